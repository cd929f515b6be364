//! Expected octave variances and their covariance, as functions of the noise parameters.

use super::{
    joint::{Component, JointMeans},
    slope::Slope,
};
use crate::accumulate::record::{Octave, RecordShape};
use crate::infer::power_law::difference_autocovariance;

/// Components whose squared amplitudes are the parameters of the fit, the statistics they explain,
/// and what is needed for the covariance of these.
///
/// The statistics are the variances of the octaves and, where a ramp is among the parameters, as
/// the last of them, the square of the slope of the record. Parameters and statistics are in units
/// of the channel and of one sample interval.
#[derive(Clone, Debug)]
pub(super) struct Model {
    /// By parameter and statistic: expected value for parameter 1.
    pub(super) basis: Vec<Vec<f64>>,
    octaves: usize,
    joint: JointMeans,
    slope: Option<Slope>,
}

impl Model {
    /// Stochastic components alone, for `octaves` in ascending order that have windows.
    pub(super) fn new(octaves: &[Octave], shape: &RecordShape, noise: &[Component<'_>]) -> Self {
        let variance = |component: &Component<'_>, octave: &Octave| {
            let m = octave.m as f64;
            difference_autocovariance(shape.deviation, m, 0.0, component.phase) / (shape.deviation.divisor() * m * m)
        };
        let basis =
            noise.iter().map(|component| octaves.iter().map(|octave| variance(component, octave)).collect()).collect();
        Self { basis, octaves: octaves.len(), joint: JointMeans::new(octaves, shape, noise), slope: None }
    }

    /// Adds the ramp as the last parameter, and the statistic that shows it.
    pub(super) fn with_ramp(mut self, slope: Slope) -> Self {
        for (column, variance) in self.basis.iter_mut().zip(slope.variances()) {
            column.push(*variance);
        }
        self.basis.push(slope.ramp_basis().to_vec());
        self.slope = Some(slope);
        self
    }

    pub(super) fn octaves(&self) -> usize {
        self.octaves
    }

    pub(super) fn statistics(&self) -> usize {
        self.octaves + usize::from(self.slope.is_some())
    }

    /// Expected value of statistic `i`.
    pub(super) fn expected(&self, parameters: &[f64], i: usize) -> f64 {
        self.basis.iter().zip(parameters).map(|(column, parameter)| parameter * column[i]).sum()
    }

    /// Covariances of the statistics, as rows; the lower triangle is filled.
    pub(super) fn covariance(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let mut covariance = self.octave_covariance(parameters);
        if let Some(slope) = &self.slope {
            slope.add_covariance(parameters, parameters, &mut covariance);
        }
        covariance
    }

    /// Equivalent degrees of freedom of each octave: 2 E²/variance. A ramp moves up and down with
    /// the slope of the noise, which is taken from `upper_bounds`.
    pub(super) fn edf(&self, parameters: &[f64], upper_bounds: &[f64]) -> Vec<f64> {
        let mut covariance = self.octave_covariance(parameters);
        if let Some(slope) = &self.slope {
            slope.add_covariance(parameters, upper_bounds, &mut covariance);
        }
        (0..self.octaves).map(|a| 2.0 * self.expected(parameters, a).powi(2) / covariance[a][a]).collect()
    }

    /// By parameter: variance of the slope of the record for parameter 1; nothing without a ramp in
    /// the model.
    pub(super) fn slope_variances(&self) -> &[f64] {
        self.slope.as_ref().map_or(&[], Slope::variances)
    }

    fn octave_covariance(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let size = self.statistics();
        let noise = self.basis.len() - usize::from(self.slope.is_some());
        let present: Vec<usize> = (0..noise).filter(|p| parameters[*p] > 0.0).collect();
        // √V of each component in each octave
        let roots: Vec<Vec<f64>> = present
            .iter()
            .map(|&p| self.basis[p][..self.octaves].iter().map(|value| (value * parameters[p]).sqrt()).collect())
            .collect();
        let mut covariance = vec![vec![0.0; size]; size];
        for a in 0..self.octaves {
            for b in 0..=a {
                let pairs = present.iter().zip(&roots).map(|(&p, root_p)| {
                    let row = present.iter().zip(&roots);
                    let sum: f64 = row.map(|(&q, root_q)| root_q[a] * root_q[b] * self.joint.mean(a, b, p, q)).sum();
                    root_p[a] * root_p[b] * sum
                });
                covariance[a][b] = 2.0 * pairs.sum::<f64>();
            }
        }
        covariance
    }
}
