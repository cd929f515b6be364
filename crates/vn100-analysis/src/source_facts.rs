//! What is known of a source besides its samples.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};
use std::{
    collections::BTreeMap,
    str::FromStr,
    sync::Arc,
    time::{Duration, SystemTime},
};

use vn100_protocol::{
    Layout,
    stream::{BagReport, CsvReport, FileReport},
};

use crate::{
    snapshot::PlaceMark,
    warning::{Finding, Severity, Warning},
};

/// What is known of a source besides its samples. A session fills in the facts; those that the
/// stream itself carries are added with the result.
#[derive(Debug, Clone, Default, PartialEq, JsonSchema, Serialize)]
pub struct SourceFacts {
    /// Name of the file without its folder, `-` for standard input, or the name of the port.
    pub name: String,
    /// Form of the source, such as text, csv, raw, mcap, bag, db3, serial, sim, tcp, stdin; null
    /// while it is not recognised.
    pub kind: Option<&'static str>,
    /// Message of the sensor, such as VNYMR, or the type of the foreign samples; null without a
    /// sample.
    pub message: Option<String>,
    /// Whether the sensor's filter has removed the bias of the rates; null if that is not known.
    pub compensated: Option<bool>,
    /// The sensor, as far as it was asked within the stream; null if it was not.
    pub device: Option<Device>,
    /// What a replayed recording says of itself; null for any other source.
    #[serde(rename = "recorded")]
    pub recording: Option<RecordingFacts>,
    /// Conditions of the measurement, name and text as the user wrote them down; null without any.
    pub meta: Option<BTreeMap<String, String>>,
    /// Why the measurement failed or was cut short; null if it was not.
    pub error: Option<String>,
    /// The stored file; null if the source is no file, or if the file was not hashed.
    pub file: Option<FileFacts>,
    /// The lines of a CSV file: lines = rows + skipped lines + rejected rows + other_stream_rows, up to
    /// the end of the measurement, and all 0 before it; null for any other source.
    pub csv: Option<CsvReport>,
    /// Topic of a bag, or group of columns of a table, if the source may have several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<String>,
    /// Messages of the other streams of the file.
    #[serde(skip)]
    pub other_streams: Vec<Arc<Layout>>,
    /// Messages of a topic of a bag: messages = used + without_sample + unreadable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bag: Option<BagReport>,
    /// Places that the user marked, in time order; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<PlaceMark>,
    /// The link of a live source; `None` for any other source.
    #[serde(skip)]
    pub link: Option<LinkFacts>,
    /// The recording that is made during the measurement; `None` for none.
    #[serde(skip)]
    pub recorder: Option<RecorderFacts>,
    /// The place of a paced replay; `None` for any other source.
    #[serde(skip)]
    pub playback: Option<Playback>,
    /// Why the measurement ended, so that no more samples will follow; `None` while it has not.
    #[serde(skip)]
    pub end: Option<EndKind>,
}

impl SourceFacts {
    /// The facts of a source that ended so, with what the file says of its content. Its times are
    /// those of the rows or messages if it is no recording.
    pub fn at_end(self, report: Option<FileReport>, end: EndKind) -> Self {
        let facts = Self { end: Some(end), ..self };
        match report {
            Some(FileReport::Csv(csv)) => {
                let recording = facts.recording.or_else(|| RecordingFacts::of_rows(&csv));
                Self { csv: Some(csv), recording, ..facts }
            }
            Some(FileReport::Bag(bag)) => {
                let recording = facts.recording.or_else(|| RecordingFacts::of_bag(&bag, end));
                Self { bag: Some(bag), recording, ..facts }
            }
            None => facts,
        }
    }
}

/// A sensor, as far as it was asked within the stream.
#[derive(Debug, Clone, Default, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Device {
    /// Model, register 1.
    pub model: Option<String>,
    /// Hardware revision, register 2.
    pub hardware_revision: Option<String>,
    /// Serial number, register 3.
    pub serial_number: Option<String>,
    /// Firmware version, register 4.
    pub firmware: Option<String>,
    /// Every register that was read, by number, as printed.
    pub registers: BTreeMap<u8, String>,
}

impl Device {
    /// The sensor with these registers; `None` if there are none.
    pub(crate) fn of(registers: &BTreeMap<u8, String>) -> Option<Self> {
        let register = |number| registers.get(&number).map(|text| text.trim().to_owned());
        (!registers.is_empty()).then(|| Self {
            model: register(1),
            hardware_revision: register(2),
            serial_number: register(3),
            firmware: register(4),
            registers: registers.clone(),
        })
    }
}

