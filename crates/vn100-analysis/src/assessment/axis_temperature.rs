//! What is known of an axis and the temperature of the sensor.

use imu_noise::{NoCoefficient, TemperatureCoefficient};

/// Share of the temperature in an octave of the level from which on it would be taken for noise.
const POSES_AS_NOISE: f64 = 0.1;

/// How the bias of one axis follows the temperature of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisTemperature {
    /// From the lowest to the highest mean of a block, in °C; `None` where there were too few.
    pub excursion_c: Option<f64>,
    /// Of the temperature with time, -1 to 1; likewise.
    pub correlation_with_time: Option<f64>,
    /// The temperature was asked for between the rows.
    pub is_polled: bool,
    /// In the unit of the channel per °C, or why there is none.
    pub coefficient: Result<TemperatureCoefficient, NoCoefficient>,
    /// The axes of the record together (Holm) prove that this one follows the temperature.
    pub is_proved: bool,
}

impl AxisTemperature {
    /// The share of the temperature in the level, if bias instability, random walk and ramp would be
    /// fitted to what the temperature made: it is proved, and above a tenth.
    pub fn share_as_noise(&self) -> Option<f64> {
        let coefficient = self.coefficient.ok().filter(|_| self.is_proved)?;
        Some(coefficient.largest_share).filter(|share| *share > POSES_AS_NOISE)
    }
}
