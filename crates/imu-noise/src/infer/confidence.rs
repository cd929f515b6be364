//! Degrees of freedom of an octave, and intervals of its deviation.

use super::chi_squared;
use super::power_law::{PowerLaw, difference_autocovariance};
use crate::accumulate::record::{Octave, RecordShape};

/// Windows per averaging time that represent all overlaps: the edf differ by less than 1e-6 for α
/// <= 0. Noise of the phase has more in more overlaps; its intervals are wider than need be.
const ALL_OVERLAPS: u64 = 2048;

/// The same for averaging factors that are no octave, and of which there may be thousands: within
/// 1e-4, and within 3e-3 where fewer than m windows are left.
const SOME_OVERLAPS: u64 = 256;

/// Correlations of flicker noise fall with the square of the distance: beyond, they add below 1e-6.
const LONGEST_LAG_TAU: u64 = 64;

/// Confidence interval of the deviation of one octave alone: octaves share samples, so all
/// intervals of a curve together are right less often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Equivalent degrees of freedom.
    pub edf: f64,
    /// Lower bound of the true deviation, in the unit of the channel.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
}

impl Interval {
    /// The interval with probability `confidence` around an estimate `variance` with `edf` degrees
    /// of freedom: edf · estimate / truth follows χ²(edf) (Howe, Allan and Barnes, 1981), equal
    /// tails. `None` unless 0 < `confidence` < 1, `edf` > 0 and `variance` >= 0.
    pub fn new(variance: f64, edf: f64, confidence: f64) -> Option<Self> {
        if !(variance >= 0.0 && edf.is_finite() && confidence > 0.0 && confidence < 1.0) {
            return None;
        }
        let tail = (1.0 - confidence) / 2.0;
        let bound = |p| chi_squared::quantile(p, edf).map(|quantile| (variance * edf / quantile).sqrt());
        Some(Self { edf, lower: bound(1.0 - tail)?, upper: bound(tail)? })
    }
}

/// Equivalent degrees of freedom of an octave in noise of one kind; `None` below two windows.
///
/// edf = M / (1 + 2 Σ (1 - j/M) ρ_j²), with M windows and the correlation ρ_j of differences j
/// strides apart (Greenhall and Riley, 2003, eq. 7), with the covariances of sampled noise. With
/// samples missing, the edf shrinks as the number of windows.
pub fn edf(octave: &Octave, shape: &RecordShape, law: PowerLaw) -> Option<f64> {
    let windows = shape.windows(octave.m);
    if octave.terms < 2 || windows < 2 {
        return None;
    }
    let at = |lag| difference_autocovariance(shape.deviation, octave.m as f64, lag, |lag| law.phase_covariance(lag));
    let (variance, span) = (at(0.0), (windows * shape.stride(octave.m)) as f64);
    let terms = lags(shape, octave.m).map(|(lag, weight)| {
        let correlation = at(lag) / variance;
        weight * (1.0 - lag / span) * correlation * correlation
    });
    Some(windows as f64 / terms.sum::<f64>() * shape.share_of_windows(octave))
}

