//! Flicker (1/f) noise as a sum of first-order Gauss-Markov processes.

use std::f64::consts::PI;

use crate::gauss_markov::GaussMarkov;

/// Ratio of neighbouring time constants: the Allan deviation then ripples by 0.02 %.
const RATIO: f64 = 4.0;

/// The longest time constant is at least this, 16 times the longest τ for which the flicker is accurate.
const LONGEST_S: f64 = 1.6e6;

/// Flicker of bias instability B (0: none), of two-sided density B²/(2πf), for samples every `interval_s`.
///
/// A process of variance v and time constant T has the density 2vT/(1 + (2πfT)²); over time
/// constants in geometric progression of ratio r these add up to v/(2f ln r), so v = B² ln r/π.
/// (Sum of Lorentzians: van der Ziel, 1950.)
pub(crate) fn flicker(bias_instability: f64, interval_s: f64) -> Vec<GaussMarkov> {
    if bias_instability == 0.0 {
        return Vec::new();
    }
    let sigma = bias_instability * (RATIO.ln() / PI).sqrt();
    time_constants_s(interval_s).map(|correlation_time_s| GaussMarkov { correlation_time_s, sigma }).collect()
}

/// Time constants from half a sample interval up. With this start, the sum has at the shortest τ
/// the same values as flicker of the same B that is sampled without averaging: 1.20, 1.07, 1.02 of
/// the plateau at m = 1, 2, 4.
fn time_constants_s(interval_s: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(interval_s / 2.0), |last_s| (*last_s < LONGEST_S).then_some(last_s * RATIO))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{LN_2, LOG2_E};

    use super::*;

    /// Allan variance of a sampled Gauss-Markov process of variance 1 at averaging factor m.
    fn gauss_markov_avar(interval_s: f64, time_constant_s: f64, m: f64) -> f64 {
        let x = interval_s / time_constant_s;
        if m * x < 1e-3 {
            // so far a random walk; the closed form would lose all digits to cancellation
            return 2.0 * x * (2.0 * m * m + 1.0) / (6.0 * m);
        }
        let (phi, q, a) = ((-x).exp(), -(-x).exp_m1(), -(-m * x).exp_m1());
        let block_variance = m * (1.0 + phi) / q - 2.0 * phi * a / (q * q);
        let block_covariance = phi * a * a / (q * q);
        (block_variance - block_covariance) / (m * m)
    }

    /// Allan deviation of the sum relative to the plateau √(2 ln 2/π)·B.
    fn relative_deviation(interval_s: f64, m: f64) -> f64 {
        let variances = time_constants_s(interval_s).map(|t| gauss_markov_avar(interval_s, t, m));
        let sum: f64 = variances.sum::<f64>() * RATIO.ln() / PI;
        (sum / (2.0 * LN_2 / PI)).sqrt()
    }

    #[test]
    fn plateau_is_flat_from_16_samples_to_more_than_a_day() {
        for rate_hz in [1.0, 40.0, 200.0, 800.0] {
            let mut m: f64 = 16.0;
            while m / rate_hz <= 1e5 {
                let relative = relative_deviation(1.0 / rate_hz, m);
                assert!((relative - 1.0).abs() < 5e-3, "{rate_hz} Hz, m {m}: {relative}");
                m *= 2.0;
            }
        }
    }

    /// The expected values are those of half-integrated white noise (Kasdin, 1995): Allan variance
    /// 1/ln 2, 1.1542, 1.0500, 1.0154 of the plateau at m = 1, 2, 4, 8.
    #[test]
    fn shortest_tau_read_as_sampled_flicker_does() {
        for (m, avar) in [(1.0, LOG2_E), (2.0, 1.1542), (4.0, 1.05), (8.0, 1.0154)] {
            let relative = relative_deviation(0.025, m);
            assert!((relative / avar.sqrt() - 1.0).abs() < 0.01, "m {m}: {relative}");
        }
    }
}
