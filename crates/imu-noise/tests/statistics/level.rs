//! The level of a channel shows a random walk that the octaves do not.

use imu_noise::{
    ChannelAccumulator, ChannelCurve, ChannelSignal, Deviation, Estimator, LevelSeries, NoiseFit, NoiseModel,
    RecordShape, SpectrumPlan, Status, Term, Terms, counts_to_unit,
};

use crate::synthetic::Synthesis;

const SAMPLES: usize = 6_000;
const INTERVAL_S: f64 = 0.025;
const DECIMALS: u8 = 3;

/// In samples, where the slow noise is as strong as the white.
const WALK_CROSSING: f64 = SAMPLES as f64 / 20.0;
const FLICKER_CROSSING: f64 = SAMPLES as f64 / 200.0;

/// Fits of the same record without its level and with it.
fn fits(values: &[f64]) -> [NoiseFit; 2] {
    let counts: Vec<i32> = values.iter().map(|value| (value * 1e3).round() as i32).collect();
    let shape = RecordShape {
        samples: SAMPLES as u64,
        interval_s: INTERVAL_S,
        estimator: Estimator::Strided,
        deviation: Deviation::Allan,
    };
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
    let level = LevelSeries::of(&signal, counts_to_unit(1.0, DECIMALS)).unwrap();
    let curve = ChannelCurve::new(&variances, slope);
    [None, Some(&level)].map(|level| model.fit(&ChannelCurve { level, ..curve }, 0.95))
}

fn walk_p(fit: &NoiseFit) -> f64 {
    fit.parameter(Term::RateRandomWalk).and_then(|walk| walk.p).unwrap_or(1.0)
}

#[test]
fn walks_are_found_more_often_and_flicker_noise_is_none() {
    const RECORDS: usize = 600;
    let mut synthesis = Synthesis::new(SAMPLES, 17);
    let records: Vec<_> = (0..RECORDS).map(|_| synthesis.next_record()).collect();
    // K²τ/3 and (2 ln 2/π) B² are 1/τ there
    let (walk_step, flicker) = (3_f64.sqrt() / WALK_CROSSING, (0.441 * FLICKER_CROSSING).sqrt().recip());
    let mixed = |slow: fn(&(Vec<f64>, Vec<f64>, Vec<f64>)) -> &[f64], by: f64| -> Vec<[NoiseFit; 2]> {
        let mixed = |record: &(Vec<f64>, Vec<f64>, Vec<f64>)| -> Vec<f64> {
            record.0.iter().zip(slow(record)).map(|(white, slow)| white + by * slow).collect()
        };
        records.iter().map(|record| fits(&mixed(record))).collect()
    };
    let (walking, flickering) = (mixed(|record| &record.2, walk_step), mixed(|record| &record.1, flicker));
    // below it are the p of one record in forty without a walk
    let threshold = |place: usize| {
        let mut p: Vec<f64> = flickering.iter().map(|fits| walk_p(&fits[place])).collect();
        p.sort_by(f64::total_cmp);
        p[RECORDS / 40]
    };
    let found = |place: usize| walking.iter().filter(|fits| walk_p(&fits[place]) < threshold(place)).count();
    let (by_octaves, by_level) = (found(0), found(1));
    assert!(by_level > by_octaves + RECORDS / 25, "{by_level} by the level, {by_octaves} by the octaves");
    let false_walks = |place: usize| flickering.iter().filter(|fits| walk_p(&fits[place]) < 0.025).count();
    let (by_octaves, by_level) = (false_walks(0), false_walks(1));
    assert!(by_level <= RECORDS / 50, "{by_level} by the level, {by_octaves} by the octaves");
}

#[test]
fn the_level_changes_what_is_said_of_the_walk_alone() {
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
        if after.status == Status::Estimated {
            let (lower, value, upper) = (after.lower.unwrap(), after.value.unwrap(), after.upper.unwrap());
            assert!(0.0 < lower && lower < value && value < upper, "{after:?}");
        }
        statuses.push((before.status, after.status));
    }
    for both in [(Status::Bounded, Status::Estimated), (Status::Estimated, Status::Estimated)] {
        assert!(statuses.contains(&both), "{statuses:?}");
    }
}
