//! Why a measurement ended, as plain data: a session fills it, and the faces put it into words.

use std::time::Duration;

use vn100_protocol::stream::{MessageName, OpenHint};

use crate::{rate_change::RateChange, source_facts::EndKind};

/// Why a measurement is over.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The source could not be opened: nothing was measured.
    NotStarted {
        /// Why, with all causes.
        text: String,
        /// Whether the text names the source.
        names_source: bool,
        /// Whether the recording that was to be made is at fault, and not the source.
        is_of_recording: bool,
        /// What the user can say so that the source can be read; `None` where nothing helps.
        cure: Option<StartCure>,
    },
    /// The source was read to its end.
    SourceEnded,
    /// The data time asked for has passed.
    DurationReached,
    /// All goals are met, or one is out of reach.
    GoalsDecided,
    /// The user stopped the measurement, or a signal did.
    Stopped,
    /// Reading failed, for this reason; the result holds what came before.
    SourceFailed(String),
    /// The sensor sends other messages, and not the one that was measured.
    OtherMessages {
        /// The message that was measured.
        message: String,
        /// The latest of the other messages; `None` for binary packets.
        other: Option<MessageName>,
        /// The rate of the record in hertz, if the sensor sends at another one now.
        rate_hz: Option<f64>,
        /// For how long no measured message had come.
        after: Duration,
    },
    /// The sensor sends at another rate than that of the record.
    OtherRate(RateChange),
    /// The sensor sends, and never sent a measurement.
    NoMeasurement,
    /// No sample has arrived for the time after which the source is given up.
    GaveUp {
        /// That time.
        after: Duration,
        /// Why the link is down; `None` if it is up, or if the cause is not known.
        cause: Option<String>,
    },
    /// The session has lasted as long by the clock as it may, which is this long.
    WallTime(Duration),
}

impl End {
    /// The reason as a code, without its details.
    pub const fn kind(&self) -> EndKind {
        match self {
            Self::NotStarted { .. } => EndKind::NotStarted,
            Self::SourceEnded => EndKind::EndOfInput,
            Self::DurationReached => EndKind::Duration,
            Self::GoalsDecided => EndKind::Goals,
            Self::Stopped => EndKind::Stopped,
            Self::SourceFailed(_) => EndKind::SourceFailed,
            Self::OtherMessages { .. } => EndKind::OtherMessage,
            Self::OtherRate(_) => EndKind::OtherRate,
            Self::NoMeasurement => EndKind::NoMeasurement,
            Self::GaveUp { .. } => EndKind::GaveUp,
            Self::WallTime(_) => EndKind::WallTime,
        }
    }
}

/// What the user can say of a source so that it can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StartCure {
    /// What the file lacks.
    Capture(OpenHint),
    /// The rate, or the column of the times.
    Rate {
        /// Whether it has times, which do not show the rate.
        has_times: bool,
    },
    /// The rows of one of two sources, or the rate of a buffer of two.
    OneSource,
}

/// A measurement that ended before the data time asked for had passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortfall {
    /// The data time asked for.
    pub wanted: Duration,
    /// The data time that has passed.
    pub measured: Duration,
}
