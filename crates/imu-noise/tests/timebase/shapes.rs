//! The shapes of stamps in tables and bags of unknown rate.

use std::{f64::consts::TAU, time::Duration};

use imu_noise::timebase::{GapDetector, GapEvent, Refusal, TimebaseSummary};
use proptest::prelude::*;

/// Rate at the end, missing samples, the places and rates of changes, and the summary.
fn detected(stamps_s: &[f64]) -> (Option<f64>, u64, Vec<(u64, f64)>, TimebaseSummary) {
    let mut detector = GapDetector::new(&[], None);
    let (mut rate_hz, mut missing, mut changes, mut placed) = (None, 0, Vec::new(), 0);
    for stamp_s in stamps_s {
        detector.push(Duration::from_secs_f64(1000.0 + stamp_s), None);
    }
    detector.finish();
    while let Some(event) = detector.poll() {
        match event {
            GapEvent::Samples(samples) => placed += samples,
            GapEvent::Missing(more) => missing += more,
            GapEvent::Rate(rate) => rate_hz = Some(rate.hz()),
            GapEvent::RateChanged { to_hz, .. } => {
                changes.push((placed, to_hz));
                rate_hz = Some(to_hz);
            }
            _ => {}
        }
    }
    assert_eq!(placed, stamps_s.len() as u64, "every sample comes out once");
    (rate_hz, missing, changes, detector.summary().unwrap())
}

fn is_near(rate_hz: Option<f64>, expected_hz: f64, within: f64) -> bool {
    rate_hz.is_some_and(|hz| (hz / expected_hz - 1.0).abs() <= within)
}

prop_compose! {
    fn rate()(log_hz in 0.7..2.9) -> f64 { 10_f64.powf(log_hz) }
}

/// Stamps of a clock with these ticks.
fn on_ticks(rate_hz: f64, tick_s: f64, samples: usize, phase: f64) -> Vec<f64> {
    (0..samples).map(|place| f64::floor(place as f64 / rate_hz / tick_s + phase) * tick_s).collect()
}

#[test]
fn stamps_in_reverse_order_step_backwards() {
    for rate_hz in [10.0, 40.0, 100.0, 100.01, 200.0, 800.0] {
        let stamps_s: Vec<f64> = (0..3000).rev().map(|place| f64::from(place) / rate_hz).collect();
        let refusal = detected(&stamps_s).3.refusal;
        assert!(matches!(refusal, Some(Refusal::Backwards { .. })), "{rate_hz} Hz: {refusal:?}");
    }
}

