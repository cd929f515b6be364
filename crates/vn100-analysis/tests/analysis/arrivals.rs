//! Streams with arrival times: losses, refusals and changes of rate reach the result at their
//! place, however the stream was cut.

use std::{sync::Arc, time::Duration};

use imu_noise::timebase::{Arrivals, NominalRate, Refusal};
use imu_noise::{Deviation, Estimator, Octaves};
use proptest::prelude::*;
use vn100_analysis::{
    Analysis, Assessment, Finding, MissingFrom, Parts, RateFrom, Remedy, Settings, Severity, Snapshot, SourceFacts,
    SourceResult, Timing, Warning, WarningKind,
};
use vn100_protocol::stream::{Arrival, Batch, LinkEvent, LinkEventKind, Mark, MarkKind, StreamCounts};
use vn100_protocol::{Layout, Register, RegisterContents, RegisterFields, VNYMR};

use crate::batches::are_the_same;

/// A good line that arrives then, or a bad one.
#[derive(Debug, Clone, Copy)]
enum Line {
    At(i64),
    Bad,
}
use Line::{At, Bad};

const SECOND_NS: f64 = 1e9;

/// Lines at a steady rate from a time in nanoseconds on.
fn steady(rate_hz: f64, from_ns: i64, count: usize) -> Vec<Line> {
    (0..count).map(|index| At(from_ns + (SECOND_NS / rate_hz * index as f64) as i64)).collect()
}

fn without(lines: &[Line], mut lost: impl FnMut(usize) -> bool) -> Vec<Line> {
    lines.iter().enumerate().filter(|(index, _)| !lost(*index)).map(|(_, line)| *line).collect()
}

/// The count of every channel is the number of the line, so that what was kept can be told.
fn analysed(lines: &[Line], rows: usize, settings: Settings) -> Snapshot {
    analysed_as(VNYMR.clone(), lines, rows, settings)
}

fn analysed_as(layout: Layout, lines: &[Line], rows: usize, settings: Settings) -> Snapshot {
    let mut analysis = Analysis::new(settings);
    absorb(&mut analysis, layout, lines, rows);
    analysis.finish();
    analysis.snapshot()
}

fn absorb(analysis: &mut Analysis, layout: Layout, lines: &[Line], rows: usize) {
    let layout: Arc<Layout> = Arc::new(layout);
    let width = layout.channels.len();
    let empty = || Batch { layout: Some(Arc::clone(&layout)), ..Batch::default() };
    let mut batch = empty();
    for (number, line) in (0_i32..).zip(lines) {
        let row = batch.row_count();
        match *line {
            At(at_ns) => {
                batch.arrivals.push(Arrival { from_row: row, at_ns });
                batch.counts.extend(std::iter::repeat_n(number, width));
            }
            Bad => batch.marks.push(Mark { before_row: row, kind: MarkKind::Rejected }),
        }
        if batch.row_count() == rows {
            analysis.absorb(&std::mem::replace(&mut batch, empty()));
        }
    }
    let mut link = StreamCounts::default();
    link.tally.samples = lines.iter().filter(|line| matches!(line, At(_))).count() as u64;
    batch.link = link;
    analysis.absorb(&batch);
}

fn found_in(snapshot: &Snapshot, finding: &Finding) -> bool {
    snapshot.warnings.iter().any(|warning| warning.finding == *finding)
}

fn refused(snapshot: &Snapshot) -> bool {
    snapshot.warnings.iter().any(|warning| matches!(warning.finding, Finding::StampsRefused(..)))
}

fn warned(snapshot: &Snapshot, kind: WarningKind) -> bool {
    snapshot.warnings.iter().any(|warning| warning.kind == kind)
}

