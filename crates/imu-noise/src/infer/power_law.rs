//! Power-law noise: variances and covariances of its differences, sampled.

use core::f64::consts::{PI, TAU};

use crate::accumulate::record::{Deviation, Octave};

/// Noise of a rate with the spectrum S(f) ~ f^α, sampled: independent samples and their sums, so
/// that the formulas hold from m = 1 on.
///
/// Amplitudes are 1 in units of one sample: of the angle for the first two, of the rate for
/// [`White`](Self::White) and of [`Flicker`](Self::Flicker) (IEEE Std 952: S = 1/(2πf)), of the
/// step for [`RandomWalk`](Self::RandomWalk).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PowerLaw {
    /// α = 2: independent errors of the angle, quantisation.
    WhitePhase,
    /// α = 1.
    FlickerPhase,
    /// α = 0: independent samples of the rate. Angle random walk.
    White,
    /// α = -1: white noise half integrated, (1 - B)^(-1/2) w. Bias instability.
    Flicker,
    /// α = -2: the sum of independent steps. Rate random walk.
    RandomWalk,
}

impl PowerLaw {
    /// The exponent α of the spectrum of the rate.
    pub const fn alpha(self) -> i8 {
        match self {
            Self::WhitePhase => 2,
            Self::FlickerPhase => 1,
            Self::White => 0,
            Self::Flicker => -1,
            Self::RandomWalk => -2,
        }
    }

    /// The law with exponent `alpha`, the nearest one outside -2 ..= 2.
    pub const fn nearest(alpha: i8) -> Self {
        match alpha {
            2.. => Self::WhitePhase,
            1 => Self::FlickerPhase,
            0 => Self::White,
            -1 => Self::Flicker,
            ..=-2 => Self::RandomWalk,
        }
    }

    /// Expected Allan or Hadamard variance at averaging factor `m` >= 1, for amplitude 1: white
    /// 1/m; random walk, Allan (2m² + 1)/(6m); flicker 2 ln 2/π for large m, up to 1.44 times that
    /// at m = 1.
    pub fn variance(self, deviation: Deviation, m: u64) -> f64 {
        let m = m as f64;
        difference_autocovariance(deviation, m, 0.0, |lag| self.phase_covariance(lag)) / (deviation.divisor() * m * m)
    }

    /// Generalised covariance of the phase (the running sum of the rate) at an integer lag, without
    /// polynomials of the lag up to third order (Hadamard: fifth), which drop out of every
    /// difference.
    ///
    /// The phase is white noise integrated δ = 1 - α/2 times, with the covariance Γ(1-2δ) Γ(n+δ) /
    /// (Γ(δ) Γ(1-δ) Γ(n+1-δ)) (Hosking, 1981, theorem 1); at a pole its derivative by δ remains,
    /// the digamma function ψ.
    pub(crate) fn phase_covariance(self, lag: f64) -> f64 {
        let n = lag.abs();
        match self {
            Self::WhitePhase => f64::from(n == 0.0),
            Self::FlickerPhase => -digamma_half(n) / PI,
            Self::White => -n / 2.0,
            Self::Flicker => (n * n - 0.25) * digamma_half(n) / TAU,
            Self::RandomWalk => n * (n * n - 1.0) / 12.0,
        }
    }
}

/// Covariance of two differences, `lag` samples apart, from that of the `phase`.
pub(crate) fn difference_autocovariance(deviation: Deviation, m: f64, lag: f64, phase: impl Fn(f64) -> f64) -> f64 {
    let weights: &[f64] = match deviation {
        Deviation::Allan => &[6.0, -4.0, 1.0],
        Deviation::Hadamard => &[20.0, -15.0, 6.0, -1.0],
    };
    let around = weights.iter().enumerate().skip(1);
    let sides = around.map(|(k, weight)| weight * (phase(lag + k as f64 * m) + phase(lag - k as f64 * m)));
    weights[0] * phase(lag) + sides.sum::<f64>()
}

