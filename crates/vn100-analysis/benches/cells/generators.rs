//! Series of known noise, in standard deviations of the white part.

use std::{
    collections::VecDeque,
    f64::consts::{PI, TAU},
    sync::Arc,
};

use realfft::{ComplexToReal, RealFftPlanner, num_complex::Complex};

use super::random::Random;

/// Refreshes of the sensor from one output to the next.
const REFRESHES: u32 = 20;

/// The white part, with a density of 1/√rate at low frequencies but for tails and spikes, which
/// add to it.
#[derive(Clone, Copy)]
pub(crate) enum White {
    None,
    Gaussian,
    Student5,
    Laplace,
    /// Gaussian, with a value moved by `height` up or down at this probability.
    Spikes {
        probability: f64,
        height: f64,
    },
    /// Averages over so many refreshes, one output in [`REFRESHES`].
    Window(u32),
    /// A Butterworth low pass, its corner over the rate.
    LowPass {
        order: u8,
        corner: f64,
    },
    /// Gaussian, its standard deviation up and down by this share, once in this part of the record.
    Modulated {
        depth: f64,
        period: f64,
    },
    /// A sensor's own low pass at 0.32 of the refresh rate, then averages over four refreshes, all
    /// of them sent.
    EveryRefresh,
}

/// What is added to the white part.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    /// With this B.
    Flicker(f64),
    /// With steps of this standard deviation.
    Walk(f64),
    /// Over the whole record.
    Ramp(f64),
    /// First order, stationary.
    GaussMarkov { time_s: f64, deviation: f64 },
    /// A sine that has this share in the variance of white part and line.
    Line { hz: f64, share: f64, drift: Drift },
    /// White noise through a resonance of this quality, stationary.
    Resonance { hz: f64, quality: f64, deviation: f64 },
    /// Two levels, apart by twice the deviation, each for this time in the mean.
    Popcorn { dwell_s: f64, deviation: f64 },
    /// A level that decays from this deviation with this time.
    WarmUp { time_s: f64, deviation: f64 },
    /// A slow sine, the same in all channels but for the sign, with the temperature.
    Cycle { period_s: f64, deviation: f64 },
}

/// How the frequency of a line moves.
#[derive(Clone, Copy)]
pub(crate) enum Drift {
    None,
    /// Linearly, by this share over the record.
    Once(f64),
    /// Up and down within this share, six times.
    Swept(f64),
}

impl White {
    /// In the density at low frequencies.
    pub(crate) fn variance(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Spikes { probability, height } => 1.0 + probability * height * height,
            _ => 1.0,
        }
    }

    pub(crate) fn series(self, samples: usize, random: &mut Random) -> Vec<f64> {
        let each = |value: fn(&mut Random) -> f64, random: &mut Random| (0..samples).map(|_| value(random)).collect();
        match self {
            Self::None => vec![0.0; samples],
            Self::Gaussian => each(Random::normal, random),
            Self::Student5 => each(Random::student5, random),
            Self::Laplace => each(Random::laplace, random),
            Self::Spikes { probability, height } => (0..samples)
                .map(|_| {
                    let spike = if random.uniform() < probability { height * random.sign() } else { 0.0 };
                    random.normal() + spike
                })
                .collect(),
            Self::Window(length) => window(length, samples, random),
            Self::LowPass { order, corner } => low_passed(order, corner, samples, random),
            Self::Modulated { depth, period } => {
                let share = |i: usize| 1.0 + depth * (TAU * i as f64 / (period * samples as f64)).sin();
                // of a part of a period the mean is not that of a whole one
                let mean_square = (0..samples).map(|i| share(i).powi(2)).sum::<f64>() / samples as f64;
                (0..samples).map(|i| share(i) / mean_square.sqrt() * random.normal()).collect()
            }
            Self::EveryRefresh => {
                let refreshes = low_passed(2, 0.32, samples + 3, random);
                refreshes.windows(4).map(|averaged| averaged.iter().sum::<f64>() / 4.0).collect()
            }
        }
    }
}

/// Refreshes that all windows share or none are one number.
fn window(length: u32, samples: usize, random: &mut Random) -> Vec<f64> {
    let shared = greatest_divisor(length, REFRESHES);
    let deviation = f64::from(shared).sqrt();
    let mut inside: VecDeque<f64> = (0..length / shared).map(|_| deviation * random.normal()).collect();
    // the autocovariance of the outputs, summed over all distances, is that of the density
    let overlaps = (1..).map(|apart| length.saturating_sub(apart * REFRESHES)).take_while(|overlap| *overlap > 0);
    let summed = f64::from(length + 2 * overlaps.sum::<u32>());
    let outputs = (0..samples).map(|_| {
        for _ in 0..REFRESHES / shared {
            inside.pop_front();
            inside.push_back(deviation * random.normal());
        }
        inside.iter().sum::<f64>() / summed.sqrt()
    });
    outputs.collect()
}

