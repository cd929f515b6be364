//! Expected octave variances and their covariance, as functions of the noise parameters; and the
//! slope of the regression line over the record as one more statistic.

use std::sync::Arc;

use core::f64::consts::PI;

use super::{
    Term,
    joint::{Component, JointMeans, MOST_COMPONENTS},
    least_squares::dot,
};
use crate::accumulate::record::{Deviation, Octave, RecordShape};
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
    /// is, and the standard deviation of each octave from what is not known of the frequency.
    Line { noise: f64, spread: Vec<f64> },
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
                BesideKind::Line { .. } | BesideKind::Edges => 0.0,
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

    /// Correlation times in samples of what is beside the terms, where that is a Gauss-Markov
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

    pub(super) fn covariance(&self, parameters: &[f64]) -> Covariance {
        self.covariance_of(parameters, parameters)
    }

    /// 2 E²/variance. A ramp moves with the slope of the noise, which is taken from `upper_bounds`.
    pub(super) fn edf(&self, parameters: &[f64], upper_bounds: &[f64]) -> Vec<f64> {
        let covariance = self.covariance_of(parameters, upper_bounds);
        (0..self.octaves).map(|a| 2.0 * self.expected(parameters, a).powi(2) / covariance.variance(a)).collect()
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
    fn of_slope(&self, parameters: &[f64]) -> Vec<f64> {
        let mut noise = parameters[..self.noise].to_vec();
        let Some(slope) = &self.slope else { return noise };
        for (beside, parameter) in self.beside.iter().zip(&parameters[self.terms()..]) {
            if let BesideKind::GaussMarkov { time } = beside.kind {
                noise[self.white] += parameter * slope.gauss_markov_variance(time) / slope.variances[self.white];
            }
        }
        noise
    }

    /// The noise that moves the slope is that of `of_slope`.
    fn covariance_of(&self, parameters: &[f64], of_slope: &[f64]) -> Covariance {
        let terms = self.noise;
        // by octave and term: root of what it adds to the variance there
        let mut roots = vec![[0.0; MOST_COMPONENTS]; self.octaves];
        for (p, (column, parameter)) in self.basis[..terms].iter().zip(parameters).enumerate() {
            for (a, value) in column[..self.octaves].iter().enumerate() {
                roots[a][p] = value * parameter;
            }
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
        let mut covariance = Covariance::new(self.statistics());
        for (a, roots_a) in roots.iter().enumerate() {
            let row = covariance.row(a);
            for (b, roots_b) in roots[..=a].iter().enumerate() {
                let products: [f64; MOST_COMPONENTS] = std::array::from_fn(|p| roots_a[p] * roots_b[p]);
                let means = self.joint.means(a, b);
                let sum: f64 =
                    means.iter().zip(&products).map(|(means, product)| product * dot(means, &products)).sum();
                row[b] = 2.0 * sum + self.tails / (self.factors[a] * self.factors[b]);
            }
        }
        for (beside, &parameter) in self.beside.iter().zip(&parameters[self.terms()..]) {
            let BesideKind::Line { noise, spread } = &beside.kind else { continue };
            // The power P of a line in noise of density S has the variance 4 P S/n.
            let factor = 4.0 * parameter * noise;
            for (a, (value, spread)) in beside.variances.iter().zip(spread).enumerate() {
                let row = covariance.row(a);
                row.iter_mut().zip(&beside.variances[..=a]).for_each(|(row, other)| *row += factor * value * other);
                row[a] += (parameter * spread).powi(2);
            }
        }
        if let Some(slope) = &self.slope {
            slope.add_covariance(parameters[self.noise], &self.of_slope(of_slope), &mut covariance);
        }
        covariance
    }

    /// The term of noise that octave `a` of a Gauss-Markov process is most like.
    fn like_gauss_markov(&self, a: usize, time: f64) -> usize {
        if self.factors[a] < time { self.noise - 1 } else { self.white }
    }
}

/// Of all statistics, the lower triangle of a symmetric matrix, row by row.
pub(super) struct Covariance {
    values: Vec<f64>,
}

impl Covariance {
    fn new(statistics: usize) -> Self {
        Self { values: vec![0.0; statistics * (statistics + 1) / 2] }
    }

    /// Up to the diagonal.
    fn row(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * (i + 1) / 2..][..=i]
    }

    pub(super) fn variance(&self, i: usize) -> f64 {
        self.between(i, i)
    }

    /// Of statistic `i` and one up to it.
    pub(super) fn between(&self, i: usize, j: usize) -> f64 {
        self.values[i * (i + 1) / 2 + j]
    }
}

const PLACES: usize = 16;

