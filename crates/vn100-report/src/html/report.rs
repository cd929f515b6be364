//! The report: one HTML file that needs nothing else.

use std::io::{self, Write};

use crate::warnings::{details, headline};
use crate::{facts::NOT_RECORDED, figure::Figures, run_name, run_prefix, summary::Summary};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use vn100_analysis::{NoiseResult, RemedyWords, SENSORS, SourceResult, noise::Sensor};

use crate::html::{
    caption::Captions,
    elements::{FIGURES_SCRIPT, STYLE, text_of},
    facts, figures, filters, glance, lab,
    options::PageOptions,
    parameters, several, statistics,
};

const SCRIPT: &str = include_str!("../../assets/script.js");

/// Writes the page of one capture, or of several. `figures` are those of the records, in the same
/// order; `together` are the figures of all records together, which are empty for a single one.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write_page(
    out: &mut impl Write,
    records: &[SourceResult],
    figures: &[Figures],
    together: &Figures,
    options: PageOptions<'_>,
) -> io::Result<()> {
    let title = match records {
        [record] => format!("Noise report: {}", record.source.name),
        _ => format!("Noise report of {} captures", records.len()),
    };
    let is_empty = |record: &SourceResult| record.timing.samples == 0;
    let readings = figures::readings(figures.iter().chain([together]).flat_map(Figures::all))?;
    let captions = Captions::default();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(running_head(records))) }
            }
            body {
                header { h1 { (title) } }
                main {
                    @if let [record] = records {
                        @if let Some(figures) = figures.first() { (one(record, figures, options, "", &captions)) }
                    } @else {
                        (several::several(records, together, options, &captions))
                        @for (index, (record, figures)) in records.iter().zip(figures).enumerate() {
                            article {
                                h2.record { (run_name(index)) ": " (record.source.name) }
                                (one(record, figures, options, &run_prefix(index), &captions))
                            }
                        }
                    }
                    @if !records.iter().all(is_empty) { section id="background" { h2 { "Background" } (lab::background(options.words)) } }
                    div.end {
                        @if !records.iter().all(is_empty) { section id="references" { h2 { "References" } ol.references { @for reference in REFERENCES { li { (reference) } } } } }
                        footer { p { "Made by " (options.program.name) ", commit " (options.program.commit.unwrap_or(NOT_RECORDED)) ", from the capture alone: the same capture and options give the same page, byte by byte." } }
                    }
                }
                script type="application/json" id="readings" { (PreEscaped(readings)) }
                script { (PreEscaped(FIGURES_SCRIPT)) (PreEscaped(SCRIPT)) }
            }
        }
    };
    out.write_all(text_of(page).as_bytes())
}

/// The style of what each sheet of paper names at its foot.
fn running_head(records: &[SourceResult]) -> String {
    let text: String = running(records)
        .chars()
        .map(|c| match c {
            // neither the end of the string nor that of the element
            '"' | '\\' | '<' | '>' | '&' => format!("\\{:x} ", u32::from(c)),
            c if c.is_control() => "\u{fffd}".into(),
            c => c.into(),
        })
        .collect();
    format!("@page {{ @bottom-left {{ content: \"{text}\"; }} }}\n")
}

/// Captures and serial numbers.
fn running(records: &[SourceResult]) -> String {
    let of = |record: &SourceResult| {
        let serial = record.source.device.as_ref().and_then(|device| device.serial_number.as_ref());
        let serial = serial.map_or(String::new(), |serial| format!(" (s/n {serial})"));
        format!("{}{serial}", record.source.name)
    };
    records.iter().map(of).collect::<Vec<_>>().join(", ")
}