/// Why a measurement ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndKind {
    /// All data was read.
    EndOfInput,
    /// The data time asked for has passed.
    Duration,
    /// All goals are met, or one is out of reach.
    Goals,
    /// The user stopped it, or a signal did.
    Stopped,
    /// No sample came for as long as one was to be waited for.
    GaveUp,
    /// It had taken as long by the clock as it was allowed to.
    WallTime,
    /// Reading failed; the result holds what came before.
    SourceFailed,
    /// The sensor sent another message than the measured one.
    OtherMessage,
    /// The sensor sent at another rate than that of the record.
    OtherRate,
    /// The sensor sent, and never a measurement.
    NoMeasurement,
    /// The source was not opened; nothing was measured.
    NotStarted,
}

/// A file as it is stored, which may be compressed.
#[derive(Debug, Clone, Default, PartialEq, Eq, JsonSchema, Serialize)]
pub struct FileFacts {
    /// Size in bytes.
    pub bytes: u64,
    /// The SHA-256 of its bytes, in 64 hexadecimal digits.
    pub sha256: String,
}

/// What a recording says of itself.
#[derive(Debug, Clone, Default, PartialEq, Eq, JsonSchema, Serialize)]
pub struct RecordingFacts {
    /// Program that wrote the recording, with its version; null if the recording does not say.
    pub program: Option<String>,
    /// Time of the first byte, RFC 3339; null without a date.
    #[serde(rename = "started", serialize_with = "as_utc")]
    #[schemars(with = "Option<String>")]
    pub started_ns: Option<i64>,
    /// How the recording ended; `None` until it is read to its end.
    #[serde(flatten)]
    pub end: Option<RecordingEndFacts>,
}

/// How a recording ended.
#[derive(Debug, Clone, Default, PartialEq, Eq, JsonSchema, Serialize)]
pub struct RecordingEndFacts {
    /// Time of the last byte, RFC 3339; null without a date.
    #[serde(rename = "ended", serialize_with = "as_utc")]
    #[schemars(with = "Option<String>")]
    pub ended_ns: Option<i64>,
    /// Whether the file has its end, and no part of the recording before it is missing.
    pub complete: bool,
    /// Why the recording ended, as it says itself; null if it does not.
    #[serde(rename = "end_reason")]
    pub reason: Option<String>,
}

/// Earlier times belong to a simulation, or count from the power-up of the sensor.
const YEAR_2001_NS: i64 = 978_307_200_000_000_000;

impl RecordingFacts {
    /// The time of the first row of a table, if its times count from 1970, in any time zone.
    fn of_rows(csv: &CsvReport) -> Option<Self> {
        let is_count =
            |part: &str| part.rsplit_once(':').is_some_and(|(_, form)| ["s", "ms", "us", "ns"].contains(&form));
        let counts = csv.times.as_ref()?.split('+').all(is_count);
        let started_ns = csv.first_stamp_ns.filter(|first_ns| counts && *first_ns >= YEAR_2001_NS)?;
        Some(Self { started_ns: Some(started_ns), ..Self::default() })
    }

    /// The times of the recording of a bag, if they are dates; the end only if it was read to its end.
    fn of_bag(bag: &BagReport, end: EndKind) -> Option<Self> {
        let (first_ns, last_ns) = bag.recorded_ns.filter(|(first_ns, _)| *first_ns >= YEAR_2001_NS)?;
        let complete = end == EndKind::EndOfInput;
        let end = (complete || end == EndKind::SourceFailed).then_some(RecordingEndFacts {
            ended_ns: Some(last_ns),
            complete,
            reason: None,
        });
        Some(Self { program: None, started_ns: Some(first_ns), end })
    }

    /// When the recording began, in UTC to the millisecond (RFC 3339); `None` if it does not say, or
    /// by a clock that was not set.
    pub fn started(&self) -> Option<String> {
        self.started_ns.and_then(utc)
    }

    /// When the recording ended, in the same form; also `None` before it was read to its end.
    pub fn ended(&self) -> Option<String> {
        self.end.as_ref()?.ended_ns.and_then(utc)
    }
}

/// A time in nanoseconds since 1970 in UTC, to the millisecond, as the clock of a host is not better
/// than that; `None` for a time before 1971: it is that of a clock that was not set, or of no clock.
pub fn utc(at_ns: i64) -> Option<String> {
    const YEAR: Duration = Duration::from_secs(365 * 24 * 3600);
    let since_1970 = Duration::from_nanos(at_ns.try_into().ok()?);
    (since_1970 >= YEAR).then(|| humantime::format_rfc3339_millis(SystemTime::UNIX_EPOCH + since_1970).to_string())
}

