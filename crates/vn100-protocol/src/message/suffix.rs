//! The fields that register 30 appends to a measuring message.

use nom::{
    IResult, Parser,
    branch::alt,
    bytes::complete::take_while_m_n,
    character::complete::char,
    combinator::{map, map_opt},
    sequence::preceded,
};

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
    fn parse_fields(mut input: &[u8]) -> Option<Self> {
        let mut suffix = Self::default();
        while !input.is_empty() {
            let (rest, field) = field(input).ok()?;
            let is_second = match field {
                Field::Count(count) => suffix.count.replace(count).is_some(),
                Field::Status(status) => suffix.status.replace(status).is_some(),
            };
            if is_second {
                return None;
            }
            input = rest;
        }
        Some(suffix)
    }
}

enum Field {
    Count(u64),
    Status(u16),
}

/// `,T` and 1 to 20 digits, or `,S` and 4 hexadecimal digits.
fn field(input: &[u8]) -> IResult<&[u8], Field> {
    let digits = take_while_m_n(1, 20, |byte: u8| byte.is_ascii_digit());
    let hex_digits = take_while_m_n(4, 4, |byte| matches!(byte, b'0'..=b'9' | b'A'..=b'F'));
    // twenty digits can be a number beyond 64 bits
    let count = map_opt(digits, |digits| str::from_utf8(digits).ok()?.parse().ok());
    let status = map_opt(hex_digits, |digits| u16::from_str_radix(str::from_utf8(digits).ok()?, 16).ok());
    let fields = alt((map(preceded(char('T'), count), Field::Count), map(preceded(char('S'), status), Field::Status)));
    preceded(char(','), fields).parse(input)
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
