//! A rate known beforehand: when it is confirmed, and what contradicts it.

use super::*;

/// The first line behind which lines have a place.
fn first_placed(mut timebase: GapDetector, stamps_s: &[f64]) -> Option<usize> {
    stamps_s.iter().position(|&stamp_s| {
        timebase.push(Duration::from_secs_f64(stamp_s), None);
        timebase.poll().is_some()
    })
}

#[test]
fn a_known_low_rate_is_confirmed_by_four_intervals_and_a_second() {
    for (rate_hz, line) in [(1.0, 4), (2.0, 4), (4.0, 4), (5.0, 5), (10.0, 10), (25.0, 25), (40.0, 32), (200.0, 32)] {
        let known = GapDetector::new(&RATES_HZ, Some(rate_hz));
        assert_eq!(first_placed(known.clone(), &steady(rate_hz, 100)), Some(line), "{rate_hz} Hz");
        assert_eq!(first_placed(GapDetector::new(&RATES_HZ, None), &steady(rate_hz, 100)), Some(32), "{rate_hz} Hz");
        // Known while samples are held, it is confirmed by these and the next one.
        let mut informed = GapDetector::new(&RATES_HZ, None);
        let stamps_s = steady(rate_hz, 100);
        stamps_s[..30].iter().for_each(|&stamp_s| informed.push(Duration::from_secs_f64(stamp_s), None));
        informed.set_reported_rate(rate_hz);
        assert_eq!(first_placed(informed, &stamps_s[30..]), Some(line.saturating_sub(30)), "{rate_hz} Hz");
    }
}

#[test]
fn a_few_even_lines_hide_neither_a_backlog_nor_losses_nor_another_rate() {
    for rate_hz in [1.0, 2.0, 4.0, 5.0, 10.0] {
        // The first seven at once, as the port was opened late, and one lost soon after.
        let mut late: Vec<f64> = steady(rate_hz, 200).iter().map(|stamp_s| stamp_s.max(1.0 + 7.0 / rate_hz)).collect();
        late.remove(30);
        let expected = [known(rate_hz), GapEvent::Samples(30), GapEvent::Missing(1), GapEvent::Samples(169)];
        assert_eq!(place_known(rate_hz, &late).0, expected);
        let mut lossy = steady(rate_hz, 200);
        lossy.drain(1..4);
        lossy.remove(3);
        let expected = [(1, 3), (2, 1)].map(|(lines, missing)| [GapEvent::Samples(lines), GapEvent::Missing(missing)]);
        let expected = [&[known(rate_hz)], expected.as_flattened(), &[GapEvent::Samples(193)]].concat();
        assert_eq!(place_known(rate_hz, &lossy).0, expected);
        for other_hz in RATES_HZ.into_iter().filter(|&other_hz| other_hz != rate_hz) {
            for stamps_s in [steady(other_hz, 1200), bunched(&steady(other_hz, 1200), 0.05)] {
                let (sequence, _) = place_known(rate_hz, &stamps_s);
                let refused =
                    matches!(sequence[..], [GapEvent::Refused(Refusal::OtherRate { .. }), GapEvent::Samples(1200)]);
                assert!(refused, "{other_hz} Hz for {rate_hz} Hz: {sequence:?}");
            }
        }
    }
}

#[test]
fn few_lines_agree_with_a_known_rate_that_bunching_explains() {
    for stamps_s in [&[7.0][..], &[7.0; 4], &[7.0, 7.05, 7.05, 7.1]] {
        assert_eq!(place_known(40.0, stamps_s).0, [known(40.0), GapEvent::Samples(stamps_s.len() as u64)]);
    }
    let paused = [7.0, 7.025, 7.05, 7.075, 9.0];
    let gap = GapEvent::Missing(76);
    assert_eq!(place_known(40.0, &paused).0, [known(40.0), GapEvent::Samples(4), gap, GapEvent::Samples(1)]);
    let (sequence, _) = place_known(200.0, &steady(40.0, 20));
    assert!(
        matches!(sequence[..], [GapEvent::Refused(Refusal::OtherRate { .. }), GapEvent::Samples(20)]),
        "{sequence:?}"
    );
}

