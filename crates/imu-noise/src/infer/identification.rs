//! The kind of noise at each averaging time, from block sums and from the slope of the curve.

use super::power_law::PowerLaw;
use crate::accumulate::aligned_sums::{LagOneSums, MAX_DIFFERENCES};
use crate::accumulate::channel::ChannelAccumulator;
use crate::accumulate::record::{Octave, RecordShape};

/// Fewer blocks do not distinguish the noise types: the standard deviation of α is 0.35 at 30.
const LEAST_BLOCKS: u64 = 30;

/// Noise type by block sums, at their length.
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

impl LagOneSums {
    /// `None` for lengths that are not kept, below 30 blocks, and for blocks that are all the same.
    pub(crate) fn lag_one(&self, m: u64) -> Option<LagOne> {
        let series = self.series(m)?;
        let blocks = series[0].count;
        if blocks < LEAST_BLOCKS {
            return None;
        }
        for (differences, series) in series.iter().enumerate() {
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

impl ChannelAccumulator {
    /// The kind of noise of each of `octaves`, whose `variances` are in any unit.
    #[must_use]
    pub fn noise_types(&self, octaves: &[Octave], variances: &[f64], shape: &RecordShape) -> Vec<NoiseType> {
        noise_types(octaves, variances, shape, |m| self.lag_one.lag_one(m))
    }
}

/// `lag_one` reads out block sums of a length.
fn noise_types(
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

#[cfg(test)]
mod tests;
