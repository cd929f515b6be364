//! `$VNYMR`: attitude, magnetic field, acceleration and angular rate, compensated.

use core::fmt::{self, Write};

use super::{Counts, GrammarError, MessageError, RangeError, Suffix, numbers::Numbers, parse_fields, scale};
use crate::{
    framing::checksum::Check,
    framing::sentence::{Sentence, write_sentence},
    message::decimal::Decimal,
    message::layout::{VNYMR, YMR_CHANNELS},
    message::print_format::PrintFormat,
};

/// One `$VNYMR` line.
///
/// ```text
/// $VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63 CR LF
///        '- yaw   pitch    roll     '- magnetic field x y z    '- acceleration x y z  '- angular rate x y z            '- check
///           deg                        gauss                      m/s²                   rad/s
/// ```
///
/// Axes are those of the body: x forward, y right, z down. 122 bytes in the usual widths; an
/// acceleration of 100 m/s² or more makes the line longer, and a [`Suffix`] may stand before the
/// `*`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ymr {
    counts: [i32; 12],
    negative_zeros: u16,
    print_format: PrintFormat,
    check: Check,
    suffix: Suffix,
}

impl Ymr {
    /// Reads a sentence.
    ///
    /// # Errors
    /// [`MessageError::Grammar`] unless it is a `VNYMR` with twelve numbers in one of the two print
    /// formats and at most a suffix behind them; [`MessageError::Range`] for a value beyond its
    /// channel's limit.
    pub fn parse(sentence: &Sentence<'_>) -> Result<Self, MessageError> {
        Self::read(sentence, PrintFormat::Current)
            .or_else(|| Self::read(sentence, PrintFormat::Old))
            .map_or_else(|| Self::judge(sentence), Ok)
    }

    /// Reads a line that is as `print_format` has it.
    #[inline(always)]
    fn read(sentence: &Sentence<'_>, print_format: PrintFormat) -> Option<Self> {
        let mut numbers = Numbers::behind("VNYMR", sentence.body)?;
        let forms = print_format.ymr_forms();
        numbers.three(0, &YMR_CHANNELS, forms[0].decimals)?;
        numbers.three(3, &YMR_CHANNELS, forms[3].decimals)?;
        numbers.three(6, &YMR_CHANNELS, forms[6].decimals)?;
        numbers.three(9, &YMR_CHANNELS, forms[9].decimals)?;
        let suffix = Suffix::parse(numbers.rest())?;
        let Numbers { counts, negative_zeros, .. } = numbers;
        Some(Self { counts, negative_zeros, print_format, check: sentence.check, suffix })
    }

    /// Reads any line, and says what is wrong with it.
    #[cold]
    fn judge(sentence: &Sentence<'_>) -> Result<Self, MessageError> {
        let fields = parse_fields(sentence, &VNYMR)?;
        let print_format = print_format(&fields.numbers)?;
        let Counts { counts, negative_zeros } = scale(&fields.numbers, &VNYMR)?;
        Ok(Self { counts, negative_zeros, print_format, check: sentence.check, suffix: fields.suffix })
    }

    /// A line of the current print format with these counts, in the units of
    /// [`counts`](Self::counts).
    ///
    /// # Errors
    /// [`RangeError`] for the first count beyond its channel's limit.
    pub fn from_counts(counts: [i32; 12]) -> Result<Self, RangeError> {
        for (channel, count) in VNYMR.channels.iter().zip(counts) {
            if count.unsigned_abs() > channel.limit_counts.unsigned_abs() {
                return Err(RangeError { channel, count: count.into() });
            }
        }
        Ok(Self::usual(counts, 0))
    }

    /// A line as most are: current print format, XOR-8, no suffix. The counts must be within their
    /// limits.
    #[inline]
    pub(crate) fn usual(counts: [i32; 12], negative_zeros: u16) -> Self {
        Self {
            counts,
            negative_zeros,
            print_format: PrintFormat::Current,
            check: Check::Xor8,
            suffix: Suffix::default(),
        }
    }

    /// The twelve values in the order of the wire, exactly: in units of the last decimal of each
    /// channel of [`VNYMR`], whatever the print format.
    #[inline]
    #[must_use]
    pub fn counts(&self) -> &[i32; 12] {
        &self.counts
    }

