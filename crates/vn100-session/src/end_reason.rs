//! The reasons for the end of a session.

use std::{error::Error, fmt, io, path::PathBuf, time::Duration};

use vn100_analysis::protocol::stream::MessageName;
use vn100_analysis::timebase::Refusal;
use vn100_analysis::{End, EndKind, RateChange, StartCure};
use vn100_capture::{BagError, MapHint, OpenError, RecordError};

use crate::{live_error::LiveError, setup_error::SetupError};

/// A sensor that sends no measurement for this time, or none at the rate of the record, was set to
/// other output. A burst of delayed bytes is shorter than this. So is the time in which the link
/// detects a paused output, including the first frame of the slowest sensor after that.
pub(crate) const NO_MEASUREMENT_AFTER: Duration = Duration::from_secs(5);

/// The reason for the end of a session.
#[derive(Debug)]
pub enum EndReason {
    /// The source could not be opened: nothing was measured.
    NotStarted(StartError),
    /// The source was read to its end.
    SourceEnded,
    /// The requested data time has passed.
    DurationReached,
    /// All goals are met, or one is out of reach.
    GoalsDecided,
    /// The session was stopped by [`Command::Stop`](crate::Command::Stop) or by its token.
    Stopped,
    /// Reading failed; the result contains the samples before that.
    SourceFailed(io::Error),
    /// The sensor sends other messages, and no longer the measured one.
    OtherMessages {
        /// The measured message.
        message: String,
        /// The latest of the other messages; `None` if these are binary packets.
        other: Option<MessageName>,
        /// The rate of the record in hertz, if the sensor now sends at another one; otherwise
        /// `None`.
        rate_hz: Option<f64>,
    },
    /// The sensor sends at another rate than that of the record.
    OtherRate(RateChange),
    /// The sensor sends, but never sent a measurement.
    NoMeasurement,
    /// No sample has arrived for the time after which the source is given up.
    GaveUp {
        /// That time.
        after: Duration,
        /// The reason why the link is down; `None` if it is up, or if the cause is not known.
        cause: Option<String>,
    },
    /// The session has reached its limit by the clock, which is this duration.
    WallTime(Duration),
}

impl EndReason {
    /// The reason as plain data, with the text of its error.
    #[must_use]
    pub fn plain(&self) -> End {
        match self {
            Self::NotStarted(error) => End::NotStarted {
                text: with_causes(error),
                names_source: matches!(error, StartError::Capture(_)),
                is_of_recording: matches!(error, StartError::Recording(_) | StartError::OtherMessage { .. }),
                cure: error.cure(),
            },
            Self::SourceEnded => End::SourceEnded,
            Self::DurationReached => End::DurationReached,
            Self::GoalsDecided => End::GoalsDecided,
            Self::Stopped => End::Stopped,
            Self::SourceFailed(error) => End::SourceFailed(error.to_string()),
            Self::OtherMessages { message, other, rate_hz } => End::OtherMessages {
                message: message.clone(),
                other: *other,
                rate_hz: *rate_hz,
                after: NO_MEASUREMENT_AFTER,
            },
            Self::OtherRate(change) => End::OtherRate(*change),
            Self::NoMeasurement => End::NoMeasurement,
            Self::GaveUp { after, cause } => End::GaveUp { after: *after, cause: cause.clone() },
            Self::WallTime(wall) => End::WallTime(*wall),
        }
    }

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

/// The reason why a source could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The capture could not be opened.
    #[error(transparent)]
    Capture(#[from] OpenError),
    /// No recording could be made.
    #[error(transparent)]
    Recording(#[from] RecordError),
    /// The recording to be resumed contains another message.
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
        /// The reason why the times of the capture do not show the rate; `None` if it has none.
        refusal: Option<Refusal>,
    },
    /// The session was stopped before the source was opened.
    #[error("not read, interrupted")]
    Stopped,
}

impl StartError {
    fn cure(&self) -> Option<StartCure> {
        match self {
            Self::RateUnknown { refusal: Some(Refusal::Pairs { .. }) } => Some(StartCure::OneSource),
            Self::RateUnknown { refusal } => Some(StartCure::Rate { has_times: refusal.is_some() }),
            Self::Capture(OpenError::Csv { problem, .. }) => Some(match problem.hint()? {
                MapHint::Columns(map) => StartCure::Columns(map),
                MapHint::DateOrder(map) => StartCure::DateOrder(map),
                MapHint::StampUnit(map) => StartCure::StampUnit(map),
            }),
            Self::Capture(OpenError::Bag { problem, .. }) => match &**problem {
                BagError::SeveralTopics { .. } => Some(StartCure::Topic),
                BagError::NoTopic { topics, .. } => (!topics.is_empty()).then_some(StartCure::Topic),
                BagError::NoSensor { .. } => Some(StartCure::TopicAndColumns),
                BagError::NotOfSensor { .. } => Some(StartCure::ColumnsOfTopic),
                _ => None,
            },
            _ => None,
        }
    }
}

/// An error with all its causes.
#[must_use]
pub fn with_causes(error: &dyn Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| (**cause).source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

impl fmt::Display for EndReason {
    /// The reason as a word, as written in recordings.
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
    fn a_recording_contains_its_end_reason() {
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
