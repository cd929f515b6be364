//! The page: one HTML file that needs nothing else.

mod facts;
mod figures;
mod parameters;
mod several;
mod statistics;
mod summary;

use std::io::{self, Write};

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use vn100_analysis::RemedyWords;

use crate::{
    export::kalibr::KalibrYaml,
    figure::Figures,
    findings::Findings,
    measured::{Record, record_letter},
    numbers::{duration, grouped, trimmed},
    printable::steers_terminal,
    words::conclusions,
};

/// The Earth's turning, in rad/s (IERS Conventions, 2010).
pub const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

const STYLE: &str = include_str!("page/style.css");
const SCRIPT: &str = include_str!("page/script.js");

/// The content of a page besides the results.
#[derive(Debug, Clone, Copy)]
pub struct PageOptions<'a> {
    /// Two-sided level of the intervals of a comparison.
    pub confidence: f64,
    /// What was asked for, as a user would ask for it again.
    pub asked: &'a str,
    /// How what the user can do is called.
    pub words: RemedyWords,
    /// What makes the page.
    pub program: Program<'a>,
}

/// A program by its name.
#[derive(Debug, Clone, Copy)]
pub struct Program<'a> {
    /// Name and version, such as `vn100 1.0.0`.
    pub name: &'a str,
    /// The commit it was built from; `None` where that is not known.
    pub commit: Option<&'a str>,
}

