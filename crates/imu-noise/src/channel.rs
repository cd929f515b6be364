//! Everything accumulated of one channel.

use crate::{Deviation, Estimator, Histogram, Moments, Octaves};

/// Samples handed to one accumulator after the other, so that they are read from the cache.
const BLOCK: usize = 256;

/// Moments, histogram and octave sums of one channel.
///
/// Any division of the same samples over calls of [`push`](Self::push) gives the same results, bit by bit.
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

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.moments.push(block);
            self.histogram.push(block);
            self.octaves.push(block);
        }
    }

    /// Samples are missing here, see [`Octaves::gap`]. Moments and histogram do not depend on time.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.octaves.gap(missing);
    }

    /// Announces about `samples` samples without a gap, see [`Octaves::reserve`].
    pub fn reserve(&mut self, samples: usize) {
        self.octaves.reserve(samples);
    }

    /// Mean, spread, shape and extremes.
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
