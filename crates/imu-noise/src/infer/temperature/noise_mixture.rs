//! White noise, flicker noise and a random walk in many proportions, and a regression for each.
//!
//! The spectra are those of `level_noise`, which takes the likeliest proportion to find a change of
//! the level. Here all proportions count, each by its weight: the interval of a coefficient must
//! contain what is not known of the noise.

use core::f64::consts::PI;
use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use crate::infer::{
    chi_squared::normal_above,
    level_noise::{flicker_variance, walk_variance},
    level_shapes::dot,
};

/// From one cosine coefficient to the next at which flicker noise or a random walk crosses the
/// white noise.
const CROSSINGS_APART: f64 = 2.5;

/// A walk that crosses at a higher coefficient weighs more, by this power of it: chosen for the
/// coverage where a walk is there but looks much like flicker noise (the benchmark `cells`).
const WALK_WEIGHT: f64 = 1.5;

/// Share of the temperature in coefficients that are not used.
const NOT_REACHED: f64 = 1e-3;

/// Regressions with less of the weight of the likeliest one are excluded.
const NEGLIGIBLE: f64 = 1e-4;

/// Halvings of the range in which a quantile lies: to a thousandth of the standard deviation.
const HALVINGS: usize = 14;

#[derive(Clone)]
pub(super) struct NoiseMixture {
    blocks: usize,
    noises: Arc<[MixtureComponent]>,
    transform: Arc<dyn RealToComplex<f64>>,
}

struct MixtureComponent {
    log_prior: f64,
    /// By coefficient, from the first on: 1 over the variance.
    weights: Vec<f64>,
    /// Sum of the logarithms of the variances.
    log_determinant: f64,
}

/// The temperature behind one lag.
#[derive(Clone, Debug)]
pub(super) struct Regressor {
    pub(super) lag_s: f64,
    coefficients: Vec<f64>,
    /// By noise: the weighted squares.
    squares: Vec<f64>,
}

/// One axis.
pub(super) struct WeightedAxis<'a> {
    mixture: &'a NoiseMixture,
    /// By noise, of those that matter: its place, the coefficients times its weights, and their
    /// weighted squares.
    weighted: Vec<(usize, Vec<f64>, f64)>,
    /// The likeliest noise without any influence of the temperature.
    likeliest: usize,
}

/// The regression with one noise and one lag.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    lag_s: f64,
    log_weight: f64,
    value: f64,
    error: f64,
    dof: f64,
}

impl core::fmt::Debug for NoiseMixture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("NoiseMixture").field("blocks", &self.blocks).finish_non_exhaustive()
    }
}

impl NoiseMixture {
    /// For series of so many blocks, two or more.
    pub(super) fn new(blocks: usize) -> Self {
        let of = |variance: fn(usize, usize) -> f64| -> Vec<f64> { (1..blocks).map(|k| variance(k, blocks)).collect() };
        let (flicker, walk) = (of(flicker_variance), of(walk_variance));
        let crossings = core::iter::successors(Some(1.0), |at| Some(at * CROSSINGS_APART));
        let crossings: Vec<f64> = crossings.take_while(|at: &f64| at.round() < blocks as f64).collect();
        let at = |variances: &[f64], crossing: f64| variances[crossing.round() as usize - 1];
        let noise = |white: f64, of_flicker: f64, of_walk: f64, crossing: f64| {
            let each = flicker.iter().zip(&walk);
            let variances: Vec<f64> =
                each.map(|(flicker, walk)| white + of_flicker * flicker + of_walk * walk).collect();
            MixtureComponent {
                log_prior: WALK_WEIGHT * crossing.ln(),
                log_determinant: variances.iter().map(|variance| variance.ln()).sum(),
                weights: variances.iter().map(|variance| 1.0 / variance).collect(),
            }
        };
        let mut noises =
            vec![noise(1.0, 0.0, 0.0, 1.0), noise(0.0, 1.0, 0.0, 1.0), noise(0.0, 0.0, 1.0, blocks as f64)];
        for &f in &crossings {
            let (of_flicker, of_walk) = (1.0 / at(&flicker, f), 1.0 / at(&walk, f));
            noises.push(noise(1.0, of_flicker, 0.0, 1.0));
            noises.push(noise(1.0, 0.0, of_walk, f));
            noises.push(noise(0.0, of_flicker, of_walk, f.sqrt()));
            noises.extend(crossings.iter().map(|&w| noise(1.0, of_flicker, 1.0 / at(&walk, w), w)));
        }
        let transform = RealFftPlanner::new().plan_fft_forward(2 * blocks);
        Self { blocks, noises: noises.into(), transform }
    }

