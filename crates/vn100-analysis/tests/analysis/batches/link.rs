//! What counters, the sensor's own words and losses of the link make of a record.

use vn100_analysis::{Finding, Rejected, Warning};

use super::*;

#[test]
fn counters_tell_exactly_what_is_missing() {
    // a bad line between lines 9 and 11; lines 20 to 22 lost whole
    let counts = (0..=9).chain(11..=19).chain(23..=40);
    let mut lines = vec![Good(1); counts.clone().count()];
    lines.insert(10, Bad);
    let mut all = batches(&lines, 1000);
    all[0].counters = counts.enumerate().map(|(row, count)| RowCounter { row, count: 100 + 20 * count }).collect();
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&all[0]);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.gaps, timing.segments), (37, 4, 2, 3));
    assert_eq!(timing.missing_from, MissingFrom::Counter);
    assert!(snapshot.arrivals.is_none());
}

#[test]
fn a_mark_is_placed_behind_the_data_before_it_and_breaks_nothing() {
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    for text in ["begun", "heater on", "door"] {
        analysis.take_link_event(&LinkEvent { at_ns: 0, kind: LinkEventKind::Marked { text: text.into() } });
        batches(&[Good(1); 80], 50).iter().for_each(|batch| analysis.absorb(batch));
    }
    let snapshot = analysis.snapshot();
    let marks: Vec<_> = snapshot.marks.iter().map(|mark| (mark.at_s, mark.text.as_str())).collect();
    assert_eq!(marks, [(0.0, "begun"), (2.0, "heater on"), (4.0, "door")]);
    assert_eq!((snapshot.timing.samples, snapshot.timing.segments), (240, 1));
}

#[test]
fn the_sensor_tells_its_rate() {
    let told = |fields: &str, settings: Settings| {
        let mut all = batches(&[Good(1), Good(2)], 10);
        let fields = fields.to_owned();
        all[0].registers.push(RegisterContents { register: Register(7), fields: RegisterFields::new(fields).unwrap() });
        let mut analysis = Analysis::new(settings);
        all.iter().for_each(|batch| analysis.absorb(batch));
        analysis.snapshot()
    };
    let snapshot = told("100,1", Settings::default());
    assert_eq!((snapshot.timing.rate_hz, snapshot.timing.rate_from), (100.0, RateFrom::Device));
    assert!(!warned(&snapshot, WarningKind::RateAssumed));
    assert_eq!(snapshot.registers[&7], "100,1");
    assert_eq!(told("0", Settings::default()).timing.rate_from, RateFrom::Assumed);
    assert_eq!(told("?", Settings::default()).timing.rate_from, RateFrom::Assumed);
    let asked = Settings { rate_hz: Some(50.0), ..Settings::default() };
    assert_eq!(told("100", asked).timing.rate_hz, 50.0);
}

#[test]
fn a_sensor_that_replies_and_sends_packets_is_not_said_to_send_nothing() {
    let tally = Tally { replies: 9, valid_sentence_bytes: 200, packets: 548, packet_bytes: 9864, ..Tally::default() };
    let link = StreamCounts { connects: 1, tally, ..StreamCounts::default() };
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&Batch { link, ..Batch::default() });
    let warnings = analysis.snapshot().warnings;
    let told = &warnings.iter().find(|warning| warning.kind == WarningKind::NoValidLines).unwrap().finding;
    assert!(matches!(told, Finding::NothingMeasured(548, _, None)), "{told:?}");
}

#[test]
fn bytes_without_any_line_are_named() {
    let mut analysis = Analysis::new(Settings::default());
    let tally = Tally { skipped_bytes: 4000, ..Tally::default() };
    analysis.absorb(&Batch { link: StreamCounts { tally, ..StreamCounts::default() }, ..Batch::default() });
    let warnings = analysis.snapshot().warnings;
    let named = warnings.iter().find(|warning| warning.kind == WarningKind::NoValidLines);
    assert_eq!(named.map(|warning| &warning.finding), Some(&Finding::NoSentence(4000)));
}

#[test]
fn a_sensor_that_only_replies_is_told_by_its_output_register() {
    let told = |output: Option<&str>| {
        let tally = Tally { replies: 9, valid_sentence_bytes: 200, ..Tally::default() };
        let link = StreamCounts { connects: 1, tally, ..StreamCounts::default() };
        let registers = output
            .map(|fields| RegisterContents { register: Register(6), fields: RegisterFields::new(fields).unwrap() });
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&Batch { link, registers: registers.into_iter().collect(), ..Batch::default() });
        let warnings = analysis.snapshot().warnings;
        warnings.iter().find(|warning| warning.kind == WarningKind::NoValidLines).unwrap().finding.clone()
    };
    for off in [None, Some("0"), Some("0,1")] {
        assert_eq!(told(off), Finding::OnlyReplies(9, None));
    }
    assert_eq!(told(Some("14")), Finding::OnlyReplies(9, Some("14".into())));
}

