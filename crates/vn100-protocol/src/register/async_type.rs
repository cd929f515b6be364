//! Registers 6 and 7: the message that a port sends of itself, and how often.

use core::fmt;

use super::{
    Register, RegisterContents, RegisterValue, ValueError, WritableValue,
    field_reader::{FieldReader, integer},
};
use crate::message::layout::OUTPUT_RATES_HZ;

/// The message that a port sends of itself, by the code that register 6 takes.
///
/// A code without a constant here, of a sister product or of the maker's own, can be read and
/// written all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AsyncType(pub u8);

struct Message {
    code: AsyncType,
    header: &'static str,
    description: &'static str,
    usual_length: Option<u32>,
}

/// The lengths are those of the recorded print widths; that of the IMU message takes the wider of
/// the two pressures reported.
const MESSAGES: [Message; 14] = [
    message(AsyncType::YPR, "VNYPR", "attitude", Some(38)),
    message(AsyncType::QTN, "VNQTN", "attitude as a quaternion", Some(51)),
    message(AsyncType::QMR, "VNQMR", "quaternion, magnetic field, acceleration, angular rate", Some(135)),
    message(AsyncType::DCM, "VNDCM", "attitude as a rotation matrix", None),
    message(AsyncType::MAG, "VNMAG", "magnetic field", Some(38)),
    message(AsyncType::ACC, "VNACC", "acceleration", Some(35)),
    message(AsyncType::GYR, "VNGYR", "angular rate", Some(44)),
    message(AsyncType::MAR, "VNMAR", "magnetic field, acceleration, angular rate", Some(95)),
    message(AsyncType::YMR, "VNYMR", "attitude, magnetic field, acceleration, angular rate", Some(122)),
    message(AsyncType::YBA, "VNYBA", "attitude, linear acceleration along the body's axes, angular rate", Some(95)),
    message(AsyncType::YIA, "VNYIA", "attitude, linear acceleration along north, east, down, angular rate", Some(95)),
    message(
        AsyncType::IMU,
        "VNIMU",
        "uncompensated magnetic field, acceleration, angular rate, temperature, pressure",
        Some(112),
    ),
    message(AsyncType::DTV, "VNDTV", "change of angle and of velocity, with its time", Some(75)),
    message(AsyncType::HVE, "VNHVE", "vertical motion", None),
];

impl AsyncType {
    /// Nothing is sent.
    pub const OFF: Self = Self(0);
    /// `$VNYPR`: yaw, pitch, roll.
    pub const YPR: Self = Self(1);
    /// `$VNQTN`: the attitude as a quaternion, scalar last.
    pub const QTN: Self = Self(2);
    /// `$VNQMR`: quaternion, magnetic field, acceleration, angular rate.
    pub const QMR: Self = Self(8);
    /// `$VNDCM`: the attitude as a rotation matrix; firmware 2, undocumented.
    pub const DCM: Self = Self(9);
    /// `$VNMAG`: magnetic field.
    pub const MAG: Self = Self(10);
    /// `$VNACC`: acceleration.
    pub const ACC: Self = Self(11);
    /// `$VNGYR`: angular rate.
    pub const GYR: Self = Self(12);
    /// `$VNMAR`: magnetic field, acceleration, angular rate.
    pub const MAR: Self = Self(13);
    /// `$VNYMR`: attitude, magnetic field, acceleration, angular rate; what a sensor is sold with.
    pub const YMR: Self = Self(14);
    /// `$VNYBA`: attitude, linear acceleration along the axes of the body, angular rate.
    pub const YBA: Self = Self(16);
    /// `$VNYIA`: attitude, linear acceleration along north, east, down, angular rate.
    pub const YIA: Self = Self(17);
    /// `$VNIMU`: uncompensated magnetic field, acceleration and angular rate, temperature,
    /// pressure.
    pub const IMU: Self = Self(19);
    /// `$VNDTV`: change of angle and of velocity, with the time it took.
    pub const DTV: Self = Self(30);
    /// `$VNHVE`: vertical motion; firmware 3.
    pub const HVE: Self = Self(34);

    /// The message with this header, such as `VNYPR`; `None` for one that has no constant here.
    #[must_use]
    pub fn from_header(header: &[u8]) -> Option<Self> {
        MESSAGES.iter().find(|message| message.header.as_bytes() == header).map(|message| message.code)
    }

    /// The header of its lines, without the `$`; `None` for [`OFF`](Self::OFF) and for a code
    /// without a constant.
    #[must_use]
    pub fn header(self) -> Option<&'static str> {
        self.message().map(|message| message.header)
    }

    /// What it holds, in words; `None` as for the header.
    #[must_use]
    pub fn description(self) -> Option<&'static str> {
        self.message().map(|message| message.description)
    }

    /// The usual length of a line in bytes with an 8-bit checksum, CR and LF, without suffix; 0 for
    /// [`OFF`](Self::OFF), `None` where it is not known. A value beyond its usual width makes a
    /// line longer.
    #[must_use]
    pub fn usual_length(self) -> Option<u32> {
        if self == Self::OFF { Some(0) } else { self.message()?.usual_length }
    }

    fn message(self) -> Option<&'static Message> {
        MESSAGES.iter().find(|message| message.code == self)
    }
}

const fn message(
    code: AsyncType,
    header: &'static str,
    description: &'static str,
    usual_length: Option<u32>,
) -> Message {
    Message { code, header, description, usual_length }
}

impl RegisterValue for AsyncType {
    const REGISTERS: &'static [Register] = &[Register::ASYNC_TYPE];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let code = fields.integer("async type")?;
        fields.optional_port()?;
        fields.end()?;
        Ok(Self(code))
    }
}

impl WritableValue for AsyncType {
    fn register(&self) -> Register {
        Register::ASYNC_TYPE
    }
}

impl fmt::Display for AsyncType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How often a port sends its message, in hertz: one of [`OUTPUT_RATES_HZ`], or 0, which firmware 3
/// takes for never.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AsyncRate(u32);

impl AsyncRate {
    /// This many lines per second; `None` for a rate that the sensor does not have.
    #[must_use]
    pub fn new(hz: u32) -> Option<Self> {
        (hz == 0 || OUTPUT_RATES_HZ.contains(&hz)).then_some(Self(hz))
    }

    /// Lines per second.
    #[must_use]
    pub fn hz(self) -> u32 {
        self.0
    }
}

impl RegisterValue for AsyncRate {
    const REGISTERS: &'static [Register] = &[Register::ASYNC_RATE];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let mut fields = FieldReader::of::<Self>(contents)?;
        let rate = fields.value("async rate", "0, 1, 2, 4, 5, 10, 20, 25, 40, 50, 100 or 200", |text| {
            integer(text).and_then(Self::new)
        })?;
        fields.optional_port()?;
        fields.end()?;
        Ok(rate)
    }
}

impl WritableValue for AsyncRate {
    fn register(&self) -> Register {
        Register::ASYNC_RATE
    }
}

impl fmt::Display for AsyncRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
