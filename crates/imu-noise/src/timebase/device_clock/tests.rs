//! Device times with gaps, restarts, false times and other rates.

use proptest::prelude::*;

use super::super::gap_event::GapEvent::{DeviceTimeInUse, FalseTime, Missing, Restart, Samples, TimeStep, UnknownGap};
use super::*;

const TICK: u64 = 1_250_000;

fn events(device_ns: impl IntoIterator<Item = u64>) -> Vec<GapEvent> {
    let mut clock = DeviceClock::default();
    device_ns.into_iter().for_each(|ns| clock.push(ns, None));
    clock.finish();
    std::iter::from_fn(|| clock.events.next()).collect()
}

#[test]
fn the_exact_vectors_miss_one_sample() {
    let expected = [DeviceTimeInUse { rate_hz: 800.0 }, Samples(2), Missing(1), Samples(1)];
    assert_eq!(events([TICK, 2 * TICK, 4 * TICK]), expected);
}

#[test]
fn few_samples_give_a_partial_result() {
    assert_eq!(events([]), []);
    assert_eq!(events([5]), [Samples(1)]);
    assert_eq!(events([9, 5]), [Samples(1), UnknownGap, Samples(1)]);
    assert_eq!(events([0, 5_000_000]), [DeviceTimeInUse { rate_hz: 200.0 }, Samples(2)]);
}

#[test]
fn a_restart_is_no_gap() {
    let running = (100..140).map(|tick| tick * TICK);
    let restarted = (1..50).map(|tick| tick * TICK);
    let used = DeviceTimeInUse { rate_hz: 800.0 };
    assert_eq!(events(running.clone().chain(restarted)), [used.clone(), Samples(40), Restart, Samples(49)]);
    let later = (100_140..100_150).map(|tick| tick * TICK);
    assert_eq!(events(running.clone().chain(later)), [used.clone(), Samples(40), Missing(100_000), Samples(10)]);
    let off = (0..9).map(|tick| 140 * TICK + TICK / 2 + tick * TICK);
    assert_eq!(events(running.chain(off)), [used, Samples(40), UnknownGap, Samples(9)]);
}

#[test]
fn a_time_that_neither_neighbour_confirms_is_false() {
    let used = DeviceTimeInUse { rate_hz: 800.0 };
    for false_ns in [0, 97 * TICK, 99 * TICK + TICK / 2, 102 * TICK, u64::MAX] {
        let times = (0..200).map(|tick| if tick == 100 { false_ns } else { tick * TICK });
        let expected = [used.clone(), Samples(100), FalseTime, Missing(1), Samples(99)];
        assert_eq!(events(times), expected, "{false_ns}");
    }
    // no sample follows the last one
    let expected = [used.clone(), Samples(100), Missing(400), Samples(1)];
    assert_eq!(events((0..100).chain([500]).map(|tick| tick * TICK)), expected);
    let two = (0..200).map(|tick| if (100..102).contains(&tick) { 5 } else { tick * TICK });
    let found = events(two);
    let samples: u64 = found.iter().map(|event| if let Samples(samples) = event { *samples } else { 0 }).sum();
    assert_eq!(samples, 200, "{found:?}");
}

#[test]
fn a_clock_runs_on_over_an_outage_if_the_host_agrees() {
    let clock = |samples: u64| {
        let mut clock = DeviceClock::default();
        for tick in 0..samples {
            clock.push(tick * TICK, Some(Duration::from_nanos(tick * TICK)));
        }
        clock.finish();
        while clock.events.next().is_some() {}
        clock
    };
    for (after_s, passed_s, expected) in [
        (10, 10.4, ClockAfterOutage::RunsOn),
        (10, 11.0, ClockAfterOutage::Unknown),
        (10, 9.0, ClockAfterOutage::Unknown),
        (86_400, 86_440.0, ClockAfterOutage::RunsOn),
    ] {
        let next_ns = 99 * TICK + after_s * 1_000_000_000;
        let at = Duration::from_nanos(99 * TICK) + Duration::from_secs_f64(passed_s);
        let mut clock = clock(100);
        assert_eq!(clock.after_outage(next_ns, at), expected, "{after_s} s, {passed_s} s");
        if expected == ClockAfterOutage::RunsOn {
            clock.push(next_ns, Some(at));
            clock.push(next_ns + TICK, Some(at));
            let found = [(); 3].map(|()| clock.events.next());
            assert_eq!(found, [Some(Missing(after_s * 800 - 1)), Some(Samples(2)), None]);
            assert_eq!(clock.summary().unwrap().arrivals.unwrap().max_us, 1250, "an outage is no interval");
        }
    }
    let second = Duration::from_secs(1);
    assert_eq!(clock(100).after_outage(7 * TICK, second), ClockAfterOutage::Restarted);
    assert_eq!(clock(100).after_outage(1_124_100_000, second), ClockAfterOutage::Unknown, "no whole period");
    assert_eq!(clock(9).after_outage(800 * TICK, second), ClockAfterOutage::Unknown, "too few for a period");
}

#[test]
fn a_clock_without_such_ticks_has_its_mean_interval() {
    let every_ms = (0..100).map(|ms| ms * 1_000_000);
    assert_eq!(events(every_ms), [DeviceTimeInUse { rate_hz: 1000.0 }, Samples(100)]);
}

