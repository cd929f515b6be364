//! The columns that hold the stamps of the rows.

use super::{ColumnUse, date::DateForm, stamp::StampForm};

/// The columns of the stamps, in the order in which they are added.
#[derive(Debug, Clone)]
pub(super) struct StampColumns {
    pub(super) columns: Vec<(usize, ColumnUse)>,
    /// The time from a row to the next one with the same stamp; `None` where it is usual that rows
    /// share a stamp.
    pub(super) repeated_step_ns: Option<i64>,
}

impl StampColumns {
    /// The form of dates and times of day.
    pub(super) fn clock(&self) -> Option<DateForm> {
        self.columns.iter().find_map(|&(_, column)| match column {
            ColumnUse::Stamp(StampForm::Date(form)) => Some(form),
            _ => None,
        })
    }
}
