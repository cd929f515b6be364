//! Sums for the lag-1 autocorrelation of block sums at each block length.

mod series;

use super::aligned::BLOCK;
use series::Series;

/// Times that block sums are differenced at most, as suits the Allan deviation.
pub(crate) const MAX_DIFFERENCES: usize = 2;

/// Longest blocks, 2^26 samples: then sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004).
///
/// Shorter blocks would cost as much as all the octaves; there the degrees of freedom are many and
/// the slope shows the noise type. Sums are exact integers, so that results do not depend on how samples
/// are divided over calls. Neighbours across a gap are no neighbours.
#[derive(Clone, Debug)]
pub(crate) struct LagOneSums {
    block: u64,
    levels: Vec<Level>,
}

/// Blocks of one length.
#[derive(Clone, Debug, Default)]
struct Level {
    /// By number of differences taken.
    series: [Series; MAX_DIFFERENCES + 1],
    /// The first half of a block of the next level.
    half: Option<i64>,
}

impl LagOneSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, levels: Vec::new() }
    }

    /// Takes the block with that number on the grid.
    #[inline]
    pub(crate) fn push(&mut self, mut number: u64, mut sum: i64) {
        let mut k = 0;
        loop {
            if k == self.levels.len() {
                if self.block << k > LONGEST {
                    return;
                }
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[k];
            level.push(sum);
            if number & 1 == 0 {
                level.half = Some(sum);
                return;
            }
            let Some(half) = level.half.take() else { return };
            sum += half;
            number /= 2;
            k += 1;
        }
    }

    /// What comes next is no neighbour of what came before.
    pub(crate) fn gap(&mut self) {
        for level in &mut self.levels {
            level.half = None;
            level.series.iter_mut().for_each(Series::gap);
        }
    }

    /// Blocks of `m` samples, by the number of differences taken; `None` for lengths that are not
    /// kept.
    pub(crate) fn series(&self, m: u64) -> Option<&[Series; MAX_DIFFERENCES + 1]> {
        let level = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        Some(&level.series)
    }
}

impl Level {
    #[inline]
    fn push(&mut self, sum: i64) {
        let mut value = sum;
        for series in &mut self.series {
            let Some(difference) = series.push(value) else { return };
            value = difference;
        }
    }
}

impl Default for LagOneSums {
    fn default() -> Self {
        Self::new(BLOCK)
    }
}
