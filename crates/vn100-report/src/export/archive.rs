//! The rows of an archive: one for each recording and channel, as a line of JSON or of a table.

use serde_json::{Value, json};
use std::collections::BTreeSet;
use vn100_analysis::noise::Term;
use vn100_analysis::{ChannelResult, Completion, SourceResult};

use super::tables::quoted;
use crate::{codes::name_of, printable::json_line};

/// A file of an archive, as it was when it was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArchivedFile {
    /// Its path.
    pub path: String,
    /// Its size, with that of the files that belong to it.
    pub bytes: u64,
    /// When it was last changed, in nanoseconds since 1970-01-01 UTC.
    pub modified_ns: i64,
    /// The options of the measurement.
    pub options: String,
}

/// A row of an archive: a channel of a recording, or a recording without channels. SI units,
/// magnetic field in gauss.
#[derive(Debug, Clone)]
pub struct ArchiveRow {
    /// The columns, each with its value.
    cells: Vec<(&'static str, Value)>,
}

impl ArchiveRow {
    /// The rows of all recordings of a file, each with their number in the column `rows`.
    pub fn of_file(file: &ArchivedFile, recordings: &[SourceResult]) -> Vec<Self> {
        let channels = |result: &SourceResult| result.channels.len().max(1);
        let count = recordings.iter().map(channels).sum();
        let of_channel = |result, channel| Self { cells: cells(file, count, Some(result), channel) };
        let rows = recordings.iter().flat_map(|result| match &result.channels[..] {
            [] => vec![of_channel(result, None)],
            channels => channels.iter().map(|channel| of_channel(result, Some(channel))).collect(),
        });
        rows.collect()
    }

    /// The row as a line of JSON: an object with every column.
    pub fn json_line(&self) -> String {
        let fields: Vec<String> = self.cells.iter().map(|(column, cell)| format!("\"{column}\":{cell}")).collect();
        json_line(&format!("{{{}}}", fields.join(",")))
    }

    /// The row as a line of a table, under [`table_header`](Self::table_header).
    pub fn table_line(&self) -> String {
        // one line
        let cell = |(_, cell): &(_, Value)| quoted(&text(cell).replace(['\n', '\r'], " "));
        self.cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n"
    }

    /// The first line of a table.
    pub fn table_header() -> String {
        columns().join(",") + "\n"
    }

    /// The file, the number of its rows and its outcome by a line; `None` for one that is no row.
    pub fn file_of_line(line: &str) -> Option<(ArchivedFile, usize, Completion)> {
        let cells: Vec<String> = match serde_json::from_str::<Value>(line) {
            Ok(Value::Object(row)) => {
                columns().into_iter().map(|column| row.get(column).map_or_else(String::new, text)).collect()
            }
            _ => table_cells(line)?,
        };
        let [path, bytes, modified_ns, options, rows, completion, ..] = &cells[..] else { return None };
        let file = ArchivedFile {
            path: path.clone(),
            bytes: bytes.parse().ok()?,
            modified_ns: modified_ns.parse().ok()?,
            options: options.clone(),
        };
        let completion = Completion::ALL.into_iter().find(|of| name_of(of) == *completion)?;
        (cells.len() == columns().len()).then_some((file, rows.parse().ok()?, completion))
    }
}

/// The columns of every row, in their order.
fn columns() -> Vec<&'static str> {
    let file = ArchivedFile { path: String::new(), bytes: 0, modified_ns: 0, options: String::new() };
    cells(&file, 0, None, None).into_iter().map(|(column, _)| column).collect()
}

/// Whether a table with this first line, or a line of JSON that begins like it, is of an archive.
pub(super) fn is_first_line(line: &str) -> bool {
    line == ArchiveRow::table_header().trim_end()
        || line.starts_with("{\"file\":") && line.contains(",\"modified_ns\":")
}

