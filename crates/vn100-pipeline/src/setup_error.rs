//! Why the settings of a sensor are not as requested.

use vn100_driver::{CommandError, ConfigureError};

use crate::live_error::LiveError;

/// Why a sensor is not set as requested, or its settings are not restored.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// It is not connected.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// Its settings cannot be written or restored.
    #[error(transparent)]
    Configure(#[from] ConfigureError),
    /// Its output could not be paused again.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// Another one is on the port; it is left as it is.
    #[error("another sensor is on the port: serial number {now}, expected {known}")]
    AnotherSensor {
        /// Its serial number.
        now: String,
        /// That of the one that was set.
        known: String,
    },
}
