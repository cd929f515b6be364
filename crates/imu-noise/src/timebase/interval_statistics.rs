//! Running statistics of the intervals between arrivals.

use schemars::JsonSchema;
use serde::Serialize;

use hdrhistogram::Histogram;

/// Samples less than this many periods apart were returned by one read.
pub(super) const TOGETHER_PERIODS: f64 = 0.2;

/// Longest interval that the percentiles distinguish: longer ones count as one hour.
const MAX_INTERVAL_US: u64 = 3_600_000_000;

/// Times between samples over the whole stream, changes of rate included; of a live link since it was up last.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Arrivals {
    /// Median time between samples in microseconds, to three digits.
    #[serde(rename = "p50")]
    pub p50_us: u64,
    /// 99th percentile in microseconds, to three digits.
    #[serde(rename = "p99")]
    pub p99_us: u64,
    /// Longest time between samples in microseconds, exactly.
    #[serde(rename = "max")]
    pub max_us: u64,
    /// Share of the samples, 0 to 1, that arrived within 0.2 nominal periods of the one before.
    pub share_together: f64,
    /// Mean number of samples per read of the host; 1 if each arrived alone.
    pub samples_together: f64,
}

#[derive(Clone, Debug)]
pub(super) struct IntervalStatistics {
    /// Always `Some`, because the bounds of the histogram are valid.
    histogram: Option<Histogram<u32>>,
    min_us: u64,
    max_us: u64,
}

impl Default for IntervalStatistics {
    fn default() -> Self {
        let histogram = Histogram::new_with_bounds(1, MAX_INTERVAL_US, 3).ok();
        Self { histogram, min_us: u64::MAX, max_us: 0 }
    }
}

impl IntervalStatistics {
    pub(super) fn push(&mut self, interval_us: u64) {
        if let Some(histogram) = &mut self.histogram {
            histogram.saturating_record(interval_us);
        }
        self.min_us = self.min_us.min(interval_us);
        self.max_us = self.max_us.max(interval_us);
    }

    /// Forgets all intervals so far.
    pub(super) fn restart(&mut self) {
        if let Some(histogram) = &mut self.histogram {
            histogram.reset();
        }
        (self.min_us, self.max_us) = (u64::MAX, 0);
    }

    pub(super) fn summary(&self, period_s: f64) -> Option<Arrivals> {
        let intervals = self.histogram.as_ref().filter(|histogram| !histogram.is_empty())?;
        // the middle of a bucket, unless it is outside the range of all intervals
        let percentile_us = |quantile: f64| {
            let middle_us = intervals.median_equivalent(intervals.value_at_quantile(quantile));
            middle_us.clamp(self.min_us, self.max_us)
        };
        let together_us = (TOGETHER_PERIODS * period_s * 1e6) as u64;
        let together = intervals.count_between(0, together_us) as f64;
        let samples = (intervals.len() + 1) as f64;
        Some(Arrivals {
            p50_us: percentile_us(0.5),
            p99_us: percentile_us(0.99),
            max_us: self.max_us,
            share_together: together / intervals.len() as f64,
            samples_together: samples / (samples - together),
        })
    }
}
