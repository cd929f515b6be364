//! What the fit of one channel says: parameters, quality, and what stands beside them.

use super::{Parameter, Status, Term};
use crate::infer::roll_off::RollOff;
use schemars::JsonSchema;
use serde::Serialize;

/// The fitted noise of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFit {
    /// `None` if no parameter could be fitted.
    pub quality: Option<FitQuality>,
    /// By term, as in [`Term::ALL`]; `None` for terms that were not asked for.
    pub(super) parameters: [Option<Parameter>; Term::ALL.len()],
    /// Gauss-Markov noise beside the terms, in rising correlation time.
    pub processes: Vec<GaussMarkovProcess>,
    /// Whether the record shows processes beyond doubt. Otherwise they keep the interval of N from
    /// being too narrow, and may as well be absent.
    pub is_process_proved: bool,
    /// Lines cover more than half of the frequencies: what looks white between them may be their
    /// tails, and N is bounded only.
    pub lacks_free_band: bool,
    /// The low pass of unknown transfer behind which the terms were fitted, where one is proved.
    pub roll_off: Option<RollOff>,
    /// A filter of unknown transfer is possible but not proved, and matters: it makes the interval
    /// of N more than 1.5 times as wide, or a bound, or the model holds only behind it.
    pub may_be_filtered: bool,
    /// Averaging factor and edf of each octave from the shortest in use on.
    pub(super) edf: Vec<(u64, f64)>,
    /// Averaging factor and expected variance of each octave in use, in the unit squared.
    pub(super) expected: Vec<(u64, f64)>,
    pub(super) correlations: Vec<(Term, Term, f64)>,
}

/// Goodness of a fit.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct FitQuality {
    /// In seconds. Octaves below do not follow the model, as with vibration.
    pub tau_min_s: f64,
    /// Longest averaging time in use, in seconds.
    pub tau_max_s: f64,
    /// Sum of squared independent residuals.
    pub chi2: f64,
    /// Octaves in use, one more for the slope of the record, less positive parameters.
    pub dof: usize,
    /// Probability of a larger sum if the model is right.
    pub p: f64,
}

/// First-order Gauss-Markov noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkovProcess {
    /// Where the covariance is σ²/e; known to a factor of about two.
    pub correlation_time_s: f64,
    /// Standard deviation σ, in the unit of the channel.
    pub sigma: f64,
}

impl NoiseFit {
    /// Parameters by term, as in [`Term::ALL`], and nothing else.
    pub(super) const fn of_parameters(parameters: [Option<Parameter>; Term::ALL.len()]) -> Self {
        Self {
            quality: None,
            parameters,
            processes: Vec::new(),
            is_process_proved: false,
            lacks_free_band: false,
            roll_off: None,
            may_be_filtered: false,
            edf: Vec::new(),
            expected: Vec::new(),
            correlations: Vec::new(),
        }
    }

    /// The parameter of `term`; `None` if it was not asked for.
    #[must_use]
    pub fn parameter(&self, term: Term) -> Option<Parameter> {
        self.parameters[term as usize]
    }

    /// N that long averages show, in unit/√Hz: that of the white and the Gauss-Markov noise
    /// together, √(N² + Σ 2σ²T). `None` if no Gauss-Markov noise is proved or N has no value.
    #[must_use]
    pub fn apparent_white(&self) -> Option<f64> {
        let white = self.parameter(Term::White)?.value.filter(|_| self.is_process_proved)?;
        let of = |process: &GaussMarkovProcess| 2.0 * process.sigma.powi(2) * process.correlation_time_s;
        Some((white * white + self.processes.iter().map(of).sum::<f64>()).sqrt())
    }

    pub(super) fn with_proved_processes(mut self) -> Self {
        self.is_process_proved = !self.processes.is_empty();
        self
    }

    /// The fit where `term` is known to be no more than bounded, as other channels of the record
    /// were tested too.
    pub fn not_proved(&mut self, term: Term) {
        if let Some(parameter) = &mut self.parameters[term as usize] {
            *parameter = parameter.not_proved();
        }
    }

    /// Takes all parameters and the model behind them back: each has this status, and no value. The
    /// degrees of freedom of the octaves stay.
    pub fn withhold(&mut self, status: Status) {
        let parameters = self.parameters.map(|known| known.map(|_| Parameter::without_value(status)));
        let edf = std::mem::take(&mut self.edf);
        *self = Self { edf, ..Self::of_parameters(parameters) };
    }

