//! Rate, change of the rate and refusal: what is reported, and where.

mod known;
mod unlisted;

use std::time::Duration;

use proptest::prelude::*;

use super::{Arrivals, GapDetector, GapEvent, NominalRate, Refusal, TimebaseSummary};

const RATES_HZ: [f64; 11] = [1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 25.0, 40.0, 50.0, 100.0, 200.0];

/// So many stamps in seconds at this rate, the first one a period after the last one of `before`.
fn then(mut before: Vec<f64>, rate_hz: f64, lines: u32) -> Vec<f64> {
    let last_s = before.last().copied().unwrap_or(1.0);
    before.extend((1..=lines).map(|line| last_s + f64::from(line) / rate_hz));
    before
}

fn steady(rate_hz: f64, lines: u32) -> Vec<f64> {
    then(Vec::new(), rate_hz, lines)
}

/// As a host sees them that reads at multiples of `read_s`.
fn bunched(stamps_s: &[f64], read_s: f64) -> Vec<f64> {
    stamps_s.iter().map(|stamp_s| (stamp_s / read_s).ceil() * read_s).collect()
}

/// All that comes out when it is asked for after each of these numbers of lines, in turn, and at
/// the end; neighbouring lines are merged.
fn polled(mut timebase: GapDetector, stamps_s: &[f64], polls: &[usize]) -> (Vec<GapEvent>, TimebaseSummary) {
    let mut sequence: Vec<GapEvent> = Vec::new();
    let mut take = |timebase: &mut GapDetector| {
        while let Some(placed) = timebase.poll() {
            match (placed, sequence.last_mut()) {
                (GapEvent::Samples(more), Some(GapEvent::Samples(lines))) => *lines += more,
                (placed, _) => sequence.push(placed),
            }
        }
    };
    let (mut polls, mut rest) = (polls.iter().cycle(), stamps_s);
    while !rest.is_empty() {
        let lines = polls.next().map_or(rest.len(), |&lines| lines.min(rest.len()));
        let (now, later) = rest.split_at(lines);
        now.iter().for_each(|&stamp_s| timebase.push(Duration::from_secs_f64(stamp_s), None));
        take(&mut timebase);
        rest = later;
    }
    timebase.finish();
    take(&mut timebase);
    (sequence, timebase.summary().unwrap())
}

fn place(stamps_s: &[f64]) -> (Vec<GapEvent>, TimebaseSummary) {
    polled(GapDetector::new(&RATES_HZ, None), stamps_s, &[1])
}

fn place_known(known_hz: f64, stamps_s: &[f64]) -> (Vec<GapEvent>, TimebaseSummary) {
    polled(GapDetector::new(&RATES_HZ, Some(known_hz)), stamps_s, &[1])
}

fn snapped(rate_hz: f64) -> GapEvent {
    GapEvent::Rate(NominalRate::Snapped(rate_hz))
}

fn known(rate_hz: f64) -> GapEvent {
    GapEvent::Rate(NominalRate::Known(rate_hz))
}

#[test]
fn lines_are_held_until_the_rate_is_sure() {
    for mut timebase in [GapDetector::new(&RATES_HZ, None), GapDetector::new(&RATES_HZ, Some(40.0))] {
        let mut stamps_s = steady(40.0, 100).into_iter();
        let held = stamps_s.by_ref().take_while(|&stamp_s| {
            timebase.push(Duration::from_secs_f64(stamp_s), None);
            timebase.poll().is_none()
        });
        assert_eq!(held.count(), 32);
    }
}

#[test]
fn few_lines_have_their_mean_rate() {
    let (sequence, summary) = place(&[]);
    assert_eq!((sequence, summary.nominal, summary.arrivals), (vec![], None, None));
    let (sequence, summary) = place(&[7.0]);
    assert_eq!((sequence, summary.nominal, summary.refusal), (vec![GapEvent::Samples(1)], None, None));
    assert_eq!(place(&[7.0, 7.025, 7.05]).0, [snapped(40.0), GapEvent::Samples(3)]);
}

