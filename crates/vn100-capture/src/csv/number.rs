//! Numbers as laboratory scripts print them, such as `-077.706` and `1e-05`, held exactly.

/// The powers of ten that are floats.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Separators of thousands, for numbers with no decimals after them.
const THOUSANDS: [u8; 3] = *b",' ";

/// The most digits that always fit 64 bits.
const MOST_DIGITS: usize = 19;

/// Exponents beyond this have no further effect: the number is zero or too large.
const LARGEST_EXPONENT: i32 = 9_999;

/// A decimal number: ±`digits` / 10^`decimals`, cut after 19 digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Number {
    negative: bool,
    pub(super) digits: u64,
    /// Negative for a number such as 1e5.
    pub(super) decimals: i32,
}

impl Number {
    /// Reads a field without spaces or quotes around it, also with separators of thousands as in
    /// `101,325.12`; `None` if it is no finite decimal number.
    #[inline]
    pub(super) fn parse(field: &[u8]) -> Option<Self> {
        match Self::parse_prefix(field) {
            Some((number, length)) if length == field.len() => Some(number),
            Some((_, length)) if THOUSANDS.contains(&field[length]) => Self::parse_thousands(field),
            _ => None,
        }
    }

    #[cold]
    fn parse_thousands(field: &[u8]) -> Option<Self> {
        let whole = field.split(|byte| *byte == b'.').next().unwrap_or_default();
        let mark = *whole.iter().find(|byte| THOUSANDS.contains(byte))?;
        let digits = whole.strip_prefix(b"-").or(whole.strip_prefix(b"+")).unwrap_or(whole);
        let bare: Vec<u8> = field.iter().copied().filter(|byte| *byte != mark).collect();
        let (number, length) = Self::parse_prefix(&bare)?;
        (length == bare.len() && are_thousands(digits, mark)).then_some(number)
    }

    /// Reads the number at the head of `input`; also returns its length.
    #[inline]
    pub(super) fn parse_prefix(input: &[u8]) -> Option<(Self, usize)> {
        // `-` lies two above `+`. One test for both: signs are random, and a branch between them is mispredicted half of the time
        let &first = input.first()?;
        let sign = usize::from(first.wrapping_sub(b'+') & !2 == 0);
        let (whole, point) = append_digits(0, input, sign);
        let (mut digits, mut end, mut decimals) = (whole, point, 0);
        if input.get(point) == Some(&b'.') {
            let (eights, at) = append_eights(whole, input, point + 1);
            (digits, end) = append_digits(eights, input, at);
            decimals = end - point - 1;
        }
        let digit_count = point - sign + decimals;
        if digit_count == 0 {
            return None;
        }
        let mut decimals = decimals as i32;
        if digit_count > MOST_DIGITS {
            (digits, decimals) = cut(digits, decimals, &input[sign..end]);
        }
        if let Some(b'e' | b'E') = input.get(end) {
            let exponent;
            (exponent, end) = parse_exponent(input, end + 1)?;
            decimals = decimals.saturating_sub(exponent);
        }
        Some((Self { negative: first == b'-', digits, decimals }, end))
    }

    #[inline]
    pub(super) fn signed_digits(&self) -> i64 {
        (self.digits as i64).wrapping_mul(1 - 2 * i64::from(self.negative))
    }

    /// The number times `factor`, rounded, half away from zero; `None` beyond 64 bits.
    #[inline]
    pub(super) fn times(&self, factor: i64) -> Option<i64> {
        // most stamps are whole nanoseconds
        let power = u32::try_from(self.decimals).ok().and_then(|decimals| 10_i64.checked_pow(decimals));
        if let Some(power) = power.filter(|power| factor % power == 0 && self.digits <= i64::MAX as u64) {
            return self.signed_digits().checked_mul(factor / power);
        }
        let product = i128::from(self.digits) * i128::from(factor);
        let magnitude = match 10_i128.checked_pow(self.decimals.unsigned_abs()) {
            Some(power) if self.decimals >= 0 => product.saturating_add(power / 2) / power,
            None if self.digits == 0 || self.decimals > 0 => 0,
            power => product.checked_mul(power?)?,
        };
        i64::try_from(if self.negative { -magnitude } else { magnitude }).ok()
    }

