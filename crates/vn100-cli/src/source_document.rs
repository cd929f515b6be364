//! What a document says of the source: which it was, which sensor, and what became of the lines of
//! a CSV file.

use std::collections::BTreeMap;

use serde::Serialize;
use vn100_analysis::Snapshot;
use vn100_capture::{CsvReport, Recorded};

use crate::recorded::RecordedDocument;

/// Where the samples came from, as far as the document names it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Origin {
    /// File name without its folder, `-` for standard input.
    pub(crate) name: String,
    /// The form of the source; `None` while it could not be told.
    pub(crate) kind: Option<&'static str>,
    /// Why reading did not begin, or ended early.
    pub(crate) error: Option<String>,
    /// What became of the lines of a CSV file.
    pub(crate) csv: Option<CsvReport>,
    /// What a recording says of itself.
    pub(crate) recorded: Option<Recorded>,
    /// The conditions of the measurement.
    pub(crate) meta: Option<BTreeMap<String, String>>,
}

#[derive(Debug, Serialize)]
pub(crate) struct SourceDocument {
    kind: Option<&'static str>,
    name: String,
    message: Option<String>,
    compensated: Option<bool>,
    device: Option<Device>,
    recorded: Option<RecordedDocument>,
    meta: Option<BTreeMap<String, String>>,
    error: Option<String>,
    csv: Option<Csv>,
}

impl SourceDocument {
    /// What is known of it so far.
    pub(crate) fn new(origin: &Origin, snapshot: &Snapshot) -> Self {
        Self {
            kind: origin.kind,
            name: origin.name.clone(),
            message: snapshot.layout.as_ref().map(|layout| layout.message.to_string()),
            compensated: snapshot.layout.as_ref().map(|layout| layout.compensated),
            device: Device::new(&snapshot.registers),
            recorded: origin.recorded.as_ref().map(RecordedDocument::new),
            meta: origin.meta.clone(),
            error: origin.error.clone(),
            csv: origin.csv.clone().map(csv),
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

fn csv(report: CsvReport) -> Csv {
    let odd = report.odd.into_iter().map(|odd| Odd {
        reason: odd.reason,
        count: odd.count,
        first_line: odd.first_line,
        first_text: odd.first_text,
    });
    Csv {
        lines: report.lines,
        rows: report.rows,
        skipped_lines: report.skipped_lines,
        odd: odd.collect(),
        ignored_columns: report.ignored_columns,
        rounded: report.rounded,
    }
}
