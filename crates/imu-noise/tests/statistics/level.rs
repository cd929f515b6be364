//! The level of a channel decides whether its noise contains a random walk.

use imu_noise::{
    ChannelAccumulator, ChannelCurve, ChannelSignal, Deviation, Estimator, LevelSeries, NoiseFit, NoiseModel,
    RecordShape, SpectrumPlan, Status, Term, Terms, counts_to_unit,
};

use crate::synthetic::Synthesis;

const SAMPLES: usize = 6_000;
const INTERVAL_S: f64 = 0.025;
const DECIMALS: u8 = 3;

/// The averaging time in samples at which the slow noise equals the white noise.
const WALK_CROSSING: f64 = SAMPLES as f64 / 20.0;
const FLICKER_CROSSING: f64 = SAMPLES as f64 / 200.0;

const fn shape() -> RecordShape {
    RecordShape {
        samples: SAMPLES as u64,
        interval_s: INTERVAL_S,
        estimator: Estimator::Strided,
        deviation: Deviation::Allan,
    }
}

/// Fits of the same record without its level and with it.
fn fits(values: &[f64]) -> [NoiseFit; 2] {
    let counts: Vec<i32> = values.iter().map(|value| (value * 1e3).round() as i32).collect();
    let shape = shape();
    let mut channel = ChannelAccumulator::new(shape.estimator, shape.deviation);
    channel.push(&counts);
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    signal.push(&counts);
    let octaves: Vec<_> = channel.octaves().sums().map(|sum| sum.octave()).collect();
    let variance = |counts2| counts_to_unit(counts2, 2 * DECIMALS);
    let variances: Vec<_> =
        channel.octaves().sums().map(|sum| sum.variance_counts2().map_or(f64::NAN, variance)).collect();
    let slope = channel.slope_counts().map(|slope| counts_to_unit(slope, DECIMALS) / INTERVAL_S);
    let model = NoiseModel::new(&octaves, &shape, Terms::RATE, None);
    let bands = signal.narrow_bands(counts_to_unit(1.0, DECIMALS));
    let level = LevelSeries::of(&signal, counts_to_unit(1.0, DECIMALS)).unwrap();
    let curve = ChannelCurve { bands: &bands, ..ChannelCurve::new(&variances, slope) };
    [None, Some(&level)].map(|level| model.fit(&ChannelCurve { level, ..curve }, 0.95))
}

fn walk_p(fit: &NoiseFit) -> f64 {
    fit.parameter(Term::RateRandomWalk).and_then(|walk| walk.p).unwrap_or(1.0)
}

#[test]
fn flicker_noise_passes_for_a_walk_less_often_and_walks_are_found_as_often() {
    const RECORDS: usize = 600;
    let mut synthesis = Synthesis::new(SAMPLES, 17);
    // K²τ/3 and (2 ln 2/π) B² equal 1/τ there
    let (walk_step, b) = (3_f64.sqrt() / WALK_CROSSING, (0.441 * FLICKER_CROSSING).sqrt().recip());
    let mut walking = Vec::new();
    let mut flickering = Vec::new();
    for _ in 0..RECORDS {
        let (white, flicker, walk) = synthesis.next_record();
        let beside = |slow: &[f64], by: f64| -> Vec<f64> {
            white.iter().zip(slow).map(|(white, slow)| white + by * slow).collect()
        };
        walking.push(fits(&beside(&walk, walk_step)).map(|fit| walk_p(&fit)));
        flickering.push(fits(&beside(&flicker, b)).map(|fit| walk_p(&fit)));
    }
    let below = |records: &[[f64; 2]], limit: f64| {
        [0, 1].map(|place| records.iter().filter(|both| both[place] < limit).count())
    };
    let [by_octaves, by_level] = below(&flickering, 0.025);
    assert!(by_level < by_octaves && (3..=RECORDS / 50).contains(&by_level), "{by_level}, by octaves {by_octaves}");
    // as if all axes and terms of a record were tested together
    let [by_octaves, by_level] = below(&walking, 0.0017);
    assert!(by_octaves > RECORDS / 10 && 10 * by_level > 9 * by_octaves, "{by_level}, by octaves {by_octaves}");
}

#[test]
fn beside_a_line_the_octaves_decide() {
    let (white, _, walk) = Synthesis::new(SAMPLES, 9).next_record();
    let line = |i: usize| 0.8 * (std::f64::consts::TAU * 0.11 * i as f64).sin();
    let values: Vec<f64> =
        white.iter().zip(&walk).enumerate().map(|(i, (white, walk))| white + 0.02 * walk + line(i)).collect();
    let [without, with] = fits(&values);
    assert!(walk_p(&with) < 0.01);
    assert_eq!(with, without);
}

#[test]
fn the_level_affects_only_the_random_walk() {
    let mut synthesis = Synthesis::new(SAMPLES, 5);
    let mut statuses = Vec::new();
    for _ in 0..60 {
        let (white, _, walk) = synthesis.next_record();
        let values: Vec<f64> = white.iter().zip(&walk).map(|(white, walk)| white + 0.008 * walk).collect();
        let [without, with] = fits(&values);
        for term in [Term::White, Term::BiasInstability] {
            assert_eq!(with.parameter(term), without.parameter(term));
        }
        let [before, after] = [&without, &with].map(|fit| fit.parameter(Term::RateRandomWalk).unwrap());
        assert!(after.upper >= before.upper, "{before:?} {after:?}");
        if after.status == Status::Bounded {
            assert!(after.p >= before.p, "{before:?} {after:?}");
        }
        let ramp = |fit: &NoiseFit| fit.parameter(Term::RateRamp).unwrap().upper;
        assert!(ramp(&with) >= ramp(&without));
        if after.status == Status::Estimated {
            let (lower, value, upper) = (after.lower.unwrap(), after.value.unwrap(), after.upper.unwrap());
            assert!(value / 50.0 < lower && lower < value && value < upper, "{after:?}");
            // the walk is part of the whole solution
            let of_walk = Term::RateRandomWalk.variance(value, 512, &shape()).sqrt();
            assert!(with.deviation(512).unwrap() > of_walk, "{of_walk} of {:?}", with.deviation(512));
        }
        statuses.push((before.status, after.status));
    }
    for both in [(Status::Bounded, Status::Estimated), (Status::Estimated, Status::Estimated)] {
        assert!(statuses.contains(&both), "{statuses:?}");
    }
}
