//! Eight decimal digits as one number.

/// The number whose digits, the first one lowest, are the bytes of `digits`: neighbours are joined
/// to pairs, fours and eight.
#[inline]
pub(crate) fn eight_digits(digits: u64) -> u32 {
    let pairs = (digits * 10 + (digits >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    (fours * 10_000 + (fours >> 32)) as u32
}
