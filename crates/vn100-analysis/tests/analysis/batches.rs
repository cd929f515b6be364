//! What becomes of batches: gaps, segments, angles, and results that do not depend on how the
//! stream was cut.

mod absent;
mod link;
mod pending;
mod temperature;

use std::{sync::Arc, time::Duration};

use imu_noise::{Deviation, Estimator, Octaves, Term};
use proptest::prelude::*;
use vn100_analysis::{Analysis, Assessment, MissingFrom, RateFrom, Remedy, Setting, Settings, Snapshot, WarningKind};
use vn100_protocol::stream::{Arrival, Batch, LinkEvent, LinkEventKind, Mark, MarkKind, RowCounter, StreamCounts};
use vn100_protocol::{
    Channel, Layout, PrintFormat, Register, RegisterContents, RegisterFields, RejectedCounts, Tally, VNIMU, VNQMR,
    VNYMR,
};

/// One thing on a stream.
#[derive(Debug, Clone, Copy)]
enum Line {
    /// A good line, all channels of this count.
    Good(i32),
    Bad,
    Printed(PrintFormat),
}
use Line::{Bad, Good, Printed};

/// Batches of at most `rows` rows.
fn batches(lines: &[Line], rows: usize) -> Vec<Batch> {
    let layout: Arc<Layout> = Arc::new(VNYMR.clone());
    let width = layout.channels.len();
    let empty = || Batch { layout: Some(Arc::clone(&layout)), ..Batch::default() };
    let mut batches = vec![empty()];
    for line in lines {
        if batches.last().unwrap().rows().len() == rows {
            batches.push(empty());
        }
        let batch = batches.last_mut().unwrap();
        let before_row = batch.rows().len();
        match *line {
            Good(count) => batch.counts.extend(std::iter::repeat_n(count, width)),
            Bad => batch.marks.push(Mark { before_row, kind: MarkKind::Rejected }),
            Printed(format) => batch.marks.push(Mark { before_row, kind: MarkKind::Printed(format) }),
        }
    }
    let mut link = StreamCounts::default();
    link.tally.samples = lines.iter().filter(|line| matches!(line, Good(_))).count() as u64;
    batches.iter_mut().for_each(|batch| batch.link = link);
    batches
}

fn analysed(lines: &[Line], rows: usize, settings: Settings) -> Snapshot {
    let mut analysis = Analysis::new(settings);
    batches(lines, rows).iter().for_each(|batch| analysis.absorb(batch));
    analysis.snapshot()
}

fn warned(snapshot: &Snapshot, kind: WarningKind) -> bool {
    snapshot.warnings.iter().any(|warning| warning.kind == kind)
}

#[test]
fn nothing_seen_is_nothing_claimed() {
    let snapshot = Analysis::new(Settings::default()).snapshot();
    assert!(snapshot.layout.is_none() && snapshot.channels.is_empty());
    assert_eq!((snapshot.timing.samples, snapshot.timing.segments), (0, 0));
    assert_eq!((snapshot.timing.rate_hz, snapshot.timing.rate_from), (40.0, RateFrom::Assumed));
    assert!(snapshot.warnings.is_empty());
}

#[test]
fn a_sensor_that_only_answers_is_told_how_to_send() {
    let told = |connects: u64, replies: u64, bad: u64, skipped_bytes: u64| {
        let mut batch = Batch::default();
        batch.link.tally.rejected.checksum = bad;
        batch.link.tally.rejected_sentence_bytes = 122 * bad;
        batch.link.tally.skipped_bytes = skipped_bytes;
        batch.link.connects = connects;
        batch.link.tally.replies = replies;
        batch.link.tally.valid_sentence_bytes = 25 * replies;
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&batch);
        analysis
            .snapshot()
            .warnings
            .iter()
            .any(|warning| warning.remedies.contains(&Remedy::Configure(Setting::Message("VNYMR"))))
    };
    assert!(told(1, 24, 0, 0));
    assert!(!told(1, 24, 40, 0), "measurements, all of them damaged");
    assert!(!told(1, 24, 0, 4000), "measurements, beyond recognition");
    assert!(!told(1, 0, 0, 0), "a link that is just up");
    assert!(!told(0, 24, 0, 0), "a capture cannot be configured");
}

