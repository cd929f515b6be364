//! The fields that register 30 appends to a measuring message.

use nom::{
    IResult, Parser,
    branch::alt,
    bytes::complete::{tag, take_while_m_n},
    combinator::map_opt,
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
    /// The number behind `T`: what it counts, or which time in which unit, is for register 30 to
    /// say.
    pub count: Option<u64>,
    /// The attitude filter's status word behind `S`.
    pub status: Option<u16>,
}

impl Suffix {
    /// Reads all of `input`, which begins with a comma.
    pub(super) fn parse(mut input: &[u8]) -> Option<Self> {
        let mut suffix = Self::default();
        while !input.is_empty() {
            let (rest, part) = part(input).ok()?;
            match part {
                Part::Count(count) if suffix.count.is_none() => suffix.count = Some(count),
                Part::Status(status) if suffix.status.is_none() => suffix.status = Some(status),
                _ => return None,
            }
            input = rest;
        }
        Some(suffix)
    }
}

enum Part {
    Count(u64),
    Status(u16),
}

fn part(input: &[u8]) -> IResult<&[u8], Part> {
    let is_hex = |byte| matches!(byte, b'0'..=b'9' | b'A'..=b'F');
    let count = preceded(tag(",T"), map_opt(take_while_m_n(1, 20, |byte: u8| byte.is_ascii_digit()), count));
    let status = preceded(tag(",S"), map_opt(take_while_m_n(4, 4, is_hex), status));
    alt((count, status)).parse(input)
}

/// `None` for a number beyond 64 bits, which twenty digits can be.
fn count(digits: &[u8]) -> Option<Part> {
    core::str::from_utf8(digits).ok()?.parse().ok().map(Part::Count)
}

fn status(digits: &[u8]) -> Option<Part> {
    u16::from_str_radix(core::str::from_utf8(digits).ok()?, 16).ok().map(Part::Status)
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
