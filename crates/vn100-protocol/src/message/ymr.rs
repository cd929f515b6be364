//! `$VNYMR`: attitude, magnetic field, acceleration and angular rate, compensated.

use core::fmt::{self, Write};

use super::{Counts, GrammarError, MessageError, RangeError, Suffix, parse_fields, scale, write_sentence};
use crate::{checksum::Check, decimal::Decimal, layout::VNYMR, print_format::PrintFormat, sentence::Sentence};

/// One `$VNYMR` line.
///
/// ```text
/// $VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63 CR LF
///        '- yaw   pitch    roll     '- magnetic field x y z    '- acceleration x y z  '- angular rate x y z            '- check
///           deg                        gauss                      m/s²                   rad/s
/// ```
///
/// Axes are those of the body: x forward, y right, z down. 122 bytes in the usual widths; an acceleration of 100 m/s² or more makes the
/// line longer, and a [`Suffix`] may stand before the `*`.
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
    /// [`MessageError::Grammar`] unless it is a `VNYMR` with twelve numbers in one of the two print formats and at most a suffix behind
    /// them; [`MessageError::Range`] for a value beyond its channel's limit.
    pub fn parse(sentence: &Sentence<'_>) -> Result<Self, MessageError> {
        if let Some(ymr) = Self::quick(sentence) {
            return Ok(ymr);
        }
        let fields = parse_fields(sentence, &VNYMR)?;
        let print_format = print_format(&fields.numbers)?;
        let Counts { counts, negative_zeros } = scale(&fields.numbers, &VNYMR)?;
        Ok(Self { counts, negative_zeros, print_format, check: sentence.check, suffix: fields.suffix })
    }

    #[inline]
    fn quick(sentence: &Sentence<'_>) -> Option<Self> {
        sentence.body.strip_prefix(b"VNYMR")?;
        Self::quick_as(sentence, PrintFormat::Current, [3, 4, 3, 6])
            .or_else(|| Self::quick_as(sentence, PrintFormat::Old, [2, 4, 3, 4]))
    }

    #[inline(always)]
    fn quick_as(sentence: &Sentence<'_>, print_format: PrintFormat, printed: [u32; 4]) -> Option<Self> {
        let mut numbers = super::usual::Numbers { body: sentence.body, at: 5 };
        let [a, b, c] = numbers.three(printed[0], 3, 180_000)?;
        let [d, e, f] = numbers.three(printed[1], 4, 100_000)?;
        let [g, h, i] = numbers.three(printed[2], 3, 200_000)?;
        let [j, k, l] = numbers.three(printed[3], 6, 40_000_000)?;
        if numbers.at != sentence.body.len() {return None;}
        let all = [a, b, c, d, e, f, g, h, i, j, k, l];
        let counts = all.map(|number| number.0);
        let mut negative_zeros = 0;
        for index in 0..12 { negative_zeros |= u16::from(all[index].1) << index; }
        Some(Self { counts, negative_zeros, print_format, check: sentence.check, suffix: Suffix::default() })
    }

    /// A line of the current print format with these counts, in the units of [`counts`](Self::counts).
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

    /// A line as most are: current print format, XOR-8, no suffix. The counts must be within their limits.
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

    /// The twelve values in the order of the wire, exactly: in units of the last decimal of each channel of [`VNYMR`], whatever the
    /// print format.
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
    /// A line in the widths of its format, as the sensor prints it, comes back byte for byte when `check` is its own.
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
