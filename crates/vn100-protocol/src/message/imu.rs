//! `$VNIMU`: magnetic field, acceleration and angular rate as measured, with temperature and
//! pressure.

use alloc::format;
use core::fmt::{self, Write};

use super::{Counts, Fields, GrammarError, MessageError, Suffix, numbers::Numbers, parse_fields, scale, split_fields};
use crate::{
    framing::checksum::Check,
    framing::sentence::{Sentence, write_sentence},
    message::decimal::Decimal,
    message::layout::{IMU_CHANNELS, VNIMU},
    register::{Register, RegisterContents, RegisterValue, ValueError},
};

/// One `$VNIMU` line.
///
/// ```text
/// $VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66 CR LF
///        '- magnetic field x y z    '- acceleration x y z   '- angular rate x y z            degC  '- kPa   '- check
///           gauss                      m/s²                    rad/s
/// ```
///
/// A read of register 54 gives the same numbers: see [`RegisterContents::value`]. Nothing is
/// compensated: the angular rates keep their bias, which `$VNYMR` has taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Imu {
    counts: [i32; 11],
    negative_zeros: u16,
    check: Check,
    suffix: Suffix,
}

/// Digits before the point as recorded. One edition of the maker's manual gives the pressure five;
/// no recording shows that.
const WHOLE_DIGITS: [usize; 11] = [2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3];

impl Imu {
    /// Reads a sentence.
    ///
    /// # Errors
    /// [`MessageError::Grammar`] unless it is a `VNIMU` with eleven numbers of the known decimals
    /// and at most a suffix behind them; [`MessageError::Range`] for a value beyond its channel's
    /// limit.
    pub fn parse(sentence: &Sentence<'_>) -> Result<Self, MessageError> {
        Self::read(sentence).map_or_else(|| Self::judge(sentence), Ok)
    }

    /// Reads a line that is as all are.
    #[inline]
    fn read(sentence: &Sentence<'_>) -> Option<Self> {
        let mut numbers = Numbers::behind("VNIMU", sentence.body)?;
        for first in [0, 3, 6] {
            numbers.three(first, &IMU_CHANNELS, IMU_CHANNELS[first].decimals)?;
        }
        for index in [9, 10] {
            numbers.one(index, &IMU_CHANNELS[index], IMU_CHANNELS[index].decimals)?;
        }
        let suffix = Suffix::parse(numbers.rest())?;
        let Numbers { counts, negative_zeros, .. } = numbers;
        Some(Self { counts, negative_zeros, check: sentence.check, suffix })
    }

    /// Reads any line, and says what is wrong with it.
    #[cold]
    fn judge(sentence: &Sentence<'_>) -> Result<Self, MessageError> {
        Self::from_fields(parse_fields(sentence, &VNIMU)?, sentence.check)
    }

    fn from_fields(fields: Fields<11>, check: Check) -> Result<Self, MessageError> {
        for (number, channel) in fields.numbers.iter().zip(&*VNIMU.channels) {
            if number.decimals() != channel.decimals {
                let (expected, found) = (channel.decimals, number.decimals());
                return Err(GrammarError::Decimals { channel: &channel.name, expected, found }.into());
            }
        }
        let Counts { counts, negative_zeros } = scale(&fields.numbers, &VNIMU)?;
        Ok(Self { counts, negative_zeros, check, suffix: fields.suffix })
    }

    /// The eleven values in the order of the wire, exactly: in units of the last decimal of each
    /// channel of [`VNIMU`].
    #[inline]
    #[must_use]
    pub fn counts(&self) -> &[i32; 11] {
        &self.counts
    }

    /// What protected the line.
    #[must_use]
    pub fn check(&self) -> Check {
        self.check
    }

    /// The optional fields behind the numbers.
    #[must_use]
    pub fn suffix(&self) -> Suffix {
        self.suffix
    }

    /// The magnetic field along x, y, z in gauss.
    #[must_use]
    pub fn mag_gauss(&self) -> [f64; 3] {
        [0, 1, 2].map(|index| self.value(index))
    }

    /// The specific force along x, y, z in m/s²; level and at rest z reads about -9.8.
    #[must_use]
    pub fn accel_m_s2(&self) -> [f64; 3] {
        [3, 4, 5].map(|index| self.value(index))
    }

    /// The angular rate about x, y, z in rad/s.
    #[must_use]
    pub fn gyro_rad_s(&self) -> [f64; 3] {
        [6, 7, 8].map(|index| self.value(index))
    }

    /// The temperature in °C.
    #[must_use]
    pub fn temperature_c(&self) -> f64 {
        self.value(9)
    }

    /// The air pressure in kPa.
    #[must_use]
    pub fn pressure_kpa(&self) -> f64 {
        self.value(10)
    }

    /// Writes the line from `$` to LF, protected by `check`.
    ///
    /// A line in the recorded widths (three whole digits of pressure) comes back byte for byte when
    /// `check` is its own.
    ///
    /// # Errors
    /// What `out` reports.
    pub fn encode(&self, check: Check, out: &mut impl Write) -> fmt::Result {
        write_sentence(out, check, |out| {
            out.write_str(&VNIMU.message)?;
            for (index, channel) in VNIMU.channels.iter().enumerate() {
                let negative_zero = self.negative_zeros >> index & 1 == 1;
                out.write_char(',')?;
                Decimal::from_count(self.counts[index], negative_zero, channel.decimals)
                    .write(out, WHOLE_DIGITS[index])?;
            }
            self.suffix.write(out)
        })
    }

    fn value(&self, index: usize) -> f64 {
        VNIMU.channels[index].value(self.counts[index])
    }
}

/// The same numbers, asked for: the answer to a read of register 54.
impl RegisterValue for Imu {
    const REGISTERS: &'static [Register] = &[Register::IMU];

    fn from_contents(contents: &RegisterContents) -> Result<Self, ValueError> {
        let register = contents.register;
        if register != Register::IMU {
            return Err(ValueError::Register { expected: Self::REGISTERS, found: register });
        }
        let fields = format!(",{}", contents.fields);
        split_fields(fields.as_bytes(), &VNIMU)
            .map_err(MessageError::from)
            .and_then(|fields| Self::from_fields(fields, contents.check))
            .map_err(|error| ValueError::Measurement { register, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(body: &[u8]) -> Sentence<'_> {
        Sentence { body, raw: body, check: Check::Xor8, offset: 0 }
    }

    #[test]
    fn every_change_of_one_byte_is_read_as_judged() {
        let body = b"VNIMU,-0.0350,+00.4222,-000.6643,-00.015,+00.019,+109.948,-00.000000,-08.008442,-0.044656,+20.7,+084.322,T5";
        assert!(Imu::read(&sentence(body)).is_some());
        for at in 0..body.len() {
            for byte in 0..=u8::MAX {
                let mut changed = body.to_vec();
                changed[at] = byte;
                if let Some(imu) = Imu::read(&sentence(&changed)) {
                    assert_eq!(Imu::judge(&sentence(&changed)), Ok(imu), "{}", String::from_utf8_lossy(&changed));
                }
            }
        }
    }
}
