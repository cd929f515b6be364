//! The places and sizes of a disturbance, a step and a warm-up.

use imu_noise::{ChannelSignal, LevelSearch, LevelShape, SpectrumPlan};

use crate::synthetic::Synthesis;

const INTERVAL_S: f64 = 0.025;
const SAMPLES: usize = 24_000;
/// Counts per standard deviation, with two decimals.
const COUNTS: f64 = 100.0;

#[test]
fn a_disturbance_is_reported_by_its_windows() {
    let slam = |i: usize| if (12_000..12_040).contains(&i) && i % 4 < 2 { 6.0 } else { 0.0 };
    let found = signal(&record(slam), &[]).disturbances(INTERVAL_S);
    assert_eq!(found.len(), 1);
    // Windows of 32 samples: 375 and 376 contain the 40 samples
    assert_eq!((found[0].start_s, found[0].end_s), (300.0, 301.6));
    assert!(found[0].sigmas > 10.0, "{found:?}");
}

#[test]
fn several_disturbances_are_reported_in_time_order() {
    let slam = |i: usize| if i % 4000 < 40 && i % 4 < 2 { 6.0 * (1 + i / 4000) as f64 } else { 0.0 };
    let found = signal(&record(slam), &[]).disturbances(INTERVAL_S);
    let starts_s: Vec<_> = found.iter().map(|found| found.start_s).collect();
    assert_eq!(starts_s, [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]);
}

#[test]
fn a_gap_shifts_later_samples_and_is_no_disturbance() {
    let slam = |i: usize| if (12_000..12_040).contains(&i) && i % 4 < 2 { 6.0 } else { 0.0 };
    let found = signal(&record(slam), &[(8000, Some(4000))]).disturbances(INTERVAL_S);
    assert_eq!((found.len(), found[0].start_s), (1, 400.0));
    // after a gap of unknown length the level may differ, so no windows are compared across it
    let moved = |i: usize| if i < 12_000 { 0.0 } else { 50.0 };
    assert!(signal(&record(moved), &[(12_000, None)]).disturbances(INTERVAL_S).is_empty());
    assert!(!signal(&record(moved), &[]).disturbances(INTERVAL_S).is_empty());
}

#[test]
fn a_step_has_its_place_and_height() {
    let change = level_change(&|i| if i < 15_000 { 0.0 } else { -0.8 }).unwrap();
    let LevelShape::Step { start_s, amplitude } = change.shape else { panic!("{change:?}") };
    // a block is 256 samples, 6.4 s
    assert!((start_s - 375.0).abs() < 6.4, "{change:?}");
    assert!((amplitude + 0.8).abs() < 0.1, "{change:?}");
}

#[test]
fn a_warm_up_has_its_size_its_time_constant_and_a_skip() {
    let warm_up = |i: usize| 2.0 * (-(i as f64) * INTERVAL_S / 51.2).exp();
    let change = level_change(&warm_up).unwrap();
    let LevelShape::WarmUp { amplitude, time_constant_s, skip_s } = change.shape else { panic!("{change:?}") };
    assert!((time_constant_s / 51.2 - 1.0).abs() < 0.2, "{change:?}");
    assert!((amplitude - 2.0).abs() < 0.2, "{change:?}");
    // at the skip, half of the deviation of a block mean, which is a 16th of that of a sample
    let skip_s = skip_s.unwrap();
    assert!((skip_s - 51.2 * 64_f64.ln()).abs() < 15.0, "{change:?}");
    let rest = &record(warm_up)[(skip_s / INTERVAL_S) as usize..];
    assert_eq!(change_in(&signal(rest, &[])), None);
}

#[test]
fn a_cycle_has_its_period_and_size() {
    let change = level_change(&|i| 0.4 * (std::f64::consts::TAU * i as f64 * INTERVAL_S / 90.0).sin()).unwrap();
    let LevelShape::Cycle { period_s, amplitude } = change.shape else { panic!("{change:?}") };
    assert!((period_s - 90.0).abs() < 7.0 && (amplitude - 0.4).abs() < 0.06, "{change:?}");
    assert!(!change.is_ramp);
}

#[test]
fn a_cycle_with_one_to_three_periods_has_its_period_and_size() {
    let duration_s = SAMPLES as f64 * INTERVAL_S;
    for cycles in [1.0, 1.5, 1.75, 2.5] {
        for phase in [0.3, 1.7, 3.1, 5.0] {
            let cycle =
                |i: usize| 0.4 * (std::f64::consts::TAU * cycles * i as f64 * INTERVAL_S / duration_s + phase).sin();
            let signal = signal(&record(cycle), &[]);
            let found = LevelSearch::of([&signal]).find(&signal, INTERVAL_S, 2);
            let change = found.change.unwrap();
            let LevelShape::Cycle { period_s, amplitude } = change.shape else { panic!("{cycles} {phase} {change:?}") };
            assert!((duration_s / period_s - cycles).abs() < 0.3 && (amplitude - 0.4).abs() < 0.1, "{change:?}");
        }
    }
}

#[test]
fn the_level_is_judged_between_long_gaps() {
    let counts = record(|i| if i < 15_000 { 0.0 } else { -0.8 });
    // the longer part contains the step, and its place is after the gap
    let find = |gap: usize| change_in(&signal(&counts, &[(gap, Some(4000))]));
    let change = find(4000).unwrap();
    let LevelShape::Step { start_s, .. } = change.shape else { panic!("{change:?}") };
    assert!((start_s - 475.0).abs() < 13.0, "{change:?}");
    assert_eq!(find(15_000), None, "the step is in the gap");
}

#[test]
fn an_endless_drift_has_no_skip() {
    let change = level_change(&|i| 4.0 * i as f64 / SAMPLES as f64).unwrap();
    let LevelShape::WarmUp { amplitude, time_constant_s, skip_s: None } = change.shape else { panic!("{change:?}") };
    assert!(amplitude < -4.0 && time_constant_s > 300.0 && change.is_ramp, "{change:?}");
}

fn level_change(change: &dyn Fn(usize) -> f64) -> Option<imu_noise::LevelChange> {
    change_in(&signal(&record(change), &[]))
}

fn change_in(signal: &ChannelSignal) -> Option<imu_noise::LevelChange> {
    LevelSearch::of([signal]).find(signal, INTERVAL_S, 2).change
}

/// White noise with standard deviation 1, plus `added`.
fn record(added: impl Fn(usize) -> f64) -> Vec<i32> {
    let white = Synthesis::new(SAMPLES, 12).next_record().0;
    white.iter().enumerate().map(|(i, white)| (COUNTS * (white + added(i))).round() as i32).collect()
}

/// A channel with gaps at these places.
fn signal(counts: &[i32], gaps: &[(usize, Option<u64>)]) -> ChannelSignal {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    let mut pushed = 0;
    for &(place, missing) in gaps {
        signal.push(&counts[pushed..place]);
        signal.gap(missing);
        pushed = place;
    }
    signal.push(&counts[pushed..]);
    signal
}
