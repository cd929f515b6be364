//! Data time: how far the record has come, which of its samples count, and their segments.

use std::{ops::Range, time::Duration};

/// Counts data time in samples from the first one, missing samples included, and selects the
/// samples that count: those after the warm-up and before the end that the user asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct MeasuredSpan {
    pub(super) skip: Duration,
    duration: Option<Duration>,
    /// The index of the first sample after the end, if the record was ended by its content.
    ended_at: Option<u64>,
    /// Absolute index of the next sample, missing samples counted.
    index: u64,
    /// Number of samples that count; `excluded` is the number of the others.
    pub(super) samples: u64,
    pub(super) excluded: u64,
    /// The number of samples behind the end, which are excluded too.
    pub(super) after_end: u64,
    pub(super) segments: u64,
    /// Whether the next sample continues the segment of the last one.
    in_segment: bool,
}

impl MeasuredSpan {
    /// A span without samples, which will exclude `skip` at the start and all after `duration`.
    pub(crate) const fn new(skip: Duration, duration: Option<Duration>) -> Self {
        Self {
            skip,
            duration,
            ended_at: None,
            index: 0,
            samples: 0,
            excluded: 0,
            after_end: 0,
            segments: 0,
            in_segment: false,
        }
    }

    pub(crate) const fn has_rows(&self) -> bool {
        self.index > 0
    }

    /// Whether a sample of the record has counted.
    pub(crate) const fn has_begun(&self) -> bool {
        self.samples > 0
    }

    /// Adds rows. Returns those that count, if any do, and the index of the first.
    pub(crate) fn push(&mut self, rows: usize, rate_hz: f64, exclude: bool) -> Option<(Range<usize>, u64)> {
        let rows_until = |index: u64| rows.min(usize::try_from(index.saturating_sub(self.index)).unwrap_or(usize::MAX));
        let before_end = rows_until(self.end(rate_hz));
        self.after_end += (rows - before_end) as u64;
        let end = if exclude { 0 } else { before_end };
        // a rate that is measured changes a little meanwhile
        let skipped = if self.has_begun() { 0 } else { rows_until(samples_in(self.skip, rate_hz)).min(end) };
        let used = (end - skipped) as u64;
        let first = self.index + skipped as u64;
        self.excluded += rows as u64 - used;
        self.index += rows as u64;
        if used == 0 {
            return None;
        }
        self.segments += u64::from(!self.in_segment);
        self.in_segment = true;
        self.samples += used;
        Some((skipped..end, first))
    }

    /// Adds missing samples. Returns how many of them count: none before the first sample that counts,
    /// after the end, or with `exclude`.
    pub(crate) fn gap(&mut self, missing: u64, rate_hz: f64, exclude: bool) -> u64 {
        if !self.has_rows() {
            return 0;
        }
        let counted = missing.min(self.end(rate_hz).saturating_sub(self.index));
        self.index += missing;
        if counted == 0 || !self.has_begun() || exclude {
            return 0;
        }
        self.break_segment();
        counted
    }

    pub(crate) fn break_segment(&mut self) {
        self.in_segment = false;
    }

    pub(crate) fn rescale(&mut self, from_hz: f64, to_hz: f64) {
        self.index = (self.index as f64 / from_hz * to_hz).round() as u64;
    }

    pub(crate) fn discard(&mut self) {
        self.excluded += self.samples;
        (self.samples, self.segments, self.in_segment) = (0, 0, false);
    }

    pub(crate) fn end_warm_up(&mut self, rate_hz: f64) {
        self.skip = self.data_time(rate_hz);
        self.discard();
    }

    pub(crate) fn start_over(&mut self, skip: Duration) {
        self.discard();
        (self.skip, self.index) = (skip, 0);
    }

    /// Ends the span here, before the end that the user asked for.
    pub(crate) fn end_here(&mut self) {
        self.ended_at = Some(self.index);
    }

    /// Whether the span is complete once `pending` data time is added.
    pub(crate) fn is_complete(&self, rate_hz: f64, pending: Duration) -> bool {
        let is_passed = self.has_rows() && self.index >= self.end(rate_hz);
        let is_asked_for = |duration| self.data_time(rate_hz).saturating_add(pending) >= duration;
        is_passed || (!pending.is_zero() && self.duration.is_some_and(is_asked_for))
    }

    pub(crate) fn data_time(&self, rate_hz: f64) -> Duration {
        Duration::try_from_secs_f64(self.index as f64 / rate_hz).unwrap_or(Duration::MAX)
    }

    pub(crate) fn seconds(&self, rate_hz: f64) -> u64 {
        (self.index as f64 / rate_hz) as u64
    }

