//! The beginning of a page: which sensor and record, how far it can be trusted, and the noise
//! parameters in one table for each sensor.

use crate::{
    numbers::{NOTHING, duration, grouped, with_powers},
    summary::{AXES, AspectStatus, ParameterRow, SensorTable, Summary, VerdictWord, rate_text},
    units::pretty_unit,
};
use maud::{Markup, html};
use vn100_analysis::{Severity, SourceResult};

use crate::html::caption::Captions;

/// Digits of a checksum that name a file beyond doubt for people.
const SHORT_SHA256: usize = 12;

/// Names and values side by side; what is not known is not there.
pub(crate) fn rows<'a>(rows: impl IntoIterator<Item = (&'a str, Option<String>)>) -> Markup {
    html! {
        dl.identity { @for (name, value) in rows { @if let Some(value) = value { div { dt { (name) } dd { (value) } } } } }
    }
}

/// What was measured, with what, when and by whom.
pub(crate) fn identity(record: &SourceResult) -> Markup {
    let (source, timing) = (&record.source, &record.timing);
    let device = source.device.clone().unwrap_or_default();
    let meta = |name: &str| source.meta.as_ref().and_then(|meta| meta.get(name)).cloned();
    rows([
        ("Sensor", device.model),
        ("Serial number", device.serial_number),
        ("Firmware", device.firmware),
        ("Source", Some(source.name.clone())),
        ("Stream", source.stream.clone()),
        ("Message", source.message.clone()),
        ("Sample rate", Some(rate_text(timing))),
        ("Length", Some(format!("{}, {} samples", duration(timing.duration_s), grouped(timing.samples)))),
        ("Start", source.recording.as_ref().and_then(|recording| recording.started())),
        ("Place", meta("place")),
        ("Operator", meta("operator")),
        (
            "SHA-256",
            source.file.as_ref().map(|file| format!("{}…", &file.sha256[..SHORT_SHA256.min(file.sha256.len())])),
        ),
    ])
}

/// How far the record can be trusted.
pub(crate) fn statuses(summary: &Summary) -> Markup {
    html! {
        ul.statuses { @for status in &summary.statuses { (status_line(status)) } }
        @if summary.sensors.is_empty() && !summary.statistics.is_empty() {
            p.problem { b { "No noise figures are given." } " The reason is given above." }
        }
    }
}

fn status_line(status: &AspectStatus) -> Markup {
    let class = severity_class(status.severity);
    html! {
        li {
            span.aspect { (status.aspect) } " "
            b class={ "badge " (class) } { (status.word.word()) } " "
            span {
                @for (place, (text, notes)) in status.findings.iter().enumerate() {
                    @if place > 0 { "; " } (text) (numbers_of(notes))
                }
            }
        }
    }
}

/// The numbers of the notes in these places.
fn numbers_of(notes: &[usize]) -> Markup {
    html! { @for place in notes { sup { "[" (place + 1) "]" } } }
}

pub(crate) const fn severity_class(severity: Option<Severity>) -> &'static str {
    match severity {
        Some(Severity::Problem) => "problem",
        Some(Severity::Caution) => "caution",
        Some(Severity::Note) => "note",
        None => "fine",
    }
}

fn verdict_class(verdict: &VerdictWord) -> &'static str {
    match verdict.word.split(' ').next() {
        _ if verdict.is_failed => "problem",
        Some("pass") => "fine",
        _ => "note",
    }
}

/// A cell of the summary as the page writes numbers: `≤ 7.2e-3` as `≤ 7.2·10⁻³`.
fn as_written(cell: &str) -> String {
    if cell == "-" {
        return NOTHING.into();
    }
    with_powers(cell).replace('%', " %")
}

/// One table for each sensor: values, intervals, data sheet, verdict.
pub(crate) fn parameters(summary: &Summary, captions: &Captions) -> Markup {
    html! {
        @for table in &summary.sensors {
            div.scroll {
                table.glance {
                    (captions.table(&format!("{}: noise parameters", table.title)))
                    thead {
                        tr {
                            th scope="col" { "parameter" } th scope="col" { "unit" }
                            @for axis in &table.axes { th scope="col" { (axis) } }
                            @if table.has_datasheet { th scope="col" { "data sheet" (numbers_of(&table.notes)) } th scope="col" { "verdict" } }
                        }
                    }
                    tbody { @for row in &table.rows { (parameter(row, table)) } }
                }
            }
        }
        @if !summary.notes.is_empty() {
            ol.notes { @for note in &summary.notes { li { (with_code(note)) } } }
        }
    }
}

fn parameter(row: &ParameterRow, table: &SensorTable) -> Markup {
    let axes = table.axes.len().min(AXES);
    html! {
        tr.more[row.is_detail] {
            th scope="row" { (row.label) }
            td.unit { (pretty_unit(row.unit)) }
            @if let ([text], true) = (&row.cells[..], axes > 1) {
                td.all colspan=(axes) { (text) }
            } @else {
                @for place in 0..axes { td { (row.cells.get(place).map_or_else(String::new, |cell| as_written(cell))) } }
            }
            @if table.has_datasheet {
                @if let Some((figure, verdict)) = &row.figure {
                    td { (figure) }
                    td { b class={ "badge " (verdict_class(verdict)) } { (verdict.word) } }
                } @else {
                    td {} td {}
                }
            }
        }
    }
}

/// The text with what stands between backticks as code.
pub(crate) fn with_code(text: &str) -> Markup {
    html! {
        @for (place, part) in text.split('`').enumerate() {
            @if place % 2 == 1 { code { (part) } } @else { (with_whole_units(part)) }
        }
    }
}

/// The text without line breaks within units such as °/√h, nor before them.
pub(crate) fn with_whole_units(text: &str) -> Markup {
    let text = text.replace(" °", "\u{a0}°");
    html! {
        @for (place, word) in text.split(' ').enumerate() {
            @if place > 0 { " " }
            @if word.contains("/√") { span.whole { (word) } } @else { (word) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_summary_are_written_as_those_of_the_page() {
        for (cell, written) in [
            ("≤ 7.2e-3", "≤ 7.2·10⁻³"),
            ("≤ 1.2", "≤ 1.2"),
            ("1.2e+12", "1.2·10¹²"),
            ("0.347", "0.347"),
            ("-", NOTHING),
            ("no fit", "no fit"),
            ("0.35 ±2.4%", "0.35 ±2.4 %"),
        ] {
            assert_eq!(as_written(cell), written);
        }
    }
}
