//! What arrival times are warned of.

use imu_noise::timebase::{Arrivals, NominalRate, Refusal, TimebaseSummary};
use vn100_protocol::stream::{RejectedRow, RejectedRowCounts};
use vn100_protocol::{Layout, VNYMR};

use super::*;
use crate::{
    snapshot::{MissingFrom, Timing},
    warning::WarningKind,
};

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
    let timing = crate::Analysis::new(crate::Settings::default()).timing();
    let found = time::on_arrivals(summary, rates_hz, &Timing { missing_from, ..timing });
    found.iter().map(|warning| warning.kind).collect()
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
    assert_eq!(kinds(&back, &[]), [WarningKind::StampsDoubtful]);
    let refusal = Some(Refusal::NoTimePasses { samples: 9 });
    assert_eq!(kinds(&TimebaseSummary { refusal, ..back }, &[]), [], "they are not followed");
    let together = |share_together| {
        let times = Arrivals { p50_us: 25_000, p99_us: 26_000, max_us: 27_000, share_together, samples_together: 2.0 };
        kinds(&TimebaseSummary { arrivals: Some(times), ..SUMMARY }, &[])
    };
    assert_eq!((together(0.2), together(0.21)), (vec![], vec![WarningKind::StampsDoubtful]));
    let times = Arrivals { p50_us: 0, p99_us: 26_000, max_us: 27_000, share_together: 0.9, samples_together: 9.0 };
    let bunched = TimebaseSummary { arrivals: Some(times), ..SUMMARY };
    assert_eq!(kinds_by(MissingFrom::DeviceTime, &bunched, &[]), [], "packets have times of their own");
}

fn snapshot() -> Snapshot {
    crate::Analysis::new(crate::Settings::default()).final_snapshot()
}

fn rejected(snapshot: &Snapshot) -> Vec<Finding> {
    lines(snapshot, &StreamFindings::default()).map(|warning| warning.finding).collect()
}

#[test]
fn what_is_rejected_is_warned_of_with_its_reason() {
    let mut packets = snapshot();
    assert_eq!(rejected(&packets), []);
    let tally = &mut packets.link.tally;
    (tally.measured_packets.samples, tally.measured_packets.rejected, tally.packets) = (10, 3, 13);
    tally.damaged_packets = 2;
    let found = [Finding::Rejected(Rejected::Packets, 2, 15), Finding::Rejected(Rejected::PacketNumbers, 3, 13)];
    assert_eq!(rejected(&packets), found);
    let (mut table, mut rows) = (snapshot(), RejectedRowCounts::default());
    (0..2).for_each(|_| rows.count(RejectedRow::Number));
    table.link.rejected_rows = Some(rows);
    table.link.tally.rejected.checksum = 3;
    let found = [Finding::Rejected(Rejected::Rows(rows), 2, 3), Finding::Rejected(Rejected::Sentences, 1, 3)];
    assert_eq!(rejected(&table), found);
}

#[test]
fn packets_that_are_neither_measured_nor_rejected_nor_repeated_are_of_another_form() {
    let found = |packets| {
        let mut snapshot = snapshot();
        snapshot.layout = Some(std::sync::Arc::new(Layout { message: BINARY.into(), ..VNYMR.clone() }));
        let tally = &mut snapshot.link.tally;
        tally.packets = packets;
        let measured = &mut tally.measured_packets;
        (measured.samples, measured.rejected, measured.repeated) = (10, 3, 2);
        others(&snapshot).map(|warning| warning.finding).collect::<Vec<_>>()
    };
    // counts may contradict each other
    assert_eq!((found(3), found(15)), (vec![], vec![]));
    assert_eq!(found(17), [Finding::OtherPackets(2, None, BINARY.into())]);
}
