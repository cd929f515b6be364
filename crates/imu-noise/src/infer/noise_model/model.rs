//! Expected octave variances and their covariance, as functions of the noise parameters; and the
//! slope of the regression line over the record as one more statistic.

use std::{array, sync::Arc};

use super::{
    covariance::Covariance,
    joint::{Component, JointMeans, MOST_COMPONENTS},
    slope::Slope,
};
use crate::accumulate::record::{Octave, RecordShape};
use crate::infer::least_squares::dot;
use crate::infer::power_law::expected_variance;

/// Components whose squared amplitudes are the parameters of the fit, and the statistics they
/// explain: the variances of the octaves and, with a ramp, as the last of them, the square of the
/// slope of the record. Both are in units of the channel and of one sample interval.
#[derive(Clone, Debug)]
pub(super) struct Model {
    /// By parameter and statistic: expected value for parameter 1. The terms of noise come first,
    /// then the ramp if there is one, then what one channel shows beside them.
    pub(super) basis: Vec<Vec<f64>>,
    pub(super) octaves: usize,
    /// Terms of noise, a random walk the last.
    noise: usize,
    /// Place of white noise, the first but for quantisation.
    white: usize,
    /// Averaging factor of each octave.
    factors: Vec<f64>,
    joint: Arc<JointMeans>,
    slope: Option<Arc<Slope>>,
    beside: Vec<Beside>,
    /// Fourth cumulant of the white noise over the samples.
    tails: f64,
}

/// What one channel shows beside the terms, with a squared amplitude as its parameter.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    /// By octave: expected value for parameter 1.
    pub(super) variances: Vec<f64>,
    pub(super) kind: BesideKind,
}

/// How it varies from record to record.
#[derive(Clone, Debug)]
pub(super) enum BesideKind {
    /// A sine: known but for the noise at its own frequency, whose density over the samples this
    /// is, and the standard deviation of each octave from what is not known of the frequency. A
    /// slow one has the square of its slope over the record, for parameter 1.
    Line { noise: f64, spread: Vec<f64>, slope: f64 },
    /// A Gauss-Markov process with this correlation time in samples: longer averages of it vary as
    /// those of white noise, shorter ones as those of a random walk.
    GaussMarkov { time: f64 },
    /// What a filter changes at the edges of every block: part of the white noise.
    Edges,
}

impl Model {
    /// For `octaves` in ascending order that have windows.
    /// `known`: a model of the same noise in a record of another length.
    pub(super) fn new(octaves: &[Octave], shape: &RecordShape, noise: &[Component<'_>], known: Option<&Self>) -> Self {
        let variances = |component: &Component<'_>| {
            octaves.iter().map(|octave| expected_variance(octave, shape.deviation, component.phase)).collect()
        };
        let basis = noise.iter().map(variances).collect();
        let factors = octaves.iter().map(|octave| octave.m as f64).collect();
        let white = noise.iter().position(|component| !component.meets_at_edges).unwrap_or_default();
        let joint = Arc::new(JointMeans::new(octaves, shape, noise, known.map(|known| &*known.joint)));
        Self {
            basis,
            octaves: octaves.len(),
            noise: noise.len(),
            white,
            factors,
            joint,
            slope: None,
            beside: Vec::new(),
            tails: 0.0,
        }
    }

    /// The ramp is the last parameter.
    pub(super) fn with_ramp(mut self, slope: Slope) -> Self {
        for (column, variance) in self.basis.iter_mut().zip(&slope.variances) {
            column.push(*variance);
        }
        self.basis.push(slope.ramp_basis.clone());
        self.slope = Some(Arc::new(slope));
        self
    }

    /// What a channel shows beside the terms are the last parameters.
    pub(super) fn beside(&self, beside: Vec<Beside>) -> Self {
        let mut model = self.clone();
        for beside in &beside {
            let of_slope = self.slope.as_ref().map(|slope| match beside.kind {
                BesideKind::GaussMarkov { time } => slope.gauss_markov_variance(time),
                BesideKind::Line { slope, .. } => slope,
                BesideKind::Edges => 0.0,
            });
            model.basis.push(beside.variances.iter().copied().chain(of_slope).collect());
        }
        model.beside.extend(beside);
        model
    }

