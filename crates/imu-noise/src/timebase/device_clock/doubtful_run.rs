//! Samples that do not follow by one period, until a later sample decides about them.

use std::{mem, time::Duration};

use super::{
    super::sensor_rates::RUN,
    ticks::{round_to_ticks, whole_ticks},
};

/// A sample with its time by both clocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamped {
    pub(super) device_ns: u64,
    pub(super) at: Option<Duration>,
}

/// The latest samples, whose intervals are equal and not one period: a false time, the samples
/// after a gap, or the first ones at another rate.
#[derive(Clone, Debug, Default)]
pub(super) struct DoubtfulRun {
    samples: Vec<Stamped>,
}

impl DoubtfulRun {
    pub(super) const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The sample in doubt, if it is the only one.
    pub(super) fn only(&self) -> Option<Stamped> {
        match self.samples[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    pub(super) fn push(&mut self, stamped: Stamped) {
        self.samples.push(stamped);
    }

    /// Takes all samples; after this none is in doubt.
    pub(super) fn take(&mut self) -> Vec<Stamped> {
        mem::take(&mut self.samples)
    }

    /// Whether the sample begins a run, or follows it at the same number of ticks as between the
    /// samples of the run. `last_ns` is the device time before the run.
    pub(super) fn is_continued_by(&self, stamped: Stamped, last_ns: u64) -> bool {
        let (before_ns, latest_ns) = match self.samples[..] {
            [] => return true,
            [only] => (last_ns, only.device_ns),
            [.., before, latest] => (before.device_ns, latest.device_ns),
        };
        let ticks = |from_ns: u64, to_ns: u64| whole_ticks(to_ns.checked_sub(from_ns)?);
        let expected = ticks(before_ns, latest_ns);
        expected.is_some() && ticks(latest_ns, stamped.device_ns) == expected
    }

    /// The period in nanoseconds of another rate; `None` while there are too few samples to show
    /// one.
    pub(super) fn period_ns(&self) -> Option<f64> {
        match self.samples[..] {
            [first, .., latest] if self.samples.len() >= RUN => {
                let mean_ns = (latest.device_ns - first.device_ns) as f64 / (self.samples.len() - 1) as f64;
                Some(round_to_ticks(mean_ns))
            }
            _ => None,
        }
    }
}
