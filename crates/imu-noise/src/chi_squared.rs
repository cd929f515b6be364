//! The chi-squared distribution at any, also fractional, degrees of freedom, and its relatives.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

/// x with P(χ² < x) = `p` at `dof` degrees of freedom; `None` unless 0 < p < 1 and dof > 0.
pub(crate) fn quantile(p: f64, dof: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0) {
        return None;
    }
    let chi_squared = ChiSquared::new(dof).ok()?;
    // Either is too coarse, the search by 1e-9 absolute near zero; Newton's steps do the rest.
    let mut x = if dof < 10.0 { chi_squared.inverse_cdf(p) } else { wilson_hilferty(p, dof) };
    for _ in 0..20 {
        let next = x - (chi_squared.cdf(x) - p) / chi_squared.pdf(x);
        if !(next > 0.0 && next.is_finite()) {
            break;
        }
        let settled = (next / x - 1.0).abs() < 1e-13;
        x = next;
        if settled {
            break;
        }
    }
    Some(x)
}

/// The quantile from the normal distribution of the cube root (Wilson and Hilferty, 1931), good to some 1e-3 from 10 degrees of freedom
/// on, where a search costs ten times as much.
fn wilson_hilferty(p: f64, dof: f64) -> f64 {
    let variance = 2.0 / (9.0 * dof);
    dof * (1.0 - variance + normal_quantile(p) * variance.sqrt()).powi(3).max(1e-3)
}

/// P(χ² > x) at `dof` degrees of freedom; `None` unless dof > 0 and x is a number.
pub(crate) fn probability_above(x: f64, dof: f64) -> Option<f64> {
    if x.is_nan() {
        return None;
    }
    ChiSquared::new(dof).ok().map(|chi_squared| chi_squared.sf(x))
}

/// x with P(Z < x) = `p` for a standard normal Z, 0 < p < 1.
pub(crate) fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// x with P(|Z| < x) = `p` for a standard normal Z; `None` unless 0 < p < 1.
pub(crate) fn normal_two_sided(p: f64) -> Option<f64> {
    (p > 0.0 && p < 1.0).then(|| Normal::standard().inverse_cdf(0.5 + p / 2.0))
}

/// x with P(|T| < x) = `p` for Student's T with `dof` degrees of freedom, taken between 1 and 10 000; `None` unless 0
/// < p < 1.
pub(crate) fn student_two_sided(p: f64, dof: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0) {
        return None;
    }
    let dof = if dof.is_nan() { 1.0 } else { dof.clamp(1.0, 10_000.0) };
    StudentsT::new(0.0, 1.0, dof).ok().map(|student| student.inverse_cdf(0.5 + p / 2.0))
}