    /// The number less a whole one; `None` if it is smaller, or has an exponent.
    pub(super) fn minus(&self, whole: u64) -> Option<Self> {
        let power = u32::try_from(self.decimals).ok().and_then(|decimals| 10_u64.checked_pow(decimals))?;
        let digits = self.digits.checked_sub(whole.checked_mul(power)?)?;
        (!self.negative).then_some(Self { digits, ..*self })
    }

    /// The number of digits after the point, as if an exponent were written out, without trailing zeros.
    pub(super) fn significant_decimals(&self) -> u32 {
        let (mut digits, mut decimals) = (self.digits, self.decimals);
        while decimals > 0 && digits % 10 == 0 {
            digits /= 10;
            decimals -= if digits == 0 { decimals } else { 1 };
        }
        decimals.max(0).unsigned_abs()
    }

    /// The decimal number with the fewest digits that is the same float: the number that a script
    /// had before it printed all digits of the float. `None` beyond the range of floats.
    #[cold]
    pub(super) fn shortest_of_float(&self) -> Option<Self> {
        let sign = if self.negative { "-" } else { "" };
        let float: f64 = format!("{sign}{}e{}", self.digits, -self.decimals).parse().ok()?;
        Self::parse(format!("{float:e}").as_bytes())
    }

    /// The number, to the precision of a float: the nearest float up to 15 digits and 22 decimals.
    #[inline]
    pub(super) fn value(&self) -> f64 {
        let digits = self.digits as f64;
        let magnitude = match self.decimals {
            decimals @ 0..=22 => digits / EXACT_POWERS[decimals as usize],
            decimals @ 23..=44 => digits / EXACT_POWERS[22] / EXACT_POWERS[decimals as usize - 22],
            decimals @ -22..0 => digits * EXACT_POWERS[-decimals as usize],
            decimals => digits * 10_f64.powi(-decimals),
        };
        if self.negative { -magnitude } else { magnitude }
    }
}

/// Whether the text is a number from a thousand on, with this separator of thousands.
pub(super) fn are_thousands(digits: &[u8], mark: u8) -> bool {
    let mut groups = digits.split(|byte| *byte == mark);
    let first = groups.next().unwrap_or_default();
    let are_digits = |group: &[u8]| group.iter().all(u8::is_ascii_digit);
    let mut rest = groups.peekable();
    matches!(first, [b'1'..=b'9', ..])
        && first.len() <= 3
        && are_digits(first)
        && rest.peek().is_some()
        && rest.all(|group| group.len() == 3 && are_digits(group))
}

/// Appends eight digits of `input` at a time: neighbours are joined to pairs, fours and eight.
#[inline(always)]
fn append_eights(mut digits: u64, input: &[u8], mut at: usize) -> (u64, usize) {
    while let Some(eight) = input.get(at..).and_then(<[u8]>::first_chunk) {
        let word = u64::from_le_bytes(*eight) ^ u64::from_le_bytes(*b"00000000");
        if (word | word.wrapping_add(0x0606_0606_0606_0606)) & 0xF0F0_F0F0_F0F0_F0F0 != 0 {
            break;
        }
        let pairs = (word * 10 + (word >> 8)) & 0x00FF_00FF_00FF_00FF;
        let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
        let eight = (fours * 10_000 + (fours >> 32)) & 0xFFFF_FFFF;
        digits = digits.wrapping_mul(100_000_000).wrapping_add(eight);
        at += 8;
    }
    (digits, at)
}

/// Appends the digits of `input` from `at` on to `digits`, modulo 2^64, and returns their end.
#[inline(always)]
fn append_digits(mut digits: u64, input: &[u8], mut at: usize) -> (u64, usize) {
    while let Some(byte @ b'0'..=b'9') = input.get(at) {
        digits = digits.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
        at += 1;
    }
    (digits, at)
}

/// The digits and decimals of a number of many digits, which are `digits` if all but zeros at the head fit.
fn cut(digits: u64, decimals: i32, number: &[u8]) -> (u64, i32) {
    let significant = number.iter().skip_while(|byte| matches!(byte, b'0' | b'.')).filter(|byte| **byte != b'.');
    if significant.count() <= MOST_DIGITS {
        return (digits, decimals);
    }
    let (mut digits, mut decimals, mut is_fraction) = (0_u64, 0_i32, false);
    for &byte in number {
        if byte == b'.' {
            is_fraction = true;
        } else if digits < 10_u64.pow(MOST_DIGITS as u32 - 1) {
            digits = digits * 10 + u64::from(byte - b'0');
            decimals += i32::from(is_fraction);
        } else {
            decimals -= i32::from(!is_fraction);
        }
    }
    (digits, decimals)
}