    /// With white noise whose fourth cumulant, over the samples, is `tails`: each sample squared is
    /// in every octave with the weight 1/m, so that it adds `tails`/(m m') to the covariance.
    pub(super) fn with_tails(mut self, tails: f64) -> Self {
        self.tails = tails;
        self
    }

    /// Correlation times in samples of what is beside the terms, if that is a Gauss-Markov
    /// process.
    pub(super) fn gauss_markov_times(&self) -> impl Iterator<Item = Option<f64>> {
        self.beside.iter().map(|beside| match beside.kind {
            BesideKind::GaussMarkov { time } => Some(time),
            BesideKind::Line { .. } | BesideKind::Edges => None,
        })
    }

    /// For white noise behind a filter that forgets within less than `shortest` samples, the first
    /// averaging factor in use: N²/m - c/m², with any c up to N² · `shortest`.
    pub(super) fn filtered(&self, shortest: f64) -> Self {
        let edges: Vec<f64> = self.factors.iter().map(|m| 1.0 / (m * m)).collect();
        let mut model = self.beside(vec![Beside { variances: edges.clone(), kind: BesideKind::Edges }]);
        for ((value, edge), m) in model.basis[self.white].iter_mut().zip(edges).zip(&self.factors) {
            *value = 1.0 / m - shortest * edge;
        }
        model
    }

    /// Expected value of each octave for white noise of parameter 1, without a filter.
    pub(super) fn white(&self) -> &[f64] {
        &self.basis[self.white][..self.octaves]
    }

    /// Of the terms and the ramp, not of what is beside them.
    pub(super) fn terms(&self) -> usize {
        self.noise + usize::from(self.slope.is_some())
    }

    pub(super) fn statistics(&self) -> usize {
        self.octaves + usize::from(self.slope.is_some())
    }

    pub(super) fn expected(&self, parameters: &[f64], i: usize) -> f64 {
        self.basis.iter().zip(parameters).map(|(column, parameter)| parameter * column[i]).sum()
    }

    /// 2 E²/variance. A ramp moves with the slope of the noise, which is taken from `upper_bounds`.
    /// A slow cycle may as well be part of a walk: what it adds varies with the degrees of freedom
    /// `of_walk` of one.
    pub(super) fn edf(&self, parameters: &[f64], upper_bounds: &[f64], of_walk: &[f64]) -> Vec<f64> {
        let mut covariance = Covariance::default();
        self.covariance(parameters, upper_bounds, &mut covariance);
        let of_cycles = |a: usize| -> f64 {
            let of = |(beside, parameter): (&Beside, &f64)| match beside.kind {
                BesideKind::Line { slope, .. } if slope > 0.0 => parameter * beside.variances[a],
                _ => 0.0,
            };
            self.beside.iter().zip(&parameters[self.terms()..]).map(of).sum()
        };
        let spread = |a: usize| covariance.variance(a).sqrt() + of_cycles(a) * (2.0 / of_walk[a]).sqrt();
        (0..self.octaves).map(|a| 2.0 * (self.expected(parameters, a) / spread(a)).powi(2)).collect()
    }

    /// Of the slope of the record, by parameter for parameter 1; nothing without a ramp in the
    /// model.
    pub(super) fn slope_variances(&self) -> Vec<f64> {
        let Some(slope) = &self.slope else { return Vec::new() };
        let mut variances: Vec<f64> = self.basis.iter().map(|column| column[self.octaves]).collect();
        // The ramp is no noise.
        variances[self.noise] = 0.0;
        debug_assert_eq!(variances[..self.noise], slope.variances);
        variances
    }

    /// The parameters of the terms, with the white noise or walk that other noise is to the slope.
    fn of_slope(&self, slope: &Slope, parameters: &[f64]) -> [f64; MOST_COMPONENTS] {
        let mut noise = [0.0; MOST_COMPONENTS];
        noise[..self.noise].copy_from_slice(&parameters[..self.noise]);
        for (beside, parameter) in self.beside.iter().zip(&parameters[self.terms()..]) {
            if let BesideKind::GaussMarkov { time } = beside.kind {
                noise[self.white] += parameter * slope.gauss_markov_variance(time) / slope.variances[self.white];
            }
        }
        noise
    }

