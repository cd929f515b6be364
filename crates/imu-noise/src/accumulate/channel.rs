//! The exact sums of one channel: moments, histogram, octaves, slope.

use super::aligned_sums::{self, AlignedSums, LagOneSums, Trend};
use super::histogram::Histogram;
use super::moments::Moments;
use super::octaves::Octaves;
use super::record::{Deviation, Estimator};

/// Samples handed to one accumulator after the other, so that they are read from the cache.
const BLOCK: usize = 256;

/// Moments, histogram and octave sums of one channel: the same, bit by bit, for any division of the
/// samples over calls of [`push`](Self::push).
#[derive(Clone, Debug)]
pub struct ChannelAccumulator {
    moments: Moments,
    histogram: Histogram,
    octaves: Octaves,
    aligned: AlignedSums,
    pub(crate) lag_one: LagOneSums,
    trend: Trend,
}

impl ChannelAccumulator {
    /// A channel without samples.
    #[must_use]
    pub fn new(estimator: Estimator, deviation: Deviation) -> Self {
        Self {
            moments: Moments::new(),
            histogram: Histogram::new(),
            octaves: Octaves::new(estimator, deviation),
            aligned: AlignedSums::new(aligned_sums::BLOCK),
            lag_one: LagOneSums::new(aligned_sums::BLOCK),
            trend: Trend::new(),
        }
    }

    /// The same, with what [`OctaveSum::without_slope`](crate::OctaveSum::without_slope) needs.
    #[must_use]
    pub fn keeping_slope(mut self) -> Self {
        self.octaves = self.octaves.keeping_slope();
        self
    }

    /// The same, with what [`Octaves::sum_at`] needs.
    #[must_use]
    pub fn keeping_runs(mut self) -> Self {
        self.octaves = self.octaves.keeping_runs();
        self
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.moments.push(block);
            self.histogram.push(block);
            self.octaves.push(block);
            self.aligned.push(block, |number, sum| {
                self.lag_one.push(number, sum);
                self.trend.push(number, sum);
            });
        }
    }

    /// Samples are missing here, see [`Octaves::gap`]. Moments and histogram do not depend on time.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.octaves.gap(missing);
        self.aligned.gap(missing);
        self.lag_one.gap();
        if missing.is_none() {
            self.trend.restart();
        }
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

    /// Slope of the regression line over the record, in counts per sample, missing samples counted
    /// as such. `None` below three blocks of 64 samples, and after a gap of unknown length.
    #[must_use]
    pub fn slope_counts(&self) -> Option<f64> {
        self.trend.slope_counts()
    }
}
