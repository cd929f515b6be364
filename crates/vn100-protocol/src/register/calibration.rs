//! Registers 21, 23, 25, 26, 43, 44, 47 and 84: what is known of this sensor and of where it is.

use core::fmt;

use super::{Register, RegisterContents, RegisterValue, Setting, ValueError, field_reader::FieldReader, write_list};

/// Register 21: what the attitude filter expects to measure at rest, along north, east, down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceVectors {
    /// The magnetic field in gauss.
    pub mag_gauss: [f32; 3],
    /// The acceleration in m/s².
    pub accel_m_s2: [f32; 3],
}

impl RegisterValue for ReferenceVectors {
    const REGISTERS: &'static [Register] = &[Register::REFERENCE_VECTORS];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let vectors = Self { mag_gauss: fields.floats("magnetic field")?, accel_m_s2: fields.floats("acceleration")? };
        fields.end()?;
        Ok(vectors)
    }
}

impl Setting for ReferenceVectors {
    fn register(&self) -> Register {
        Register::REFERENCE_VECTORS
    }
}

impl fmt::Display for ReferenceVectors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, self.mag_gauss.iter().chain(&self.accel_m_s2))
    }
}

/// The sensors that a user can calibrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CalibratedSensor {
    /// Register 23.
    Magnetometer,
    /// Register 25.
    Accelerometer,
    /// Register 84.
    Gyro,
}

/// Registers 23, 25 and 84: the user's calibration of one sensor, y = C (x - b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Which sensor.
    pub sensor: CalibratedSensor,
    /// C by rows.
    pub matrix: [[f32; 3]; 3],
    /// b along x, y, z: gauss, m/s² or rad/s.
    pub offset: [f32; 3],
}

impl RegisterValue for Calibration {
    const REGISTERS: &'static [Register] =
        &[Register::MAG_CALIBRATION, Register::ACCEL_CALIBRATION, Register::GYRO_CALIBRATION];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let sensor = match contents.register {
            Register::MAG_CALIBRATION => CalibratedSensor::Magnetometer,
            Register::ACCEL_CALIBRATION => CalibratedSensor::Accelerometer,
            _ => CalibratedSensor::Gyro,
        };
        let calibration = Self { sensor, matrix: matrix(&mut fields)?, offset: fields.floats("offset")? };
        fields.end()?;
        Ok(calibration)
    }
}

impl Setting for Calibration {
    fn register(&self) -> Register {
        match self.sensor {
            CalibratedSensor::Magnetometer => Register::MAG_CALIBRATION,
            CalibratedSensor::Accelerometer => Register::ACCEL_CALIBRATION,
            CalibratedSensor::Gyro => Register::GYRO_CALIBRATION,
        }
    }
}

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, self.matrix.as_flattened().iter().chain(&self.offset))
    }
}

/// Register 26: from the axes of the sensor to those of the vehicle.
///
/// A new matrix must be orthonormal to 1e-5, and acts only when it has been saved and the sensor
/// restarted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFrameRotation {
    /// The matrix by rows.
    pub matrix: [[f32; 3]; 3],
}

impl RegisterValue for ReferenceFrameRotation {
    const REGISTERS: &'static [Register] = &[Register::ROTATION];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let rotation = Self { matrix: matrix(&mut fields)? };
        fields.end()?;
        Ok(rotation)
    }
}

impl Setting for ReferenceFrameRotation {
    fn register(&self) -> Register {
        Register::ROTATION
    }
}

impl fmt::Display for ReferenceFrameRotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, self.matrix.as_flattened())
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

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let bias = Self { bias_rad_s: fields.floats("bias")? };
        fields.end()?;
        Ok(bias)
    }
}

impl Setting for StartupGyroBias {
    fn register(&self) -> Register {
        Register::STARTUP_GYRO_BIAS
    }
}

impl fmt::Display for StartupGyroBias {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, self.bias_rad_s)
    }
}

/// Register 44: the magnetometer's self-calibration against iron in its vicinity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct HsiControl {
    /// 0 off, 1 runs, 2 starts anew.
    pub mode: u8,
    /// Whether its result is used: 1 no, 3 yes.
    pub output: u8,
    /// How fast it follows, 1 slow to 5 fast.
    pub convergence: u8,
}

impl RegisterValue for HsiControl {
    const REGISTERS: &'static [Register] = &[Register::HSI_CONTROL];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let control = Self {
            mode: fields.integer("mode")?,
            output: fields.integer("output")?,
            convergence: fields.integer("convergence")?,
        };
        fields.end()?;
        Ok(control)
    }
}

impl Setting for HsiControl {
    fn register(&self) -> Register {
        Register::HSI_CONTROL
    }
}

impl fmt::Display for HsiControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, [self.mode, self.output, self.convergence])
    }
}

/// Register 47: what the self-calibration has found, y = C (x - b). It cannot be written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HsiResult {
    /// C by rows.
    pub matrix: [[f32; 3]; 3],
    /// b along x, y, z in gauss.
    pub offset_gauss: [f32; 3],
}

impl RegisterValue for HsiResult {
    const REGISTERS: &'static [Register] = &[Register::HSI_RESULT];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let result = Self { matrix: matrix(&mut fields)?, offset_gauss: fields.floats("offset")? };
        fields.end()?;
        Ok(result)
    }
}

fn matrix(fields: &mut FieldReader<'_>) -> Result<[[f32; 3]; 3], ValueError> {
    Ok([fields.floats("matrix")?, fields.floats("matrix")?, fields.floats("matrix")?])
}
