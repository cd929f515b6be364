//! How far an integral drifts while a sensor coasts, from the curve of the deviation alone.
//!
//! A rest of T0 gives the mean that is subtracted during the coast of T. With x the integral of the
//! signal, the error of the once integrated signal is
//! x(T0 + T) - x(T0) - (T/T0) (x(T0) - x(0)), a sum of values of x whose weights w have neither
//! mean nor slope: Σ w = Σ w t = 0. For such sums the variance is Σ Σ w w' G(|t - t'|) with
//! the generalised covariance G of x (Matheron, 1973; for clocks NIST SP 1065, Greenhall 1983), of
//! which a multiple of τ² has no effect. The Allan variance is one of them:
//! G(2τ) = 4 G(τ) + τ² σ²(τ), so the curve gives G at all octaves, with no model. If the
//! rest is as long as the coast, the variance is 2 T² σ²(T). The same weights, integrated once and
//! twice more, give the position of an accelerometer and what a tilt makes of it.

use crate::infer::{chi_squared, confidence::Interval};

/// The deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Averaging time in seconds, above 0.
    pub tau_s: f64,
    /// Allan deviation, above 0.
    pub deviation: f64,
    /// Equivalent degrees of freedom of its square.
    pub edf: f64,
}

/// How often the signal is integrated before its error is read, beside the factor of the integral.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integral {
    /// Once: the angle of a gyroscope, the velocity of an accelerometer.
    Once,
    /// Twice: the position of an accelerometer; the velocity of a tilt, over g.
    Twice,
    /// Three times: the position of a tilt, over g.
    ThreeTimes,
}

/// How far an integral drifts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Standard deviation.
    pub std: f64,
    /// Equivalent degrees of freedom of its square.
    pub edf: f64,
}

/// Degrees of freedom below which a drift is not observable.
const LEAST_EDF: f64 = 2.0;

/// Parts of a coast over which the second and third integral are summed.
const PARTS: usize = 64;

/// Correlation of the variances of neighbours in white noise; of others a power of this.
const CORRELATION: f64 = 0.5;

impl Drift {
    /// The drift after a rest of `rest_s` and a coast of `coast_s` seconds, by a curve at octaves of the
    /// averaging time. `None` if a point is not above 0 or no octave of the one before, if a time is
    /// shorter than the first, and if the curve does not reach half of rest and coast together with two
    /// degrees of freedom.
    pub fn new(curve: &[CurvePoint], integral: Integral, rest_s: f64, coast_s: f64) -> Option<Self> {
        let is_known = |point: &&CurvePoint| {
            let CurvePoint { tau_s, deviation, edf } = **point;
            edf >= LEAST_EDF && [tau_s, deviation].iter().all(|value| *value > 0.0 && value.is_finite())
        };
        let curve: Vec<CurvePoint> = curve.iter().take_while(is_known).copied().collect();
        let is_octave = |pair: &[CurvePoint]| (pair[1].tau_s / pair[0].tau_s / 2.0 - 1.0).abs() < 1e-6;
        let longest_s = curve.last().filter(|_| curve.windows(2).all(is_octave))?.tau_s;
        let is_reached = rest_s.min(coast_s) >= curve[0].tau_s * (1.0 - 1e-9)
            && (rest_s + coast_s) / 2.0 <= longest_s * (1.0 + 1e-9);
        if !is_reached {
            return None;
        }
        let lags = lags(integral, rest_s, coast_s);
        let mut ln_variances: Vec<f64> = curve.iter().map(|point| 2.0 * point.deviation.ln()).collect();
        let variance = variance(curve[0].tau_s, &ln_variances, &lags);
        // by Satterthwaite, from what a change of each point changes
        let share = |place: usize| {
            const CHANGE: f64 = 1e-4;
            ln_variances[place] += CHANGE;
            let changed = self::variance(curve[0].tau_s, &ln_variances, &lags);
            ln_variances[place] -= CHANGE;
            (changed - variance) / CHANGE
        };
        let shares: Vec<f64> = (0..curve.len()).map(share).collect();
        let error = |(place, share): (usize, &f64)| {
            let with = |(other, of_other): (usize, &f64)| {
                let correlation = CORRELATION.powi(place.abs_diff(other) as i32);
                share * of_other * correlation / (curve[place].edf * curve[other].edf).sqrt()
            };
            shares.iter().enumerate().map(with).sum::<f64>()
        };
        let edf = variance * variance / shares.iter().enumerate().map(error).sum::<f64>();
        (variance > 0.0 && edf >= LEAST_EDF && edf.is_finite()).then(|| Self { std: variance.sqrt(), edf })
    }

