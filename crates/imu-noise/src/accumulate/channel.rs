//! The exact sums of one channel: moments, histogram, octaves, slope.

use super::aligned_sums::{self, AlignedBlock, AlignedSums};
use super::histogram::Histogram;
use super::lag_one_sums::LagOneSums;
use super::moments::Moments;
use super::octaves::Octaves;
use super::piece::PieceNotAppended;
use super::record::{Deviation, Estimator};
use super::trend::Trend;

/// Samples handed to one accumulator after the other, so that they are read from the cache.
const BLOCK: usize = 256;

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
            aligned: AlignedSums::new(aligned_sums::BLOCK, 0),
            lag_one: LagOneSums::new(aligned_sums::BLOCK),
            trend: Trend::new(),
        }
    }

    /// The accumulator with the sums that [`Octaves::sum_at`] needs. To be called before any
    /// sample.
    #[must_use]
    pub fn keeping_runs(mut self) -> Self {
        self.octaves = self.octaves.keeping_runs();
        self
    }

    /// The accumulator for a piece of a record whose first sample has this absolute index. To be
    /// called before any sample.
    #[must_use]
    pub fn starting_at(mut self, index: u64) -> Self {
        self.octaves = self.octaves.starting_at(index);
        self.aligned = AlignedSums::new(aligned_sums::BLOCK, index);
        self
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.moments.push(block);
            self.histogram.push(block);
            self.octaves.push(block);
            self.aligned.push(block, |block| add_block(block, &mut self.lag_one, &mut self.trend));
        }
    }

    /// Adds a gap, see [`Octaves::gap`]. Moments and histogram do not depend on gaps.
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

    /// Appends the piece of the record that follows this one. The result is the same, bit by bit,
    /// as of one record of all samples, in whatever order neighbours are appended. Samples between
    /// the two pieces count as missing.
    ///
    /// # Errors
    /// [`PieceNotAppended`] where `next` begins before this piece ends, or was made with another
    /// estimator. Then nothing is appended.
    pub fn append(&mut self, next: &Self) -> Result<(), PieceNotAppended> {
        self.octaves.append(&next.octaves)?;
        self.moments.append(&next.moments);
        self.histogram.append(&next.histogram);
        self.aligned.append(&next.aligned, |block| add_block(block, &mut self.lag_one, &mut self.trend));
        self.lag_one.append(&next.lag_one);
        self.trend.append(&next.trend);
        Ok(())
    }

    /// Adds `by` to the counts of all samples so far. Where the counts or the bins of the histogram
    /// have no room for that, nothing is changed and `false` is returned.
    #[must_use]
    pub fn shift(&mut self, by: i64) -> bool {
        let extremes = [self.moments.min_counts(), self.moments.max_counts()];
        let has_room = extremes.into_iter().flatten().all(|count| i32::try_from(i64::from(count) + by).is_ok());
        if !has_room || by % self.histogram.bin_width_counts() as i64 != 0 {
            return false;
        }
        self.moments.shift(by);
        self.histogram.shift(by);
        self.octaves.shift(by);
        self.aligned.shift(by);
        self.lag_one.shift(by);
        self.trend.shift(by);
        true
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

state_bytes::encoded!(ChannelAccumulator { moments, histogram, octaves, aligned, lag_one, trend });

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    /// The accumulators with blocks of four samples: records as short reach many block lengths.
    fn of(start: u64, steps: &[Result<Vec<i32>, Option<u64>>]) -> (ChannelAccumulator, u64) {
        let mut channel = ChannelAccumulator::new(Estimator::Strided, Deviation::Allan).starting_at(start);
        channel.aligned = AlignedSums::new(4, start);
        channel.lag_one = LagOneSums::new(4);
        let mut end = start;
        for step in steps {
            match step {
                Ok(counts) => {
                    channel.push(counts);
                    end += counts.len() as u64;
                }
                Err(missing) => {
                    channel.gap(*missing);
                    end += missing.unwrap_or(0);
                }
            }
        }
        (channel, end)
    }

    fn steps() -> impl Strategy<Value = Vec<Result<Vec<i32>, Option<u64>>>> {
        let gap = prop_oneof![4 => (0_u64..14).prop_map(Some), 1 => Just(None)];
        let counts = prop_oneof![vec(-9000..9000, 0..60), vec(any::<i32>(), 0..4)];
        vec(prop_oneof![3 => counts.prop_map(Ok), 1 => gap.prop_map(Err)], 0..6)
    }

    proptest! {
        #[test]
        fn pieces_append_to_the_whole(
            start in prop_oneof![Just(0_u64), 0_u64..50],
            pieces in vec(steps(), 1..7),
            order in vec(any::<prop::sample::Index>(), 6),
        ) {
            let (whole, _) = of(start, &pieces.concat());
            let mut end = start;
            let mut parts = Vec::new();
            for steps in &pieces {
                let (piece, next) = of(end, steps);
                parts.push(piece);
                end = next;
            }
            for place in order {
                if parts.len() > 1 {
                    let left = place.index(parts.len() - 1);
                    let right = parts.remove(left + 1);
                    parts[left].append(&right).unwrap();
                }
            }
            let joined = parts.remove(0);
            prop_assert!(joined.octaves.sums().eq(whole.octaves.sums()));
            prop_assert_eq!(joined.moments, whole.moments);
            prop_assert_eq!(joined.histogram, whole.histogram);
            prop_assert_eq!(joined.aligned, whole.aligned);
            prop_assert_eq!(joined.lag_one, whole.lag_one);
            prop_assert_eq!(joined.trend, whole.trend);
        }
    }
}