/// As read by a host that stalls for `stalled_s` at first, then reads for the rest of a second
/// after these pauses in turn, and then takes each line alone.
fn bunched_start(stamps_s: &[f64], stalled_s: f64, pauses_s: &[f64]) -> Vec<f64> {
    let first_s = stamps_s.first().copied().unwrap_or_default();
    let mut pauses_s = pauses_s.iter().cycle();
    let mut read_s = first_s + stalled_s;
    let read = |&sent_s: &f64| {
        while read_s < sent_s && read_s < first_s + 1.0 {
            read_s += pauses_s.next().copied().unwrap_or(1.0);
        }
        sent_s.max(read_s)
    };
    stamps_s.iter().map(read).collect()
}

#[test]
fn a_rate_change_is_reported_where_it_is() {
    let pairs = [
        (40.0, 200.0, 3),
        (200.0, 40.0, 3),
        (40.0, 50.0, 3),
        (50.0, 40.0, 12),
        (200.0, 100.0, 3),
        (100.0, 200.0, 3),
        (1.0, 40.0, 3),
        (40.0, 1.0, 3),
    ];
    for (from_hz, to_hz, late) in pairs {
        let (sequence, summary) = place(&then(steady(from_hz, 600), to_hz, 1800));
        let [GapEvent::Rate(_), GapEvent::Samples(before), ref change, GapEvent::Samples(after)] = sequence[..] else {
            panic!("{from_hz} to {to_hz} Hz: {sequence:?}")
        };
        let GapEvent::RateChanged { from_hz: before_hz, to_hz: after_hz, until } = change.clone() else {
            panic!("{change:?}")
        };
        assert_eq!((before_hz, after_hz), (from_hz, to_hz));
        // of the first part alone
        assert_eq!(until.nominal, Some(NominalRate::Snapped(from_hz)));
        assert!((until.measured_hz.unwrap() / from_hz - 1.0).abs() < 1e-6, "{from_hz} to {to_hz} Hz: {until:?}");
        let Arrivals { p50_us, p99_us, .. } = until.arrivals.unwrap();
        assert!([p50_us, p99_us].iter().all(|us| (*us as f64 * 1e-6 * from_hz - 1.0).abs() < 1e-3), "{until:?}");
        assert!((599..=600 + late).contains(&before), "{from_hz} to {to_hz} Hz: after {before} lines");
        assert_eq!(before + after, 2400);
        assert_eq!(summary.nominal, Some(NominalRate::Snapped(to_hz)));
        assert!((summary.measured_hz.unwrap() / to_hz - 1.0).abs() < 1e-6, "{summary:?}");
        assert!(summary.offset_ppm.unwrap().abs() < 1.0, "{summary:?}");
    }
}

#[test]
fn a_rate_change_of_bunched_lines_is_reported_where_it_is() {
    for read_s in [0.004, 0.016, 0.033, 0.05] {
        for extra in 0..20 {
            let stamps_s = then(then(steady(40.0, 580), 40.0, extra), 200.0, 1800);
            let (sequence, _) = place(&bunched(&stamps_s, read_s));
            let [GapEvent::Rate(_), GapEvent::Samples(before), ref change, GapEvent::Samples(_)] = sequence[..] else {
                panic!("{read_s} s: {sequence:?}")
            };
            assert!(matches!(change, GapEvent::RateChanged { from_hz: 40.0, to_hz: 200.0, .. }), "{change:?}");
            // A read of 50 ms brings ten lines.
            let changed = u64::from(580 + extra);
            assert!((changed - 3..=changed + 12).contains(&before), "{read_s} s: after {before} of {changed} lines");
        }
    }
}

#[test]
fn samples_held_before_the_change_keep_their_rate() {
    // The first 600 lines are 15 ms late; six lines after the last of these the rate changes.
    let stamps_s = then(steady(40.0, 606), 200.0, 1000).into_iter().enumerate();
    let stamps_s: Vec<_> = stamps_s.map(|(line, stamp_s)| if line < 600 { stamp_s + 0.015 } else { stamp_s }).collect();
    let (sequence, _) = place(&stamps_s);
    let [_, GapEvent::Samples(before), GapEvent::RateChanged { .. }, GapEvent::Samples(_)] = sequence[..] else {
        panic!("{sequence:?}")
    };
    assert!((605..=607).contains(&before), "after {before} lines");
}