    /// Rows until this many whole seconds have passed; at least one.
    pub(crate) fn rows_until(&self, seconds: u64, rate_hz: f64) -> u64 {
        samples_in(Duration::from_secs(seconds), rate_hz).saturating_sub(self.index).max(1)
    }

    fn end(&self, rate_hz: f64) -> u64 {
        let asked_for = self.duration.map_or(u64::MAX, |duration| samples_in(duration, rate_hz));
        self.ended_at.unwrap_or(asked_for)
    }
}

fn samples_in(time: Duration, rate_hz: f64) -> u64 {
    // what a product of doubles adds to a whole number is no sample
    const ROUNDING: f64 = 1e-6;
    (time.as_secs_f64() * rate_hz - ROUNDING).ceil() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    /// At 10 Hz, the samples with the indices 5 to 9 count.
    fn middle() -> MeasuredSpan {
        MeasuredSpan::new(seconds(0.5), Some(seconds(1.0)))
    }

    fn counts(span: &MeasuredSpan) -> (u64, u64, u64) {
        (span.samples, span.excluded, span.segments)
    }

    #[test]
    fn samples_between_the_skip_and_the_end_count() {
        let mut span = middle();
        assert_eq!(span.push(3, 10.0, false), None);
        assert_eq!(span.push(4, 10.0, false), Some((2..4, 5)));
        assert_eq!(span.push(9, 10.0, false), Some((0..3, 7)));
        assert_eq!(span.push(1, 10.0, false), None);
        assert_eq!(counts(&span), (5, 12, 1));
        let mut all = MeasuredSpan::new(Duration::ZERO, None);
        assert_eq!(all.push(7, 10.0, false), Some((0..7, 0)));
        assert_eq!(all.push(2, 10.0, true), None, "excluded");
        assert_eq!(all.push(1, 10.0, false), Some((0..1, 9)));
        assert_eq!(counts(&all), (8, 2, 1));
    }

    #[test]
    fn a_time_that_is_no_whole_sample_ends_with_the_next_one() {
        for (duration_s, rate_hz, samples) in [(1.0, 40.0, 40), (0.99, 40.0, 40), (0.976, 40.0, 40), (0.3, 10.0, 3)] {
            let mut span = MeasuredSpan::new(Duration::ZERO, Some(seconds(duration_s)));
            assert_eq!(span.push(100, rate_hz, false), Some((0..samples, 0)), "{duration_s} s");
        }
    }

    #[test]
    fn a_gap_counts_between_samples_that_do() {
        let mut span = middle();
        assert_eq!(span.gap(3, 10.0, false), 0, "before the first sample");
        span.push(2, 10.0, false);
        assert_eq!(span.gap(4, 10.0, false), 0, "before the first that counts");
        assert_eq!(span.push(1, 10.0, false), Some((0..1, 6)));
        assert_eq!(span.gap(0, 10.0, false), 0);
        assert_eq!(span.gap(1, 10.0, true), 0, "excluded");
        assert_eq!(span.gap(1, 10.0, false), 1);
        assert_eq!(counts(&span), (1, 2, 1));
        assert_eq!(span.push(9, 10.0, false), Some((0..1, 9)), "those behind are behind the end");
        let mut span = middle();
        span.push(8, 10.0, false);
        assert_eq!(span.gap(9, 10.0, false), 2, "until the end");
        let mut span = MeasuredSpan::new(Duration::ZERO, None);
        span.push(1, 10.0, false);
        assert_eq!(span.gap(2, 10.0, false), 2);
        assert_eq!(span.push(1, 10.0, false), Some((0..1, 3)));
        assert_eq!(counts(&span), (2, 0, 2));
        span.break_segment();
        assert_eq!(span.segments, 2, "it begins with the next sample");
    }

    #[test]
    fn data_time_is_complete_when_the_end_is_reached() {
        let mut span = middle();
        assert!(!span.is_complete(10.0, Duration::ZERO));
        span.push(9, 10.0, false);
        assert!(!span.is_complete(10.0, Duration::ZERO) && !span.is_complete(10.0, seconds(0.09)));
        assert!(span.is_complete(10.0, seconds(0.1)));
        span.push(1, 10.0, false);
        assert!(span.is_complete(10.0, Duration::ZERO));
        let mut endless = MeasuredSpan::new(Duration::ZERO, None);
        endless.push(1000, 10.0, false);
        assert!(!endless.is_complete(10.0, seconds(1e6)));
        assert!(
            !MeasuredSpan::new(Duration::ZERO, Some(Duration::ZERO)).is_complete(10.0, Duration::ZERO),
            "no sample"
        );
    }
}
