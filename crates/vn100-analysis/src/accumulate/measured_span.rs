//! Data time: how far the record has come, which of its samples count, and their segments.

use std::{ops::Range, time::Duration};

/// Counts data time in samples from the first one, dropped ones included, and selects those that
/// count: behind the warm-up, and before the end that the user asked for.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredSpan {
    skip: Duration,
    duration: Option<Duration>,
    /// Absolute index of the next sample, dropped ones counted.
    index: u64,
    samples: u64,
    left_out: u64,
    segments: u64,
    /// Whether the next sample continues the segment of the last one.
    in_segment: bool,
}

impl MeasuredSpan {
    /// No sample yet; leaves out `skip` at the start, and what comes after `duration`.
    pub(crate) const fn new(skip: Duration, duration: Option<Duration>) -> Self {
        Self { skip, duration, index: 0, samples: 0, left_out: 0, segments: 0, in_segment: false }
    }

    /// Adds rows without a gap between them. Gives those that count and the index of the first of
    /// them; `None` if none does, as when `leave_out` is set.
    pub(crate) fn push(&mut self, rows: usize, rate_hz: f64, leave_out: bool) -> Option<(Range<usize>, u64)> {
        let rows_until = |index: u64| rows.min(usize::try_from(index.saturating_sub(self.index)).unwrap_or(usize::MAX));
        let end = if leave_out { 0 } else { rows_until(self.end(rate_hz)) };
        let skipped = rows_until(samples_in(self.skip, rate_hz)).min(end);
        let used = (end - skipped) as u64;
        let first = self.index + skipped as u64;
        self.left_out += rows as u64 - used;
        self.index += rows as u64;
        if used == 0 {
            return None;
        }
        self.segments += u64::from(!self.in_segment);
        self.in_segment = true;
        self.samples += used;
        Some((skipped..end, first))
    }

    /// Samples are missing before the next row. Gives how many of them count: none before the first
    /// sample that does, behind the end, or where `leave_out` is set.
    pub(crate) fn gap(&mut self, missing: u64, rate_hz: f64, leave_out: bool) -> u64 {
        if self.index == 0 {
            return 0;
        }
        let counted = missing.min(self.end(rate_hz).saturating_sub(self.index));
        self.index += missing;
        if counted == 0 || self.samples == 0 || leave_out {
            return 0;
        }
        self.break_segment();
        counted
    }

    /// The next sample begins another segment.
    pub(crate) fn break_segment(&mut self) {
        self.in_segment = false;
    }

    /// Data time so far was counted at another rate.
    pub(crate) fn rescale(&mut self, from_hz: f64, to_hz: f64) {
        self.index = (self.index as f64 / from_hz * to_hz).round() as u64;
    }

    /// Leaves out the samples so far.
    pub(crate) fn discard(&mut self) {
        self.left_out += self.samples;
        (self.samples, self.segments, self.in_segment) = (0, 0, false);
    }

    /// Everything so far was warm-up.
    pub(crate) fn end_warm_up(&mut self, rate_hz: f64) {
        self.skip = self.data_time(rate_hz);
        self.discard();
    }

    /// Data time, and what was asked for in it, begins here.
    pub(crate) fn start_over(&mut self, skip: Duration) {
        self.discard();
        (self.skip, self.index) = (skip, 0);
    }

    /// Whether the data time asked for has passed; `pending` comes on top of it.
    pub(crate) fn is_complete(&self, rate_hz: f64, pending: Duration) -> bool {
        let is_passed = self.index > 0 && self.index >= self.end(rate_hz);
        let is_asked_for = |duration| self.data_time(rate_hz).saturating_add(pending) >= duration;
        is_passed || (!pending.is_zero() && self.duration.is_some_and(is_asked_for))
    }

    pub(crate) fn data_time(&self, rate_hz: f64) -> Duration {
        Duration::try_from_secs_f64(self.index as f64 / rate_hz).unwrap_or(Duration::MAX)
    }

    /// Whole seconds of data time.
    pub(crate) fn seconds(&self, rate_hz: f64) -> u64 {
        (self.index as f64 / rate_hz) as u64
    }

    /// Data time left out at the start.
    pub(crate) const fn skip(&self) -> Duration {
        self.skip
    }

    /// Samples that count.
    pub(crate) const fn samples(&self) -> u64 {
        self.samples
    }

    pub(crate) const fn left_out(&self) -> u64 {
        self.left_out
    }

    pub(crate) const fn segments(&self) -> u64 {
        self.segments
    }

    /// Index behind the last sample asked for.
    fn end(&self, rate_hz: f64) -> u64 {
        self.duration.map_or(u64::MAX, |duration| samples_in(duration, rate_hz))
    }
}

/// The index of the first sample at or behind this data time.
fn samples_in(time: Duration, rate_hz: f64) -> u64 {
    // what a product of doubles adds to a whole number is no sample
    const ROUNDING: f64 = 1e-6;
    (time.as_secs_f64() * rate_hz - ROUNDING).ceil() as u64
}
