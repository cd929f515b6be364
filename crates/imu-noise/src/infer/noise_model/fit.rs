//! The fit of one channel: which octaves follow the model, and the parameters that they show.

use std::ops::Range;

use super::{
    NoiseModel, Parameter, Status, Term,
    least_squares::dot,
    model::Model,
    parameter::ramp,
    regression::{Regression, Solution},
};
use crate::infer::chi_squared;

/// Fits with a smaller probability are not believed.
const LEAST_P: f64 = 0.01;

/// An octave that adds more to χ², as one in twenty does by chance, disagrees with the longer ones.
const MOST_FROM_ONE: f64 = 3.84;

/// The fitted noise of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFit {
    /// `None` where no parameter could be fitted.
    pub quality: Option<FitQuality>,
    /// By term, as in [`Term::ALL`]; `None` for terms that were not asked for.
    parameters: [Option<Parameter>; Term::ALL.len()],
    /// Averaging factor and edf of each octave from the shortest in use on.
    edf: Vec<(u64, f64)>,
    correlations: Vec<(Term, Term, f64)>,
}

/// Goodness of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
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

struct Accepted<'a> {
    model: &'a Model,
    regression: Regression<'a>,
    solution: Solution,
    range: Range<usize>,
    quality: FitQuality,
}

impl NoiseFit {
    /// The parameter of `term`; `None` if it was not asked for.
    #[must_use]
    pub fn parameter(&self, term: Term) -> Option<Parameter> {
        self.parameters[term as usize]
    }

    /// Equivalent degrees of freedom of the octave with averaging factor `m` in the fitted mixture
    /// of noises; `None` for octaves that do not follow the model and below two windows.
    #[must_use]
    pub fn edf(&self, m: u64) -> Option<f64> {
        self.edf.iter().find(|(octave, _)| *octave == m).map(|(_, edf)| *edf)
    }

    /// Of the squared amplitudes of two terms, -1 to 1; `None` unless both are positive.
    #[must_use]
    pub fn correlation(&self, a: Term, b: Term) -> Option<f64> {
        let found = self.correlations.iter().find(|(p, q, _)| (*p, *q) == (a, b) || (*p, *q) == (b, a));
        found.map(|(.., correlation)| *correlation)
    }
}

impl NoiseModel {
    /// Fits the model to the `variances` of one channel, in the order of the octaves, in the unit
    /// of the channel squared. Where one is missing, zero or no number, nothing is observable.
    /// `slope_unit_s` is the slope of the regression line, in the unit of the channel per second;
    /// without it, a ramp is not observable and is not in the model.
    ///
    /// Generalised least squares with the covariance of all octaves from the fitted model itself,
    /// on statistics made normal, with squared amplitudes that cannot be negative. The shortest
    /// octaves, half of all at most, are excluded until the model holds with p >= 0.01: vibration
    /// shows there, and a fit through it invents bias instability. Where one had to go, so must the
    /// next unless χ² falls by less than 3.84 without it.
    ///
    /// A parameter is [`Status::Estimated`] where zero is excluded by more than 1.96 standard
    /// deviations (χ² falls by 3.84), else bounded from above. Interval and bound are the
    /// amplitudes that the data do not exclude at the level `confidence` (0 < p < 1), the other
    /// terms fitted anew for each of them; the bound is the upper end of the two-sided interval, so
    /// that the level holds whichever comes out.
    #[must_use]
    pub fn fit(&self, variances: &[f64], slope_unit_s: Option<f64>, confidence: f64) -> NoiseFit {
        let without_shortest = (0..=self.fitted / 2).map(|skip| skip..self.fitted);
        self.fit_first(without_shortest, variances, slope_unit_s, confidence)
    }

    /// As [`fit`](Self::fit), without a ramp, to as many octaves as follow the model, half of all
    /// at least, without the shortest or the longest: for streams whose long averaging times show
    /// something else, such as a filter that takes slow changes out. Of as many octaves, those at
    /// shorter averaging times are tried first.
    #[must_use]
    pub fn fit_part(&self, variances: &[f64], confidence: f64) -> NoiseFit {
        let parts = (0..=self.fitted / 2)
            .flat_map(|excluded| (0..=excluded).map(move |skip| (skip, excluded - skip)))
            .map(|(skip, end)| skip..self.fitted - end);
        self.fit_first(parts, variances, None, confidence)
    }

