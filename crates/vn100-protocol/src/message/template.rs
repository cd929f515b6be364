//! The usual `$VNYMR` and `$VNIMU` lines at full speed: every digit has a known place.
//!
//! A line that differs in one byte is left to the general path, which gives the same result for
//! every line that is accepted here.

use crate::{
    message::layout::{Layout, PrintFormat},
    message::sample::{MAX_CHANNELS, Sample},
    message::suffix::Suffix,
    message::table::{VNIMU, VNYMR},
};

const YMR: &Template<117, 12> = &Template::new(
    b"$VNYMR,+000.000,+000.000,+000.000,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,+00.000000,+00.000000,+00.000000",
    &VNYMR,
);

/// Sensors print the pressure in two widths.
const IMU: &Template<107, 11> = &Template::new(
    b"$VNIMU,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,+00.000000,+00.000000,+00.000000,+00.0,+00000.000",
    &VNIMU,
);
const IMU_NARROW: &Template<NARROW, 11> = &Template::new(
    b"$VNIMU,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,+00.000000,+00.000000,+00.000000,+00.0,+000.000",
    &VNIMU,
);

const NARROW: usize = 105;

/// The length of the check digits with the `*` before them.
const CHECK: usize = 3;

/// A usual line up to its `*`: `0` for a digit, `+` for a sign, other bytes unchanged.
struct Template<const BODY: usize, const CHANNELS: usize> {
    line: [u8; BODY],
    /// The allowed excess of a byte over its place in the line: 9 for a digit, 2 for a sign.
    span: [u8; BODY],
    /// The bits of that excess that must be 0, because the comma lies between `+` and `-`.
    sign_bit: [u8; BODY],
    /// The places where the fields begin.
    fields: [usize; CHANNELS],
    limits: [u32; CHANNELS],
    layout: &'static Layout,
}

/// Reads the line at the head of `input` if it is a usual one, in range, with a correct checksum and CR
/// or LF after it.
#[inline]
pub(crate) fn read(input: &[u8]) -> Option<Sample> {
    match input.get(3)? {
        b'Y' => {
            let line = YMR.checked(input)?;
            let word = |field: usize| word(line, YMR.fields[field]);
            let rate = |field: usize| angular_rate(line, YMR.fields[field]);
            // unrolled: a loop over the fields is not unrolled, and costs a fifth more
            let magnitudes = [
                angle(word(0)),
                angle(word(1)),
                angle(word(2)),
                magnetic_field(word(3)),
                magnetic_field(word(4)),
                magnetic_field(word(5)),
                acceleration(word(6)),
                acceleration(word(7)),
                acceleration(word(8)),
                rate(9),
                rate(10),
                rate(11),
            ];
            YMR.sample(line, magnitudes)
        }
        b'I' if input.get(NARROW) == Some(&b'*') => {
            let line = IMU_NARROW.checked(input)?;
            let pressure = angle(word(line, IMU_NARROW.fields[10]));
            IMU_NARROW.sample(line, inertial(line, &IMU_NARROW.fields, pressure))
        }
        b'I' => {
            let line = IMU.checked(input)?;
            let pressure = leading_digit(line, IMU.fields[10]) + wide_pressure(word(line, IMU.fields[10] + 2));
            IMU.sample(line, inertial(line, &IMU.fields, pressure))
        }
        _ => None,
    }
}

/// The length, up to its last check digit, of a line that was read.
#[inline]
pub(crate) fn length(line: &[u8]) -> usize {
    let star = if line[3] == b'Y' {
        YMR.line.len()
    } else if line[NARROW] == b'*' {
        NARROW
    } else {
        IMU.line.len()
    };
    star + CHECK
}

/// The magnitudes of a `$VNIMU` line.
#[inline(always)]
fn inertial(line: &[u8], fields: &[usize; 11], pressure: u32) -> [u32; 11] {
    let word = |field: usize| word(line, fields[field]);
    let rate = |field: usize| angular_rate(line, fields[field]);
    [
        magnetic_field(word(0)),
        magnetic_field(word(1)),
        magnetic_field(word(2)),
        acceleration(word(3)),
        acceleration(word(4)),
        acceleration(word(5)),
        rate(6),
        rate(7),
        rate(8),
        temperature(word(9)),
        pressure,
    ]
}

impl<const BODY: usize, const CHANNELS: usize> Template<BODY, CHANNELS> {
    const fn new(line: &[u8; BODY], layout: &'static Layout) -> Self {
        let (mut span, mut sign_bit) = ([0; BODY], [0; BODY]);
        let (mut fields, mut limits) = ([0; CHANNELS], [0; CHANNELS]);
        let (mut at, mut field) = (0, 0);
        while at < BODY {
            match line[at] {
                b'0' => span[at] = 9,
                b'+' => {
                    (span[at], sign_bit[at]) = (2, 1);
                    (fields[field], limits[field]) =
                        (at, layout.constant_channels()[field].limit_counts.cast_unsigned());
                    field += 1;
                }
                _ => {}
            }
            at += 1;
        }
        assert!(field == CHANNELS);
        Self { line: *line, span, sign_bit, fields, limits, layout }
    }