fn greatest_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}

/// White noise through a Butterworth low pass of any order, by sections of first and second order.
fn low_passed(order: u8, corner: f64, samples: usize, random: &mut Random) -> Vec<f64> {
    let mut series: Vec<f64> = (0..samples + LowPass::SETTLED).map(|_| random.normal()).collect();
    for section in LowPass::sections(order, corner) {
        section.filter(&mut series);
    }
    series.split_off(LowPass::SETTLED)
}

/// A section of a Butterworth low pass, by the bilinear transform, with unit gain at zero frequency.
pub(crate) struct LowPass {
    forward: [f64; 3],
    back: [f64; 2],
}

impl LowPass {
    /// Samples until a start from rest is forgotten.
    const SETTLED: usize = 400;

    pub(crate) fn sections(order: u8, corner: f64) -> Vec<Self> {
        let k = (PI * corner).tan();
        let mut sections = Vec::new();
        if order % 2 == 1 {
            let gain = k / (1.0 + k);
            sections.push(Self { forward: [gain, gain, 0.0], back: [(k - 1.0) / (k + 1.0), 0.0] });
        }
        for pair in 0..order / 2 {
            // the angle of the pair of poles from the negative real axis
            let angle = PI * f64::from(2 * pair + 1 + order % 2) / f64::from(2 * order);
            let root = 2.0 * k * angle.cos();
            let scale = 1.0 / (1.0 + root + k * k);
            let gain = k * k * scale;
            let back = [2.0 * (k * k - 1.0) * scale, (1.0 - root + k * k) * scale];
            sections.push(Self { forward: [gain, 2.0 * gain, gain], back });
        }
        sections
    }

    fn filter(&self, series: &mut [f64]) {
        let ([f0, f1, f2], [b1, b2]) = (self.forward, self.back);
        // the transposed direct form
        let (mut first, mut second) = (0.0, 0.0);
        for value in series {
            let input = *value;
            *value = f0 * input + first;
            first = f1 * input - b1 * *value + second;
            second = f2 * input - b2 * *value;
        }
    }

    /// The squared gain at this frequency over the rate.
    pub(crate) fn squared_gain(&self, frequency: f64) -> f64 {
        let at = |c0: f64, c1: f64, c2: f64| {
            let turn = |power: f64| Complex::from_polar(1.0, -TAU * frequency * power);
            (turn(0.0) * c0 + turn(1.0) * c1 + turn(2.0) * c2).norm_sqr()
        };
        let ([f0, f1, f2], [b1, b2]) = (self.forward, self.back);
        at(f0, f1, f2) / at(1.0, b1, b2)
    }
}

impl Part {
    /// `cycle_phase` is that of slow cycles.
    pub(crate) fn add_to(
        self,
        series: &mut [f64],
        rate_hz: f64,
        flicker: &Flicker,
        cycle_phase: f64,
        random: &mut Random,
    ) {
        let samples = series.len() as f64;
        match self {
            Self::Flicker(b) => {
                series.iter_mut().zip(flicker.series(random)).for_each(|(sum, value)| *sum += b * value)
            }
            Self::Walk(step) => {
                let mut level = 0.0;
                for sum in series {
                    level += step * random.normal();
                    *sum += level;
                }
            }
            Self::Ramp(total) => {
                series.iter_mut().enumerate().for_each(|(i, sum)| *sum += total * i as f64 / samples);
            }
            Self::GaussMarkov { time_s, deviation } => {
                let memory = (-1.0 / (time_s * rate_hz)).exp();
                let kick = deviation * (1.0 - memory * memory).sqrt();
                let mut level = deviation * random.normal();
                for sum in series {
                    *sum += level;
                    level = memory * level + kick * random.normal();
                }
            }
            Self::Line { hz, share, drift } => {
                let amplitude = (2.0 * share / (1.0 - share)).sqrt();
                let mut phase = random.uniform();
                for (i, sum) in series.iter_mut().enumerate() {
                    *sum += amplitude * (TAU * phase).sin();
                    let hz = hz * (1.0 + drift.at(i as f64 / samples));
                    phase = (phase + hz / rate_hz).fract();
                }
            }
            Self::Resonance { hz, quality, deviation } => {
                let [first, second, kick] = resonance(hz / rate_hz, quality);
                let (mut last, mut before) = (0.0, 0.0);
                // until the start from rest is forgotten
                let settled = (10.0 * quality * rate_hz / hz) as usize;
                let mut next = || {
                    let value = first * last + second * before + kick * random.normal();
                    before = std::mem::replace(&mut last, value);
                    value
                };
                (0..settled).for_each(|_| {
                    next();
                });
                series.iter_mut().for_each(|sum| *sum += deviation * next());
            }
            Self::Popcorn { dwell_s, deviation } => {
                let changes = 1.0 - (-1.0 / (dwell_s * rate_hz)).exp();
                let mut level = deviation * random.sign();
                for sum in series {
                    *sum += level;
                    if random.uniform() < changes {
                        level = -level;
                    }
                }
            }
            Self::WarmUp { time_s, deviation } => {
                let start = deviation * random.sign();
                let level = |i: usize| start * (-(i as f64) / (time_s * rate_hz)).exp();
                series.iter_mut().enumerate().for_each(|(i, sum)| *sum += level(i));
            }
            Self::Cycle { period_s, deviation } => {
                let amplitude = 2_f64.sqrt() * deviation * random.sign();
                let cycle = |i: usize| (TAU * (i as f64 / (rate_hz * period_s) + cycle_phase)).sin();
                series.iter_mut().enumerate().for_each(|(i, sum)| *sum += amplitude * cycle(i));
            }
        }
    }
}

