//! What a session reports besides its state.

use std::time::Duration;

use vn100_driver::{Change, Configured};

use crate::{command::CommandRefusal, setup_error::SetupError, watchdog::RateEvent};

/// Something that happened in a session; the result of it is in the [state](crate::SourceState).
#[derive(Debug)]
pub enum SessionEvent {
    /// The sensor was set as requested, before its measurement.
    SensorConfigured(Configured),
    /// The settings of the sensor were restored.
    SettingsRestored {
        /// Its output is paused again, as it was found.
        output_paused: bool,
    },
    /// The settings of the sensor could not be restored.
    SettingsNotRestored {
        /// Why.
        error: SetupError,
        /// What may stay changed.
        changes: Vec<Change>,
        /// How its output may be left, where that is not as it was found.
        output: Option<OutputLeft>,
    },
    /// An output that was found paused, and resumed for the measurement, is paused again.
    OutputPausedAgain,
    /// An output that was found paused could not be paused again.
    OutputNotPausedAgain,
    /// Another program has the port open too.
    PortShared {
        /// Its name, and the number of its process.
        program: String,
    },
    /// The rate of the stream changed.
    Rate(RateEvent),
    /// Everything before this is excluded as warm-up.
    WarmUpEnded {
        /// Data time since the measurement began, or was started over.
        warm_up: Duration,
        /// Data time excluded at the beginning of the whole record.
        excluded: Duration,
    },
    /// Everything before this is excluded, and the measurement began anew.
    StartedOver {
        /// Data time until then.
        after: Duration,
    },
    /// The same beginning is excluded although the capture is replayed from its start again.
    StillExcluded {
        /// Data time at the beginning.
        first: Duration,
    },
    /// Nothing is excluded: the capture is replayed to a place before the end of what was.
    NoLongerExcluded {
        /// Data time until where it was.
        until: Duration,
    },
    /// A command had no effect.
    Refused(CommandRefusal),
}

/// The output of a sensor whose settings could not be restored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputLeft {
    /// It is on, and was found paused.
    On,
    /// It may be paused, and was found on.
    MaybePaused,
}