#[test]
fn lines_lost_whole_are_gaps_at_their_place() {
    let lines = without(&steady(40.0, 0, 1000), |index| index == 300 || (600..610).contains(&index));
    let snapshot = analysed(&lines, 64, Settings::default());
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.gaps, timing.segments), (989, 11, 2, 3));
    assert_eq!((timing.rate_hz, timing.rate_from), (40.0, RateFrom::Arrival));
    assert_eq!(snapshot.timing.missing_from, MissingFrom::Arrival);

    let mut expected = Octaves::new(Estimator::Strided, Deviation::Allan);
    let counts: Vec<i32> = (0..989).collect();
    expected.push(&counts[..300]);
    expected.gap(Some(1));
    expected.push(&counts[300..599]);
    expected.gap(Some(10));
    expected.push(&counts[599..]);
    let octaves: Vec<_> = expected.sums().collect();
    assert_eq!(snapshot.channels[9].octaves, octaves);
}

#[test]
fn a_bad_line_is_not_counted_beside_its_arrival() {
    let mut lines = without(&steady(40.0, 0, 400), |index| index == 200);
    lines.insert(200, Bad);
    let snapshot = analysed(&lines, 50, Settings::default());
    assert_eq!((snapshot.timing.missing, snapshot.timing.gaps), (1, 1));
}

#[test]
fn refused_stamps_leave_the_rejected_lines_as_evidence() {
    // a file read at full speed
    let mut lines: Vec<_> = (0..500).map(|index| At(index * 40_000)).collect();
    lines.insert(250, Bad);
    let snapshot = analysed(&lines, 50, Settings::default());
    assert!(refused(&snapshot) && warned(&snapshot, WarningKind::RateAssumed));
    assert_eq!(snapshot.timing.missing_from, MissingFrom::RejectedRows);
    assert_eq!((snapshot.timing.samples, snapshot.timing.missing), (500, 1));
    assert_eq!(snapshot.timing.rate_from, RateFrom::Assumed);
    let cures = |snapshot: &Snapshot| {
        let is_refused = |warning: &&Warning| matches!(warning.finding, Finding::StampsRefused(..));
        snapshot.warnings.iter().find(is_refused).unwrap().remedies.clone()
    };
    assert_eq!(cures(&snapshot), [Remedy::GiveRate(None)]);
    // a link stamps what comes itself, and the advice for a file does not help
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    absorb(&mut analysis, VNYMR.clone(), &lines, 50);
    analysis.finish();
    analysis.absorb(&Batch { link: StreamCounts { connects: 1, ..StreamCounts::default() }, ..Batch::default() });
    assert_eq!(cures(&analysis.snapshot()), []);
}

#[test]
fn stamps_refused_once_are_told_behind_the_next_link_too() {
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let lossy = without(&steady(40.0, 0, 600), |index| index == 300);
    absorb(&mut analysis, VNYMR.clone(), &lossy, 64);
    analysis.take_link_event(&down);
    assert_eq!(analysis.snapshot().timing.missing_from, MissingFrom::Arrival);
    absorb(&mut analysis, VNYMR.clone(), &steady(100.0, 0, 600), 64);
    analysis.take_link_event(&down);
    absorb(&mut analysis, VNYMR.clone(), &lossy, 64);
    analysis.finish();
    let snapshot = analysis.snapshot();
    assert_eq!(snapshot.timing.missing, 2);
    assert_eq!(snapshot.timing.missing_from, MissingFrom::Arrival, "both were found by arrival");
    let is_over =
        |warning: &Warning| matches!(warning.finding, Finding::StampsRefused(Refusal::OtherRate { .. }, true));
    assert!(snapshot.warnings.iter().any(is_over), "{:?}", snapshot.warnings);
}

