//! Rows of tables, whose rate nothing but their stamps tells: repeated ones, other orders, changes of
//! the rate.

use std::{borrow::Cow, sync::Arc};

use proptest::prelude::*;
use vn100_analysis::{Analysis, Settings, Severity, Snapshot, WarningKind};
use vn100_protocol::stream::{Arrival, Batch};
use vn100_protocol::{Layout, VNYMR};

const CHANNELS: usize = 3;

/// The analysis of rows with these stamps in seconds, each with a number in all of its channels, in
/// batches of so many rows.
fn analysed(rows: &[(f64, i32)], together: usize, settings: Settings) -> Snapshot {
    let message = Cow::Borrowed("CSV");
    let layout =
        Arc::new(Layout { message, channels: VNYMR.channels[6..6 + CHANNELS].to_vec().into(), ..VNYMR.clone() });
    let mut analysis = Analysis::new(settings);
    for rows in rows.chunks(together) {
        let arrival = |(from_row, row): (usize, &(f64, i32))| Arrival { from_row, at_ns: (row.0 * 1e9).round() as i64 };
        analysis.absorb(&Batch {
            layout: Some(Arc::clone(&layout)),
            counts: rows.iter().flat_map(|(_, number)| [*number; CHANNELS]).collect(),
            arrivals: rows.iter().enumerate().map(arrival).collect(),
            ..Batch::default()
        });
    }
    analysis.finish();
    analysis.final_snapshot()
}

fn steady(rate_hz: f64, rows: usize) -> Vec<(f64, i32)> {
    (0..rows)
        .map(|row| (5.0 + row as f64 / rate_hz, ((row as u32).wrapping_mul(2_654_435_761) >> 16) as i32 % 1009))
        .collect()
}

fn severity(snapshot: &Snapshot, kind: WarningKind) -> Option<Severity> {
    snapshot.warnings.iter().find(|warning| warning.kind == kind).map(|warning| warning.severity)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn repeated_rows_and_other_orders_change_nothing_but_their_counts(
        rate_hz in 5.0..500.0,
        repeated in prop::collection::btree_set(100_usize..1900, 0..40),
        swapped in prop::collection::btree_set(10_usize..190, 0..20),
        distance in 1_usize..8,
        together in 1_usize..700,
    ) {
        let rows = steady(rate_hz, 2000);
        let plain = analysed(&rows, together, Settings::default());
        let mut changed: Vec<_> = rows.iter().enumerate().flat_map(|(place, row)| {
            std::iter::repeat_n(*row, 1 + usize::from(repeated.contains(&place)))
        }).collect();
        prop_assert_eq!(plain.timing.samples, 2000);
        if repeated.is_empty() {
            for place in &swapped {
                changed.swap(10 * place, 10 * place + distance);
            }
        }
        let found = analysed(&changed, together, Settings::default());
        prop_assert_eq!(found.repeated_rows, repeated.len() as u64);
        prop_assert_eq!(found.moved_rows > 0, repeated.is_empty() && !swapped.is_empty());
        prop_assert_eq!((found.timing.samples, found.timing.missing), (2000, 0), "{:?}", found.arrivals);
        for (plain, found) in plain.channels.iter().zip(&found.channels) {
            prop_assert_eq!(&plain.octaves, &found.octaves);
        }
        prop_assert_eq!(severity(&found, WarningKind::RepeatedLines).is_some(), !repeated.is_empty());
    }

    #[test]
    fn of_a_record_whose_rate_changes_the_longest_stretch_is_measured(
        rate_hz in 20.0..200.0, factor in prop_oneof![0.2..0.7, 1.5..4.0], before in 700_usize..3000, after in 700_usize..3000, together in 1_usize..900,
    ) {
        let seconds = |rows: usize, rate_hz: f64| rows as f64 / rate_hz;
        prop_assume!((seconds(before, rate_hz) / seconds(after, rate_hz * factor) - 1.0).abs() > 0.05);
        let mut rows = steady(rate_hz, before);
        let last_s = rows[before - 1].0 + 1.0 / rate_hz;
        rows.extend((0..after).map(|row| (last_s + row as f64 / (rate_hz * factor), row as i32 % 777)));
        let found = analysed(&rows, together, Settings::default());
        let is_first = seconds(before, rate_hz) > seconds(after, rate_hz * factor);
        let (expected_hz, expected) = if is_first { (rate_hz, before) } else { (rate_hz * factor, after) };
        prop_assert!((found.timing.rate_hz / expected_hz - 1.0).abs() < 0.003, "{} of {expected_hz}", found.timing.rate_hz);
        prop_assert!(found.timing.samples.abs_diff(expected as u64) <= 3, "{} of {expected}", found.timing.samples);
        prop_assert_eq!(found.timing.samples + found.timing.excluded, (before + after) as u64);
        prop_assert_eq!(severity(&found, WarningKind::StreamChanged), Some(Severity::Problem));
    }
}

#[test]
fn a_given_rate_that_the_stamps_contradict_is_a_problem() {
    for given_hz in [50.0, 98.0, 101.5, 200.0, 400.0] {
        let settings = Settings { rate_hz: Some(given_hz), ..Settings::default() };
        let found = analysed(&steady(100.0, 3000), 64, settings);
        let kinds = [WarningKind::StampsDoubtful, WarningKind::RateOffNominal];
        let severities = kinds.map(|kind| severity(&found, kind));
        assert!(severities.contains(&Some(Severity::Problem)), "{given_hz} Hz: {:?}", found.warnings);
    }
}

#[test]
fn no_row_and_one_row_have_no_rate() {
    assert_eq!(analysed(&[], 1, Settings::default()).timing.samples, 0);
    let one = analysed(&steady(100.0, 1), 1, Settings::default());
    assert_eq!((one.timing.samples, one.timing.missing), (1, 0));
}