#[test]
fn bad_lines_between_good_ones_are_missing_samples() {
    // those before the first and behind the last good line are nobody's samples
    let snapshot = analysed(&[Bad, Good(1), Bad, Bad, Good(2), Good(3), Bad], 10, Settings::default());
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.gaps, timing.segments), (3, 2, 1, 2));
    assert_eq!(timing.duration_s(), 5.0 / 40.0);
    assert!(warned(&snapshot, WarningKind::Gaps));

    let mut expected = Octaves::new(Estimator::Strided, Deviation::Allan);
    expected.push(&[1]);
    expected.gap(Some(2));
    expected.push(&[2, 3]);
    let octaves: Vec<_> = expected.sums().collect();
    assert_eq!((octaves.len(), octaves[0].terms), (2, 1), "m = 1 has one window; in that of m = 2 half is present");
    for channel in &snapshot.channels {
        assert_eq!(channel.octaves, octaves);
    }
}

#[test]
fn the_time_asked_for_ends_the_measurement() {
    let settings = |seconds: f64, skip: f64| Settings {
        duration: Some(Duration::from_secs_f64(seconds)),
        skip: Duration::from_secs_f64(skip),
        ..Settings::default()
    };
    let lines = [Good(1), Good(2), Bad, Bad, Good(3), Good(4)];
    for (rows, ticks, skip, expected) in [
        // rows a batch, then samples of 25 ms; samples, left out, missing
        (10, 2.0, 0.0, (2, 2, 0)),
        (1, 2.0, 0.0, (2, 2, 0)),
        (10, 3.0, 0.0, (2, 2, 1)),
        (10, 5.0, 1.0, (2, 2, 2)),
        (10, 100.0, 0.0, (4, 0, 2)),
        (10, 1.0, 3.0, (0, 4, 0)),
    ] {
        let timing = analysed(&lines, rows, settings(ticks / 40.0, skip / 40.0)).timing;
        assert_eq!((timing.samples, timing.excluded, timing.missing), expected, "{ticks} samples, {skip} skipped");
    }
    let mut analysis = Analysis::new(settings(2.0 / 40.0, 0.0));
    let complete: Vec<_> = (batches(&lines, 1).iter())
        .map(|batch| {
            analysis.absorb(batch);
            analysis.is_complete()
        })
        .collect();
    assert_eq!(complete, [false, true, true, true]);
}

#[test]
fn a_change_of_print_format_breaks_the_segment_and_the_resolution() {
    let current = Printed(PrintFormat::Current);
    let old = Printed(PrintFormat::Old);
    let steady = analysed(&[current, Good(10), Good(20)], 10, Settings::default());
    assert_eq!((steady.timing.segments, steady.channels[0].printed_step_counts), (1, 1.0));
    let changed = analysed(&[current, Good(10), Good(20), old, Good(30)], 10, Settings::default());
    assert_eq!((changed.timing.segments, changed.timing.missing), (2, 0));
    assert_eq!(changed.channels[0].printed_step_counts, 10.0);
    assert_eq!(changed.channels[0].octaves[0].terms, 1);
    assert!(warned(&changed, WarningKind::StreamChanged));
    let always_old = analysed(&[old, Good(10), Good(20)], 10, Settings::default());
    assert_eq!((always_old.timing.segments, always_old.channels[9].printed_step_counts), (1, 100.0));
    assert!(!warned(&always_old, WarningKind::StreamChanged));
}

#[test]
fn angles_are_unwrapped_and_brought_back() {
    // yaw passes south: 179.99, -179.99, 179.99, -179.98 degrees
    let snapshot = analysed(&[179_990, -179_990, 179_990, -179_980].map(Good), 2, Settings::default());
    let yaw = &snapshot.channels[0];
    assert_eq!(yaw.moments.min_counts(), Some(179_990));
    assert_eq!(yaw.moments.max_counts(), Some(180_020));
    assert_eq!(yaw.branch_counts, 360_000, "a mean of 180.0025 degrees is -179.9975");
    let gyro = &snapshot.channels[9];
    assert_eq!((gyro.moments.min_counts(), gyro.branch_counts), (Some(-179_990), 0));
}