#[test]
fn a_rate_by_few_lines_before_the_link_was_lost_is_given_up() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    // A backlog of 40 Hz, read a line each 5 ms, looks like 200 Hz.
    let few = steady(200.0, 0, 20);
    let fewer = steady(50.0, 0, 5);
    let lossy = without(&steady(40.0, 0, 600), |index| index == 300);
    for (stretches, expected_hz, missing) in [
        (vec![&few], 200.0, 0),
        (vec![&few, &lossy], 40.0, 1),
        (vec![&few, &fewer], 50.0, 0),
        (vec![&fewer, &few], 200.0, 0),
        (vec![&fewer, &few, &lossy, &fewer, &few], 40.0, 1),
    ] {
        let mut analysis = Analysis::new(Settings { recent: true, ..Settings::default() });
        for &stretch in &stretches {
            absorb(&mut analysis, VNYMR.clone(), stretch, 8);
            analysis.take_link_event(&down);
        }
        let snapshot = analysis.snapshot();
        let case = format!("{:?}", stretches.iter().map(|lines| lines.len()).collect::<Vec<_>>());
        assert_eq!((snapshot.timing.rate_hz, snapshot.timing.rate_from), (expected_hz, RateFrom::Arrival), "{case}");
        assert_eq!(snapshot.timing.missing, missing, "{case}");
        let slot = snapshot.recent.map(|recent| recent.samples_per_slot);
        assert!(slot.is_none_or(|samples| samples as f64 == expected_hz / 2.0), "{case}: {slot:?}");
    }
}

#[test]
fn the_columns_of_the_history_lie_where_their_samples_do() {
    let snapshot = analysed(&steady(40.0, 0, 4000), 8, Settings { recent: true, ..Settings::default() });
    let per_count = VNYMR.channels[6].in_unit(1.0);
    let assessment = Arc::new(Assessment::new(&snapshot, 0.95));
    let result = SourceResult::new(SourceFacts::default(), Arc::new(snapshot), assessment, Parts::WithoutSignals);
    let history = result.history(6, 11, usize::MAX).unwrap();
    assert_eq!(history.columns.iter().flatten().map(|column| column.count).sum::<u64>(), 4000);
    for column in history.columns.iter().flatten() {
        // the number of the middle sample, from the time of the middle before the end
        let expected = 4000.0 + 40.0 * (column.start_s + column.duration_s / 2.0) - 0.5;
        assert!((column.mean / per_count - expected).abs() < 1e-6, "{column:?} {expected}");
    }
}

fn rate_of_the_sensor(rate_hz: &str) -> Batch {
    let registers = vec![RegisterContents { register: Register(7), fields: RegisterFields::new(rate_hz).unwrap() }];
    Batch { registers, ..Batch::default() }
}

/// Lines at 40 Hz, of which seven in ten are lost, by no rule.
fn mostly_lost(count: usize) -> Vec<Line> {
    let mut random = 1_u64;
    without(&steady(40.0, 0, count), move |_| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % 10 < 7
    })
}

#[test]
fn the_rate_of_a_stream_that_is_mostly_lost_is_that_of_the_sensor() {
    for told_after in [None, Some(0), Some(10), Some(300)] {
        let mut analysis = Analysis::new(Settings::default());
        let lines = mostly_lost(4000);
        let (before, after) = lines.split_at(told_after.unwrap_or(0));
        absorb(&mut analysis, VNYMR.clone(), before, 8);
        if told_after.is_some() {
            analysis.absorb(&rate_of_the_sensor("40"));
        }
        absorb(&mut analysis, VNYMR.clone(), after, 8);
        analysis.finish();
        let snapshot = analysis.snapshot();
        let Timing { rate_hz, rate_from, samples, missing, .. } = snapshot.timing;
        assert_eq!(rate_hz, 40.0, "{told_after:?}");
        assert_eq!(rate_from == RateFrom::Arrival, told_after.is_none(), "{told_after:?}");
        let all = samples + missing;
        assert!(samples > 1000 && (3950..=4000).contains(&all), "{told_after:?}: {samples} of {all}");
        assert!(!refused(&snapshot), "{:?}", snapshot.warnings);
    }
}

#[test]
fn what_was_placed_by_a_rate_that_the_sensor_denies_is_left_out() {
    let mut analysis = Analysis::new(Settings::default());
    absorb(&mut analysis, VNYMR.clone(), &steady(37.0, 0, 1100), 8);
    analysis.absorb(&rate_of_the_sensor("40"));
    absorb(&mut analysis, VNYMR.clone(), &steady(40.0, 30_000_000_000, 400), 8);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let timing = snapshot.timing;
    assert_eq!((timing.rate_hz, timing.rate_from), (40.0, RateFrom::Device));
    assert_eq!((timing.samples, timing.excluded, timing.missing), (400, 1100, 0));
    let found = Finding::FalseRate { samples: 1100, arrival_hz: 37.0, device_hz: 40.0 };
    assert!(found_in(&snapshot, &found), "{:?}", snapshot.warnings);
}

