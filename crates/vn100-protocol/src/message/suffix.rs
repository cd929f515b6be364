//! The fields that register 30 appends to a measuring message.

use core::fmt;

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
    count: u64,
    /// The digits that the count is printed with; 0 when there is none.
    count_digits: u8,
    status: Option<u16>,
    status_first: bool,
}

impl Suffix {
    /// The number behind `T`: what it counts, or which time in which unit, is for register 30 to
    /// say.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        (self.count_digits > 0).then_some(self.count)
    }

    /// The attitude filter's status word behind `S`.
    #[must_use]
    pub fn status(&self) -> Option<u16> {
        self.status
    }

    /// Reads all of `input`, which begins with a comma.
    pub(super) fn parse(mut input: &[u8]) -> Option<Self> {
        let mut suffix = Self::default();
        while !input.is_empty() {
            let (rest, part) = part(input).ok()?;
            match part {
                Part::Count(count, digits) if suffix.count_digits == 0 => {
                    (suffix.count, suffix.count_digits) = (count, digits)
                }
                Part::Status(status) if suffix.status.is_none() => {
                    suffix.status = Some(status);
                    suffix.status_first = suffix.count_digits == 0;
                }
                _ => return None,
            }
            input = rest;
        }
        // without a count there is no order to remember
        suffix.status_first &= suffix.count_digits > 0;
        Some(suffix)
    }

    pub(super) fn write(&self, out: &mut impl fmt::Write) -> fmt::Result {
        if self.status_first {
            self.write_status(out)?;
        }
        if self.count_digits > 0 {
            write!(out, ",T{:0digits$}", self.count, digits = usize::from(self.count_digits))?;
        }
        if !self.status_first {
            self.write_status(out)?;
        }
        Ok(())
    }

    fn write_status(&self, out: &mut impl fmt::Write) -> fmt::Result {
        self.status.map_or(Ok(()), |status| write!(out, ",S{status:04X}"))
    }
}

enum Part {
    /// A number, and how many digits it has.
    Count(u64, u8),
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
    let value = core::str::from_utf8(digits).ok()?.parse().ok()?;
    Some(Part::Count(value, digits.len() as u8))
}

fn status(digits: &[u8]) -> Option<Part> {
    u16::from_str_radix(core::str::from_utf8(digits).ok()?, 16).ok().map(Part::Status)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_order_and_padding_come_back() {
        for text in [",T0", ",T0000000543", ",T18446744073709551615", ",S0000", ",T1162704,S0000", ",S09AF,T0007"] {
            let suffix = Suffix::parse(text.as_bytes()).unwrap();
            let mut out = String::new();
            suffix.write(&mut out).unwrap();
            assert_eq!(out, text);
        }
        let both = Suffix::parse(b",T1162704,S00FF").unwrap();
        assert_eq!((both.count(), both.status()), (Some(1_162_704), Some(0xFF)));
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
