//! Narrow bands of high power: vibration lines, steady, drifting or swept.
//!
//! The fit excludes every band; those that a clean record hardly ever shows are reported as lines.

use core::f64::consts::PI;

use super::chi_squared;
use super::spectral_lines::SpectralLine;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::spectrum::Powers;

/// Points on either side in the median that is the noise around a point: of a band, which may be wide,
/// and of a line, about which the density may be bent.
const AROUND_BAND: usize = 25;
const AROUND_LINE: usize = 10;

/// Lowest point examined: below, the noise around a point includes the point, and drift leaks in.
const LOWEST: usize = 4;

/// Points on either side that a line of one frequency reaches under the Hann window.
const REACH: usize = 2;

/// Up to so many cycles per sum of samples the spectrum of the sums shows what is slow, beyond that
/// of the samples.
const JOINED: f64 = 0.45;

/// Probability that the noise alone lifts one point above the threshold of a band.
const FALSE_BAND: f64 = 1e-5;

/// Probability that a clean record of twelve channels shows a line in any of the spectra.
const FALSE_LINE: f64 = 1e-4;
const SPECTRA: f64 = 3.0;

/// Variance in points² of the power of a line of one frequency under the Hann window is 1/3; wider
/// bands are of a line that drifts.
const STEADY: f64 = 0.6;

/// Uncertainty of an interpolated frequency, in points.
const INTERPOLATED: f64 = 0.1;

/// A narrow band of frequencies with more power than the noise around it has by chance.
#[derive(Clone, Debug, PartialEq)]
pub struct NarrowBand {
    /// From one frequency to another in cycles per sample, with the share of the power between them.
    pub(super) parts: Vec<(f64, f64, f64)>,
    /// Power above the noise, the variance of the line, in the unit of the channel squared.
    pub power: f64,
    /// Share of the frequencies up to half the sampling rate that it covers.
    pub share_of_band: f64,
    /// The vibration line that is reported of it: its highest point if that is steady, else the whole band.
    /// `None` if twelve channels of a clean record have one as high with a probability of 1e-4 or more.
    pub line: Option<SpectralLine>,
}

impl NarrowBand {
    /// Frequency in cycles per sample: the mean over its power.
    pub fn frequency(&self) -> f64 {
        self.parts.iter().map(|(from, to, share)| 0.5 * (from + to) * share).sum()
    }

    /// Whether it reaches within `margin` of `frequency`, both in cycles per sample.
    pub(super) fn covers(&self, frequency: f64, margin: f64) -> bool {
        self.parts.iter().any(|(from, to, _)| (0.5 * (from + to) - frequency).abs() <= margin)
    }
}

impl ChannelSignal {
    /// The bands of the record in rising frequency: those below 1/64 of the sampling rate from the
    /// spectrum of the sums of 32 samples, those below 1/2048 from that of the sums of 1024, the
    /// others from that of the samples, which lie `interval_s` seconds apart. None of a spectrum before
    /// four of its segments are full.
    pub fn narrow_bands(&self, unit_per_count: f64, interval_s: f64) -> Vec<NarrowBand> {
        let full = |powers: Option<Powers>| powers.filter(|powers| powers.segments >= 4);
        let Some(powers) = full(self.spectrum().powers()) else { return Vec::new() };
        let sides = |k: usize| if 2 * k == powers.segment_samples { 1.0 } else { 2.0 };
        let total = (1..powers.powers.len()).map(|k| sides(k) * powers.powers[k]).sum::<f64>();
        let total = total / powers.segment_samples as f64;
        let mut bands = bands_of(&powers, 1.0);
        for (spectrum, samples) in self.slow_spectra() {
            let Some(powers) = full(spectrum.powers()) else { continue };
            let samples = samples as f64;
            bands.retain(|band| band.frequency() * samples > JOINED);
            // A line above half the rate of the sums is in their spectrum too.
            let reach = (REACH + 1) as f64 / powers.segment_samples as f64;
            let is_of_another = |band: &NarrowBand| {
                let mut parts = bands.iter().flat_map(|band| &band.parts);
                parts.any(|(from, to, _)| is_folded(0.5 * (from + to), band.frequency(), samples, reach))
            };
            let mut slow = bands_of(&powers, samples);
            slow.retain(|band| !is_of_another(band));
            bands.splice(..0, slow);
        }
        for band in &mut bands {
            band.power *= unit_per_count * unit_per_count;
            if let Some(line) = &mut band.line {
                line.share_of_variance /= total;
                line.amplitude *= unit_per_count.abs();
                line.frequency_hz /= interval_s;
            }
        }
        bands
    }
}

/// Bands of the spectrum of sums of `samples` samples each.
fn bands_of(spectrum: &Powers, samples: f64) -> Vec<NarrowBand> {
    let last = spectrum.segment_samples / 2;
    let freedom = 2.0 * spectrum.averages;
    let threshold = |p: f64| chi_squared::quantile(1.0 - p, freedom).map(|quantile| quantile / freedom);
    let candidates = (last - LOWEST + 1) as f64 * chi_squared::CHANNELS * SPECTRA;
    let Some((of_band, of_line)) = threshold(FALSE_BAND).zip(threshold(FALSE_LINE / candidates)) else {
        return Vec::new();
    };
    let floors = [AROUND_BAND, AROUND_LINE].map(|most| spectrum.floors(most));
    let [of_bands, _] = &floors;
    let high: Vec<usize> =
        (LOWEST..=last).filter(|&k| of_bands[k] > 0.0 && spectrum.powers[k] > of_band * of_bands[k]).collect();
    // Points of one band are at most the reach of a line apart.
    let bands = high.chunk_by(|a, b| b - a <= 2 * REACH);
    bands.filter_map(|points| band(spectrum, &floors, points, samples, of_line)).collect()
}