    /// The line if all its bytes fit, its checksum is correct, and CR or LF follows.
    #[inline(always)]
    fn checked<'a>(&self, input: &'a [u8]) -> Option<&'a [u8; BODY]> {
        let (line, rest) = input.split_first_chunk::<BODY>()?;
        let [b'*', high, low, b'\r' | b'\n', ..] = *rest else {
            return None;
        };
        let mut xor = [0; 16];
        let mut wrong = [0; 16];
        // byte by byte in sixteen lanes, which a vector register processes at once
        for start in (0..BODY / 16 * 16).step_by(16) {
            for lane in 0..16 {
                let at = start + lane;
                let above = line[at].wrapping_sub(self.line[at]);
                wrong[lane] |= above.saturating_sub(self.span[at]) | above & self.sign_bit[at];
                xor[lane] ^= line[at];
            }
        }
        let mut wrong = wrong.into_iter().fold(0, |all, lane| all | lane);
        let mut xor = xor.into_iter().fold(b'$', |all, lane| all ^ lane);
        for (at, byte) in line.iter().enumerate().skip(BODY / 16 * 16) {
            let above = byte.wrapping_sub(self.line[at]);
            wrong |= above.saturating_sub(self.span[at]) | above & self.sign_bit[at];
            xor ^= byte;
        }
        const HEX: &[u8; 16] = b"0123456789ABCDEF";
        let is_right = [high, low] == [HEX[usize::from(xor >> 4)], HEX[usize::from(xor & 15)]];
        (wrong == 0 && is_right).then_some(line)
    }

    /// The sample of these magnitudes with the signs of the line, if they are in range.
    #[inline(always)]
    fn sample(&self, line: &[u8; BODY], magnitudes: [u32; CHANNELS]) -> Option<Sample> {
        let mut counts = [0; MAX_CHANNELS];
        let mut beyond = false;
        for index in 0..CHANNELS {
            let magnitude = magnitudes[index];
            beyond |= magnitude > self.limits[index];
            let magnitude = magnitude.cast_signed();
            counts[index] = if line[self.fields[index]] == b'-' { -magnitude } else { magnitude };
        }
        let (print_format, suffix) = (PrintFormat::Current, Suffix::default());
        (!beyond).then_some(Sample { layout: self.layout, counts, print_format, suffix })
    }
}

/// Eight bytes as a number, the first one lowest.
#[inline]
fn word(line: &[u8], at: usize) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&line[at..at + 8]);
    u64::from_le_bytes(bytes)
}

// Each of these functions moves the digits of its form together at the end of the word, with zeros
// before them.

/// `+ddd.ddd`
#[inline]
fn angle(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_0F0F_0F00) << 8 | word & 0x0F0F_0F00_0000_0000)
}

/// `+dd.dddd`
#[inline]
fn magnetic_field(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_000F_0F00) << 8 | word & 0x0F0F_0F0F_0000_0000)
}

/// `+dd.ddd,`
#[inline]
fn acceleration(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_000F_0F00) << 16 | (word & 0x000F_0F0F_0000_0000) << 8)
}

/// `+dd.dddddd` at this place.
#[inline]
fn angular_rate(line: &[u8], at: usize) -> u32 {
    let word = word(line, at + 2);
    leading_digit(line, at) + eight_digits((word & 0x0000_0000_0000_000F) << 8 | word & 0x0F0F_0F0F_0F0F_0000)
}

/// `+dd.d,`
#[inline]
fn temperature(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_000F_0F00) << 32 | (word & 0x0000_000F_0000_0000) << 24)
}

/// `dddd.ddd`
#[inline]
fn wide_pressure(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_0F0F_0F0F) << 8 | word & 0x0F0F_0F00_0000_0000)
}

/// The number whose digits, the first one lowest, are the bytes of `digits`: neighbours are joined
/// to pairs, fours and eight.
#[inline]
fn eight_digits(digits: u64) -> u32 {
    let pairs = (digits * 10 + (digits >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    (fours * 10_000 + (fours >> 32)) as u32
}

/// The first of eight digits, after the sign at this place.
#[inline]
fn leading_digit(line: &[u8], at: usize) -> u32 {
    10_000_000 * u32::from(line[at + 1] - b'0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_lines_of_both_messages_take_this_path() {
        for (line, last) in [
            (
                "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n",
                -391,
            ),
            (
                "$VNIMU,+00.2263,+00.1184,+00.0624,+00.049,-00.009,-09.722,-00.001453,-00.000175,+00.000531,+33.0,+00101.326*63\r\n",
                101_326,
            ),
            (
                "$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66\n",
                84_322,
            ),
        ] {
            let (sample, length) = (read(line.as_bytes()).unwrap(), length(line.as_bytes()));
            assert_eq!((sample.counts().last(), length), (Some(&last), line.trim_end().len()));
            assert_eq!(read(&line.as_bytes()[..length]), None);
        }
    }
}
