//! Vibration lines of a channel, as they are reported.

use schemars::JsonSchema;
use serde::Serialize;

/// A vibration line of one channel.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct SpectralLine {
    /// In Hz, between 0 and half the sampling rate, interpolated between the points.
    pub frequency_hz: f64,
    /// Amplitude of the sine in the unit of the channel (half of peak to peak).
    pub amplitude: f64,
    /// Share of the line in the variance within segments, from 0 to 1.
    pub share_of_variance: f64,
    /// Power of the highest point over the power of the noise around it.
    pub peak_to_floor: f64,
}
