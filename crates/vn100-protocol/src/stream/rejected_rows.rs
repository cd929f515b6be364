//! The counts of the lines of a CSV file, with the reasons for rejected rows.

use alloc::{string::String, vec::Vec};
use core::fmt;

/// The reason why a row of a CSV file was rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
#[cfg_attr(feature = "schema", serde(rename_all = "kebab-case"))]
pub enum RejectedRow {
    /// It has more or fewer fields than the header, or no sentence in the field for it.
    Fields,
    /// A field is no number, or no channel has one.
    Number,
    /// The stamp is no number, or more than 292 years from the first.
    Stamp,
    /// The line is longer than 64 KiB.
    Length,
    /// The last line has no line end, and its last field is missing or has another form than those
    /// above: the file may be cut there.
    Truncated,
}

/// The lines of a CSV file, each counted once: `lines = rows + skipped_lines + rejected rows +
/// other_stream_rows`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct CsvReport {
    /// All lines.
    pub lines: u64,
    /// Valid rows.
    pub rows: u64,
    /// Header, comments and blank lines.
    pub skipped_lines: u64,
    /// Rejected rows, one entry for each reason.
    #[cfg_attr(feature = "schema", serde(rename = "odd"))]
    pub rejected: Vec<RejectedRows>,
    /// Rows with numbers of other streams alone; `None` where all columns of numbers are read.
    #[cfg_attr(feature = "schema", serde(skip_serializing_if = "Option::is_none"))]
    pub other_stream_rows: Option<u64>,
    /// The columns of the stamps and their forms, as written in a column map; `None` without any.
    pub times: Option<String>,
    /// The stamp from which the times of the rows are counted, in nanoseconds as written; `None`
    /// without any.
    #[cfg_attr(feature = "schema", serde(skip))]
    pub first_stamp_ns: Option<i64>,
    /// Columns that are not used, by their names in the file.
    pub ignored_columns: Vec<String>,
    /// Columns whose names tell their content, but that are not read.
    pub left_out: Vec<LeftOutColumn>,
    /// Channels whose last digits are rounded, because they have more than a count can hold.
    pub rounded: Vec<String>,
    /// Channels that are absent in otherwise good rows, one entry for each such channel.
    pub absent: Vec<AbsentValues>,
}

/// A column whose name tells its content, but that is not read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct LeftOutColumn {
    /// The name in the file.
    #[cfg_attr(feature = "schema", serde(rename = "column"))]
    pub name: String,
    /// Why it is not read, in words.
    pub reason: String,
}

/// The number of good rows of a CSV file, or of messages of a bag, that lack a channel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct AbsentValues {
    /// The channel, by name.
    pub channel: String,
    /// The field is empty.
    pub empty: u64,
    /// The field states that there is no number, such as `nan`, `inf` or `null`.
    pub not_a_number: u64,
    /// The number is beyond what the sensor can give, or beyond the counts that fit all others.
    pub out_of_range: u64,
    /// Number of the first such line, or message, from 1.
    pub first_line: u64,
}

impl AbsentValues {
    /// The number of absences for any reason.
    pub const fn total(&self) -> u64 {
        self.empty + self.not_a_number + self.out_of_range
    }
}

/// Rows of a CSV file rejected for one reason.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct RejectedRows {
    /// The reason.
    pub reason: RejectedRow,
    /// The number of rows.
    pub count: u64,
    /// Number of the first such line, from 1.
    pub first_line: u64,
    /// The beginning of this line.
    pub first_text: String,
}

/// Rejected rows of a CSV file, by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RejectedRowCounts {
    counts: [u64; RejectedRow::ALL.len()],
}

impl RejectedRow {
    /// All reasons.
    pub const ALL: [Self; 5] = [Self::Fields, Self::Number, Self::Stamp, Self::Length, Self::Truncated];
}

impl RejectedRowCounts {
    /// The reasons that occurred, and the number of rows for each.
    pub fn iter(&self) -> impl Iterator<Item = (RejectedRow, u64)> {
        let counted = RejectedRow::ALL.into_iter().zip(self.counts);
        counted.filter(|(_, count)| *count > 0)
    }

    /// Rows for any reason.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Counts a row.
    pub fn count(&mut self, kind: RejectedRow) {
        self.counts[kind as usize] += 1;
    }
}

impl fmt::Display for RejectedRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fields => "fields",
            Self::Number => "number",
            Self::Stamp => "stamp",
            Self::Length => "length",
            Self::Truncated => "truncated",
        })
    }
}
