//! The slope of the regression line over a record: its variance in each noise, and its covariance
//! with the variances of the octaves.

use core::f64::consts::PI;

use super::{covariance::Covariance, joint::MOST_COMPONENTS, least_squares::dot, term::Term};
use crate::accumulate::record::{Deviation, Octave, RecordShape};

/// Places in the record at which the covariance of a difference with the slope is taken.
const PLACES: usize = 16;

/// Covariances of the slope d, of the mean difference of each octave, and of single differences,
/// all from the generalised covariance of s.
///
/// For continuous noise, with the phase x (the integral of the rate) and its integral s, d = 12/n³
/// (n (x_0 + x_n)/2 - s_n + s_0) and the mean difference of an octave is a sum of values of s.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    /// By parameter: variance of the slope for parameter 1.
    pub(super) variances: Vec<f64>,
    /// By statistic: expected value for a squared ramp of 1.
    pub(super) ramp_basis: Vec<f64>,
    /// By octave and parameter: covariance of mean difference and slope.
    means: Vec<f64>,
    /// By octave, octave up to it, and parameter: covariance of the mean differences.
    mean_pairs: Vec<f64>,
    /// By octave, and by parameter and those up to it: what the product of the two parameters adds
    /// to the mean over the places of the squared covariance of a difference and the slope.
    squares: Vec<f64>,
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
            mean_squares(&(0..PLACES).flat_map(of).collect::<Vec<_>>(), noise.len())
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
            squares: averages.iter().flat_map(places).collect(),
            divisors: octaves.iter().map(|octave| shape.deviation.divisor() * (octave.m as f64).powi(2)).collect(),
            deviation: shape.deviation,
            samples: n,
        }
    }

    /// Fills the last row, that of the squared slope, and adds the products of the squared `ramp`
    /// with the noise of `noise`.
    pub(super) fn add_covariance(&self, ramp: f64, noise: &[f64], covariance: &mut Covariance) {
        let terms = noise.len();
        let variance = dot(&self.variances, noise);
        let octaves = self.divisors.len();
        let last = covariance.row_mut(octaves);
        let mut products = [0.0; MOST_COMPONENTS * (MOST_COMPONENTS + 1) / 2];
        let pairs = (0..terms).flat_map(|p| (0..=p).map(move |q| (p, q)));
        pairs.zip(&mut products).for_each(|((p, q), product)| *product = noise[p] * noise[q]);
        let products = &products[..terms * (terms + 1) / 2];
        for ((last, squares), divisor) in
            last.iter_mut().zip(self.squares.chunks_exact(products.len())).zip(&self.divisors)
        {
            *last = 2.0 * dot(squares, products) / divisor;
        }
        last[octaves] = 2.0 * variance * variance + 4.0 * ramp * variance;
        if self.deviation == Deviation::Allan && ramp > 0.0 {
            for (last, mean) in last.iter_mut().zip(self.means.chunks_exact(terms)) {
                *last += 2.0 * ramp * dot(mean, noise);
            }
            let mut pairs = self.mean_pairs.chunks_exact(terms);
            for a in 0..octaves {
                covariance
                    .row_mut(a)
                    .iter_mut()
                    .zip(&mut pairs)
                    .for_each(|(row, pair)| *row += ramp * dot(pair, noise));
            }
        }
    }
}

impl Slope {
    /// Of a Gauss-Markov process of variance 1 and this correlation time in samples: that of the
    /// white noise that it is to long averages, or of the walk that it is to short ones, the
    /// smaller.
    pub(super) fn gauss_markov_variance(&self, time: f64) -> f64 {
        let n = self.samples;
        (2.0 * time * slope_variance(Term::White, n)).min(2.0 / time * slope_variance(Term::RateRandomWalk, n))
    }
}

/// The mean over all places of the square of Σ parameter · `places`, as multiples of the products
/// of each parameter with those up to it: none of it depends on the parameters.
fn mean_squares(places: &[f64], terms: usize) -> Vec<f64> {
    let count = (places.len() / terms) as f64;
    let mean = |p: usize, q: usize| {
        let products = places.chunks_exact(terms).map(|place| place[p] * place[q]);
        products.sum::<f64>() / count * if p == q { 1.0 } else { 2.0 }
    };
    (0..terms).flat_map(|p| (0..=p).map(move |q| (p, q))).map(|(p, q)| mean(p, q)).collect()
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

    #[test]
    fn squares_of_places_are_known_without_the_parameters() {
        let places = [[1.0, 2.0, -3.0], [0.5, -1.0, 4.0], [2.0, 0.0, 1.0], [-1.0, 3.0, 0.25]];
        let noise = [0.3, 2.0, 0.7];
        let expected = places.iter().map(|place| dot(place, &noise).powi(2)).sum::<f64>() / 4.0;
        let squares = mean_squares(&places.concat(), 3);
        let pairs = (0..3).flat_map(|p| (0..=p).map(move |q| noise[p] * noise[q]));
        let found: f64 = squares.iter().zip(pairs).map(|(square, pair)| square * pair).sum();
        assert!((found / expected - 1.0).abs() < 1e-14, "{found}, not {expected}");
    }
}
