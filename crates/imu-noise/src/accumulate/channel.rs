//! The exact sums of one channel: moments, histogram, octaves, slope.

use super::aligned_sums::{self, AlignedBlock, AlignedSums};
use super::histogram::Histogram;
use super::lag_one_sums::LagOneSums;
use super::moments::Moments;
use super::octaves::{Octaves, window_plan::WindowPlans};
use super::record::{Deviation, Estimator};
use super::stretch::Stretch;
use super::trend::Trend;

/// Moments, histogram and octave sums of one channel. The result is the same, bit by bit, for any
/// division of the samples over calls of [`push`](Self::push).
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
        for (missing, run) in stretch.runs_of(counts) {
            if missing > 0 {
                self.aligned.gap(Some(missing as u64), |block| add_block(block, &mut self.lag_one, &mut self.trend));
            }
            self.aligned.push(run, |block| add_block(block, &mut self.lag_one, &mut self.trend));
        }
    }

    /// Adds a gap; see [`Octaves::gap`]. Moments and histogram do not depend on gaps.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.octaves.gap(missing);
        self.aligned.gap(missing, |block| add_block(block, &mut self.lag_one, &mut self.trend));
        if missing.is_none_or(|missing| missing == 0) {
            self.lag_one.part();
        }
        if missing.is_none() {
            self.trend.restart();
        }
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

    /// Slope of the regression line over the record, in counts per sample; missing samples have
    /// their place on the time axis. `None` below three blocks of 64 samples with at least half of
    /// the samples each, and after a gap of unknown length.
    #[must_use]
    pub fn slope_counts(&self) -> Option<f64> {
        self.trend.slope_counts()
    }
}

fn add_block(block: AlignedBlock, lag_one: &mut LagOneSums, trend: &mut Trend) {
    if block.present == lag_one.block {
        lag_one.push(block.number, block.sum);
    }
    if 2 * block.present >= lag_one.block {
        trend.push(block);
    }
}
