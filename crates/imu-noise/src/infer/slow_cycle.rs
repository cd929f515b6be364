//! A slow cycle of the level, for the fit: what a sine of known phase adds to the variance of
//! octaves, of which it has few periods.

use core::f64::consts::{PI, TAU};

use super::level_noise::Sine;
use crate::accumulate::blocks::Block;
use crate::accumulate::counts::counts_to_unit;
use crate::accumulate::record::{Deviation, RecordShape};

/// A sine in the level of a channel, known as well as the noise allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowCycle {
    /// In cycles per sample, with its standard deviation.
    frequency: (f64, f64),
    /// Of its cosine in the middle of the record, in radians, with its standard deviation.
    phase: (f64, f64),
    /// In the unit of the channel.
    amplitude: f64,
    /// Density of the noise at its frequency, in the unit of the channel squared per cycle per
    /// sample, two-sided.
    pub(crate) noise_density: f64,
}

impl SlowCycle {
    /// `sine`: of the means of `blocks` blocks from `first` on, in the record that `all` make.
    pub(super) fn new(sine: &Sine, first: &Block, blocks: usize, all: &[Block], decimals: u8) -> Self {
        let (length, blocks) = (first.length as f64, blocks as f64);
        let frequency = sine.frequency / length;
        let [cosine, sine_multiple] = sine.multiples;
        let middle = first.first_sample as f64 + length * blocks / 2.0;
        let end = |block: &Block| (block.first_sample + block.count) as f64;
        let (start, end) = (all.first().map_or(0.0, |block| block.first_sample as f64), all.last().map_or(0.0, end));
        let phase = TAU * frequency * ((start + end) / 2.0 - middle) - sine_multiple.atan2(cosine);
        // in cycles per block and radians, of noise of this density per block (Rife and Boorstyn, 1974)
        let amplitude = cosine.hypot(sine_multiple);
        let noise_to_power = sine.density / amplitude.powi(2);
        let frequency_std = (6.0 * noise_to_power / blocks.powi(3)).sqrt() / PI;
        let phase_std = (2.0 * noise_to_power / blocks).sqrt();
        Self {
            frequency: (frequency, frequency_std / length),
            phase: (phase, phase_std),
            amplitude: counts_to_unit(amplitude, decimals),
            noise_density: counts_to_unit(sine.density * length, 2 * decimals),
        }
    }

    /// The same in a unit of which `scale` are one of this.
    #[must_use]
    pub fn scaled(self, scale: f64) -> Self {
        Self { amplitude: self.amplitude * scale.abs(), noise_density: self.noise_density * scale * scale, ..self }
    }

    /// In cycles per sample.
    #[must_use]
    pub const fn frequency(&self) -> f64 {
        self.frequency.0
    }

    /// Half of the way from the lowest to the highest level, in the unit of the channel.
    #[must_use]
    pub const fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// What a cycle of variance 1 adds to the Allan or Hadamard variance of a record at averaging
    /// factor `m`, and the standard deviation of that from what is not known of its frequency and
    /// phase.
    pub(crate) fn variance(&self, shape: &RecordShape, deviation: Deviation, m: u64) -> (f64, f64) {
        let ((frequency, frequency_std), (phase, phase_std)) = (self.frequency, self.phase);
        let at = |frequency: f64, phase: f64| variance(frequency, phase, shape, deviation, m);
        let half = |above: f64, below: f64| (above - below) / 2.0;
        let by_frequency = half(at(frequency + frequency_std, phase), at(frequency - frequency_std, phase));
        let by_phase = half(at(frequency, phase + phase_std), at(frequency, phase - phase_std));
        (at(frequency, phase), by_frequency.hypot(by_phase))
    }

    /// Slope per sample of the regression line over as many samples of a cycle of variance 1.
    pub(crate) fn slope(&self, samples: u64) -> f64 {
        let n = samples as f64;
        let half = PI * self.frequency.0 * n;
        let sine = (half.sin() / half - half.cos()) / half;
        -2_f64.sqrt() * self.phase.0.sin() * 6.0 / n * sine
    }
}