#[test]
fn a_rate_that_is_contradicted_has_the_name_of_who_gave_it() {
    let given = Settings { rate_hz: Some(100.0), ..Settings::default() };
    let snapshot = analysed(&steady(40.0, 0, 600), 64, given);
    let is_wrong = |warning: &Warning| warning.severity == Severity::Problem;
    assert!(refused(&snapshot) && snapshot.warnings.iter().any(is_wrong), "{:?}", snapshot.warnings);
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&rate_of_the_sensor("100"));
    absorb(&mut analysis, VNYMR.clone(), &steady(40.0, 0, 150), 64);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let found = Finding::FalseReport { reported_hz: 100.0, arrival_hz: 40.0 };
    assert!(found_in(&snapshot, &found), "{:?}", snapshot.warnings);
}

#[test]
fn starting_over_begins_the_statistics_of_the_intervals_anew() {
    let mut analysis = Analysis::new(Settings::default());
    let longest_us =
        |analysis: &Analysis| analysis.snapshot().arrivals.and_then(|summary| summary.arrivals?.max_us.into());
    absorb(&mut analysis, VNYMR.clone(), &steady(40.0, 0, 200), 1);
    absorb(&mut analysis, VNYMR.clone(), &steady(40.0, 5_006_000_000, 200), 1);
    assert_eq!(longest_us(&analysis), Some(31_000));
    analysis.start_over();
    absorb(&mut analysis, VNYMR.clone(), &steady(40.0, 10_006_000_000, 200), 1);
    assert_eq!(longest_us(&analysis), Some(25_000));
}

#[test]
fn seconds_of_exact_arrivals_outweigh_the_register() {
    for told_after in [0, 10, 100, 400] {
        let mut analysis = Analysis::new(Settings::default());
        let lines = without(&steady(100.0, 0, 800), |index| (500..503).contains(&index));
        let (before, after) = lines.split_at(told_after);
        absorb(&mut analysis, VNYMR.clone(), before, 8);
        analysis.absorb(&rate_of_the_sensor("40"));
        absorb(&mut analysis, VNYMR.clone(), after, 8);
        analysis.absorb(&rate_of_the_sensor("40"));
        analysis.finish();
        let snapshot = analysis.snapshot();
        let Timing { rate_hz, rate_from, samples, missing, excluded, .. } = snapshot.timing;
        assert_eq!((rate_hz, rate_from), (100.0, RateFrom::Arrival), "{told_after}");
        // a second of arrivals alone gives way to the first report, and the first sample after it counts by the report
        let expected = match told_after {
            400 => 0,
            101.. => 100,
            told_after => told_after.min(100) + 1,
        };
        assert!(
            excluded <= expected as u64 && samples + excluded == 797 && missing == 3,
            "{told_after}: {:?}",
            snapshot.timing
        );
        let found = Finding::FalseReport { reported_hz: 40.0, arrival_hz: 100.0 };
        assert!(found_in(&snapshot, &found), "{:?}", snapshot.warnings);
        assert!(!refused(&snapshot) && !warned(&snapshot, WarningKind::StreamChanged));
    }
}

#[test]
fn a_rate_the_stamps_contradict_is_kept_and_costs_nothing() {
    for rate_hz in [20.0, 50.0, 200.0] {
        let settings = Settings { rate_hz: Some(rate_hz), ..Settings::default() };
        let snapshot = analysed(&steady(40.0, 0, 600), 64, settings);
        assert_eq!((snapshot.timing.samples, snapshot.timing.missing), (600, 0), "{rate_hz} Hz");
        assert_eq!((snapshot.timing.rate_hz, snapshot.timing.rate_from), (rate_hz, RateFrom::Option));
        assert!(refused(&snapshot), "{rate_hz} Hz");
    }
}