fn band(
    spectrum: &Powers,
    [floors, of_lines]: &[Vec<f64>; 2],
    points: &[usize],
    samples: f64,
    of_line: f64,
) -> Option<NarrowBand> {
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
    let about = |point: f64, off: f64, share: f64| (frequency(point - off), frequency(point + off), share);
    let parts = if variance < STEADY && peak < last && peak > LOWEST {
        vec![about(interpolated(peak, above), INTERPOLATED, 1.0)]
    } else {
        shares.iter().map(|(k, share)| about(*k, 0.5, share / total)).collect()
    };
    let passed: f64 = parts.iter().map(|(from, to, share)| share * passed(0.5 * (from + to), samples)).sum();
    // The median of few points is itself uncertain: three standard errors of it, from 1.25 σ/√n of a Gaussian.
    let around = (2 * AROUND_LINE.min(peak - 1) + 1) as f64;
    let uncertain = 1.0 + 3.0 * 1.25 / (spectrum.averages * around).sqrt();
    let power = power / (samples * samples) / passed;
    let peak_to_floor = spectrum.powers[peak] / of_lines[peak];
    let (frequency, line_power) = if variance < STEADY || peak == last {
        steady_line(spectrum, of_lines[peak], peak, samples)
    } else {
        (frequency(mean), power)
    };
    // in counts, cycles per sample and of the power, until all bands are known
    let amplitude = (2.0 * line_power).sqrt();
    let line = SpectralLine { frequency_hz: frequency, amplitude, share_of_variance: line_power, peak_to_floor };
    Some(NarrowBand {
        parts,
        power,
        share_of_band: reach.count() as f64 / last as f64 / samples,
        line: Some(line).filter(|_| peak_to_floor.is_finite() && peak_to_floor > of_line * uncertain),
    })
}

/// Frequency in cycles per sample and variance of the line whose highest point is `peak`.
fn steady_line(spectrum: &Powers, floor: f64, peak: usize, samples: f64) -> (f64, f64) {
    let n = spectrum.segment_samples as f64;
    let last = spectrum.segment_samples / 2;
    let above = |k: usize| (spectrum.power(k) - floor).max(0.0);
    let frequency = interpolated(peak, above).min(n / 2.0) / n / samples;
    // Points beyond half the sampling rate are the mirror image of those below it, and count once.
    let sides = |k: usize| if k == last { 1.0 } else { 2.0 };
    let power = (peak - REACH..=(peak + REACH).min(last)).map(|k| sides(k) * above(k)).sum::<f64>() / n;
    (frequency, power / (samples * samples) / passed(frequency, samples))
}

impl Powers {
    /// The power at point k, mirrored about half the sampling rate as every sampled spectrum is.
    fn power(&self, k: usize) -> f64 {
        let last = self.segment_samples / 2;
        self.powers[if k > last { 2 * last - k } else { k }]
    }

    /// For each point the median of those up to `most` points away, as many on either side, so that a
    /// slope cancels. Infinite below [`LOWEST`].
    fn floors(&self, most: usize) -> Vec<f64> {
        let last = self.segment_samples / 2;
        let mut floors = vec![f64::INFINITY; LOWEST.min(last + 1)];
        // in rising order: from point 1 on at first, then as many on either side
        let mut around: Vec<f64> = Vec::with_capacity(2 * most + 2);
        let place = |around: &[f64], power: f64| around.partition_point(|other| other.total_cmp(&power).is_lt());
        let mut end = 1;
        for k in LOWEST..=last {
            let side = most.min(k - 1);
            while end <= k + side {
                let power = self.power(end);
                around.insert(place(&around, power), power);
                end += 1;
            }
            if around.len() > 2 * side + 1 {
                around.remove(place(&around, self.power(k - side - 1)));
            }
            floors.push(around[side]);
        }
        floors
    }
}

/// Where the line of the highest point `peak` lies, in points, by the power `above` the noise.
///
/// Grandke (1983): of a line at k + δ the Hann window passes to k and k + 1 amplitudes in the ratio
/// (1 + δ)/(2 - δ).
fn interpolated(peak: usize, above: impl Fn(usize) -> f64) -> f64 {
    let (below, here, beyond) = (above(peak - 1).max(0.0), above(peak), above(peak + 1).max(0.0));
    let ratio = (below.max(beyond) / here).sqrt();
    let off = ((2.0 * ratio - 1.0) / (ratio + 1.0)).max(0.0);
    peak as f64 + if beyond >= below { off } else { -off }
}

/// Whether a line at `fast` cycles per sample lies at `slow` in the spectrum of the sums of so many
/// samples, folded, within `reach` cycles per sum.
fn is_folded(fast: f64, slow: f64, samples: f64, reach: f64) -> bool {
    let cycles = fast * samples;
    ((cycles - cycles.round()).abs() - slow * samples).abs() < reach
}

/// Share of the power of a line that the means over so many samples have.
fn passed(frequency: f64, samples: f64) -> f64 {
    let phase = PI * frequency;
    ((phase * samples).sin() / (samples * phase.sin())).powi(2)
}
