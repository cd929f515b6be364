//! Which program the sensor runs.

/// The program of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Firmware {
    /// 2.1.0.0
    V2_1,
    /// 3.1.0.0
    #[default]
    V3_1,
}
