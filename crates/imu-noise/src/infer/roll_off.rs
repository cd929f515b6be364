//! Whether a filter slower than the output cuts or raises the high frequencies of a channel.

use core::f64::consts::TAU;

use super::least_squares::NonNegative;
use super::narrow_bands::NarrowBand;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::spectrum::Powers;

/// Of the rate: above, Gauss-Markov noise with a correlation time of 16 samples or more falls as a
/// random walk does.
const LOWEST: f64 = 1.0 / 16.0;

/// Correlation times in samples that indicate a filter.
const FAST: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Lowest point in use: below, segments have lost their mean.
const FIRST: usize = 4;

/// Twice the log-likelihood ratio that proves a filter; none of the 50 records of power-law noise
/// in the tests reaches it.
const EVIDENCE: f64 = 20.0;

/// Above, there may be one, and the interval of N covers both. A minute behind the filter of a
/// VN-100 at 200 Hz gives a ratio of 9 to 20, half a minute one of 2 to 9.
const POSSIBLE: f64 = 3.0;

/// Points that the Hann window makes of one independent point: 1 + 2 (4/9 + 1/36).
const DEPENDENCE: f64 = 1.944;

const ROUNDS: usize = 8;

/// Points of the spectrum that are fitted together: a filter changes little over one part in a
/// hundred of the band.
const POINTS_OF_BIN: usize = 4;

/// Of the largest power: what is below may be leakage.
const LEAKAGE: f64 = 1e-3;

/// A filter slower than the output: white noise is correlated from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollOff {
    /// Density of the white noise at low frequencies over its mean density: the correlation time in
    /// samples, both signs counted; above 1 for a low pass, below for a filter that raises high
    /// frequencies.
    pub correlation_samples: f64,
    /// Whether it is a low pass beyond doubt. Otherwise the noise may be white after all, and
    /// intervals hold with and without a filter.
    pub is_proved: bool,
}

impl RollOff {
    /// A filter that the spectrum does not show.
    pub(crate) const POSSIBLE: Self = Self { correlation_samples: 1.0, is_proved: false };
}

impl ChannelSignal {
    /// What a filter makes of the spectrum towards half the sampling rate, beyond what white,
    /// flicker, random-walk and Gauss-Markov noise show, the `bands` excluded; `None` where the
    /// record does not show it, and before eight segments are full.
    #[must_use]
    pub fn roll_off(&self, bands: &[NarrowBand]) -> Option<RollOff> {
        let powers = self.spectrum().powers().filter(|powers| powers.segments >= 8)?;
        let n = powers.segment_samples as f64;
        let last = powers.segment_samples / 2;
        let is_free = |k: usize| bands.iter().all(|band| !band.covers(k as f64 / n, 2.0 / n));
        // The last point has half the degrees of freedom.
        let points: Vec<usize> = (FIRST..last).filter(|k| is_free(*k) && powers.powers[*k] > 0.0).collect();
        let first_fast = points.partition_point(|k| (*k as f64) < LOWEST * n);
        let fast: Vec<Bin> =
            points[first_fast..].chunks(POINTS_OF_BIN).map(|points| Bin::of(&powers, points)).collect();
        let column = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
            fast.iter().map(|bin| shape((TAU * bin.point / n).cos())).collect()
        };
        // 4 sin² πf = 2 - 2 cos 2πf
        let slow = [column(&|cos| (2.0 - 2.0 * cos).powf(-0.5)), column(&|cos| (2.0 - 2.0 * cos).recip())];
        let with = |white: Vec<Vec<f64>>| fit(&fast, &[&white[..], &slow].concat());
        let white = vec![column(&|_| 1.0)];
        let fast_noise = FAST.map(|time| column(&|cos| correlated(time, cos)));
        let flat = with(white.clone())?;
        let raised = with([white.clone(), vec![column(&|cos| 1.0 - cos)]].concat())?;
        let filtered = with([white, vec![column(&|cos| 1.0 + cos)], fast_noise.to_vec()].concat())?;
        let evidence = |filter: f64| 2.0 * powers.averages * (flat - filter) / DEPENDENCE;
        let is_proved = evidence(filtered) > EVIDENCE || falls_faster_than_a_walk(&powers, &points);
        let [may_fall, may_rise] = [filtered, raised].map(|filter| evidence(filter) > POSSIBLE);
        if !is_proved && !may_fall && !may_rise {
            return None;
        }
        // without the lines, which are no white noise
        let mean = points.iter().map(|k| powers.powers[*k]).sum::<f64>() / points.len() as f64;
        let mut low: Vec<f64> = points.iter().take_while(|k| **k <= last / 8).map(|k| powers.powers[*k]).collect();
        let middle = low.len() / 2;
        let plateau = *low.get_mut(..).filter(|low| !low.is_empty())?.select_nth_unstable_by(middle, f64::total_cmp).1;
        let correlation_samples = plateau / mean;
        // a hump of some frequencies falls towards higher ones, but not from a plateau
        match plateau > mean {
            true => (is_proved || may_fall).then_some(RollOff { correlation_samples, is_proved }),
            false => may_rise.then_some(RollOff { correlation_samples, is_proved: false }),
        }
    }
}

