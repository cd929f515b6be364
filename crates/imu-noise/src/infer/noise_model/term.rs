//! The terms of noise that a model may have.

use crate::accumulate::record::{Deviation, RecordShape};
use crate::infer::power_law::PowerLaw;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A component of the noise of a rate, with its letter in IEEE Std 952 and its Allan variance.
/// Amplitudes follow the two-sided spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, JsonSchema, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Term {
    /// Q, unit · s: 3 Q²/τ². Rounding of an angle; rounding of a rate is white.
    Quantization,
    /// N, unit/√Hz: N²/τ. Angle or velocity random walk.
    White,
    /// B, unit: (2 ln 2/π) B². Flicker noise.
    BiasInstability,
    /// K, unit/√s: K² τ/3.
    RateRandomWalk,
    /// R, unit/s, with a sign: R² τ²/2. Not random.
    RateRamp,
}

impl Term {
    /// All terms, in the order in which results are given.
    pub const ALL: [Self; 5] =
        [Self::Quantization, Self::White, Self::BiasInstability, Self::RateRandomWalk, Self::RateRamp];

    /// The Allan or Hadamard variance, in the unit of the channel squared, of this component alone, at
    /// `amplitude` in its own unit, at averaging factor `m` >= 1 of a record of this shape, but for
    /// averaging on board. A ramp has no Hadamard variance.
    pub fn variance(self, amplitude: f64, m: u64, shape: &RecordShape) -> f64 {
        let amplitude = amplitude / self.per_second(shape.interval_s);
        let of = |law: PowerLaw| law.variance(shape.deviation, m);
        amplitude
            * amplitude
            * match (self, shape.deviation) {
                (Self::Quantization, _) => of(PowerLaw::WhitePhase),
                (Self::White, _) => of(PowerLaw::White),
                (Self::BiasInstability, _) => of(PowerLaw::Flicker),
                (Self::RateRandomWalk, _) => of(PowerLaw::RandomWalk),
                (Self::RateRamp, Deviation::Allan) => (m as f64).powi(2) / 2.0,
                (Self::RateRamp, Deviation::Hadamard) => 0.0,
            }
    }

    /// From an amplitude in sample intervals to one in seconds.
    pub(super) fn per_second(self, interval_s: f64) -> f64 {
        match self {
            Self::Quantization => interval_s,
            Self::White => interval_s.sqrt(),
            Self::BiasInstability => 1.0,
            Self::RateRandomWalk => 1.0 / interval_s.sqrt(),
            Self::RateRamp => 1.0 / interval_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Estimator;

    #[test]
    fn long_averaging_times_show_the_published_formulas() {
        let shape =
            RecordShape { samples: 0, interval_s: 0.01, estimator: Estimator::Full, deviation: Deviation::Allan };
        let (amplitude, m) = (3.0, 1 << 12);
        let tau = m as f64 * shape.interval_s;
        for (term, expected) in [
            (Term::Quantization, 3.0 / (tau * tau)),
            (Term::White, 1.0 / tau),
            (Term::BiasInstability, 2.0 * core::f64::consts::LN_2 / core::f64::consts::PI),
            (Term::RateRandomWalk, tau / 3.0),
            (Term::RateRamp, tau * tau / 2.0),
        ] {
            let off = term.variance(amplitude, m, &shape) / (amplitude * amplitude * expected) - 1.0;
            assert!(off.abs() < 1e-6, "{term:?} {off}");
        }
        let hadamard = RecordShape { deviation: Deviation::Hadamard, ..shape };
        assert_eq!(Term::RateRamp.variance(amplitude, m, &hadamard), 0.0);
    }
}
