//! The exact sums of one channel: moments, histogram, octaves.

use super::histogram::Histogram;
use super::moments::Moments;
use super::octaves::{Octaves, window_plan::WindowPlans};
use super::record::{Deviation, Estimator};
use super::stretch::Stretch;

/// Moments, histogram and octave sums of one channel. The result is the same, bit by bit, for any
/// division of the samples over calls of [`push`](Self::push).
#[derive(Clone, Debug)]
pub struct ChannelAccumulator {
    moments: Moments,
    histogram: Histogram,
    octaves: Octaves,
}

impl ChannelAccumulator {
    /// A channel without samples.
    #[must_use]
    pub fn new(estimator: Estimator, deviation: Deviation) -> Self {
        Self { moments: Moments::new(), histogram: Histogram::new(), octaves: Octaves::new(estimator, deviation) }
    }

    /// The accumulator with the sums that [`Octaves::sum_at`] needs. Must be called before any
    /// sample.
    #[must_use]
    pub fn keeping_runs(mut self) -> Self {
        self.octaves = self.octaves.keeping_runs();
        self
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        for counts in counts.chunks(Stretch::MOST) {
            self.push_stretch(counts, &Stretch::full(counts.len()), &mut WindowPlans::new());
        }
    }

    /// Adds the samples of a stretch, in time order: like [`push`](Self::push) of its runs and
    /// [`gap`](Self::gap) between them. `plans` are for all channels of the stretch.
    pub fn push_stretch(&mut self, counts: &[i32], stretch: &Stretch, plans: &mut WindowPlans) {
        self.moments.push(counts);
        self.histogram.push(counts);
        self.octaves.push_stretch(counts, stretch, plans);
    }

    /// Adds a gap; see [`Octaves::gap`]. Moments and histogram do not depend on gaps.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.octaves.gap(missing);
    }

    /// Moments and extremes of the samples.
    #[must_use]
    pub const fn moments(&self) -> &Moments {
        &self.moments
    }

    /// Frequencies of the values.
    #[must_use]
    pub const fn histogram(&self) -> &Histogram {
        &self.histogram
    }

    /// Sums of the Allan or Hadamard deviation.
    #[must_use]
    pub const fn octaves(&self) -> &Octaves {
        &self.octaves
    }
}