    /// Half the width of the interval that contains one drift with this probability, the error of the
    /// standard deviation included: Student's t. `None` unless 0 < `confidence` < 1.
    pub fn half_width(&self, confidence: f64) -> Option<f64> {
        Some(self.std * chi_squared::student_two_sided(confidence, self.edf)?)
    }

    /// The confidence interval of the standard deviation. `None` unless 0 < `confidence` < 1.
    pub fn interval(&self, confidence: f64) -> Option<(f64, f64)> {
        let interval = Interval::new(self.std * self.std, self.edf, confidence)?;
        Some((interval.lower, interval.upper))
    }
}

/// The distances of the values of x in seconds, each with the sum of its products of weights.
fn lags(integral: Integral, rest_s: f64, coast_s: f64) -> Vec<(f64, f64)> {
    let parts = if integral == Integral::Once { 1 } else { PARTS };
    let part_s = coast_s / parts as f64;
    let weight = |at: usize| {
        let is_end = at == 0 || at == parts;
        let trapezoid = if is_end { part_s / 2.0 } else { part_s };
        match integral {
            Integral::Once => at as f64,
            Integral::Twice => trapezoid,
            Integral::ThreeTimes => trapezoid * (parts - at) as f64 * part_s,
        }
    };
    let mut weights: Vec<f64> = (0..=parts).map(weight).collect();
    let (sum, slope): (f64, f64) = weights
        .iter()
        .enumerate()
        .fold((0.0, 0.0), |(sum, slope), (at, weight)| (sum + weight, slope + weight * at as f64 * part_s));
    // the mean over the rest is subtracted, and the integral begins at the end of it
    let start = slope / rest_s;
    weights[0] -= sum + start;
    let product = |apart: usize| weights.iter().zip(&weights[apart..]).map(|(a, b)| 2.0 * a * b).sum();
    let within = (1..=parts).map(|apart| (apart as f64 * part_s, product(apart)));
    let from_start = weights.iter().enumerate().map(|(at, weight)| (rest_s + at as f64 * part_s, 2.0 * start * weight));
    within.chain(from_start).collect()
}

/// The sum of the coefficients times G at their lags. G(τ) = τ² h(τ) with h(2τ) = h(τ) + σ²(τ)/4;
/// between octaves, h follows the power of τ that the neighbouring octaves do, and below the first
/// that of white noise. What is added to all h has no effect, so that h is 0 at the octave
/// below the shortest lag.
fn variance(shortest_s: f64, ln_variances: &[f64], lags: &[(f64, f64)]) -> f64 {
    let last = ln_variances.len() - 1;
    let place_of = |lag_s: f64| ((lag_s / shortest_s).log2().max(0.0) as usize).min(last);
    let first = lags.iter().map(|(lag_s, _)| place_of(*lag_s)).min().unwrap_or(0);
    let mut at_octaves = vec![0.0; ln_variances.len()];
    for place in first + 1..ln_variances.len() {
        at_octaves[place] = at_octaves[place - 1] + ln_variances[place - 1].exp() / 4.0;
    }
    let at = |lag_s: f64| {
        let place = place_of(lag_s);
        let octaves = (lag_s / shortest_s).log2() - place as f64;
        let (before, after) = (place.saturating_sub(1), (place + 1).min(last));
        let slope = match after - before {
            // no neighbour, or shorter than all: white
            0 => -1.0,
            _ if octaves < 0.0 => -1.0,
            apart => (ln_variances[after] - ln_variances[before]) / (apart as f64 * std::f64::consts::LN_2),
        };
        let grown = |octaves: f64| if slope.abs() < 1e-6 { octaves } else { (octaves * slope).exp2() - 1.0 };
        at_octaves[place] + ln_variances[place].exp() / 4.0 * grown(octaves) / grown(1.0)
    };
    lags.iter().map(|(lag_s, coefficient)| coefficient * lag_s * lag_s * at(*lag_s)).sum()
}

#[cfg(test)]
mod tests;
