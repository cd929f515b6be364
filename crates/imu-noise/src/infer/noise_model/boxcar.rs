//! White noise as a stream carries it: averaged on board over a window that may be longer than the
//! interval between outputs, or filtered out at long averaging times.

use crate::accumulate::record::{Octave, RecordShape};
use crate::infer::chi_squared;
use crate::infer::confidence::edf;
use crate::infer::power_law::{PowerLaw, expected_variance};
use schemars::JsonSchema;
use serde::Serialize;

/// A sensor that averages `length` internal samples and sends every `decimation`-th average. Above
/// `decimation`, neighbours share samples, and white noise is depressed at short averaging times.
/// Flicker noise and random walk, below it there, are taken as they are.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct BoxcarWindow {
    /// Internal samples averaged; 0 counts as 1.
    pub length: u32,
    /// Internal samples from one output to the next: internal rate / output rate. Values below 1,
    /// and no numbers, count as 1; not whole where the rates are no multiples.
    pub decimation: f64,
}

impl BoxcarWindow {
    /// Autocovariance of averaged white noise at distances of 0, 1, 2, ... outputs, scaled so that
    /// over both signs they sum to 1: N is that at long averaging times.
    pub(super) fn autocovariance(self) -> Vec<f64> {
        let shared: Vec<f64> = self.shared().collect();
        let sum = 2.0 * shared.iter().sum::<f64>() - shared[0];
        shared.iter().map(|shared| shared / sum).collect()
    }

    /// Factor from the sensor's own density of white noise to the one at long averaging times: √(d
    /// Σ r(jd)) over all whole j, with the window w, the decimation d and the autocorrelation r(l)
    /// = (w - |l|)/w² of a mean of w independent values, |l| < w: 1 where w = d, √(d/w) where w <=
    /// d.
    pub fn white_factor(self) -> f64 {
        let length = f64::from(self.length.max(1));
        let sum = 2.0 * self.shared().sum::<f64>() - length;
        (self.outputs_apart() * sum).sqrt() / length
    }

    /// Whether successive outputs share internal samples.
    pub fn overlaps(self) -> bool {
        f64::from(self.length) > self.outputs_apart()
    }

    fn outputs_apart(self) -> f64 {
        self.decimation.max(1.0)
    }

    /// Internal samples that averages 0, 1, 2, ... outputs apart share.
    fn shared(self) -> impl Iterator<Item = f64> {
        let length = f64::from(self.length.max(1));
        let decimation = self.outputs_apart();
        (0_u32..).map(move |outputs| length - f64::from(outputs) * decimation).take_while(|shared| *shared > 0.0)
    }
}

/// Generalised covariance of the phase of white noise with these autocovariances.
pub(super) fn phase_covariance(autocovariance: &[f64], lag: f64) -> f64 {
    let phase = |lag| PowerLaw::White.phase_covariance(lag);
    let neighbours = autocovariance.iter().enumerate().skip(1);
    let sides = neighbours.map(|(apart, weight)| weight * (phase(lag - apart as f64) + phase(lag + apart as f64)));
    autocovariance[0] * phase(lag) + sides.sum::<f64>()
}

/// Octaves with fewer degrees of freedom are too uncertain to count.
const LEAST_EDF: f64 = 3.0;

/// Of the variances of neighbouring octaves in white noise; further apart it is a power of this.
const CORRELATION: f64 = 0.5;

