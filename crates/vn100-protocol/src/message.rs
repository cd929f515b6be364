//! The messages that are measured: a table of their contents, and the readers of their sentences.

pub(crate) mod decimal;
pub(crate) mod decoder;
pub(crate) mod increments;
pub(crate) mod layout;
pub(crate) mod quantity;
pub(crate) mod sample;
pub(crate) mod suffix;
pub(crate) mod table;
mod template;

use thiserror::Error;

use crate::message::layout::Channel;

/// The reason why a sentence with the header of a measured message is malformed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum GrammarError {
    /// The text before the first comma is no name of a message.
    #[error("the sentence has no name of a message")]
    Name,
    /// The number of fields differs from that of the message.
    #[error("the sentence has {found} fields, {expected} are expected")]
    FieldCount {
        /// Number of values of the message.
        expected: usize,
        /// Number of fields of the sentence.
        found: usize,
    },
    /// A field is not a number.
    #[error("{channel} is no number with a sign, digits, a point and decimals, or has too many digits")]
    Number {
        /// The channel of the field.
        channel: &'static str,
    },
    /// The number of decimals fits no print format.
    #[error("{channel} has {found} decimals, {expected} are expected from the first number of the sentence")]
    Decimals {
        /// The first channel with other decimals.
        channel: &'static str,
        /// The decimals of the channel in the print format that the first field determines.
        expected: u8,
        /// The decimals of the channel in this sentence.
        found: u8,
    },
    /// The fields after the values are no suffix.
    #[error(
        "the fields after the numbers should be T with 1 to 20 digits and S with 4 hexadecimal digits, each at most once"
    )]
    Suffix,
}

/// A value beyond the limit of its channel, in a sentence with a correct checksum.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{} of {count} counts is beyond ±{} counts ({} {})", .channel.name, .channel.limit_counts,
    .channel.value(.channel.limit_counts), .channel.unit)]
pub struct RangeError {
    /// The channel, with its limit.
    pub channel: &'static Channel,
    /// The value in the sentence, in units of the last decimal of the channel.
    pub count: i64,
}
