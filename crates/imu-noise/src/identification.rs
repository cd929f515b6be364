//! The kind of noise at each averaging time: from the lag-1 autocorrelation of block sums, and from
//! the slope of the curve.

mod series;

use crate::{Octave, PowerLaw, RecordShape, aligned::BLOCK};
use series::Series;

/// Times that block sums are differenced at most, as suits the Allan deviation.
const MAX_DIFFERENCES: usize = 2;

/// Fewer blocks do not tell one noise from another: the standard deviation of α is 0.35 at 30.
const LEAST_BLOCKS: u64 = 30;

/// Longest blocks, 2^26 samples: then sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004).
///
/// Shorter blocks would cost as much as all the octaves; there the degrees of freedom are many and
/// the slope tells the noise. Sums are exact integers, so that results do not depend on how samples
/// are divided over calls. Neighbours across a gap are no neighbours.
#[derive(Clone, Debug)]
pub(crate) struct Identification {
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

/// What block sums say of the noise at their length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagOne {
    /// Number of blocks.
    pub blocks: u64,
    /// How often the block sums had to be differenced to become stationary.
    pub differences: u8,
    /// Lag-1 autocorrelation r₁ of what resulted.
    pub autocorrelation: f64,
    /// Exponent α of the spectrum, not rounded: -2 (δ + differences), δ = r₁/(1 + r₁).
    pub alpha: f64,
}

impl LagOne {
    /// The nearest power law: α = -round(2 δ) - 2 · differences.
    #[must_use]
    pub fn law(&self) -> PowerLaw {
        PowerLaw::nearest(self.alpha.round().clamp(-100.0, 100.0) as i8)
    }
}

impl Identification {
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

    /// The lag-1 autocorrelation of blocks of `m` samples; `None` for lengths that are not kept,
    /// below 30 blocks, and for blocks that are all the same.
    pub(crate) fn lag_one(&self, m: u64) -> Option<LagOne> {
        let k = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        let blocks = k.series[0].count();
        if blocks < LEAST_BLOCKS {
            return None;
        }
        for (differences, series) in k.series.iter().enumerate() {
            let autocorrelation = series.lag_one_autocorrelation()?;
            let delta = autocorrelation / (1.0 + autocorrelation);
            if delta < 0.25 || differences == MAX_DIFFERENCES {
                let alpha = -2.0 * (delta + differences as f64);
                return Some(LagOne { blocks, differences: differences as u8, autocorrelation, alpha });
            }
        }
        None
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

/// The kind of noise of one octave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseType {
    /// From block sums, where these are kept and many enough.
    pub lag_one: Option<LagOne>,
    /// From the slope of the variance to the next octave, α = -1 - log₂(V(2m)/V(m)). Kinds above α
    /// = 1 look like α = 1 there. `None` at the last octave and below 30 blocks.
    pub slope_alpha: Option<f64>,
}

impl NoiseType {
    /// The nearest power law: from block sums, else from the slope.
    #[must_use]
    pub fn law(&self) -> Option<PowerLaw> {
        let from_slope = || self.slope_alpha.map(|alpha| PowerLaw::nearest(alpha.round().clamp(-100.0, 100.0) as i8));
        self.lag_one.map(|lag_one| lag_one.law()).or_else(from_slope)
    }
}

/// The kind of noise of each of `octaves`, with their `variances` in any unit; `lag_one` reads out
/// block sums of a length.
pub(crate) fn noise_types(
    octaves: &[Octave],
    variances: &[f64],
    shape: &RecordShape,
    lag_one: impl Fn(u64) -> Option<LagOne>,
) -> Vec<NoiseType> {
    let slope_alpha = |i: usize| {
        let (here, next) = (octaves.get(i)?, octaves.get(i + 1)?);
        let doubled = next.m == 2 * here.m && shape.samples / next.m >= LEAST_BLOCKS;
        let ratio = variances.get(i + 1)? / variances.get(i)?;
        (doubled && ratio > 0.0 && ratio.is_finite()).then(|| -1.0 - ratio.log2())
    };
    (0..octaves.len()).map(|i| NoiseType { lag_one: lag_one(octaves[i].m), slope_alpha: slope_alpha(i) }).collect()
}

impl Default for Identification {
    fn default() -> Self {
        Self::new(BLOCK)
    }
}

#[cfg(test)]
mod tests;
