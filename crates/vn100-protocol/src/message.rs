//! The messages that are measured: a table of what they hold, and how their sentences are read.

pub(crate) mod decimal;
pub(crate) mod decoder;
pub(crate) mod increments;
pub(crate) mod layout;
mod numbers;
pub(crate) mod quantity;
pub(crate) mod sample;
pub(crate) mod suffix;
pub(crate) mod table;
mod template;

use thiserror::Error;

use crate::message::{decimal::DecimalError, layout::Channel};

/// Why a sentence with a measuring message's header is not that message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum GrammarError {
    /// What is before the first comma is no name of a message.
    #[error("the sentence has no name of a message")]
    Name,
    /// Not as many fields as the message has.
    #[error("the sentence has {found} fields, {expected} are expected")]
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
    #[error("{channel} has {found} decimals, {expected} are expected from the first number of the sentence")]
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
        "the fields after the numbers should be T with 1 to 20 digits and S with 4 hexadecimal digits, each at most once"
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
    /// The value of the line, in units of the last decimal of the channel.
    pub count: i64,
}