    /// How many coefficients of the temperature matter: the others hold less than a thousandth of
    /// it, by their size squared times their frequency. A regression without them is not biased.
    pub(super) fn reach(&self, temperatures: &[f64]) -> usize {
        let weigh = |(place, value): (usize, f64)| value * value * (place + 1) as f64;
        let weighed: Vec<f64> = self.cosine_coefficients(temperatures).into_iter().enumerate().map(weigh).collect();
        let mut rest = weighed.iter().sum::<f64>();
        let least = NOT_REACHED * rest;
        let reached = weighed.iter().position(|weight| {
            rest -= weight;
            rest <= least
        });
        reached.map_or(weighed.len(), |last| last + 1)
    }

    /// With the first `reach` coefficients.
    pub(super) fn regressor(&self, values: &[f64], lag_s: f64, reach: usize) -> Regressor {
        let mut coefficients = self.cosine_coefficients(values);
        coefficients.truncate(reach);
        let squared: Vec<f64> = coefficients.iter().map(|value| value * value).collect();
        let squares = self.noises.iter().map(|noise| dot(&noise.weights[..squared.len()], &squared)).collect();
        Regressor { lag_s, coefficients, squares }
    }

    /// `None` if the values do not vary.
    pub(super) fn axis(&self, values: &[f64]) -> Option<WeightedAxis<'_>> {
        let coefficients = self.cosine_coefficients(values);
        let dof = coefficients.len() as f64;
        let weighted = self.noises.iter().enumerate().map(|(place, noise)| {
            let weighted: Vec<f64> =
                coefficients.iter().zip(&noise.weights).map(|(value, weight)| value * weight).collect();
            let squares = dot(&weighted, &coefficients);
            (place, weighted, squares)
        });
        let weighted: Vec<_> = weighted.collect();
        let log_likelihood = |(place, _, squares): &(usize, Vec<f64>, f64)| {
            -0.5 * (self.noises[*place].log_determinant + dof * squares.ln())
        };
        let likeliest = weighted.iter().max_by(|a, b| log_likelihood(a).total_cmp(&log_likelihood(b)))?.0;
        weighted.iter().all(|(.., squares)| *squares > 0.0).then_some(WeightedAxis {
            mixture: self,
            weighted,
            likeliest,
        })
    }

    /// From the first on, without that of the level.
    fn cosine_coefficients(&self, values: &[f64]) -> Vec<f64> {
        let blocks = self.blocks;
        let mut mirrored: Vec<f64> = values.iter().chain(values.iter().rev()).copied().collect();
        let mut spectrum = self.transform.make_output_vec();
        if self.transform.process(&mut mirrored, &mut spectrum).is_err() {
            return vec![0.0; blocks - 1];
        }
        let scale = (0.5 / blocks as f64).sqrt();
        let coefficient = |k: usize| {
            let turn = Complex::from_polar(scale, -PI * k as f64 / (2 * blocks) as f64);
            (spectrum[k] * turn).re
        };
        (1..blocks).map(coefficient).collect()
    }
}

