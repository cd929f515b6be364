//! What the user says of a capture.

use std::path::PathBuf;

use crate::csv::ColumnMap;

/// What the user says of a capture.
#[derive(Debug, Clone, Default)]
pub struct CaptureOptions {
    /// Which columns of a CSV file, or numbers in the messages of a bag, are which channels; `None`
    /// where they are known by their names.
    pub columns: Option<ColumnMap>,
    /// The topic of a bag; `None` for the only one of a sensor. Of a table of numbers the columns
    /// to be read, by quantity or channel with spaces between them; `None` for all.
    pub topic: Option<String>,
    /// The later parts of a recording of which the capture is a part, in their order.
    pub later_parts: Vec<PathBuf>,
}
