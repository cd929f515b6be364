//! The usual `$VNYMR` line at full speed: every digit has a known place.
//!
//! A line that differs in one byte is left to the general path, which gives the same result for
//! every line that is accepted here.

use crate::{
    message::layout::PrintFormat,
    message::numbers::eight_digits,
    message::sample::{MAX_CHANNELS, Sample},
    message::suffix::Suffix,
    message::table::VNYMR,
};

/// The length of the usual line up to its last check digit.
pub(crate) const LENGTH: usize = 120;

/// The usual line: `0` for a digit, `+` for a sign, other bytes unchanged. The digits after the `*`
/// are checked by their value.
const LINE: &[u8; LENGTH] = b"$VNYMR,+000.000,+000.000,+000.000,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,\
    +00.000000,+00.000000,+00.000000*00";

/// The length of the bytes up to the `*`, which the checksum covers after the `$`.
const BODY_END: usize = 117;

/// The places where the fields begin.
const FIELDS: [usize; 12] = [7, 16, 25, 34, 43, 52, 61, 69, 77, 85, 96, 107];

/// The allowed excess of a byte over its place in `LINE`: 9 for a digit, 2 for a sign.
const SPAN: [u8; LENGTH] = span(9, 2);

/// The bits of that excess that must be 0, because the comma lies between `+` and `-`.
const SIGN_BIT: [u8; LENGTH] = span(0, 1);

/// Reads `line` if it is a usual one, in range, with a correct checksum and CR or LF after it.
#[inline]
pub(crate) fn ymr(line: &[u8; LENGTH + 1]) -> Option<Sample> {
    let [.., b'*', high, low, b'\r' | b'\n'] = *line else {
        return None;
    };
    let xor = checked_xor(line)?;
    const HEX: &[u8; 16] = b"0123456789ABCDEF";
    if [high, low] != [HEX[usize::from(xor >> 4)], HEX[usize::from(xor & 15)]] {
        return None;
    }
    let at = |field: usize| word(line, FIELDS[field]);
    let rate = |field: usize| {
        10_000_000 * u32::from(line[FIELDS[field] + 1] - b'0') + angular_rate(word(line, FIELDS[field] + 2))
    };
    // unrolled: a loop over the fields is not unrolled, and costs a fifth more
    let magnitudes = [
        angle(at(0)),
        angle(at(1)),
        angle(at(2)),
        magnetic_field(at(3)),
        magnetic_field(at(4)),
        magnetic_field(at(5)),
        acceleration(at(6)),
        acceleration(at(7)),
        acceleration(at(8)),
        rate(9),
        rate(10),
        rate(11),
    ];
    let mut counts = [0; MAX_CHANNELS];
    let mut beyond = false;
    for index in 0..12 {
        let magnitude = magnitudes[index];
        beyond |= magnitude > LIMITS[index];
        let magnitude = magnitude.cast_signed();
        counts[index] = if line[FIELDS[index]] == b'-' { -magnitude } else { magnitude };
    }
    (!beyond).then(|| Sample { layout: &VNYMR, counts, print_format: PrintFormat::Current, suffix: Suffix::default() })
}

/// The XOR-8 of the body if all bytes before the check digits fit the usual line.
#[inline]
fn checked_xor(line: &[u8; LENGTH + 1]) -> Option<u8> {
    let mut xor = [0; 16];
    let mut wrong = [0; 16];
    // byte by byte in sixteen lanes, which a vector register processes at once
    for start in (0..112).step_by(16) {
        for lane in 0..16 {
            let at = start + lane;
            let above = line[at].wrapping_sub(LINE[at]);
            wrong[lane] |= above.saturating_sub(SPAN[at]) | above & SIGN_BIT[at];
            xor[lane] ^= line[at];
        }
    }
    let mut wrong = wrong.into_iter().fold(0, |all, lane| all | lane);
    let mut xor = xor.into_iter().fold(b'$', |all, lane| all ^ lane);
    for at in 112..BODY_END {
        wrong |= line[at].wrapping_sub(LINE[at]).saturating_sub(SPAN[at]);
        xor ^= line[at];
    }
    (wrong == 0).then_some(xor)
}

/// Eight bytes as a number, the first one lowest.
#[inline]
fn word(line: &[u8; LENGTH + 1], at: usize) -> u64 {
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

/// `d.dddddd`
#[inline]
fn angular_rate(word: u64) -> u32 {
    eight_digits((word & 0x0000_0000_0000_000F) << 8 | word & 0x0F0F_0F0F_0F0F_0000)
}

const LIMITS: [u32; 12] = {
    let mut limits = [0; 12];
    let mut index = 0;
    while index < 12 {
        limits[index] = VNYMR.constant_channels()[index].limit_counts.cast_unsigned();
        index += 1;
    }
    limits
};

/// `digit` for each digit of the line, `sign` for each sign, 0 elsewhere.
const fn span(digit: u8, sign: u8) -> [u8; LENGTH] {
    let mut span = [0; LENGTH];
    let mut at = 0;
    while at < LENGTH {
        span[at] = match LINE[at] {
            b'0' => digit,
            b'+' => sign,
            _ => 0,
        };
        at += 1;
    }
    span
}
