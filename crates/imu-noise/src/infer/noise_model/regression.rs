//! Generalised least squares with a covariance that depends on the parameters, and score tests.

use core::{cell::RefCell, ops::Range};

use super::{covariance::Covariance, model::Model};
use crate::infer::least_squares::{AT_ONCE, Cholesky, NonNegative, dot};

/// At most. Weights follow the fitted model: those from the data favour what is too low.
const ROUNDS: usize = 12;

pub(super) struct Regression<'a> {
    model: &'a Model,
    values: &'a [f64],
    used: Vec<usize>,
    space: RefCell<Space>,
}

/// Memory to work in, so that no step of a fit allocates any.
#[derive(Default)]
struct Space {
    covariance: Covariance,
    /// By statistic in use.
    expected: Vec<f64>,
    /// 1 over the standard deviation.
    inverse: Vec<f64>,
    cholesky: Cholesky,
    /// By statistic in use, some of residual and derivatives.
    rows: Vec<[f64; AT_ONCE]>,
    target: Vec<f64>,
    columns: Vec<f64>,
    least_squares: NonNegative,
}

#[derive(Clone, Default)]
pub(super) struct Solution {
    pub(super) parameters: Vec<f64>,
    pub(super) chi2: f64,
    /// Independent and with variance 1.
    residuals: Vec<f64>,
    /// By parameter, as many as residuals.
    derivatives: Vec<f64>,
}

impl<'a> Regression<'a> {
    /// `values`: the statistics of `model`; `octaves` have a part in the fit, and the slope if
    /// there is one.
    pub(super) fn new(model: &'a Model, values: &'a [f64], octaves: Range<usize>) -> Self {
        let used = octaves.chain(model.octaves..model.statistics()).collect();
        Self { model, values, used, space: RefCell::default() }
    }

    pub(super) fn statistics(&self) -> usize {
        self.used.len()
    }

    /// `None` if the model cannot be evaluated, as for data that never change.
    pub(super) fn fit(&self) -> Option<Solution> {
        self.solve(self.start(None), None)
    }

    /// With parameter `term` held at `value`, from parameters `near` it.
    pub(super) fn fit_with(&self, term: usize, value: f64, near: &[f64]) -> Option<Solution> {
        let mut start = near.to_vec();
        start[term] = value;
        if start.iter().all(|parameter| *parameter == 0.0) {
            start = self.start(Some(term));
        }
        self.solve(start, Some(term))
    }

    /// Without parameter `term`: the better of the fits that begin `near` and at the octaves alone.
    /// From zero on a walk may stay there, as a slope far below what it makes on average weighs
    /// much beside white noise, and little beside a walk.
    pub(super) fn fit_without(&self, term: usize, near: &[f64]) -> Option<Solution> {
        let fits = [self.fit_with(term, 0.0, near), self.solve(self.start(Some(term)), Some(term))];
        fits.into_iter().flatten().min_by(|a, b| a.chi2.total_cmp(&b.chi2))
    }

    /// Relative least squares of the octaves with equal weights.
    fn start(&self, without: Option<usize>) -> Vec<f64> {
        let Space { columns, target, least_squares, .. } = &mut *self.space.borrow_mut();
        columns.clear();
        let octaves = || self.used.iter().filter(|i| **i < self.model.octaves);
        for (term, column) in self.model.basis.iter().enumerate() {
            let value = |&i: &usize| if Some(term) == without { 0.0 } else { column[i] / self.values[i] };
            columns.extend(octaves().map(value));
        }
        target.clear();
        target.extend(octaves().map(|_| 1.0));
        if target.is_empty() {
            return vec![0.0; self.model.basis.len()];
        }
        least_squares.solve(columns, target, &[]).to_vec()
    }

    fn solve(&self, parameters: Vec<f64>, held: Option<usize>) -> Option<Solution> {
        let space = &mut *self.space.borrow_mut();
        let mut solution = Solution { parameters, ..Solution::default() };
        for round in 0..=ROUNDS {
            self.evaluate_in(space, &mut solution)?;
            if round == ROUNDS {
                break;
            }
            let Space { target, columns, least_squares, .. } = &mut *space;
            let Solution { parameters, residuals, derivatives, .. } = &mut solution;
            let statistics = residuals.len();
            target.clone_from(residuals);
            let by_term = || derivatives.chunks_exact(statistics).enumerate();
            for ((term, derivative), parameter) in by_term().zip(&*parameters) {
                if Some(term) != held {
                    target.iter_mut().zip(derivative).for_each(|(t, d)| *t += d * parameter);
                }
            }
            columns.clone_from(derivatives);
            if let Some(held) = held {
                columns[held * statistics..][..statistics].fill(0.0);
            }
            let next = least_squares.solve(columns, target, parameters);
            // In standard deviations of the fit
            let step = |(term, derivative): (usize, &[f64])| match Some(term) == held {
                true => 0.0,
                false => (next[term] - parameters[term]).abs() * dot(derivative, derivative).sqrt(),
            };
            let moved = by_term().map(step).fold(0.0, f64::max);
            // Scores hardly depend on the parameters that are not held.
            if moved < if held.is_some() { 0.05 } else { 0.01 } {
                break;
            }
            let value = held.map(|held| parameters[held]);
            parameters.copy_from_slice(next);
            if let Some((held, value)) = held.zip(value) {
                parameters[held] = value;
            }
        }
        Some(solution)
    }

