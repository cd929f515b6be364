//! What the measuring messages have in common: numbers, an optional suffix, and the way back to
//! bytes.

pub(crate) mod decimal;
pub(crate) mod decoder;
mod digits;
mod imu;
pub(crate) mod layout;
mod numbers;
pub(crate) mod print_format;
mod suffix;
mod template;
mod ymr;

use nom::{IResult, Parser, bytes::complete::tag};
use thiserror::Error;

pub use self::{imu::Imu, suffix::Suffix, ymr::Ymr};
use crate::{
    framing::sentence::Sentence,
    message::decimal::{Decimal, DecimalError},
    message::layout::{Channel, Layout},
};

/// Why a sentence with a measuring message's header is not that message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum GrammarError {
    /// The header is another message's.
    #[error("the header is not {expected}")]
    Header {
        /// The header of the message.
        expected: &'static str,
    },
    /// Not as many fields as the message has.
    #[error("the line has {found} fields and should have {expected}")]
    FieldCount {
        /// The numbers of the message.
        expected: usize,
        /// All fields of the line.
        found: usize,
    },
    /// A field is not a number.
    #[error("{channel}: {error}")]
    Number {
        /// The channel it stands for.
        channel: &'static str,
        /// What is wrong with it.
        error: DecimalError,
    },
    /// The numbers are not printed as any firmware prints them.
    #[error("{channel} has {found} decimals and should have {expected}, going by the first number of the line")]
    Decimals {
        /// The first channel printed otherwise.
        channel: &'static str,
        /// Its decimals in the print format that the first number chose.
        expected: u8,
        /// Its decimals in this line.
        found: u8,
    },
    /// The fields behind the numbers are not a suffix.
    #[error(
        "the fields behind the numbers should be T with 1 to 20 digits and S with 4 hexadecimal digits, each at most once"
    )]
    Suffix,
}

/// A value that no VN-100 measures, in a line whose checksum is right.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{} of {count} counts is beyond ±{} counts ({} {})", .channel.name, .channel.limit_counts,
    .channel.value(.channel.limit_counts), .channel.unit)]
pub struct RangeError {
    /// The channel, with its limit.
    pub channel: &'static Channel,
    /// What the line says, in units of the last decimal of the channel.
    pub count: i64,
}

/// Why a good sentence is not a good measurement.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum MessageError {
    /// It does not have the form of the message.
    #[error(transparent)]
    Grammar(#[from] GrammarError),
    /// A value cannot be.
    #[error(transparent)]
    Range(#[from] RangeError),
}

/// The fields of a message as printed.
struct Fields<const N: usize> {
    numbers: [Decimal; N],
    suffix: Suffix,
}

/// Counts in the decimals of the layout, with a bit for each zero that had a minus sign.
struct Counts<const N: usize> {
    counts: [i32; N],
    negative_zeros: u16,
}

/// Splits a sentence into the numbers of `layout` and a suffix.
fn parse_fields<const N: usize>(sentence: &Sentence<'_>, layout: &'static Layout) -> Result<Fields<N>, GrammarError> {
    let header: IResult<_, _> = tag(layout.message.as_bytes()).parse(sentence.body);
    let Ok((fields, _)) = header else {
        return Err(GrammarError::Header { expected: &layout.message });
    };
    split_fields(fields, layout)
}

/// Splits `fields`, each with a comma before it, into the numbers of `layout` and a suffix.
fn split_fields<const N: usize>(fields: &[u8], layout: &'static Layout) -> Result<Fields<N>, GrammarError> {
    let mut rest = fields;
    let field_count =
        || GrammarError::FieldCount { expected: N, found: fields.iter().filter(|&&byte| byte == b',').count() };
    let mut numbers = [Decimal::from_count(0, false, 0); N];
    for (number, channel) in numbers.iter_mut().zip(&*layout.channels) {
        let [b',', behind @ ..] = rest else {
            return Err(field_count());
        };
        let end = behind.iter().position(|&byte| byte == b',').unwrap_or(behind.len());
        *number =
            Decimal::parse(&behind[..end]).map_err(|error| GrammarError::Number { channel: &channel.name, error })?;
        rest = &behind[end..];
    }
    let suffix = match rest {
        [] | [b',', b'T' | b'S', ..] => Suffix::parse(rest).ok_or(GrammarError::Suffix)?,
        _ => return Err(field_count()),
    };
    Ok(Fields { numbers, suffix })
}

/// Brings printed numbers to the decimals of `layout`, which are no fewer, and judges their range.
fn scale<const N: usize>(numbers: &[Decimal; N], layout: &'static Layout) -> Result<Counts<N>, RangeError> {
    let mut scaled = Counts { counts: [0; N], negative_zeros: 0 };
    for (index, (number, channel)) in numbers.iter().zip(&*layout.channels).enumerate() {
        let mut count = i64::from(number.count());
        for _ in number.decimals()..channel.decimals {
            count *= 10;
        }
        if count.unsigned_abs() > u64::from(channel.limit_counts.unsigned_abs()) {
            return Err(RangeError { channel, count });
        }
        scaled.counts[index] = count as i32; // within the limit, which is one of 32 bits
        scaled.negative_zeros |= u16::from(number.is_negative_zero()) << index;
    }
    Ok(scaled)
}