    fn fit_first(
        &self,
        ranges: impl Iterator<Item = Range<usize>>,
        variances: &[f64],
        slope_unit_s: Option<f64>,
        confidence: f64,
    ) -> NoiseFit {
        let mut values: Vec<f64> = self.octaves.iter().filter_map(|(i, _)| variances.get(*i).copied()).collect();
        let slope = slope_unit_s.map(|slope| slope * self.shape.interval_s);
        let (model, slope) = match (&self.with_ramp, slope) {
            (Some(model), Some(slope)) => (Some(model), Some(slope)),
            _ => (self.without_ramp.as_ref(), None),
        };
        let usable = values.len() == self.octaves.len() && values.iter().all(|value| value.is_finite() && *value > 0.0);
        values.extend(slope.map(|slope| slope * slope));
        let Some(model) = model.filter(|_| usable) else { return self.without_values(Status::NotObservable) };
        if self.fitted + usize::from(slope.is_some()) <= model.basis.len() {
            return self.without_values(Status::NotObservable);
        }
        for range in ranges {
            let regression = Regression::new(model, &values, range.clone());
            if regression.statistics() <= model.basis.len() {
                break;
            }
            let Some(solution) = regression.fit() else { continue };
            let positive = solution.parameters.iter().filter(|parameter| **parameter > 0.0).count();
            let dof = regression.statistics() - positive;
            let Some(p) = chi_squared::probability_above(solution.chi2, dof as f64).filter(|p| *p >= LEAST_P) else {
                continue;
            };
            // where octaves had to go, the line that made them go still pulls at the next, which says most of the white noise
            let without_first = Regression::new(model, &values, range.start + 1..range.end);
            if range.start > 0
                && without_first.statistics() > model.basis.len()
                && without_first.fit().is_some_and(|without| solution.chi2 - without.chi2 > MOST_FROM_ONE)
            {
                continue;
            }
            let tau_s = |i: usize| self.octaves[i].1.m as f64 * self.shape.interval_s;
            let quality = FitQuality {
                tau_min_s: tau_s(range.start),
                tau_max_s: tau_s(range.end - 1),
                chi2: solution.chi2,
                dof,
                p,
            };
            let accepted = Accepted { model, regression, solution, range, quality };
            return self.read_out(&accepted, slope, confidence);
        }
        self.without_values(Status::ModelRejected)
    }

    fn without_values(&self, status: Status) -> NoiseFit {
        let parameter = |term| self.terms.contains(term).then_some(Parameter::without_value(status));
        NoiseFit { quality: None, parameters: Term::ALL.map(parameter), edf: Vec::new(), correlations: Vec::new() }
    }

    fn read_out(&self, accepted: &Accepted<'_>, slope: Option<f64>, confidence: f64) -> NoiseFit {
        let Accepted { model, regression, solution, range, quality } = accepted;
        let mut fit = self.without_values(Status::NotObservable);
        fit.quality = Some(*quality);
        // What noise may be at most makes slopes; a measured noise is known to some degrees of freedom.
        let mut upper_bounds = solution.parameters.clone();
        let mut deviations = vec![0.0; upper_bounds.len()];
        for (i, &term) in self.noise.iter().enumerate() {
            let parameter = Parameter::of(regression, solution, i, confidence);
            if parameter.status == Status::Bounded {
                upper_bounds[i] = parameter.upper.map_or(upper_bounds[i], |upper| upper * upper);
            } else {
                deviations[i] = solution.standard_deviation(i).unwrap_or_default();
            }
            fit.parameters[term as usize] = Some(parameter.scaled(term.per_second(self.shape.interval_s)));
            for (j, &other) in self.noise[..i].iter().enumerate() {
                if solution.parameters[i] > 0.0 && solution.parameters[j] > 0.0 {
                    fit.correlations.extend(solution.correlation(i, j).map(|correlation| (other, term, correlation)));
                }
            }
        }
        if let Some(slope) = slope {
            let per_parameter = model.slope_variances();
            let variance = dot(per_parameter, &upper_bounds);
            let error: f64 = per_parameter.iter().zip(&deviations).map(|(c, deviation)| (c * deviation).powi(2)).sum();
            let parameter = ramp(slope, variance.sqrt(), 2.0 * variance * variance / error, confidence);
            fit.parameters[Term::RateRamp as usize] =
                Some(parameter.scaled(Term::RateRamp.per_second(self.shape.interval_s)));
        }
        let edf = model.edf(&solution.parameters, &upper_bounds);
        // octaves too long to be fitted may follow the model all the same
        let end = if range.end == self.fitted { self.octaves.len() } else { range.end };
        fit.edf = self.octaves[..end].iter().map(|(_, octave)| octave.m).zip(edf).skip(range.start).collect();
        fit
    }
}