/// The exponent whose sign or first digit is at `at`, and its end.
fn parse_exponent(input: &[u8], at: usize) -> Option<(i32, usize)> {
    let signed = matches!(input.get(at), Some(b'+' | b'-'));
    let begin = at + usize::from(signed);
    let mut end = begin;
    let mut exponent = 0_i32;
    while let Some(byte @ b'0'..=b'9') = input.get(end) {
        exponent = (exponent * 10 + i32::from(byte - b'0')).min(LARGEST_EXPONENT);
        end += 1;
    }
    if end == begin {
        return None;
    }
    let negative = input.get(at) == Some(&b'-');
    Some((if negative { -exponent } else { exponent }, end))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The number in units of 10^-`decimals`.
    fn count(field: &str, decimals: u32) -> Option<i64> {
        Number::parse(field.as_bytes()).unwrap().times(10_i64.pow(decimals))
    }

    #[test]
    fn the_ways_to_print_a_number_are_one() {
        for field in [
            "-0.0125",
            "-000.0125",
            "-.0125",
            "-1.25e-2",
            "-125E-0004",
            "-0.00000125e+4",
            "-0.01250000000000000000000000",
        ] {
            assert_eq!(count(field, 6), Some(-12_500), "{field}");
        }
        assert_eq!(count("1e-05", 6), Some(10));
        assert_eq!(count("12", 3), Some(12_000));
        assert_eq!(count("+5.", 1), Some(50));
        assert_eq!(count("0e99999999999", 3), Some(0));
    }

    #[test]
    fn nineteen_digits_are_kept_and_zeros_at_the_head_are_none() {
        for (field, digits, decimals) in [
            ("9.999999999999999999e-03", 9_999_999_999_999_999_999, 21),
            ("0.0012345678901234567890", 1_234_567_890_123_456_789, 21),
            ("000000000000.00000000000125", 125, 14),
            ("12345678901234567890.5", 1_234_567_890_123_456_789, -1),
            ("-99999999999999999999", 9_999_999_999_999_999_999, -1),
        ] {
            let number = Number::parse(field.as_bytes()).unwrap();
            assert_eq!((number.digits, number.decimals), (digits, decimals), "{field}");
        }
    }

    #[test]
    fn other_texts_are_no_number() {
        for field in [
            "", "+", "-", ".", "-.", "nan", "inf", "1e", "1e+", "e5", "1.2.3", "0x10", "1 ", " 1", "1_0", "--1", "1,5",
            "\u{661}",
        ] {
            assert_eq!(Number::parse(field.as_bytes()), None, "{field:?}");
        }
    }

    #[test]
    fn thousands_may_be_separated() {
        for (field, value) in
            [("101,325.12", 10_132_512), ("-1,234,567", -123_456_700), ("1'000.5", 100_050), ("+12 345", 1_234_500)]
        {
            assert_eq!(count(field, 2), Some(value), "{field}");
        }
        for field in ["0,500", "1,50", "1,5000", "1234,567", "1,234'567", "1,", ",500", "1,234,56", "1.000,5", "01 234"]
        {
            assert_eq!(Number::parse(field.as_bytes()), None, "{field}");
        }
    }

    #[test]
    fn decimals_are_counted_as_printed_and_without_zeros() {
        for (field, printed, significant) in [
            ("0.500", 3, 1),
            ("1.50e-05", 7, 6),
            ("1200", 0, 0),
            ("1e5", 0, 0),
            ("0.000", 3, 0),
            ("1.234000000000000000e-03", 21, 6),
        ] {
            let number = Number::parse(field.as_bytes()).unwrap();
            assert_eq!((number.decimals.max(0), number.significant_decimals()), (printed, significant), "{field}");
        }
    }

    proptest! {
        #[test]
        fn the_standard_library_agrees(text in "[-+]?[0-9]{0,3}[.]?[0-9]{0,24}(e[-+]?[0-9]{0,2})?") {
            let float: Option<f64> = text.parse().ok();
            let number = Number::parse(text.as_bytes());
            prop_assert_eq!(number.is_some(), float.is_some());
            if let (Some(number), Some(float)) = (number, float) {
                prop_assert!((number.value() - float).abs() <= 4.0 * f64::EPSILON * float.abs());
            }
        }
    }
}