/// Everything of one record. `prefix` makes its anchors unique.
fn one(
    record: &SourceResult,
    figures: &Figures,
    options: PageOptions<'_>,
    prefix: &str,
    captions: &Captions,
) -> Markup {
    let section = |anchor: &str, name: &str, content: Markup| {
        html! { section id={ (prefix) (anchor) } { h2 { (name) } (content) } }
    };
    if record.timing.samples == 0 {
        return html! {
            p.warning.problem { (record.source.error.as_deref().unwrap_or("No valid sample in this capture.")) }
            p { "There are no results. What is known of the capture follows." }
            @if !record.warnings.is_empty() { (section("cautions", "Cautions", warnings(record, options.words))) }
            (section("record", "Record and method", facts::facts(record, options, captions)))
        };
    }
    let summary = Summary::new(record, options.words);
    let sections: [(&str, &str, Markup); 12] = [
        ("allan", "Allan deviation", figures::together(record, figures, captions)),
        ("cautions", "Cautions", warnings(record, options.words)),
        (
            "parameters",
            "Noise parameters",
            html! {
                (glance::parameters(&summary, captions))
                details { summary { "All units, fit quality and graphical readings" } (parameters::parameters(record, captions)) }
            },
        ),
        ("datasheet", "Comparison with the data sheet", parameters::verdicts(record, options.words, captions)),
        ("axes", "Allan deviation of each axis", figures::axes(record, figures, captions)),
        ("lab", "Lab report", lab::lab(record, figures, captions)),
        ("statistics", "Descriptive statistics", statistics::statistics(record, figures, options.words, captions)),
        ("drift", "Drift while coasting", filters::drift(record, figures, captions)),
        ("spectrum", "Spectrum and deviation per segment", figures::spectrum(figures, captions)),
        ("advice", "What to do, and what was not tested", advice(record, &summary)),
        ("filters", "Values for filters and simulators", filters::filters(record, options.span_s)),
        ("record", "Record and method", facts::facts(record, options, captions)),
    ];
    html! {
        (glance::identity(record))
        @if let Some(error) = &record.source.error { p.warning.problem { (error) } }
        (glance::verdicts(&summary))
        nav aria-label={ "Sections" @if !prefix.is_empty() { " of " (prefix.trim_end_matches('-')) } } {
            @for (anchor, name, _) in &sections { a href={ "#" (prefix) (anchor) } { (name) } " " }
        }
        @for (anchor, name, content) in sections { (section(anchor, name, content)) }
    }
}

/// The notes of the summary, and the limits of any record at rest.
fn advice(record: &SourceResult, summary: &Summary) -> Markup {
    let inertial = || SENSORS.iter().filter(|(_, sensor)| *sensor != Sensor::Magnetometer);
    let mut axes = inertial().flat_map(|(quantity, _)| record.of(*quantity)).filter_map(|axis| axis.noise.as_ref());
    let has_coefficient = |noise: &NoiseResult| noise.temperature.as_ref().is_some_and(|found| found.reason.is_none());
    let temperature = if axes.all(has_coefficient) { "" } else { "temperature, " };
    html! {
        @if !summary.notes.is_empty() { ul { @for note in &summary.notes { li { (glance::with_code(note)) } } } }
        p {
            "One record at rest does not show bias from turn-on to turn-on, scale factor, misalignment, or the sensitivity to " (temperature)
            "supply and acceleration. Slow motion that looks like noise is not detected. "
            @if record.source.device.is_none() {
                "The record does not hold the registers of the sensor: its averaging window, calibration and filter modes are unknown. "
            }
            @if record.source.meta.is_none() { "Place, mounting, ambient temperature and supply were not recorded." }
        }
    }
}

pub(crate) fn warnings(record: &SourceResult, words: RemedyWords) -> Markup {
    html! {
        @if record.warnings.is_empty() { p { "None." } }
        @for warning in &record.warnings {
            @let class = glance::severity_class(Some(warning.severity));
            details class={ "warning " (class) } {
                summary { b class={ "badge " (class) } { (warning.severity.name()) } " " (headline(warning)) " " code { (warning.kind.name()) } }
                p { (glance::with_code(&details(warning, words))) }
            }
        }
    }
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