/// The columns with their values, of a file without a recording only those of the file.
fn cells(
    file: &ArchivedFile,
    rows: usize,
    result: Option<&SourceResult>,
    channel: Option<&ChannelResult>,
) -> Vec<(&'static str, Value)> {
    let (source, timing) = (result.map(|result| &result.source), result.map(|result| &result.timing));
    let device = source.and_then(|source| source.device.as_ref());
    let recording = source.and_then(|source| source.recording.as_ref());
    let statistics = channel.map(|channel| &channel.statistics);
    let mut cells = vec![
        ("file", json!(file.path)),
        ("bytes", json!(file.bytes)),
        ("modified_ns", json!(file.modified_ns)),
        ("options", json!(file.options)),
        ("rows", json!(rows)),
        ("completion", json!(result.map(|result| result.completion))),
        ("name", json!(source.map(|source| &source.name))),
        ("serial", json!(device.map(|device| &device.serial_number))),
        ("model", json!(device.map(|device| &device.model))),
        ("message", json!(source.map(|source| &source.message))),
        (
            "started_ns",
            json!(recording.and_then(|recording| recording.started_ns.filter(|_| recording.started().is_some()))),
        ),
        ("rate_hz", json!(timing.and_then(|timing| timing.rate_hz))),
        ("duration_s", json!(timing.map(|timing| timing.duration_s))),
        ("samples", json!(timing.map(|timing| timing.samples))),
        ("missing", json!(timing.and_then(|timing| timing.missing))),
        ("channel", json!(channel.map(|channel| &channel.name))),
        ("unit", json!(channel.map(|channel| &channel.unit))),
        ("mean", json!(statistics.and_then(|statistics| statistics.mean))),
        ("std", json!(statistics.and_then(|statistics| statistics.std))),
        ("min", json!(statistics.and_then(|statistics| statistics.min))),
        ("max", json!(statistics.and_then(|statistics| statistics.max))),
    ];
    for (term, columns) in PARAMETERS {
        let noise = channel.and_then(|channel| channel.noise.as_ref());
        let found = noise.and_then(|noise| noise.parameter(term));
        let values = [
            json!(found.map(|found| found.status)),
            json!(found.map(|found| found.value)),
            json!(found.map(|found| found.lower)),
            json!(found.map(|found| found.upper)),
        ];
        cells.extend(columns.into_iter().zip(values));
    }
    let judged = channel.map_or(&[][..], ChannelResult::verdicts);
    let verdicts = judged.iter().filter_map(|judged| {
        let (figure, verdict) = (&judged.figure, name_of(judged.verdict?));
        Some(format!("{} {} {verdict}", name_of(figure.term), figure.claim.name()))
    });
    cells.push(("verdicts", joined(verdicts)));
    let mut named = BTreeSet::new();
    let kinds = result.iter().flat_map(|result| &result.warnings).map(|warning| warning.kind.name());
    cells.push(("warnings", joined(kinds.filter(|kind| named.insert(*kind)).map(str::to_owned))));
    cells.push(("error", json!(source.and_then(|source| source.error.as_ref()))));
    cells
}

/// The columns of status, value and interval of each parameter.
const PARAMETERS: [(Term, [&str; 4]); 3] = [
    (Term::White, ["white_status", "white", "white_lower", "white_upper"]),
    (
        Term::BiasInstability,
        ["bias_instability_status", "bias_instability", "bias_instability_lower", "bias_instability_upper"],
    ),
    (
        Term::RateRandomWalk,
        ["rate_random_walk_status", "rate_random_walk", "rate_random_walk_lower", "rate_random_walk_upper"],
    ),
];

/// One text; no value of none.
fn joined(texts: impl Iterator<Item = String>) -> Value {
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() { Value::Null } else { json!(texts.join("; ")) }
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The cells of a line of a table; `None` if a quoted cell does not end.
fn table_cells(line: &str) -> Option<Vec<String>> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut letters = line.trim_end_matches(['\n', '\r']).chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if is_quoted && letters.peek() == Some(&'"') => cell.extend(letters.next()),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            other => cell.push(other),
        }
    }
    cells.push(cell);
    (!is_quoted).then_some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::fixture::{facts, nothing, result};

    #[test]
    fn a_row_names_its_file_in_both_forms() {
        let file = ArchivedFile {
            path: "in/a \"b\", c.bin".into(),
            bytes: 7,
            modified_ns: 1_700_000_000_123_456_789,
            options: "b1946ac92492d234".into(),
        };
        let mut unread = result(facts("a"), nothing());
        unread.note_failure("not read,\nas \"it\" is".into());
        let row = ArchiveRow::of_file(&file, &[unread]).remove(0);
        for line in [row.json_line(), row.table_line()] {
            assert_eq!(ArchiveRow::file_of_line(&line), Some((file.clone(), 1, Completion::Failed)), "{line}");
            assert_eq!(line.matches('\n').count(), 1, "{line}");
            assert_eq!(ArchiveRow::file_of_line(&line[..line.len() - 3]), None, "a line that was cut");
        }
        assert_eq!(ArchiveRow::file_of_line(&ArchiveRow::table_header()), None);
        assert!(is_first_line(row.json_line().trim_end()) && is_first_line(ArchiveRow::table_header().trim_end()));
    }
}
