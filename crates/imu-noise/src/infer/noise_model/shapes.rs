//! Shapes that the mean of a record may have beside a ramp: a warm-up, a cycle, a step.

use core::f64::consts::TAU;
use std::sync::OnceLock;

use super::cholesky::Cholesky;
use crate::accumulate::counts::{dot, lane_sum};
use crate::infer::level_series::CosineTransform;

/// Steps from one shape to the next: of the logarithm of the time constant, of cycles in the
/// record, and of blocks.
const RELAXATIONS_APART: f64 = 1.5;
const CYCLES_APART: f64 = 0.25;
const STEPS_APART: f64 = 0.5;

/// Blocks at either end in which a step is not sought: a few blocks do not make a level.
const STEP_MARGIN: f64 = 4.0;

/// Halvings, or nearly, of the range between neighbours in which the likeliest shape is sought.
const REFINEMENTS: usize = 9;

/// By how much the likeliest shape may exceed the likeliest of those examined.
const COARSE: f64 = 2.0;

/// Of the square of a shape: with less beside known shapes it is one of them.
const ALIKE: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::infer) enum MeanShape {
    /// Relaxes from the start on, with this time constant in blocks.
    Relaxation(f64),
    /// Cycles per block.
    Cycle(f64),
    /// 0 before this time in blocks, 1 from it on.
    Step(f64),
}

/// The shapes that are examined in a level of so many blocks, by their cosine coefficients.
#[derive(Clone, Debug)]
pub(in crate::infer) struct MeanShapes {
    pub(in crate::infer) blocks: usize,
    /// A straight line that rises by 1 from block to block.
    pub(in crate::infer) ramp: Vec<f64>,
    pub(in crate::infer) transform: CosineTransform,
    has_steps: bool,
    candidates: OnceLock<Vec<FoundShape>>,
}

/// A shape, its coefficients, and how far the log-likelihood rises with it.
#[derive(Clone, Debug)]
pub(in crate::infer) struct FoundShape {
    pub(in crate::infer) shape: MeanShape,
    pub(in crate::infer) coefficients: Vec<Vec<f64>>,
    pub(in crate::infer) rise: f64,
}

impl MeanShape {
    /// Between the neighbours that are examined, the place of 0 to 1.
    fn beside(self, place: f64, blocks: usize) -> Self {
        let off = 2.0 * place - 1.0;
        match self {
            Self::Relaxation(time) => Self::Relaxation(time * RELAXATIONS_APART.powf(off)),
            Self::Cycle(frequency) => Self::Cycle(frequency + off * CYCLES_APART / blocks as f64),
            Self::Step(at) => Self::Step(at + off * STEPS_APART),
        }
    }
}

impl MeanShapes {
    /// Warm-ups and cycles, and steps if it `has_steps`.
    pub(in crate::infer) fn new(blocks: usize, has_steps: bool) -> Self {
        let transform = CosineTransform::new(blocks);
        let mut shapes = Self { blocks, ramp: Vec::new(), transform, has_steps, candidates: OnceLock::new() };
        shapes.ramp = shapes.coefficients_of(|i| i);
        shapes
    }

    fn candidates(&self) -> &[FoundShape] {
        let n = self.blocks as f64;
        let times = core::iter::successors(Some(0.3), |time| Some(time * RELAXATIONS_APART));
        let relaxations = times.take_while(|time| *time < 3.0 * n).map(MeanShape::Relaxation);
        let cycles = (2..).map(|step| f64::from(step) * CYCLES_APART / n).take_while(|frequency| *frequency < 0.48);
        let last = if self.has_steps { n - STEP_MARGIN } else { 0.0 };
        let places = core::iter::successors(Some(STEP_MARGIN), |at| Some(at + STEPS_APART));
        let steps = places.take_while(|at| *at <= last).map(MeanShape::Step);
        let of = |shape| FoundShape { shape, coefficients: self.coefficients(shape), rise: 0.0 };
        let all = relaxations.chain(cycles.map(MeanShape::Cycle)).chain(steps);
        self.candidates.get_or_init(|| all.map(of).collect())
    }

    /// One vector, or those of the cosine and the sine of a cycle.
    pub(in crate::infer) fn coefficients(&self, shape: MeanShape) -> Vec<Vec<f64>> {
        match shape {
            // the mean over a block
            MeanShape::Relaxation(time) => {
                vec![self.coefficients_of(|i| (-i / time).exp() * time * -(-1.0 / time).exp_m1())]
            }
            MeanShape::Step(at) => vec![self.coefficients_of(|i| (i + 1.0 - at).clamp(0.0, 1.0))],
            MeanShape::Cycle(frequency) => {
                let middle = 0.5 * (self.blocks as f64 - 1.0);
                let angle = |i: f64| TAU * frequency * (i - middle);
                vec![self.coefficients_of(|i| angle(i).cos()), self.coefficients_of(|i| angle(i).sin())]
            }
        }
    }

    /// Of a level by block.
    fn coefficients_of(&self, level: impl Fn(f64) -> f64) -> Vec<f64> {
        self.transform.of(&(0..self.blocks).map(|i| level(i as f64)).collect::<Vec<_>>())
    }

