//! The events of a session besides its state.

use std::time::Duration;

use vn100_driver::{Change, Configured, OutputLeft};

use crate::{
    command::CommandRefusal,
    start_error::{OtherMessage, SetupError},
    watchdog::RateEvent,
};

/// Something that happened in a session; its effect is in the [state](crate::SourceState).
#[derive(Debug)]
pub enum SessionEvent {
    /// The sensor was set as requested, before the measurement.
    SensorConfigured(Configured),
    /// The settings of the sensor were restored.
    SettingsRestored {
        /// Whether the output is paused again, as it was found.
        output_paused: bool,
    },
    /// The settings of the sensor could not be restored.
    SettingsNotRestored {
        /// The reason.
        error: SetupError,
        /// The registers that may stay changed.
        changes: Vec<Change>,
        /// The possible state of the output, if it differs from the state in which it was found.
        output: Option<OutputLeft>,
    },
    /// The output, which was found paused and resumed for the measurement, is paused again.
    OutputPausedAgain,
    /// The output, which was found paused, could not be paused again.
    OutputNotPausedAgain,
    /// Another program has the port open as well.
    PortShared {
        /// The name of the program, and the number of its process.
        program: String,
    },
    /// A replay of the recording that is resumed will not measure what the sensor sends.
    OtherMessage(OtherMessage),
    /// The rate of the stream changed.
    Rate(RateEvent),
    /// Everything before this is excluded as warm-up.
    WarmUpEnded {
        /// Data time since the measurement began, or was started over.
        warm_up: Duration,
        /// Data time excluded at the beginning of the whole record.
        excluded: Duration,
    },
    /// Everything before this is excluded, and the measurement restarted.
    StartedOver {
        /// Data time up to the restart.
        after: Duration,
    },
    /// A command had no effect, for this reason.
    Refused(CommandRefusal),
}
