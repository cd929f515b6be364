//! The reported rate, in spite of losses and reads.

use imu_noise::timebase::{GapDetector, NominalRate};

use crate::link::{Link, RATES_HZ, gap, losing, place, place_with, stalling};

#[test]
fn a_steady_stream_has_its_rate_and_no_gap() {
    for rate_hz in RATES_HZ {
        let (events, summary) = place(Link { clock_ppm: 50.0, ..Link::steady(rate_hz) }.stamps(1000));
        assert_eq!(events, [], "{rate_hz} Hz");
        assert_eq!(summary.nominal, Some(NominalRate::Snapped(rate_hz)));
        let offset_ppm = summary.offset_ppm.unwrap();
        assert!((offset_ppm - 50.0).abs() < 0.1, "{offset_ppm} ppm at {rate_hz} Hz");
    }
}

#[test]
fn an_even_rate_the_sensor_does_not_have_is_kept() {
    for rate_hz in [1.3, 7.0, 30.0, 33.0, 37.0, 38.5, 41.0, 43.0, 96.0, 104.0, 208.0] {
        for (jitter, read_s) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.0437)] {
            // near a rate of the sensor only even stamps show another one
            if jitter + read_s > 0.0 && [38.5, 41.0, 43.0, 96.0, 104.0, 208.0].contains(&rate_hz) {
                continue;
            }
            let link = Link { jitter_s: jitter / rate_hz, read_s, ..Link::steady(rate_hz) };
            let (events, summary) = place(link.stamps(5000));
            assert_eq!(events, [], "{link:?}");
            let Some(NominalRate::Measured(hz)) = summary.nominal else { panic!("{link:?}: {summary:?}") };
            // Reads with several lines shift the first 500 by up to a period.
            assert!((hz / rate_hz - 1.0).abs() < 0.005, "{hz} of {link:?}");
            assert!((summary.measured_hz.unwrap() / rate_hz - 1.0).abs() < 2e-5, "{summary:?}");
        }
    }
}

#[test]
fn without_a_list_the_rate_is_that_of_all_samples() {
    for rate_hz in [0.5, 26.0, 52.0, 96.0, 100.0, 104.0, 208.0, 416.0, 1000.0, 6664.0] {
        // A recording with a resolution of a microsecond.
        let stamps = Link::steady(rate_hz).stamps(3000).map(|stamp_s| (stamp_s * 1e6).round() / 1e6);
        let kept = stamps.enumerate().filter(|(line, _)| line % 1000 != 999).map(|(_, stamp_s)| stamp_s);
        let (events, summary) = place_with(GapDetector::new(&[], None), kept);
        assert_eq!(events, [(999, gap(1)), (1998, gap(1))], "{rate_hz} Hz");
        let Some(NominalRate::Measured(hz)) = summary.nominal else { panic!("{summary:?}") };
        assert!((hz / rate_hz - 1.0).abs() < 1e-6, "{hz} of {rate_hz} Hz");
    }
}

#[test]
fn a_given_rate_is_not_replaced_by_a_listed_one() {
    for rate_hz in [37.0, 96.0, 104.0, 300.0] {
        let stamps = Link::steady(rate_hz).stamps(3000).enumerate();
        let kept = stamps.filter(|(line, _)| *line != 2000).map(|(_, stamp_s)| stamp_s);
        let (events, summary) = place_with(GapDetector::new(&RATES_HZ, Some(rate_hz)), kept);
        assert_eq!(events, [(2000, gap(1))], "{rate_hz} Hz");
        assert_eq!(summary.nominal, Some(NominalRate::Known(rate_hz)));
        assert!(summary.offset_ppm.unwrap().abs() < 1.0, "{summary:?}");
    }
}

#[test]
fn reads_at_another_rate_of_the_sensor_are_not_its_rate() {
    // Read every 20 ms a stream of 40 Hz looks like one of 50 Hz that loses every fifth line.
    for (rate_hz, read_s) in [(40.0, 0.02), (25.0, 0.025), (20.0, 0.04), (40.0, 0.0202), (40.0, 0.019_935_85)] {
        let (events, summary) = place(Link { read_s, ..Link::steady(rate_hz) }.stamps(5000));
        assert_eq!((events, summary.nominal), (vec![], Some(NominalRate::Snapped(rate_hz))), "{read_s} s");
    }
}

#[test]
fn a_reader_that_stalls_at_the_start_does_not_hide_the_rate() {
    for rate_hz in [40.0, 100.0, 200.0] {
        for seed in 0..20 {
            let (_, summary) = place(stalling(rate_hz, 0.2, 0.05, seed));
            assert_eq!(summary.nominal, Some(NominalRate::Snapped(rate_hz)), "seed {seed}");
        }
    }
}

#[test]
fn one_kept_line_of_many_is_the_lower_rate() {
    let kept = Link::steady(40.0).stamps(40 * 300).step_by(40);
    let (events, summary) = place(kept);
    assert_eq!((events.len(), summary.nominal), (0, Some(NominalRate::Snapped(1.0))));
}

#[test]
fn a_stream_that_loses_lines_all_the_time_has_its_rate() {
    // Every third line is lost: no stretch has the sensor's rate, but half of the intervals.
    let kept = Link::steady(40.0).stamps(3200).enumerate();
    let kept = kept.filter(|(line, _)| line % 3 != 2 || *line > 3000);
    let (_, summary) = place(kept.map(|(_, stamp_s)| stamp_s));
    assert_eq!(summary.nominal, Some(NominalRate::Snapped(40.0)));
    assert_eq!(summary.missing, 1000);
}

#[test]
fn losses_do_not_make_a_lower_rate_of_the_sensor() {
    // Three lines of eight are lost: the first stretches fit 25 Hz by chance.
    for seed in [9, 15, 253, 358, 422] {
        let (kept, lost) = losing(Link { seed, ..Link::steady(40.0) }, 0.375, 1500);
        let (_, summary) = place(kept);
        assert_eq!((summary.nominal, summary.missing), (Some(NominalRate::Snapped(40.0)), lost), "seed {seed}");
    }
}

#[test]
fn the_rate_is_found_if_some_neighbours_arrive() {
    // Some stretches of 200 arrive; for 1500 the lower edge fits another rate of the sensor: two lines in five of 100
    // Hz are 40 Hz.
    for (lost_share, lines) in [(0.6, 200), (0.7, 200), (0.6, 1500)] {
        for rate_hz in RATES_HZ {
            for seed in 0..20 {
                let (kept, lost) = losing(Link { seed, ..Link::steady(rate_hz) }, lost_share, lines);
                let (_, summary) = place(kept);
                let case = format!("{lost_share} of {lines} at {rate_hz} Hz, seed {seed}");
                assert_eq!((summary.nominal, summary.missing), (Some(NominalRate::Snapped(rate_hz)), lost), "{case}");
            }
        }
    }
}
