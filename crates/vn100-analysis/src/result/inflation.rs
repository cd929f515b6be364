//! The smallest white noise and walk that lie above the fitted density: what a filter takes.

use std::f64::consts::TAU;

use imu_noise::{Status, Term};
use schemars::JsonSchema;
use serde::Serialize;

use super::NoiseResult;

/// How long a filter goes without correction, in seconds.
const USE_S: f64 = 60.0;

/// The walk of this many B per √(averaging time) drifts over that time as flicker of B does.
pub const WALK_OF_FLICKER: f64 = 1.15;

/// The smallest N and K together whose density lies above the fitted one at all frequencies from that
/// of the time of use on: what a filter takes by the likeliest noise. K is at least the walk that drifts over the time of use as the estimated B does,
/// 1.15 B/√(time): a filter with less believes that its bias stands still. A record at rest knows
/// nothing of scale factor, vibration in motion, timing and linearisation, for which filters are
/// inflated further.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Inflation {
    /// Time of use in seconds: a minute, or as far as the deviation reaches.
    pub use_s: f64,
    /// N in the SI unit.
    pub white: f64,
    /// K in the SI unit.
    pub walk: f64,
    /// That N over the estimated one; null without an estimate.
    pub white_factor: Option<f64>,
    /// That K over the estimated one; null without an estimate.
    pub walk_factor: Option<f64>,
}

impl Inflation {
    /// Of the octaves, each an averaging time in seconds with the fitted deviation; `None` if the density
    /// has less than two points.
    pub(super) fn of(octaves: &[(f64, f64)], noise: &NoiseResult) -> Option<Self> {
        let bounds = densities(octaves);
        let lowest_hz = bounds.last().filter(|_| bounds.len() >= 2)?.0;
        let estimated = |term| {
            let estimate = noise.parameter(term).filter(|found| found.status == Status::Estimated);
            estimate.and_then(|found| found.value)
        };
        let (n, k) = (estimated(Term::White), estimated(Term::RateRandomWalk));
        let use_s = (1.0 / lowest_hz).min(USE_S);
        let flicker = estimated(Term::BiasInstability).map_or(0.0, |b| WALK_OF_FLICKER * b / use_s.sqrt());
        let (white2, walk2) = (n.unwrap_or(0.0).powi(2), k.unwrap_or(0.0).max(flicker).powi(2));
        // what the estimates leave, since a filter is given no less than these
        let left: Vec<(f64, f64)> =
            bounds.iter().map(|(hz, bound)| (*hz, bound - white2 - walk2 * weight(*hz))).collect();
        let (more_white2, more_walk2) = smallest_above(&left, use_s)?;
        let (white, walk) = ((white2 + more_white2).sqrt(), (walk2 + more_walk2).sqrt());
        Some(Self { use_s, white, walk, white_factor: n.map(|n| white / n), walk_factor: k.map(|k| walk / k) })
    }
}

/// Frequency and two-sided density at each octave, to the first that is as long as the time of use.
///
/// The Allan variance is the density seen through a band-pass of about an octave: S(c/τ) = τ σ²(τ),
/// with c = 1/(4 ln 2) = 0.361 for flicker noise and √3/(2π) = 0.276 for a walk (IEEE Std 952); white
/// noise has it at any c.
fn densities(octaves: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const OF_FLICKER: f64 = 0.361;
    const OF_WALK: f64 = 0.276;
    let known: Vec<(f64, f64)> = octaves.iter().map(|(tau_s, fitted)| (*tau_s, fitted * fitted)).collect();
    let density = |(place, (tau_s, variance)): (usize, &(f64, f64))| {
        let next = known.get(place + 1).unwrap_or(&known[place]);
        let slope = (next.1 / variance).log2().clamp(0.0, 1.0);
        ((OF_FLICKER + slope * (OF_WALK - OF_FLICKER)) / tau_s, tau_s * variance)
    };
    let mut densities: Vec<(f64, f64)> = known.iter().enumerate().map(density).collect();
    let shorter = densities.iter().take_while(|(hz, _)| *hz > 1.0 / USE_S).count();
    densities.truncate(shorter + 1);
    densities
}

/// The density of a walk of K = 1.
fn weight(hz: f64) -> f64 {
    1.0 / (TAU * hz).powi(2)
}

/// N² and K² with N² + K²/(2πf)² above all bounds, for the least variance N² T + K² T³/3 of the
/// integral after the time of use: the best corner, as in any linear program of two unknowns.
fn smallest_above(bounds: &[(f64, f64)], use_s: f64) -> Option<(f64, f64)> {
    let highest = bounds.iter().map(|(_, bound)| *bound).fold(0.0, f64::max);
    let steepest = bounds.iter().map(|(hz, bound)| bound / weight(*hz)).fold(0.0, f64::max);
    let crossings = bounds.iter().enumerate().flat_map(|(place, (hz, bound))| {
        bounds[place + 1..].iter().map(move |(other_hz, other)| {
            let walk2 = (bound - other) / (weight(*hz) - weight(*other_hz));
            (bound - walk2 * weight(*hz), walk2)
        })
    });
    let corners = crossings.chain([(highest, 0.0), (0.0, steepest)]);
    let is_above = |(white2, walk2): &(f64, f64)| {
        *white2 >= 0.0
            && *walk2 >= 0.0
            && bounds.iter().all(|(hz, bound)| white2 + walk2 * weight(*hz) >= bound * (1.0 - 1e-12))
    };
    let cost = |(white2, walk2): &(f64, f64)| white2 * use_s + walk2 * use_s.powi(3) / 3.0;
    corners.filter(is_above).min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// No pair on a fine grid is cheaper and lies above.
        #[test]
        fn the_corner_is_the_cheapest_pair_above(
            levels in proptest::collection::vec(0.1_f64..10.0, 2..8),
            use_s in 1.0_f64..100.0,
        ) {
            let bounds: Vec<(f64, f64)> =
                levels.iter().enumerate().map(|(octave, level)| (f64::from(1 << octave) / (30.0 * use_s), *level)).collect();
            let (white2, walk2) = smallest_above(&bounds, use_s).unwrap();
            for (hz, bound) in &bounds {
                prop_assert!(white2 + walk2 * weight(*hz) >= bound * 0.999_999);
            }
            let cost = |white2: f64, walk2: f64| white2 * use_s + walk2 * use_s.powi(3) / 3.0;
            let least = cost(white2, walk2);
            for part in 0..=200 {
                let white2 = 10.0 * f64::from(part) / 200.0;
                let needed = bounds.iter().map(|(hz, bound)| (bound - white2) / weight(*hz)).fold(0.0, f64::max);
                prop_assert!(cost(white2, needed) * 1.000_001 >= least, "{white2} {needed}");
            }
        }
    }
}
