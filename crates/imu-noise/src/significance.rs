//! Quantiles of the distributions that decide what is seen as significant.

/// Channels that make up a record: a probability of false alarm is shared among them.
pub(crate) const CHANNELS: f64 = 12.0;

/// The standard normal deviate that is exceeded with probability `p`, from 1e-300 to 0.5, within 4.5e-4.
///
/// Abramowitz and Stegun (1964), 26.2.23.
pub(crate) fn normal_deviate(p: f64) -> f64 {
    let t = (-2.0 * p.ln()).sqrt();
    let numerator = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let denominator = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - numerator / denominator
}

/// The multiple of its mean that a chi-squared variable of `freedom` degrees exceeds with probability `p`.
///
/// Wilson and Hilferty (1931): the cube root is nearly normal.
pub(crate) fn chi_squared_ratio(freedom: f64, p: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    (1.0 - variance + normal_deviate(p) * variance.sqrt()).powi(3)
}
