//! What is known of a source beside its samples.

use std::collections::BTreeMap;

use vn100_protocol::stream::{BagReport, CsvReport};

/// What is known of a source beside its samples: a session fills it, reports and faces read it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SourceFacts {
    /// File name without its folder, `-` for standard input, or the port.
    pub name: String,
    /// The format of the source; `None` while it is not known.
    pub kind: Option<&'static str>,
    /// Why reading did not begin, or ended early.
    pub error: Option<String>,
    /// The stored file; `None` for what is no file, and where it was not read for that.
    pub file: Option<FileFacts>,
    /// The lines of a CSV file.
    pub csv: Option<CsvReport>,
    /// The messages of a bag.
    pub bag: Option<BagReport>,
    /// Which stream of the source this is, where it may have several: the topic of a bag, or a
    /// group of columns.
    pub stream: Option<String>,
    /// What a recording that is replayed says of itself.
    pub recording: Option<RecordingFacts>,
    /// The conditions of the measurement, as the user wrote them down.
    pub meta: Option<BTreeMap<String, String>>,
    /// The link of a live source; its counts are in the snapshot.
    pub link: Option<LinkFacts>,
    /// The recording that is made meanwhile.
    pub recorder: Option<RecorderFacts>,
    /// Where a paced replay is.
    pub playback: Option<PlaybackFacts>,
    /// Whether no more samples come.
    pub ended: bool,
    /// Why the measurement ended; `None` until it has.
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
    /// The user stopped it, or a signal did.
    Stopped,
    /// The source was lost for longer than it was waited for.
    GaveUp,
    /// The time by the clock that it could take was over.
    WallTime,
    /// Reading failed.
    SourceFailed,
    /// The sensor sent another message.
    OtherMessage,
    /// The sensor sent at another rate.
    OtherRate,
    /// The sensor sent, and never a measurement.
    NoMeasurement,
    /// The source was not opened.
    NotStarted,
}

impl EndKind {
    /// All of them.
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

/// A file as it is stored, compressed or not.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileFacts {
    /// Its size.
    pub bytes: u64,
    /// The SHA-256 of its bytes, in 64 hexadecimal digits.
    pub sha256: String,
}

/// What a recording says of itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingFacts {
    /// The program that wrote it.
    pub program: Option<String>,
    /// Time of the first byte, in nanoseconds since 1970-01-01 UTC.
    pub started_ns: Option<i64>,
    /// How it ended; `None` until it was read to the end.
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

/// A live link at one moment.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LinkFacts {
    /// What the link does.
    pub status: LinkStatus,
    /// The port by its name, once one is open.
    pub port: Option<String>,
    /// Baud rate; `None` where the link has none, or it is not known yet.
    pub baud: Option<u32>,
    /// Why the link is down.
    pub cause: Option<String>,
    /// Failed attempts since the sensor was connected last, as far as they are known to have
    /// failed.
    pub attempts: u32,
}

/// What a link does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LinkStatus {
    /// The port is being opened.
    #[default]
    Opening,
    /// The baud rate is searched.
    Scanning,
    /// The sensor's output is received.
    Connected,
    /// The port is open and no bytes arrive.
    Silent,
    /// A connection was lost; it is opened again.
    Lost,
    /// There was no connection yet; it is tried again.
    NotConnected,
    /// The link is over.
    Closed,
}

impl LinkStatus {
    /// Its name in results.
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
    /// Bytes of the stream that are in it.
    pub bytes: u64,
    /// Bytes that are missing in it because the disk did not take them in time.
    pub unrecorded_bytes: u64,
    /// Why it stopped, if it did.
    pub error: Option<String>,
}

/// Where a paced replay is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlaybackFacts {
    /// Samples replayed.
    pub samples: u64,
    /// Samples in the capture; `None` until they are counted.
    pub total: Option<u64>,
    /// Whether the replay is paused.
    pub paused: bool,
    /// Whether the capture was replayed to its end.
    pub at_end: bool,
}
