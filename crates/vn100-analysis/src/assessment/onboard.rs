//! Averaging and decimation inside the sensor.

use imu_noise::BoxcarWindow;
use vn100_protocol::{Channel, ImuFilter, Quantity, Register, RegisterContents, RegisterFields};

use crate::{accumulate::rate_authority::rates_hz, snapshot::Snapshot};

/// Refreshes of gyroscope and accelerometer per second.
const IMU_REFRESH_HZ: f64 = 800.0;

/// Averaging and decimation inside a VN-100, for one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Onboard {
    /// Refreshes of the channel's sensor per second.
    pub refresh_hz: f64,
    /// The averaging window and the decimation.
    pub window: BoxcarWindow,
    /// The window is that of register 85; otherwise it is the sensor's default.
    pub window_known: bool,
}

impl Onboard {
    /// Refreshes of the magnetometer per second.
    pub const MAG_REFRESH_HZ: f64 = 250.0;

    /// How far the factor may be off, relative, as the sensor's own roll-off is not known: measured
    /// at 40 Hz with a window of four refreshes were 2.17 to 2.47 where the formula gives 2.236.
    pub const UNCERTAINTY: f64 = 0.10;

    /// [`UNCERTAINTY`](Self::UNCERTAINTY) where white noise folds. Where the windows cover all
    /// refreshes evenly, the density at low frequencies stays as it is, whatever the roll-off.
    #[must_use]
    pub fn uncertainty_of(window: BoxcarWindow) -> f64 {
        const EXACT: f64 = 1e-9;
        if window.white_factor() < 1.0 + EXACT { 0.0 } else { Self::UNCERTAINTY }
    }

    /// Density of white noise in the stream over the sensor's own.
    #[must_use]
    pub fn white_factor(&self) -> f64 {
        self.window.white_factor()
    }

    /// The window that would bring the sensor's own density into the stream.
    #[must_use]
    pub fn unaliased_window(&self) -> u32 {
        self.window.decimation.round() as u32
    }

    /// For a channel of a sensor of this make that is averaged on board.
    pub(super) fn of(channel: &Channel, snapshot: &Snapshot) -> Option<Self> {
        let layout = snapshot.layout.as_ref().filter(|layout| !rates_hz(Some(layout)).is_empty())?;
        let filter = filter(snapshot);
        let averaging = filter.unwrap_or_default();
        let (refresh_hz, window, mode) = match channel.quantity {
            Quantity::MagneticField => (Self::MAG_REFRESH_HZ, averaging.mag_window, averaging.mag_mode),
            Quantity::Acceleration => (IMU_REFRESH_HZ, averaging.accel_window, averaging.accel_mode),
            Quantity::AngularRate => (IMU_REFRESH_HZ, averaging.gyro_window, averaging.gyro_mode),
            Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure => return None,
        };
        // bits of the mode: 1 averages the uncompensated values, 2 the compensated ones
        let averaged = mode & if layout.compensated { 2 } else { 1 } != 0;
        let length = if averaged { window.into() } else { 1 };
        let decimation = refresh_hz / snapshot.timing.rate_hz;
        let window_known = filter.is_some();
        Some(Self { refresh_hz, window: BoxcarWindow { length, decimation }, window_known })
    }
}

fn filter(snapshot: &Snapshot) -> Option<ImuFilter> {
    let register = Register::IMU_FILTER;
    let fields = RegisterFields::new(snapshot.registers.get(&register.0)?.as_str()).ok()?;
    RegisterContents { register, fields }.value().ok()
}
