//! That a sensor was moved.

use schemars::JsonSchema;
use serde::Serialize;

/// A sensor that was moved, by the axis that shows it most.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct Motion {
    /// The axis.
    pub channel: String,
    /// Its standard deviation over the record, in `unit`.
    pub std: f64,
    /// The least that counts as motion.
    pub limit: f64,
    /// rad/s or m/s².
    pub unit: String,
    /// All axes beyond their limits.
    pub axes: Vec<String>,
}
