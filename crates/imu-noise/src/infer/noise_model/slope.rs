//! The slope of the regression line over a record: its variance in each noise, and its covariance
//! with the variances of the octaves.

use core::f64::consts::PI;

use super::{covariance::Covariance, joint::MOST_COMPONENTS, term::Term};
use crate::accumulate::record::{Deviation, Octave, RecordShape};
use crate::infer::least_squares::dot;

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
    /// By octave and parameter: covariance of mean difference and slope; none for third
    /// differences.
    means: Vec<f64>,
    /// By octave, octave up to it, and parameter: covariance of the mean differences; none for
    /// third differences.
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
        // a ramp moves second differences alone
        let second = if shape.deviation == Deviation::Allan { &averages[..] } else { &[] };
        let mean_pairs = second.iter().enumerate().flat_map(|(a, (octave, average))| {
            let of = move |(other_octave, other): &(&Octave, Average)| {
                let of = |term: &Term| {
                    present(octave, *term) * present(other_octave, *term) * average.covariance(other, *term)
                };
                noise.iter().map(of).collect::<Vec<_>>()
            };
            second[..=a].iter().flat_map(of)
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
            means: second.iter().flat_map(with_slope).collect(),
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

/// The mean of the differences of an octave.
struct Average {
    m: f64,
    /// Of the differences of the phase.
    order: usize,
    /// Starts range from 0 to this.
    range: f64,
}

impl Average {
    fn new(m: u64, shape: &RecordShape) -> Self {
        Self { m: m as f64, order: shape.deviation.order(), range: (shape.windows(m) * shape.stride(m)) as f64 }
    }

    /// Between the start of a difference and its middle.
    fn half(&self) -> f64 {
        self.order as f64 * self.m / 2.0
    }

    /// The integral of the phase at the middle of the last difference less that at the middle of
    /// the first, over the range, differs as the mean does: times and weights.
    fn ends(&self) -> [(f64, f64); 2] {
        [(self.range + self.half(), 1.0 / self.range), (self.half(), -1.0 / self.range)]
    }

    /// With the mean of another, both of second differences.
    fn covariance(&self, other: &Self, term: Term) -> f64 {
        let (long, short) = if self.m > other.m { (self, other) } else { (other, self) };
        let of_short =
            |order, lag: f64| difference(short.order, short.m, lag, |more, lag| derivative(term, order + more, lag));
        let of_both = |lag: f64| difference(long.order, long.m, lag, of_short);
        let pairs = long.ends().into_iter().flat_map(|a| short.ends().map(|b| (a, b)));
        pairs.map(|((t, w), (u, v))| w * v * of_both(t - u)).sum()
    }

    fn with_slope(&self, n: f64, term: Term) -> f64 {
        self.ends().into_iter().map(|(time, weight)| weight * self.with_regression(0, n, time, term)).sum()
    }

    /// At `place`, 0 to 1, of the range.
    fn place_with_slope(&self, place: f64, n: f64, term: Term) -> f64 {
        self.with_regression(1, n, place * self.range + self.half(), term)
    }

    /// Of the slope over n samples with the difference about `time` of the integral of the phase,
    /// or of its derivative of this order.
    fn with_regression(&self, order: usize, n: f64, time: f64, term: Term) -> f64 {
        let by_start = |more, lag| regression(term, order + more, n, lag);
        let by_end = |more, lag| regression(term, order + more, -n, lag);
        let of = |lag, by: &dyn Fn(usize, f64) -> f64| difference(self.order, self.m, lag, by);
        12.0 / n.powi(3) * (of(time, &by_start) - of(time - n, &by_end))
    }
}

/// The difference of this order at distances `m` about `middle` of a function that is smooth but at
/// 0, by its derivatives where it is smooth: there the values are alike in all their digits.
fn difference(order: usize, m: f64, middle: f64, derivative: impl Fn(usize, f64) -> f64) -> f64 {
    /// In distances `m`: the first term of the series that is not taken is below 1e-7.
    const SMOOTH: f64 = 16.0;
    if middle.abs() > SMOOTH * m {
        // (2 sinh(D/2))^p
        let p = order as f64;
        let series = [(0, 1.0), (2, p / 24.0), (4, p / 1920.0 + p * (p - 1.0) / 1152.0)];
        return series
            .map(|(more, part)| part * m.powi((order + more) as i32) * derivative(order + more, middle))
            .iter()
            .sum();
    }
    let weights: &[f64] = match order {
        2 => &[1.0, -2.0, 1.0],
        _ => &[-1.0, 3.0, -3.0, 1.0],
    };
    let first = middle - order as f64 * m / 2.0;
    weights.iter().enumerate().map(|(k, weight)| weight * derivative(0, first + k as f64 * m)).sum()
}

/// What the start of the record, or with -n its end, adds to the covariance of the slope over n
/// samples with the integral of the phase this much later, but for a factor; a derivative of it.
fn regression(term: Term, order: usize, n: f64, lag: f64) -> f64 {
    derivative(term, order, lag) - n / 2.0 * derivative(term, order + 1, lag)
}

/// Derivative of this order of the generalised covariance of the integral of the phase, that of the
/// phase being the second one but for its sign.
fn derivative(term: Term, order: usize, lag: f64) -> f64 {
    const FLICKER: [(f64, f64); 5] = [(1.0, 0.0), (4.0, 1.0), (12.0, 7.0), (24.0, 26.0), (24.0, 50.0)];
    let t = lag.abs();
    let value = match (term, order) {
        (Term::White, 0..=3) => t.powi(3 - order as i32) / [12.0, 4.0, 2.0, 2.0][order],
        (Term::RateRandomWalk, 0..=5) => -t.powi(5 - order as i32) / [240.0, 48.0, 12.0, 4.0, 2.0, 2.0][order],
        (Term::BiasInstability, _) if t == 0.0 => 0.0,
        (Term::BiasInstability, 0..=4) => {
            let (of_logarithm, of_one) = FLICKER[order];
            -t.powi(4 - order as i32) * (of_logarithm * t.ln() + of_one) / (24.0 * PI)
        }
        // -ln t/π, differentiated
        (Term::BiasInstability, _) => {
            let factorial: f64 = (1..=order - 5).map(|k| -(k as f64)).product();
            -factorial / (PI * t.powi(order as i32 - 4))
        }
        _ => 0.0,
    };
    if order % 2 == 1 && lag < 0.0 { -value } else { value }
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

    /// Over so many samples, at this averaging factor.
    fn average(samples: u64, m: u64, deviation: Deviation) -> Average {
        Average::new(m, &RecordShape { samples, interval_s: 1.0, estimator: Estimator::Strided, deviation })
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }

    #[test]
    fn covariances_are_those_of_the_values_where_these_have_the_digits() {
        let samples = 256;
        let n = samples as f64;
        for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
            // white noise has no third differences in common with the slope
            let both = [Deviation::Allan, Deviation::Hadamard];
            for deviation in both.into_iter().filter(|deviation| deviation.order() == 2 || term != Term::White) {
                let weights: &[f64] = match deviation {
                    Deviation::Allan => &[1.0, -2.0, 1.0],
                    Deviation::Hadamard => &[-1.0, 3.0, -3.0, 1.0],
                };
                // times and weights at which the phase enters a difference
                let points = |average: &Average| {
                    let m = average.m;
                    weights.iter().enumerate().map(move |(k, weight)| (k as f64 * m, *weight)).collect::<Vec<_>>()
                };
                let ends = |average: &Average| {
                    let range = average.range;
                    let of =
                        move |(time, weight): (f64, f64)| [(time + range, weight / range), (time, -weight / range)];
                    points(average).into_iter().flat_map(of).collect::<Vec<_>>()
                };
                for m in [1, 4, 16, 64] {
                    let long = average(samples, m, deviation);
                    let of_slope = |order, (time, weight): &(f64, f64)| {
                        let of = regression(term, order, n, *time) - regression(term, order, -n, time - n);
                        weight * 12.0 / n.powi(3) * of
                    };
                    let expected: f64 = ends(&long).iter().map(|end| of_slope(0, end)).sum();
                    // third differences take any ramp out
                    if deviation == Deviation::Allan {
                        assert_near(long.with_slope(n, term), expected, 1e-5);
                    }
                    let start = 0.3 * long.range;
                    let expected: f64 =
                        points(&long).iter().map(|(time, weight)| of_slope(1, &(start + time, *weight))).sum();
                    assert_near(long.place_with_slope(0.3, n, term), expected, 1e-5);
                    for short in [1, 4, 16].into_iter().filter(|short| *short <= m && deviation == Deviation::Allan) {
                        let short = average(samples, short, deviation);
                        let pairs = ends(&long).into_iter().flat_map(|a| ends(&short).into_iter().map(move |b| (a, b)));
                        let expected: f64 = pairs.map(|((t, w), (u, v))| w * v * derivative(term, 0, t - u)).sum();
                        assert_near(long.covariance(&short, term), expected, 1e-4);
                        assert_near(short.covariance(&long, term), expected, 1e-4);
                    }
                }
            }
        }
    }

    #[test]
    fn long_records_have_the_covariances_of_the_formulas() {
        // nine days at 800 Hz and more
        let samples = 1_u64 << 30;
        let n = samples as f64;
        for m in [1, 16, 1024, 1 << 20] {
            let average = average(samples, m, Deviation::Allan);
            let square = (m * m) as f64;
            if m > 1 {
                assert_near(average.with_slope(n, Term::White), square * 12.0 / n.powi(3), 0.1);
            }
            assert_near(average.with_slope(n, Term::RateRandomWalk), square / n, 0.01);
            assert_near(average.place_with_slope(0.5, n, Term::RateRandomWalk), square * 1.5 / n, 0.01);
            assert_near(average.covariance(&average, Term::RateRandomWalk), square * square / n, 0.01);
        }
        // flicker noise is the same on all scales
        let (small, large) = (average(1 << 12, 1, Deviation::Allan), average(1 << 30, 1 << 18, Deviation::Allan));
        let scale = f64::from(1 << 18).powi(2);
        let of = |average: &Average| average.covariance(average, Term::BiasInstability);
        assert_near(of(&large), scale * of(&small), 0.01);
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