#[test]
fn an_angle_that_turns_without_end_starts_anew_and_says_so() {
    // a third of a turn a line: 2^31 counts are full after 17 896 lines
    let lines: Vec<_> = (0..18_000).map(|i| Good([0, 120_000, -120_000][i % 3])).collect();
    let snapshot = analysed(&lines, 500, Settings::default());
    assert!(warned(&snapshot, WarningKind::FullRange));
    assert_eq!(snapshot.channels[0].moments.count(), 18_000);
    assert_eq!(snapshot.channels[0].octaves[0].terms, 17_998, "one window touches the new start");
    assert_eq!(snapshot.channels[9].octaves[0].terms, 17_999);
}

#[test]
fn a_loop_is_noticed() {
    let lines: Vec<_> = (0..50).map(|i| Good(i % 20)).collect();
    assert!(warned(&analysed(&lines, 7, Settings::default()), WarningKind::RepeatedLines));
    assert!(!warned(&analysed(&lines[..20], 7, Settings::default()), WarningKind::RepeatedLines));
}

/// The channels a warning of this kind names.
fn named(snapshot: &Snapshot, kind: WarningKind) -> Vec<String> {
    snapshot.warnings.iter().filter(|warning| warning.kind == kind).flat_map(|w| w.channels.clone()).collect()
}

#[test]
fn a_channel_that_sticks_is_named() {
    let sticks: Vec<_> = (0..100).map(|i| Good(7 + i % 2)).collect();
    assert_eq!(named(&analysed(&sticks, 9, Settings::default()), WarningKind::QuantisationFloor).len(), 12);
    assert!(named(&analysed(&sticks[..99], 9, Settings::default()), WarningKind::QuantisationFloor).is_empty());
    let lives: Vec<_> = (0..100).map(|i| Good(7 + i % 3)).collect();
    assert!(named(&analysed(&lives, 9, Settings::default()), WarningKind::QuantisationFloor).is_empty());
}

#[test]
fn temperature_and_pressure_may_stand_still_for_minutes() {
    let layout: Arc<Layout> = Arc::new(VNIMU.clone());
    let stuck = |samples: usize| {
        // the others live
        let counts = (0..samples).flat_map(|row| {
            let count = |name: &str| if matches!(name, "temperature" | "pressure") { 7 } else { (row % 9) as i32 };
            layout.channels.iter().map(|channel| count(&channel.name)).collect::<Vec<_>>()
        });
        let mut analysis = Analysis::new(Settings { rate_hz: Some(2.0), ..Settings::default() });
        analysis.absorb(&Batch { layout: Some(Arc::clone(&layout)), counts: counts.collect(), ..Batch::default() });
        named(&analysis.snapshot(), WarningKind::QuantisationFloor)
    };
    assert!(stuck(599).is_empty(), "five minutes are 600 samples");
    assert_eq!(stuck(600), ["temperature", "pressure"]);
}

/// Rows of white noise about zero, but for a level of `level` counts; the same for the same seed.
fn noisy(channels: usize, rows: usize, level: i32) -> Vec<i32> {
    let mut state = 1_u64;
    let counts = (0..channels * rows).map(|_| {
        let uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 52) as i32
        };
        level + std::iter::repeat_with(uniform).take(4).sum::<i32>() - 4 * 2048
    });
    counts.collect()
}

