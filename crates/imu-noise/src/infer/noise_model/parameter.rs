//! The noise parameters: the components of the noise of a rate, and what is known of each.

use super::regression::{Regression, Solution};
use crate::infer::chi_squared;
use schemars::JsonSchema;
use serde::Serialize;

/// Standard deviations above zero that exclude it: χ² falls by more than 3.84, which noise without
/// the term does in 2.5 % of records; of a walk decided by the level, twice the log-likelihood,
/// which noise without one does in half as many at most.
pub(super) const PRESENT: f64 = 1.96;

/// A square that is so small a part of the best one is as good as zero: at zero itself the model
/// may lack what keeps the other terms apart, and χ² leaps.
const NEGLIGIBLE: f64 = 1e-4;

/// Probability, corrected for all slow terms and axes of a record together, up to which one of them
/// is proved.
pub const PROVED_P: f64 = 0.03;

/// Relative error of the squared parameter.
const TOLERANCE: f64 = 2e-3;

/// What is known of a noise parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// It is there, and has a value and a two-sided interval.
    Estimated,
    /// It may be absent; it is not above the upper bound.
    Bounded,
    /// The record does not show it.
    NotObservable,
    /// The stream does not carry it, however long the record; set by the caller.
    NotMeasurable,
    /// The sensor was moved: what the fit shows is the motion; set by the caller.
    Moved,
    /// No range of averaging times follows the model.
    ModelRejected,
}

impl Status {
    /// From what is known best to what is known least.
    pub const ALL: [Self; 6] =
        [Self::Estimated, Self::Bounded, Self::NotObservable, Self::NotMeasurable, Self::Moved, Self::ModelRejected];
}

/// A noise parameter, in the unit of its term.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Parameter {
    /// What is known.
    pub status: Status,
    /// The best value, where estimated.
    pub value: Option<f64>,
    /// Lower end of the interval, where estimated.
    pub lower: Option<f64>,
    /// Upper end of the interval, where estimated; the bound on the magnitude, where bounded.
    pub upper: Option<f64>,
    /// Probability that noise without this term would show as much of it; `None` if that was
    /// not tested.
    pub p: Option<f64>,
}

impl Parameter {
    /// A parameter of which nothing more is known than `status`.
    #[must_use]
    pub const fn without_value(status: Status) -> Self {
        Self { status, value: None, lower: None, upper: None, p: None }
    }

    /// A value with the interval from `lower` to `upper`.
    #[must_use]
    pub const fn estimated(value: f64, lower: f64, upper: f64) -> Self {
        Self { status: Status::Estimated, value: Some(value), lower: Some(lower), upper: Some(upper), p: None }
    }

    /// A bound from above.
    #[must_use]
    pub const fn bounded(upper: f64) -> Self {
        Self { upper: Some(upper), ..Self::without_value(Status::Bounded) }
    }

    /// The same, known to be no more than bounded: it may be absent after all.
    #[must_use]
    pub fn not_proved(self) -> Self {
        // of a ramp that falls the lower end is the larger magnitude
        let upper = self.lower.into_iter().chain(self.upper).map(f64::abs).reduce(f64::max);
        Self { status: Status::Bounded, value: None, lower: None, upper, ..self }
    }

    /// Half the width of the interval over the value; `None` without a value other than zero.
    #[must_use]
    pub fn relative_half_width(&self) -> Option<f64> {
        let half_width = (self.upper? - self.lower?) / 2.0;
        self.value.filter(|value| *value != 0.0).map(|value| (half_width / value).abs())
    }

    /// Reads parameter `term`, a square, off the best fit; the result is its root.
    pub(super) fn of(regression: &Regression<'_>, solution: &Solution, term: usize, confidence: f64) -> Self {
        let search = Search { regression, solution, term };
        let found = chi_squared::normal_two_sided(confidence).and_then(|z| Some((z, search.crossing_above(z)?)));
        let Some((z, upper)) = found else { return Self::without_value(Status::NotObservable) };
        let best = solution.parameters[term];
        let (lower, at_zero) = search.lower(z);
        let found = match at_zero > PRESENT {
            true => Self::estimated(best.sqrt(), lower.sqrt(), upper.sqrt()),
            false => Self::bounded(upper.sqrt()),
        };
        Self { p: Some(chi_squared::normal_above(at_zero)), ..found }
    }

    /// By how many standard deviations zero is excluded for parameter `term`.
    pub(super) fn evidence(regression: &Regression<'_>, solution: &Solution, term: usize) -> f64 {
        let search = Search { regression, solution, term };
        if search.best() > 0.0 { search.at_zero().0 } else { 0.0 }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * factor);
        Self { value: scaled(self.value), lower: scaled(self.lower), upper: scaled(self.upper), ..self }
    }
}

/// The ramp from the slope of the regression line and the standard deviation that noise gives it,
/// with `dof` degrees of freedom. It is there above twice that, which a random walk reaches at K
/// √(1.2/T), or more where the noise is poorly known (Student, 1908).
pub(super) fn ramp(slope: f64, deviation: f64, dof: f64, confidence: f64) -> Parameter {
    let quantiles = chi_squared::student_two_sided(confidence, dof).zip(chi_squared::student_two_sided(0.96, dof));
    let Some((t, present)) = quantiles else { return Parameter::without_value(Status::NotObservable) };
    let found = match slope.abs() > present.max(2.0) * deviation {
        true => Parameter::estimated(slope, slope - t * deviation, slope + t * deviation),
        false => Parameter::bounded(slope.abs() + t * deviation),
    };
    Parameter { p: chi_squared::student_two_sided_above(slope.abs() / deviation, dof), ..found }
}