impl Octave {
    /// The expected variance of noise with amplitude 1, its missing samples considered.
    pub fn expected_variance(&self, deviation: Deviation, law: PowerLaw) -> f64 {
        expected_variance(self, deviation, |lag| law.phase_covariance(lag))
    }
}

/// Variance of an octave of noise with this generalised covariance of the phase.
pub(crate) fn expected_variance(octave: &Octave, deviation: Deviation, phase: impl Fn(f64) -> f64) -> f64 {
    let variance = |deviation: Deviation, m: u64| {
        let m = m as f64;
        difference_autocovariance(deviation, m, 0.0, &phase) / (deviation.divisor() * m * m)
    };
    octave.expected(variance(deviation, octave.m), |m| variance(Deviation::Allan, m))
}

/// Variance of the cosine coefficient `k` of the means of so many blocks of flicker noise, folded at
/// half a cycle per block.
pub(super) fn flicker_variance(k: usize, blocks: usize) -> f64 {
    let omega = PI * k as f64 / blocks as f64;
    let folded = |m: i32| (TAU * f64::from(m) + omega).abs().powi(-3);
    4.0 * (omega / 2.0).sin().powi(2) * (-20..=20).map(folded).sum::<f64>()
}

/// The same of a random walk.
pub(super) fn walk_variance(k: usize, blocks: usize) -> f64 {
    let square = (PI * k as f64 / (2 * blocks) as f64).sin().powi(2);
    (3.0 - 2.0 * square) / (12.0 * square)
}

/// ψ(n + 1/2) for integers n >= 0, to 1e-13: by the recurrence ψ(x + 1) = ψ(x) + 1/x, from 16 on by
/// the asymptotic series (Abramowitz and Stegun, 1964, 6.3.5 and 6.3.18, shifted by one half).
fn digamma_half(n: f64) -> f64 {
    const BELOW_16: [f64; 16] = {
        // ψ(1/2) = -γ - 2 ln 2
        let mut values = [-1.963_510_026_021_423_5; 16];
        let mut n = 1;
        while n < values.len() {
            values[n] = values[n - 1] + 1.0 / (n as f64 - 0.5);
            n += 1;
        }
        values
    };
    if n < 16.0 {
        return BELOW_16[n as usize];
    }
    let x = 1.0 / (n * n);
    n.ln() + x * (1.0 / 24.0 - x * (7.0 / 960.0 - x * (31.0 / 8064.0 - x * (127.0 / 30720.0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::LN_2;

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }

    #[test]
    fn digamma_of_halves() {
        assert_near(digamma_half(0.0), -1.963_510_026_021_423_5, 1e-13); // -γ - 2 ln 2
        assert_near(digamma_half(1.0), 0.036_489_973_978_576_52, 1e-11);
        assert_near(digamma_half(16.0) - digamma_half(15.0), 1.0 / 15.5, 1e-11);
    }

    #[test]
    fn variances_are_those_of_the_formulas() {
        for m in (0..20).map(|k| 1_u64 << k) {
            let mf = m as f64;
            let of = |law: PowerLaw| law.variance(Deviation::Allan, m);
            assert_near(of(PowerLaw::WhitePhase), 3.0 / (mf * mf), 1e-12);
            assert_near(of(PowerLaw::White), 1.0 / mf, 1e-12);
            assert_near(of(PowerLaw::RandomWalk), (2.0 * mf * mf + 1.0) / (6.0 * mf), 1e-9);
            let hadamard = |law: PowerLaw| law.variance(Deviation::Hadamard, m);
            assert_near(hadamard(PowerLaw::White), 1.0 / mf, 1e-12);
            if m >= 256 {
                assert_near(of(PowerLaw::Flicker), 2.0 * LN_2 / PI, 1e-4);
                assert_near(hadamard(PowerLaw::Flicker) / of(PowerLaw::Flicker), 0.8113, 1e-4);
                assert_near(hadamard(PowerLaw::RandomWalk) / of(PowerLaw::RandomWalk), 0.5, 1e-4);
            }
        }
        assert_near(PowerLaw::Flicker.variance(Deviation::Allan, 1), 2.0 / PI, 1e-12);
    }
}
