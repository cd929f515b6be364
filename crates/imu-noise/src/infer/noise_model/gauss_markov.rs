//! First-order Gauss-Markov noise: its covariance falls as e^(-|t|/T).

/// Generalised covariance of the phase of a process with covariance e^(-|t|/T): -T² (e^(-x) - 1 + x
/// - x²/2), x = |t|/T. The polynomial cancels in differences and keeps the digits.
pub(super) fn phase_covariance(lag: f64, time: f64) -> f64 {
    let x = lag.abs() / time;
    let remainder = if x < 0.5 {
        // -x³/6 + x⁴/24 - ...
        let terms = (3..16).rev();
        terms.fold(0.0, |rest, k| (1.0 - rest) * x / f64::from(k)) * -x * x / 2.0
    } else {
        (-x).exp() - 1.0 + x - x * x / 2.0
    };
    -time * time * remainder
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Deviation;
    use crate::infer::power_law::difference_autocovariance;

    #[test]
    fn variances_are_those_of_the_formula() {
        for time in [20.0, 1000.0, 10_000.0] {
            for m in [16.0, 256.0, 65_536.0] {
                let variance = difference_autocovariance(Deviation::Allan, m, 0.0, |lag| phase_covariance(lag, time))
                    / (2.0 * m * m);
                // IEEE Std 952, C.1.1.7.1, with (q T)² = 2 σ² T
                let x: f64 = m / time;
                let expected = 2.0 / x * (1.0 - (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()) / (2.0 * x));
                assert!((variance / expected - 1.0).abs() < 1e-6, "{time} {m}: {variance}, not {expected}");
            }
        }
        // Much shorter than the correlation time it is a walk with steps of variance 2/T.
        let variance = difference_autocovariance(Deviation::Allan, 16.0, 0.0, |lag| phase_covariance(lag, 1e6)) / 512.0;
        assert!((variance / (2e-6 * 16.0 / 3.0) - 1.0).abs() < 1e-4, "{variance}");
    }
}