    /// The likeliest of the shapes that are meant in `level`, whose coefficients have these variances,
    /// beside the shapes `known`; nothing if it cannot reach `least_rise`.
    pub(in crate::infer) fn likeliest(
        &self,
        level: &[f64],
        variances: &[f64],
        known: &[&[f64]],
        is_meant: impl Fn(MeanShape) -> bool,
        least_rise: f64,
    ) -> Option<FoundShape> {
        let regression = Regression::new(level, variances, known);
        let meant = self.candidates().iter().filter(|candidate| is_meant(candidate.shape));
        let rises = meant.map(|candidate| (candidate.shape, regression.rise(&candidate.coefficients)));
        let (coarse, rise) = rises.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        if COARSE * rise < least_rise {
            return None;
        }
        let found = |place: f64| {
            let shape = coarse.beside(place, self.blocks);
            let coefficients = self.coefficients(shape);
            let rise = regression.rise(&coefficients);
            FoundShape { shape, coefficients, rise }
        };
        // golden section
        let part = (5_f64.sqrt() - 1.0) / 2.0;
        let (mut low, mut high) = (0.0, 1.0);
        let (mut left, mut right) = (found(1.0 - part), found(part));
        for _ in 0..REFINEMENTS {
            if left.rise > right.rise {
                high = low + part * (high - low);
                right = left;
                left = found(high - part * (high - low));
            } else {
                low = high - part * (high - low);
                left = right;
                right = found(low + part * (high - low));
            }
        }
        Some(if left.rise > right.rise { left } else { right })
    }
}

/// Least squares of a level on a shape beside known ones.
struct Regression {
    weights: Vec<f64>,
    /// What the known shapes leave of the level, weighted.
    rest: Vec<f64>,
    /// The known shapes, weighted, after those before them and of length 1.
    known: Vec<Vec<f64>>,
}

impl Regression {
    fn new(level: &[f64], variances: &[f64], shapes: &[&[f64]]) -> Self {
        let weights = variances.iter().map(|variance| 1.0 / variance).collect();
        let mut regression = Self { weights, rest: Vec::new(), known: Vec::new() };
        for shape in shapes {
            let left = regression.rest_of(shape);
            let square = dot(&left, shape);
            if square > ALIKE * regression.square(shape, shape) {
                regression.known.push(left.iter().map(|value| value / square.sqrt()).collect());
            }
        }
        regression.rest = regression.rest_of(level);
        regression
    }

    /// Weighted, without the known shapes.
    fn rest_of(&self, values: &[f64]) -> Vec<f64> {
        let mut rest: Vec<f64> = values.iter().zip(&self.weights).map(|(value, weight)| value * weight).collect();
        for known in &self.known {
            let product = dot(known, values);
            rest.iter_mut().zip(known).for_each(|(rest, known)| *rest -= product * known);
        }
        rest
    }

    fn square(&self, a: &[f64], b: &[f64]) -> f64 {
        lane_sum([a, b, &self.weights], |[a, b, weight]| a * b * weight)
    }

    /// By how much the log-likelihood rises with a shape.
    fn rise(&self, shape: &[Vec<f64>]) -> f64 {
        let of_known = |x: &Vec<f64>| self.known.iter().map(|known| dot(x, known)).collect();
        let of_known: Vec<Vec<f64>> = shape.iter().map(of_known).collect();
        let entry = |i: usize, j: usize| {
            let whole = self.square(&shape[i], &shape[j]);
            let rest = whole - dot(&of_known[i], &of_known[j]);
            if i == j && rest < ALIKE * whole { 0.0 } else { rest }
        };
        let right: Vec<f64> = shape.iter().map(|x| dot(x, &self.rest)).collect();
        let found = Cholesky::new(shape.len(), entry).map(|factor| factor.solve(right.clone()));
        found.map_or(0.0, |found| 0.5 * dot(&found, &right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_found_between_those_examined() {
        let blocks = 80;
        let shapes = MeanShapes::new(blocks, true);
        let variances = vec![1.0; blocks - 1];
        let find = |level: &dyn Fn(f64) -> f64| {
            let level = shapes.coefficients_of(|i| 9.0 * level(i));
            shapes.likeliest(&level, &variances, &[&shapes.ramp], |_| true, 2.0).unwrap()
        };
        for cycles in [0.9, 3.37, 20.11] {
            let found = find(&|i| (TAU * cycles * i / 80.0 + 1.0).sin());
            let MeanShape::Cycle(frequency) = found.shape else { panic!("{found:?}") };
            assert!((frequency * 80.0 - cycles).abs() < 0.01 && found.rise > 100.0, "{cycles}: {found:?}");
        }
        let found = find(&|i| (-i / 7.3).exp());
        let MeanShape::Relaxation(time) = found.shape else { panic!("{found:?}") };
        assert!((time / 7.3 - 1.0).abs() < 0.02, "{found:?}");
        let found = find(&|i| (i + 1.0 - 33.3).clamp(0.0, 1.0));
        let MeanShape::Step(at) = found.shape else { panic!("{found:?}") };
        assert!((at - 33.3).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn a_known_shape_explains_nothing_further() {
        let shapes = MeanShapes::new(40, false);
        let level: Vec<f64> = shapes.ramp.iter().enumerate().map(|(k, ramp)| ramp + (k % 3) as f64).collect();
        let regression = Regression::new(&level, &[0.5; 39], &[&shapes.ramp, &shapes.ramp]);
        assert!(regression.rise(core::slice::from_ref(&shapes.ramp)) == 0.0);
        assert!(regression.rest.iter().zip(&shapes.ramp).map(|(rest, ramp)| rest * ramp).sum::<f64>().abs() < 1e-9);
    }
}