/// All values of an assessed record in units of their channels, bit by bit.
fn values(channels: Vec<Channel>, counts: Vec<i32>) -> Vec<Option<f64>> {
    let layout = Layout { channels: channels.into(), ..VNIMU.clone() };
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    analysis.absorb(&Batch { layout: Some(Arc::new(layout.clone())), counts, ..Batch::default() });
    let snapshot = analysis.snapshot();
    let assessment = Assessment::new(&snapshot, 0.95);
    let mut values: Vec<_> = snapshot.magnitudes.iter().map(|magnitude| Some(magnitude.scale)).collect();
    for ((channel, results), assessed) in layout.channels.iter().zip(&snapshot.channels).zip(&assessment.channels) {
        let moments = &results.moments;
        values.extend([moments.mean_counts(), moments.std_counts()].map(|counts| Some(channel.in_unit(counts?))));
        values.extend([moments.min_counts(), moments.max_counts()].map(|count| Some(channel.value(count?))));
        values.extend(results.octaves.iter().map(|octave| Some(channel.in_unit(octave.deviation_counts()?))));
        let white = assessed.noise.as_ref().and_then(|noise| noise.parameter(Term::White));
        values.push(white.and_then(|white| white.value));
        values.extend(assessed.stationarity.lines.iter().map(|line| Some(line.amplitude)));
    }
    values
}

#[test]
fn a_scale_that_is_a_power_of_two_scales_every_value_exactly() {
    let channels = |bits: i32| {
        let of_floats = |channel: &Channel| Channel { decimals: 0, scale: 2_f64.powi(-bits), ..channel.clone() };
        VNIMU.channels[3..9].iter().map(of_floats).collect::<Vec<_>>()
    };
    let counts = noisy(6, 2000, 77_777);
    let (coarse, fine) = (values(channels(20), counts.clone()), values(channels(27), counts));
    assert!(coarse.iter().flatten().count() > 6 * 12);
    let scaled: Vec<_> = coarse.iter().map(|value| value.map(|value| value / 128.0)).collect();
    assert_eq!(scaled, fine);
}

#[test]
fn a_quaternion_that_changes_its_sign_stands_still() {
    let attitude = [300_000, -400_000, 500_000, 707_107];
    let row = |index: usize| {
        let sign = if index.is_multiple_of(3) { -1 } else { 1 };
        let mut row = vec![0; VNQMR.channels.len()];
        // one count of noise, so that nothing is stuck
        row[..4].copy_from_slice(&attitude.map(|count| sign * (count + (index % 5) as i32)));
        row
    };
    let rows: Vec<i32> = (0..600).flat_map(row).collect();
    let layout = Arc::new(VNQMR.clone());
    let analysed = |rows_per_batch: usize| {
        let mut analysis = Analysis::new(Settings::default());
        for counts in rows.chunks(rows_per_batch * 13) {
            let (layout, mark) = (Some(Arc::clone(&layout)), Mark { before_row: 1, kind: MarkKind::Rejected });
            // a gap of one sample in each batch of two rows or more
            let marks = if counts.len() > 13 && rows_per_batch == 600 { vec![mark] } else { Vec::new() };
            analysis.absorb(&Batch { layout, counts: counts.to_vec(), marks, ..Batch::default() });
        }
        analysis.snapshot()
    };
    for snapshot in [analysed(600), analysed(1), analysed(7)] {
        let sign = -1; // of the first row
        for (channel, expected) in snapshot.channels.iter().zip(attitude) {
            let extremes = (channel.moments.min_counts().unwrap(), channel.moments.max_counts().unwrap());
            let ends = (sign * expected, sign * (expected + 4));
            assert_eq!(extremes, (ends.0.min(ends.1), ends.0.max(ends.1)));
        }
        let assessment = Assessment::new(&snapshot, 0.95);
        assert!(assessment.channels[..4].iter().all(|channel| channel.noise.is_none()));
        assert!(!named(&snapshot, WarningKind::QuantisationFloor).contains(&"quat_x".to_owned()));
    }
}

