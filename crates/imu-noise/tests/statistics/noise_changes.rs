//! Changes of noise are found at their place, and tails, walks and coarse channels are no change.

use imu_noise::{ChannelSignal, Histogram, LevelSearch, NoiseChanges, SpectrumPlan};

use crate::synthetic::Random;

const INTERVAL_S: f64 = 0.025;
const SAMPLES: usize = 24_000;

/// Counts per standard deviation.
const COUNTS: f64 = 100.0;

/// Records without a spike.
const CLEAN: u64 = 300;

#[derive(Clone, Copy, Debug)]
enum Tails {
    Normal,
    /// Student's t with five degrees of freedom.
    Student,
    Laplace,
}

impl Tails {
    /// Standard deviation 1.
    fn value(self, random: &mut Random) -> f64 {
        match self {
            Self::Normal => normal(random),
            Self::Student => {
                let squares: f64 = (0..5).map(|_| normal(random).powi(2)).sum();
                normal(random) * (3.0 / squares).sqrt()
            }
            Self::Laplace => {
                let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
                sign * -(1.0 - random.uniform()).ln() / 2_f64.sqrt()
            }
        }
    }
}

/// From the sine of a random phase (Box and Muller, 1958).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.uniform()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.uniform()).sin()
}

struct Channel {
    signal: ChannelSignal,
    histogram: Histogram,
}

impl Channel {
    fn of(counts: &[i32]) -> Self {
        let mut channel = Self { signal: ChannelSignal::new(&SpectrumPlan::new()), histogram: Histogram::new() };
        channel.signal.push(counts);
        channel.histogram.push(counts);
        channel
    }

    fn changes(&self) -> NoiseChanges {
        self.signal.noise_changes(&self.histogram, INTERVAL_S)
    }
}

/// White noise, each value changed by `change(place, value)`.
fn channel(seed: u64, tails: Tails, change: impl Fn(usize, f64) -> f64) -> Channel {
    channel_of(SAMPLES, seed, tails, change)
}

fn channel_of(samples: usize, seed: u64, tails: Tails, change: impl Fn(usize, f64) -> f64) -> Channel {
    let mut random = Random(seed);
    let value = |i: usize| (COUNTS * change(i, tails.value(&mut random))).round() as i32;
    Channel::of(&(0..samples).map(value).collect::<Vec<_>>())
}

const TAILS: [Tails; 3] = [Tails::Normal, Tails::Student, Tails::Laplace];

#[test]
fn louder_noise_is_found_from_its_beginning() {
    for tails in TAILS {
        let half = |i: usize, value: f64| if i < SAMPLES / 2 { value } else { 1.2 * value };
        let changes = channel(1, tails, half).changes();
        let change = changes.change.unwrap_or_else(|| panic!("{tails:?}: {changes:?}"));
        assert!((change.start_s - 300.0).abs() < 20.0 && change.end_s >= 590.0, "{tails:?} {change:?}");
        assert!((change.factor - 1.2).abs() < 0.06, "{tails:?} {change:?}");
    }
}

#[test]
fn louder_noise_for_a_while_is_found_with_its_length() {
    let while_it_lasts = |i: usize, value: f64| if (8000..8800).contains(&i) { 2.0 * value } else { value };
    for tails in TAILS {
        let change = channel(2, tails, while_it_lasts).changes().change.unwrap();
        // blocks of 6.4 s
        assert!((change.start_s - 200.0).abs() < 6.5 && (change.end_s - 220.0).abs() < 6.5, "{tails:?} {change:?}");
        assert!(change.factor > 1.6 && change.factor < 2.2, "{tails:?} {change:?}");
    }
}

#[test]
fn a_frozen_channel_is_found_for_as_long_as_it_is() {
    let frozen = |i: usize, value: f64| if (8000..8200).contains(&i) { 0.25 } else { value };
    for tails in TAILS {
        let found = channel(3, tails, frozen).changes().frozen.unwrap();
        assert!(found.start_s <= 200.0 && found.end_s >= 204.0 && found.end_s - found.start_s < 20.0, "{found:?}");
        // five seconds are five or six windows of 0.8 s
        assert!(found.duration_s > 3.9 && found.duration_s < 5.1, "{found:?}");
    }
}

#[test]
fn spikes_are_counted_and_heavy_tails_are_none() {
    let spiked = |i: usize, value: f64| if i % 1200 == 600 { value + 9.0 } else { value };
    let spikes = channel(4, Tails::Normal, spiked).changes().spikes.unwrap();
    assert!((18..=20).contains(&spikes.count) && spikes.sigmas > 9.0, "{spikes:?}");
    for tails in TAILS {
        assert_eq!(channel(4, tails, |_, value| value).changes().spikes, None, "{tails:?}");
    }
}

