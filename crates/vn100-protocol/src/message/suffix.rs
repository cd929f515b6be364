//! The fields that register 30 appends to a measuring message.

use crate::register::fields::integer;

/// The optional last fields of a message: a count or time, and a status word, in either order.
///
/// ```text
/// …,-00.000391 ,T0000000543 ,S0000 *HH
///               '- digits    '- 4 hexadecimal digits
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Suffix {
    /// The number after `T`: register 30 determines whether it is a count or a time, and its unit.
    pub count: Option<u64>,
    /// The attitude filter's status word after `S`.
    pub status: Option<u16>,
}

impl Suffix {
    /// Reads all of `input`, which is empty or begins with a comma.
    #[inline]
    pub(super) fn parse(input: &[u8]) -> Option<Self> {
        if input.is_empty() { Some(Self::default()) } else { Self::parse_fields(input) }
    }

    #[inline(never)]
    fn parse_fields(input: &[u8]) -> Option<Self> {
        let mut suffix = Self::default();
        for field in str::from_utf8(input).ok()?.strip_prefix(',')?.split(',') {
            let is_status = |digits: &str| digits.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'A'..=b'F'));
            let is_second = match field.split_at_checked(1)? {
                ("T", digits) if digits.len() <= 20 => suffix.count.replace(integer(digits)?).is_some(),
                ("S", digits) if digits.len() == 4 && is_status(digits) => {
                    suffix.status.replace(u16::from_str_radix(digits, 16).ok()?).is_some()
                }
                _ => return None,
            };
            if is_second {
                return None;
            }
        }
        Some(suffix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_order_and_padding_are_read() {
        for (text, count, status) in [
            ("", None, None),
            (",T0", Some(0), None),
            (",T0000000543", Some(543), None),
            (",T18446744073709551615", Some(u64::MAX), None),
            (",S0000", None, Some(0)),
            (",T1162704,S00FF", Some(1_162_704), Some(0xFF)),
            (",S09AF,T0007", Some(7), Some(0x9AF)),
        ] {
            assert_eq!(Suffix::parse(text.as_bytes()), Some(Suffix { count, status }), "{text}");
        }
    }

    #[test]
    fn anything_else_is_refused() {
        for text in [
            ",",
            ",T",
            ",S",
            ",S123",
            ",S12345",
            ",S00ff",
            ",T1.5",
            ",T-1",
            ",T+1",
            ",T1,T2",
            ",S0000,S0000",
            ",T1,S0000,T1",
            ",T1,",
            ",T18446744073709551616",
            ",T000000000000000000001",
            ",X1",
            ",T1S0000",
            ",T 1",
        ] {
            assert_eq!(Suffix::parse(text.as_bytes()), None, "{text}");
        }
    }
}
