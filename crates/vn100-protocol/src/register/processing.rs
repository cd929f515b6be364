//! Registers 35 and 85: what happens to the samples before they are sent.

use core::fmt;

use super::{
    Register, RegisterContents, RegisterValue, ValueError, WritableValue, field_reader::FieldReader, write_list,
};

/// Register 35: the modes of the attitude filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VpeControl {
    /// 1 on, 0 off; reserved in firmware 3.
    pub enable: u8,
    /// Where the heading comes from: 0 the magnetometer is trusted, 1 relative, 2 indoor.
    pub heading_mode: u8,
    /// Filtering: 0 none, 1 adaptive.
    pub filtering_mode: u8,
    /// Tuning: 0 fixed, 1 adaptive.
    pub tuning_mode: u8,
}

impl RegisterValue for VpeControl {
    const REGISTERS: &'static [Register] = &[Register::VPE_CONTROL];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let control = Self {
            enable: fields.integer("enable")?,
            heading_mode: fields.integer("heading mode")?,
            filtering_mode: fields.integer("filtering mode")?,
            tuning_mode: fields.integer("tuning mode")?,
        };
        fields.end()?;
        Ok(control)
    }
}

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

/// As sold: four samples of acceleration, angular rate and temperature.
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

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
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
        fields.end()?;
        Ok(Self { window, mode })
    }
}

impl WritableValue for ImuFilter {
    fn register(&self) -> Register {
        Register::IMU_FILTER
    }
}

impl fmt::Display for ImuFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { window, mode } = self;
        write_list(f, [window.mag, window.accel, window.gyro, window.temperature, window.pressure])?;
        f.write_str(",")?;
        write_list(f, [mode.mag, mode.accel, mode.gyro, mode.temperature, mode.pressure])
    }
}