struct Search<'a> {
    regression: &'a Regression<'a>,
    solution: &'a Solution,
    term: usize,
}

impl Search<'_> {
    fn best(&self) -> f64 {
        self.solution.parameters[self.term]
    }

    /// Standard deviations by which the data lie above `value`, and the fit there.
    fn score(&self, value: f64, near: &[f64]) -> Option<(f64, Vec<f64>)> {
        let solution = self.regression.fit_with(self.term, value, near)?;
        Some((solution.score(self.term)?, solution.parameters))
    }

    /// The root of what χ² rises from the best fit to `value` below it, and the fit there. With few
    /// degrees of freedom that finds a weak term more often than the score does, which weighs by
    /// the covariance without it.
    fn rise(&self, value: f64, near: &[f64]) -> Option<(f64, Vec<f64>)> {
        let solution = self.regression.fit_with(self.term, value, near)?;
        Some(((solution.chi2 - self.solution.chi2).max(0.0).sqrt(), solution.parameters))
    }

    /// Standard deviations by which the data lie above zero, and the fit there: without the term
    /// there may be nothing left that could explain the data.
    fn at_zero(&self) -> (f64, Vec<f64>) {
        let near = &self.solution.parameters;
        let without = self.regression.fit_without(self.term, near);
        let rise = |without: Solution| ((without.chi2 - self.solution.chi2).max(0.0).sqrt(), without.parameters);
        without.map(rise).unwrap_or((f64::INFINITY, near.clone()))
    }

    /// The largest value less than `z` standard deviations above the data. Where the best fit is
    /// zero and the data lie below even that, distances count from there, in squares.
    fn crossing_above(&self, z: f64) -> Option<f64> {
        let mut low = self.best();
        let at_best = if low > 0.0 { 0.0 } else { self.solution.score(self.term)? };
        let z = z.hypot(at_best);
        let mut step = (z + 1.0) * self.solution.standard_deviation(self.term)?;
        let mut near = self.solution.parameters.clone();
        for _ in 0..30 {
            let high = low + step;
            let (score, parameters) = self.score(high, &near)?;
            near = parameters;
            if score + z < 0.0 {
                let low_score = if low == self.best() { at_best + z } else { self.score(low, &near)?.0 + z };
                return Some(self.root(Self::score, (low, low_score), (high, score + z), z, &near));
            }
            low = high;
            step *= 2.0;
        }
        None
    }

    /// The smallest value less than `z` standard deviations below the data, and how many of them
    /// zero is.
    fn lower(&self, z: f64) -> (f64, f64) {
        let best = self.best();
        if best == 0.0 {
            return (0.0, self.solution.score(self.term).unwrap_or(0.0));
        }
        let near = &self.solution.parameters;
        let (at_zero, parameters) = self.at_zero();
        if at_zero <= PRESENT.max(z) {
            return (0.0, at_zero);
        }
        let deviation = self.solution.standard_deviation(self.term).unwrap_or(best);
        // Far from zero the bound is near the normal one.
        let mut low = best - (z + 1.0) * deviation;
        if low > 0.0 {
            while let Some((rise, _)) = self.rise(low, near) {
                if rise > z {
                    return (self.root(Self::rise, (low, rise - z), (best, -z), -z, near), at_zero);
                }
                low = 2.0 * low - best;
                if low <= 0.0 {
                    break;
                }
            }
        }
        let finite = at_zero.min(100.0);
        let lower = self.root(Self::rise, (0.0, finite - z), (best, -z), -z, &parameters);
        let negligible = NEGLIGIBLE * best;
        match self.rise(negligible, &parameters).filter(|_| lower < negligible) {
            Some((above_zero, _)) => (0.0, above_zero.min(at_zero)),
            None => (lower, at_zero),
        }
    }

    /// Where `distance` + `offset` falls through zero, by false position with halving of a stale
    /// end (Dowell and Jarratt, 1971).
    fn root(
        &self,
        distance: impl Fn(&Self, f64, &[f64]) -> Option<(f64, Vec<f64>)>,
        low: (f64, f64),
        high: (f64, f64),
        offset: f64,
        near: &[f64],
    ) -> f64 {
        let ((mut low, mut at_low), (mut high, mut at_high)) = (low, high);
        let mut near = near.to_vec();
        let mut middle = high;
        for _ in 0..30 {
            let before = middle;
            middle = (low * at_high - high * at_low) / (at_high - at_low);
            if !(middle > low && middle < high) {
                middle = (low + high) / 2.0;
            }
            let tolerance = TOLERANCE * middle.max(TOLERANCE * self.best());
            if (middle - before).abs() <= tolerance || high - low <= tolerance {
                break;
            }
            let Some((found, parameters)) = distance(self, middle, &near) else { break };
            near = parameters;
            let value = found + offset;
            if value > 0.0 {
                (low, at_low) = (middle, value);
                at_high /= 2.0;
            } else {
                (high, at_high) = (middle, value);
                at_low /= 2.0;
            }
        }
        middle
    }
}
