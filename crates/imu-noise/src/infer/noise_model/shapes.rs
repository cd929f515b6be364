//! Shapes that the mean of a record may have beside a ramp: a warm-up, and one cycle.

use core::f64::consts::TAU;

use super::scoring::solved;
use crate::infer::level_series::CosineTransform;

/// Steps from one shape to the next: of the logarithm of the time constant, and of cycles in the
/// record.
const RELAXATIONS_APART: f64 = 1.5;
const CYCLES_APART: f64 = 0.25;

/// Halvings, or nearly, of the range between neighbours in which the likeliest shape is sought.
const REFINEMENTS: usize = 9;

/// By how much the likeliest shape may exceed the likeliest of those examined.
const COARSE: f64 = 2.0;

/// A shape of the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MeanShape {
    /// Relaxes from the start on, with this time constant in blocks.
    Relaxation(f64),
    /// Cycles per block.
    Cycle(f64),
}

/// The shapes that are examined in a level of so many blocks, by their cosine coefficients.
#[derive(Clone, Debug)]
pub(super) struct MeanShapes {
    pub(super) blocks: usize,
    /// A straight line that rises by 1 from block to block.
    pub(super) ramp: Vec<f64>,
    transform: CosineTransform,
    candidates: Vec<(MeanShape, Vec<Vec<f64>>)>,
}

/// A shape, its coefficients, and how far the log-likelihood rises with it.
#[derive(Clone, Debug)]
pub(super) struct FoundShape {
    /// Which one it is.
    #[cfg(test)]
    shape: MeanShape,
    pub(super) coefficients: Vec<Vec<f64>>,
    pub(super) rise: f64,
}

impl MeanShape {
    fn coefficients(self, transform: &CosineTransform, blocks: usize) -> Vec<Vec<f64>> {
        let of = |level: &dyn Fn(f64) -> f64| transform.of(&(0..blocks).map(|i| level(i as f64)).collect::<Vec<_>>());
        match self {
            Self::Relaxation(time) => vec![of(&|i| (-i / time).exp())],
            Self::Cycle(frequency) => {
                let middle = 0.5 * (blocks as f64 - 1.0);
                let angle = |i: f64| TAU * frequency * (i - middle);
                vec![of(&|i| angle(i).cos()), of(&|i| angle(i).sin())]
            }
        }
    }

    /// Between the neighbours that are examined, the place of 0 to 1.
    fn beside(self, place: f64, blocks: usize) -> Self {
        match self {
            Self::Relaxation(time) => Self::Relaxation(time * RELAXATIONS_APART.powf(2.0 * place - 1.0)),
            Self::Cycle(frequency) => Self::Cycle(frequency + (2.0 * place - 1.0) * CYCLES_APART / blocks as f64),
        }
    }

    pub(super) const fn is_cycle(self) -> bool {
        matches!(self, Self::Cycle(_))
    }
}

impl MeanShapes {
    pub(super) fn new(blocks: usize) -> Self {
        let n = blocks as f64;
        let times = core::iter::successors(Some(0.3), |time| Some(time * RELAXATIONS_APART));
        let relaxations = times.take_while(|time| *time < 3.0 * n).map(MeanShape::Relaxation);
        let cycles = (2..).map(|step| f64::from(step) * CYCLES_APART / n).take_while(|frequency| *frequency < 0.48);
        let shapes = relaxations.chain(cycles.map(MeanShape::Cycle));
        let transform = CosineTransform::new(blocks);
        Self {
            blocks,
            ramp: transform.of(&(0..blocks).map(|i| i as f64).collect::<Vec<_>>()),
            candidates: shapes.map(|shape| (shape, shape.coefficients(&transform, blocks))).collect(),
            transform,
        }
    }

    /// The likeliest relaxation or the likeliest cycle in `level`, whose coefficients have these
    /// variances, beside the shapes `known`; nothing if it cannot reach `least_rise`.
    pub(super) fn likeliest(
        &self,
        level: &[f64],
        variances: &[f64],
        known: &[&[f64]],
        is_cycle: bool,
        least_rise: f64,
    ) -> Option<FoundShape> {
        let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / variance).collect();
        let regression = Regression::new(level, &weights, known);
        let meant = self.candidates.iter().filter(|(shape, _)| shape.is_cycle() == is_cycle);
        let rises = meant.map(|(shape, coefficients)| (*shape, regression.rise(coefficients)));
        let (coarse, rise) = rises.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        if COARSE * rise < least_rise {
            return None;
        }
        let found = |place: f64| {
            let shape = coarse.beside(place, self.blocks);
            let coefficients = shape.coefficients(&self.transform, self.blocks);
            let rise = regression.rise(&coefficients);
            FoundShape {
                #[cfg(test)]
                shape,
                coefficients,
                rise,
            }
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

/// Least squares of a level on shapes, some of them known.
struct Regression<'a> {
    level: &'a [f64],
    weights: &'a [f64],
    known: &'a [&'a [f64]],
    /// Log-likelihood by the known ones alone, but for a constant.
    by_known: f64,
}

impl<'a> Regression<'a> {
    fn new(level: &'a [f64], weights: &'a [f64], known: &'a [&'a [f64]]) -> Self {
        let mut regression = Self { level, weights, known, by_known: 0.0 };
        regression.by_known = regression.explained(&[]);
        regression
    }

    fn rise(&self, more: &[Vec<f64>]) -> f64 {
        self.explained(more) - self.by_known
    }

    fn explained(&self, more: &[Vec<f64>]) -> f64 {
        let shapes: Vec<&[f64]> = self.known.iter().copied().chain(more.iter().map(Vec::as_slice)).collect();
        let product = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).zip(self.weights).map(|((a, b), weight)| a * b * weight).sum::<f64>()
        };
        let right: Vec<f64> = shapes.iter().map(|shape| product(shape, self.level)).collect();
        let found = solved(shapes.len(), |i, j| product(shapes[i], shapes[j]), right.clone());
        found.map_or(self.by_known, |found| 0.5 * found.iter().zip(right).map(|(a, b)| a * b).sum::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_and_a_warm_up_are_found_between_those_examined() {
        let blocks = 80;
        let shapes = MeanShapes::new(blocks);
        let variances = vec![1.0; blocks - 1];
        for cycles in [0.9, 3.37, 20.11] {
            let level: Vec<f64> = (0..blocks).map(|i| 9.0 * (TAU * cycles * i as f64 / 80.0 + 1.0).sin()).collect();
            let found = shapes.likeliest(&shapes.transform.of(&level), &variances, &[&shapes.ramp], true, 2.0).unwrap();
            let MeanShape::Cycle(frequency) = found.shape else { panic!("{found:?}") };
            assert!((frequency * 80.0 - cycles).abs() < 0.01 && found.rise > 100.0, "{cycles}: {found:?}");
        }
        let level: Vec<f64> = (0..blocks).map(|i| 9.0 * (-(i as f64) / 7.3).exp()).collect();
        let found = shapes.likeliest(&shapes.transform.of(&level), &variances, &[&shapes.ramp], false, 2.0).unwrap();
        let MeanShape::Relaxation(time) = found.shape else { panic!("{found:?}") };
        assert!((time / 7.3 - 1.0).abs() < 0.02, "{found:?}");
    }
}