#[test]
fn samples_that_are_early_by_a_tick_have_not_waited() {
    let (found_hz, missing, ..) = detected(&on_ticks(267.342_292_672, 0.244_093_794_797, 4172, 0.090_469_469));
    assert!(is_near(found_hz, 267.34, 0.01) && missing < 10, "{found_hz:?}, {missing}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn samples_that_waited_at_the_start_do_not_decide_the_rate(
        rate_hz in rate(), waited in 20_usize..400, factor in 0.01..0.5, samples in 1500_usize..4000,
    ) {
        let mut at_s = 0.0;
        let stamps_s: Vec<f64> = (0..samples).map(|place| {
            at_s += if place < waited { factor } else { 1.0 } / rate_hz;
            at_s
        }).collect();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 1e-3) && missing == 0 && changes.is_empty(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
    }

    #[test]
    fn bursts_are_no_gaps(
        rate_hz in rate(), burst in 3_usize..12, spacing in 0.0..0.35, samples in 1500_usize..4000,
        lost in prop::option::of(300_usize..1000),
    ) {
        let stamp = |place: usize| (place / burst * burst) as f64 / rate_hz + (place % burst) as f64 * spacing / rate_hz;
        let gap = |place: &usize| lost.is_none_or(|lost| !(lost / burst * burst..(lost / burst + 4) * burst).contains(place));
        let stamps_s: Vec<f64> = (0..samples).filter(gap).map(stamp).collect();
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        let expected = if lost.is_some() { 4 * burst as u64 } else { 0 };
        prop_assert!(is_near(found_hz, rate_hz, 0.01) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
        prop_assert!(missing.abs_diff(expected) <= 1, "{missing} of {expected}: {summary:?}");
        prop_assert!(summary.unevenness.is_some(), "{summary:?}");
    }

    #[test]
    fn a_coarse_clock_drops_nothing(
        rate_hz in 20.0..400.0, tick_s in prop::sample::select(vec![0.01, 0.0156, 0.015_625]), samples in 1500_usize..4000,
        phase in 0.0..1.0_f64,
    ) {
        let stamps_s: Vec<f64> = (0..samples).map(|place| f64::floor(place as f64 / rate_hz / tick_s + phase) * tick_s).collect();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 0.01) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
        prop_assert!(missing as usize <= samples / 100, "{missing} at {rate_hz} Hz");
    }

    /// Its steps are one and the next number of ticks in turn, as those of pairs are.
    #[test]
    fn a_step_of_a_number_and_a_half_of_digits_is_no_pair(
        whole in 1_u32..9, tick_s in prop::sample::select(vec![0.001, 0.1, 1.0]), off in -3e-4..3e-4_f64,
        samples in 1500_usize..6000, phase in 0.0..1.0_f64,
    ) {
        let rate_hz = (1.0 + off) / (tick_s * (f64::from(whole) + 0.5));
        let (found_hz, missing, changes, summary) = detected(&on_ticks(rate_hz, tick_s, samples, phase));
        prop_assert!(is_near(found_hz, rate_hz, 0.002) && changes.is_empty(), "{found_hz:?} of {rate_hz}: {summary:?}");
        prop_assert!(missing == 0, "{missing} at {rate_hz} Hz");
    }

    #[test]
    fn a_repeated_stamp_hides_no_dropped_samples(
        rate_hz in rate(), lost in 0.03..0.4, kept in prop::collection::vec(0.0..1.0_f64, 2000..4000), repeated in any::<prop::sample::Index>(),
    ) {
        let is_kept = |place: &usize| *place == 0 || *place == kept.len() - 1 || kept[*place] >= lost;
        let mut stamps_s: Vec<f64> = (0..kept.len()).filter(is_kept).map(|place| place as f64 / rate_hz).collect();
        let dropped = (kept.len() - stamps_s.len()) as u64;
        let repeated = 1 + repeated.index(stamps_s.len() - 1);
        stamps_s[repeated] = stamps_s[repeated - 1];
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 0.005) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {changes:?}: {summary:?}");
        prop_assert!(missing.abs_diff(dropped) as f64 <= 3.0 + 0.01 * kept.len() as f64, "{missing} of {dropped}: {summary:?}");
    }

    #[test]
    fn samples_after_the_clock_has_stopped_do_not_change_the_rate(rate_hz in rate(), samples in 1500_usize..4000, stopped in 0.02..0.45) {
        let running = samples - (stopped * samples as f64) as usize;
        let stamps_s: Vec<f64> = (0..samples).map(|place| place.min(running) as f64 / rate_hz).collect();
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        let is_measured = is_near(found_hz, rate_hz, 0.01) && missing == 0 && changes.is_empty();
        prop_assert!(is_measured || summary.refusal.is_some(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
    }

    #[test]
    fn a_clock_with_ticks_of_many_samples_drops_nothing_or_is_refused(
        rate_hz in 5.0..400.0, tick_s in 0.05..1.0, samples in 1500_usize..6000, phase in 0.0..1.0_f64,
    ) {
        // ticks about as long as the steps may be samples that a sender left out
        prop_assume!(!(0.7..1.05).contains(&(tick_s * rate_hz)));
        let (found_hz, missing, changes, summary) = detected(&on_ticks(rate_hz, tick_s, samples, phase));
        // the rate of a record of few ticks is known to two of them
        let within = 0.01 + 2.0 * tick_s * rate_hz / samples as f64;
        let is_measured = is_near(found_hz, rate_hz, within) && changes.is_empty() && missing as usize <= samples / 100;
        prop_assert!(is_measured || summary.refusal.is_some(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
    }

    /// Steps of one and two ticks in turn are as those of a sender that leaves out each third sample.
    #[test]
    fn a_clock_with_ticks_of_two_thirds_of_a_step_is_one(
        rate_hz in 5.0..400.0, part in 0.668..0.68, samples in 1500_usize..6000, phase in 0.0..1.0_f64,
    ) {
        let (found_hz, missing, changes, summary) = detected(&on_ticks(rate_hz, part / rate_hz, samples, phase));
        let is_measured = is_near(found_hz, rate_hz, 0.01) && changes.is_empty() && missing as usize <= samples / 100;
        prop_assert!(is_measured || summary.refusal.is_some(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
    }

    #[test]
    fn samples_that_waited_while_the_host_paused_are_none_missing(
        rate_hz in rate(), from in 300_usize..2500, held in 20_usize..400, spacing in 0.001..0.1, samples in 3000_usize..4000,
    ) {
        let until = (from + held) as f64;
        let stamps_s: Vec<f64> = (0..samples).map(|place| match place {
            _ if place < from || place >= from + held => place as f64 / rate_hz,
            _ => (until - spacing * (from + held - place) as f64) / rate_hz,
        }).collect();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 1e-3) && missing == 0 && changes.is_empty(), "{found_hz:?} of {rate_hz}, {missing}, {changes:?}");
    }

    #[test]
    fn a_step_that_wanders_drops_nothing(
        rate_hz in rate(), by in 0.0..0.03, over in 300.0..2000.0, digits in prop::sample::select(vec![1e-6, 0.01]),
        late in prop::collection::vec(0.0..0.1, 2000..4000),
    ) {
        let digit_s = f64::min(digits, 1.03 / rate_hz);
        // with ticks as long as the steps, a wander of more is the same as missing samples
        let by = if digits > 1e-3 { by / 4.0 } else { by };
        let mut at_s = 0.0;
        let stamps_s: Vec<f64> = late.iter().enumerate().map(|(place, late)| {
            at_s += (1.0 + by * f64::sin(TAU * place as f64 / over)) / rate_hz;
            f64::round((at_s + late / rate_hz) / digit_s) * digit_s
        }).collect();
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        let mean_hz = (stamps_s.len() - 1) as f64 / (stamps_s[stamps_s.len() - 1] - stamps_s[0]);
        prop_assert!(is_near(found_hz, mean_hz, 0.01) && changes.is_empty(), "{found_hz:?} of {mean_hz}, {missing}, {changes:?}");
        prop_assert!(missing as usize <= stamps_s.len() / 100, "{missing}: {summary:?}");
    }

    #[test]
    fn dropped_samples_leave_the_step(
        rate_hz in rate(), dropped in 0.0..0.4, jitter in 0.0..0.1, chances in prop::collection::vec((0.0..1.0, 0.0..1.0), 1500..3000),
    ) {
        let all = || chances.iter().enumerate().filter(|(place, (drop, _))| *place == 0 || *drop >= dropped);
        let stamps_s: Vec<f64> = all().map(|(place, (_, late))| (place as f64 + jitter * late) / rate_hz).collect();
        let expected = all().next_back().map_or(0, |(place, _)| place + 1) - stamps_s.len();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 0.005) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {changes:?}");
        prop_assert!(missing.abs_diff(expected as u64) as f64 <= 3.0 + 0.01 * chances.len() as f64, "{missing} of {expected}");
    }

    #[test]
    fn a_change_of_the_rate_is_found_at_its_place(
        rate_hz in rate(), factor in prop_oneof![0.2..0.75, 1.35..5.0], before in 600_usize..2000, after in 600_usize..2000,
    ) {
        let mut at_s = 0.0;
        let stamps_s: Vec<f64> = (0..before + after).map(|place| {
            at_s += if place < before { 1.0 } else { 1.0 / factor } / rate_hz;
            at_s
        }).collect();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz * factor, 0.005) && missing <= 1, "{found_hz:?}, {missing}, {changes:?}");
        let [(place, _)] = changes[..] else { panic!("{changes:?}") };
        prop_assert!(place.abs_diff(before as u64) <= 2, "{place} for {before}");
    }

    #[test]
    fn a_small_change_of_an_even_rate_is_found(
        rate_hz in rate(), factor in prop_oneof![0.85..0.95, 1.05..1.15], before in 600_usize..2000, after in 600_usize..2000,
        late in prop::collection::vec(0.0..0.05, 4000),
    ) {
        let mut at_s = 0.0;
        let stamps_s: Vec<f64> = (0..before + after).map(|place| {
            at_s += if place < before { 1.0 } else { 1.0 / factor } / rate_hz;
            at_s + late[place] / rate_hz
        }).collect();
        let (found_hz, missing, changes, _) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz * factor, 0.005) && missing <= 1, "{found_hz:?}, {missing}, {changes:?}");
        let [(place, _)] = changes[..] else { panic!("{changes:?}") };
        prop_assert!(place.abs_diff(before as u64) <= 8, "{place} for {before}");
    }

    #[test]
    fn a_clock_that_stands_still_for_a_while_drops_nothing(
        rate_hz in rate(), stopped in 3_usize..400, from in 10_usize..2500, jitter in 0.0..0.1,
        late in prop::collection::vec(0.0..1.0, 3000),
    ) {
        let place = |place: usize| if (from..from + stopped).contains(&place) { from } else { place };
        let stamps_s: Vec<f64> =
            (0..3000).map(|sample| (place(sample) as f64 + jitter * late[place(sample)]) / rate_hz).collect();
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 1e-3) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {changes:?}: {summary:?}");
        prop_assert!(missing == 0, "{missing}: {summary:?}");
    }

    #[test]
    fn samples_that_are_left_out_regularly_are_missing(
        rate_hz in rate(), every in 4_usize..60, jitter in 0.0..0.04, late in prop::collection::vec(0.0..1.0, 3000),
    ) {
        let period_s = f64::recip(rate_hz);
        // with ticks of a clock as long as a step the samples may be fewer
        let is_tick = |tick_s: &f64| (period_s / tick_s - 1.0).abs() < 0.1;
        prop_assume!(![0.001, 0.004, 0.008, 0.01, 0.015_625, 0.016, 1.0 / 60.0, 0.1, 1.0].iter().any(is_tick));
        let kept = (0..3000).filter(|place| place % every > 0);
        let stamps_s: Vec<f64> = kept.map(|place| (place as f64 + jitter * late[place]) * period_s).collect();
        let expected = 2999 - stamps_s.len() as u64;
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 0.005) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {changes:?}: {summary:?}");
        prop_assert!(missing.abs_diff(expected) <= 3 + 30, "{missing} of {expected}: {summary:?}");
    }

    #[test]
    fn a_clock_that_steps_is_a_gap_or_continues(rate_hz in rate(), place in 600_usize..1200, by_periods in prop_oneof![-4000.0..-40.0, 10.0..4000.0]) {
        let stamps_s: Vec<f64> = (0..2000).map(|sample| {
            (5000.0 + sample as f64 + if sample >= place { by_periods } else { 0.0 }) / rate_hz
        }).collect();
        prop_assume!(by_periods > 0.0 || by_periods / rate_hz < -0.02);
        let (found_hz, missing, changes, summary) = detected(&stamps_s);
        prop_assert!(is_near(found_hz, rate_hz, 1e-3) && changes.is_empty(), "{found_hz:?} of {rate_hz}, {changes:?}");
        prop_assert_eq!((missing > 0, summary.backwards), (by_periods > 0.0, u64::from(by_periods < 0.0)));
    }
}

#[test]
fn two_sources_are_pairs_and_days_are_too_fast() {
    for phase in [0.1, 0.25, 0.4] {
        let stamps_s: Vec<f64> =
            (0..4000).map(|place| 0.01 * (f64::from(place / 2) + if place % 2 == 1 { phase } else { 0.0 })).collect();
        let refusal = detected(&stamps_s).3.refusal;
        assert!(matches!(refusal, Some(Refusal::Pairs { .. })), "{phase}: {refusal:?}");
    }
    let days: Vec<f64> = (0..1600).map(|place| f64::from(place) * 0.01 / 86_400.0).collect();
    let refusal = detected(&days).3.refusal.unwrap();
    assert!(refusal.to_string().contains("days of a spreadsheet"), "{refusal}");
}