#[test]
fn a_known_rate_that_the_stamps_contradict_is_refused() {
    for known_hz in [1.0, 20.0, 50.0, 200.0] {
        for stamps_s in [steady(40.0, 3000), bunched(&steady(40.0, 3000), 0.05)] {
            let (sequence, summary) = place_known(known_hz, &stamps_s);
            let refusal = Refusal::OtherRate { known_hz, measured_hz: 40.0 };
            assert_eq!(sequence, [GapEvent::Refused(refusal), GapEvent::Samples(3000)]);
            assert_eq!((summary.refusal, summary.nominal, summary.gaps), (Some(refusal), None, 0));
            let text = refusal.to_string();
            assert!(text.contains("40.0000 Hz") && text.contains(&format!("{known_hz} Hz")), "{text}");
        }
    }
}

#[test]
fn a_known_rate_outlasts_a_backlog_that_drains() {
    // Ten lines are late at first, and the reader catches up by one in 40, one read in four bringing two.
    let drained: Vec<f64> = steady(200.0, 6000)
        .into_iter()
        .enumerate()
        .map(|(line, sent_s)| {
            let behind = 10_usize.saturating_sub(line / 40) + usize::from(line < 500 && line % 4 == 0);
            sent_s + 0.005 * behind as f64
        })
        .collect();
    let mut lossy = drained.clone();
    lossy.drain(3000..3004);
    let expected = [known(200.0), GapEvent::Samples(3000), GapEvent::Missing(4), GapEvent::Samples(2996)];
    assert_eq!(place_known(200.0, &drained).0, [known(200.0), GapEvent::Samples(6000)]);
    assert_eq!(place_known(200.0, &lossy).0, expected);
}

#[test]
fn a_bunched_start_hides_no_other_rate() {
    for (known_hz, rate_hz) in [(200.0, 100.0), (100.0, 200.0), (40.0, 50.0), (50.0, 40.0), (200.0, 180.0)] {
        let stamps_s = bunched_start(&steady(rate_hz, 3000), 0.3, &[0.031, 0.017, 0.013, 0.049]);
        let (sequence, _) = place_known(known_hz, &stamps_s);
        let [GapEvent::Refused(Refusal::OtherRate { measured_hz, .. }), GapEvent::Samples(3000)] = sequence[..] else {
            panic!("{rate_hz} for {known_hz} Hz: {sequence:?}")
        };
        assert!((measured_hz / rate_hz - 1.0).abs() < 0.01, "{measured_hz} of {rate_hz} Hz");
    }
}

#[test]
fn a_known_rate_within_5_percent_is_used() {
    for known_hz in [38.2, 39.0, 40.0, 41.0, 41.9] {
        for stamps_s in [steady(40.0, 20_000), bunched(&steady(40.0, 20_000), 0.05)] {
            assert_eq!(place_known(known_hz, &stamps_s).0, [known(known_hz), GapEvent::Samples(20_000)]);
        }
    }
    assert_eq!(place_known(f64::NAN, &steady(40.0, 100)).0, [snapped(40.0), GapEvent::Samples(100)]);
    let (sequence, _) = place_known(f64::MAX, &steady(40.0, 100));
    assert!(matches!(sequence[..], [GapEvent::Refused(_), GapEvent::Samples(100)]), "{sequence:?}");
}

#[test]
fn dropped_samples_do_not_contradict_a_known_rate() {
    for lost in 1..60 {
        let mut stamps_s = steady(40.0, 2000);
        stamps_s.drain(10..10 + lost);
        let expected =
            [known(40.0), GapEvent::Samples(10), GapEvent::Missing(lost as u64), GapEvent::Samples(1990 - lost as u64)];
        assert_eq!(place_known(40.0, &stamps_s).0, expected);
        let (sequence, _) = place_known(40.0, &bunched(&stamps_s, 0.0437));
        assert_eq!(sequence[0], known(40.0), "{lost} lost");
    }
}

/// Without so many of a hundred, by no rule; the first and the last one are kept.
fn mostly_lost(mut stamps_s: Vec<f64>, percent: u64) -> Vec<f64> {
    let (last, mut line, mut random) = (stamps_s.len() - 1, 0, 1_u64);
    stamps_s.retain(|_| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        line += 1;
        line == 1 || line > last || (random >> 33) % 100 >= percent
    });
    stamps_s
}

