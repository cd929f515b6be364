//! The kind of noise of an octave, by the lag-one autocorrelation of its block sums.

use super::power_law::PowerLaw;
use crate::accumulate::channel::ChannelAccumulator;
use crate::accumulate::lag_one_sums::{LagOneSums, MAX_DIFFERENCES};
use crate::accumulate::record::{Octave, RecordShape};

/// Fewer blocks do not distinguish the noise types: the standard deviation of α is 0.35 at 30.
const LEAST_BLOCKS: u64 = 30;

impl LagOneSums {
    /// Exponent α of the spectrum by blocks of `m` samples: -2 (δ + differences), δ = r₁/(1 + r₁),
    /// with the lag-1 autocorrelation r₁ of their sums, differenced until stationary. `None` for
    /// lengths that are not kept, below 30 blocks, and for blocks that are all the same.
    fn alpha(&self, m: u64) -> Option<f64> {
        let series = self.series(m).filter(|series| series[0].count >= LEAST_BLOCKS)?;
        for (differences, series) in series.iter().enumerate() {
            let autocorrelation = series.lag_one_autocorrelation()?;
            let delta = autocorrelation / (1.0 + autocorrelation);
            if delta < 0.25 || differences == MAX_DIFFERENCES {
                return Some(-2.0 * (delta + differences as f64));
            }
        }
        None
    }
}

impl ChannelAccumulator {
    /// The kind of noise of each of `octaves`, whose `variances` are in any unit, by the lag-1
    /// autocorrelation of block sums (Riley and Greenhall, 2004), else by the slope of the variance
    /// to the next octave, α = -1 - log₂(V(2m)/V(m)), where kinds above α = 1 look like α = 1.
    /// `None` if neither has 30 blocks.
    #[must_use]
    pub fn noise_types(&self, octaves: &[Octave], variances: &[f64], shape: &RecordShape) -> Vec<Option<PowerLaw>> {
        noise_types(octaves, variances, shape, |m| self.lag_one.alpha(m))
    }
}

fn noise_types(
    octaves: &[Octave],
    variances: &[f64],
    shape: &RecordShape,
    by_block_sums: impl Fn(u64) -> Option<f64>,
) -> Vec<Option<PowerLaw>> {
    let by_slope = |i: usize| {
        let (here, next) = (octaves.get(i)?, octaves.get(i + 1)?);
        let doubled = next.m == 2 * here.m && shape.samples / next.m >= LEAST_BLOCKS;
        let ratio = variances.get(i + 1)? / variances.get(i)?;
        (doubled && ratio > 0.0 && ratio.is_finite()).then(|| -1.0 - ratio.log2())
    };
    let alpha = |(i, octave): (usize, &Octave)| by_block_sums(octave.m).or_else(|| by_slope(i));
    octaves.iter().enumerate().map(|place| alpha(place).map(|alpha| PowerLaw::nearest(alpha.round() as i8))).collect()
}

#[cfg(test)]
mod tests;