    /// How the line was printed.
    #[inline]
    #[must_use]
    pub fn print_format(&self) -> PrintFormat {
        self.print_format
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

    /// Yaw in degrees, within ±180.
    #[must_use]
    pub fn yaw_deg(&self) -> f64 {
        self.value(0)
    }

    /// Pitch in degrees, within ±180 as the line is checked, ±90 as the sensor prints it.
    #[must_use]
    pub fn pitch_deg(&self) -> f64 {
        self.value(1)
    }

    /// Roll in degrees, within ±180.
    #[must_use]
    pub fn roll_deg(&self) -> f64 {
        self.value(2)
    }

    /// The magnetic field along x, y, z in gauss.
    #[must_use]
    pub fn mag_gauss(&self) -> [f64; 3] {
        [3, 4, 5].map(|index| self.value(index))
    }

    /// The specific force along x, y, z in m/s²; level and at rest z reads about -9.8.
    #[must_use]
    pub fn accel_m_s2(&self) -> [f64; 3] {
        [6, 7, 8].map(|index| self.value(index))
    }

    /// The angular rate about x, y, z in rad/s, with the attitude filter's bias estimate taken off.
    #[must_use]
    pub fn gyro_rad_s(&self) -> [f64; 3] {
        [9, 10, 11].map(|index| self.value(index))
    }

    /// Writes the line in its own print format, from `$` to LF, protected by `check`.
    ///
    /// A line in the widths of its format, as the sensor prints it, comes back byte for byte when
    /// `check` is its own.
    ///
    /// # Errors
    /// What `out` reports.
    pub fn encode(&self, check: Check, out: &mut impl Write) -> fmt::Result {
        write_sentence(out, check, |out| {
            out.write_str(&VNYMR.message)?;
            for (index, channel) in VNYMR.channels.iter().enumerate() {
                let form = &self.print_format.ymr_forms()[index];
                let printed = self.counts[index] / 10_i32.pow(u32::from(channel.decimals - form.decimals));
                out.write_char(',')?;
                Decimal::from_count(printed, self.negative_zeros >> index & 1 == 1, form.decimals)
                    .write(out, form.whole_digits)?;
            }
            self.suffix.write(out)
        })
    }

    fn value(&self, index: usize) -> f64 {
        VNYMR.channels[index].value(self.counts[index])
    }
}

/// The format whose decimals all numbers have.
fn print_format(numbers: &[Decimal; 12]) -> Result<PrintFormat, GrammarError> {
    let is_old = numbers[0].decimals() == PrintFormat::Old.ymr_forms()[0].decimals;
    let format = if is_old { PrintFormat::Old } else { PrintFormat::Current };
    for (index, (number, form)) in numbers.iter().zip(format.ymr_forms()).enumerate() {
        if number.decimals() != form.decimals {
            let channel = &VNYMR.channels[index].name;
            return Err(GrammarError::Decimals { channel, expected: form.decimals, found: number.decimals() });
        }
    }
    Ok(format)
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*, sample::select};

    use super::*;

    const BODIES: [&str; 4] = [
        "VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391",
        "VNYMR,-5.469,+04.972,-180.000,-0.5551,+10.0000,+000.9048,+108.971,-2.145,-200.000,+0.000040,-40.000000,-0.000000,T01,S00FF",
        "VNYMR,-085.46,+074.97,+063.75,-0.5551,+0.4403,-0.0000,+08.971,-02.145,-01.093,+00.0000,-40.0000,-00.0003",
        "VNYMR,-5.46,-000.00,+180.00,-00.5551,+10.0000,+000.9048,+108.971,-2.145,-0.000,+0.0000,-40.0000,-0.0003,S0000",
    ];

    fn sentence(body: &[u8]) -> Sentence<'_> {
        Sentence { body, raw: body, check: Check::Crc16, offset: 0 }
    }

    fn read(body: &[u8]) -> Option<Ymr> {
        let line = sentence(body);
        Ymr::read(&line, PrintFormat::Current).or_else(|| Ymr::read(&line, PrintFormat::Old))
    }

    fn assert_read_as_judged(body: &[u8]) {
        if let Some(ymr) = read(body) {
            assert_eq!(Ymr::judge(&sentence(body)), Ok(ymr), "{}", String::from_utf8_lossy(body));
        }
    }

    #[test]
    fn good_lines_of_any_width_are_read_at_once() {
        for body in BODIES {
            assert!(read(body.as_bytes()).is_some(), "{body}");
            assert_read_as_judged(body.as_bytes());
        }
    }

    #[test]
    fn every_change_of_one_byte_is_read_as_judged() {
        for body in BODIES {
            for at in 0..body.len() {
                for byte in 0..=u8::MAX {
                    let mut changed = body.as_bytes().to_vec();
                    changed[at] = byte;
                    assert_read_as_judged(&changed);
                }
                assert_read_as_judged(&body.as_bytes()[..at]);
            }
        }
    }

    proptest! {
        #[test]
        fn changes_of_many_bytes_are_read_as_judged(
            body in select(&BODIES[..]),
            changes in vec((6_usize..100, prop_oneof![Just(None), select(&b"+-,.0123456789"[..]).prop_map(Some)]), 1..4),
        ) {
            let mut body = body.as_bytes().to_vec();
            for (at, byte) in changes {
                match byte {
                    Some(byte) => body.insert(at, byte),
                    None => _ = body.remove(at),
                }
            }
            assert_read_as_judged(&body);
        }
    }
}
