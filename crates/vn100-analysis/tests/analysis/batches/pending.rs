//! Lines that are held because their rate is not sure: the time asked for passes for them, too.

use vn100_protocol::stream::Arrival;

use super::*;

/// Takes lines with these stamps, in seconds, one by one until the measurement is complete, if it
/// becomes so: after how many.
fn until_complete(analysis: &mut Analysis, stamps_s: &[f64]) -> Option<usize> {
    let lines = batches(&vec![Good(1); stamps_s.len()], 1);
    (1..).zip(lines).zip(stamps_s).find_map(|((number, mut line), stamp_s)| {
        line.arrivals.push(Arrival { from_row: 0, at_ns: (stamp_s * 1e9) as i64 });
        analysis.absorb(&line);
        analysis.is_complete().then_some(number)
    })
}

fn steady(rate_hz: f64, lines: u32) -> Vec<f64> {
    (0..lines).map(|line| f64::from(line) / rate_hz).collect()
}

#[test]
fn the_time_asked_for_passes_for_lines_that_are_held() {
    let mut lossy = steady(1.0, 40);
    lossy.remove(2);
    let mut ahead = steady(40.0, 300);
    ahead[3] = 1000.0;
    for (case, stamps_s, duration_s, rate_hz, expected) in [
        // lines until it ends; samples, left out, missing, rate
        ("of unknown rate", steady(1.0, 40), 5.0, None, (Some(7), 5, 2, 0, 1.0)),
        ("of known rate", steady(1.0, 40), 5.0, Some(1.0), (Some(5), 5, 0, 0, 1.0)),
        ("one lost", lossy, 5.0, None, (Some(6), 4, 2, 1, 1.0)),
        ("too few", steady(1.0, 4), 5.0, None, (None, 4, 0, 0, 1.0)),
        ("a second at least", steady(5.0, 100), 0.1, None, (Some(6), 1, 5, 0, 5.0)),
        ("one stamp far ahead", ahead, 5.0, None, (Some(200), 200, 0, 0, 40.0)),
        ("enough for a rate", steady(40.0, 100), 0.5, None, (Some(41), 20, 21, 0, 40.0)),
    ] {
        let duration = Some(Duration::from_secs_f64(duration_s));
        let mut analysis = Analysis::new(Settings { duration, rate_hz, ..Settings::default() });
        let complete = until_complete(&mut analysis, &stamps_s);
        analysis.finish();
        let timing = analysis.snapshot().timing;
        let found = (complete, timing.samples, timing.excluded, timing.missing, timing.rate_hz);
        assert_eq!(found, expected, "{case}");
    }
}

/// A stall delays lines, and all of them come behind it: none was dropped.
#[test]
fn a_stall_at_the_end_of_the_time_asked_for_drops_nothing() {
    for (true_hz, from_s, to_s, duration_s) in [
        (40.0, 0.4, 7.0, 2.0),
        (40.0, 0.9, 5.0, 2.0),
        (40.0, 1.9, 5.0, 2.0),
        (40.0, 4.9, 9.0, 5.0),
        (2.0, 2.9, 4.4, 4.0),
        (1.0, 3.5, 6.4, 5.0),
        (1.0, 3.5, 20.0, 5.0),
    ] {
        for rate_hz in [None, Some(true_hz)] {
            let delayed = |due: f64| if (from_s..to_s).contains(&due) { to_s } else { due };
            let stamps_s: Vec<f64> = steady(true_hz, 800).into_iter().map(delayed).collect();
            let duration = Some(Duration::from_secs_f64(duration_s));
            let mut analysis = Analysis::new(Settings { duration, rate_hz, ..Settings::default() });
            assert!(until_complete(&mut analysis, &stamps_s).is_some());
            analysis.finish();
            let timing = analysis.snapshot().timing;
            let expected = (true_hz * duration_s) as u64;
            assert_eq!(
                (timing.samples, timing.missing),
                (expected, 0),
                "{true_hz} Hz, {from_s} to {to_s} s, {rate_hz:?}"
            );
        }
    }
}

#[test]
fn the_time_before_a_lost_link_counts_for_lines_held_behind_it() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let settings = Settings { duration: Some(Duration::from_secs(20)), ..Settings::default() };
    let mut analysis = Analysis::new(settings);
    assert_eq!(until_complete(&mut analysis, &steady(1.0, 6)), None);
    assert_eq!(analysis.snapshot().pending_rows, 6);
    analysis.take_link_event(&down);
    let complete = until_complete(&mut analysis, &steady(1.0, 40));
    assert!(
        complete.is_some_and(|lines| (14..=16).contains(&lines)),
        "six seconds, fourteen, and half a one: {complete:?}"
    );
}

#[test]
fn no_line_is_held_once_the_rate_is_told() {
    let mut analysis = Analysis::new(Settings::default());
    assert_eq!(analysis.snapshot().pending_rows, 0);
    until_complete(&mut analysis, &steady(40.0, 30));
    assert_eq!(analysis.snapshot().pending_rows, 30);
    until_complete(&mut analysis, &steady(40.0, 60)[30..]);
    assert_eq!(analysis.snapshot().pending_rows, 0);
}

#[test]
fn rows_that_were_pending_come_out_second_by_second_and_to_the_same_numbers() {
    // rows of a pipe: their stamps are no time base, and all are decided at one moment
    let lines: Vec<_> = (0..3000).map(|row| Good(row * 7919 % 101)).collect();
    let mut all = batches(&lines, 1);
    for (row, batch) in all.iter_mut().enumerate() {
        batch.arrivals = vec![Arrival { from_row: 0, at_ns: 10_000 * row as i64 }];
    }
    let settings = Settings { rate_hz: Some(40.0), ..Settings::default() };
    let mut at_once = Analysis::new(settings.clone());
    let mut by_seconds = Analysis::new(settings);
    let mut seen = Vec::new();
    for batch in &all {
        at_once.absorb(batch);
        let mut has_more = by_seconds.absorb_to_second(batch);
        while has_more {
            seen.push((by_seconds.seconds(), by_seconds.timing().samples));
            has_more = by_seconds.continue_to_second();
        }
    }
    let last = seen.last().unwrap().0;
    assert!(last > 10, "{seen:?}");
    assert_eq!(seen, (1..=last).map(|second| (second, 40 * second)).collect::<Vec<_>>());
    at_once.finish();
    by_seconds.finish();
    let (at_once, by_seconds) = (at_once.final_snapshot(), by_seconds.final_snapshot());
    assert_eq!(format!("{at_once:?}"), format!("{by_seconds:?}"));
}