#[test]
fn a_channel_that_spans_its_full_range_is_exact_and_named() {
    // 34.9 rad/s is 34 900 000 counts; for all other channels with a range it is far outside, for angles it wraps
    let lines: Vec<_> = (0..1000).map(|i| Good(if i % 2 == 0 { 34_900_000 } else { -34_900_000 })).collect();
    let snapshot = analysed(&lines, 64, Settings::default());
    let named = named(&snapshot, WarningKind::FullRange);
    assert!(named.contains(&"gyro_x".to_owned()) && !named.contains(&"yaw".to_owned()));
    let gyro_x = &snapshot.channels[9];
    assert_eq!((gyro_x.moments.mean_counts(), gyro_x.moments.skewness()), (Some(0.0), Some(0.0)));
    let expected = 999 * (2 * 34_900_000_u128).pow(2);
    assert_eq!((gyro_x.octaves[0].terms, gyro_x.octaves[0].sum_squares), (999, Some(expected)));
    assert_eq!(gyro_x.octaves[1].sum_squares, Some(0), "neighbouring pairs have equal sums");

    let half: Vec<_> = (0..200).map(|i| Good(10_000 + i % 5)).collect();
    assert!(!warned(&analysed(&half, 64, Settings::default()), WarningKind::FullRange));
}

#[test]
fn a_lone_value_far_out_is_no_motion() {
    let moved = |values: &mut dyn Iterator<Item = i32>| {
        let lines: Vec<Line> = values.map(Good).collect();
        Assessment::new(&analysed(&lines, 64, Settings::default()), 0.95).motion
    };
    // 2 rad/s and 2000 m/s² for an instant
    let damaged = |index: i32| if index == 400 { -2_000_000 } else { index % 7 };
    assert_eq!(moved(&mut (0..636).map(damaged)), None);
    let swaying = |index: i32| if index / 40 % 2 == 0 { 200_000 } else { -200_000 };
    let motion = moved(&mut (0..636).map(swaying)).unwrap();
    assert_eq!(motion.axes.len(), 6);
}

#[test]
fn skipped_time_is_left_out_with_its_gaps() {
    let settings = Settings { rate_hz: Some(2.0), skip: Duration::from_secs(2), ..Settings::default() };
    // indices 0 1 [2] 3 4 [5] 6, of which the first four are skipped
    let snapshot = analysed(&[Good(0), Good(1), Bad, Good(3), Good(4), Bad, Good(6)], 10, settings);
    let timing = snapshot.timing;
    assert_eq!((timing.excluded, timing.samples, timing.missing, timing.gaps), (3, 2, 1, 1));
    assert_eq!(snapshot.channels[9].moments.min_counts(), Some(4));
    assert_eq!(timing.rate_from, RateFrom::Option);
}

#[test]
fn a_record_in_its_warm_up_is_not_too_short() {
    let lines: Vec<Line> = (0..80).map(Good).collect();
    let skipped = |skip| analysed(&lines, 10, Settings { skip, ..Settings::default() });
    let (within, behind) = (skipped(Duration::from_secs(3)), skipped(Duration::from_millis(1975)));
    assert_eq!((within.timing.samples, within.timing.excluded, behind.timing.samples), (0, 80, 1));
    assert!(!warned(&within, WarningKind::TooShort) && warned(&behind, WarningKind::TooShort));
}

#[test]
fn too_short_is_what_leaves_the_fourth_octave_less_than_ten_degrees_of_freedom() {
    let is_too_short = |samples: u64| {
        let lines: Vec<Line> = (0..samples).map(|i| Good((7 * i % 11) as i32)).collect();
        let snapshot = analysed(&lines, 10, Settings::default());
        let octave = snapshot.channels[9].octaves.get(3).map(imu_noise::OctaveSum::octave);
        let edf = octave.and_then(|octave| imu_noise::edf(&octave, &snapshot.shape(), imu_noise::PowerLaw::White));
        (edf.unwrap_or(0.0) < 10.0, warned(&snapshot, WarningKind::TooShort))
    };
    for samples in [1, 2, 3, 39, 40, 64, 65, 66, 67, 200] {
        let (expected, warns) = is_too_short(samples);
        assert_eq!(warns, expected, "{samples} samples");
    }
}

fn line() -> impl Strategy<Value = Line> {
    prop_oneof![
        20 => any::<i16>().prop_map(|count| Good(count.into())),
        1 => Just(Bad),
        1 => Just(Printed(PrintFormat::Current)),
        1 => Just(Printed(PrintFormat::Old)),
    ]
}

