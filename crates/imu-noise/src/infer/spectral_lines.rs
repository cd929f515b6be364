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

impl SpectralLine {
    /// The frequencies in Hz up to `max_hz` that a sensor sampled every `interval_s` seconds
    /// without filter shows at this place, in rising order: f, 1/interval - f, 1/interval + f,
    /// 2/interval - f, ... The samples do not distinguish them.
    pub fn aliases_hz(&self, interval_s: f64, max_hz: f64) -> impl Iterator<Item = f64> {
        let (line_hz, rate_hz) = (self.frequency_hz, 1.0 / interval_s);
        let pairs = (0..).flat_map(move |n| {
            let carrier_hz = f64::from(n) * rate_hz;
            [carrier_hz - line_hz, carrier_hz + line_hz]
        });
        pairs.skip(1).take_while(move |&alias_hz| alias_hz <= max_hz)
    }
}
