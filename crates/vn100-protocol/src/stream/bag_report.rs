//! The counts of the messages of a bag.

use alloc::{string::String, vec::Vec};
use core::fmt;

use super::{AbsentValues, CsvReport};

/// The counts of the rows or messages of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileReport {
    /// The counts of the lines of a CSV file.
    Csv(CsvReport),
    /// The counts of the messages of a bag.
    Bag(BagReport),
}

/// The messages of a topic, each counted once: `messages = used + without_sample + unreadable`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct BagReport {
    /// The topic.
    pub topic: String,
    /// The type of its messages, as `package/Type`.
    #[cfg_attr(feature = "schema", serde(rename = "type"))]
    pub type_name: String,
    /// All messages of the topic.
    pub messages: u64,
    /// Messages with sentences, good or not, or with a number.
    pub used: u64,
    /// Messages without a sentence, or without a number that a count can hold.
    pub without_sample: u64,
    /// Messages that end too early, or have another form.
    pub unreadable: u64,
    /// The numbers that are absent in messages that are used, by channel.
    pub absent: Vec<AbsentValues>,
    /// Messages of other topics.
    pub other_messages: u64,
    /// Bytes unpacked to a temporary file, if the bag is compressed or comes from a stream.
    pub unpacked_bytes: u64,
    /// The record times of its first and its last message, in nanoseconds since 1970-01-01 UTC, or
    /// since the start of a simulation; `None` without a message.
    #[cfg_attr(feature = "schema", serde(skip))]
    pub recorded_ns: Option<(i64, i64)>,
    /// Which times are used.
    #[cfg_attr(feature = "schema", serde(flatten))]
    pub stamps: StampSource,
}

/// The source of the times of the messages of a bag.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
#[cfg_attr(feature = "schema", serde(rename_all = "kebab-case", tag = "stamps", content = "stamp_field"))]
pub enum StampSource {
    /// The times in the messages, in the field with this path.
    Field(String),
    /// The times of the recorder: for sentences, and if the messages have no times that increase.
    #[default]
    Recorded,
}

impl fmt::Display for StampSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field(path) => write!(f, "by {path} in the messages"),
            Self::Recorded => f.write_str("by the time of recording"),
        }
    }
}
