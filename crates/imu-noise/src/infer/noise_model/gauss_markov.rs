//! White noise and one first-order Gauss-Markov process, for filters that ask for them.

use super::{
    NoiseModel, Parameter, Status, Term,
    boxcar::StreamedWhite,
    joint::{Component, of_each},
    model::Model,
    regression::{Regression, Solution},
};
use crate::accumulate::record::Octave;
use crate::infer::chi_squared;

/// Correlation times tried, at equal ratios.
const TRIALS: usize = 24;

/// Over the averaging factor of the first octave in use: below, averages show little of the
/// process.
const SHORTEST: f64 = 8.0;

/// χ² falls by more in one of twenty records of white noise alone, the best of all trials taken.
const PRESENT: f64 = 6.6;

/// White noise and a first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkovFit {
    /// N, in unit/√Hz.
    pub white: Parameter,
    /// Standard deviation σ of the process, in the unit of the channel, for the best correlation
    /// time; bounded from below alone where that time is bounded.
    pub sigma: Parameter,
    /// Correlation time, where the covariance is σ²/e. The bounds are those of its interval, where
    /// they lie within the times that the record resolves: from 8 times the shortest averaging time
    /// in use to a quarter of the record. Where the best lies at an end of these, as a random
    /// walk's does, there is no value: it is bounded, from above at the short end (`upper`), from
    /// below at the long one (`lower`), or not observable.
    pub correlation_time_s: Parameter,
    /// Sum of squared independent residuals.
    pub chi2: f64,
    /// Octaves in use less three.
    pub dof: usize,
    /// Probability of a larger sum if the model is right.
    pub p: f64,
}

impl NoiseModel {
    /// Fits white noise and a first-order Gauss-Markov process instead of the terms of the model,
    /// at the level `confidence`, to all octaves of one channel, with 24 correlation times: some
    /// tenths of a second. `None` with fewer than five octaves, where no correlation time is
    /// resolved, for variances that are not positive, and for a level outside 0 < p < 1.
    #[must_use]
    pub fn fit_gauss_markov(&self, variances: &[f64], confidence: f64) -> Option<GaussMarkovFit> {
        let z = chi_squared::normal_two_sided(confidence)?;
        let octaves: Vec<Octave> = self.octaves[..self.fitted].iter().map(|(_, octave)| *octave).collect();
        let values: Vec<f64> =
            self.octaves[..self.fitted].iter().filter_map(|(i, _)| variances.get(*i).copied()).collect();
        let dof = octaves.len().checked_sub(3).filter(|dof| *dof > 1)?;
        if values.len() != octaves.len() || values.iter().any(|value| !(value.is_finite() && *value > 0.0)) {
            return None;
        }
        let shortest = SHORTEST * octaves[0].m as f64;
        let longest = self.shape.samples as f64 / 4.0;
        if longest <= shortest {
            return None;
        }
        let time = |trial: usize| shortest * (longest / shortest).powf(trial as f64 / (TRIALS - 1) as f64);
        let trials: Vec<(Model, Option<Solution>)> = (0..TRIALS)
            .map(|trial| {
                let model = self.gauss_markov(&octaves, time(trial));
                let solution = Regression::new(&model, &values, 0..octaves.len()).fit();
                (model, solution)
            })
            .collect();
        let chi2 = |trial: usize| trials[trial].1.as_ref().map_or(f64::INFINITY, |solution| solution.chi2);
        let best = (0..TRIALS).min_by(|a, b| chi2(*a).total_cmp(&chi2(*b)))?;
        let (model, solution) = (&trials[best].0, trials[best].1.as_ref()?);
        let regression = Regression::new(model, &values, 0..octaves.len());
        let parameter = |i| Parameter::of(&regression, solution, i, confidence);
        let without = regression.fit_with(1, 0.0, &solution.parameters);
        let is_there = without.is_none_or(|without| without.chi2 - solution.chi2 > PRESENT);
        let excluded = |trial: &usize| chi2(*trial) - solution.chi2 > z * z;
        let seconds = |trial: usize| time(trial) * self.shape.interval_s;
        let (shorter, longer) = ((0..best).rev().find(excluded), (best + 1..TRIALS).find(excluded));
        let (lower, upper) = (shorter.map(seconds), longer.map(seconds));
        let is_at_an_end = best == 0 || best == TRIALS - 1;
        let (sigma, correlation_time_s) = match parameter(1) {
            found if !is_there => (
                Parameter { upper: found.upper, ..Parameter::without_value(Status::Bounded) },
                Parameter::without_value(Status::NotObservable),
            ),
            found if found.status != Status::Estimated => (found, Parameter::without_value(Status::NotObservable)),
            // beyond the end the same variances have a larger σ
            found if is_at_an_end => {
                let status = if lower.or(upper).is_some() { Status::Bounded } else { Status::NotObservable };
                (
                    Parameter { lower: found.lower, ..Parameter::without_value(Status::Bounded) },
                    Parameter { lower, upper, ..Parameter::without_value(status) },
                )
            }
            found => (
                found,
                Parameter { value: Some(seconds(best)), lower, upper, ..Parameter::without_value(Status::Estimated) },
            ),
        };
        Some(GaussMarkovFit {
            white: parameter(0).scaled(Term::White.per_second(self.shape.interval_s)),
            sigma,
            correlation_time_s,
            chi2: solution.chi2,
            dof,
            p: chi_squared::probability_above(solution.chi2, dof as f64)?,
        })
    }

    fn gauss_markov(&self, octaves: &[Octave], time: f64) -> Model {
        let averaged = StreamedWhite::new(self.window);
        let white = |lag: f64| averaged.phase_covariance(lag);
        let process = |lag: f64| phase_covariance(lag, time);
        let (whites, processes) = (of_each(white), of_each(process));
        let white = Component { phase: &white, phases: &whites, meets_at_edges: false, scale: averaged.length() };
        let process = Component { phase: &process, phases: &processes, meets_at_edges: false, scale: u64::MAX };
        Model::new(octaves, &self.shape, &[white, process], None)
    }
}

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