/// By how many standard deviations the longest octaves lie below white noise with density `white`
/// (N, in unit/√Hz): the most of all runs of octaves that reach to the longest averaging time, 0
/// if none lies below. What lies below was filtered: a high-pass, or a bias that is taken out.
///
/// The probability of each variance under χ² becomes a normal deviate; a run's deviate is their sum
/// over its standard deviation (Stouffer, 1949) with correlated neighbours. One of 6000 seeded
/// records of white noise came to 3.7. A `window` longer than the interval depresses the short octaves
/// itself: the expected white noise follows it.
pub fn white_deficit(
    octaves: &[Octave],
    variances: &[f64],
    shape: &RecordShape,
    white: f64,
    window: Option<BoxcarWindow>,
) -> f64 {
    let averaged = window.map_or_else(|| vec![1.0], BoxcarWindow::autocovariance);
    let deviates: Vec<f64> = octaves
        .iter()
        .zip(variances)
        .filter(|(octave, _)| octave.m >= averaged.len() as u64)
        .filter_map(|(octave, variance)| {
            let edf = edf(octave, shape, PowerLaw::White).filter(|edf| *edf >= LEAST_EDF)?;
            let of_white = expected_variance(octave, shape.deviation, |lag| phase_covariance(&averaged, lag));
            let expected = white * white / shape.interval_s * of_white;
            let below = 1.0 - chi_squared::probability_above(variance / expected * edf, edf)?;
            // far out the deviate would be infinite
            Some(chi_squared::normal_quantile(below.clamp(1e-15, 1.0 - 1e-15)))
        })
        .collect();
    let mut sum = 0.0;
    let mut variance = 0.0;
    let mut to_the_others = 0.0;
    let runs = deviates.iter().rev().map(|deviate| {
        sum += deviate;
        variance += 1.0 + 2.0 * to_the_others;
        to_the_others = CORRELATION * (1.0 + to_the_others);
        -sum / f64::sqrt(variance)
    });
    runs.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::octaves::Octaves;
    use crate::accumulate::record::{Deviation, Estimator};

    #[test]
    fn factors_are_those_of_the_theory() {
        for (length, decimation, expected) in [
            (4, 4.0, 1.0),
            (4, 8.0, 2_f64.sqrt()),
            (4, 16.0, 2.0),
            (4, 20.0, 5_f64.sqrt()),
            (20, 20.0, 1.0),
            // averages that overlap whole keep the density
            (20, 4.0, 1.0),
            (4, 1.0, 1.0),
            // no averaging
            (0, 6.25, 2.5),
            (1, f64::NAN, 1.0),
        ] {
            let factor = BoxcarWindow { length, decimation }.white_factor();
            assert!((factor - expected).abs() < 1e-12, "window {length}, decimation {decimation}: {factor}");
        }
    }

    #[test]
    fn only_a_window_longer_than_the_interval_overlaps() {
        assert!(BoxcarWindow { length: 20, decimation: 4.0 }.overlaps());
        assert!(!BoxcarWindow { length: 4, decimation: 4.0 }.overlaps());
    }

    #[test]
    fn only_what_lies_below_counts() {
        let shape = RecordShape {
            samples: 144_000,
            interval_s: 0.025,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let octaves: Vec<Octave> =
            (0..17).map(|k| Octave::whole(1 << k, shape.windows(1 << k))).filter(|octave| octave.terms > 0).collect();
        let deficit = |factor: &dyn Fn(f64) -> f64| {
            let variance = |octave: &Octave| {
                let tau_s = octave.m as f64 * shape.interval_s;
                factor(tau_s) / tau_s
            };
            white_deficit(&octaves, &octaves.iter().map(variance).collect::<Vec<_>>(), &shape, 1.0, None)
        };
        // the median of few degrees of freedom lies below the mean
        assert!(deficit(&|_| 1.0) < 0.3);
        assert_eq!(deficit(&|tau_s| 1.0 + tau_s), 0.0);
        // a tracker with half a minute: white noise at short, slope -1 at long averaging times
        assert!(deficit(&|tau_s| 1.0 / (1.0 + tau_s / 100.0)) > 4.0);
        assert_eq!(white_deficit(&[], &[], &shape, 1.0, None), 0.0);
    }
    #[test]
    fn a_window_longer_than_the_interval_is_no_filter_of_the_bias() {
        let (window, samples) = (20, 60_000);
        let mut state = 1_u64;
        // sums of twelve uniform numbers are normal enough, with a variance of 1
        let mut normal = || {
            let uniform = (0..12).map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / 2_f64.powi(53)
            });
            uniform.sum::<f64>() - 6.0
        };
        let internal: Vec<f64> = (0..samples * 4 + window).map(|_| normal()).collect();
        let counts: Vec<i32> = internal
            .windows(window)
            .step_by(4)
            .map(|averaged| (averaged.iter().sum::<f64>() / window as f64 * 1e4).round() as i32)
            .collect();
        let mut sums = Octaves::new(Estimator::Strided, Deviation::Allan);
        sums.push(&counts);
        let octaves: Vec<_> = sums.sums().map(|sum| sum.octave()).collect();
        let variances: Vec<_> = sums.sums().filter_map(|sum| sum.variance_counts2()).map(|v| v * 1e-8).collect();
        let shape = RecordShape {
            samples: counts.len() as u64,
            interval_s: 0.005,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        // one value of variance 1 every 1/800 s
        let white = 800_f64.powf(-0.5);
        let window = BoxcarWindow { length: window as u32, decimation: 4.0 };
        let deficit = |window| white_deficit(&octaves, &variances, &shape, white, window);
        assert!(deficit(None) > 3.7, "{}", deficit(None));
        assert!(deficit(Some(window)) < 2.0, "{}", deficit(Some(window)));
    }
}
