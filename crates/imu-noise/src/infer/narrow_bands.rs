//! Narrow bands of high power, for the fit: vibration lines, steady, drifting or swept, with what
//! they add to the Allan variance.

use core::f64::consts::PI;

use super::chi_squared;
use super::spectral_peak::{JOINED, LOWEST, REACH, interpolated, is_folded, passed};
use crate::accumulate::record::Deviation;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::spectrum::Powers;

/// Points on either side in the median that is the noise around a point.
const SIDE: usize = 25;

/// Probability that the noise alone lifts one point above the threshold.
const FALSE_ALARM: f64 = 1e-5;

/// Variance in points² of the power of a line of one frequency under the Hann window is 1/3; wider
/// bands are of a line that drifts.
const STEADY: f64 = 0.6;

/// Uncertainty of an interpolated frequency, in points.
const INTERPOLATED: f64 = 0.1;

/// A narrow band of frequencies with more power than the noise around it has by chance.
#[derive(Clone, Debug, PartialEq)]
pub struct NarrowBand {
    /// Frequencies in cycles per sample, each with its standard deviation and its share of the
    /// power.
    parts: Vec<(f64, f64, f64)>,
    /// Power above the noise, the variance of the line, in the unit of the channel squared.
    pub power: f64,
    /// Density of the noise around it, in the unit squared per cycle per sample, two-sided.
    pub noise_density: f64,
    /// Share of the frequencies up to half the sampling rate that it covers.
    pub share_of_band: f64,
}

impl NarrowBand {
    /// Frequency in cycles per sample: the mean over its power.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        self.parts.iter().map(|(frequency, _, share)| frequency * share).sum()
    }

    /// Whether it reaches within `margin` of `frequency`, both in cycles per sample.
    pub(crate) fn covers(&self, frequency: f64, margin: f64) -> bool {
        self.parts.iter().any(|(part, ..)| (part - frequency).abs() <= margin)
    }

    /// What a line of variance 1 in this band adds to the Allan or Hadamard variance at averaging
    /// factor `m`, and the standard deviation of that: for a sine of frequency f 2 sin⁴(πfm)/(m sin
    /// πf)² and (8/3) sin⁶(πfm)/(m sin πf)², over the uncertainty of the frequency.
    #[must_use]
    pub(crate) fn variance(&self, deviation: Deviation, m: u64) -> (f64, f64) {
        let m = m as f64;
        // By cosines of even multiples of the phase: sin⁴, sin⁸, and sin⁶, sin¹².
        let (factor, power, square): (f64, &[f64], &[f64]) = match deviation {
            Deviation::Allan => (2.0, &[3.0, -4.0, 1.0], &[35.0, -56.0, 28.0, -8.0, 1.0]),
            Deviation::Hadamard => {
                (8.0 / 3.0, &[10.0, -15.0, 6.0, -1.0], &[462.0, -792.0, 495.0, -220.0, 66.0, -12.0, 1.0])
            }
        };
        let of = |(frequency, spread, share): &(f64, f64, f64)| {
            let (phase, spread) = (PI * frequency * m, PI * spread * m);
            // The mean of cos 2kφ over a normal φ.
            let cosine = |k: f64| (2.0 * k * phase).cos() * (-2.0 * (k * spread).powi(2)).exp();
            // The coefficients of a power of the sine are those at φ = π/2, where it is 1.
            let mean = |coefficients: &[f64]| {
                let sum: f64 = coefficients.iter().enumerate().map(|(k, c)| c * cosine(k as f64)).sum();
                sum / coefficients.iter().map(|c| c.abs()).sum::<f64>()
            };
            let scale = factor * share / (m * (PI * frequency).sin()).powi(2);
            let mean_power = mean(power);
            (scale * mean_power, scale * (mean(square) - mean_power * mean_power).max(0.0).sqrt())
        };
        self.parts.iter().map(of).fold((0.0_f64, 0.0_f64), |(mean, spread), part| (mean + part.0, spread.hypot(part.1)))
    }
}

impl ChannelSignal {
    /// The bands of the record in rising frequency: those below 1/64 of the sampling rate from the
    /// spectrum of the sums of 32 samples, those below 1/2048 from that of the sums of 1024, the
    /// others from that of the samples. None of a spectrum before four of its segments are full.
    #[must_use]
    pub fn narrow_bands(&self, unit_per_count: f64) -> Vec<NarrowBand> {
        let full = |powers: Option<Powers>| powers.filter(|powers| powers.segments >= 4);
        let mut bands = full(self.spectrum().powers()).map_or_else(Vec::new, |powers| bands_of(&powers, 1.0));
        for (spectrum, samples) in self.slow_spectra() {
            let Some(powers) = full(spectrum.powers()) else { continue };
            let samples = samples as f64;
            bands.retain(|band| band.frequency() * samples > JOINED);
            // A line above half the rate of the sums is in their spectrum too.
            let reach = (REACH + 1) as f64 / powers.segment_samples as f64;
            let is_of_another = |band: &NarrowBand| {
                let mut parts = bands.iter().flat_map(|band| &band.parts);
                parts.any(|(frequency, ..)| is_folded(*frequency, band.frequency(), samples, reach))
            };
            let mut slow = bands_of(&powers, samples);
            slow.retain(|band| !is_of_another(band));
            bands.splice(..0, slow);
        }
        for band in &mut bands {
            band.power *= unit_per_count * unit_per_count;
            band.noise_density *= unit_per_count * unit_per_count;
        }
        bands
    }
}

