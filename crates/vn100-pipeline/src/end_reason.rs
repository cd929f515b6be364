//! Why a session ended.

use std::{error::Error, fmt, io, path::PathBuf, time::Duration};

use vn100_analysis::protocol::stream::MessageName;
use vn100_analysis::timebase::Refusal;
use vn100_analysis::{EndKind, RateChange};
use vn100_capture::{OpenError, RecordError};

use crate::{live_error::LiveError, setup_error::SetupError};

/// Why a session is over.
#[derive(Debug)]
pub enum EndReason {
    /// The source could not be opened: nothing was measured.
    NotStarted(StartError),
    /// The source was read to its end.
    SourceEnded,
    /// The data time asked for has passed.
    DurationReached,
    /// All goals are met, or one is out of reach.
    GoalsDecided,
    /// The session was stopped by [`Command::Stop`](crate::Command::Stop) or by its token.
    Stopped,
    /// Reading failed; the result holds what came before.
    SourceFailed(io::Error),
    /// The sensor sends other messages, and not the one that was measured.
    OtherMessages {
        /// The message that was measured.
        message: String,
        /// The latest of the other messages; `None` where these are binary packets.
        other: Option<MessageName>,
        /// The rate of the record in hertz, where the sensor sends at another one now; `None` where
        /// it does not.
        rate_hz: Option<f64>,
    },
    /// The sensor sends at another rate than that of the record.
    OtherRate(RateChange),
    /// The sensor sends, and never sent a measurement.
    NoMeasurement,
    /// No sample has arrived for the time after which the source is given up.
    GaveUp {
        /// That time.
        after: Duration,
        /// Why the link is down; `None` where it is up, or where the cause is not known.
        cause: Option<String>,
    },
    /// The session has lasted as long by the clock as it may, which is this long.
    WallTime(Duration),
}

/// A measurement that ended before the data time asked for had passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortfall {
    /// The data time asked for.
    pub wanted: Duration,
    /// The data time that has passed.
    pub measured: Duration,
}

impl EndReason {
    /// The reason as a code, without its details.
    #[must_use]
    pub const fn kind(&self) -> EndKind {
        match self {
            Self::NotStarted(_) => EndKind::NotStarted,
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

/// Why a source could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The capture could not be opened.
    #[error(transparent)]
    Capture(#[from] OpenError),
    /// No recording could be made.
    #[error(transparent)]
    Recording(#[from] RecordError),
    /// The recording to be resumed holds another message.
    #[error(
        "{} holds {recorded}, and a replay would not measure {asked} behind it: record {asked} to another file",
        path.display()
    )]
    OtherMessage {
        /// The recording.
        path: PathBuf,
        /// The message in it.
        recorded: String,
        /// The message that the sensor was to be set to.
        asked: String,
    },
    /// The sensor could not be set as requested.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The live source could not be opened.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The [`LiveSource`](crate::LiveSource) had failed before the session began.
    #[error(transparent)]
    StreamInput(Box<dyn Error + Send + Sync>),
    /// The capture holds values of any sensor, their rate cannot be found, and none was given.
    #[error("its sample rate is unknown{}", .refusal.map_or_else(String::new, |refusal| format!(": {refusal}")))]
    RateUnknown {
        /// Why the times of the capture do not show the rate; `None` where it has none.
        refusal: Option<Refusal>,
    },
    /// The session was stopped before the source was opened.
    #[error("not read, interrupted")]
    Stopped,
}

impl fmt::Display for EndReason {
    /// The reason as a word, the one that recordings hold.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted(error) => error.fmt(f),
            Self::SourceFailed(error) => error.fmt(f),
            Self::SourceEnded => f.write_str("end of the source"),
            Self::DurationReached => f.write_str("duration reached"),
            Self::GoalsDecided => f.write_str("goals decided"),
            Self::Stopped | Self::NoMeasurement => f.write_str("stopped"),
            Self::OtherMessages { .. } => f.write_str("the sensor sends another message"),
            Self::OtherRate(_) => f.write_str("the sensor sends at another rate"),
            Self::GaveUp { .. } => f.write_str("the sensor was lost"),
            Self::WallTime(_) => f.write_str("wall time over"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_says_why_it_ended() {
        let change = RateChange { after_samples: 1, from_hz: 200.0, to_hz: 40.0 };
        let other = EndReason::OtherMessages { message: "VNYMR".into(), other: None, rate_hz: None };
        for (reason, text) in [
            (EndReason::NotStarted(StartError::Stopped), "not read, interrupted"),
            (EndReason::SourceEnded, "end of the source"),
            (EndReason::DurationReached, "duration reached"),
            (EndReason::GoalsDecided, "goals decided"),
            (EndReason::Stopped, "stopped"),
            (EndReason::NoMeasurement, "stopped"),
            (EndReason::SourceFailed(io::Error::other("unplugged")), "unplugged"),
            (other, "the sensor sends another message"),
            (EndReason::OtherRate(change), "the sensor sends at another rate"),
            (EndReason::GaveUp { after: Duration::ZERO, cause: None }, "the sensor was lost"),
            (EndReason::WallTime(Duration::ZERO), "wall time over"),
        ] {
            assert_eq!(reason.to_string(), text);
        }
    }
}