#[test]
fn what_comes_at_another_rate_is_left_out() {
    let mut lines = steady(40.0, 0, 600);
    lines.extend(steady(200.0, 15_000_000_000, 1800));
    let snapshot = analysed(&lines, 64, Settings::default());
    assert!(warned(&snapshot, WarningKind::StreamChanged));
    let timing = snapshot.timing;
    assert_eq!((timing.rate_hz, timing.missing), (40.0, 0));
    assert!((590..=603).contains(&timing.samples), "{} samples", timing.samples);
    assert_eq!(timing.samples + timing.excluded, 2400);
    assert_says(&snapshot, 40.0);

    let settings = Settings { skip: Duration::from_secs(16), ..Settings::default() };
    let snapshot = analysed(&lines, 64, settings);
    assert_eq!(snapshot.timing.rate_hz, 200.0, "the first part skipped, the second is the record");
    assert!((1590..=1605).contains(&snapshot.timing.samples), "{} samples", snapshot.timing.samples);
}

/// The stamps speak of the samples of the record alone, which came at this rate.
fn assert_says(snapshot: &Snapshot, rate_hz: f64) {
    let said = snapshot.arrivals.unwrap();
    assert_eq!(said.nominal.map(NominalRate::hz), Some(rate_hz));
    assert!(said.offset_ppm.is_none_or(|ppm| ppm.abs() < 1.0), "{said:?}");
    let Arrivals { p50_us, p99_us, .. } = said.arrivals.unwrap();
    assert!([p50_us, p99_us].iter().all(|us| (*us as f64 * 1e-6 * rate_hz - 1.0).abs() < 1e-3), "{said:?}");
    assert!(!refused(snapshot), "{:?}", snapshot.warnings);
}

#[test]
fn of_a_sensor_that_returned_at_another_rate_the_stamps_before_count() {
    for (from_hz, to_hz, arrival_hz, count) in [(20., 10., 10., 133), (40., 200., 200., 60), (20., 10., 20., 133)] {
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&rate_of_the_sensor(&from_hz.to_string()));
        absorb(&mut analysis, VNYMR.clone(), &steady(from_hz, 0, count), 8);
        let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "VNERR,01".into() } };
        analysis.take_link_event(&down);
        analysis.absorb(&rate_of_the_sensor(&arrival_hz.to_string()));
        for _ in 0..2 {
            absorb(&mut analysis, VNYMR.clone(), &steady(to_hz, 0, 600), 8);
            analysis.take_link_event(&down);
        }
        let snapshot = analysis.snapshot();
        // the first sample of a connection is decided at once
        let samples = snapshot.timing.samples;
        assert!((count as u64..=count as u64 + 1).contains(&samples), "{samples} of {count}");
        assert_eq!(snapshot.timing.missing_from, MissingFrom::Arrival);
        assert_says(&snapshot, from_hz);
    }
}

#[test]
fn what_is_flushed_at_the_full_baud_rate_ends_no_record() {
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&rate_of_the_sensor("40"));
    let mut lines = steady(40.0, 0, 600);
    lines.extend(steady(100.0, 15_000_000_000, 200));
    lines.extend(steady(40.0, 17_000_000_000, 600));
    absorb(&mut analysis, VNYMR.clone(), &lines, 8);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let timing = snapshot.timing;
    assert!((1190..=1210).contains(&timing.samples), "{timing:?}");
    assert_eq!((timing.samples + timing.excluded, timing.missing, timing.segments), (1400, 0, 2));
    let is_burst = |warning: &Warning| matches!(warning.finding, Finding::BurstExcluded(_));
    assert!(snapshot.warnings.iter().any(is_burst), "{:?}", snapshot.warnings);
}