/// Lines give the same in one batch and in several.
pub(crate) fn are_the_same(
    analysed: impl Fn(usize, Settings) -> Snapshot,
    rows: usize,
    skip_s: u64,
) -> Result<(), TestCaseError> {
    let settings = Settings { skip: Duration::from_secs(skip_s), ..Settings::default() };
    let [whole, cut] = [usize::MAX, rows].map(|rows| analysed(rows, settings.clone()));
    prop_assert_eq!(whole.timing, cut.timing);
    prop_assert_eq!(&whole.warnings, &cut.warnings);
    prop_assert_eq!(whole.timing.samples + whole.timing.excluded, whole.link.samples());
    for (a, b) in whole.channels.iter().zip(&cut.channels) {
        prop_assert_eq!(&a.octaves, &b.octaves);
        prop_assert_eq!(&a.moments, &b.moments);
        prop_assert!(a.histogram.bins().eq(b.histogram.bins()));
        prop_assert_eq!(a.branch_counts, b.branch_counts);
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_batches_give_the_same_results(
        lines in prop::collection::vec(line(), 0..300),
        rows in 1..40_usize,
        skip_s in 0..4_u64,
    ) {
        are_the_same(|rows, settings| analysed(&lines, rows, settings), rows, skip_s)?;
    }
}

/// What a measurement came to, as far as two ways to the same samples must agree.
fn result(snapshot: &Snapshot) -> String {
    let channels: Vec<_> = snapshot.channels.iter().map(|c| (&c.moments, &c.histogram, &c.octaves)).collect();
    format!("{:?} {channels:?} {:?}", snapshot.timing, snapshot.warnings)
}

proptest! {
    #[test]
    fn a_warm_up_that_ends_on_the_way_is_a_skip_from_the_start(
        lines in prop::collection::vec(line(), 1..300),
        at in 0_usize..300,
        rows in 1_usize..50,
    ) {
        let at = at.min(lines.len());
        let settings = Settings { rate_hz: Some(40.0), ..Settings::default() };
        let mut analysis = Analysis::new(settings.clone());
        let (before, after) = lines.split_at(at);
        batches(before, rows).iter().for_each(|batch| analysis.absorb(batch));
        let skip = analysis.end_warm_up();
        batches(after, rows).iter().for_each(|batch| analysis.absorb(batch));
        let mut skipped = Analysis::new(Settings { skip, ..settings });
        batches(before, rows).iter().chain(&batches(after, rows)).for_each(|batch| skipped.absorb(batch));
        prop_assert_eq!(result(&analysis.snapshot()), result(&skipped.snapshot()));
    }

    #[test]
    fn starting_over_forgets_all_but_the_link(
        before in prop::collection::vec(line().prop_filter("one format", |line| !matches!(line, Printed(_))), 1..100),
        after in prop::collection::vec(line().prop_filter("one format", |line| !matches!(line, Printed(_))), 1..100),
    ) {
        let settings = Settings { rate_hz: Some(40.0), duration: Some(Duration::from_secs(1)), ..Settings::default() };
        let mut analysis = Analysis::new(settings.clone());
        batches(&before, 7).iter().for_each(|batch| analysis.absorb(batch));
        let samples = analysis.snapshot().timing;
        analysis.start_over();
        let begun = analysis.snapshot().timing;
        prop_assert_eq!((begun.samples, begun.excluded), (0, samples.samples + samples.excluded));
        prop_assert_eq!(analysis.seconds(), 0);
        batches(&after, 7).iter().for_each(|batch| analysis.absorb(batch));
        let (again, fresh) = (analysis.snapshot(), analysed(&after, 7, settings));
        prop_assert_eq!(again.timing.samples, fresh.timing.samples);
        for (again, fresh) in again.channels.iter().zip(&fresh.channels) {
            prop_assert_eq!(&again.moments, &fresh.moments);
            prop_assert_eq!(&again.octaves, &fresh.octaves);
        }
    }
}
