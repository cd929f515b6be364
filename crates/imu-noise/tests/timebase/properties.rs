//! Any bunching, any losses.

use imu_noise::timebase::NominalRate;
use proptest::prelude::*;

use crate::link::{Link, gap, losing, place};

prop_compose! {
    fn link(jitter_periods: f64, max_read_s: f64)(
        rate_hz in prop::sample::select(vec![1.0, 40.0, 200.0]),
        clock_ppm in -500.0..500.0,
        jitter in 0.0..1.0,
        read in 0.0..=1.0,
        start_s in 0.1..1.1,
        seed: u64,
    ) -> Link {
        let jitter_s = f64::min(0.002, jitter_periods / rate_hz) * jitter;
        Link { rate_hz, clock_ppm, jitter_s, read_s: max_read_s * read, start_s, seed }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::default())]

    #[test]
    fn bunching_is_no_loss(link in link(1.0, 0.05)) {
        // Reads once per period look like lost lines if they drift past a line, and cannot be
        // distinguished from them.
        prop_assume!((link.read_s * link.rate_hz - 1.0).abs() > 0.01);
        let (events, summary) = place(link.stamps(20_000));
        // Once in some ten thousand streams reads that drift past the lines cost one of 20 000.
        prop_assert!(summary.missing <= 1 && events.len() <= 1, "{:?}", events);
        prop_assert_eq!(summary.nominal, Some(NominalRate::Snapped(link.rate_hz)));
    }

    #[test]
    fn lines_removed_from_a_steady_stream_are_counted(
        link in link(0.2, 0.0),
        removals in prop::collection::vec((prop_oneof![1_usize..12, 1_usize..600], prop_oneof![1_u64..4, 1_u64..=1000]), 1..6),
        after in prop_oneof![1_usize..12, 1_usize..200],
    ) {
        // The first lines show the lateness of lines; after the last ones a loss cannot be detected.
        const FIRST: usize = 40;
        let mut stamps = link.stamps(10_000);
        let mut kept: Vec<f64> = stamps.by_ref().take(FIRST).collect();
        let mut expected = Vec::new();
        // The rate of the clock is not known early enough to count more lines in pauses.
        let mut early = 100;
        for &(before, missing) in &removals {
            kept.extend(stamps.by_ref().take(before));
            let missing = if kept.len() < 200 { missing.min(early) } else { missing };
            early -= missing.min(early);
            if missing == 0 {
                continue;
            }
            expected.push((kept.len() as u64, gap(missing)));
            stamps.by_ref().take(missing as usize).for_each(drop);
        }
        kept.extend(stamps.take(after));
        let (events, _) = place(kept);
        prop_assert_eq!(events, expected);
    }

    #[test]
    fn lines_lost_at_random_from_the_start_are_counted(
        link in link(0.1, 0.0),
        lost_share in 0.01..0.4,
        lines in 1000_u64..4000,
    ) {
        let (kept, expected) = losing(link, lost_share, lines);
        let (_, summary) = place(kept);
        prop_assert_eq!((summary.nominal, summary.missing), (Some(NominalRate::Snapped(link.rate_hz)), expected));
    }

    #[test]
    fn single_lines_removed_from_a_bunched_stream_are_counted(
        clock_ppm in -500.0..500.0,
        start_s in 0.1..1.1,
        seed: u64,
        removed in prop::collection::vec(200_usize..600, 3..6),
    ) {
        // Reads that meet the lines at all phases.
        let link = Link { clock_ppm, jitter_s: 0.002, read_s: 0.0437, start_s, seed, ..Link::steady(40.0) };
        let mut stamps = link.stamps(10_000);
        let mut kept = Vec::new();
        for &before in &removed {
            kept.extend(stamps.by_ref().take(before));
            stamps.next();
        }
        kept.extend(stamps.take(200));
        let (_, summary) = place(kept);
        // Once in some thousand streams one loss coincides with a shift of the reads.
        let lost = removed.len() as u64;
        prop_assert!(summary.missing.abs_diff(lost) <= 1, "{} of {lost}", summary.missing);
    }
}