#[test]
fn one_sample_far_out_is_found_and_the_farthest_of_a_tail_is_none() {
    for (seed, samples) in (0..).zip([600, 1300, 5000, 20_000]) {
        let glitch = |i: usize, value: f64| if i == samples / 2 { value + 40.0 } else { value };
        let found = channel_of(samples, seed, Tails::Normal, glitch).changes().spikes.unwrap();
        assert!(found.count == 1 && (found.sigmas - 40.0).abs() < 8.0, "{samples} samples: {found:?}");
    }
    // 1e-3 a record of twelve channels
    let is_false = |seed: &u64| {
        let clean = channel_of(300 << (seed % 7), 1000 + seed, TAILS[*seed as usize % 3], |_, value| value);
        clean.changes().spikes.is_some()
    };
    assert!((0..CLEAN).filter(is_false).count() <= 1);
}

#[test]
fn one_sample_far_out_is_found_beside_slow_noise_and_gaps_and_a_step_is_none() {
    for seed in 80..120 {
        let mut random = Random(seed);
        let far = [0, SAMPLES - 1, 8299].get(seed as usize - 80).copied();
        let far = far.unwrap_or_else(|| (random.uniform() * SAMPLES as f64) as usize);
        let mut spikes = |change: &dyn Fn(usize) -> f64| {
            let (mut channel, mut level) = (Channel::of(&[]), 0.0);
            for place in 0..SAMPLES {
                level += 20.0 / (SAMPLES as f64).sqrt() * normal(&mut random);
                let count = (COUNTS * (level + normal(&mut random) + change(place))).round() as i32;
                channel.signal.push(&[count]);
                channel.histogram.push(&[count]);
                if place % 100 == 99 {
                    channel.signal.gap(Some(1));
                }
            }
            channel.changes().spikes
        };
        let found = spikes(&|place| if place == far { 40.0 } else { 0.0 });
        assert!(found.is_some_and(|of| of.count == 1 && (of.sigmas - 40.0).abs() < 8.0), "{seed} {far} {found:?}");
        let step = far.min(SAMPLES - 77);
        assert_eq!(spikes(&|place| if (77..step).contains(&place) { 60.0 } else { 0.0 }), None, "{seed} {far}");
    }
}

#[test]
fn bursts_are_distinguished_from_heavy_tails() {
    let bursts = |i: usize, value: f64| if (i / 80 * 7).is_multiple_of(31) { 3.0 * value } else { value };
    let changes = channel(5, Tails::Normal, bursts).changes();
    assert!(changes.bursts.is_some_and(|ratio| ratio > 1.5), "{changes:?}");
}

#[test]
fn nothing_is_found_in_noise_of_any_tails() {
    for tails in TAILS {
        for seed in 10..40 {
            let channel = channel(seed, tails, |_, value| value);
            let changes = channel.changes();
            assert_eq!(changes, NoiseChanges::default(), "{tails:?} {seed} {changes:?}");
            assert_eq!(channel.signal.disturbances(INTERVAL_S), [], "{tails:?} {seed}");
            assert_eq!(
                LevelSearch::of([&channel.signal]).find(&channel.signal, INTERVAL_S, 2).change,
                None,
                "{tails:?} {seed}"
            );
        }
    }
}

/// The position of the level within a step determines the visible noise, and the time for which a
/// value stays.
#[test]
fn a_coarse_channel_is_neither_frozen_nor_louder() {
    for (seed, std_counts) in (50..60).zip([0.1, 0.2, 0.3, 0.4].into_iter().cycle()) {
        let mut random = Random(seed);
        let mut level = 0.0;
        // steps of nine counts
        let value = |_: usize| {
            level += 0.002 * normal(&mut random);
            9 * (level + std_counts * normal(&mut random)).round() as i32
        };
        let mut counts: Vec<i32> = (0..SAMPLES).map(value).collect();
        let changes = Channel::of(&counts).changes();
        assert_eq!(changes, NoiseChanges::default(), "{std_counts} {seed}");
        counts[SAMPLES / 3] += 900;
        assert_eq!(Channel::of(&counts).changes().spikes.map(|spikes| spikes.count), Some(1), "{std_counts} {seed}");
    }
}

#[test]
fn a_random_walk_is_no_change_of_noise() {
    for seed in 70..80 {
        let mut random = Random(seed);
        let mut level = 0.0;
        let value = |_: usize| {
            level += normal(&mut random);
            (COUNTS * level).round() as i32
        };
        let changes = Channel::of(&(0..SAMPLES).map(value).collect::<Vec<_>>()).changes();
        assert_eq!(changes, NoiseChanges::default(), "{seed} {changes:?}");
    }
}
