//! How the sensor printed its numbers.

use vn100_protocol::PrintFormat;

/// The formats of a stream: the format before its first row, and each change of it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Printed {
    format: Option<PrintFormat>,
    pub(super) coarsest: PrintFormat,
    pub(super) changes: u64,
}

impl Printed {
    /// Adds a format. Returns whether it changes, and the resolution with it.
    pub(crate) fn push(&mut self, format: PrintFormat) -> bool {
        if format != PrintFormat::Current {
            self.coarsest = format;
        }
        let before = self.format.replace(format);
        self.changes += u64::from(before.is_some());
        before.is_some()
    }
}
