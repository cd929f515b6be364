//! What is known of a source besides its samples.

use std::collections::BTreeMap;

use vn100_protocol::stream::{BagReport, CsvReport};

use crate::warning::{Finding, Severity, Warning, WarningKind};

/// What is known of a source besides its samples: a session fills in the facts, reports and faces
/// read them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SourceFacts {
    /// File name without its folder, `-` for standard input, or the name of the port.
    pub name: String,
    /// The format of the source; `None` while it is not known.
    pub kind: Option<&'static str>,
    /// Why reading did not begin, or ended early; `None` where it did not.
    pub error: Option<String>,
    /// The stored file; `None` where the source is no file, and where the file was not hashed.
    pub file: Option<FileFacts>,
    /// What the reader of a CSV file found; `None` for any other source.
    pub csv: Option<CsvReport>,
    /// What the reader of a bag found; `None` for any other source.
    pub bag: Option<BagReport>,
    /// Which stream of the source this is, where the source may have several: the topic of a bag,
    /// or a group of columns; else `None`.
    pub stream: Option<String>,
    /// What a replayed recording says of itself; `None` for any other source.
    pub recording: Option<RecordingFacts>,
    /// The conditions of the measurement, name and text as the user wrote them down; `None` for
    /// none.
    pub meta: Option<BTreeMap<String, String>>,
    /// The link of a live source; its counts are in the snapshot. `None` for any other source.
    pub link: Option<LinkFacts>,
    /// The recording that is made during the measurement; `None` for none.
    pub recorder: Option<RecorderFacts>,
    /// The place of a paced replay; `None` for any other source.
    pub playback: Option<PlaybackFacts>,
    /// Whether no more samples will follow.
    pub ended: bool,
    /// Why the measurement ended; `None` while it has not.
    pub end: Option<EndKind>,
}

/// Why a measurement ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndKind {
    /// All data was read.
    EndOfInput,
    /// The data time asked for has passed.
    Duration,
    /// All goals are met, or one is out of reach.
    Goals,
    /// The user stopped the measurement, or a signal did.
    Stopped,
    /// No sample arrived for the time after which the source is given up.
    GaveUp,
    /// The measurement had lasted as long by the clock as it may.
    WallTime,
    /// Reading failed.
    SourceFailed,
    /// The sensor sent another message.
    OtherMessage,
    /// The sensor sent at another rate.
    OtherRate,
    /// The sensor sent frames, but never a measurement.
    NoMeasurement,
    /// The source was not opened.
    NotStarted,
}

impl EndKind {
    /// All reasons, in the order of the codes.
    pub const ALL: [Self; 11] = [
        Self::EndOfInput,
        Self::Duration,
        Self::Goals,
        Self::Stopped,
        Self::GaveUp,
        Self::WallTime,
        Self::SourceFailed,
        Self::OtherMessage,
        Self::OtherRate,
        Self::NoMeasurement,
        Self::NotStarted,
    ];
}

/// A file as it is stored, which may be compressed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileFacts {
    /// Size in bytes.
    pub bytes: u64,
    /// The SHA-256 of its bytes, in 64 hexadecimal digits.
    pub sha256: String,
}

/// What a recording says of itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingFacts {
    /// The program that wrote the recording, with its version.
    pub program: Option<String>,
    /// Time of the first byte, in nanoseconds since 1970-01-01 UTC.
    pub started_ns: Option<i64>,
    /// How the recording ended; `None` until it is read to its end.
    pub end: Option<RecordingEndFacts>,
}

/// How a recording ended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingEndFacts {
    /// Time of the last byte, in nanoseconds since 1970-01-01 UTC.
    pub ended_ns: Option<i64>,
    /// Whether the file was finished.
    pub complete: bool,
    /// Why the recording ended, as it says itself.
    pub reason: Option<String>,
}

impl RecordingEndFacts {
    /// The warning of a recording that was cut, as by a loss of power, or where a copy of the file
    /// is not whole; `None` for one that was finished.
    #[must_use]
    pub fn warning(&self) -> Option<Warning> {
        let found = Warning::new(WarningKind::Incomplete, Finding::RecordingCut);
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
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

impl LinkStatus {
    /// The code of the status in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Opening => "opening",
            Self::Scanning => "scanning",
            Self::Connected => "connected",
            Self::Silent => "silent",
            Self::Lost => "lost",
            Self::NotConnected => "not-connected",
            Self::Closed => "closed",
        }
    }
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlaybackFacts {
    /// Samples replayed.
    pub samples: u64,
    /// Samples in the capture; `None` until they are counted, and where they cannot be.
    pub total: Option<u64>,
    /// Whether the replay is paused.
    pub paused: bool,
    /// Whether the capture, or the part to be measured, was replayed to its end.
    pub at_end: bool,
}