    /// The residuals at `parameters`.
    pub(super) fn evaluate(&self, parameters: Vec<f64>) -> Option<Solution> {
        let mut solution = Solution { parameters, ..Solution::default() };
        self.evaluate_in(&mut self.space.borrow_mut(), &mut solution)?;
        Some(solution)
    }

    /// What belongs to the parameters of `solution`.
    ///
    /// A variance estimate V with ν degrees of freedom is skewed; (V/E)^(1/3) is nearly normal with
    /// mean 1 - 2/(9ν) and variance 2/(9ν) (Wilson and Hilferty, 1931), so that bounds hold at few
    /// degrees of freedom as well.
    fn evaluate_in(&self, space: &mut Space, solution: &mut Solution) -> Option<()> {
        if self.used.is_empty() {
            return None;
        }
        let Space { covariance, expected, inverse, cholesky, rows, .. } = space;
        let Solution { parameters, chi2, residuals, derivatives } = solution;
        expected.clear();
        expected.extend(self.used.iter().map(|&i| self.model.expected(parameters, i)));
        if expected.iter().any(|value| value.is_nan() || *value <= 0.0) {
            return None;
        }
        self.model.covariance(parameters, parameters, covariance);
        inverse.clear();
        inverse.extend(self.used.iter().map(|&i| 1.0 / covariance.variance(i).sqrt()));
        cholesky.factor(self.used.len(), |i, j| {
            let correlation = covariance.row(self.used[i])[self.used[j]] * inverse[i] * inverse[j];
            if i == j { 1.0 + 1e-9 } else { correlation }
        })?;
        // first of all the residuals themselves, as if they were a column of derivatives by σ
        derivatives.clear();
        for ((&i, expected), inverse) in self.used.iter().zip(&*expected).zip(&*inverse) {
            // √(2/(9ν)), with ν = 2 E²/σ²
            let spread = 1.0 / (3.0 * inverse * expected);
            derivatives.push(((self.values[i] / expected).cbrt() - (1.0 - spread * spread)) / spread);
        }
        for column in &self.model.basis {
            derivatives.extend(self.used.iter().zip(&*inverse).map(|(&i, inverse)| column[i] * inverse));
        }
        let statistics = self.used.len();
        rows.clear();
        rows.resize(statistics, [0.0; AT_ONCE]);
        for columns in derivatives.chunks_mut(AT_ONCE * statistics) {
            for (place, column) in columns.chunks_exact(statistics).enumerate() {
                rows.iter_mut().zip(column).for_each(|(row, value)| row[place] = *value);
            }
            cholesky.whiten(rows);
            for (place, column) in columns.chunks_exact_mut(statistics).enumerate() {
                column.iter_mut().zip(&*rows).for_each(|(value, row)| *value = row[place]);
            }
        }
        residuals.clear();
        residuals.extend(derivatives.drain(..statistics));
        *chi2 = dot(residuals, residuals);
        Some(())
    }
}

impl Solution {
    /// How many standard deviations the data lie above the held parameter `term`: its score, the
    /// other positive parameters fitted, over its standard deviation (Rao, 1948).
    pub(super) fn score(&self, term: usize) -> Option<f64> {
        let direction = self.own_direction(term)?;
        Some(dot(&direction, &self.residuals) / dot(&direction, &direction).sqrt())
    }

    /// Residuals and, by parameter, their derivatives: those of the first statistics do not depend
    /// on later ones.
    pub(super) fn rows(&self) -> (&[f64], impl Iterator<Item = &[f64]>) {
        (&self.residuals, self.derivatives.chunks_exact(self.residuals.len()))
    }

    /// With the other positive parameters fitted.
    pub(super) fn standard_deviation(&self, term: usize) -> Option<f64> {
        let direction = self.own_direction(term)?;
        Some(1.0 / dot(&direction, &direction).sqrt())
    }

    /// The derivative by `term`, less what those by the other positive parameters explain.
    fn own_direction(&self, term: usize) -> Option<Vec<f64>> {
        let by_term = || self.derivatives.chunks_exact(self.residuals.len());
        let full = by_term().nth(term)?;
        let mut others: Vec<Vec<f64>> = Vec::new();
        for (other, (derivative, parameter)) in by_term().zip(&self.parameters).enumerate() {
            if other != term && *parameter > 0.0 {
                let rest = orthogonal(derivative.to_vec(), &others);
                others.push(rest);
            }
        }
        let direction = orthogonal(full.to_vec(), &others);
        (dot(&direction, &direction) > 1e-12 * dot(full, full)).then_some(direction)
    }

    pub(super) fn correlation(&self, p: usize, q: usize) -> Option<f64> {
        // The inverse information has the inner products of the dual directions.
        let (a, b) = (self.own_direction(p)?, self.own_direction(q)?);
        Some(dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt())
    }
}

/// `others` are orthogonal to each other.
fn orthogonal(mut vector: Vec<f64>, others: &[Vec<f64>]) -> Vec<f64> {
    for other in others {
        let square = dot(other, other);
        if square > 0.0 {
            let part = dot(&vector, other) / square;
            vector.iter_mut().zip(other).for_each(|(value, o)| *value -= part * o);
        }
    }
    vector
}