/// The two coefficients of the recursion of a resonance at this frequency over the rate, and the
/// standard deviation of its input for an output of 1.
pub(crate) fn resonance(frequency: f64, quality: f64) -> [f64; 3] {
    let radius = (-PI * frequency / quality).exp();
    let (first, second) = (2.0 * radius * (TAU * frequency).cos(), -radius * radius);
    // the variance of an autoregressive process of second order (Box and Jenkins, 1970)
    let variance = (1.0 - second) / ((1.0 + second) * ((1.0 - second).powi(2) - first * first));
    [first, second, variance.recip().sqrt()]
}

impl Drift {
    /// From the frequency in the middle, relative; `at` from 0 to 1 over the record.
    fn at(self, at: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Once(share) => share * (at - 0.5),
            Self::Swept(share) => {
                let turn = (6.0 * at).fract();
                share * (0.5 - (2.0 * turn - 1.0).abs())
            }
        }
    }
}

/// Flicker noise with B = 1: the running sum of (1 - L)^(1/2) w by circulant embedding (Davies and
/// Harte, 1987).
pub(crate) struct Flicker {
    samples: usize,
    /// Standard deviations of the coefficients.
    deviations: Vec<f64>,
    transform: Arc<dyn ComplexToReal<f64>>,
}

impl Flicker {
    pub(crate) fn new(samples: usize) -> Self {
        let size = 2 * samples;
        let mut planner = RealFftPlanner::new();
        let mut circle = vec![0.0; size];
        let mut covariance = 4.0 / PI;
        for k in 0..=samples {
            circle[k] = covariance;
            circle[(size - k) % size] = covariance;
            covariance *= (k as f64 - 0.5) / (k as f64 + 1.5);
        }
        let forward = planner.plan_fft_forward(size);
        let mut powers = forward.make_output_vec();
        forward.process(&mut circle, &mut powers).unwrap();
        let deviations = powers.iter().map(|power| (power.re.max(0.0) / size as f64).sqrt()).collect();
        Self { samples, deviations, transform: planner.plan_fft_inverse(size) }
    }

    fn series(&self, random: &mut Random) -> Vec<f64> {
        let last = self.deviations.len() - 1;
        let coefficient = |(k, deviation): (usize, &f64)| match k {
            _ if k == 0 || k == last => Complex::new(deviation * random.normal(), 0.0),
            _ => Complex::new(random.normal(), random.normal()) * (deviation / 2_f64.sqrt()),
        };
        let mut coefficients: Vec<_> = self.deviations.iter().enumerate().map(coefficient).collect();
        let mut values = self.transform.make_output_vec();
        self.transform.process(&mut coefficients, &mut values).unwrap();
        values.truncate(self.samples);
        let mut sum = 0.0;
        for value in &mut values {
            sum += *value;
            *value = sum;
        }
        values
    }
}

/// Which rows arrive.
#[derive(Clone, Copy)]
pub(crate) enum Loss {
    /// Each is lost with this probability.
    Random(f64),
    /// As many, in runs of one second in the mean.
    Bunched(f64),
}

impl Loss {
    pub(crate) fn kept(self, samples: usize, random: &mut Random) -> Vec<bool> {
        const RUN: f64 = 40.0;
        match self {
            Self::Random(share) => (0..samples).map(|_| random.uniform() >= share).collect(),
            Self::Bunched(share) => {
                let begins = share / ((1.0 - share) * RUN);
                let mut is_lost = false;
                let rows = (0..samples).map(|_| {
                    is_lost = random.uniform() < if is_lost { 1.0 - 1.0 / RUN } else { begins };
                    !is_lost
                });
                rows.collect()
            }
        }
    }
}
