//! What arrival times are warned of.

use imu_noise::timebase::{Arrivals, NominalRate, Refusal, TimebaseSummary};
use vn100_protocol::{Layout, VNYMR, stream::RejectedRow};

use super::*;
use crate::snapshot::Timing;

const SUMMARY: TimebaseSummary = TimebaseSummary {
    samples: 4000,
    backwards: 0,
    nominal: Some(NominalRate::Snapped(40.0)),
    measured_hz: Some(40.0),
    offset_ppm: Some(0.0),
    refusal: None,
    missing: 0,
    gaps: 0,
    unevenness: None,
    flushed: 0,
    arrivals: None,
};

fn kinds(summary: &TimebaseSummary, rates_hz: &[f64]) -> Vec<WarningKind> {
    kinds_by(MissingFrom::Arrival, summary, rates_hz)
}

fn kinds_by(missing_from: MissingFrom, summary: &TimebaseSummary, rates_hz: &[f64]) -> Vec<WarningKind> {
    let mut advice = Advice::default();
    let timing = crate::Analysis::new(crate::Settings::default()).timing();
    advice.on_arrivals(summary, rates_hz, &Timing { missing_from, ..timing });
    advice.warnings.iter().map(|warning| warning.kind).collect()
}

#[test]
fn a_clock_is_off_that_drifts_further_than_bunching_and_quartz_explain() {
    for (ppm, samples, is_off) in [
        (2500.0, 1599, false),
        (2500.0, 1601, true),
        (-2500.0, 1601, true),
        (999.0, 1_000_000, false),
        (-1001.0, 1_000_000, true),
    ] {
        let summary = TimebaseSummary { offset_ppm: Some(ppm), samples, ..SUMMARY };
        let expected = if is_off { vec![WarningKind::RateOffNominal] } else { vec![] };
        assert_eq!(kinds(&summary, &[40.0]), expected, "{ppm} ppm, {samples} samples");
    }
    // a rate that is none of the sensor's is said to be that, whatever the clock
    let measured = TimebaseSummary { nominal: Some(NominalRate::Measured(37.0)), ..SUMMARY };
    assert_eq!(kinds(&measured, &[40.0]), [WarningKind::RateOffNominal]);
    assert_eq!(kinds(&measured, &[]), []);
}

#[test]
fn a_rate_by_times_that_lack_many_samples_is_unsure() {
    let summary = |missing, offset_ppm| TimebaseSummary {
        nominal: Some(NominalRate::Measured(38.81)),
        measured_hz: Some(38.73),
        missing,
        gaps: missing / 2,
        offset_ppm,
        ..SUMMARY
    };
    assert_eq!(kinds(&summary(500, None), &[]), [WarningKind::RateOffNominal]);
    assert_eq!(kinds(&summary(400, None), &[]), []);
    // off from a rate that is used
    assert_eq!(kinds(&summary(500, Some(10.0)), &[]), []);
    assert_eq!(kinds(&TimebaseSummary { nominal: Some(NominalRate::Snapped(40.0)), ..summary(500, None) }, &[]), []);
}

#[test]
fn stamps_that_go_back_and_lines_in_bunches_are_named() {
    let back = TimebaseSummary { backwards: 1, ..SUMMARY };
    assert_eq!(kinds(&back, &[]), [WarningKind::StampsBackwards]);
    let refusal = Some(Refusal::NoTimePasses { samples: 9 });
    assert_eq!(kinds(&TimebaseSummary { refusal, ..back }, &[]), [], "they are not followed");
    let together = |share_together| {
        let times = Arrivals { p50_us: 25_000, p99_us: 26_000, max_us: 27_000, share_together, samples_together: 2.0 };
        kinds(&TimebaseSummary { arrivals: Some(times), ..SUMMARY }, &[])
    };
    assert_eq!((together(0.2), together(0.21)), (vec![], vec![WarningKind::BunchedArrival]));
    let times = Arrivals { p50_us: 0, p99_us: 26_000, max_us: 27_000, share_together: 0.9, samples_together: 9.0 };
    let bunched = TimebaseSummary { arrivals: Some(times), ..SUMMARY };
    assert_eq!(kinds_by(MissingFrom::DeviceTime, &bunched, &[]), [], "packets have times of their own");
}