#[test]
fn lines_before_a_change_keep_their_losses() {
    let mut stamps_s = then(steady(40.0, 1000), 200.0, 1000);
    stamps_s.drain(1500..1507);
    stamps_s.drain(980..983);
    let (sequence, summary) = place(&stamps_s);
    let [
        _,
        GapEvent::Samples(980),
        GapEvent::Missing(3),
        GapEvent::Samples(_),
        ref change,
        GapEvent::Samples(_),
        ref gap,
        _,
    ] = sequence[..]
    else {
        panic!("{sequence:?}")
    };
    let GapEvent::RateChanged { from_hz: 40.0, to_hz: 200.0, until } = change else { panic!("{change:?}") };
    assert_eq!((until.missing, gap), (3, &GapEvent::Missing(7)));
    assert_eq!((summary.missing, summary.gaps), (10, 2));
}

#[test]
fn a_phase_that_was_late_is_held_and_released() {
    // All lines up to 500 are 15 ms late.
    let late = steady(40.0, 1000).into_iter().enumerate();
    let stamps_s: Vec<_> = late.map(|(line, stamp_s)| if line < 500 { stamp_s + 0.015 } else { stamp_s }).collect();
    let mut timebase = GapDetector::new(&RATES_HZ, None);
    let mut push = |line: usize| {
        timebase.push(Duration::from_secs_f64(stamps_s[line]), None);
        std::iter::from_fn(|| timebase.poll()).last()
    };
    for line in 0..499 {
        push(line);
    }
    assert_eq!(push(499), Some(GapEvent::Samples(1)));
    assert_eq!((500..512).find_map(&mut push), None);
    assert_eq!(push(512), Some(GapEvent::Samples(13)));
}

#[test]
fn stamps_that_are_no_time_base_are_refused() {
    let unpaced: Vec<_> = (0..12_000).map(|line| f64::from(line) * 44e-6).collect();
    for (sequence, _) in [place(&unpaced), place_known(40.0, &unpaced)] {
        let [GapEvent::Refused(Refusal::TooFast { .. }), GapEvent::Samples(12_000)] = sequence[..] else {
            panic!("{sequence:?}")
        };
    }
    for (sequence, summary) in [place(&[3.0; 2000]), place_known(40.0, &[3.0; 2000])] {
        let refusal = Refusal::NoTimePasses { samples: 1024 };
        assert_eq!(sequence, [GapEvent::Refused(refusal), GapEvent::Samples(2000)]);
        assert_eq!(summary.refusal, Some(refusal));
    }
}

#[test]
fn a_refusal_is_reported_at_its_place() {
    // The record goes round every 50 lines; the ninth time is once too often.
    let (sequence, summary) = place(&steady(40.0, 50).repeat(10));
    let refusal = Refusal::Backwards { times: 9, samples: 451 };
    assert_eq!(sequence, [snapped(40.0), GapEvent::Samples(450), GapEvent::Refused(refusal), GapEvent::Samples(50)]);
    assert_eq!((summary.refusal, summary.backwards), (Some(refusal), 9));

    let (sequence, _) = place(&then(steady(40.0, 600), 4000.0, 1800));
    let [_, GapEvent::Samples(before), GapEvent::Refused(Refusal::TooFast { .. }), GapEvent::Samples(_)] = sequence[..]
    else {
        panic!("{sequence:?}")
    };
    assert!((600..=603).contains(&before), "{before}");
}

#[test]
fn intervals_begin_anew_and_the_time_base_continues() {
    let mut detector = GapDetector::new(&[40.0], None);
    let mut at = Duration::ZERO;
    let mut push = |detector: &mut GapDetector, interval_ms: u64, samples: u32| {
        for _ in 0..samples {
            at += Duration::from_millis(interval_ms);
            detector.push(at, None);
        }
        while detector.poll().is_some() {}
    };
    push(&mut detector, 25, 200);
    push(&mut detector, 31, 1);
    push(&mut detector, 25, 100);
    let max_us = |detector: &GapDetector| detector.summary().unwrap().arrivals.map(|arrivals| arrivals.max_us);
    assert_eq!(max_us(&detector), Some(31_000));
    detector.restart_intervals();
    assert_eq!(max_us(&detector), None);
    push(&mut detector, 25, 100);
    assert_eq!(max_us(&detector), Some(25_000));
    assert_eq!(detector.summary().unwrap().nominal, Some(NominalRate::Snapped(40.0)));
}

