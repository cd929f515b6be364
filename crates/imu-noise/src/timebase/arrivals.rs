//! Statistics of the times between lines.

use hdrhistogram::Histogram;

use super::Arrivals;

/// Longest interval told apart, one hour; longer ones count as one hour.
const MAX_INTERVAL_US: u64 = 3_600_000_000;

/// Lines closer than this part of a period came together.
pub(super) const TOGETHER_PERIODS: f64 = 0.2;

/// Statistics of the times between consecutive lines, in microseconds as the host stamped them.
#[derive(Clone, Debug)]
pub(super) struct Intervals {
    histogram: Histogram<u64>,
}

impl Intervals {
    #[expect(clippy::expect_used, reason = "the bounds are constant and valid")]
    pub(super) fn new() -> Self {
        let histogram = Histogram::new_with_bounds(1, MAX_INTERVAL_US, 3).expect("valid bounds");
        Self { histogram }
    }

    /// Adds the time between a line and the one before.
    pub(super) fn push(&mut self, interval_us: u64) {
        self.histogram.saturating_record(interval_us);
    }

    /// What the intervals say, for lines this far apart; nothing without an interval.
    pub(super) fn summary(&self, period_s: f64) -> Option<Arrivals> {
        let intervals = &self.histogram;
        if intervals.is_empty() {
            return None;
        }
        let together_us = (TOGETHER_PERIODS * period_s * 1e6) as u64;
        let together = intervals.count_between(0, together_us) as f64;
        let share_together = together / intervals.len() as f64;
        let lines = (intervals.len() + 1) as f64;
        Some(Arrivals {
            p50_us: intervals.value_at_quantile(0.5),
            p99_us: intervals.value_at_quantile(0.99),
            max_us: intervals.max(),
            share_together,
            lines_together: lines / (lines - together),
        })
    }
}
