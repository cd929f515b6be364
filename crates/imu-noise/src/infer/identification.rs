//! The kind of noise of an octave, by the slope of the curve.

use super::power_law::PowerLaw;
use crate::accumulate::record::{Octave, RecordShape};

/// Fewer blocks do not distinguish the noise types: the standard deviation of α is 0.35 at 30.
const LEAST_BLOCKS: u64 = 30;

/// The kind of noise of each of `octaves`, by the slope of the variance in any unit to the next one,
/// α = -1 - log₂(V(2m)/V(m)), 1 at most; `None` if the next octave has fewer than 30 blocks.
pub fn noise_types(octaves: &[Octave], variances: &[f64], shape: &RecordShape) -> Vec<Option<PowerLaw>> {
    let kind = |i: usize| {
        let (here, next) = (octaves.get(i)?, octaves.get(i + 1)?);
        let doubled = next.m == 2 * here.m && shape.samples / next.m >= LEAST_BLOCKS;
        let ratio = variances.get(i + 1)? / variances.get(i)?;
        let is_known = doubled && ratio > 0.0 && ratio.is_finite();
        is_known.then(|| PowerLaw::nearest((-1.0 - ratio.log2()).round() as i8))
    };
    (0..octaves.len()).map(kind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::{Deviation, Estimator};

    #[test]
    fn the_slope_shows_the_kind_of_noise_while_there_are_blocks() {
        for deviation in [Deviation::Allan, Deviation::Hadamard] {
            let shape = RecordShape { samples: 100_000, interval_s: 1.0, estimator: Estimator::Strided, deviation };
            let octaves = shape.octaves();
            for law in [PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk] {
                let variances: Vec<f64> = octaves.iter().map(|octave| law.variance(deviation, octave.m)).collect();
                let found = noise_types(&octaves, &variances, &shape);
                // 32 blocks of 2048 samples hold 48 of the next octave, those of 4096 samples 24
                assert!(found[3..=10].iter().all(|found| *found == Some(law)), "{law:?}: {found:?}");
                assert!(found[11..].iter().all(Option::is_none), "{law:?}: {found:?}");
            }
            assert_eq!(noise_types(&octaves, &[0.0; 3], &shape)[0], None);
        }
    }
}