/// Bands of the spectrum of sums of `samples` samples each.
fn bands_of(spectrum: &Powers, samples: f64) -> Vec<NarrowBand> {
    let last = spectrum.segment_samples / 2;
    let freedom = 2.0 * spectrum.averages;
    let Some(threshold) = chi_squared::quantile(1.0 - FALSE_ALARM, freedom).map(|quantile| quantile / freedom) else {
        return Vec::new();
    };
    let floors = spectrum.floors(SIDE);
    let high: Vec<usize> =
        (LOWEST..=last).filter(|&k| floors[k] > 0.0 && spectrum.powers[k] > threshold * floors[k]).collect();
    // Points of one band are at most the reach of a line apart.
    let bands = high.chunk_by(|a, b| b - a <= 2 * REACH);
    bands.filter_map(|points| band(spectrum, &floors, points, samples)).collect()
}

fn band(spectrum: &Powers, floors: &[f64], points: &[usize], samples: f64) -> Option<NarrowBand> {
    let n = spectrum.segment_samples as f64;
    let last = spectrum.segment_samples / 2;
    let (first, end) = (*points.first()?, *points.last()?);
    let reach = first.saturating_sub(REACH).max(LOWEST)..=(end + REACH).min(last);
    let above = |k: usize| spectrum.powers[k] - floors[k];
    let sides = |k: usize| if k == last { 1.0 } else { 2.0 };
    let power: f64 = reach.clone().map(|k| sides(k) * above(k)).sum::<f64>() / n;
    let frequency = |point: f64| point / n / samples;
    let peak = points.iter().copied().max_by(|a, b| above(*a).total_cmp(&above(*b)))?;
    let shares: Vec<(f64, f64)> = reach.clone().map(|k| (k as f64, sides(k) * above(k).max(0.0))).collect();
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let mean: f64 = shares.iter().map(|(k, share)| k * share / total).sum();
    let variance: f64 = shares.iter().map(|(k, share)| (k - mean).powi(2) * share / total).sum();
    let parts = if variance < STEADY && peak < last && peak > LOWEST {
        vec![(frequency(interpolated(peak, above)), frequency(INTERPOLATED), 1.0)]
    } else {
        shares.iter().map(|(k, share)| (frequency(*k), frequency(0.5), share / total)).collect()
    };
    let passed: f64 = parts.iter().map(|(f, _, share)| share * passed(*f, samples)).sum();
    Some(NarrowBand {
        parts,
        power: power / (samples * samples) / passed,
        noise_density: floors[peak] / samples,
        share_of_band: reach.count() as f64 / last as f64 / samples,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(frequency: f64, spread: f64) -> NarrowBand {
        let parts = vec![(frequency, spread, 0.25), (frequency, spread, 0.75)];
        NarrowBand { parts, power: 1.0, noise_density: 1.0, share_of_band: 0.01 }
    }

    #[test]
    fn a_line_of_one_frequency_adds_what_its_sine_does() {
        for (frequency, m) in [(0.01, 1), (0.05, 3), (0.05, 16), (0.22, 2), (0.37, 5)] {
            let sine = |times: f64| (PI * frequency * times).sin();
            let under = (m as f64 * sine(1.0)).powi(2);
            for (deviation, expected) in [
                (Deviation::Allan, 2.0 * sine(m as f64).powi(4) / under),
                (Deviation::Hadamard, 8.0 / 3.0 * sine(m as f64).powi(6) / under),
            ] {
                let (mean, spread) = line(frequency, 0.0).variance(deviation, m);
                assert!(
                    (mean - expected).abs() < 1e-12 / under,
                    "{frequency} {m} {deviation:?}: {mean}, not {expected}"
                );
                assert!(spread < 1e-6 / under, "{frequency} {m} {deviation:?}: {spread}");
            }
        }
    }

    /// Of sin⁴ and sin⁶ of any phase the means are 3/8 and 5/16, and the mean squares 35/128 and
    /// 231/1024.
    #[test]
    fn a_line_of_unknown_phase_adds_the_mean_over_all_phases() {
        let under = (PI * 0.05).sin().powi(2);
        for (deviation, factor, power, square) in [
            (Deviation::Allan, 2.0, 3.0 / 8.0, 35.0 / 128.0),
            (Deviation::Hadamard, 8.0 / 3.0, 5.0 / 16.0, 231.0 / 1024.0),
        ] {
            let (mean, spread) = line(0.05, 10.0).variance(deviation, 1);
            assert!((mean * under / factor / power - 1.0_f64).abs() < 1e-12, "{deviation:?}: {mean}");
            let [one, other] = [0.25, 0.75].map(|share| share * factor / under * f64::sqrt(square - power * power));
            assert!((spread / one.hypot(other) - 1.0).abs() < 1e-12, "{deviation:?}: {spread}");
        }
    }
}