    /// Lets the interval of `term` cover that of another fit that explains the record as well.
    pub(super) fn widen(&mut self, term: Term, other: &Self) {
        let Some((ours, theirs)) = self.parameters[term as usize].as_mut().zip(other.parameter(term)) else { return };
        if ours.status == Status::Estimated {
            ours.lower = ours.lower.zip(theirs.lower).map(|(ours, theirs)| ours.min(theirs)).or(ours.lower);
        }
        ours.upper = ours.upper.zip(theirs.upper).map(|(ours, theirs)| ours.max(theirs)).or(ours.upper);
    }

    /// Lets intervals and bounds cover those of another fit that may be the right one: a term that
    /// only one of them shows is no more than bounded.
    pub(super) fn cover(&mut self, other: &Self) {
        let width = |fit: &Self| fit.parameter(Term::White)?.relative_half_width();
        let before = width(self);
        for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
            self.widen(term, other);
            let Some((ours, theirs)) = self.parameters[term as usize].as_mut().zip(other.parameter(term)) else {
                continue;
            };
            if [ours.status, theirs.status].contains(&Status::NotObservable) {
                *ours = Parameter::without_value(Status::NotObservable);
                continue;
            }
            ours.p = ours.p.zip(theirs.p).map(|(ours, theirs)| ours.max(theirs));
            if theirs.status != Status::Estimated {
                *ours = ours.not_proved();
            }
        }
        self.may_be_filtered = before.is_some_and(|before| width(self).is_none_or(|after| after > 1.5 * before));
    }

    /// Equivalent degrees of freedom of the octave with averaging factor `m` in the fitted mixture
    /// of noises; `None` for octaves that do not follow the model and below two windows.
    #[must_use]
    pub fn edf(&self, m: u64) -> Option<f64> {
        self.edf.iter().find(|(octave, _)| *octave == m).map(|(_, edf)| *edf)
    }

    /// Deviation of the whole solution at averaging factor `m`, in the unit of the channel: all
    /// terms at their best values, those that are bounded only too, the ramp, lines and
    /// Gauss-Markov noise. `None` for octaves that have no part in the fit.
    #[must_use]
    pub fn deviation(&self, m: u64) -> Option<f64> {
        self.expected.iter().find(|(octave, _)| *octave == m).map(|(_, variance)| variance.sqrt())
    }

    /// Of the squared amplitudes of two terms, -1 to 1; `None` unless both are positive.
    #[must_use]
    pub fn correlation(&self, a: Term, b: Term) -> Option<f64> {
        let found = self.correlations.iter().find(|(p, q, _)| (*p, *q) == (a, b) || (*p, *q) == (b, a));
        found.map(|(.., correlation)| *correlation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_covers_another_that_may_be_the_right_one() {
        let fit = |parameters: [Option<Parameter>; 3]| {
            let [white, flicker, walk] = parameters;
            NoiseFit::of_parameters(Term::ALL.map(|term| match term {
                Term::White => white,
                Term::BiasInstability => flicker,
                Term::RateRandomWalk => walk,
                Term::Quantization | Term::RateRamp => None,
            }))
        };
        let estimated = |value: f64, half: f64| Some(Parameter::estimated(value, value - half, value + half));
        let nothing = Some(Parameter::without_value(Status::NotObservable));
        let mut ours = fit([estimated(1.0, 0.1), estimated(0.5, 0.1), nothing]);
        ours.cover(&fit([estimated(1.2, 0.2), Some(Parameter::bounded(0.7)), Some(Parameter::bounded(1.0))]));
        assert_eq!(ours.parameter(Term::White), Some(Parameter::estimated(1.0, 0.9, 1.4)));
        assert_eq!(ours.parameter(Term::BiasInstability), Some(Parameter::bounded(0.7)));
        assert_eq!(ours.parameter(Term::RateRandomWalk), nothing);
        assert!(ours.may_be_filtered);
        // about as wide as before
        let mut ours = fit([estimated(1.0, 0.1), None, None]);
        ours.cover(&fit([estimated(1.01, 0.1), nothing, nothing]));
        assert!(!ours.may_be_filtered && ours.parameter(Term::BiasInstability).is_none());
        // N itself is not known behind the filter
        let mut ours = fit([estimated(1.0, 0.1), estimated(0.5, 0.1), Some(Parameter::bounded(1.0))]);
        ours.cover(&fit([Some(Parameter::bounded(1.5)), nothing, nothing]));
        assert_eq!(ours.parameter(Term::White), Some(Parameter::bounded(1.5)));
        assert_eq!(ours.parameter(Term::BiasInstability), nothing);
        assert_eq!(ours.parameter(Term::RateRandomWalk), nothing);
        assert!(ours.may_be_filtered);
    }
}
