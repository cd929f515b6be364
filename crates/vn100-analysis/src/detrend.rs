//! What is removed from a channel.

/// What is removed from a channel before its deviation is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detrend {
    /// The regression line of the channel.
    Line,
    /// Of gyroscopes and accelerometers the contribution of the temperature of the sensor, where it
    /// is statistically significant in the record.
    Temperature,
}