#[test]
fn replies_beside_damaged_lines_are_no_sign_that_the_output_is_off() {
    let is_off = |rejected: u64, rejected_sentence_bytes: u64| {
        let rejected = RejectedCounts { checksum: rejected, ..RejectedCounts::default() };
        let tally =
            Tally { replies: 50, valid_sentence_bytes: 1000, rejected, rejected_sentence_bytes, ..Tally::default() };
        let link = StreamCounts { connects: 1, tally, ..StreamCounts::default() };
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&Batch { link, ..Batch::default() });
        let warnings = analysis.snapshot().warnings;
        warnings.iter().any(|warning| matches!(warning.finding, Finding::OnlyReplies(_, None)))
    };
    // a tenth of the answers, and of their bytes
    assert!(is_off(0, 0) && is_off(5, 100));
    assert!(!is_off(6, 100) && !is_off(5, 101));
}

#[test]
fn a_sensor_that_comes_back_at_another_rate_is_left_out() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let at = |rate_hz: &str, lines: &[Line]| {
        let mut all = batches(lines, 10);
        all[0]
            .registers
            .push(RegisterContents { register: Register(7), fields: RegisterFields::new(rate_hz).unwrap() });
        all
    };
    let told = |settings: Settings| {
        let mut analysis = Analysis::new(settings);
        at("40", &[Good(1), Good(2)]).iter().for_each(|batch| analysis.absorb(batch));
        analysis.take_link_event(&down);
        at("20", &[Good(3), Good(4), Good(5)]).iter().for_each(|batch| analysis.absorb(batch));
        analysis.snapshot()
    };
    let snapshot = told(Settings::default());
    assert_eq!((snapshot.timing.samples, snapshot.timing.excluded, snapshot.timing.rate_hz), (2, 3, 40.0));
    assert!(warned(&snapshot, WarningKind::StreamChanged));
    let asked = Settings { rate_hz: Some(40.0), ..Settings::default() };
    assert_eq!(told(asked).timing.samples, 5, "whoever gives a rate knows it");
    let late = Settings { skip: Duration::from_secs_f64(2.0 / 40.0), ..Settings::default() };
    let snapshot = told(late);
    assert_eq!((snapshot.timing.samples, snapshot.timing.rate_hz), (3, 20.0), "the first part was to be left out");
}

fn two_sensors(is_excluded: bool) -> Finding {
    Finding::TwoSensors(["0100099887".into(), "0100012345".into()], is_excluded)
}

fn found_in(snapshot: &Snapshot, finding: &Finding) -> bool {
    snapshot.warnings.iter().any(|warning| warning.finding == *finding)
}

#[test]
fn two_sensors_in_one_stream_are_told() {
    let told = |serials: [&str; 2]| {
        let mut all = batches(&[Good(1), Good(2)], 1);
        for (batch, serial) in all.iter_mut().zip(serials) {
            batch
                .registers
                .push(RegisterContents { register: Register(3), fields: RegisterFields::new(serial).unwrap() });
        }
        let mut analysis = Analysis::new(Settings::default());
        all.iter().for_each(|batch| analysis.absorb(batch));
        analysis.snapshot()
    };
    assert!(!warned(&told(["0100099887", "0100099887"]), WarningKind::StreamChanged));
    let snapshot = told(["0100099887", "0100012345"]);
    assert!(found_in(&snapshot, &two_sensors(false)), "{:?}", snapshot.warnings);
}

#[test]
fn of_two_sensors_the_one_whose_samples_count_is_named() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "recording ended and resumed".into() } };
    let (first, second) = ([(7, "200"), (3, "0100099887")], [(3, "0100012345"), (7, "40")]);
    let told = |second: [(u8, &str); 2]| {
        let mut analysis = Analysis::new(Settings::default());
        for registers in [first, second] {
            let mut all = batches(&[Good(1), Good(2)], 10);
            let value = |(register, fields): (u8, &str)| RegisterContents {
                register: Register(register),
                fields: RegisterFields::new(fields).unwrap(),
            };
            all[0].registers = registers.map(value).into();
            all.iter().for_each(|batch| analysis.absorb(batch));
            analysis.take_link_event(&down);
        }
        analysis.snapshot()
    };
    let reversed = [second[1], second[0]];
    for snapshot in [told(second), told(reversed)] {
        assert_eq!((snapshot.timing.samples, snapshot.timing.excluded), (2, 2));
        assert_eq!((&*snapshot.registers[&3], &*snapshot.registers[&7]), ("0100099887", "200"));
        assert!(found_in(&snapshot, &two_sensors(true)), "{:?}", snapshot.warnings);
    }
    // at the same rate both count
    let snapshot = told([(3, "0100012345"), (7, "200")]);
    assert!(found_in(&snapshot, &two_sensors(false)), "{:?}", snapshot.warnings);
}