/// Distances between windows in samples, and how many pairs of windows each is for: every one where
/// correlations have corners, at multiples of m, and few where they are smooth.
fn lags(shape: &RecordShape, m: u64) -> impl Iterator<Item = (f64, f64)> {
    let stride = shape.stride(m) as f64;
    let most = if m.is_power_of_two() { ALL_OVERLAPS } else { SOME_OVERLAPS };
    let fine = stride.max(m as f64 / most as f64);
    let coarse = stride.max(m as f64 / 4.0);
    let last = ((LONGEST_LAG_TAU * m) as f64).min((shape.windows(m).max(1) - 1) as f64 * stride);
    let corners = (shape.deviation.order() as u64 + 5) * m;
    let corner_steps = (corners as f64 / fine).round();
    let fine_lags = (0..=corner_steps.min((last / fine).floor()) as u64).map(move |j| {
        let pairs = fine / stride;
        // a lag and its negative; half of either step at the transition
        let weight = match j as f64 {
            0.0 => pairs,
            step if step == corner_steps => pairs + coarse / stride,
            _ => 2.0 * pairs,
        };
        (j as f64 * fine, weight)
    });
    let coarse_lags = ((corners as f64 / coarse) as u64 + 1..=(last / coarse) as u64)
        .map(move |j| (j as f64 * coarse, 2.0 * coarse / stride));
    fine_lags.chain(coarse_lags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::{Deviation, Estimator};
    use crate::oracle;

    fn column(row: &[(String, String)], name: &str) -> f64 {
        oracle::field(row, name).unwrap().parse().unwrap()
    }

    #[test]
    fn edf_is_that_of_the_exact_table() {
        let mut used = 0;
        for row in oracle::table("edf_table.csv") {
            let number = |name| column(&row, name);
            let (alpha, m, stride) = (number("alpha"), number("m") as u64, number("stride") as u64);
            let estimator = match stride {
                _ if alpha < -2.0 || number("modified") == 1.0 => continue,
                1 => Estimator::Full,
                stride if stride == m => Estimator::Plain,
                stride if stride == m / 16 => Estimator::Strided,
                _ => continue,
            };
            let deviation = if number("d") == 2.0 { Deviation::Allan } else { Deviation::Hadamard };
            let shape = RecordShape { samples: number("N") as u64 - 1, interval_s: 1.0, estimator, deviation };
            let terms = shape.windows(m);
            assert_eq!(terms, number("M") as u64);
            if alpha > 0.0 && stride == 1 && m > ALL_OVERLAPS {
                continue;
            }
            let Some(found) = edf(&Octave::whole(m, terms), &shape, PowerLaw::nearest(alpha as i8)) else {
                assert_eq!(terms, 1);
                continue;
            };
            let expected = number("edf_iid");
            assert!((found / expected - 1.0).abs() < 1e-6, "{row:?}: {found}");
            used += 1;
        }
        assert_eq!(used, 513);
    }

    #[test]
    fn any_averaging_factor_has_the_edf_of_the_sum_over_all_lags() {
        for deviation in [Deviation::Allan, Deviation::Hadamard] {
            let shape = RecordShape { samples: 7001, interval_s: 1.0, estimator: Estimator::Full, deviation };
            for m in [3, 10, 257, 300, 999, 1500, 2300] {
                for law in [PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk] {
                    let windows = shape.windows(m);
                    let at = |lag: u64| {
                        difference_autocovariance(deviation, m as f64, lag as f64, |lag| law.phase_covariance(lag))
                    };
                    let share = |lag: u64| 1.0 - lag as f64 / windows as f64;
                    let both_sides: f64 = (1..windows).map(|lag| 2.0 * share(lag) * (at(lag) / at(0)).powi(2)).sum();
                    let expected = windows as f64 / (1.0 + both_sides);
                    let found = edf(&Octave::whole(m, windows), &shape, law).unwrap();
                    let tolerance = if windows > m { 1e-4 } else { 3e-3 };
                    assert!((found / expected - 1.0).abs() < tolerance, "{law:?}, m = {m}: {found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn bounds_are_those_of_the_exact_table() {
        let mut used = 0;
        for row in oracle::table("chi2_ci.csv") {
            let number = |name| column(&row, name);
            let interval = Interval::new(4.0, number("edf"), number("p")).unwrap();
            assert!((interval.lower / (2.0 * number("lo")) - 1.0).abs() < 1e-10, "{row:?}: {interval:?}");
            assert!((interval.upper / (2.0 * number("hi")) - 1.0).abs() < 1e-10, "{row:?}: {interval:?}");
            used += 1;
        }
        assert_eq!(used, 72);
    }

    #[test]
    fn missing_windows_shrink_the_edf_in_proportion() {
        let shape =
            RecordShape { samples: 4096, interval_s: 1.0, estimator: Estimator::Strided, deviation: Deviation::Allan };
        let whole = shape.windows(64);
        let edf_of = |terms: u64| edf(&Octave::whole(64, terms), &shape, PowerLaw::Flicker).unwrap();
        assert!((edf_of(whole / 2) / edf_of(whole) - (whole / 2) as f64 / whole as f64).abs() < 1e-12);
    }

    #[test]
    fn few_windows_and_invalid_levels_have_no_interval() {
        let shape =
            RecordShape { samples: 9, interval_s: 1.0, estimator: Estimator::Strided, deviation: Deviation::Allan };
        let octave = |m, terms| Octave::whole(m, terms);
        assert!(edf(&octave(4, 2), &shape, PowerLaw::White).is_some());
        assert_eq!(edf(&octave(4, 1), &shape, PowerLaw::White), None);
        assert_eq!(edf(&octave(4, 0), &shape, PowerLaw::White), None);
        assert_eq!(edf(&octave(16, 2), &shape, PowerLaw::White), None);
        for confidence in [0.0, 1.0, -0.5, 2.0, f64::NAN] {
            assert_eq!(Interval::new(1.0, 10.0, confidence), None, "{confidence}");
        }
        assert_eq!(Interval::new(f64::NAN, 10.0, 0.95), None);
        assert_eq!(Interval::new(1.0, 0.0, 0.95), None);
        assert!(Interval::new(1.0, 10.0, 1e-6).is_some());
        assert_eq!(Interval::new(0.0, 10.0, 0.95).map(|interval| interval.upper), Some(0.0));
    }
}
