//! What contradicts the rate of a stream: a change of the sensor's, a false one by arrivals, a false report.

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

/// A rate by arrival times that the sensor contradicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseRate {
    /// Samples that were placed by the false rate, and excluded.
    pub samples: u64,
    /// The rate by arrival times, in hertz.
    pub arrival_hz: f64,
    /// The sensor's rate, in hertz.
    pub device_hz: f64,
}

/// A rate reported by the sensor that arrival times contradicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseReport {
    /// The rate that the sensor reports in register 7, in hertz.
    pub reported_hz: f64,
    /// The rate by arrival times, that of the record, in hertz.
    pub arrival_hz: f64,
}