#[test]
fn a_lost_link_breaks_the_segment_and_bridges_nothing() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let mut analysis = Analysis::new(Settings::default());
    analysis.take_link_event(&down);
    batches(&[Good(1), Good(2)], 10).iter().for_each(|batch| analysis.absorb(batch));
    analysis.take_link_event(&down);
    batches(&[Good(9), Good(8)], 10).iter().for_each(|batch| analysis.absorb(batch));
    let snapshot = analysis.snapshot();
    assert_eq!((snapshot.timing.samples, snapshot.timing.segments, snapshot.timing.missing), (4, 2, 0));
    assert_eq!(snapshot.channels[3].octaves[0].terms, 2, "one window on each side, none across");
    // however often it is lost then, nothing follows that could be a segment
    analysis.take_link_event(&down);
    analysis.take_link_event(&down);
    assert_eq!(analysis.snapshot().timing.segments, 2);
    batches(&[Good(7)], 10).iter().for_each(|batch| analysis.absorb(batch));
    assert_eq!(analysis.snapshot().timing.segments, 3);
}

/// Rows with these times of the sensor at 800 Hz, in ticks, that arrive as they are measured; the
/// clock of the host began `host_ticks` before that of the sensor.
fn by_device_time(ticks: impl IntoIterator<Item = u64>, host_ticks: u64) -> Batch {
    const TICK_NS: u64 = 1_250_000;
    let ticks: Vec<u64> = ticks.into_iter().collect();
    let mut batch = batches(&vec![Good(1); ticks.len()], usize::MAX).remove(0);
    batch.device_ns = ticks.iter().map(|tick| tick * TICK_NS).collect();
    let at_ns = |tick: &u64| i64::try_from((tick + host_ticks) * TICK_NS).unwrap();
    batch.arrivals =
        ticks.iter().enumerate().map(|(from_row, tick)| Arrival { from_row, at_ns: at_ns(tick) }).collect();
    batch
}

#[test]
fn the_time_of_the_sensor_shows_how_many_samples_an_outage_cost() {
    let down = LinkEvent { at_ns: 0, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let over = |next: Batch| {
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&by_device_time(0..1000, 9000));
        analysis.take_link_event(&down);
        // what stands between the connections is no sample
        let mark = Mark { before_row: 0, kind: MarkKind::Rejected };
        analysis.absorb(&Batch { layout: next.layout.clone(), marks: vec![mark], ..Batch::default() });
        analysis.absorb(&next);
        analysis.finish();
        let snapshot = analysis.snapshot();
        let timing = snapshot.timing;
        assert_eq!((timing.rate_hz, timing.rate_from), (800.0, RateFrom::DeviceTime));
        (timing.samples, timing.missing, timing.segments, snapshot.restarts)
    };
    assert_eq!(over(by_device_time(3000..4000, 9000)), (2000, 2000, 2, 0));
    assert_eq!(over(by_device_time(1000..2000, 9000)), (2000, 0, 1, 0), "nothing was lost");
    // the power was lost too: the clock starts anew; or another sensor, whose time is another
    let by_restart = over(by_device_time(5..1000, 12_000));
    assert_eq!((by_restart.0, by_restart.2, by_restart.3), (1995, 2, 1));
    let by_another = over(by_device_time(70_000..71_000, 12_000));
    assert_eq!((by_another.0, by_another.2, by_another.3), (2000, 2, 0));
}

#[test]
fn a_step_of_the_time_of_the_sensor_is_no_data_time() {
    let hour = Some(Duration::from_secs(3600));
    let mut analysis = Analysis::new(Settings { duration: hour, ..Settings::default() });
    let mut batch = by_device_time(0..4000, 0);
    batch.device_ns[800..].iter_mut().for_each(|ns| *ns += 7_200_000_000_000);
    analysis.absorb(&batch);
    assert!(!analysis.is_complete());
    analysis.finish();
    let snapshot = analysis.snapshot();
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.segments, snapshot.time_steps), (4000, 0, 2, 1));
    assert!(found_in(&snapshot, &Finding::TimeSteps(1)), "{:?}", snapshot.warnings);
}