#[test]
fn even_intervals_are_exact_and_the_longest_always_is() {
    for interval_us in [5000, 24_990, 25_000, 25_007, 1_000_003] {
        let mut timebase = GapDetector::new(&RATES_HZ, Some(1e6 / interval_us as f64));
        (0..100).for_each(|line| timebase.push(Duration::from_micros(interval_us * line), None));
        let Some(Arrivals { p50_us, p99_us, max_us, .. }) = timebase.summary().and_then(|summary| summary.arrivals)
        else {
            panic!()
        };
        assert_eq!([p50_us, p99_us, max_us], [interval_us; 3]);
        timebase.push(Duration::from_secs(7201), None);
        timebase.finish();
        let Some(Arrivals { p50_us, max_us, .. }) = timebase.summary().and_then(|summary| summary.arrivals) else {
            panic!()
        };
        assert!(p50_us.abs_diff(interval_us) <= interval_us / 2000, "{p50_us} of {interval_us}");
        assert_eq!(max_us, 7_201_000_000 - 99 * interval_us);
    }
}

proptest! {
    /// The host is busy for the first second; lines are lost later.
    #[test]
    fn a_known_rate_outlasts_any_bunched_start(
        rate_hz in prop::sample::select(vec![40.0, 50.0, 100.0, 200.0]),
        stalled_s in 0.0..0.9,
        pauses_s in prop::collection::vec(0.0001..0.5, 8..40),
        lost in prop::collection::vec((2000_usize..5000, 1_usize..12), 0..6),
    ) {
        let mut stamps_s = bunched_start(&steady(rate_hz, 6000), stalled_s, &pauses_s);
        let mut missing = 0;
        for (line, lines) in lost {
            stamps_s.drain(line..line + lines);
            missing += lines as u64;
        }
        let (sequence, summary) = place_known(rate_hz, &stamps_s);
        prop_assert_eq!((summary.refusal, summary.missing), (None, missing), "{:?}", sequence);
        prop_assert_eq!(summary.nominal, Some(NominalRate::Known(rate_hz)));
    }

    /// A stream with a loss, a change of the rate, and a stamp that goes back, polled in any
    /// rhythm.
    #[test]
    fn when_it_is_polled_changes_nothing(
        rates_hz in prop::sample::subsequence(RATES_HZ[3..].to_vec(), 2).prop_shuffle(),
        known in prop::option::of(prop::sample::select(RATES_HZ.to_vec())),
        lines in prop::array::uniform3(1_u32..400),
        lost in 0_usize..20,
        read_s in prop::sample::select(vec![1e-6, 0.016, 0.05]),
        goes_back: bool,
        polls in prop::collection::vec(1_usize..200, 1..20),
    ) {
        let mut stamps_s = then(then(steady(rates_hz[0], lines[0]), rates_hz[1], lines[1]), rates_hz[1], lines[2]);
        stamps_s.drain(1..1 + lost.min(stamps_s.len() - 1));
        let mut stamps_s = bunched(&stamps_s, read_s);
        if goes_back {
            let all = stamps_s.len();
            stamps_s[all / 2..].iter_mut().for_each(|stamp_s| *stamp_s -= 0.9);
        }
        let timebase = known.map_or_else(|| GapDetector::new(&RATES_HZ, None), |hz| GapDetector::new(&RATES_HZ, Some(hz)));
        let each = polled(timebase.clone(), &stamps_s, &[1]);
        prop_assert_eq!(&polled(timebase.clone(), &stamps_s, &polls), &each);
        prop_assert_eq!(&polled(timebase, &stamps_s, &[]), &each);
        let placed: u64 = each.0.iter().map(|placed| if let GapEvent::Samples(lines) = placed { *lines } else { 0 }).sum();
        prop_assert_eq!(placed, stamps_s.len() as u64);
    }
}
