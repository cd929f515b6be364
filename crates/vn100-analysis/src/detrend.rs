//! What is removed from a channel.

/// What is removed from a channel before its deviation is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detrend {
    /// The regression line.
    Line,
    /// Of gyroscopes and accelerometers what follows the temperature of the sensor, where the
    /// record proves that something does.
    Temperature,
}

imu_noise::encoded!(Detrend = Detrend::Line, Detrend::Temperature);
