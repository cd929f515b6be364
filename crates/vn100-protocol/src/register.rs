//! The registers of the sensor: their numbers, and the common properties of their values.

pub(crate) mod fields;
mod port;
mod values;

use alloc::string::{String, ToString};
use core::fmt;

use thiserror::Error;

pub use self::{
    port::{AsyncRate, AsyncType, BaudRate},
    values::{BinaryOutput, ImuFilter, ProtocolControl, ReferenceFrameRotation, SyncControl},
};
use crate::register::fields::{FieldReader, RegisterFields};

/// The number of a register; displays with at least two digits, as on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Register(pub u8);

/// The contents of a register, as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegisterContents {
    /// The register.
    pub register: Register,
    /// Its fields.
    pub fields: RegisterFields,
}

/// A value contained in one register, or in several of a kind.
pub trait RegisterValue: Sized {
    /// The registers that contain such a value.
    const REGISTERS: &'static [Register];

    /// Reads the fields of the value.
    #[doc(hidden)]
    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError>;
}

/// A value that can be written; displays as its fields, separated by commas.
pub trait WritableValue: RegisterValue + fmt::Display {
    /// The register to write the value to.
    fn register(&self) -> Register {
        Self::REGISTERS[0]
    }

    /// The fields to write.
    fn fields(&self) -> RegisterFields {
        RegisterFields::trusted(self.to_string())
    }
}

/// The contents of a register are not the expected value.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("register {register}: {problem}")]
pub struct ValueError {
    /// The register.
    pub register: Register,
    /// The field, and what is wrong with it.
    pub problem: String,
}

/// Number, name and meaning of each register that has a constant.
macro_rules! registers {
    ($($constant:ident = $number:literal, $name:literal, $meaning:literal;)*) => {
        impl Register {
            $(#[doc = concat!("Register ", $number, ", ", $name, ": ", $meaning, ".")]
            pub const $constant: Self = Self($number);)*

            /// The name of the register; `None` if it is not known here.
            pub fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some($name),)*
                    _ => None,
                }
            }

        }
    };
}

registers! {
    MODEL = 1, "model", "the product name, such as VN-100S-CR";
    HARDWARE_REVISION = 2, "hardware revision", "the revision of the circuit board";
    SERIAL_NUMBER = 3, "serial number", "the number of this very sensor";
    FIRMWARE = 4, "firmware", "the version of the firmware";
    BAUD_RATE = 5, "baud rate", "bits per second of the port";
    ASYNC_TYPE = 6, "async type", "the message that the port sends of itself";
    ASYNC_RATE = 7, "async rate", "how often it sends that message, in hertz";
    REFERENCE_VECTORS = 21, "reference vectors", "the magnetic field and gravity that the attitude filter expects";
    MAG_CALIBRATION = 23, "magnetometer calibration", "the user's matrix and offset for the magnetic field";
    ACCEL_CALIBRATION = 25, "accelerometer calibration", "the user's matrix and offset for the acceleration";
    ROTATION = 26, "reference frame rotation", "from the axes of the sensor to those of the vehicle";
    PROTOCOL_CONTROL = 30, "protocol control", "suffix fields, checksums and error reports of the port";
    SYNC_CONTROL = 32, "synchronisation control", "what the SyncIn and SyncOut pins do";
    VPE_CONTROL = 35, "attitude filter", "the modes of the attitude filter";
    STARTUP_GYRO_BIAS = 43, "start-up gyro bias", "the bias of the angular rate that the filter starts with";
    HSI_CONTROL = 44, "magnetometer self-calibration", "whether it runs, and whether its result is used";
    HSI_RESULT = 47, "magnetometer self-calibration result", "the matrix and offset that the sensor has found";
    IMU = 54, "IMU", "the uncompensated magnetic field, acceleration and angular rate, temperature, pressure";
    BINARY_OUTPUT_1 = 75, "binary output 1", "the first stream of binary packets";
    BINARY_OUTPUT_2 = 76, "binary output 2", "the second stream of binary packets";
    BINARY_OUTPUT_3 = 77, "binary output 3", "the third stream of binary packets";
    DELTA_SETTINGS = 82, "delta settings", "the frame and the compensation of these changes";
    REFERENCE_MODEL = 83, "reference model", "whether magnetic field and gravity come from a model of the Earth";
    GYRO_CALIBRATION = 84, "gyro calibration", "the user's matrix and offset for the angular rate";
    IMU_FILTER = 85, "IMU filter", "how many 800 Hz samples are averaged";
}

impl RegisterContents {
    /// The value of the fields, as the sensor sends them in the reply to a read or a write.
    ///
    /// # Errors
    /// For the contents of another register, too few or too many fields, and a field of another form.
    pub fn value<T: RegisterValue>(&self) -> Result<T, ValueError> {
        let mut fields = FieldReader::of::<T>(self)?;
        let value = T::read(&mut fields)?;
        fields.end()?;
        Ok(value)
    }

    /// Whether these can be the contents after a write of `fields`: the sensor may print numbers
    /// differently, and registers 5 to 7 may name their port.
    pub fn is_as_written(&self, fields: &RegisterFields) -> bool {
        let names_port = matches!(self.register, Register::BAUD_RATE | Register::ASYNC_TYPE | Register::ASYNC_RATE);
        fields.means(&self.fields, usize::from(names_port))
    }
}

impl fmt::Display for Register {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02}", self.0)
    }
}
