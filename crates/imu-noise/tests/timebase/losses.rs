//! Lost lines, and similar effects.

use imu_noise::timebase::GapDetector;

use crate::link::{Link, RATES_HZ, gap, place, place_with, stalling};

#[test]
fn a_first_line_that_is_late_is_no_loss() {
    for rate_hz in [1.0, 40.0, 200.0] {
        for known in [false, true] {
            let timebase =
                if known { GapDetector::new(&RATES_HZ, Some(rate_hz)) } else { GapDetector::new(&RATES_HZ, None) };
            let first_s = 0.55;
            let stamps = Link::steady(rate_hz).stamps(1000).map(|stamp_s| stamp_s.max(first_s));
            assert_eq!(place_with(timebase, stamps).0, [], "{rate_hz} Hz, known: {known}");
        }
    }
}

#[test]
fn a_stalled_reader_loses_nothing() {
    for rate_hz in [1.0, 40.0, 200.0] {
        for stalled_s in [0.5, 1.0, 1.9, 3.1, 13.377] {
            let stamps = Link::steady(rate_hz)
                .stamps(4000)
                .map(|stamp_s| if (stalled_s..stalled_s + 2.0).contains(&stamp_s) { stalled_s + 2.0 } else { stamp_s });
            assert_eq!(place(stamps).0, [], "{rate_hz} Hz at {stalled_s} s");
        }
    }
}

#[test]
fn a_reader_that_stalls_at_times_hides_no_single_loss() {
    for (rate_hz, stall_share, stalled_s) in
        [(200.0, 0.02, 0.07), (200.0, 0.1, 0.02), (200.0, 0.2, 0.03), (40.0, 0.2, 0.03)]
    {
        let stamps = stalling(rate_hz, stall_share, stalled_s, 3).into_iter().enumerate();
        let kept = stamps.filter(|(line, _)| line % 500 != 250 || *line < 1000);
        let (events, summary) = place(kept.map(|(_, stamp_s)| stamp_s));
        assert_eq!(
            (summary.missing, events.len()),
            (38, 38),
            "{rate_hz} Hz, {stall_share} of {stalled_s} s: {events:?}"
        );
    }
}

#[test]
fn a_read_that_leaves_lines_loses_none() {
    for rate_hz in [40.0, 100.0, 200.0] {
        for (away_s, left_s) in [(0.3, 0.2), (0.5, 0.1), (0.5, 0.4), (0.9, 0.7)] {
            // One read at 10 s + away takes the lines sent until `left_s` before, the next one, equally long after,
            // all others.
            let stamps = Link::steady(rate_hz).stamps(6000).map(|sent_s| {
                let first = 10.0..10.0 + away_s - left_s;
                let second = first.end..10.0 + 2.0 * away_s;
                if first.contains(&sent_s) {
                    10.0 + away_s
                } else if second.contains(&sent_s) {
                    second.end
                } else {
                    sent_s
                }
            });
            assert_eq!(place(stamps).0, [], "{rate_hz} Hz, {away_s} s");
        }
    }
}

#[test]
fn a_pause_with_lines_lost_is_one_gap() {
    let stamps = Link::steady(40.0).stamps(2000).enumerate();
    let kept = stamps.filter(|(line, _)| !(1000..1024).contains(line));
    let (events, summary) = place(kept.map(|(_, stamp_s)| stamp_s));
    assert_eq!(events, [(1000, gap(24))]);
    assert_eq!((summary.missing, summary.gaps), (24, 1));
}

#[test]
fn a_pause_before_the_last_line_is_a_gap() {
    let stamps = Link::steady(40.0).stamps(525).enumerate();
    let kept = stamps.filter(|(line, _)| !(500..524).contains(line));
    assert_eq!(place(kept.map(|(_, stamp_s)| stamp_s)).0, [(500, gap(24))]);
}

#[test]
fn a_later_phase_is_no_loss() {
    for rate_hz in [1.0, 40.0, 200.0] {
        let stamps = Link::steady(rate_hz).stamps(3000).enumerate();
        let shifted = stamps.map(|(line, stamp_s)| if line < 1500 { stamp_s } else { stamp_s + 0.003 });
        assert_eq!(place(shifted).0, [], "{rate_hz} Hz");
    }
}

#[test]
fn a_reader_that_is_too_slow_is_not_counted_twice() {
    // Between 25.5 and 69 s it takes one line every 43 ms and loses the others: 1740 were sent, 1000
    // arrived.
    let before = Link::steady(40.0).stamps(1000);
    let slow = (0..1000).map(|line| 25.5 + 0.043 * f64::from(line));
    let after = Link { start_s: 69.0, ..Link::steady(40.0) }.stamps(1000);
    let (_, summary) = place(before.chain(slow).chain(after));
    assert!(summary.missing.abs_diff(740) <= 2, "{summary:?}");
}

#[test]
fn a_million_lines_without_loss_show_none() {
    for rate_hz in [40.0, 200.0] {
        for (clock_ppm, read_s) in
            [(500.0, 0.05), (-500.0, 0.05), (37.0, 0.016), (-500.0, 0.0437), (500.0, 0.0), (-500.0, 0.0)]
        {
            let link = Link { clock_ppm, jitter_s: 0.002, read_s, ..Link::steady(rate_hz) };
            let (events, summary) = place(link.stamps(1_000_000));
            assert_eq!(events, [], "{link:?}");
            let offset_ppm = summary.offset_ppm.unwrap();
            assert!((offset_ppm - clock_ppm).abs() < 5.0, "{offset_ppm} ppm of {link:?}");
        }
    }
}

#[test]
fn reads_that_drift_past_the_lines_are_no_loss() {
    // Each read comes a little sooner after the line than the one before, until one finds no line.
    for periods in [0.95, 0.98, 0.99] {
        let link = Link { read_s: 0.025 * periods, ..Link::steady(40.0) };
        assert_eq!(place(link.stamps(20_000)).0, [], "{periods} periods");
    }
}
