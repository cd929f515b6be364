//! Thresholds that clean records of twelve channels exceed with a stated probability.

use crate::chi_squared;

/// Channels that make up a record: a probability of false alarm is shared among them.
pub(crate) const CHANNELS: f64 = 12.0;

/// The standard normal deviate that is exceeded with probability `p`.
pub(crate) fn normal_deviate(p: f64) -> f64 {
    -chi_squared::normal_quantile(p)
}

/// The multiple of its mean that a chi-squared variable of `freedom` degrees exceeds with
/// probability `p`; `None` unless 0 < p < 1 and freedom > 0.
pub(crate) fn chi_squared_ratio(freedom: f64, p: f64) -> Option<f64> {
    chi_squared::quantile(1.0 - p, freedom).map(|quantile| quantile / freedom)
}
