//! Averaging and decimation inside the sensor.

use imu_noise::BoxcarWindow;
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::{Channel, ImuFilter, Quantity, Register};

use crate::{
    accumulate::sensor_rates::rates_hz,
    snapshot::{ChannelSnapshot, Snapshot},
};

/// Refreshes of gyroscope and accelerometer per second.
const IMU_REFRESH_HZ: f64 = 800.0;

/// Averaging and decimation inside a VN-100, for one channel.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Onboard {
    /// Refreshes of the channel's sensor per second.
    pub refresh_hz: f64,
    /// Samples of the channel per second.
    pub rate_hz: f64,
    /// The averaging window and the decimation.
    pub window: BoxcarWindow,
    /// Where the window comes from.
    pub window_from: WindowFrom,
}

/// Where the averaging window of a sensor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WindowFrom {
    /// The capture contains register 85.
    Register,
    /// The user gave the value of register 85.
    #[serde(rename = "option")]
    Given,
    /// The sensor sends integrals over the interval between rows.
    Integrated,
    /// Unknown: the factory default, which may have been changed.
    Default,
}

impl Onboard {
    /// Refreshes of the magnetometer per second.
    pub const MAG_REFRESH_HZ: f64 = 250.0;

    /// How far the factor may be off, relative, as the sensor's own roll-off is not known: measured
    /// at 40 Hz with a window of four refreshes were 2.17 to 2.47 where the formula gives 2.236.
    pub const UNCERTAINTY: f64 = 0.10;

    /// [`UNCERTAINTY`](Self::UNCERTAINTY) where white noise is aliased. Where the windows cover all
    /// refreshes evenly, the density at low frequencies stays as it is, whatever the roll-off.
    pub(crate) fn uncertainty_of(window: BoxcarWindow) -> f64 {
        const EXACT: f64 = 1e-9;
        if window.white_factor() < 1.0 + EXACT { 0.0 } else { Self::UNCERTAINTY }
    }

    /// Whether the window is known; otherwise nothing can pass or fail by it.
    pub fn window_known(&self) -> bool {
        self.window_from != WindowFrom::Default
    }

    /// Whether some averaging window would alias white noise, by half a percent or more: none does
    /// where the sensor sends every refresh.
    pub fn aliases(&self) -> bool {
        const NEGLIGIBLE: f64 = 1.005;
        self.window.decimation.max(1.0).sqrt() >= NEGLIGIBLE
    }

    /// The window that would bring the sensor's own density into the stream.
    pub fn unaliased_window(&self) -> u32 {
        self.window.decimation.round() as u32
    }

    /// Correlation time in samples that the low pass of accelerometer and gyroscope, with their window,
    /// makes of neighbouring outputs; `None` where these are independent, or where a long window that overlaps says more.
    ///
    /// The low pass is not documented: one second of a real sensor's output has autocorrelations of
    /// 0.83, 0.49, 0.17, -0.02, -0.05 (gyro) and 0.86, 0.60, 0.35, 0.14, 0.08 (accelerometer) at
    /// lags of 1.25 ms, behind a window of four of them.
    pub(super) fn own_low_pass(&self) -> Option<f64> {
        (self.refresh_hz == IMU_REFRESH_HZ).then(|| Self::low_pass_of(self.window, self.rate_hz)).flatten()
    }

    /// The same of a window on gyro or accelerometer, for outputs at this rate.
    fn low_pass_of(window: BoxcarWindow, rate_hz: f64) -> Option<f64> {
        /// Refreshes after which the low pass has forgotten.
        const MEMORY: f64 = 3.0;
        /// Refreshes averaged from which on the window says more.
        const LONG: f64 = 8.0;
        /// Refreshes averaged from which on neighbours are alike to less than 0.3 %.
        const NEGLIGIBLE: f64 = 160.0;
        /// Of the shortest window and low pass together, more than was measured.
        const CORRELATION_S: f64 = 0.005;
        let length = f64::from(window.length.max(1));
        let between = window.decimation.max(1.0) - length;
        let is_modelled = length >= LONG && between < 0.0;
        (between < MEMORY && !is_modelled && length < NEGLIGIBLE).then_some(1.0 + CORRELATION_S * rate_hz)
    }

    /// For a channel of a sensor of this make that is averaged on board.
    pub(super) fn of(channel: &Channel, results: &ChannelSnapshot, snapshot: &Snapshot) -> Option<Self> {
        let layout = snapshot.layout.as_ref().filter(|layout| !rates_hz(Some(layout)).is_empty())?;
        let filter: Option<ImuFilter> = snapshot.register(Register::IMU_FILTER);
        let averaging = filter.unwrap_or_default();
        // a user knows of one window alone
        let given =
            snapshot.settings.window.filter(|_| filter.is_none() && channel.quantity != Quantity::MagneticField);
        let (refresh_hz, window, mode) = match channel.quantity {
            Quantity::MagneticField => (Self::MAG_REFRESH_HZ, averaging.mag_window, averaging.mag_mode),
            Quantity::Acceleration => (IMU_REFRESH_HZ, averaging.accel_window, averaging.accel_mode),
            Quantity::AngularRate => (IMU_REFRESH_HZ, averaging.gyro_window, averaging.gyro_mode),
            _ => return None,
        };
        // bits of the mode: 1 averages the uncompensated values, 2 the compensated ones
        let averaged = mode & if layout.compensated == Some(false) { 1 } else { 2 } != 0;
        let length = if averaged { given.unwrap_or(window.into()) } else { 1 };
        let rate_hz = snapshot.rate_of(results);
        let decimation = refresh_hz / rate_hz;
        if channel.increment_step.is_some() {
            let window = BoxcarWindow { length: decimation.round() as u32, decimation };
            return Some(Self { refresh_hz, rate_hz, window, window_from: WindowFrom::Integrated });
        }
        let window_from = match (filter, given) {
            (Some(_), _) => WindowFrom::Register,
            (None, Some(_)) => WindowFrom::Given,
            (None, None) => WindowFrom::Default,
        };
        Some(Self { refresh_hz, rate_hz, window: BoxcarWindow { length, decimation }, window_from })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_that_covers_all_refreshes_leaves_no_uncertainty() {
        let uncertainty = |length| Onboard::uncertainty_of(BoxcarWindow { length, decimation: 20.0 });
        assert_eq!((uncertainty(20), uncertainty(4)), (0.0, Onboard::UNCERTAINTY));
    }

    #[test]
    fn a_low_pass_shows_between_short_windows_that_are_close() {
        let shows = |length, decimation| Onboard::low_pass_of(BoxcarWindow { length, decimation }, 200.0).is_some();
        for (length, decimation) in [(4, 4.0), (4, 6.5), (7, 2.0), (8, 8.0), (159, 159.0)] {
            assert!(shows(length, decimation), "{length} of {decimation} refreshes");
        }
        for (length, decimation, why) in
            [(4, 7.0, "forgotten between"), (8, 7.0, "the windows overlap"), (160, 160.0, "too long to show it")]
        {
            assert!(!shows(length, decimation), "{length} of {decimation} refreshes: {why}");
        }
    }
}
