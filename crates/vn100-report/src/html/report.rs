//! The report: one HTML file that needs nothing else.

use crate::{
    evaluation::is_of_vn100,
    facts::NOT_RECORDED,
    figure::{Figures, ReportFigures},
    names::{run_name, run_prefix},
};
use maud::{Markup, html};
use vn100_analysis::SourceResult;

use crate::html::{
    caption::Captions,
    lab,
    options::PageOptions,
    page::Page,
    parts::{arranged, parts},
    several,
};

/// The page of one capture or of several, with their figures.
pub fn report_page(records: &[SourceResult], figures: &ReportFigures, options: PageOptions<'_>) -> String {
    let title = match records {
        [record] => format!("Noise report: {}", record.source.name),
        _ => format!("Noise report of {} captures", records.len()),
    };
    let has_results = records.iter().any(|record| record.timing.samples > 0);
    let captions = Captions::default();
    let main = html! {
        @if let ([record], [figures]) = (records, &figures.records[..]) { (one(record, figures, options, "", &captions)) } @else {
            (several::several(records, &figures.together, options, &captions))
            @for (index, (record, figures)) in records.iter().zip(&figures.records).enumerate() {
                article {
                    h2.record { (run_name(index)) ": " (record.source.name) }
                    (one(record, figures, options, &run_prefix(index), &captions))
                }
            }
        }
        @if has_results { section id="background" { h2 { "Background" } (lab::background(options.words, records.iter().any(is_of_vn100))) } }
        div.end {
            @if has_results { section id="references" { h2 { "References" } ol.references { @for reference in REFERENCES { li { (reference) } } } } }
            footer { p { "Made by " (options.program.name) ", commit " (options.program.commit.unwrap_or(NOT_RECORDED)) ", from the capture alone: the same capture and options give the same page, byte by byte." } }
        }
    };
    Page { title: &title, style: &running_head(records), version: None, head: html! {}, main }.text()
}

/// The style of what each sheet of paper names at its foot: captures and serial numbers.
fn running_head(records: &[SourceResult]) -> String {
    let named = |record: &SourceResult| {
        let serial = record.source.device.as_ref().and_then(|device| device.serial_number.as_ref());
        let serial = serial.map_or(String::new(), |serial| format!(" (s/n {serial})"));
        format!("{}{serial}", record.source.name)
    };
    let named: Vec<String> = records.iter().map(named).collect();
    let text: String = (named.join(", ").chars())
        .map(|c| match c {
            // neither the end of the string nor that of the element
            '"' | '\\' | '<' | '>' | '&' => format!("\\{:x} ", u32::from(c)),
            c if c.is_control() => "\u{fffd}".into(),
            c => c.into(),
        })
        .collect();
    format!("@page {{ @bottom-left {{ content: \"{text}\"; }} }}\n")
}

/// Everything of one record.
fn one(
    record: &SourceResult,
    figures: &Figures,
    options: PageOptions<'_>,
    prefix: &str,
    captions: &Captions,
) -> Markup {
    let parts = parts(record, figures, options, captions, false);
    let content = |id: &str| Some(&*parts.iter().find(|part| part.id == id && !part.html.is_empty())?.html);
    let error = record.source.error.as_ref().filter(|_| record.timing.samples > 0);
    html! {
        @for text in error.into_iter().chain(&record.unmet) { p.warning.problem { (text) } }
        (arranged(content, prefix))
    }
}

const REFERENCES: [&str; 7] = [
    "D. W. Allan, \"Statistics of atomic frequency standards\", Proc. IEEE 54 (1966), 221-230.",
    "W. J. Riley, \"Handbook of Frequency Stability Analysis\", NIST Special Publication 1065 (2008).",
    "C. A. Greenhall and W. J. Riley, \"Uncertainty of stability variances based on finite differences\", 35th PTTI Meeting (2003).",
    "IEEE Std 952-1997, \"IEEE Standard Specification Format Guide and Test Procedure for Single-Axis Interferometric Fiber Optic Gyros\", annex C; IEEE Std 1293 for accelerometers.",
    "P. D. Welch, \"The use of fast Fourier transform for the estimation of power spectra\", IEEE Trans. Audio Electroacoust. 15 (1967), 70-73.",
    "A. C. Harvey, \"Forecasting, Structural Time Series Models and the Kalman Filter\" (1989): steps and warm-up.",
    "Kalibr, \"IMU noise model\", the page of that name in the project's documentation: continuous-time densities and their units.",
];
