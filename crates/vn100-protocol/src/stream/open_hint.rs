//! What the user can add so that a file can be read.

use alloc::{string::String, vec::Vec};

/// What the user can add so that a file can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OpenHint {
    /// The columns; with a fitting map, if names, units and magnitudes fit exactly one.
    Columns(Option<String>),
    /// The unit of the stamps, one of s, ms, us and ns; with a map that names one.
    StampUnit(String),
    /// The order of the dates, dmy or mdy; with a map that names one.
    DateOrder(String),
    /// The topic of a bag, one of these.
    Topic(Vec<String>),
    /// The topic of a bag, one of these, and its numbers.
    TopicAndColumns(Vec<String>),
    /// The numbers in the messages of the only topic.
    ColumnsOfTopic,
}
