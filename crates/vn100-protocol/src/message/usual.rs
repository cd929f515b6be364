//! The numbers of a message when nothing is wrong with them, as quick as can be.

use crate::digits::eight_digits;

/// Reads numbers one after the other.
///
/// `None` says nothing of what is wrong, or only unusual: that is for the exact way to find out.
pub(super) struct Numbers<'a> {
    pub(super) body: &'a [u8],
    pub(super) at: usize,
}

impl Numbers<'_> {
    /// Three fields.
    #[inline(always)]
    pub(super) fn three(&mut self, printed: u32, decimals: u32, limit: i32) -> Option<[(i32, bool); 3]> {
        Some([self.one(printed, decimals, limit)?, self.one(printed, decimals, limit)?, self.one(printed, decimals, limit)?])
    }

    #[inline(always)]
    fn one(&mut self, printed: u32, decimals: u32, limit: i32) -> Option<(i32, bool)> {
        let [b',', sign, digits @ ..] = self.body.get(self.at..)? else {
            return None;
        };
        if sign.wrapping_sub(b'+') & !2 != 0 {
            return None;
        }
        let whole = match digits.first_chunk()? {
            [_, _, b'.', _] => 2,
            [_, _, _, b'.'] if decimals + 3 <= 8 => 3,
            [_, b'.', _, _] => 1,
            _ => return None,
        };
        let point = self.at + 2 + whole;
        let end = point + 1 + printed as usize;
        let before_point = u64::from_le_bytes(*self.body.get(..point)?.last_chunk()?);
        let before_end = u64::from_le_bytes(*self.body.get(..end)?.last_chunk()?);
        let text = before_end & u64::MAX << (64 - 8 * printed) | before_point >> (8 * printed) & u64::MAX >> (8 * printed);
        let count = whole as u32 + printed;
        let text = (text ^ 0x3030_3030_3030_3030) & (u64::MAX << (64 - 8 * count));
        if (text | text.wrapping_add(0x0606_0606_0606_0606)) & 0xF0F0_F0F0_F0F0_F0F0 != 0 {
            return None;
        }
        self.at = end;
        let magnitude = eight_digits(text >> (8 * (decimals - printed))).cast_signed();
        if magnitude > limit { return None; }
        let negative = *sign == b'-';
        Some((if negative { -magnitude } else { magnitude }, negative && magnitude == 0))
    }
}
