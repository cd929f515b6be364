//! Noise of one channel with known truth: white, flicker, walk, ramp, Gauss-Markov processes and vibration lines.

use std::{f64::consts::TAU, num::NonZeroU32};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use crate::gauss_markov::GaussMarkov;
use crate::{
    flicker::flicker,
    gauss_markov::Processes,
    normal::normal,
    onboard::{AveragingWindow, White},
};

/// The truth of one channel, in the unit `u` of the channel: deg, gauss, m/s² or rad/s.
///
/// The default is a channel that is always zero. A component of zero is off. Values are not
/// checked: one that is not finite gives samples that are not finite.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoiseTruth {
    /// Constant mean, u.
    pub mean: f64,
    /// White noise density N, two-sided, u/√Hz: Allan deviation N/√τ, standard deviation of one
    /// sample N·√rate. Angle random walk of a gyroscope, velocity random walk of an accelerometer.
    pub white_density: f64,
    /// Bias instability B, u: flicker of two-sided density B²/(2πf), whose Allan deviation is flat
    /// at √(2 ln 2/π)·B = 0.664 B. It holds within 0.5 % for τ from 16 sample intervals to 10⁵ s
    /// (28 h). At the shortest τ the deviation is higher, as for sampled flicker: 1.19, 1.08, 1.03,
    /// 1.01 times the plateau at m = 1, 2, 4, 8.
    pub bias_instability: f64,
    /// Rate random walk K, u/√s: Allan deviation K·√(τ/3). Starts at zero.
    pub random_walk: f64,
    /// Ramp R, u/s: Allan deviation R·τ/√2. Starts at zero.
    pub ramp: f64,
    /// Noise that is correlated over a time.
    pub processes: Vec<GaussMarkov>,
    /// Vibrations, each at one frequency.
    pub lines: Vec<Vibration>,
    /// Step of the values in a capture, u; 0 for the step of the message alone.
    pub resolution: f64,
}

impl NoiseTruth {
    /// The deterministic part: mean, ramp and lines at a time.
    pub(crate) fn steady(&self, time_s: f64, line_phases_turns: &[f64]) -> f64 {
        let at = |(line, phase_turns): (&Vibration, &f64)| {
            let turns = line.frequency_hz * time_s + phase_turns;
            line.amplitude * (TAU * turns.fract()).sin()
        };
        self.mean + self.ramp * time_s + self.lines.iter().zip(line_phases_turns).map(at).sum::<f64>()
    }

    pub(crate) fn line_phases_turns(&self, mut rng: ChaCha8Rng) -> Vec<f64> {
        self.lines.iter().map(|_| rng.random()).collect()
    }
}

/// A sinusoid; its phase comes from the seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// Peak amplitude, in the unit of the channel; the standard deviation is amplitude/√2.
    pub amplitude: f64,
    /// Frequency in Hz; above half the rate it is aliased, as in a real sensor.
    pub frequency_hz: f64,
}

/// The endless stream of the samples of one channel, in constant memory.
///
/// Every component of every channel has a random stream of its own: changing one component or
/// channel leaves all others unchanged.
#[derive(Debug, Clone)]
pub struct ChannelStream {
    noise: NoiseTruth,
    rate_hz: f64,
    index: u64,
    white: White,
    flicker: Processes,
    walk: RandomWalk,
    processes: Processes,
    line_phases_turns: Vec<f64>,
}

impl ChannelStream {
    /// A stream of samples at `rate_hz`. Channels with equal seeds and different numbers are
    /// independent.
    ///
    /// White noise passes through the on-board `window`. The other components are advanced once per
    /// output sample and do not pass through it: averaging over some milliseconds changes a process
    /// only near the frequency 1/window, and there each of them is far below the white noise.
    pub fn new(noise: &NoiseTruth, window: AveragingWindow, rate_hz: NonZeroU32, seed: u64, channel: u32) -> Self {
        let rng = |component| random_stream(seed, channel, component);
        let interval_s = 1.0 / f64::from(rate_hz.get());
        Self {
            noise: noise.clone(),
            rate_hz: f64::from(rate_hz.get()),
            index: 0,
            white: White::new(noise.white_density, window, rate_hz, rng(NoiseComponent::White)),
            flicker: Processes::new(
                &flicker(noise.bias_instability, interval_s),
                interval_s,
                rng(NoiseComponent::Flicker),
            ),
            walk: RandomWalk::new(noise.random_walk, interval_s, rng(NoiseComponent::Walk)),
            processes: Processes::new(&noise.processes, interval_s, rng(NoiseComponent::Processes)),
            line_phases_turns: noise.line_phases_turns(rng(NoiseComponent::LinePhase)),
        }
    }

    /// The next sample, in the unit of the channel.
    pub fn next_sample(&mut self) -> f64 {
        let time_s = self.index as f64 / self.rate_hz;
        self.index += 1;
        self.white.advance();
        let value = self.noise.steady(time_s, &self.line_phases_turns)
            + self.white.mean()
            + self.flicker.advance()
            + self.walk.advance()
            + self.processes.advance();
        let step = self.noise.resolution;
        if step > 0.0 { (value / step).round() * step } else { value }
    }
}

/// Sum of independent steps; the first sample is zero.
#[derive(Debug, Clone)]
pub(crate) struct RandomWalk {
    step: f64,
    level: f64,
    rng: ChaCha8Rng,
}

impl RandomWalk {
    /// A walk of coefficient K, u/√s, sampled every `interval_s`.
    pub(crate) fn new(coefficient: f64, interval_s: f64, rng: ChaCha8Rng) -> Self {
        Self { step: coefficient * interval_s.sqrt(), level: 0.0, rng }
    }

    pub(crate) fn advance(&mut self) -> f64 {
        let level = self.level;
        if self.step != 0.0 {
            self.level += self.step * normal(&mut self.rng);
        }
        level
    }
}

/// Numbers of the random streams of one channel, on which every capture depends: append only.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NoiseComponent {
    White = 0,
    Flicker = 1,
    Walk = 2,
    LinePhase = 3,
    TurnOnBias = 4,
    Processes = 5,
}

pub(crate) fn random_stream(seed: u64, channel: u32, component: NoiseComponent) -> ChaCha8Rng {
    // room for further components, so that they do not renumber those of the next channel
    const STREAMS_PER_CHANNEL: u64 = 16;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(channel) * STREAMS_PER_CHANNEL + component as u64);
    rng
}

#[cfg(test)]
mod tests;
