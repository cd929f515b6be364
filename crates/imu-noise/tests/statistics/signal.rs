//! A channel's blocks are exact, and the results do not depend on the division of its samples over calls.

use imu_noise::{
    ChannelSignal, Histogram, LevelFindings, LevelSearch, MAX_BLOCKS, Moments, NoiseChanges, Sides, SpectrumPlan,
};
use proptest::{collection::vec, prelude::*};

/// Stretches of samples, each with the number of missing samples after it.
type Stretches = Vec<(Vec<i32>, Option<u64>)>;

fn stretches(count: impl Strategy<Value = i32> + Clone) -> impl Strategy<Value = Stretches> {
    let missing = prop_oneof![Just(None), (0_u64..200).prop_map(Some), Just(Some(10_000))];
    vec((vec(count, 0..1500), missing), 1..6)
}

fn divided(stretches: &Stretches, part: usize) -> ChannelSignal {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    for (counts, missing) in stretches {
        counts.chunks(part).for_each(|part| signal.push(part));
        signal.gap(*missing);
    }
    signal
}

/// Noise with single outliers, and occasionally a frozen sensor.
fn disturbed() -> impl Strategy<Value = Stretches> {
    let noise = vec(prop_oneof![40 => -90..90, 1 => -90_000..90_000], 0..1500);
    let counts = prop_oneof![4 => noise, 1 => (-90..90, 0_usize..900).prop_map(|(count, len)| vec![count; len])];
    let missing = prop_oneof![1 => Just(None), 3 => (0_u64..200).prop_map(Some), 1 => Just(Some(10_000))];
    vec((counts, missing), 1..9)
}

fn assert_same(one: &ChannelSignal, other: &ChannelSignal) -> Result<(), TestCaseError> {
    for sides in [Sides::One, Sides::Two] {
        prop_assert_eq!(one.spectrum().density(sides, 0.025, 3), other.spectrum().density(sides, 0.025, 3));
    }
    prop_assert_eq!(one.narrow_bands(0.001, 0.025), other.narrow_bands(0.001, 0.025));
    prop_assert_eq!(one.blocks(), other.blocks());
    prop_assert_eq!(one.disturbances(0.025), other.disturbances(0.025));
    let level = |signal: &ChannelSignal| LevelSearch::of([signal]).find(signal, 0.025, 3);
    prop_assert_eq!(level(one), level(other));
    let noise = |signal: &ChannelSignal| signal.noise_changes(&Histogram::new(), 0.025);
    prop_assert_eq!(noise(one), noise(other));
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_division_gives_the_same_bits(
        stretches in prop_oneof![stretches(-9000..9000), disturbed()],
        part in 1_usize..700,
    ) {
        let (whole, parts) = (divided(&stretches, usize::MAX), divided(&stretches, part));
        assert_same(&whole, &parts)?;
    }

    #[test]
    fn blocks_agree_with_their_samples(stretches in stretches(any::<i32>())) {
        let signal = divided(&stretches, 97);
        let mut samples = Vec::new();
        let mut next = 0_u64;
        for (counts, missing) in &stretches {
            samples.extend((next..).zip(counts.iter().copied()));
            next += counts.len() as u64 + missing.unwrap_or(0);
        }
        let blocks = signal.blocks();
        prop_assert!(blocks.len() <= MAX_BLOCKS);
        prop_assert_eq!(blocks.iter().map(|block| block.count).sum::<u64>(), samples.len() as u64);
        for block in &blocks {
            prop_assert!(block.length.is_power_of_two() && block.first_sample % block.length == 0);
            let places = block.first_sample..block.first_sample + block.length;
            let inside: Vec<i32> = samples.iter().filter(|(i, _)| places.contains(i)).map(|(_, count)| *count).collect();
            prop_assert_eq!(block.count, inside.len() as u64);
            prop_assert_eq!(Some(&block.min_counts), inside.iter().min());
            prop_assert_eq!(Some(&block.max_counts), inside.iter().max());
            let mut moments = Moments::new();
            moments.push(&inside);
            let mean = moments.mean_counts().unwrap();
            prop_assert!((block.mean_counts - mean).abs() <= 1e-12 * mean.abs());
            let std = moments.variance_counts2().map(f64::sqrt);
            prop_assert_eq!(block.std_counts.is_some(), std.is_some());
            for (block, std) in block.std_counts.iter().zip(std) {
                prop_assert!((block - std).abs() <= 1e-12 * std, "{} {}", block, std);
            }
        }
    }

    #[test]
    fn no_counts_and_no_gap_are_too_large(stretches in stretches(prop_oneof![Just(i32::MIN), Just(i32::MAX)])) {
        let mut signal = divided(&stretches, 512);
        signal.gap(Some(u64::MAX));
        signal.push(&[i32::MIN; 1000]);
        signal.gap(Some(u64::MAX));
        signal.push(&[i32::MAX; 1000]);
        let _ = (signal.blocks(), signal.disturbances(1.0), LevelSearch::of([&signal]).find(&signal, 1.0, 0), signal.narrow_bands(1.0, 0.025));
    }
}

#[test]
fn an_empty_record_has_no_findings() {
    let signal = ChannelSignal::new(&SpectrumPlan::new());
    assert!(signal.disturbances(0.025).is_empty());
    assert_eq!(LevelSearch::of([&signal]).find(&signal, 0.025, 3), LevelFindings::default());
    assert_eq!(signal.noise_changes(&Histogram::new(), 0.025), NoiseChanges::default());
    let mut constant = ChannelSignal::new(&SpectrumPlan::new());
    constant.push(&[-9813; 10_000]);
    assert!(constant.disturbances(0.025).is_empty());
    assert_eq!(LevelSearch::of([&constant]).find(&constant, 0.025, 3), LevelFindings::default());
    assert_eq!(constant.noise_changes(&Histogram::new(), 0.025), NoiseChanges::default());
}

/// Counts of noise with a standard deviation of 30, the sum of twelve uniform numbers each.
fn noise(samples: usize) -> Vec<i32> {
    let mut state = 7_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / 2_f64.powi(31)
    };
    (0..samples).map(|_| (30.0 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)) as i32).collect()
}

fn changes(counts: &[i32]) -> NoiseChanges {
    let (mut signal, mut histogram) = (ChannelSignal::new(&SpectrumPlan::new()), Histogram::new());
    signal.push(counts);
    histogram.push(counts);
    signal.noise_changes(&histogram, 0.01)
}

#[test]
fn a_single_sample_is_an_outlier_however_far_it_lies() {
    assert_eq!(changes(&noise(8000)).spikes, None);
    // whatever share of a bin the noise is
    for tenths in 30..90 {
        let far = 10_f64.powf(0.1 * f64::from(tenths)) as i32;
        let mut counts = noise(8000);
        counts[5000] += far;
        let found = changes(&counts);
        assert_eq!((found.spikes.map(|spikes| spikes.count), found.change), (Some(1), None), "{far} counts");
    }
}

#[test]
fn a_sensor_that_stands_still_is_frozen_for_whatever_part_of_the_record() {
    for part in [0.2, 0.45, 0.55, 0.8] {
        let mut counts = noise(8000);
        let last = counts[((1.0 - part) * 8000.0) as usize..].iter_mut();
        last.for_each(|count| *count = 12);
        let frozen = changes(&counts).frozen.unwrap();
        assert!((frozen.duration_s / (80.0 * part) - 1.0).abs() < 0.02, "{part}: {frozen:?}");
    }
}
