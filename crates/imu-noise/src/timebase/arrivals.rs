//! How lines arrive: the times between them and how many come at once.

use hdrhistogram::Histogram;

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

    pub(super) fn push(&mut self, interval_us: u64) {
        self.histogram.saturating_record(interval_us);
    }

    pub(super) fn count(&self) -> u64 {
        self.histogram.len()
    }

    pub(super) fn quantile_us(&self, quantile: f64) -> u64 {
        self.histogram.value_at_quantile(quantile)
    }

    /// Part of the lines that came together with the line before.
    pub(super) fn share_together(&self, period_s: f64) -> f64 {
        let limit_us = (TOGETHER_PERIODS * period_s * 1e6) as u64;
        let together = self.histogram.count_between(0, limit_us);
        together as f64 / self.histogram.len().max(1) as f64
    }
}
