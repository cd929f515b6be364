//! How a CSV file is to be read, decided by its head alone.

use memchr::memmem;
use vn100_protocol::{Channel, Layout, Quantity, VNIMU, VNYMR};

use super::{
    BYTE_ORDER_MARK, CsvError,
    channel::{KNOWN, known},
    column_map::ColumnMap,
    fields::Fields,
    header::{Header, Places},
    number::{LastDigit, Number},
    stamp::StampUnit,
    survey::{self, Prior, Resolution, Survey},
};

/// How a CSV file is to be read.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// What its rows are.
    pub(crate) kind: Kind,
    /// The columns that are not used, by their names in the file.
    pub(crate) ignored_columns: Vec<String>,
    /// The channels whose last digits are rounded away.
    pub(crate) rounded: Vec<Rounded>,
    pub(super) separator: u8,
    /// What each column is for.
    pub(super) columns: Vec<Column>,
    /// How the columns of channels become counts, in the order of the layout.
    pub(super) scales: Vec<Scale>,
    /// Lines before the first row.
    pub(super) lines_above: u64,
}

/// What the rows of a CSV file are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// Numbers, one per channel.
    Values(CsvLayout),
    /// Sentences as the sensor sent them.
    Sentences,
}

/// The channels of a file of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CsvLayout {
    /// Named after the message when it has exactly the channels of one, `CSV` otherwise. `unit` is the channel's own; a count is in
    /// units of the last of `decimals` in the file's unit.
    pub(crate) layout: Layout,
    /// For each channel how many of its own unit make one of the file's: `channel.value(count) * scale` is in `channel.unit`. All 1
    /// without a column map.
    pub(crate) scale: Vec<f64>,
}

/// A channel that is printed with more digits than are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Rounded {
    pub(crate) channel: &'static str,
    /// The most decimals seen in the first rows.
    pub(crate) printed_decimals: u32,
    pub(crate) kept_decimals: u8,
}

/// What a column is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    Ignored,
    Stamp(StampUnit),
    /// The channel at this place of the layout.
    Channel(usize),
    Sentence,
}

/// How a number becomes a count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub(super) resolution: Resolution,
    /// Taken off every count.
    pub(super) zero_counts: i64,
    pub(super) limit_counts: i32,
}

/// Decides how to read the CSV file that begins with `head`; `None` when it is none, or none that holds anything of a VN-100.
///
/// Whole lines for 1000 rows are wanted in `head` ([`HEAD_BYTES`](super::HEAD_BYTES) of it); with fewer the decimals are judged by those.
///
/// Without `map` the columns are known by their names, and the numbers are in the sensor's units.
///
/// # Errors
/// [`CsvError`] when this is a CSV file but lacks the columns, or the stamps.
pub(crate) fn recognise(head: &[u8], map: Option<&ColumnMap>) -> Result<Option<Plan>, CsvError> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let lines = || head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii_end);
    for (index, line) in lines().enumerate() {
        if line.is_empty() {
            continue;
        }
        // scripts that print arrays put a # before the names of the columns
        let (comment, names) = match line.strip_prefix(b"#") {
            Some(names) => (true, names),
            None => (false, line),
        };
        let header = Header::read(names);
        let sample = Sample {
            header: &header,
            head,
            above: lines().take(index + 1).collect(),
            rows: lines().skip(index + 1).collect(),
        };
        let plan = match map {
            Some(map) => sample.mapped(map),
            None => sample.by_names(comment),
        };
        match plan {
            Ok(None) | Err(_) if comment => {}
            decided => return decided,
        }
    }
    Ok(None)
}
