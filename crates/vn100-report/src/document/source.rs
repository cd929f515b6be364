//! What a document says of the source: which it was, which sensor, and what became of the lines of
//! a CSV file.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use vn100_analysis::{CsvFacts, Snapshot, SourceFacts};

use super::recording::RecordingDocument;

/// What is known of it so far.
pub(crate) fn source(facts: &SourceFacts, snapshot: &Snapshot) -> Value {
    let layout = snapshot.layout.as_ref();
    json!({
        "kind": facts.kind,
        "name": facts.name,
        "message": layout.map(|layout| layout.message.to_string()),
        "compensated": layout.map(|layout| layout.compensated),
        "device": Some(&snapshot.registers).filter(|registers| !registers.is_empty()).map(device),
        "recorded": facts.recording.as_ref().map(RecordingDocument::new),
        "meta": facts.meta,
        "error": facts.error,
        "csv": facts.csv.as_ref().map(csv),
    })
}

/// The sensor, as far as it was asked within the stream; every register it told, as printed.
fn device(registers: &BTreeMap<u8, String>) -> Value {
    json!({
        "model": registers.get(&1),
        "hardware_revision": registers.get(&2),
        "serial_number": registers.get(&3),
        "firmware": registers.get(&4),
        "registers": registers,
    })
}

/// The lines of a CSV file: `lines = rows + skipped_lines + all odd`.
fn csv(facts: &CsvFacts) -> Value {
    json!({
        "lines": facts.lines,
        "rows": facts.rows,
        "skipped_lines": facts.skipped_lines,
        "odd": facts.rejected.iter().map(|rejected| json!({
            "reason": rejected.reason,
            "count": rejected.count,
            "first_line": rejected.first_line,
            "first_text": rejected.first_text,
        })).collect::<Value>(),
        "ignored_columns": facts.ignored_columns,
        "rounded": facts.rounded,
    })
}
