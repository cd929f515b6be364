//! Options that the user sets for a capture.

use std::path::PathBuf;

use crate::csv::ColumnMap;

/// Options that the user sets for a capture.
#[derive(Debug, Clone, Default)]
pub struct CaptureOptions {
    /// The assignment of columns of a CSV file, or of numbers in the messages of a bag, to
    /// channels; `None` to recognise them by their names.
    pub columns: Option<ColumnMap>,
    /// The topic of a bag; `None` for the only topic of a sensor. For a table of numbers: the
    /// columns to be read, by quantity or channel, separated by spaces; `None` for all columns.
    pub topic: Option<String>,
    /// The paths of the later parts, in order, if the capture is the first part of a recording.
    pub later_parts: Vec<PathBuf>,
}
