//! What the fit of one channel says: parameters, quality, and what stands beside them.

use super::{Parameter, Status, Term, Withheld};
use schemars::JsonSchema;
use serde::Serialize;

/// The fitted noise of one channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseFit {
    /// `None` if no parameter could be fitted.
    pub quality: Option<FitQuality>,
    /// By term, as in [`Term::ALL`]; `None` for terms that were not asked for.
    pub(super) parameters: [Option<Parameter>; Term::ALL.len()],
    /// The likeliest noise beside the white one.
    pub likeliest: SlowNoise,
    /// Whether the record shows the processes beyond doubt.
    pub is_process_proved: bool,
    /// Lines cover more than half of the frequencies: what looks white between them may be their
    /// tails, and N is bounded only.
    pub lacks_free_band: bool,
    /// Behind a low pass slower than the output, whose presence is beyond doubt: density of the white
    /// noise at low frequencies over its mean density, the correlation time in samples with both signs
    /// counted; above 1.
    pub correlation_samples: Option<f64>,
    /// What explains the record about as well as B, K and R, which are bounded for it, by term.
    pub(super) rivals: [Option<Withheld>; Term::ALL.len()],
    /// Averaging factor and edf of each octave from the shortest in use on.
    pub(super) edf: Vec<(u64, f64)>,
    /// Averaging factor and expected variance of each octave in use, in the unit squared.
    pub(super) expected: Vec<(u64, f64)>,
}

/// Goodness of a fit.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct FitQuality {
    /// In seconds: the sampling interval, or, behind a filter that leaves a part of the frequencies,
    /// half a period of the highest one in use.
    pub tau_min_s: f64,
    /// Longest averaging time in use, in seconds.
    pub tau_max_s: f64,
    /// Sum of the squared deviations of the density and the octaves from the fitted ones.
    pub chi2: f64,
    /// Densities and octaves in use, less parameters.
    pub dof: usize,
    /// Probability of a larger sum if the model is right.
    pub p: f64,
}

/// The likeliest slow noise of a channel. The record need not prove any part of it.
#[derive(Clone, Debug, Default, PartialEq, JsonSchema, Serialize)]
pub struct SlowNoise {
    /// B, in the unit of the channel; zero where processes stand in its place.
    pub bias_instability: f64,
    /// K, in the unit over √s.
    pub rate_random_walk: f64,
    /// Gauss-Markov noise, in rising correlation time.
    pub processes: Vec<GaussMarkovProcess>,
}

/// First-order Gauss-Markov noise.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct GaussMarkovProcess {
    /// Where the covariance is σ²/e; known to a factor of about two.
    pub correlation_time_s: f64,
    /// Standard deviation σ, in the unit of the channel.
    pub sigma: f64,
}

impl NoiseFit {
    /// The parameter of `term`; `None` if it was not asked for.
    pub fn parameter(&self, term: Term) -> Option<Parameter> {
        self.parameters[term as usize]
    }

    /// N that long averages show, in unit/√Hz: that of the white and the Gauss-Markov noise
    /// together, √(N² + Σ 2σ²T). `None` if no Gauss-Markov noise is proved or N has no value.
    pub fn apparent_white(&self) -> Option<f64> {
        let white = self.parameter(Term::White)?.value.filter(|_| self.is_process_proved)?;
        let of = |process: &GaussMarkovProcess| 2.0 * process.sigma.powi(2) * process.correlation_time_s;
        Some((white * white + self.likeliest.processes.iter().map(of).sum::<f64>()).sqrt())
    }

    /// What explains the record about as well as `term`, where it is bounded for that.
    pub fn rival(&self, term: Term) -> Option<Withheld> {
        self.rivals[term as usize]
    }

    /// The fit where `term` is no more than bounded, as other channels were tested too.
    pub fn not_proved(&mut self, term: Term) {
        if let Some(parameter) = &mut self.parameters[term as usize] {
            *parameter = parameter.not_proved();
        }
    }

    /// Takes the model back: each parameter has this status. The degrees of freedom stay.
    pub fn withhold(&mut self, status: Status) {
        let parameters = self.parameters.map(|known| known.map(|_| Parameter::without_value(status)));
        let edf = std::mem::take(&mut self.edf);
        *self = Self { edf, parameters, ..Self::default() };
    }

    /// Equivalent degrees of freedom of the octave with averaging factor `m` in the fitted mixture
    /// of noises; `None` for octaves that do not follow the model and below two windows.
    pub fn edf(&self, m: u64) -> Option<f64> {
        self.edf.iter().find(|(octave, _)| *octave == m).map(|(_, edf)| *edf)
    }

    /// Deviation of the whole solution at averaging factor `m`, in the unit of the channel: all terms at
    /// their best values, bounded ones too. `None` for octaves that have no part in the fit.
    pub fn deviation(&self, m: u64) -> Option<f64> {
        self.expected.iter().find(|(octave, _)| *octave == m).map(|(_, variance)| variance.sqrt())
    }
}
