//! The numbers of a good line, quickly: their decimals known beforehand, all digits of one joined
//! at once.
//!
//! [`None`] says that something is wrong or unusual, not what: the exact way through
//! [`Decimal`](crate::Decimal) reads the line again and judges it. What is read here is read there
//! alike.

use crate::{message::digits::eight_digits, message::layout::Channel};

/// The numbers at the head of a body.
pub(super) struct Numbers<'a, const N: usize> {
    /// In units of the last decimal of each channel.
    pub(super) counts: [i32; N],
    /// A bit for each zero that has a minus sign.
    pub(super) negative_zeros: u16,
    body: &'a [u8],
    at: usize,
}

impl<'a, const N: usize> Numbers<'a, N> {
    /// None yet, behind the header.
    #[inline]
    pub(super) fn behind(header: &str, body: &'a [u8]) -> Option<Self> {
        let at = header.len();
        body.starts_with(header.as_bytes()).then_some(Self { counts: [0; N], negative_zeros: 0, body, at })
    }

    /// Reads three numbers of one form.
    // spelled out, and inlined with constants: a loop over all numbers costs twice as much
    #[inline(always)]
    pub(super) fn three(&mut self, first: usize, channels: &[Channel; N], decimals: u8) -> Option<()> {
        self.one(first, &channels[first], decimals)?;
        self.one(first + 1, &channels[first + 1], decimals)?;
        self.one(first + 2, &channels[first + 2], decimals)
    }

    /// Reads a comma and number `index`: a sign, one to three digits (eight with the decimals at
    /// most), a point, `decimals` digits, which are no more than the channel has.
    #[inline(always)]
    pub(super) fn one(&mut self, index: usize, channel: &Channel, decimals: u8) -> Option<()> {
        const ZEROS: u64 = u64::from_le_bytes(*b"00000000");
        let printed = usize::from(decimals);
        let missing = usize::from(channel.decimals) - printed;
        let [b',', sign, digits @ ..] = self.body.get(self.at..)? else {
            return None;
        };
        // one test for both signs, which are random: a branch that tells them apart is mispredicted half of the time
        if sign.wrapping_sub(b'+') & !2 != 0 {
            return None;
        }
        // branches, not arithmetic: a predicted width lets the next number begin before this one is known
        let whole = match digits.first_chunk()? {
            [_, b'.', _, _] => 1,
            [_, _, b'.', _] => 2,
            [_, _, _, b'.'] if 3 + channel.decimals <= 8 => 3,
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
        if magnitude > channel.limit_counts {
            return None;
        }
        let negative = *sign == b'-';
        self.counts[index] = if negative { -magnitude } else { magnitude };
        self.negative_zeros |= u16::from(negative && magnitude == 0) << index;
        self.at = end;
        Some(())
    }

    /// What stands behind the numbers read.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.body[self.at..]
    }
}

/// The eight bytes before `end` as a number, the first one lowest.
#[inline(always)]
fn word_before(end: usize, bytes: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(..end)?.last_chunk()?))
}