#[test]
fn rejected_packets_are_warned_of() {
    let warned = |rejected, damaged| {
        let mut snapshot = crate::Analysis::new(crate::Settings::default()).final_snapshot();
        snapshot.link.tally.damaged_packets = damaged;
        let measured = &mut snapshot.link.tally.measured_packets;
        (measured.samples, measured.rejected) = (10, rejected);
        snapshot.link.tally.packets = 10 + rejected;
        let mut advice = Advice::default();
        advice.on_lines(&snapshot, &StreamFindings::default());
        let rejected = advice.warnings.into_iter().find(|warning| warning.kind == WarningKind::RejectedLines);
        rejected.map(|warning| warning.headline)
    };
    assert_eq!(warned(0, 0), None);
    assert_eq!(warned(3, 0).as_deref(), Some("3 of 13 packets rejected: impossible numbers"));
    assert_eq!(warned(0, 2).as_deref(), Some("2 of 12 packets rejected: checksum mismatch"));
}

#[test]
fn rejected_rows_are_warned_of_with_their_reasons() {
    let warned = |numbers, damaged| {
        let mut snapshot = crate::Analysis::new(crate::Settings::default()).final_snapshot();
        let mut rows = RejectedRowCounts::default();
        rows.add(RejectedRow::Number, numbers);
        snapshot.link.rejected_rows = Some(rows);
        snapshot.link.tally.rejected.checksum = numbers + damaged;
        let mut advice = Advice::default();
        advice.on_lines(&snapshot, &StreamFindings::default());
        let rejected = advice.warnings.into_iter().filter(|warning| warning.kind == WarningKind::RejectedLines);
        rejected.map(|warning| warning.headline).collect::<Vec<_>>()
    };
    let rows = "2 of 2 lines rejected (number 2)";
    assert_eq!((warned(0, 0), warned(2, 0)), (vec![], vec![rows.to_owned()]));
    let damaged = "1 of 1 line rejected: checksum mismatch or malformed";
    assert_eq!(warned(0, 1), [damaged]);
}

#[test]
fn packets_that_are_neither_measured_nor_rejected_nor_repeated_are_of_another_form() {
    let warned = |packets| {
        let mut snapshot = crate::Analysis::new(crate::Settings::default()).final_snapshot();
        snapshot.layout = Some(std::sync::Arc::new(Layout { message: BINARY.into(), ..VNYMR.clone() }));
        let tally = &mut snapshot.link.tally;
        tally.packets = packets;
        let measured = &mut tally.measured_packets;
        (measured.samples, measured.rejected, measured.repeated) = (10, 3, 2);
        let mut advice = Advice::default();
        advice.on_lines(&snapshot, &StreamFindings::default());
        let other = advice.warnings.into_iter().find(|warning| warning.kind == WarningKind::OtherMessages);
        other.map(|warning| warning.headline)
    };
    assert_eq!(warned(15), None);
    assert_eq!(warned(17).as_deref(), Some("2 binary packets of another form excluded, BINARY measured"));
}

#[test]
fn counts_that_contradict_each_other_end_in_no_panic() {
    // as bytes of a state may say them
    let mut snapshot = crate::Analysis::new(crate::Settings::default()).final_snapshot();
    (snapshot.link.tally.packets, snapshot.link.tally.measured_packets.samples) = (1, 3);
    let mut advice = Advice::default();
    advice.on_lines(&snapshot, &StreamFindings::default());
    assert!(advice.warnings.iter().all(|warning| warning.kind != WarningKind::OtherMessages));
}