#[test]
fn a_known_rate_of_which_most_lines_are_lost_is_followed() {
    for percent in [40, 60, 75] {
        for rate_hz in RATES_HZ {
            for sent in [60, 200, 800, 8000] {
                let (sequence, summary) = place_known(rate_hz, &mostly_lost(steady(rate_hz, sent), percent));
                assert_eq!(sequence[0], known(rate_hz), "{percent} % of {sent} at {rate_hz} Hz");
                assert_eq!(summary.samples + summary.missing, u64::from(sent), "{percent} % at {rate_hz} Hz");
            }
            let kept = mostly_lost(steady(rate_hz, 8000), percent);
            let first = first_placed(GapDetector::new(&RATES_HZ, Some(rate_hz)), &kept);
            assert!(first.is_some_and(|line| line <= 128), "{percent} % at {rate_hz} Hz: {first:?}");
        }
    }
}

#[test]
fn a_known_rate_that_is_a_multiple_of_that_of_the_lines_is_refused_whatever_is_lost() {
    for percent in [0, 30, 60] {
        for (rate_hz, known_hz) in [(20.0, 40.0), (1.0, 40.0), (40.0, 200.0), (25.0, 50.0), (37.0, 74.0)] {
            for rates_hz in [&RATES_HZ[..], &[]] {
                let kept = mostly_lost(steady(rate_hz, 3000), percent);
                let (sequence, _) = polled(GapDetector::new(rates_hz, Some(known_hz)), &kept, &[1]);
                let is_refused = matches!(sequence[0], GapEvent::Refused(Refusal::OtherRate { .. }));
                assert!(is_refused, "{percent} % of {rate_hz} Hz for {known_hz} Hz: {sequence:?}");
            }
        }
    }
}

#[test]
fn reads_at_a_pace_of_their_own_make_no_loss_contradict_a_known_rate() {
    // Three in four intervals of 50 Hz are then 16 ms, as of 62.5 Hz, and a loss bends the first stretch.
    let mut stamps_s = steady(50.0, 3000);
    stamps_s.drain(3..8);
    let (sequence, summary) = place_known(50.0, &bunched(&stamps_s, 0.016));
    assert_eq!((&sequence[0], summary.missing), (&known(50.0), 5));
}

#[test]
fn reads_at_the_pace_of_a_known_rate_do_not_hide_another() {
    for (rate_hz, known_hz) in [(40.0, 50.0), (20.0, 25.0)] {
        let stamps_s = bunched(&steady(rate_hz, 3000), 1.0 / known_hz);
        let (sequence, _) = place_known(known_hz, &stamps_s);
        assert!(matches!(sequence[0], GapEvent::Refused(Refusal::OtherRate { .. })), "{rate_hz} Hz: {sequence:?}");
    }
}

#[test]
fn a_reported_rate_gives_way_to_five_seconds_at_another() {
    let reported = |reported_hz: f64, stamps_s: &[f64]| {
        let mut detector = GapDetector::new(&RATES_HZ, None);
        detector.set_reported_rate(reported_hz);
        polled(detector, stamps_s, &[1]).0
    };
    for rate_hz in RATES_HZ {
        for reported_hz in RATES_HZ.into_iter().filter(|&reported_hz| reported_hz != rate_hz) {
            // a clock off by 200 ppm, singly and in reads of 50 ms
            let stamps_s = steady(rate_hz * 1.0002, 1200);
            for stamps_s in [&stamps_s, &bunched(&stamps_s, 0.05)] {
                let sequence = reported(reported_hz, stamps_s);
                assert_eq!(sequence, [snapped(rate_hz), GapEvent::Samples(1200)], "{reported_hz} Hz reported");
            }
        }
    }
    let refused = |sequence: &[GapEvent]| matches!(sequence[0], GapEvent::Refused(Refusal::OtherRate { .. }));
    assert!(refused(&reported(40.0, &steady(100.0, 490))), "4.9 s");
    assert!(refused(&reported(40.0, &steady(100.5, 1200))), "no rate of a sensor to 0.2 %");
    assert_eq!(reported(40.0, &steady(40.5, 1200))[0], known(40.0), "no contradiction");
    let mut dropped = steady(100.0, 1200);
    dropped.drain(700..703);
    let expected = [snapped(100.0), GapEvent::Samples(700), GapEvent::Missing(3), GapEvent::Samples(497)];
    assert_eq!(reported(40.0, &dropped), expected);
}
