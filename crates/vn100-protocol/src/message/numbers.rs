//! A fast reader for the numbers of a valid sentence: their decimals are known in advance, and all
//! digits of a number are joined at once.
//!
//! [`None`] means that the sentence is wrong or unusual: the exact reader of `sample.rs` reads it
//! again and finds the reason. Both readers give the same values.

use crate::{
    framing::sentence::Sentence,
    message::layout::{Channel, Layout, PrintFormat},
    message::sample::{MAX_CHANNELS, Sample},
    message::suffix::Suffix,
};

/// A row of the table, at compile time.
pub(super) trait ConstLayout {
    const LAYOUT: &'static Layout;
}

/// Reads a sentence whose header is that of the row.
#[inline]
pub(super) fn read<R: ConstLayout>(sentence: &Sentence<'_>) -> Option<Sample> {
    read_as::<R, false>(sentence).or_else(|| read_as::<R, true>(sentence))
}

#[inline(always)]
fn read_as<R: ConstLayout, const OLD: bool>(sentence: &Sentence<'_>) -> Option<Sample> {
    let mut numbers =
        Numbers { counts: [0; MAX_CHANNELS], body: sentence.body, at: const { R::LAYOUT.constant_header().len() } };
    // unrolled, and inlined with constants: a loop over all numbers costs twice as much
    macro_rules! each {
        ($($index:literal)*) => {
            $(if let Some(form) = const { form(R::LAYOUT.constant_channels(), $index, format(OLD)) } {
                numbers.one($index, form)?;
            })*
        };
    }
    const { assert!(R::LAYOUT.constant_channels().len() <= MAX_CHANNELS) };
    if const { !format(OLD).covers(R::LAYOUT.constant_channels()) } {
        return None;
    }
    each!(0 1 2 3 4 5 6 7 8 9 10 11 12);
    let Numbers { counts, body, at } = numbers;
    Some(Sample { layout: R::LAYOUT, counts, print_format: format(OLD), suffix: Suffix::parse(&body[at..])? })
}

const fn format(old: bool) -> PrintFormat {
    if old { PrintFormat::Old } else { PrintFormat::Current }
}

/// The printed form of one number, and its count.
#[derive(Clone, Copy)]
struct Form {
    decimals: u8,
    /// Printed decimals, which are no more than these.
    printed: u8,
    limit_counts: i32,
}

/// The form of number `index`; `None` after the last one.
const fn form(channels: &[Channel], index: usize, format: PrintFormat) -> Option<Form> {
    if index >= channels.len() {
        return None;
    }
    let channel = &channels[index];
    let Channel { decimals, limit_counts, .. } = *channel;
    Some(Form { decimals, printed: format.decimals(channel), limit_counts })
}

/// The numbers at the head of a body.
struct Numbers<'a> {
    /// The counts, in units of the last decimal of each channel.
    counts: [i32; MAX_CHANNELS],
    body: &'a [u8],
    at: usize,
}

impl Numbers<'_> {
    /// Reads a comma and number `index`: a sign, one to three digits (at most eight with the
    /// decimals), a point, and the decimals printed.
    #[inline(always)]
    fn one(&mut self, index: usize, form: Form) -> Option<()> {
        const ZEROS: u64 = u64::from_le_bytes(*b"00000000");
        let printed = usize::from(form.printed);
        let missing = usize::from(form.decimals) - printed;
        let [b',', sign, digits @ ..] = self.body.get(self.at..)? else {
            return None;
        };
        // one test for both signs, which are random: a branch on the sign is mispredicted half of the time
        if sign.wrapping_sub(b'+') & !2 != 0 {
            return None;
        }
        // branches instead of arithmetic: a predicted width lets the next number begin before this one is
        // known
        let whole = match digits.first_chunk()? {
            [_, b'.', _, _] => 1,
            [_, _, b'.', _] => 2,
            [_, _, _, b'.'] if 3 + form.decimals <= 8 => 3,
            _ => return None,
        };
        let point = self.at + 2 + whole;
        let end = point + 1 + printed;
        // the digits on both sides of the point, moved together at the end of the word, and zeros before them
        let fraction = word_before(end, self.body)? & u64::MAX << (64 - 8 * printed);
        let before = word_before(point, self.body)? >> (8 * printed);
        let digits = ((fraction | before) ^ ZEROS) & u64::MAX << (64 - 8 * (whole + printed));
        if (digits | digits.wrapping_add(0x0606_0606_0606_0606)) & 0xF0F0_F0F0_F0F0_F0F0 != 0 {
            return None;
        }
        let magnitude = eight_digits(digits >> (8 * missing)).cast_signed();
        if magnitude > form.limit_counts {
            return None;
        }
        self.counts[index] = if *sign == b'-' { -magnitude } else { magnitude };
        self.at = end;
        Some(())
    }
}

/// The eight bytes before `end` as a number, the first one lowest.
#[inline(always)]
fn word_before(end: usize, bytes: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(..end)?.last_chunk()?))
}

/// The number whose digits, the first one lowest, are the bytes of `digits`: neighbours are joined
/// to pairs, fours and eight.
#[inline]
pub(super) fn eight_digits(digits: u64) -> u32 {
    let pairs = (digits * 10 + (digits >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    (fours * 10_000 + (fours >> 32)) as u32
}