/// Writes the page of one capture, or of several. `figures` are those of the records, in their
/// order; `together` those of all of them, of which one record alone has none.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write_page(
    out: &mut impl Write,
    records: &[Record<'_>],
    figures: &[Figures],
    together: &Figures,
    options: PageOptions<'_>,
) -> io::Result<()> {
    let title = match records {
        [record] => format!("Noise report: {}", record.measured.facts.name),
        _ => format!("Noise report of {} captures", records.len()),
    };
    let is_empty = |record: &Record<'_>| record.measured.snapshot.timing.samples == 0;
    let readings = figures::readings(figures.iter().chain([together]).flat_map(Figures::all))?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { h1 { (title) } }
                main {
                    @if let [record] = records {
                        @if let Some(figures) = figures.first() { (one(record, figures, options, "")) }
                    } @else {
                        (several::several(records, together, options))
                        @for (index, (record, figures)) in records.iter().zip(figures).enumerate() {
                            article {
                                h2.record { (record_letter(index)) ": " (record.measured.facts.name) }
                                (one(record, figures, options, &format!("{}-", record_letter(index))))
                            }
                        }
                    }
                    @if !records.iter().all(is_empty) { section id="references" { h2 { "References" } ol.references { @for reference in REFERENCES { li { (reference) } } } } }
                }
                footer { p { "Made by " (options.program.name) ", commit " (options.program.commit.unwrap_or(facts::NOT_RECORDED)) ", from the capture alone: the same capture and options give the same page, byte by byte." } }
                script type="application/json" id="readings" { (PreEscaped(readings)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    // names and notes may hold what steers a terminal, is an error in HTML, or makes them look like others
    let page = page.into_string().replace(|c: char| steers_terminal(c) && !matches!(c, '\n' | '\t'), "\u{fffd}");
    out.write_all(page.as_bytes())
}

/// Everything of one record. `prefix` makes its anchors unique.
fn one(record: &Record<'_>, figures: &Figures, options: PageOptions<'_>, prefix: &str) -> Markup {
    let findings = Findings::of(record);
    let sections = [
        ("conclusions", "Conclusions"),
        ("warnings", "Warnings"),
        ("parameters", "Noise parameters"),
        ("allan", "Allan deviation"),
        ("statistics", "Means and deviations"),
        ("time", "Time plots"),
        ("histograms", "Histograms"),
        ("spectrum", "Spectrum and deviation per segment"),
        ("filters", "For filters and Kalibr"),
        ("record", "The record"),
    ];
    let section = |index: usize, content: Markup| {
        let (anchor, name) = sections[index];
        html! { section id={ (prefix) (anchor) } { h2 { (name) } (content) } }
    };
    if record.measured.snapshot.timing.samples == 0 {
        return html! {
            p.warning { (lead(record)) }
            p { "There is nothing to conclude from. What is known of the capture follows." }
            @if !record.measured.snapshot.warnings.is_empty() { (section(1, warnings(record, options.words))) }
            (section(9, facts::facts(record, options)))
        };
    }
    html! {
        p.lead { (lead(record)) }
        nav { @for (anchor, name) in sections { a href={ "#" (prefix) (anchor) } { (name) } " " } }
        (summary::summary(record, &findings))
        (section(0, answers(&findings, options.words)))
        (section(1, warnings(record, options.words)))
        (section(2, html! { (parameters::parameters(record)) (parameters::verdicts(record, options.words)) }))
        (section(3, figures::allan(record, figures)))
        (section(4, statistics::statistics(record, options.words)))
        (section(5, figures::time(figures)))
        (section(6, figures::histograms(figures)))
        (section(7, figures::spectrum(figures)))
        (section(8, filters(record)))
        (section(9, facts::facts(record, options)))
    }
}

fn lead(record: &Record<'_>) -> String {
    let snapshot = &record.measured.snapshot;
    let timing = &snapshot.timing;
    match &snapshot.layout {
        Some(layout) if timing.samples > 0 => format!(
            "{} {} of {} in {} at {} Hz.",
            grouped(timing.samples),
            if timing.samples == 1 { "sample" } else { "samples" },
            layout.message,
            duration(timing.duration_s()),
            trimmed(timing.rate_hz, 4)
        ),
        _ => record.measured.facts.error.clone().unwrap_or_else(|| "No valid sample in this capture.".into()),
    }
}

fn answers(findings: &Findings, words: RemedyWords) -> Markup {
    html! {
        div.answers {
            @for (question, sentences) in conclusions(findings, words).iter().filter(|(_, sentences)| !sentences.is_empty()) {
                div.answer {
                    h3 { (question) }
                    ul { @for sentence in sentences { li { (sentence) } } }
                }
            }
        }
    }
}

fn warnings(record: &Record<'_>, words: RemedyWords) -> Markup {
    html! {
        @if record.measured.warnings().next().is_none() { p { "None." } }
        @for warning in record.measured.warnings() {
            p.warning { b { (warning.kind.name()) } ": " (warning.text.in_words(words).trim_end_matches('.')) "." }
        }
    }
}

fn filters(record: &Record<'_>) -> Markup {
    html! {
        p {
            "A filter that uses this stream needs the densities of this stream, at this rate, as measured: dividing out what the sensor's averaging and decimation did to them would make the filter trust \
             the stream too much. Kalibr takes N and K in continuous time, in SI units [8]; it knows no bias instability."
        }
        pre { (KalibrYaml::of(record, true).text()) }
    }
}

pub(super) fn table(class: Option<&str>, columns: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll {
            table class=[class] {
                thead { tr { @for name in columns { th scope="col" { (name) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A row whose first cell names it.
pub(super) fn row(name: impl Render, cells: impl IntoIterator<Item = String>) -> Markup {
    html! { tr { th scope="row" { (name) } @for cell in cells { td { (cell) } } } }
}

const REFERENCES: [&str; 8] = [
    "D. W. Allan, \"Statistics of atomic frequency standards\", Proc. IEEE 54 (1966), 221-230.",
    "W. J. Riley, \"Handbook of Frequency Stability Analysis\", NIST Special Publication 1065 (2008).",
    "C. A. Greenhall and W. J. Riley, \"Uncertainty of stability variances based on finite differences\", 35th PTTI Meeting (2003).",
    "IEEE Std 952-1997, \"IEEE Standard Specification Format Guide and Test Procedure for Single-Axis Interferometric Fiber Optic Gyros\", annex C; IEEE Std 1293 for accelerometers.",
    "P. D. Welch, \"The use of fast Fourier transform for the estimation of power spectra\", IEEE Trans. Audio Electroacoust. 15 (1967), 70-73.",
    "A. C. Harvey, \"Forecasting, Structural Time Series Models and the Kalman Filter\" (1989): steps and warm-up.",
    "Z. A. Lomnicki, \"Tests for departure from normality in the case of linear stochastic processes\", Metrika 4 (1961), 37-62.",
    "Kalibr, \"IMU noise model\", the page of that name in the project's documentation: continuous-time densities and their units.",
];