#[test]
fn enough_equal_intervals_are_another_rate() {
    let fast = (0..100).map(|tick| tick * TICK);
    let slow = (0..100).map(|sample| 99 * TICK + (sample + 1) * 4 * TICK);
    let found = events(fast.chain(slow));
    let changed = |event: &GapEvent| matches!(event, GapEvent::RateChanged { from_hz: 800.0, to_hz: 200.0, .. });
    assert_eq!(found.iter().filter(|event| changed(event)).count(), 1);
    assert_eq!(found[1..2], [Samples(100)], "{found:?}");
    assert_eq!(found[3..], [UnknownGap, Samples(100)], "{found:?}");
    let (fast, slow) = ((0..100).map(|sample| sample * 4 * TICK), (0..100).map(|tick| 396 * TICK + (tick + 1) * TICK));
    let found = events(fast.chain(slow));
    let changed = |event: &GapEvent| matches!(event, GapEvent::RateChanged { from_hz: 200.0, to_hz: 800.0, .. });
    assert_eq!(found.iter().filter(|event| changed(event)).count(), 1, "{found:?}");
    assert_eq!((&found[1], &found[3..]), (&Samples(100), &[UnknownGap, Samples(100)][..]));
    // too few for a rate: every second one was dropped
    let halved = (0..100).chain((101..141).step_by(2)).chain(142..160).map(|tick| tick * TICK);
    let missing = events(halved).iter().filter(|event| **event == Missing(1)).count();
    assert_eq!(missing, 20, "and two before the last part");
}

#[test]
fn a_time_that_steps_ahead_of_its_arrival_is_no_gap() {
    let stepped = |ahead_ns: u64, late: &dyn Fn(u64) -> u64| {
        let mut clock = DeviceClock::default();
        for tick in 0..4000_u64 {
            let ahead_ns = if tick < 2000 { 0 } else { ahead_ns };
            clock.push(tick * TICK + ahead_ns, Some(Duration::from_nanos(tick * TICK + late(tick))));
        }
        clock.finish();
        let is_gap = |event: &GapEvent| matches!(event, Missing(_) | UnknownGap | TimeStep | Restart);
        std::iter::from_fn(|| clock.events.next()).filter(is_gap).collect::<Vec<_>>()
    };
    let prompt = |_| 0;
    assert_eq!(stepped(7_200_000_000_000, &prompt), [TimeStep]);
    assert_eq!(stepped(500_000_000 + 2 * TICK, &prompt), [TimeStep]);
    // half a second may be the delay of a first read
    assert_eq!(stepped(400_000_000, &prompt), [Missing(320)]);
    // the host read nothing for two seconds, and a buffer lost one of them
    let stalled = |tick: u64| if (1900..2200).contains(&tick) { 2_000_000_000 } else { 1_000_000_000 };
    assert_eq!(stepped(800 * TICK, &|tick| if tick < 1900 { 0 } else { stalled(tick) }), [Missing(800)]);
}

#[test]
fn a_mean_tick_that_is_off_is_no_tick() {
    let rate = |period_ns: u64| match events((0..60).map(|sample| sample * period_ns))[0] {
        DeviceTimeInUse { rate_hz } => rate_hz,
        ref other => panic!("{other:?}"),
    };
    assert_eq!((rate(1_250_300), rate(5_001_000)), (800.0, 200.0), "a clock off by 240 ppm");
    assert!((rate(1_275_000) - 784.3).abs() < 0.1, "2 % slow");
}

#[test]
fn the_offset_of_the_clocks_shows_after_a_minute() {
    // the sensor's clock is 20 ppm fast, and reads are up to 4 ms late
    let mut clock = DeviceClock::default();
    for tick in 0..200_000_u64 {
        let late_ns = tick.wrapping_mul(2_654_435_761) % 4_000_000;
        let at = Duration::from_nanos(9_000_000_000 + (tick as f64 * 1_250_000.0 / (1.0 + 20e-6)) as u64 + late_ns);
        clock.push(7_000_000 + tick * TICK, Some(at));
        if tick == 40_000 {
            assert_eq!(clock.summary().and_then(|summary| summary.offset_ppm), None);
        }
    }
    let summary = clock.summary().unwrap();
    let ppm = summary.offset_ppm.unwrap();
    assert!((ppm - 20.0).abs() < 1.0, "{ppm}");
    assert_eq!((summary.nominal, summary.missing), (Some(NominalRate::Known(800.0)), 0));
}

proptest! {
    #[test]
    fn gaps_are_counted_at_any_rate_and_jitter(
        divisor in 1_u64..800,
        dropped in proptest::collection::btree_set(40_u64..400, 0..40),
        seed: u64,
    ) {
        // the jitter of real sensors at 800 Hz, in microseconds
        let jitter = |sample: u64| (sample.wrapping_mul(seed | 1) >> 33) % 55;
        let kept: Vec<u64> = (0..400).filter(|sample| !dropped.contains(sample)).collect();
        let found = events(kept.iter().map(|sample| 1_000_000_000 + sample * divisor * TICK + jitter(*sample) * 1000));
        let rate_hz = 800.0 / divisor as f64;
        prop_assert_eq!(&found[0], &DeviceTimeInUse { rate_hz });
        let missing: u64 = found.iter().map(|event| if let Missing(missing) = event { *missing } else { 0 }).sum();
        let last = kept[kept.len() - 1];
        prop_assert_eq!(missing, last + 1 - kept.len() as u64);
        prop_assert!(!found.contains(&UnknownGap));
    }
}
