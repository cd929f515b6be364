//! What the columns of a stream have printed so far, and when that requires another size of a
//! count.

use super::{
    CsvPlan,
    number::Number,
    resolution::{ColumnScan, SCANNED_ROWS, Scanned},
};

/// After this many readings a single number does not cause another one, in which all rows before it
/// are read again.
const MOST_READINGS: u32 = 64;

/// The columns of the rows so far. The size of a count is to be that of a file with all these rows:
/// it is compared where a number does not fit, where the number of rows has doubled, and at the
/// end.
pub(super) struct SoFar {
    columns: Vec<ColumnScan>,
    rows: u64,
    /// The last line among them; a line that is read again has no effect.
    line: u64,
    compared_at: u64,
    is_due: bool,
    readings: u32,
}

impl SoFar {
    pub(super) fn new(columns: usize) -> Self {
        let columns = vec![ColumnScan::default(); columns];
        Self { columns, rows: 0, line: 0, compared_at: SCANNED_ROWS as u64, is_due: false, readings: 0 }
    }

    /// Adds the numbers of a valid row that is read for the first time.
    pub(super) fn add(&mut self, line: u64, numbers: &[Option<Number>], plan: &CsvPlan) {
        if line <= self.line {
            return;
        }
        self.line = line;
        self.rows += 1;
        for ((column, number), quantizer) in self.columns.iter_mut().zip(numbers).zip(&plan.quantizers) {
            let Some(number) = number else { continue };
            let grows = column.add(number);
            self.is_due |= grows && self.readings < MOST_READINGS && !quantizer.holds(number);
        }
        if self.rows == self.compared_at {
            (self.is_due, self.compared_at) = (true, 2 * self.rows);
        }
    }

    /// Whether the size of a count is to be compared now.
    pub(super) const fn is_due(&self) -> bool {
        self.is_due
    }

    /// The plan with the size of a count by all rows so far; `None` where it has not changed.
    pub(super) fn other_counts(&mut self, plan: &CsvPlan) -> Option<CsvPlan> {
        self.is_due = false;
        let mut other = plan.clone();
        other.quantize(&self.columns, Scanned::Whole);
        (other.quantizers != plan.quantizers).then_some(other)
    }

    /// Notes that the rows so far are read again.
    pub(super) const fn count_reading(&mut self) {
        self.readings += 1;
    }

    /// How often they were read again.
    pub(super) const fn readings(&self) -> u32 {
        self.readings
    }
}