#[test]
fn a_rate_that_is_none_of_the_sensor_or_not_the_one_given_is_warned_of() {
    let known = |hz| Settings { rate_hz: Some(hz), ..Settings::default() };
    for (stream_hz, settings, taken_hz, said) in [
        (40.0, Settings::default(), 40.0, None),
        (40.03, Settings::default(), 40.0, None),
        (40.05, Settings::default(), 40.0, Some("RateOff(40.05")),
        (40.0, known(41.0), 41.0, Some("RateOff(40.0")),
        (37.0, Settings::default(), 37.0, Some("RateNotListed(37.0")),
        (37.0, known(37.0), 37.0, None),
    ] {
        let snapshot = analysed(&steady(stream_hz, 0, 4000), 64, settings);
        assert_eq!((snapshot.timing.rate_hz, snapshot.timing.missing), (taken_hz, 0));
        let mut texts = snapshot.warnings.iter().filter(|warning| warning.kind == WarningKind::RateOffNominal);
        let text = texts.next().map(|warning| format!("{:?}", warning.finding));
        assert!(text.is_some() == said.is_some() && texts.next().is_none(), "{stream_hz} Hz: {text:?}");
        assert!(text.as_ref().is_none_or(|text| text.contains(said.unwrap())), "{text:?}");
    }
}

#[test]
fn columns_of_any_sensor_have_the_rate_they_have() {
    let layout = Layout { message: "CSV".into(), ..VNYMR.clone() };
    for rate_hz in [26.0, 96.0, 104.0, 208.0, 416.0, 1000.0] {
        for known_hz in [None, Some(rate_hz)] {
            let settings = Settings { rate_hz: known_hz, ..Settings::default() };
            let lines = without(&steady(rate_hz, 0, 4000), |index| index == 2000);
            let snapshot = analysed_as(layout.clone(), &lines, 64, settings);
            assert!(
                (snapshot.timing.rate_hz / rate_hz - 1.0).abs() < 1e-9 && snapshot.timing.missing == 1,
                "{rate_hz}"
            );
            let arrival = [WarningKind::RateOffNominal, WarningKind::StampsDoubtful, WarningKind::RateAssumed];
            assert!(!arrival.into_iter().any(|kind| warned(&snapshot, kind)), "{:?}", snapshot.warnings);
        }
    }
}

#[test]
fn a_clock_set_back_is_reported_and_costs_nothing() {
    let mut lines = steady(40.0, 0, 1000);
    lines.extend(steady(40.0, 24_000_000_000, 1000));
    let snapshot = analysed(&lines, 64, Settings::default());
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.missing_from), (2000, 0, MissingFrom::Arrival));
    assert!(found_in(&snapshot, &Finding::Backwards(1)) && !refused(&snapshot), "{:?}", snapshot.warnings);
}

#[test]
fn time_that_jumps_ahead_is_a_gap_of_its_length() {
    // in suspend nobody reads; to stamps of a wall clock that is set forward it looks the same
    for rate_hz in [40.0, 200.0] {
        let second = rate_hz as usize;
        let mut lines = steady(rate_hz, 0, 30 * second);
        lines.extend(steady(rate_hz, 3600 * 1_000_000_000, 30 * second));
        let timing = analysed(&lines, 64, Settings::default()).timing;
        assert_eq!((timing.samples, timing.segments), (60 * second as u64, 2), "{rate_hz} Hz");
        assert_eq!(timing.missing, 3570 * second as u64, "{rate_hz} Hz: {timing:?}");
    }
}

/// Steady, bunched, lossy, refused or changing streams.
fn stream() -> impl Strategy<Value = Vec<Line>> {
    let lost = prop::collection::vec(0..700_usize, 0..4);
    (prop_oneof![Just(40.0), Just(200.0)], lost, 0..3_u8).prop_map(|(rate_hz, lost, kind)| {
        let mut lines = without(&steady(rate_hz, 0, 700), |index| lost.contains(&index));
        match kind {
            0 => lines.insert(350, At(0)),
            1 => lines.extend(steady(rate_hz / 2.0, (700.0 / rate_hz * SECOND_NS) as i64, 400)),
            _ => lines.insert(120, Bad),
        }
        lines
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_batches_give_the_same_results(lines in stream(), rows in 1..200_usize, skip_s in 0..3_u64) {
        are_the_same(|rows, settings| analysed(&lines, rows, settings), rows, skip_s)?;
    }
}
