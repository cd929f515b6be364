//! Registers 5 to 7: the baud rate of a port, its asynchronous output, and the rate of that output.

use core::fmt;

use super::{
    Register, RegisterValue, ValueError, WritableValue,
    fields::{FieldReader, integer},
};
use crate::message::layout::OUTPUT_RATES_HZ;

/// The baud rate of a port in bit/s, one of the nine that the sensor has.
///
/// The sensor replies to a write at the old rate and then changes to the new one. Eight data bits,
/// no parity, one stop bit: ten bits per byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BaudRate(u32);

impl BaudRate {
    /// All baud rates, the slowest first.
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
    /// The factory default: 115200.
    pub const DEFAULT: Self = Self(115_200);

    /// The baud rate of this many bit/s; `None` if the sensor does not have it.
    pub fn new(bits_per_s: u32) -> Option<Self> {
        Some(Self(bits_per_s)).filter(|rate| Self::ALL.contains(rate))
    }

    /// The rate in bit/s.
    pub fn bits_per_s(self) -> u32 {
        self.0
    }

    /// The rate in bytes per second, of ten bits each, rounded down.
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

/// The message that a port sends by itself, by the code in register 6.
///
/// A code without a constant here, such as that of a sister product, can be read and written as
/// well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AsyncType(pub u8);

struct AsyncMessage {
    code: AsyncType,
    header: &'static str,
    usual_length: Option<u32>,
    description: &'static str,
}

/// Code, header, usual length and content of each message.
macro_rules! messages {
    ($($constant:ident = $code:literal, $header:literal, $usual_length:expr, $description:literal;)*) => {
        impl AsyncType {
            $(#[doc = concat!("`$", $header, "`: ", $description, ".")]
            pub const $constant: Self = Self($code);)*
        }

        const MESSAGES: [AsyncMessage; [$($code),*].len()] = [$(AsyncMessage {
            code: AsyncType::$constant,
            header: $header,
            usual_length: $usual_length,
            description: $description,
        }),*];
    };
}

// The lengths are those of the recorded print widths; the IMU message has the wider of the two
// reported pressures.
messages! {
    YPR = 1, "VNYPR", Some(38), "attitude";
    QTN = 2, "VNQTN", Some(51), "attitude as a quaternion";
    QMR = 8, "VNQMR", Some(135), "quaternion, magnetic field, acceleration, angular rate";
    DCM = 9, "VNDCM", None, "attitude as a rotation matrix"; // firmware 2, undocumented
    MAG = 10, "VNMAG", Some(38), "magnetic field";
    ACC = 11, "VNACC", Some(35), "acceleration";
    GYR = 12, "VNGYR", Some(44), "angular rate";
    MAR = 13, "VNMAR", Some(95), "magnetic field, acceleration, angular rate";
    YMR = 14, "VNYMR", Some(122), "attitude, magnetic field, acceleration, angular rate"; // the factory default
    YBA = 16, "VNYBA", Some(95), "attitude, linear acceleration along the body's axes, angular rate";
    YIA = 17, "VNYIA", Some(95), "attitude, linear acceleration along north, east, down, angular rate";
    IMU = 19, "VNIMU", Some(112), "uncompensated magnetic field, acceleration, angular rate, temperature, pressure";
    DTV = 30, "VNDTV", Some(75), "change of angle and of velocity, with its time";
    HVE = 34, "VNHVE", None, "vertical motion"; // firmware 3
}

impl AsyncType {
    /// The port sends no message.
    pub const OFF: Self = Self(0);

    /// The message with this header, such as `VNYPR`; `None` for a header without a constant here.
    pub fn from_header(header: &[u8]) -> Option<Self> {
        MESSAGES.iter().find(|message| message.header.as_bytes() == header).map(|message| message.code)
    }

    /// The header of the sentences, without the `$`; `None` for [`OFF`](Self::OFF) and for a code
    /// without a constant.
    pub fn header(self) -> Option<&'static str> {
        self.message().map(|message| message.header)
    }

    /// The content of the message, in words; `None` in the same cases as [`header`](Self::header).
    pub fn description(self) -> Option<&'static str> {
        self.message().map(|message| message.description)
    }

    /// The usual length of a sentence in bytes with an 8-bit checksum, CR and LF, without suffix; 0
    /// for [`OFF`](Self::OFF), `None` if it is not known. A value beyond its usual width makes a
    /// sentence longer.
    pub fn usual_length(self) -> Option<u32> {
        if self == Self::OFF { Some(0) } else { self.message()?.usual_length }
    }

    fn message(self) -> Option<&'static AsyncMessage> {
        MESSAGES.iter().find(|message| message.code == self)
    }
}

impl RegisterValue for AsyncType {
    const REGISTERS: &'static [Register] = &[Register::ASYNC_TYPE];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        let code = fields.integer("async type")?;
        fields.optional_port()?;
        Ok(Self(code))
    }
}

/// The rate at which a port sends its message, in hertz: one of [`OUTPUT_RATES_HZ`], or 0, for
/// which firmware 3 sends no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AsyncRate(u32);

impl AsyncRate {
    /// The rate of this many hertz; `None` if the sensor does not have it.
    pub fn new(hz: u32) -> Option<Self> {
        (hz == 0 || OUTPUT_RATES_HZ.contains(&hz)).then_some(Self(hz))
    }

    /// The rate in hertz.
    pub fn hz(self) -> u32 {
        self.0
    }
}

impl RegisterValue for AsyncRate {
    const REGISTERS: &'static [Register] = &[Register::ASYNC_RATE];

    fn read(fields: &mut FieldReader<'_>) -> Result<Self, ValueError> {
        let rate = fields.value("async rate", "0, 1, 2, 4, 5, 10, 20, 25, 40, 50, 100 or 200", |text| {
            integer(text).and_then(Self::new)
        })?;
        fields.optional_port()?;
        Ok(rate)
    }
}

macro_rules! written_as_number {
    ($($name:ident)*) => {$(
        impl WritableValue for $name {}

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

written_as_number!(BaudRate AsyncType AsyncRate);
