//! The reasons why a source cannot be used.

use std::{error::Error, io, path::PathBuf};

use tokio::task;
use vn100_analysis::timebase::Refusal;
use vn100_analysis::{End, StartCure};
use vn100_capture::{OpenError, RecordError, with_causes};
use vn100_driver::{CommandError, ConfigureError};

/// The reason why a live source cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The source cannot be opened, or no sensor answers on it.
    #[error("{0}")]
    NoSensor(io::Error),
    /// The source was stopped before a sensor was connected.
    #[error("interrupted")]
    Stopped,
    /// The source is a stream, so no command can be sent to it.
    #[error("standard input is not a sensor that replies: name a port")]
    NoCommands,
    /// The source is a stream, so the temperature cannot be polled.
    #[error("the temperature cannot be polled on standard input: name a port")]
    NoTemperature,
    /// The thread that reads a stream cannot be started.
    #[error("cannot start reading")]
    Read(#[source] io::Error),
    /// The task of the link has ended.
    #[error("internal error: the link stopped")]
    LinkTask(#[from] task::JoinError),
}

/// The reason why a sensor is not set as requested, or its settings are not restored.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The sensor is not connected.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The settings cannot be written or restored.
    #[error(transparent)]
    Configure(#[from] ConfigureError),
    /// The output could not be paused again.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// Another sensor is on the port; it is left unchanged.
    #[error("another sensor is on the port: serial number {now}, expected {known}")]
    AnotherSensor {
        /// The serial number of the sensor on the port.
        now: String,
        /// The serial number of the sensor whose settings were changed.
        known: String,
    },
}

/// A recording that is resumed contains another message than the sensor sends.
#[derive(Debug, thiserror::Error)]
#[error("{} holds {recorded}, and a replay would not measure {sent} behind it: record {sent} to another file", path.display())]
pub struct OtherMessage {
    /// The recording.
    pub path: PathBuf,
    /// The message in it.
    pub recorded: String,
    /// The message of the sensor.
    pub sent: String,
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
    /// The recording to be resumed contains another message than the sensor was to be set to.
    #[error(transparent)]
    OtherMessage(#[from] OtherMessage),
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
    pub(crate) fn end(&self) -> End {
        End::NotStarted {
            text: with_causes(self),
            names_source: matches!(self, Self::Capture(_)),
            is_of_recording: matches!(self, Self::Recording(_) | Self::OtherMessage(_)),
            cure: self.cure(),
        }
    }

    fn cure(&self) -> Option<StartCure> {
        match self {
            Self::RateUnknown { refusal: Some(Refusal::Pairs { .. }) } => Some(StartCure::OneSource),
            Self::RateUnknown { refusal } => Some(StartCure::Rate { has_times: refusal.is_some() }),
            Self::Capture(OpenError::Unusable { problem, .. }) => problem.hint().cloned().map(StartCure::Capture),
            _ => None,
        }
    }
}