/// Covariances of the slope d, of the mean difference of each octave, and of single differences,
/// all from the generalised covariance of s.
///
/// For continuous noise, with the phase x (the integral of the rate) and its integral s, d = 12/n³
/// (n (x_0 + x_n)/2 - s_n + s_0) and the mean difference of an octave is a sum of values of s.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    /// By parameter: variance of the slope for parameter 1.
    variances: Vec<f64>,
    /// By statistic: expected value for a squared ramp of 1.
    ramp_basis: Vec<f64>,
    /// By octave and parameter: covariance of mean difference and slope.
    means: Vec<f64>,
    /// By octave, octave up to it, and parameter: covariance of the mean differences.
    mean_pairs: Vec<f64>,
    /// By octave, place and parameter: covariance of a difference and the slope.
    places: Vec<f64>,
    /// By octave: the divisor c m² of a squared difference.
    divisors: Vec<f64>,
    deviation: Deviation,
    samples: f64,
}

impl Slope {
    /// `noise`: the terms that are not the ramp, in the order of the parameters.
    pub(super) fn new(noise: &[Term], octaves: &[Octave], shape: &RecordShape) -> Self {
        let n = shape.samples as f64;
        // Missing samples: octaves show so much of all noise but the white, and its slope varies more.
        let present = |octave: &Octave, term: Term| match term {
            Term::White | Term::Quantization => 1.0,
            _ => octave.share_present,
        };
        let all_present = octaves.last().map_or(1.0, |octave| octave.share_present);
        let of_slope = |term: Term| match term {
            Term::White | Term::Quantization => slope_variance(term, n) / all_present,
            _ => slope_variance(term, n),
        };
        let averages: Vec<(&Octave, Average)> =
            octaves.iter().map(|octave| (octave, Average::new(octave.m, shape))).collect();
        let places = |(octave, average): &(&Octave, Average)| {
            let place = |i| (i as f64 + 0.5) / PLACES as f64;
            let of = |i| {
                let of =
                    move |term: &Term| present(octave, *term).sqrt() * average.place_with_slope(place(i), n, *term);
                noise.iter().map(of)
            };
            (0..PLACES).flat_map(of).collect::<Vec<_>>()
        };
        let mean_pairs = averages.iter().enumerate().flat_map(|(a, (octave, average))| {
            let of = move |(other_octave, other): &(&Octave, Average)| {
                let of = |term: &Term| {
                    present(octave, *term) * present(other_octave, *term) * average.covariance(other, *term)
                };
                noise.iter().map(of).collect::<Vec<_>>()
            };
            averages[..=a].iter().flat_map(of)
        });
        let with_slope = |(octave, average): &(&Octave, Average)| {
            let of = |term: &Term| present(octave, *term) * average.with_slope(n, *term);
            noise.iter().map(of).collect::<Vec<_>>()
        };
        let of_ramp = |m: u64| (m as f64).powi(2) / 2.0;
        let ramp = |octave: &Octave| match shape.deviation {
            Deviation::Allan => octave.expected(of_ramp(octave.m), of_ramp),
            Deviation::Hadamard => octave.expected(0.0, of_ramp),
        };
        Self {
            variances: noise.iter().map(|term| of_slope(*term)).collect(),
            ramp_basis: octaves.iter().map(ramp).chain([1.0]).collect(),
            means: averages.iter().flat_map(with_slope).collect(),
            mean_pairs: mean_pairs.collect(),
            places: averages.iter().flat_map(places).collect(),
            divisors: octaves.iter().map(|octave| shape.deviation.divisor() * (octave.m as f64).powi(2)).collect(),
            deviation: shape.deviation,
            samples: n,
        }
    }

    /// Fills the last row, that of the squared slope, and adds the products of the squared `ramp`
    /// with the noise of `noise`.
    fn add_covariance(&self, ramp: f64, noise: &[f64], covariance: &mut Covariance) {
        let terms = noise.len();
        let variance = dot(&self.variances, noise);
        let octaves = self.divisors.len();
        let last = covariance.row(octaves);
        for ((last, places), divisor) in
            last.iter_mut().zip(self.places.chunks_exact(PLACES * terms)).zip(&self.divisors)
        {
            let squares: f64 = places.chunks_exact(terms).map(|place| dot(place, noise).powi(2)).sum();
            *last = 2.0 * squares / PLACES as f64 / divisor;
        }
        last[octaves] = 2.0 * variance * variance + 4.0 * ramp * variance;
        if self.deviation == Deviation::Allan && ramp > 0.0 {
            for (last, mean) in last.iter_mut().zip(self.means.chunks_exact(terms)) {
                *last += 2.0 * ramp * dot(mean, noise);
            }
            let mut pairs = self.mean_pairs.chunks_exact(terms);
            for a in 0..octaves {
                covariance.row(a).iter_mut().zip(&mut pairs).for_each(|(row, pair)| *row += ramp * dot(pair, noise));
            }
        }
    }
}

impl Slope {
    /// Of a Gauss-Markov process of variance 1 and this correlation time in samples: that of the
    /// white noise that it is to long averages, or of the walk that it is to short ones, the
    /// smaller.
    fn gauss_markov_variance(&self, time: f64) -> f64 {
        let n = self.samples;
        (2.0 * time * slope_variance(Term::White, n)).min(2.0 / time * slope_variance(Term::RateRandomWalk, n))
    }
}

