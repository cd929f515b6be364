//! Whether a filter slower than the output cuts the high frequencies of a channel.

use core::f64::consts::TAU;

use super::narrow_bands::NarrowBand;
use super::noise_model::non_negative;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::spectrum::Powers;

/// Lowest point in use: below, segments have lost their mean.
const LOWEST: usize = 4;

/// Twice the log-likelihood ratio that a clean record of twelve channels does not reach.
const EVIDENCE: f64 = 20.0;

/// Points that the Hann window makes of one independent point: 1 + 2 (4/9 + 1/36).
const DEPENDENCE: f64 = 1.944;

const ROUNDS: usize = 8;

/// In samples: noise with longer correlation is noise, with shorter it is filtered.
const SLOW: f64 = 16.0;
const FAST: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];

/// A low pass slower than the output: white noise is correlated from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollOff {
    /// Density of the white noise at low frequencies over its mean density: the correlation time in
    /// samples, both signs counted, above 1.
    pub correlation_samples: f64,
}

impl ChannelSignal {
    /// The roll-off of the spectrum towards half the sampling rate, beyond what white, flicker,
    /// random-walk and Gauss-Markov noise show, the `bands` left out; `None` where the record does
    /// not show it, and before eight segments are full.
    #[must_use]
    pub fn roll_off(&self, bands: &[NarrowBand]) -> Option<RollOff> {
        let powers = self.spectrum().powers().filter(|powers| powers.segments >= 8)?;
        let n = powers.segment_samples as f64;
        let last = powers.segment_samples / 2;
        let is_free = |k: usize| bands.iter().all(|band| !band.covers(k as f64 / n, 2.0 / n));
        // The last point has half the degrees of freedom.
        let points: Vec<usize> = (LOWEST..last).filter(|k| is_free(*k) && powers.powers[*k] > 0.0).collect();
        let column = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
            points.iter().map(|&k| shape((TAU * k as f64 / n).cos())).collect()
        };
        // 4 sin² πf = 2 - 2 cos 2πf
        let slow = [
            column(&|cos| (2.0 - 2.0 * cos).powf(-0.5)),
            column(&|cos| (2.0 - 2.0 * cos).recip()),
            column(&|cos| correlated(SLOW, cos)),
        ];
        let with = |fast: Vec<Vec<f64>>| fit(&powers, &points, &[&fast[..], &slow].concat());
        let (flat, _) = with(vec![column(&|_| 1.0)])?;
        let (sloped, parameters) = with(vec![column(&|cos| 1.0 + cos), column(&|cos| 1.0 - cos)])?;
        if parameters[0] <= parameters[1] || 2.0 * powers.averages * (flat - sloped) / DEPENDENCE < EVIDENCE {
            return None;
        }
        let fast = [vec![column(&|_| 1.0)], FAST.map(|time| column(&|cos| correlated(time, cos))).to_vec()].concat();
        let (_, parameters) = with(fast)?;
        // Each has a mean density of 1.
        let mean: f64 = parameters[..=FAST.len()].iter().sum();
        let at_zero: f64 = parameters[0]
            + FAST
                .iter()
                .zip(&parameters[1..])
                .map(|(time, parameter)| parameter * correlated(*time, 1.0))
                .sum::<f64>();
        Some(RollOff { correlation_samples: (at_zero / mean).max(1.0) })
    }
}

/// Density of samples with the covariance e^(-|k|/`time`), for variance 1.
fn correlated(time: f64, cos: f64) -> f64 {
    let a = (-1.0 / time).exp();
    (1.0 - a * a) / (1.0 - 2.0 * a * cos + a * a)
}

/// Non-negative amplitudes of the `columns` by the likelihood of averaged periodograms, and its
/// negative logarithm over the averages.
fn fit(powers: &Powers, points: &[usize], columns: &[Vec<f64>]) -> Option<(f64, Vec<f64>)> {
    let mut expected: Vec<f64> = points.iter().map(|&k| powers.powers[k]).collect();
    let mut parameters = Vec::new();
    for _ in 0..ROUNDS {
        let scaled: Vec<Vec<f64>> =
            columns.iter().map(|column| column.iter().zip(&expected).map(|(c, e)| c / e).collect()).collect();
        let target: Vec<f64> = points.iter().zip(&expected).map(|(&k, e)| powers.powers[k] / e).collect();
        parameters = non_negative(&scaled, &target);
        for (i, expected) in expected.iter_mut().enumerate() {
            *expected = columns.iter().zip(&parameters).map(|(column, parameter)| column[i] * parameter).sum();
        }
        if expected.iter().any(|value| value.is_nan() || *value <= 0.0) {
            return None;
        }
    }
    let minus_log_likelihood = points.iter().zip(&expected).map(|(&k, e)| e.ln() + powers.powers[k] / e).sum();
    Some((minus_log_likelihood, parameters))
}