impl WeightedAxis<'_> {
    /// Of every noise and every lag. The weight is the restricted likelihood of the noise with a
    /// coefficient that may have any value; that of a lag, in the noise that is likeliest without
    /// it, does not depend on how much of the temperature the lag leaves.
    pub(super) fn candidates(&self, regressors: &[Regressor]) -> Vec<Candidate> {
        let mut candidates = Vec::with_capacity(regressors.len() * self.weighted.len());
        for Regressor { lag_s, coefficients, squares } in regressors {
            let reference = squares[self.likeliest];
            for (place, weighted, of_axis) in &self.weighted {
                let product = dot(&weighted[..coefficients.len()], coefficients);
                let of_lag = squares[*place];
                let (value, dof) = (product / of_lag, weighted.len() as f64 - 1.0);
                let residual = (of_axis - value * product).max(f64::MIN_POSITIVE);
                let MixtureComponent { log_prior, log_determinant, .. } = &self.mixture.noises[*place];
                let log_weight = log_prior - 0.5 * (log_determinant + (of_lag / reference).ln() + dof * residual.ln());
                candidates.push(Candidate {
                    lag_s: *lag_s,
                    log_weight,
                    value,
                    error: (residual / (dof * of_lag)).sqrt(),
                    dof,
                });
            }
        }
        let highest = candidates.iter().map(|candidate| candidate.log_weight).fold(f64::NEG_INFINITY, f64::max);
        candidates.iter_mut().for_each(|candidate| candidate.log_weight -= highest);
        candidates
    }
}

impl Candidate {
    fn weight(&self) -> f64 {
        self.log_weight.exp()
    }

    /// How probable values above are: Student's distribution, by the normal deviate of Wallace
    /// ("Bounds on normal approximations to Student's and the chi-square distributions", 1959).
    fn above(&self, value: f64) -> f64 {
        let (t, n) = ((value - self.value) / self.error, self.dof);
        let deviate = (8.0 * n + 1.0) / (8.0 * n + 3.0) * (n * (t * t / n).ln_1p()).sqrt();
        normal_above(deviate.copysign(t))
    }
}

/// How probable a coefficient is, with this lag, that lies as far out as zero does.
pub(super) fn two_sided(candidates: &[Candidate], lag_s: f64) -> f64 {
    let of_lag = candidates.iter().filter(|candidate| candidate.lag_s == lag_s);
    let highest = of_lag.clone().map(|candidate| candidate.log_weight).fold(f64::NEG_INFINITY, f64::max);
    let (mut total, mut above, mut below) = (0.0, 0.0, 0.0);
    for candidate in of_lag {
        let weight = (candidate.log_weight - highest).exp();
        total += weight;
        above += weight * candidate.above(0.0);
        below += weight * Candidate { value: -candidate.value, ..*candidate }.above(0.0);
    }
    2.0 * above.min(below) / total
}

/// By lag.
pub(super) fn weights_of_lags(candidates: &[Candidate], regressors: &[Regressor]) -> Vec<f64> {
    let each = candidates.chunks(candidates.len() / regressors.len().max(1));
    each.map(|of_lag| of_lag.iter().map(Candidate::weight).sum()).collect()
}

/// The coefficient that lies above the true one with this probability.
pub(super) fn quantile(candidates: &[Candidate], p: f64) -> Option<f64> {
    let matter: Vec<(f64, &Candidate)> = candidates
        .iter()
        .map(|candidate| (candidate.weight(), candidate))
        .filter(|(weight, _)| *weight > NEGLIGIBLE)
        .collect();
    let total: f64 = matter.iter().map(|(weight, _)| weight).sum();
    let above =
        |value: f64| matter.iter().map(|(weight, candidate)| weight * candidate.above(value)).sum::<f64>() / total;
    let mean = matter.iter().map(|(weight, candidate)| weight * candidate.value).sum::<f64>() / total;
    let square = |(weight, candidate): &(f64, &Candidate)| {
        weight * ((candidate.value - mean).powi(2) + candidate.error.powi(2) * candidate.dof / (candidate.dof - 2.0))
    };
    let deviation = (matter.iter().map(square).sum::<f64>() / total).sqrt();
    // no distribution has more beyond (Chebyshev)
    let most = deviation / p.min(1.0 - p).sqrt();
    let (mut low, mut high) = (mean - most, mean + most);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if above(middle) > 1.0 - p { low = middle } else { high = middle }
    }
    Some(f64::midpoint(low, high)).filter(|value| value.is_finite())
}
