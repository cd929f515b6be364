//! The chi-squared distribution at any, also fractional, degrees of freedom, and its relatives.

use statrs::{
    distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT},
    function::gamma::ln_gamma,
};

/// x with P(χ² < x) = `p`; `None` unless 0 < p < 1 and dof > 0, and where x underflows.
pub fn quantile(p: f64, dof: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0) {
        return None;
    }
    let chi_squared = ChiSquared::new(dof).ok()?;
    let small = near_zero(p, dof);
    if small < 1e-13 {
        // exact to all digits
        return (small > 0.0).then_some(small);
    }
    // Each is too coarse, and the search wrong by 1e-9 near zero; Halley's steps do the rest.
    let mut x = match dof {
        _ if small < 1e-3 => small,
        _ if dof < 10.0 => chi_squared.inverse_cdf(p),
        _ => wilson_hilferty(p, dof),
    };
    for _ in 0..20 {
        let newton = (chi_squared.cdf(x) - p) / chi_squared.pdf(x);
        // the logarithm of the density has this slope
        let bent = 1.0 - newton * 0.5 * ((dof / 2.0 - 1.0) / x - 0.5);
        let step = if bent > 0.5 { newton / bent } else { newton };
        let next = x - step;
        if !(next > 0.0 && next.is_finite()) {
            break;
        }
        // The error of the next one is as the third power of this step, over the scale of the density.
        let scale = x.min((2.0 * dof).sqrt());
        let settled = (step / scale).abs().powi(3) * scale < 1e-15 * x || (step / x).abs() < 1e-13;
        x = next;
        if settled {
            break;
        }
    }
    Some(x)
}

/// From the first term of the series at zero, P = (x/2)^(dof/2) / Γ(dof/2 + 1): good where small.
fn near_zero(p: f64, dof: f64) -> f64 {
    let half = dof / 2.0;
    2.0 * ((p.ln() + ln_gamma(half + 1.0)) / half).exp()
}

/// From the normal distribution of the cube root (Wilson and Hilferty, 1931), good to some 1e-3
/// from 10 degrees of freedom on, where a search costs ten times as much.
fn wilson_hilferty(p: f64, dof: f64) -> f64 {
    let variance = 2.0 / (9.0 * dof);
    dof * (1.0 - variance + normal_quantile(p) * variance.sqrt()).powi(3).max(1e-3)
}

/// P(χ² > x); `None` unless dof > 0 and x is a number.
pub fn probability_above(x: f64, dof: f64) -> Option<f64> {
    if x.is_nan() {
        return None;
    }
    ChiSquared::new(dof).ok().map(|chi_squared| chi_squared.sf(x))
}

/// x with P(Z < x) = `p` for a standard normal Z.
///
/// # Panics
/// Unless 0 <= p <= 1.
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// P(Z > x) for a standard normal Z.
pub fn normal_above(x: f64) -> f64 {
    Normal::standard().sf(x)
}

/// x with P(|Z| < x) = `p` for a standard normal Z; `None` unless 0 < p < 1.
pub fn normal_two_sided(p: f64) -> Option<f64> {
    (p > 0.0 && p < 1.0).then(|| Normal::standard().inverse_cdf(0.5 + p / 2.0))
}

/// x with P(|T| < x) = `p` for Student's T, `dof` clamped to 1..=10 000; `None` unless 0 < p < 1.
pub fn student_two_sided(p: f64, dof: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0) {
        return None;
    }
    let dof = if dof.is_nan() { 1.0 } else { dof.clamp(1.0, 10_000.0) };
    StudentsT::new(0.0, 1.0, dof).ok().map(|student| student.inverse_cdf(0.5 + p / 2.0))
}

/// Channels that make up a record: a probability of false alarm is shared among them.
pub(crate) const CHANNELS: f64 = 12.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_near_zero_are_not_those_of_a_search() {
        // made with scipy.stats.chi2.ppf
        for (p, dof, expected) in [
            (0.025, 0.05, 9.479198738737956e-65),
            (0.025, 0.134171916903456, 1.5590373354758833e-24),
            (0.025, 0.3, 2.6300743566293655e-11),
            (0.025, 0.6, 6.371358063478339e-06),
            (0.025, 1.0, 0.0009820691171752555),
            (0.005, 0.5, 8.43712236923709e-10),
            (0.025, 2.0, 0.05063561596857975),
        ] {
            let found = quantile(p, dof).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-10, "{p} {dof}: {found}, not {expected}");
        }
        assert_eq!(quantile(0.025, 1e-3), None);
    }

    #[test]
    fn quantiles_are_good_to_the_digits_of_their_distribution() {
        for dof in [0.7, 1.5, 3.0, 9.0, 11.0, 40.0, 333.0, 5000.0] {
            for p in [1e-5, 0.001, 0.025, 0.3, 0.5, 0.84, 0.975, 0.999] {
                let x = quantile(p, dof).unwrap();
                let distribution = ChiSquared::new(dof).unwrap();
                let error = (distribution.cdf(x) - p) / distribution.pdf(x) / x;
                assert!(error.abs() < 2e-13, "{dof} {p}: {error:e}");
            }
        }
    }
}
