//! One noise parameter: value, interval and status.

use super::regression::{Regression, Solution};
use crate::infer::chi_squared;

/// Zero is excluded when the data lie this many standard deviations above: χ² falls by more than
/// 3.84, which noise without the term does in 2.5 % of records.
const PRESENT: f64 = 1.96;

/// Bounds are found to this relative error of the squared parameter.
const TOLERANCE: f64 = 2e-3;

/// What is known of a noise parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// It is there, and has a value and a two-sided interval.
    Estimated,
    /// It may be absent; it is not above the upper bound.
    Bounded,
    /// The record does not show it.
    NotObservable,
    /// The stream does not carry it, however long the record: set by the caller, because of what the
    /// sensor compensates.
    NotMeasurable,
    /// No range of averaging times follows the model.
    ModelRejected,
}

/// A noise parameter, in the unit of its term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// What is known.
    pub status: Status,
    /// The best value, where estimated.
    pub value: Option<f64>,
    /// Lower end of the interval, where estimated.
    pub lower: Option<f64>,
    /// Upper end of the interval, where estimated; the bound on the magnitude, where bounded.
    pub upper: Option<f64>,
}

impl Parameter {
    /// A parameter of which nothing more is known than `status`.
    #[must_use]
    pub const fn without_value(status: Status) -> Self {
        Self { status, value: None, lower: None, upper: None }
    }

    /// Half the width of the interval over the value; `None` where there is no value other than
    /// zero.
    #[must_use]
    pub fn relative_half_width(&self) -> Option<f64> {
        let half_width = (self.upper? - self.lower?) / 2.0;
        self.value.filter(|value| *value != 0.0).map(|value| (half_width / value).abs())
    }

    /// Reads parameter `term`, a square, off the best fit `solution`; the result is its root.
    pub(super) fn of(regression: &Regression<'_>, solution: &Solution, term: usize, confidence: f64) -> Self {
        let search = Search { regression, solution, term };
        let found = chi_squared::normal_two_sided(confidence).and_then(|z| Some((z, search.crossing_above(z)?)));
        let Some((z, upper)) = found else { return Self::without_value(Status::NotObservable) };
        let best = solution.parameters[term];
        let (lower, present) = search.lower(z);
        if present {
            Self {
                status: Status::Estimated,
                value: Some(best.sqrt()),
                lower: Some(lower.sqrt()),
                upper: Some(upper.sqrt()),
            }
        } else {
            Self { upper: Some(upper.sqrt()), ..Self::without_value(Status::Bounded) }
        }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * factor);
        Self { value: scaled(self.value), lower: scaled(self.lower), upper: scaled(self.upper), ..self }
    }
}

/// The ramp from the slope of the regression line, with a sign, and the standard deviation that
/// noise gives the slope, known with `dof` degrees of freedom.
///
/// It is there above twice that, which a random walk reaches at K √(1.2/T), or more where the noise
/// is poorly known (Student, 1908). A noise that is only bounded is taken at its bound.
pub(super) fn ramp(slope: f64, deviation: f64, dof: f64, confidence: f64) -> Parameter {
    let quantiles = chi_squared::student_two_sided(confidence, dof).zip(chi_squared::student_two_sided(0.96, dof));
    let Some((t, present)) = quantiles else { return Parameter::without_value(Status::NotObservable) };
    if slope.abs() > present.max(2.0) * deviation {
        Parameter {
            status: Status::Estimated,
            value: Some(slope),
            lower: Some(slope - t * deviation),
            upper: Some(slope + t * deviation),
        }
    } else {
        Parameter { upper: Some(slope.abs() + t * deviation), ..Parameter::without_value(Status::Bounded) }
    }
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

    /// Standard deviations by which the data lie above parameter = `value`, and the fit there.
    fn score(&self, value: f64, near: &[f64]) -> Option<(f64, Vec<f64>)> {
        let solution = self.regression.fit_with(self.term, value, near)?;
        Some((solution.score(self.term)?, solution.parameters))
    }

    /// The largest value that lies less than `z` standard deviations above the data. Where the best
    /// fit is zero and the data lie below even that, distances count from there, in squares.
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
                return Some(self.root((low, low_score), (high, score + z), z, &near));
            }
            low = high;
            step *= 2.0;
        }
        None
    }

    /// The smallest value that lies less than `z` standard deviations below the data, and whether
    /// zero is excluded.
    fn lower(&self, z: f64) -> (f64, bool) {
        let best = self.best();
        if best == 0.0 {
            return (0.0, false);
        }
        let near = &self.solution.parameters;
        // Without the term there may be nothing left that could explain the data.
        let (at_zero, parameters) = self.score(0.0, near).unwrap_or((f64::INFINITY, near.clone()));
        if at_zero <= PRESENT {
            return (0.0, false);
        }
        if at_zero <= z {
            return (0.0, true);
        }
        let deviation = self.solution.standard_deviation(self.term).unwrap_or(best);
        // Far from zero the bound is near the normal one.
        let mut low = best - (z + 1.0) * deviation;
        if low > 0.0 {
            while let Some((score, _)) = self.score(low, near) {
                if score > z {
                    return (self.root((low, score - z), (best, -z), -z, near), true);
                }
                low = 2.0 * low - best;
                if low <= 0.0 {
                    break;
                }
            }
        }
        let finite = at_zero.min(100.0);
        (self.root((0.0, finite - z), (best, -z), -z, &parameters), true)
    }

    /// Where score + `offset` falls through zero between two values with known signs, by false
    /// position with halving of a stale end (Dowell and Jarratt, 1971).
    fn root(&self, low: (f64, f64), high: (f64, f64), offset: f64, near: &[f64]) -> f64 {
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
            let Some((score, parameters)) = self.score(middle, &near) else { break };
            near = parameters;
            let value = score + offset;
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
