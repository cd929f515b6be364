//! Single samples far out, more of them than the tails of the noise have.

use super::chi_squared::{self, CHANNELS};
use crate::accumulate::blocks::WINDOW;
use crate::accumulate::window_statistics::Magnitudes;
use schemars::JsonSchema;
use serde::Serialize;

/// Probability that a clean record of twelve channels shows one of these, for each of them.
pub(super) const FALSE_ALARM: f64 = 1e-3;
/// Standard deviations from the samples around: where the tail begins, where it is compared, and beyond
/// which a sample is a spike.
const TAIL: f64 = 3.0;
const NEAR: f64 = 4.0;
const FAR: f64 = 6.5;

/// The power with which a tail falls at least, if fewer windows than these are in it: as that of
/// Student's distribution with five degrees of freedom.
const USUAL_POWER: f64 = 5.0;
const TAIL_KNOWN: f64 = 30.0;

/// Single samples far from the others, which the tails of the noise do not explain.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Spikes {
    /// Windows of 32 samples with one beyond 6.5 standard deviations.
    pub count: u64,
    /// Of the farthest, in standard deviations from the samples around it.
    pub sigmas: f64,
}

impl Spikes {
    /// `std_counts`: standard deviation within windows of the usual noise.
    ///
    /// The tail is taken to fall between 4 and 6.5 standard deviations by the power of the distance with
    /// which it falls from 3 to 4, as that of Student's with five degrees of freedom does. Spikes are more
    /// windows than expected beyond 6.5 standard deviations, or one farther out than the tail reaches.
    pub(super) fn find(squares: &Magnitudes, std_counts: f64) -> Option<Self> {
        let std = WINDOW as f64 * std_counts;
        let farthest = squares.highest().last()?.peak.sqrt() / std;
        let [tail, near, far] = [TAIL, NEAR, FAR].map(|limit| squares.above((limit * std).powi(2)).ceil());
        let expected = |near: f64, limit: f64| {
            // A standard deviation more than were seen, and a power that falls the less.
            let most = near + 1.0 + near.sqrt();
            let power = (tail / most).ln().max(0.0) / (NEAR / TAIL).ln();
            let power = if tail < TAIL_KNOWN { power.max(USUAL_POWER) } else { power };
            most * (NEAR / limit).powf(power)
        };
        // P(n or more | expected) of Poisson is that of χ² with 2n degrees of freedom.
        let p = |expected: f64, found: f64| Some(1.0 - chi_squared::probability_above(2.0 * expected, 2.0 * found)?);
        // the farthest ones are not of the tail that is to explain them
        let p = p(expected(near, FAR), far)?.min(p(expected(near - far, farthest), far.min(1.0))?) * 2.0;
        (p < FALSE_ALARM / CHANNELS).then_some(Self { count: far as u64, sigmas: farthest })
    }
}