    /// Into `covariance`, that of the statistics at `parameters`. The noise that moves the slope is
    /// that of `of_slope`.
    pub(super) fn covariance(&self, parameters: &[f64], of_slope: &[f64], covariance: &mut Covariance) {
        covariance.resize(self.statistics());
        match self.noise {
            1 => self.add_noise::<1>(parameters, covariance),
            2 => self.add_noise::<2>(parameters, covariance),
            3 => self.add_noise::<3>(parameters, covariance),
            _ => self.add_noise::<MOST_COMPONENTS>(parameters, covariance),
        }
        for (beside, &parameter) in self.beside.iter().zip(&parameters[self.terms()..]) {
            let BesideKind::Line { noise, spread, .. } = &beside.kind else { continue };
            // The power P of a line in noise of density S has the variance 4 P S/n.
            let factor = 4.0 * parameter * noise;
            for (a, (value, spread)) in beside.variances.iter().zip(spread).enumerate() {
                let row = covariance.row_mut(a);
                row.iter_mut().zip(&beside.variances[..=a]).for_each(|(row, other)| *row += factor * value * other);
                row[a] += (parameter * spread).powi(2);
            }
        }
        if let Some(slope) = &self.slope {
            let noise = self.of_slope(slope, of_slope);
            let noise = &noise[..self.noise];
            slope.add_covariance(parameters[self.noise], noise, covariance);
            // like a ramp of the same slope
            let squares =
                self.beside.iter().zip(&parameters[self.terms()..]).map(|(beside, parameter)| match beside.kind {
                    BesideKind::Line { slope, .. } => slope * parameter,
                    BesideKind::GaussMarkov { .. } | BesideKind::Edges => 0.0,
                });
            let by_lines = 4.0 * squares.sum::<f64>() * dot(&slope.variances, noise);
            covariance.row_mut(self.octaves)[self.octaves] += by_lines;
        }
    }

    /// Of the octaves, in the noise of all `N` terms and what is like them.
    fn add_noise<const N: usize>(&self, parameters: &[f64], covariance: &mut Covariance) {
        // by octave and term: root of what it adds to the variance there
        let (roots, mut rows) = covariance.octaves(self.octaves);
        for (p, (column, parameter)) in self.basis[..N].iter().zip(parameters).enumerate() {
            roots.iter_mut().zip(column).for_each(|(roots, value)| roots[p] = value * parameter);
        }
        for (beside, parameter) in self.beside.iter().zip(&parameters[self.terms()..]) {
            for (a, value) in beside.variances.iter().enumerate() {
                let like = match beside.kind {
                    BesideKind::GaussMarkov { time } => self.like_gauss_markov(a, time),
                    BesideKind::Edges => self.white,
                    BesideKind::Line { .. } => continue,
                };
                roots[a][like] += value * parameter;
            }
        }
        roots.iter_mut().flatten().for_each(|variance| *variance = variance.max(0.0).sqrt());
        for (a, roots_a) in roots.iter().enumerate() {
            let means = self.joint.up_to::<N>(a);
            let (row, behind) = rows.split_at_mut(a + 1);
            rows = behind;
            let tails = self.tails / self.factors[a];
            for (b, ((row, roots_b), factor)) in row.iter_mut().zip(&*roots).zip(&self.factors).enumerate() {
                let products: [f64; N] = array::from_fn(|p| roots_a[p] * roots_b[p]);
                // the matrix of the means is symmetric
                let mut sum = 0.0;
                for (p, (means, product)) in means.iter().zip(&products).enumerate() {
                    let others: f64 = (0..p).map(|q| means[q][b] * products[q]).sum();
                    sum += product * (means[p][b] * product + 2.0 * others);
                }
                *row = 2.0 * sum + tails / factor;
            }
        }
    }

    /// The term of noise that octave `a` of a Gauss-Markov process is most like.
    fn like_gauss_markov(&self, a: usize, time: f64) -> usize {
        if self.factors[a] < time { self.noise - 1 } else { self.white }
    }
}
