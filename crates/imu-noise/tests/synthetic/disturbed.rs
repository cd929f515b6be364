//! Clean records of known noise, the same with a disturbance, and their findings.

use std::f64::consts::{PI, TAU};

use imu_noise::{ChannelSignal, LevelChange, LevelSearch, LevelShape, SpectrumPlan};

use crate::synthetic::Random;

pub(crate) const RATE_HZ: f64 = 40.0;
const INTERVAL_S: f64 = 1.0 / RATE_HZ;

/// Amplitudes relative to white noise of standard deviation 1, drawn log-uniformly for each channel.
pub(crate) struct Noise {
    pub(crate) name: &'static str,
    flicker: Option<(f64, f64)>,
    step: Option<(f64, f64)>,
}

pub(crate) const NOISES: [Noise; 3] = [
    Noise { name: "white", flicker: None, step: None },
    Noise { name: "white + flicker", flicker: Some((0.02, 0.5)), step: None },
    Noise { name: "white + walk", flicker: None, step: Some((1e-4, 1e-2)) },
];

/// Counts per standard deviation of white noise, from less than the last digit on: one value for
/// each channel.
const COUNTS: [f64; 4] = [0.6, 3.0, 30.0, 1000.0];

/// The disturbance added to a clean record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Disturbance {
    /// Ringing at 2 to 18 Hz for a second, with an amplitude of 5 standard deviations of the white
    /// noise.
    Slam,
    /// Half a sine of one second, with the same amplitude.
    Push,
    /// A sine at 1 to 19.5 Hz throughout, with an amplitude of half a standard deviation.
    Line,
    /// The same only in the last quarter of the record.
    LateLine,
    /// A level that relaxes from the start on, and begins with an offset of this many standard
    /// deviations of the clean record's block means.
    WarmUp { sigmas: f64, time_constant_s: f64 },
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Findings {
    pub(crate) lines_hz: Vec<f64>,
    /// Start and end in seconds.
    pub(crate) disturbances_s: Vec<(f64, f64)>,
    pub(crate) change: Option<LevelChange>,
}

fn lines_hz(signal: &ChannelSignal) -> Vec<f64> {
    let lines = signal.narrow_bands(1.0, INTERVAL_S).into_iter().filter_map(|band| band.line);
    lines.map(|line| line.frequency_hz).collect()
}

impl Findings {
    pub(crate) fn of(counts: &[i32], plan: &SpectrumPlan) -> Self {
        let mut signal = ChannelSignal::new(plan);
        signal.push(counts);
        Self {
            lines_hz: lines_hz(&signal),
            disturbances_s: signal.disturbances(INTERVAL_S).iter().map(|found| (found.start_s, found.end_s)).collect(),
            change: LevelSearch::of([&signal]).find(&signal, INTERVAL_S, 0).change,
        }
    }

    /// The skip of a warm-up, if there is one.
    pub(crate) fn warm_up_skip_s(&self) -> Option<Option<f64>> {
        match self.change?.shape {
            LevelShape::WarmUp { skip_s, .. } => Some(skip_s),
            LevelShape::Step { .. } | LevelShape::Cycle { .. } => None,
        }
    }

    pub(crate) fn is_clean(&self) -> bool {
        self.lines_hz.is_empty() && self.disturbances_s.is_empty() && self.change.is_none()
    }
}

/// One channel in units of its white noise.
pub(crate) struct Channel {
    values: Vec<f64>,
    /// Counts per unit.
    counts: f64,
}

impl Channel {
    pub(crate) fn new(
        noise: &Noise,
        number: usize,
        (white, flicker, walk): &(Vec<f64>, Vec<f64>, Vec<f64>),
        random: &mut Random,
    ) -> Self {
        let mut draw = |range: Option<(f64, f64)>| {
            range.map_or(0.0, |(low, high): (f64, f64)| low * (high / low).powf(random.uniform()))
        };
        let (flicker_amplitude, step) = (draw(noise.flicker), draw(noise.step));
        let samples = white.iter().zip(flicker).zip(walk);
        let values =
            samples.map(|((white, flicker), walk)| white + flicker_amplitude * flicker + step * walk).collect();
        Self { values, counts: COUNTS[number % COUNTS.len()] }
    }

    pub(crate) fn clean(&self) -> Vec<i32> {
        self.counts(|_| 0.0)
    }

    /// Whether the disturbance is found at its place, in a copy of the record.
    pub(crate) fn shows(&self, disturbance: Disturbance, plan: &SpectrumPlan, random: &mut Random) -> bool {
        let samples = self.values.len();
        let start = ((0.05 + 0.9 * random.uniform()) * samples as f64) as usize;
        let time_s = |i: usize| i as f64 * INTERVAL_S;
        let start_s = time_s(start);
        let phase = TAU * random.uniform();
        let (slam_hz, line_hz) = (2.0 + 16.0 * random.uniform(), 1.0 + 18.5 * random.uniform());
        let second = start..start + RATE_HZ as usize;
        let sine = |i: usize, hz: f64| (TAU * hz * time_s(i) + phase).sin();
        let find = |value: &dyn Fn(usize) -> f64| Findings::of(&self.counts(value), plan);
        let overlaps = |found: &Findings| {
            found.disturbances_s.iter().any(|&(from_s, to_s)| from_s < start_s + 1.0 && to_s > start_s)
        };
        let at_line = |found: &Findings| found.lines_hz.iter().any(|hz| (hz - line_hz).abs() < 0.05);
        match disturbance {
            Disturbance::Slam => overlaps(&find(&|i| if second.contains(&i) { 5.0 * sine(i, slam_hz) } else { 0.0 })),
            Disturbance::Push => {
                let push = |i: usize| 5.0 * (PI * (time_s(i) - start_s)).sin();
                overlaps(&find(&|i| if second.contains(&i) { push(i) } else { 0.0 }))
            }
            Disturbance::Line => at_line(&find(&|i| 0.5 * sine(i, line_hz))),
            Disturbance::LateLine => {
                at_line(&find(&|i| if i >= samples / 4 * 3 { 0.5 * sine(i, line_hz) } else { 0.0 }))
            }
            Disturbance::WarmUp { sigmas, time_constant_s } => {
                let counts = self.warmed_up(sigmas, time_constant_s, plan);
                let skip_s = Findings::of(&counts, plan).warm_up_skip_s();
                // Without the part to be skipped it must disappear.
                let cured = |skip_s: f64| Findings::of(&counts[(skip_s * RATE_HZ) as usize..], plan);
                skip_s.is_some_and(|skip_s| skip_s.is_none_or(|skip_s| cured(skip_s).warm_up_skip_s().is_none()))
            }
        }
    }

    /// The channel with a level that relaxes from this many standard deviations of the block means.
    pub(crate) fn warmed_up(&self, sigmas: f64, time_constant_s: f64, plan: &SpectrumPlan) -> Vec<i32> {
        let amplitude = sigmas * self.block_mean_std(plan);
        self.counts(|i| amplitude * (-(i as f64) * INTERVAL_S / time_constant_s).exp())
    }

    fn counts(&self, disturbance: impl Fn(usize) -> f64) -> Vec<i32> {
        let value = |(i, value): (usize, &f64)| (self.counts * (value + disturbance(i))).round() as i32;
        self.values.iter().enumerate().map(value).collect()
    }

    fn block_mean_std(&self, plan: &SpectrumPlan) -> f64 {
        let mut signal = ChannelSignal::new(plan);
        signal.push(&self.clean());
        let means: Vec<_> = signal.blocks().iter().map(|block| block.mean_counts / self.counts).collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        (means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
    }
}
