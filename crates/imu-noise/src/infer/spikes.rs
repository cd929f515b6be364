//! Single samples far out, more of them than the tails of the noise have.

use super::chi_squared::{self, CHANNELS};
use crate::accumulate::histogram::Histogram;
use schemars::JsonSchema;
use serde::Serialize;

/// Probability that a clean record of twelve channels shows one of these, for each of them.
pub(super) const FALSE_ALARM: f64 = 1e-3;
/// Standard deviations from the median: where the tail begins, where it is compared, and beyond
/// which a sample is a spike.
const TAIL: f64 = 3.0;
const NEAR: f64 = 4.0;
const FAR: f64 = 6.5;

/// The power with which a tail falls at least, if fewer samples than these are in it: as that of
/// Student's distribution with five degrees of freedom.
const USUAL_POWER: f64 = 5.0;
const TAIL_KNOWN: u64 = 30;

/// Slow noise that makes the deviation of all samples this many times that within windows hides
/// what is a spike.
const MOST_SLOW: f64 = 1.25;

/// Single samples far from the others, which the tails of the noise do not explain.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Spikes {
    /// Samples beyond 6.5 standard deviations.
    pub count: u64,
    /// Of the farthest, in standard deviations from the median.
    pub sigmas: f64,
}

impl Spikes {
    /// `std_counts`: standard deviation within windows of the usual noise.
    ///
    /// The tail is taken to fall between 4 and 6.5 standard deviations by the power of the distance with
    /// which it falls from 3 to 4, as that of Student's with five degrees of freedom does. Spikes are more
    /// samples than expected beyond 6.5 standard deviations, or one farther out than the tail reaches.
    pub(super) fn find(histogram: &Histogram, std_counts: f64) -> Option<Self> {
        let [below, median, above] = [0.158_655, 0.5, 0.841_345].map(|p| histogram.quantile_counts(p));
        let (median, half) = (median?, (above? - below?) / 2.0);
        // bins that a single far sample widened do not resolve the noise
        let bin = if histogram.bin_width_counts() > 1 { histogram.bin_width_counts() as f64 } else { 0.0 };
        // each quantile is known to half a bin
        if half > MOST_SLOW * std_counts.max(histogram.spacing_counts()).max(bin) + bin / 2.0 {
            return None;
        }
        let std = half.max(std_counts).max(bin);
        let middle = (histogram.bin_width_counts() - 1) as f64 / 2.0;
        let sigmas = |lowest: i64| (lowest as f64 + middle - median).abs() / std;
        let (mut tail, mut near, mut far, mut farthest) = (0, 0, 0, 0.0_f64);
        for (lowest, frequency) in histogram.bins() {
            let sigmas = sigmas(lowest);
            let beyond = |limit: f64| if sigmas > limit { frequency } else { 0 };
            (tail, near, far) = (tail + beyond(TAIL), near + beyond(NEAR), far + beyond(FAR));
            farthest = farthest.max(sigmas);
        }
        let expected = |near: u64, limit: f64| {
            // A standard deviation more than were seen, and a power that falls the less.
            let most = near as f64 + 1.0 + (near as f64).sqrt();
            let power = (tail as f64 / most).ln().max(0.0) / (NEAR / TAIL).ln();
            let power = if tail < TAIL_KNOWN { power.max(USUAL_POWER) } else { power };
            most * (NEAR / limit).powf(power)
        };
        // P(n or more | expected) of Poisson is that of χ² with 2n degrees of freedom.
        let p =
            |expected: f64, found: u64| Some(1.0 - chi_squared::probability_above(2.0 * expected, 2.0 * found as f64)?);
        // the farthest ones are not of the tail that is to explain them
        let p = p(expected(near, FAR), far)?.min(p(expected(near - far, farthest), u64::from(far > 0))?) * 2.0;
        (p < FALSE_ALARM / CHANNELS).then_some(Self { count: far, sigmas: farthest })
    }
}
