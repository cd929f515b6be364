//! How a CSV file is to be read, decided by its head alone.

use vn100_protocol::Layout;

use super::{resolution::Resolution, stamp::StampUnit, unended_row::LastField};

/// How a CSV file is to be read.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// What its rows are.
    pub(crate) kind: Kind,
    /// The columns that are not used, by their names in the file.
    pub(crate) ignored_columns: Vec<String>,
    /// The channels whose last digits are rounded away.
    pub(crate) rounded: Vec<String>,
    /// LF, also behind a CR; or CR, as on old Macs.
    pub(super) line_end: u8,
    pub(super) separator: u8,
    /// What each column is for.
    pub(super) columns: Vec<Column>,
    /// How the columns of channels become counts, in the order of the layout.
    pub(super) scales: Vec<Scale>,
    /// How the last fields of the first rows are printed; `None` for a sentence, which has a
    /// checksum.
    pub(super) last_field: Option<LastField>,
    /// Lines before the first row.
    pub(super) lines_above: u64,
}

/// What the rows of a CSV file are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// Numbers, one per channel. The layout is named after the message when it has exactly the
    /// channels of one, `CSV` otherwise; its decimals are the file's, and its scales lead from the
    /// file's units to the channels' own.
    Values(Layout),
    /// Sentences as the sensor sent them.
    Sentences,
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

impl Scale {
    pub(super) fn new(resolution: Resolution, limit: Option<f64>, zero_hundredths: i64) -> Self {
        let power = 10_f64.powi(resolution.decimals.into());
        // a cast saturates
        let limit_counts = limit.map_or(i32::MAX, |limit| (limit * power).round() as i32);
        Self { resolution, zero_counts: (zero_hundredths as f64 * power / 100.0) as i64, limit_counts }
    }
}

#[cfg(test)]
impl Plan {
    /// Whether the rows have stamps.
    pub(crate) fn is_stamped(&self) -> bool {
        self.columns.iter().any(|column| matches!(column, Column::Stamp(_)))
    }
}
