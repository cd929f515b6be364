//! The registers of the sensor: their numbers, and the common properties of their values.

pub(crate) mod fields;
mod port;
mod values;

use alloc::string::{String, ToString};
use core::fmt;

use thiserror::Error;

pub use self::{
    port::{AsyncRate, AsyncType, BaudRate},
    values::{
        BinaryOutput, Calibration, ImuFilter, ProtocolControl, ReferenceFrameRotation, StartupGyroBias, SyncControl,
        VpeControl,
    },
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

/// The reason why the contents of a register are not the expected value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ValueError {
    /// The contents are of another register.
    #[error("register {found} does not have this value; register {} does", .expected[0])]
    Register {
        /// The registers that contain the value.
        expected: &'static [Register],
        /// The register of the contents.
        found: Register,
    },
    /// The contents have fewer fields than the value.
    #[error("register {register} lacks the field {name:?}")]
    Missing {
        /// The register.
        register: Register,
        /// The first field that is missing.
        name: &'static str,
    },
    /// The contents have more fields than the value.
    #[error("register {register} has more fields than are known, from {text:?} on")]
    Surplus {
        /// The register.
        register: Register,
        /// The first field that is too many.
        text: String,
    },
    /// A field does not have the expected form.
    #[error("register {register}: {name} is {text:?}, expected {expected}")]
    Field {
        /// The register.
        register: Register,
        /// The name of the field.
        name: &'static str,
        /// The text of the field.
        text: String,
        /// The expected form.
        expected: &'static str,
    },
}

/// Number, name and meaning of each register that has a constant.
macro_rules! registers {
    ($($constant:ident = $number:literal, $name:literal, $meaning:literal;)*) => {
        impl Register {
            $(#[doc = concat!("Register ", $number, ", ", $name, ": ", $meaning, ".")]
            pub const $constant: Self = Self($number);)*

            /// The name of the register; `None` if it is not known here.
            #[must_use]
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
    USER_TAG = 0, "user tag", "a text of the user's, up to 20 characters";
    MODEL = 1, "model", "the product name, such as VN-100S-CR";
    HARDWARE_REVISION = 2, "hardware revision", "the revision of the circuit board";
    SERIAL_NUMBER = 3, "serial number", "the number of this very sensor";
    FIRMWARE = 4, "firmware", "the version of the firmware";
    BAUD_RATE = 5, "baud rate", "bits per second of the port";
    ASYNC_TYPE = 6, "async type", "the message that the port sends of itself";
    ASYNC_RATE = 7, "async rate", "how often it sends that message, in hertz";
    YPR = 8, "attitude", "yaw, pitch, roll";
    QUATERNION = 9, "quaternion", "the attitude as a quaternion, scalar last";
    QMR = 15, "QMR", "quaternion and the compensated magnetic field, acceleration and angular rate";
    MAG = 17, "magnetic field", "the compensated magnetic field";
    ACCEL = 18, "acceleration", "the compensated acceleration";
    GYRO = 19, "angular rate", "the compensated angular rate";
    MAR = 20, "MAR", "the compensated magnetic field, acceleration and angular rate";
    REFERENCE_VECTORS = 21, "reference vectors", "the magnetic field and gravity that the attitude filter expects";
    MAG_CALIBRATION = 23, "magnetometer calibration", "the user's matrix and offset for the magnetic field";
    ACCEL_CALIBRATION = 25, "accelerometer calibration", "the user's matrix and offset for the acceleration";
    ROTATION = 26, "reference frame rotation", "from the axes of the sensor to those of the vehicle";
    YMR = 27, "YMR", "attitude and the compensated magnetic field, acceleration and angular rate";
    PROTOCOL_CONTROL = 30, "protocol control", "suffix fields, checksums and error reports of the port";
    SYNC_CONTROL = 32, "synchronisation control", "what the SyncIn and SyncOut pins do";
    SYNC_STATUS = 33, "synchronisation status", "the counts of the SyncIn and SyncOut pins";
    VPE_CONTROL = 35, "attitude filter", "the modes of the attitude filter";
    VPE_MAG_TUNING = 36, "magnetometer tuning", "how far the attitude filter trusts the magnetometer";
    VPE_ACCEL_TUNING = 38, "accelerometer tuning", "how far the attitude filter trusts the accelerometer";
    STARTUP_GYRO_BIAS = 43, "start-up gyro bias", "the bias of the angular rate that the filter starts with";
    HSI_CONTROL = 44, "magnetometer self-calibration", "whether it runs, and whether its result is used";
    HSI_RESULT = 47, "magnetometer self-calibration result", "the matrix and offset that the sensor has found";
    IMU = 54, "IMU", "the uncompensated magnetic field, acceleration and angular rate, temperature, pressure";
    BINARY_OUTPUT_1 = 75, "binary output 1", "the first stream of binary packets";
    BINARY_OUTPUT_2 = 76, "binary output 2", "the second stream of binary packets";
    BINARY_OUTPUT_3 = 77, "binary output 3", "the third stream of binary packets";
    DELTA = 80, "delta", "change of angle and of velocity since it was last read";
    DELTA_SETTINGS = 82, "delta settings", "the frame and the compensation of these changes";
    REFERENCE_MODEL = 83, "reference model", "whether magnetic field and gravity come from a model of the Earth";
    GYRO_CALIBRATION = 84, "gyro calibration", "the user's matrix and offset for the angular rate";
    IMU_FILTER = 85, "IMU filter", "how many 800 Hz samples are averaged";
    HEAVE = 115, "heave", "vertical motion; firmware 3";
    HEAVE_SETTINGS = 116, "heave settings", "the filter of the vertical motion; firmware 3";
    LEGACY_COMPATIBILITY = 206, "legacy compatibility", "old behaviour under firmware 3";
    YBA = 239, "YBA", "attitude, linear acceleration along the body's axes, angular rate";
    YIA = 240, "YIA", "attitude, linear acceleration along north, east, down, angular rate";
}

impl RegisterContents {
    /// The value of the fields, as the sensor sends them in the reply to a read or a write.
    ///
    /// # Errors
    /// [`ValueError`] for the contents of another register, for too few or too many fields, and for
    /// a field that does not have the expected form.
    pub fn value<T: RegisterValue>(&self) -> Result<T, ValueError> {
        let mut fields = FieldReader::of::<T>(self)?;
        let value = T::read(&mut fields)?;
        fields.end()?;
        Ok(value)
    }

    /// Whether these can be the contents after a write of `fields`: the sensor may print numbers
    /// differently, and registers 5 to 7 may name their port.
    #[must_use]
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
