//! Registers 1 to 4: which sensor this is.

use alloc::{borrow::ToOwned, string::String};
use core::fmt;

use super::{
    Register, RegisterContents, RegisterValue, ValueError,
    field_reader::{FieldReader, integer},
};

/// Register 1: the product name, such as `VN-100S-CR`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Model(pub String);

impl Model {
    /// Whether it is a VN-100 of any kind, and not a sister product with satellite navigation.
    #[must_use]
    pub fn is_vn100(&self) -> bool {
        self.0.starts_with("VN-100")
    }
}

impl RegisterValue for Model {
    const REGISTERS: &'static [Register] = &[Register::MODEL];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let name = fields.value("model", "a name", |text| (!text.is_empty()).then(|| text.to_owned()))?;
        fields.end()?;
        Ok(Self(name))
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Register 2: the revision of the hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HardwareRevision {
    /// The revision.
    pub major: u32,
    /// What some sensors print behind a point.
    pub minor: Option<u32>,
}

impl RegisterValue for HardwareRevision {
    const REGISTERS: &'static [Register] = &[Register::HARDWARE_REVISION];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let revision =
            fields.value("revision", "a whole number, or two with a point", |text| match text.split_once('.') {
                Some((major, minor)) => Some(Self { major: integer(major)?, minor: Some(integer(minor)?) }),
                None => Some(Self { major: integer(text)?, minor: None }),
            })?;
        fields.end()?;
        Ok(revision)
    }
}

impl fmt::Display for HardwareRevision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.major.fmt(f)?;
        self.minor.map_or(Ok(()), |minor| write!(f, ".{minor}"))
    }
}

/// Register 3: the serial number; displays with ten digits, as the sensor prints it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SerialNumber(pub u32);

impl RegisterValue for SerialNumber {
    const REGISTERS: &'static [Register] = &[Register::SERIAL_NUMBER];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let number = fields.integer("serial number")?;
        fields.end()?;
        Ok(Self(number))
    }
}

impl fmt::Display for SerialNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:010}", self.0)
    }
}

/// Register 4: the version of the firmware, such as 3.1.0.0; versions compare in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Firmware(pub [u32; 4]);

impl Firmware {
    /// The first number, which tells the two worlds of this sensor apart: 2 and earlier, 3 and
    /// later.
    #[must_use]
    pub fn major(&self) -> u32 {
        self.0[0]
    }
}

impl RegisterValue for Firmware {
    const REGISTERS: &'static [Register] = &[Register::FIRMWARE];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let version = fields.value("version", "four whole numbers with points between them", |text| {
            let mut parts = text.split('.');
            let mut numbers = [0; 4];
            for number in &mut numbers {
                *number = integer(parts.next()?)?;
            }
            parts.next().is_none().then_some(Self(numbers))
        })?;
        fields.end()?;
        Ok(version)
    }
}

impl fmt::Display for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c, d] = self.0;
        write!(f, "{a}.{b}.{c}.{d}")
    }
}
