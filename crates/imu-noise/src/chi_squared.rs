//! The chi-squared distribution at any, also fractional, degrees of freedom.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF};

/// x with P(χ² < x) = `p` at `dof` degrees of freedom; `None` unless 0 < p < 1 and dof > 0.
pub(crate) fn quantile(p: f64, dof: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0) {
        return None;
    }
    let chi_squared = ChiSquared::new(dof).ok()?;
    // This is found to about 1e-9 absolute, which is too coarse near zero; Newton's steps do the rest.
    let mut x = chi_squared.inverse_cdf(p);
    for _ in 0..20 {
        let next = x - (chi_squared.cdf(x) - p) / chi_squared.pdf(x);
        if !(next > 0.0 && next.is_finite()) {
            break;
        }
        let settled = (next / x - 1.0).abs() < 1e-14;
        x = next;
        if settled {
            break;
        }
    }
    Some(x)
}
