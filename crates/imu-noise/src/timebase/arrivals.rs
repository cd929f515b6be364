//! Statistics of the times between lines.

use std::collections::VecDeque;

use hdrhistogram::Histogram;

use super::Arrivals;

/// Longest interval told apart, one hour; longer ones count as one hour in the percentiles.
const MAX_INTERVAL_US: u64 = 3_600_000_000;

/// Lines closer than this part of a period came together.
pub(super) const TOGETHER_PERIODS: f64 = 0.2;

/// Statistics of the times between consecutive lines, in microseconds as the host stamped them.
#[derive(Clone, Debug)]
pub(super) struct Intervals {
    /// Three digits; always there, as the bounds are valid. Counts of 32 bits halve the memory, and
    /// 248 days at 200 Hz fit into one.
    histogram: Option<Histogram<u32>>,
    least_us: u64,
    most_us: u64,
    /// Those before the lines that have no place yet; `None` before one that a clock begins with.
    unplaced_us: VecDeque<Option<u64>>,
}

impl Intervals {
    pub(super) fn new() -> Self {
        let histogram = Histogram::new_with_bounds(1, MAX_INTERVAL_US, 3).ok();
        Self { histogram, least_us: u64::MAX, most_us: 0, unplaced_us: VecDeque::new() }
    }

    /// Takes the time between the next line and the one before, if their clock is the same. It
    /// counts once the line has its place.
    pub(super) fn hold(&mut self, interval_us: Option<u64>) {
        self.unplaced_us.push_back(interval_us);
    }

    /// The next so many lines have their place.
    pub(super) fn place(&mut self, lines: u64) {
        for _ in 0..lines {
            match self.unplaced_us.pop_front() {
                Some(Some(interval_us)) => self.push(interval_us),
                Some(None) => {}
                // lines without a use for their stamps are not held
                None => return,
            }
        }
    }

    /// What the intervals say, for lines this far apart; nothing without an interval.
    pub(super) fn summary(&self, period_s: f64) -> Option<Arrivals> {
        let intervals = self.histogram.as_ref().filter(|histogram| !histogram.is_empty())?;
        // The middle of a bucket, unless it lies outside of all that was seen.
        let percentile_us = |quantile: f64| {
            let middle_us = intervals.median_equivalent(intervals.value_at_quantile(quantile));
            middle_us.clamp(self.least_us, self.most_us)
        };
        let together_us = (TOGETHER_PERIODS * period_s * 1e6) as u64;
        let together = intervals.count_between(0, together_us) as f64;
        let share_together = together / intervals.len() as f64;
        let lines = (intervals.len() + 1) as f64;
        Some(Arrivals {
            p50_us: percentile_us(0.5),
            p99_us: percentile_us(0.99),
            max_us: self.most_us,
            share_together,
            lines_together: lines / (lines - together),
        })
    }

    fn push(&mut self, interval_us: u64) {
        if let Some(histogram) = &mut self.histogram {
            histogram.saturating_record(interval_us);
        }
        self.least_us = self.least_us.min(interval_us);
        self.most_us = self.most_us.max(interval_us);
    }
}