/// Of a sine of variance 1, with this phase in the middle of the record: differences of averages of
/// a cosine are a sine in phase with it, second differences a cosine, and the mean of their squares
/// is taken over the windows.
fn variance(frequency: f64, phase: f64, shape: &RecordShape, deviation: Deviation, m: u64) -> f64 {
    let (half, order) = (PI * frequency * m as f64, deviation.order() as u64);
    let (factor, power, sign) = match deviation {
        Deviation::Allan => (2.0, 4, -1.0),
        Deviation::Hadamard => (8.0 / 3.0, 6, 1.0),
    };
    let windows = shape.samples.saturating_sub(order * m) as f64 + shape.stride(m) as f64;
    let turned = TAU * frequency * windows;
    let mean = if turned == 0.0 { 1.0 } else { turned.sin() / turned };
    let over_any_phase = factor * half.sin().powi(power) / (m as f64 * (PI * frequency).sin()).powi(2);
    over_any_phase * (1.0 + sign * (2.0 * phase).cos() * mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::{Estimator, Octave};
    use crate::infer::confidence::edf;
    use crate::infer::noise_model::{ChannelCurve, NoiseModel, Terms};
    use crate::infer::power_law::PowerLaw;

    #[test]
    fn a_sine_has_the_slope_of_its_samples() {
        for (samples, cycles, phase) in [(24_000_u64, 1.5, 0.7), (2400, 1.0, 2.0), (5000, 2.75, 5.1)] {
            let frequency = cycles / samples as f64;
            let times = (0..samples).map(|i| i as f64 - (samples - 1) as f64 / 2.0);
            let products = times.map(|t| t * 2_f64.sqrt() * (TAU * frequency * t + phase).cos());
            let expected = 12.0 * products.sum::<f64>() / (samples as f64).powi(3);
            let cycle =
                SlowCycle { frequency: (frequency, 0.0), phase: (phase, 0.0), amplitude: 1.0, noise_density: 0.0 };
            assert!((cycle.slope(samples) / expected - 1.0).abs() < 1e-3, "{cycles}");
        }
    }

    #[test]
    fn a_sine_has_the_variances_of_its_samples() {
        for (samples, cycles, phase) in [(24_000_u64, 1.5, 0.7), (24_000, 1.0, 2.0), (5000, 2.75, 5.1)] {
            let frequency = cycles / samples as f64;
            let angle = |i: u64| TAU * frequency * (i as f64 - (samples - 1) as f64 / 2.0) + phase;
            let mut sums = vec![0.0];
            for i in 0..samples {
                sums.push(sums[i as usize] + 2_f64.sqrt() * angle(i).cos());
            }
            for (deviation, signs) in [(Deviation::Allan, &[1.0, -1.0][..]), (Deviation::Hadamard, &[1.0, -2.0, 1.0])] {
                let shape = RecordShape { samples, interval_s: 1.0, estimator: Estimator::Strided, deviation };
                for m in [1_u64, 8, 64, 512, 1024] {
                    let starts = (0..=samples - signs.len() as u64 * m).step_by(shape.stride(m) as usize);
                    let squares: Vec<f64> = starts
                        .map(|start| {
                            let mean = |k: usize| {
                                let from = (start + k as u64 * m) as usize;
                                (sums[from + m as usize] - sums[from]) / m as f64
                            };
                            signs.iter().enumerate().map(|(k, sign)| sign * mean(k)).sum::<f64>().powi(2)
                        })
                        .collect();
                    let expected = squares.iter().sum::<f64>() / squares.len() as f64 / deviation.divisor();
                    let found = variance(frequency, phase, &shape, deviation, m);
                    assert!((found / expected - 1.0).abs() < 1e-2, "{deviation:?} {m}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn intervals_of_octaves_that_a_cycle_lifts_are_those_of_a_walk() {
        let (estimator, deviation) = (Estimator::Strided, Deviation::Allan);
        let shape = RecordShape { samples: 24_000, interval_s: 1.0, estimator, deviation };
        let (frequency, phase) = ((1.5 / 24_000.0, 1e-6), (0.7, 0.05));
        let cycle = SlowCycle { frequency, phase, amplitude: 0.4, noise_density: 1.0 };
        let octaves = shape.octaves();
        let power = cycle.amplitude.powi(2) / 2.0;
        let of = |octave: &Octave| 1.0 / octave.m as f64 + power * cycle.variance(&shape, deviation, octave.m).0;
        let variances: Vec<f64> = octaves.iter().map(of).collect();
        let curve = ChannelCurve { cycle: Some(cycle), ..ChannelCurve::new(&variances, None) };
        let fit = NoiseModel::new(&octaves, &shape, Terms::RATE, None).fit(&curve, 0.95);
        let of_law = |octave: &Octave, law| edf(octave, &shape, law).unwrap();
        let found = |octave: &Octave| fit.edf(octave.m).unwrap();
        for octave in octaves.iter().filter(|octave| octave.m >= 1024 && octave.terms > 2) {
            let walk = of_law(octave, PowerLaw::RandomWalk);
            assert!((0.8..1.6).contains(&(found(octave) / walk)), "{octave:?}: {} and {walk}", found(octave));
        }
        for octave in octaves.iter().filter(|octave| octave.m <= 16) {
            assert!((found(octave) / of_law(octave, PowerLaw::White) - 1.0).abs() < 0.1, "{octave:?}");
        }
    }
}
