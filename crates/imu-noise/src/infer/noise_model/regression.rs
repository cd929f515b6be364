//! Generalised least squares with a covariance that depends on the parameters, and score tests.

use core::ops::Range;

use super::{
    least_squares::{Cholesky, dot, non_negative},
    model::Model,
};

/// At most. Weights follow the fitted model: those from the data favour what is too low.
const ROUNDS: usize = 12;

pub(super) struct Regression<'a> {
    model: &'a Model,
    values: &'a [f64],
    used: Vec<usize>,
}

#[derive(Clone)]
pub(super) struct Solution {
    pub(super) parameters: Vec<f64>,
    pub(super) chi2: f64,
    /// Independent and with variance 1.
    residuals: Vec<f64>,
    derivatives: Vec<Vec<f64>>,
}

impl<'a> Regression<'a> {
    /// `values`: the statistics of `model`; `octaves` have a part in the fit, and the slope if
    /// there is one.
    pub(super) fn new(model: &'a Model, values: &'a [f64], octaves: Range<usize>) -> Self {
        Self { model, values, used: octaves.chain(model.octaves..model.statistics()).collect() }
    }

    pub(super) fn statistics(&self) -> usize {
        self.used.len()
    }

    /// `None` where the model cannot be evaluated, as for data that never change.
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
        let columns: Vec<Vec<f64>> = self
            .model
            .basis
            .iter()
            .enumerate()
            .map(|(term, column)| {
                let value = |&i: &usize| if Some(term) == without { 0.0 } else { column[i] / self.values[i] };
                self.used.iter().filter(|i| **i < self.model.octaves).map(value).collect()
            })
            .collect();
        let ones = vec![1.0; columns.first().map_or(0, Vec::len)];
        non_negative(&columns, &ones, &[])
    }

    fn solve(&self, mut parameters: Vec<f64>, held: Option<usize>) -> Option<Solution> {
        for round in 0.. {
            let mut solution = self.evaluate(parameters)?;
            if round == ROUNDS {
                return Some(solution);
            }
            let mut target = solution.residuals.clone();
            for (term, (derivative, parameter)) in solution.derivatives.iter().zip(&solution.parameters).enumerate() {
                if Some(term) != held {
                    target.iter_mut().zip(derivative).for_each(|(t, d)| *t += d * parameter);
                }
            }
            let mut columns = solution.derivatives.clone();
            if let Some(held) = held {
                columns[held].fill(0.0);
            }
            let mut next = non_negative(&columns, &target, &solution.parameters);
            if let Some(held) = held {
                next[held] = solution.parameters[held];
            }
            // In standard deviations of the fit
            let moved: f64 = (0..next.len())
                .map(|term| {
                    let step = (next[term] - solution.parameters[term]).abs();
                    step * dot(&solution.derivatives[term], &solution.derivatives[term]).sqrt()
                })
                .fold(0.0, f64::max);
            // Scores hardly depend on the parameters that are not held.
            if moved < if held.is_some() { 0.05 } else { 0.01 } {
                solution.chi2 = dot(&solution.residuals, &solution.residuals);
                return Some(solution);
            }
            parameters = next;
        }
        None
    }

    /// Residuals at `parameters`.
    ///
    /// A variance estimate V with ν degrees of freedom is skewed; (V/E)^(1/3) is nearly normal with
    /// mean 1 - 2/(9ν) and variance 2/(9ν) (Wilson and Hilferty, 1931), so that bounds hold at few
    /// degrees of freedom as well.
    pub(super) fn evaluate(&self, parameters: Vec<f64>) -> Option<Solution> {
        let covariance = self.model.covariance(&parameters);
        let expected: Vec<f64> = self.used.iter().map(|&i| self.model.expected(&parameters, i)).collect();
        if expected.iter().any(|value| value.is_nan() || *value <= 0.0) {
            return None;
        }
        let sigma: Vec<f64> = self.used.iter().map(|&i| covariance.variance(i).sqrt()).collect();
        let cholesky = Cholesky::new(self.used.len(), |i, j| {
            let correlation = covariance.between(self.used[i], self.used[j]) / (sigma[i] * sigma[j]);
            if i == j { 1.0 + 1e-9 } else { correlation }
        })?;
        // 2/(9ν), with ν = 2 E²/σ²
        let spread: Vec<f64> = expected.iter().zip(&sigma).map(|(e, s)| (s / e).powi(2) / 9.0).collect();
        let mut residuals: Vec<f64> = (0..self.used.len())
            .map(|i| ((self.values[self.used[i]] / expected[i]).cbrt() - (1.0 - spread[i])) / spread[i].sqrt())
            .collect();
        cholesky.whiten(&mut residuals);
        let derivatives = self.model.basis.iter().map(|column| {
            let mut derivative: Vec<f64> = self.used.iter().zip(&sigma).map(|(&i, sigma)| column[i] / sigma).collect();
            cholesky.whiten(&mut derivative);
            derivative
        });
        let derivatives = derivatives.collect();
        let chi2 = dot(&residuals, &residuals);
        Some(Solution { parameters, chi2, residuals, derivatives })
    }
}

impl Solution {
    /// How many standard deviations the data lie above the held parameter `term`: its score, the
    /// other positive parameters fitted, over its standard deviation (Rao, 1948).
    pub(super) fn score(&self, term: usize) -> Option<f64> {
        let direction = self.own_direction(term)?;
        Some(dot(&direction, &self.residuals) / dot(&direction, &direction).sqrt())
    }

    /// With the other positive parameters fitted.
    pub(super) fn standard_deviation(&self, term: usize) -> Option<f64> {
        let direction = self.own_direction(term)?;
        Some(1.0 / dot(&direction, &direction).sqrt())
    }

    /// The derivative by `term`, less what those by the other positive parameters explain.
    fn own_direction(&self, term: usize) -> Option<Vec<f64>> {
        let full = &self.derivatives[term];
        let mut others: Vec<Vec<f64>> = Vec::new();
        for (other, derivative) in self.derivatives.iter().enumerate() {
            if other != term && self.parameters[other] > 0.0 {
                let rest = orthogonal(derivative.clone(), &others);
                others.push(rest);
            }
        }
        let direction = orthogonal(full.clone(), &others);
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
