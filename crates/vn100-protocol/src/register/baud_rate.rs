//! Register 5: the speed of the port.

use core::fmt;

use super::{
    Register, RegisterValue, ValueError, WritableValue,
    field_reader::{FieldReader, integer},
};

/// Bits per second of a port, one of the nine that the sensor has.
///
/// The sensor answers a write at the old rate and goes over to the new one then. Eight data bits,
/// no parity, one stop bit: ten bits a byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BaudRate(u32);

impl BaudRate {
    /// All of them, the slowest first.
    pub const ALL: [Self; 9] = [
        Self(9_600),
        Self(19_200),
        Self(38_400),
        Self(57_600),
        Self(115_200),
        Self(128_000),
        Self(230_400),
        Self(460_800),
        Self(921_600),
    ];
    /// What a sensor is sold with: 115200.
    pub const DEFAULT: Self = Self(115_200);

    /// This many bits per second; `None` for a rate that the sensor does not have.
    #[must_use]
    pub fn new(bits_per_s: u32) -> Option<Self> {
        Some(Self(bits_per_s)).filter(|rate| Self::ALL.contains(rate))
    }

    /// Bits per second.
    #[must_use]
    pub fn bits_per_s(self) -> u32 {
        self.0
    }

    /// Bytes per second, of ten bits each.
    #[must_use]
    pub fn bytes_per_s(self) -> u32 {
        self.0 / 10
    }
}

impl RegisterValue for BaudRate {
    const REGISTERS: &'static [Register] = &[Register::BAUD_RATE];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        let rate = fields.value("baud rate", "one of the nine rates from 9600 to 921600", |text| {
            integer(text).and_then(Self::new)
        })?;
        fields.optional_port()?;
        Ok(rate)
    }
}

impl WritableValue for BaudRate {}

impl fmt::Display for BaudRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