fn as_utc<S: Serializer>(at_ns: &Option<i64>, serializer: S) -> Result<S::Ok, S::Error> {
    at_ns.and_then(utc).serialize(serializer)
}

impl RecordingEndFacts {
    /// The warning of a recording that was cut; `None` for one that was finished.
    pub fn warning(&self) -> Option<Warning> {
        let found = Warning::new(Finding::RecordingCut);
        (!self.complete).then(|| found.as_severe_as(Severity::Caution))
    }
}

/// A live link at one moment.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LinkFacts {
    /// What the link is doing.
    pub status: LinkStatus,
    /// The name of the port, once one is open.
    pub port: Option<String>,
    /// Baud rate; `None` where the link has none, or where it is not known yet.
    pub baud: Option<u32>,
    /// Why the link is down; `None` where it is not.
    pub cause: Option<String>,
    /// Attempts since the sensor was last connected that are known to have failed.
    pub attempts: u32,
}

/// What a link is doing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LinkStatus {
    /// The port is being opened.
    #[default]
    Opening,
    /// A baud scan searches the sensor.
    Scanning,
    /// The sensor's output is received.
    Connected,
    /// The port is open and no bytes arrive.
    Silent,
    /// The connection was lost; another attempt follows.
    Lost,
    /// The sensor was not connected yet; another attempt follows.
    NotConnected,
    /// The link has ended.
    Closed,
}

/// A recording that is being made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecorderFacts {
    /// The file.
    pub path: String,
    /// Bytes of the stream that the file holds.
    pub bytes: u64,
    /// Bytes of the stream that the file lacks because the disk did not take them in time.
    pub unrecorded_bytes: u64,
    /// Why the recording stopped; `None` while it continues.
    pub error: Option<String>,
}

/// The place of a paced replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    /// Samples replayed.
    pub samples: u64,
    /// Samples in the capture; `None` until they are counted, and where they cannot be.
    pub total: Option<u64>,
    /// The speed at which the replay continues.
    pub speed: Speed,
    /// Whether the replay is paused.
    pub paused: bool,
    /// Whether the capture, or the part to be measured, was replayed to its end.
    pub at_end: bool,
}

/// The speed of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// This many seconds of data per second; above 0.
    Times(f64),
    /// As fast as the machine can.
    Max,
}

impl Playback {
    /// A replay before its first sample.
    pub const fn begin(speed: Speed) -> Self {
        Self { samples: 0, total: None, speed, paused: false, at_end: false }
    }
}

/// The speeds that commands step through, in seconds of data per second; above the last one the
/// replay is as fast as the machine can.
const STEPS: [f64; 10] = [0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

impl Speed {
    /// The next higher or lower speed.
    pub fn next(self, faster: bool) -> Self {
        match (self, faster) {
            (Self::Max, true) => Self::Max,
            (Self::Max, false) => Self::Times(STEPS[STEPS.len() - 1]),
            (Self::Times(now), true) => STEPS.into_iter().find(|step| *step > now).map_or(Self::Max, Self::Times),
            (Self::Times(now), false) => {
                Self::Times(STEPS.into_iter().rev().find(|step| *step < now).unwrap_or(STEPS[0]))
            }
        }
    }
}

impl FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let times = text.strip_suffix('x').and_then(|times| times.parse::<f64>().ok());
        match times {
            _ if text == "max" => Ok(Self::Max),
            Some(times) if (1e-3..=1e6).contains(&times) => Ok(Self::Times(times)),
            _ => Err("neither \"max\" nor a speed such as \"1x\" or \"10x\"".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bag_has_times_that_are_dates_and_an_end_if_read_to_its_end() {
        let recording = |recorded_ns, end| {
            let bag = BagReport { recorded_ns, ..BagReport::default() };
            SourceFacts::default().at_end(Some(FileReport::Bag(bag)), end).recording
        };
        let dates = Some((YEAR_2001_NS, YEAR_2001_NS + 5));
        for (end, complete) in
            [(EndKind::EndOfInput, Some(true)), (EndKind::SourceFailed, Some(false)), (EndKind::Stopped, None)]
        {
            let times = recording(dates, end).unwrap();
            assert_eq!(times.started_ns, Some(YEAR_2001_NS));
            let ended = complete.map(|complete| (Some(YEAR_2001_NS + 5), complete));
            assert_eq!(times.end.map(|end| (end.ended_ns, end.complete)), ended);
        }
        // times since the start of a simulation
        assert!(recording(Some((YEAR_2001_NS - 1, YEAR_2001_NS)), EndKind::EndOfInput).is_none());
        assert!(recording(None, EndKind::EndOfInput).is_none());
    }
}
