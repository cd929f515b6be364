//! What a document says of the source: which it was, which sensor, and what became of the lines of
//! a CSV file.

use std::collections::BTreeMap;

use serde::Serialize;
use vn100_analysis::{CsvFacts, Snapshot, SourceFacts};

use super::recording::RecordingDocument;

#[derive(Debug, Serialize)]
pub(crate) struct SourceDocument {
    kind: Option<&'static str>,
    name: String,
    message: Option<String>,
    compensated: Option<bool>,
    device: Option<Device>,
    recorded: Option<RecordingDocument>,
    meta: Option<BTreeMap<String, String>>,
    error: Option<String>,
    csv: Option<Csv>,
}

impl SourceDocument {
    /// What is known of it so far.
    pub(crate) fn new(facts: &SourceFacts, snapshot: &Snapshot) -> Self {
        Self {
            kind: facts.kind,
            name: facts.name.clone(),
            message: snapshot.layout.as_ref().map(|layout| layout.message.to_string()),
            compensated: snapshot.layout.as_ref().map(|layout| layout.compensated),
            device: Device::new(&snapshot.registers),
            recorded: facts.recording.as_ref().map(RecordingDocument::new),
            meta: facts.meta.clone(),
            error: facts.error.clone(),
            csv: facts.csv.as_ref().map(csv),
        }
    }
}

/// The sensor, as far as it was asked within the stream.
#[derive(Debug, Serialize)]
struct Device {
    model: Option<String>,
    hardware_revision: Option<String>,
    serial_number: Option<String>,
    firmware: Option<String>,
    /// Every register it told, by number, as printed.
    registers: BTreeMap<u8, String>,
}

impl Device {
    fn new(registers: &BTreeMap<u8, String>) -> Option<Self> {
        let register = |number| registers.get(&number).cloned();
        (!registers.is_empty()).then(|| Self {
            model: register(1),
            hardware_revision: register(2),
            serial_number: register(3),
            firmware: register(4),
            registers: registers.clone(),
        })
    }
}

/// The lines of a CSV file: `lines = rows + skipped_lines + all odd`.
#[derive(Debug, Serialize)]
struct Csv {
    lines: u64,
    rows: u64,
    skipped_lines: u64,
    odd: Vec<Odd>,
    ignored_columns: Vec<String>,
    rounded: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Odd {
    reason: String,
    count: u64,
    first_line: u64,
    first_text: String,
}

fn csv(facts: &CsvFacts) -> Csv {
    let odd = facts.rejected.iter().map(|rejected| Odd {
        reason: rejected.reason.clone(),
        count: rejected.count,
        first_line: rejected.first_line,
        first_text: rejected.first_text.clone(),
    });
    Csv {
        lines: facts.lines,
        rows: facts.rows,
        skipped_lines: facts.skipped_lines,
        odd: odd.collect(),
        ignored_columns: facts.ignored_columns.clone(),
        rounded: facts.rounded.clone(),
    }
}
