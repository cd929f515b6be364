//! What the columns of a stream have printed so far, and when that asks for other counts.

use super::{
    CsvPlan,
    number::Number,
    resolution::{ColumnScan, SCANNED_ROWS, Scanned},
};

/// After so many readings no single number asks for another one, which costs all rows before it.
const MOST_READINGS: u32 = 64;

/// The columns of the rows so far. The counts are to be those of all these rows as of a whole file:
/// they are compared where a number does not fit, where the rows have doubled in number, and at the
/// end.
pub(super) struct SoFar {
    columns: Vec<ColumnScan>,
    rows: u64,
    /// The last line among them: one that comes again changes nothing.
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

    /// Adds the numbers of a good row that come for the first time.
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

    /// Whether the counts are to be compared now.
    pub(super) const fn is_due(&self) -> bool {
        self.is_due
    }

    /// The plan with the counts of all rows so far, where these are others.
    pub(super) fn other_counts(&mut self, plan: &CsvPlan) -> Option<CsvPlan> {
        self.is_due = false;
        let mut other = plan.clone();
        other.quantize(&self.columns, Scanned::Whole);
        (other.quantizers != plan.quantizers).then_some(other)
    }

    /// Counts that the rows so far are read again.
    pub(super) const fn count_reading(&mut self) {
        self.readings += 1;
    }

    /// How often they were.
    pub(super) const fn readings(&self) -> u32 {
        self.readings
    }
}
