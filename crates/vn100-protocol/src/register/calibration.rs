//! Registers 23, 25, 26, 43 and 84: how this sensor was calibrated and mounted.

use super::{Register, RegisterValue, ValueError, field_reader::FieldReader};

/// Registers 23, 25 and 84: the user's calibration of one sensor, y = C (x - b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// C by rows.
    pub matrix: [[f32; 3]; 3],
    /// b along x, y, z: gauss, m/s² or rad/s.
    pub offset: [f32; 3],
}

impl RegisterValue for Calibration {
    const REGISTERS: &'static [Register] =
        &[Register::MAG_CALIBRATION, Register::ACCEL_CALIBRATION, Register::GYRO_CALIBRATION];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { matrix: matrix(fields)?, offset: fields.floats("offset")? })
    }
}

/// Register 26: from the axes of the sensor to those of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFrameRotation {
    /// The matrix by rows.
    pub matrix: [[f32; 3]; 3],
}

impl RegisterValue for ReferenceFrameRotation {
    const REGISTERS: &'static [Register] = &[Register::ROTATION];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { matrix: matrix(fields)? })
    }
}

/// Register 43: the bias of the angular rate that the attitude filter starts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartupGyroBias {
    /// About x, y, z in rad/s.
    pub bias_rad_s: [f32; 3],
}

impl RegisterValue for StartupGyroBias {
    const REGISTERS: &'static [Register] = &[Register::STARTUP_GYRO_BIAS];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        Ok(Self { bias_rad_s: fields.floats("bias")? })
    }
}

fn matrix(fields: &mut FieldReader<'_>) -> Result<[[f32; 3]; 3], ValueError> {
    Ok([fields.floats("matrix")?, fields.floats("matrix")?, fields.floats("matrix")?])
}
