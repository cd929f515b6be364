//! Vibration lines of a channel, as they are reported.

use super::chi_squared;
use super::spectral_peak::{JOINED, LOWEST, REACH, interpolated, is_folded, passed, points_on_a_side};
use crate::accumulate::counts::counts_to_unit;
use crate::accumulate::signal::ChannelSignal;
use crate::accumulate::spectrum::Powers;
use schemars::JsonSchema;
use serde::Serialize;

/// Points on either side in the median that is the noise around a point.
const SIDE: usize = 10;

/// Probability that a clean record of twelve channels shows a line in any of the spectra.
const FALSE_ALARM: f64 = 1e-4;
const SPECTRA: f64 = 3.0;

/// A vibration line of one channel.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct SpectralLine {
    /// In Hz, between 0 and half the sampling rate, interpolated between the points.
    pub frequency_hz: f64,
    /// Amplitude of the sine in the unit of the channel (half of peak to peak).
    pub amplitude: f64,
    /// Share of the line in the variance within segments, from 0 to 1.
    pub share_of_variance: f64,
    /// Power of the highest point over the power of the noise around it.
    pub peak_to_floor: f64,
}

impl SpectralLine {
    /// The frequencies in Hz up to `max_hz` that a sensor sampled every `interval_s` seconds
    /// without filter shows at this place, in rising order: f, 1/interval - f, 1/interval + f,
    /// 2/interval - f, ... The samples do not distinguish them.
    pub fn aliases_hz(&self, interval_s: f64, max_hz: f64) -> impl Iterator<Item = f64> {
        let (line_hz, rate_hz) = (self.frequency_hz, 1.0 / interval_s);
        let pairs = (0..).flat_map(move |n| {
            let carrier_hz = f64::from(n) * rate_hz;
            [carrier_hz - line_hz, carrier_hz + line_hz]
        });
        pairs.skip(1).take_while(move |&alias_hz| alias_hz <= max_hz)
    }

    /// What the line adds to the Allan variance at averaging factor `m`, in the unit of the channel
    /// squared, on average over all phases: 3/8 (a/(m sin πf t))², for a sine that is not steady
    /// over many blocks. To the Hadamard variance it adds a ninth more.
    #[must_use]
    pub fn allan_variance(&self, m: u64, interval_s: f64) -> f64 {
        let blocks = m as f64 * (std::f64::consts::PI * self.frequency_hz * interval_s).sin();
        0.375 * (self.amplitude / blocks).powi(2)
    }
}

impl ChannelSignal {
    /// The lines of a channel sampled every `interval_s` seconds with `decimals` digits, in rising
    /// frequency: peaks above the noise around them (a running median) that a clean record of
    /// twelve channels shows with a probability below 1e-4, if its noise is Gaussian and its
    /// spectrum smooth. From the spectra of [`narrow_bands`](Self::narrow_bands), below the same
    /// frequencies; none of a spectrum before four of its segments are full, and where `interval_s`
    /// is not positive.
    #[must_use]
    pub fn lines(&self, interval_s: f64, decimals: u8) -> Vec<SpectralLine> {
        let full = |powers: Option<Powers>| powers.filter(|powers| powers.segments >= 4);
        let Some(spectrum) = full(self.spectrum().powers()).filter(|_| interval_s > 0.0) else { return Vec::new() };
        let total = spectrum.total();
        let mut lines = spectrum.lines(1.0);
        for (spectrum, samples) in self.slow_spectra() {
            let Some(spectrum) = full(spectrum.powers()) else { continue };
            spectrum.join(&mut lines, samples as f64);
        }
        let reported = |Line { frequency, power, peak_to_floor }: Line| SpectralLine {
            frequency_hz: frequency / interval_s,
            amplitude: counts_to_unit((2.0 * power).sqrt(), decimals),
            share_of_variance: power / total,
            peak_to_floor,
        };
        lines.into_iter().map(reported).collect()
    }
}

/// A line, by the samples.
struct Line {
    /// In cycles per sample.
    frequency: f64,
    /// Its variance in counts².
    power: f64,
    peak_to_floor: f64,
}

/// Points of the peaks, and the noise around each.
fn peaks(spectrum: &Powers) -> Vec<(usize, f64)> {
    let last = spectrum.segment_samples / 2;
    let candidates = (last - LOWEST + 1) as f64 * chi_squared::CHANNELS * SPECTRA;
    let freedom = 2.0 * spectrum.averages;
    let Some(quantile) = chi_squared::quantile(1.0 - FALSE_ALARM / candidates, freedom) else { return Vec::new() };
    let threshold = quantile / freedom;
    let mut peaks = Vec::new();
    for (k, floor) in spectrum.floors(SIDE).into_iter().enumerate().skip(LOWEST) {
        let power = spectrum.power(k);
        if (1..=REACH).any(|off| power < spectrum.power(k + off) || power <= spectrum.power(k - off)) {
            continue;
        }
        let points = 2 * points_on_a_side(k, SIDE) + 1;
        // The median of few points is itself uncertain: three standard errors of it, from 1.25 σ/√n of a Gaussian.
        let uncertain = 1.0 + 3.0 * 1.25 / (spectrum.averages * points as f64).sqrt();
        if floor > 0.0 && power > floor * threshold * uncertain {
            peaks.push((k, floor));
        }
    }
    peaks
}

impl Powers {
    /// Variance within segments.
    fn total(&self) -> f64 {
        let sides = |k: usize| if 2 * k == self.segment_samples { 1.0 } else { 2.0 };
        (1..self.powers.len()).map(|k| sides(k) * self.powers[k]).sum::<f64>() / self.segment_samples as f64
    }

    /// Of the spectrum of the sums of so many samples.
    fn lines(&self, samples: f64) -> Vec<Line> {
        peaks(self).into_iter().map(|(k, floor)| self.line(k, floor, samples)).collect()
    }

    /// Puts the lines of this spectrum, of sums of so many samples, in the place of those that it
    /// shows better than the spectrum they are of.
    fn join(&self, lines: &mut Vec<Line>, samples: f64) {
        lines.retain(|line| line.frequency * samples > JOINED);
        let reach = (REACH + 1) as f64 / self.segment_samples as f64;
        let mut slow = self.lines(samples);
        slow.retain(|line| !lines.iter().any(|fast| is_folded(fast.frequency, line.frequency, samples, reach)));
        lines.splice(..0, slow);
    }

    fn line(&self, peak: usize, floor: f64, samples: f64) -> Line {
        let above = |k: usize| (self.power(k) - floor).max(0.0);
        let n = self.segment_samples as f64;
        let frequency = interpolated(peak, above).min(n / 2.0) / n / samples;
        // Points beyond half the sampling rate are the mirror image of those below it, and count once.
        let reach = (peak - REACH)..=(peak + REACH).min(self.segment_samples / 2);
        let sides = |k: usize| if 2 * k == self.segment_samples { 1.0 } else { 2.0 };
        let power: f64 = reach.map(|k| sides(k) * above(k)).sum::<f64>() / n;
        Line {
            frequency,
            power: power / (samples * samples) / passed(frequency, samples),
            peak_to_floor: self.power(peak) / floor,
        }
    }
}
