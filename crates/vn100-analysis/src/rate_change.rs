//! A change of the rate of a stream.

use schemars::JsonSchema;
use serde::Serialize;

/// A change of the rate of the sensor within the stream.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct RateChange {
    /// Samples in the statistics, all of them before the change.
    pub after_samples: u64,
    /// Rate before, in hertz.
    pub from_hz: f64,
    /// Rate after, in hertz.
    pub to_hz: f64,
}