/// Whether the mean power of the upper half of a range of frequencies is below that of the lower
/// one by more than a random walk's is, beyond doubt.
fn falls_faster_than_a_walk(powers: &Powers, points: &[usize]) -> bool {
    const DOUBT_STD: f64 = 5.0;
    let n = powers.segment_samples as f64;
    let mean = |from: f64, to: f64| {
        let points = points.iter().filter(|k| (from..to).contains(&(**k as f64 / n)));
        let (sum, walk, count) = points.fold((0.0, 0.0, 0.0), |(sum, walk, count), &k| {
            (sum + powers.powers[k], walk + (1.0 - (TAU * k as f64 / n).cos()).recip(), count + 1.0)
        });
        (sum / walk, count)
    };
    [(1.0 / 16.0, 0.125, 0.25), (0.125, 0.25, 0.5), (0.25, 0.375, 0.5)].into_iter().any(|(from, middle, to)| {
        let ((lower, below), (upper, above)) = (mean(from, middle), mean(middle, to));
        let relative = (DEPENDENCE / powers.averages * (1.0 / below + 1.0 / above)).sqrt();
        upper < lower * (1.0 - DOUBT_STD * relative)
    })
}

/// Density of samples with the covariance e^(-|k|/`time`), for variance 1.
fn correlated(time: f64, cos: f64) -> f64 {
    let a = (-1.0 / time).exp();
    (1.0 - a * a) / (1.0 - 2.0 * a * cos + a * a)
}

/// The mean over neighbouring points.
struct Bin {
    point: f64,
    power: f64,
    points: f64,
}

impl Bin {
    fn of(powers: &Powers, points: &[usize]) -> Self {
        let count = points.len() as f64;
        Self {
            point: points.iter().map(|&k| k as f64).sum::<f64>() / count,
            power: points.iter().map(|&k| powers.powers[k]).sum::<f64>() / count,
            points: count,
        }
    }
}

/// The negative logarithm of the likelihood of averaged periodograms, over the averages, with
/// non-negative amplitudes of the `columns`.
fn fit(bins: &[Bin], columns: &[Vec<f64>]) -> Option<f64> {
    let total: f64 = bins.iter().map(|bin| bin.points).sum();
    let mean = bins.iter().map(|bin| bin.points * bin.power).sum::<f64>() / total;
    let mut expected = vec![mean; bins.len()];
    let mut parameters = Vec::new();
    let mut least_squares = NonNegative::default();
    let (mut weights, mut weighted, mut target) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        weights.clear();
        weights.extend(bins.iter().zip(&expected).map(|(bin, e)| bin.points.sqrt() / e));
        weighted.clear();
        for column in columns {
            weighted.extend(column.iter().zip(&weights).map(|(c, weight)| c * weight));
        }
        target.clear();
        target.extend(bins.iter().zip(&weights).map(|(bin, weight)| bin.power * weight));
        parameters = least_squares.solve(&weighted, &target, &parameters).to_vec();
        for (i, expected) in expected.iter_mut().enumerate() {
            *expected = columns.iter().zip(&parameters).map(|(column, parameter)| column[i] * parameter).sum();
        }
        // Behind a steep filter the smallest powers are leakage.
        let least = LEAKAGE * expected.iter().copied().fold(0.0, f64::max);
        if least.is_nan() || least <= 0.0 {
            return None;
        }
        expected.iter_mut().for_each(|expected| *expected = expected.max(least));
    }
    Some(bins.iter().zip(&expected).map(|(bin, e)| bin.points * (e.ln() + bin.power / e)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a channel in counts of any size.
    #[test]
    fn a_fall_is_compared_with_that_of_a_walk() {
        const SEGMENT: usize = 1024;
        let points: Vec<usize> = (FIRST..SEGMENT / 2).collect();
        for counts2 in [1e-6, 1.0, 1e6] {
            let falls = |power: fn(f64) -> f64| {
                let powers =
                    (0..=SEGMENT / 2).map(|k| counts2 * power(2.0 - 2.0 * (TAU * k as f64 / SEGMENT as f64).cos()));
                let powers =
                    Powers { segment_samples: SEGMENT, segments: 64, averages: 64.0, powers: powers.collect() };
                falls_faster_than_a_walk(&powers, &points)
            };
            assert!(!falls(|_| 1.0) && !falls(f64::recip), "{counts2}");
            assert!(falls(|square| square.powi(-3)), "{counts2}");
        }
    }
}
