//! The reasons why the settings of a sensor are not as requested.

use vn100_driver::{CommandError, ConfigureError};

use crate::live_error::LiveError;

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
