//! What a document says of the source: which it was, which sensor, the metadata of its recording,
//! and how many lines of a CSV file were used.

use std::{
    collections::BTreeMap,
    time::{Duration, SystemTime},
};

use serde::Serialize;
use vn100_analysis::protocol::stream::{AbsentValues, BagReport, CsvReport, LeftOutColumn, StampSource, UnreadNumbers};
use vn100_analysis::{RecordingFacts, Snapshot, SourceFacts};

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
    /// The topic of a bag, or the group of columns of a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    stream: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bag: Option<Bag>,
    /// Places that the user marked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    marks: Vec<MarkDocument>,
}

#[derive(Debug, Serialize)]
struct MarkDocument {
    at_s: f64,
    text: String,
}

impl SourceDocument {
    /// What is known of it so far.
    pub(crate) fn new(facts: &SourceFacts, snapshot: &Snapshot) -> Self {
        Self {
            kind: facts.kind,
            name: facts.name.clone(),
            message: snapshot.layout.as_ref().map(|layout| layout.message.to_string()),
            compensated: snapshot.layout.as_ref().and_then(|layout| layout.compensated),
            device: Device::new(&snapshot.registers),
            recorded: facts.recording.as_ref().map(RecordingDocument::new),
            meta: facts.meta.clone(),
            error: facts.error.clone(),
            csv: facts.csv.as_ref().map(csv),
            stream: facts.stream.clone(),
            bag: facts.bag.as_ref().map(Bag::new),
            marks: snapshot
                .marks
                .iter()
                .map(|mark| MarkDocument { at_s: mark.at_s, text: mark.text.clone() })
                .collect(),
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
    /// Every register that was read, by number, as printed.
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

/// The lines of a CSV file: `lines` are `rows`, `skipped_lines`, every odd count, and the rows of
/// other streams.
#[derive(Debug, Serialize)]
struct Csv {
    lines: u64,
    rows: u64,
    skipped_lines: u64,
    #[serde(rename = "odd")]
    rejected: Vec<RejectedDocument>,
    #[serde(skip_serializing_if = "Option::is_none")]
    other_stream_rows: Option<u64>,
    times: Option<String>,
    ignored_columns: Vec<String>,
    left_out: Vec<LeftOutDocument>,
    rounded: Vec<String>,
    absent: Vec<AbsentDocument>,
}

/// A column that is not read although its name says what it holds.
#[derive(Debug, Serialize)]
struct LeftOutDocument {
    column: String,
    reason: String,
}

impl LeftOutDocument {
    fn new(column: &LeftOutColumn) -> Self {
        Self { column: column.name.clone(), reason: column.reason.to_string() }
    }
}

/// How often rows lack a channel.
#[derive(Debug, Serialize)]
struct AbsentDocument {
    channel: String,
    count: u64,
    empty: u64,
    not_a_number: u64,
    out_of_range: u64,
    first_line: u64,
}

#[derive(Debug, Serialize)]
struct RejectedDocument {
    reason: String,
    count: u64,
    first_line: u64,
    first_text: String,
}

fn csv(facts: &CsvReport) -> Csv {
    let rejected = facts.rejected.iter().map(|row| RejectedDocument {
        reason: row.reason.to_string(),
        count: row.count,
        first_line: row.first_line,
        first_text: row.first_text.clone(),
    });
    let rejected = rejected.collect();
    Csv {
        lines: facts.lines,
        rows: facts.rows,
        skipped_lines: facts.skipped_lines,
        rejected,
        other_stream_rows: facts.other_stream_rows,
        times: facts.times.clone(),
        ignored_columns: facts.ignored_columns.clone(),
        left_out: facts.left_out.iter().map(LeftOutDocument::new).collect(),
        rounded: facts.rounded.clone(),
        absent: facts.absent.iter().map(AbsentDocument::new).collect(),
    }
}

impl AbsentDocument {
    fn new(absent: &AbsentValues) -> Self {
        Self {
            channel: absent.channel.clone(),
            count: absent.total(),
            empty: absent.empty,
            not_a_number: absent.not_a_number,
            out_of_range: absent.out_of_range,
            first_line: absent.first_line,
        }
    }
}

/// The messages of a topic of a bag: `messages` are `used` and the two that follow it.
#[derive(Debug, Serialize)]
struct Bag {
    topic: String,
    #[serde(rename = "type")]
    type_name: String,
    messages: u64,
    used: u64,
    without_sample: u64,
    unreadable: u64,
    absent: Vec<AbsentDocument>,
    unread: Vec<UnreadDocument>,
    reordered: u64,
    late: u64,
    other_messages: u64,
    stamps: &'static str,
    stamp_field: Option<String>,
    unpacked_bytes: u64,
}

/// Numbers that are zero in the first `zero_messages`, and so not read.
#[derive(Debug, Serialize)]
struct UnreadDocument {
    path: String,
    zero_messages: usize,
    nonzero_messages: u64,
}

impl UnreadDocument {
    fn new(unread: &UnreadNumbers) -> Self {
        let UnreadNumbers { path, zero_messages, nonzero_messages } = unread.clone();
        Self { path, zero_messages, nonzero_messages }
    }
}

impl Bag {
    fn new(report: &BagReport) -> Self {
        let stamp_field = match &report.stamps {
            StampSource::Field(path) => Some(path.clone()),
            _ => None,
        };
        Self {
            topic: report.topic.clone(),
            type_name: report.type_name.clone(),
            messages: report.messages,
            used: report.used,
            without_sample: report.without_sample,
            unreadable: report.unreadable,
            absent: report.absent.iter().map(AbsentDocument::new).collect(),
            unread: report.unread.iter().map(UnreadDocument::new).collect(),
            reordered: report.reordered,
            late: report.late,
            other_messages: report.other_messages,
            stamps: report.stamps.code(),
            stamp_field,
            unpacked_bytes: report.unpacked_bytes,
        }
    }
}

/// A recording, with its times in UTC.
#[derive(Debug, Serialize)]
pub struct RecordingDocument {
    /// Name and version of the program that recorded; `None` if the recording does not say.
    pub program: Option<String>,
    /// When the recording began, in UTC to the millisecond (RFC 3339); `None` if it does not
    /// say, or by a clock that was not set.
    pub started: Option<String>,
    /// When the recording ended, in the same form; also `None` before it was read to its end.
    pub ended: Option<String>,
    complete: Option<bool>,
    /// Why the recording ended, as it says itself; `None` before it was read to its end.
    pub end_reason: Option<String>,
}

impl RecordingDocument {
    /// The facts so far; how the recording ended is among them once it was read to its end.
    #[must_use]
    pub fn new(recording: &RecordingFacts) -> Self {
        let end = recording.end.as_ref();
        Self {
            program: recording.program.clone(),
            started: recording.started_ns.and_then(utc),
            ended: end.and_then(|end| end.ended_ns).and_then(utc),
            complete: end.map(|end| end.complete),
            end_reason: end.and_then(|end| end.reason.clone()),
        }
    }

    /// The facts in words.
    #[must_use]
    pub fn text(&self) -> String {
        let unknown = || "an unknown time".to_owned();
        let when = match (&self.started, &self.ended) {
            (None, None) => format!("at {}", unknown()),
            (started, ended) => {
                let shown = |time: &Option<String>| time.clone().unwrap_or_else(unknown);
                format!("{} to {}", shown(started), shown(ended))
            }
        };
        let how = match (&self.end_reason, self.complete) {
            (Some(reason), Some(true)) => format!(", ended: {reason}"),
            (_, Some(false)) => ", cut there: the file has no end".to_owned(),
            _ => String::new(),
        };
        format!("{when}{how}")
    }
}

/// To the millisecond, as the clock of a host is not better than that; `None` for a time before
/// 1971: it is that of a clock that was not set, or of no clock.
pub(crate) fn utc(at_ns: i64) -> Option<String> {
    const YEAR: Duration = Duration::from_secs(365 * 24 * 3600);
    let since_1970 = Duration::from_nanos(at_ns.try_into().ok()?);
    (since_1970 >= YEAR).then(|| humantime::format_rfc3339_millis(SystemTime::UNIX_EPOCH + since_1970).to_string())
}

#[cfg(test)]
mod tests {
    use vn100_analysis::RecordingEndFacts;

    use super::*;

    #[test]
    fn times_are_utc_and_a_cut_is_said() {
        let mut recording = RecordingFacts { started_ns: Some(1_763_700_000_123_456_789), ..RecordingFacts::default() };
        let started = "2025-11-21T04:40:00.123Z";
        assert_eq!(RecordingDocument::new(&recording).text(), format!("{started} to an unknown time"));
        let end = RecordingEndFacts { ended_ns: Some(-1), complete: false, reason: None };
        recording.end = Some(end);
        let text = RecordingDocument::new(&recording).text();
        assert_eq!(text, format!("{started} to an unknown time, cut there: the file has no end"));
    }

    #[test]
    fn a_time_that_counts_from_zero_is_no_date() {
        let mut recording = RecordingFacts { started_ns: Some(0), ..RecordingFacts::default() };
        let end = RecordingEndFacts { ended_ns: Some(60_000_000_000), complete: true, reason: None };
        recording.end = Some(end);
        let document = RecordingDocument::new(&recording);
        assert_eq!((&document.started, &document.ended), (&None, &None));
        assert_eq!(document.text(), "at an unknown time");
    }
}