/// Of the regression line over n samples, many, for amplitude 1: the double integral of the weights
/// 12 (t - n/2)/n³ over the covariance of the rate (flicker: -ln|lag|/π).
fn slope_variance(term: Term, n: f64) -> f64 {
    match term {
        Term::Quantization => 72.0 / n.powi(4),
        Term::White => 12.0 / n.powi(3),
        Term::BiasInstability => 9.0 / (PI * n * n),
        Term::RateRandomWalk => 6.0 / (5.0 * n),
        Term::RateRamp => 0.0,
    }
}

struct Average {
    /// (time, weight): where the phase enters a difference that starts at 0.
    difference: Vec<(f64, f64)>,
    /// Starts range from 0 to this.
    range: f64,
}

impl Average {
    fn new(m: u64, shape: &RecordShape) -> Self {
        let weights: &[f64] = match shape.deviation {
            Deviation::Allan => &[1.0, -2.0, 1.0],
            Deviation::Hadamard => &[-1.0, 3.0, -3.0, 1.0],
        };
        let difference = weights.iter().enumerate().map(|(k, weight)| (k as f64 * m as f64, *weight)).collect();
        Self { difference, range: (shape.windows(m) * shape.stride(m)) as f64 }
    }

    /// (time, weight): where the integral of the phase enters the mean.
    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let ends =
            |&(time, weight): &(f64, f64)| [(time + self.range, weight / self.range), (time, -weight / self.range)];
        self.difference.iter().flat_map(ends)
    }

    fn covariance(&self, other: &Self, term: Term) -> f64 {
        let pairs = self.points().flat_map(|a| other.points().map(move |b| (a, b)));
        pairs.map(|((t, w), (u, v))| w * v * integral_covariance(term, t - u)).sum()
    }

    fn with_slope(&self, n: f64, term: Term) -> f64 {
        let at = |time: f64| {
            n / 2.0 * (integral_with_phase(term, n - time) + integral_with_phase(term, -time))
                - (integral_covariance(term, n - time) - integral_covariance(term, time))
        };
        12.0 / n.powi(3) * self.points().map(|(time, weight)| weight * at(time)).sum::<f64>()
    }

    /// At `place`, 0 to 1, of the range.
    fn place_with_slope(&self, place: f64, n: f64, term: Term) -> f64 {
        let at = |time: f64| {
            n / 2.0 * (phase_covariance(term, n - time) + phase_covariance(term, time))
                - (integral_with_phase(term, time - n) - integral_with_phase(term, time))
        };
        let start = place * self.range;
        12.0 / n.powi(3) * self.difference.iter().map(|(time, weight)| weight * at(start + time)).sum::<f64>()
    }
}

/// Generalised covariance h of the integral of the phase, -h'' that of the phase.
fn integral_covariance(term: Term, lag: f64) -> f64 {
    let t = lag.abs();
    match term {
        Term::White => t.powi(3) / 12.0,
        Term::BiasInstability if t > 0.0 => -t.powi(4) * t.ln() / (24.0 * PI),
        Term::RateRandomWalk => -t.powi(5) / 240.0,
        _ => 0.0,
    }
}

/// Covariance of the phase at one time and its integral at another, h'.
fn integral_with_phase(term: Term, lag: f64) -> f64 {
    let t = lag.abs();
    let magnitude = match term {
        Term::White => t * t / 4.0,
        Term::BiasInstability if t > 0.0 => -t.powi(3) * (4.0 * t.ln() + 1.0) / (24.0 * PI),
        Term::RateRandomWalk => -t.powi(4) / 48.0,
        _ => 0.0,
    };
    magnitude.copysign(magnitude * lag)
}

/// Generalised covariance of the phase, -h''.
fn phase_covariance(term: Term, lag: f64) -> f64 {
    let t = lag.abs();
    match term {
        Term::White => -t / 2.0,
        Term::BiasInstability if t > 0.0 => t * t * (12.0 * t.ln() + 7.0) / (24.0 * PI),
        Term::RateRandomWalk => t.powi(3) / 12.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Estimator;

    #[test]
    fn the_slope_between_blocks_varies_with_the_slope_as_regression_has_it() {
        let n = 4096.0;
        let shape =
            RecordShape { samples: 4096, interval_s: 1.0, estimator: Estimator::Strided, deviation: Deviation::Allan };
        let average = Average::new(16, &shape);
        let near =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
        // Least squares is the best estimate in white noise: any other one has the covariance 12/n³ with it.
        near(average.with_slope(n, Term::White), 256.0 * 12.0 / n.powi(3));
        near(average.place_with_slope(0.1, n, Term::White), 256.0 * 12.0 / n.powi(3));
        // A walk: first against last value, (y_n - y_0)/n, has 1/n; at place u it is 6 u (1 - u)/n.
        near(average.with_slope(n, Term::RateRandomWalk), 256.0 / n);
        near(average.place_with_slope(0.5, n, Term::RateRandomWalk), 256.0 * 1.5 / n);
        near(average.covariance(&average, Term::RateRandomWalk), 256.0 * 256.0 / n);
    }
}