#[test]
fn packets_at_a_rate_that_no_sensor_or_register_has_are_told() {
    let told = |period_ns: u64, register: Option<&str>| {
        let mut batch = by_device_time(0..4000, 0);
        batch.layout = vn100_protocol::PacketForm::new(5, &[1, 0x1C]).map(|form| form.layout);
        batch.counts = vec![7; 4000 * batch.layout.as_ref().unwrap().channels.len()];
        batch.device_ns = (0..4000).map(|row| row * period_ns).collect();
        let register = register
            .map(|fields| RegisterContents { register: Register(75), fields: RegisterFields::new(fields).unwrap() });
        batch.registers.extend(register);
        let mut analysis = Analysis::new(Settings::default());
        analysis.absorb(&batch);
        analysis.finish();
        let warnings = analysis.snapshot().warnings;
        let warning = warnings.iter().find(|warning| warning.kind == WarningKind::RateOffNominal);
        warning.map(|warning| warning.finding.clone())
    };
    assert_eq!(told(1_250_000, None), None);
    let Some(Finding::PacketRate(hz)) = told(1_700_000, None) else { panic!() };
    assert!((hz - 588.235).abs() < 1e-2, "{hz}");
    assert!(matches!(told(1_000_000, None), Some(Finding::PacketRate(_))));
    for same in ["1,4,05,0001,001C", "0,4,05,0001,001C", "1,0,05,0001,001C", "?"] {
        assert_eq!(told(5_000_000, Some(same)), None, "{same}");
    }
    assert_eq!(told(5_000_000, Some("1,1,05,0001,001C")), Some(Finding::RegisterRate(75, 800.0, 200.0)));
}

#[test]
fn a_packet_with_a_false_time_is_no_sample() {
    let mut analysis = Analysis::new(Settings::default());
    let ticks = (0..2000).map(|tick| if tick == 700 { 1 << 30 } else { tick });
    let mut batch = by_device_time(ticks, 0);
    let width = batch.counts.len() / 2000;
    batch.counts[700 * width..701 * width].fill(30_000);
    analysis.absorb(&batch);
    analysis.finish();
    let snapshot = analysis.snapshot();
    let timing = snapshot.timing;
    assert_eq!((timing.samples, timing.missing, timing.segments, snapshot.restarts), (1999, 1, 2, 0));
    assert_eq!(snapshot.false_times, 1);
    assert!(snapshot.channels.iter().all(|channel| channel.moments.max_counts() == Some(1)), "its values do not count");
    let is_false = |warning: &Warning| matches!(warning.finding, Finding::Rejected(Rejected::PacketTimes, 1, _));
    assert!(snapshot.warnings.iter().any(is_false), "{:?}", snapshot.warnings);
}

#[test]
fn the_time_without_a_link_is_reported_where_the_events_contain_it() {
    let down = |at_ns| LinkEvent { at_ns, kind: LinkEventKind::Down { cause: "unplugged".into() } };
    let up = |at_ns| LinkEvent { at_ns, kind: LinkEventKind::Up { port: "COM3".into(), baud: None } };
    let told = |events: &[LinkEvent]| {
        let mut analysis = Analysis::new(Settings::default());
        events.iter().for_each(|event| analysis.take_link_event(event));
        let outages = analysis.snapshot().outages;
        (outages.times, outages.seconds())
    };
    let second = 1_000_000_000;
    assert_eq!(told(&[up(0)]), (0, None));
    assert_eq!(told(&[up(0), down(10 * second), up(14 * second)]), (1, Some(4.0)));
    let twice = [up(0), down(second), up(3 * second), down(7 * second), up(8 * second)];
    assert_eq!(told(&twice), (2, Some(3.0)));
    assert_eq!(told(&twice[..4]), (2, None), "it has not come back");
    assert_eq!(told(&[up(0), down(9 * second), up(second)]), (1, None), "the clock was set back");
    let closed = |at_ns| LinkEvent { at_ns, kind: LinkEventKind::Closed };
    let lost = [up(0), down(second), up(3 * second), down(7 * second), closed(12_177_902_500)];
    assert_eq!(told(&lost), (2, Some(7.178)), "the last outage lasted until the end");
    let resumed = [&lost[..], &[down(12_177_902_500), up(14 * second)]].concat();
    assert_eq!(told(&resumed), (2, Some(9.0)), "it lasted until the recording was resumed");
    assert_eq!(told(&[up(0), closed(second)]), (0, None), "it was not lost");

    // a link that falls silent is given up later
    let mut analysis = Analysis::new(Settings::default());
    let mut batch = batches(&[Good(1), Good(2)], 10).remove(0);
    batch.arrivals = (0..2).map(|row| Arrival { from_row: row, at_ns: (3 + row as i64) * second }).collect();
    analysis.absorb(&batch);
    [down(9 * second), up(11 * second)].iter().for_each(|event| analysis.take_link_event(event));
    assert_eq!(analysis.snapshot().outages.seconds(), Some(7.0), "since the last line");
    [down(12 * second), up(13 * second)].iter().for_each(|event| analysis.take_link_event(event));
    assert_eq!(analysis.snapshot().outages.seconds(), Some(8.0), "nothing came between");
}
