//! What the user says of a capture.

use std::path::PathBuf;

use crate::csv::ColumnMap;

/// What the user says of a capture.
#[derive(Debug, Clone, Default)]
pub struct CaptureOptions {
    /// Which columns of a CSV file, or numbers in the messages of a bag, are which channels; `None`
    /// to recognise them by their names.
    pub columns: Option<ColumnMap>,
    /// The topic of a bag; `None` for the only topic of a sensor. For a table of numbers the
    /// columns to be read, by quantity or channel, separated by spaces; `None` for all columns.
    pub topic: Option<String>,
    /// The paths of the later parts, in order, where the capture is the first part of a recording.
    pub later_parts: Vec<PathBuf>,
}
