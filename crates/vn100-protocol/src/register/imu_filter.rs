//! Register 85: the moving average of the samples before they are sent.

use core::fmt;

use super::{Register, RegisterValue, ValueError, WritableValue, field_reader::FieldReader, write_list};

/// One number for each sensor inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PerSensor<T> {
    /// The magnetometer.
    pub mag: T,
    /// The accelerometer.
    pub accel: T,
    /// The gyro.
    pub gyro: T,
    /// The thermometer.
    pub temperature: T,
    /// The barometer.
    pub pressure: T,
}

/// Register 85: the moving average of the 800 Hz samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ImuFilter {
    /// The samples averaged; 0 and 1 are none but the last.
    pub window: PerSensor<u16>,
    /// Which values are averaged: 0 none, 1 the uncompensated, 2 the compensated, 3 both.
    pub mode: PerSensor<u8>,
}

/// The factory default: four samples of acceleration, angular rate and temperature.
impl Default for ImuFilter {
    fn default() -> Self {
        Self {
            window: PerSensor { mag: 0, accel: 4, gyro: 4, temperature: 4, pressure: 0 },
            mode: PerSensor { mag: 0, accel: 3, gyro: 3, temperature: 3, pressure: 0 },
        }
    }
}

impl RegisterValue for ImuFilter {
    const REGISTERS: &'static [Register] = &[Register::IMU_FILTER];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        let window = PerSensor {
            mag: fields.integer("magnetometer window")?,
            accel: fields.integer("accelerometer window")?,
            gyro: fields.integer("gyro window")?,
            temperature: fields.integer("temperature window")?,
            pressure: fields.integer("pressure window")?,
        };
        let mode = PerSensor {
            mag: fields.integer("magnetometer mode")?,
            accel: fields.integer("accelerometer mode")?,
            gyro: fields.integer("gyro mode")?,
            temperature: fields.integer("temperature mode")?,
            pressure: fields.integer("pressure mode")?,
        };
        Ok(Self { window, mode })
    }
}

impl WritableValue for ImuFilter {}

impl fmt::Display for ImuFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { window, mode } = self;
        write_list(f, [window.mag, window.accel, window.gyro, window.temperature, window.pressure])?;
        f.write_str(",")?;
        write_list(f, [mode.mag, mode.accel, mode.gyro, mode.temperature, mode.pressure])
    }
}
