//! How much the mean changes from window to window, and how large the spread within windows is.

use super::blocks::Sums;
use super::magnitudes::Magnitudes;

/// Change of mean from window to window and spread within windows of 32 samples, both of which stay
/// the same for white, flicker and random-walk noise.
#[derive(Clone, Debug)]
pub(crate) struct WindowStatistics {
    /// |ΔΣc| of adjacent windows.
    pub(crate) changes: Magnitudes,
    /// n Σd² - (Σd)² of each window.
    pub(crate) spreads: Magnitudes,
    /// The last full window and its sum.
    last: Option<(u64, i64)>,
}

impl WindowStatistics {
    pub(crate) const fn new() -> Self {
        Self { changes: Magnitudes::new(), spreads: Magnitudes::new(), last: None }
    }

    /// Adds a full window.
    pub(crate) fn push(&mut self, window: u64, sums: &Sums, spread: f64) {
        if let Some((last, sum)) = self.last
            && last + 1 == window
        {
            self.changes.push(window, (sums.sum() - sum).unsigned_abs() as f64);
        }
        self.last = Some((window, sums.sum()));
        self.spreads.push(window, spread);
    }

    /// The next window is not compared with the last.
    pub(crate) const fn gap(&mut self) {
        self.last = None;
    }
}
