//! Sessions of any events: their published state, their commands, their end. Time is virtual.

use std::{collections::VecDeque, io, sync::Arc, time::Duration};

use tokio::{sync::mpsc, time};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{End, Finding, Settings, Severity, SourceFacts, WarningKind};
use vn100_capture::{Event, Source, read_samples};
use vn100_protocol::{
    DeviceError, VNYMR,
    stream::{Batch, Chunk, CsvReport, FileReport, LinkEvent, LinkEventKind, ReadOptions, StreamInput},
};
use vn100_session::{Command, CommandRefusal, Session, SessionEvent, SessionResult, Stage};

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

fn rows(count: usize) -> Event {
    let layout = Arc::new(VNYMR.clone());
    Batch { counts: vec![0; count * layout.channels.len()], layout: Some(layout), ..Batch::default() }.into()
}

fn end() -> Event {
    Event::End(vn100_capture::End { error: None, report: None })
}

fn at_10_hz() -> Settings {
    Settings { rate_hz: Some(10.0), ..Settings::default() }
}

/// A session, and the sender of its events.
fn session(settings: Settings) -> (mpsc::Sender<Event>, Session) {
    let (events, inbox) = mpsc::channel(1);
    (events, Session::of_events(SourceFacts { name: "a test".into(), ..SourceFacts::default() }, inbox, settings))
}

async fn samples(session: &mut Session, count: u64) {
    session.state.wait_for(|state| state.snapshot.timing.samples == count).await.unwrap();
}

async fn measured(source: impl Source, read: ReadOptions, settings: Settings) -> SessionResult {
    let events = read_samples(source, read, CancellationToken::new());
    Session::of_events(SourceFacts::default(), events, settings).result.await.unwrap()
}

#[tokio::test(start_paused = true)]
async fn a_reader_sees_the_latest_state_and_delays_nothing() {
    let (events, mut session) = session(Settings::default());
    assert!(matches!(session.state.borrow().stage, Stage::Preparing));
    for _ in 0..100 {
        events.send(rows(3)).await.unwrap();
    }
    samples(&mut session, 300).await;
    assert!(matches!(session.state.borrow().stage, Stage::Measuring));
    assert_eq!(session.state.borrow().assessment().samples, 300);
    // not published at once, but a tenth of a second later
    events.send(rows(1)).await.unwrap();
    time::sleep(Duration::from_millis(1)).await;
    assert_eq!(session.state.borrow().snapshot.timing.samples, 300);
    time::sleep(Duration::from_millis(100)).await;
    assert_eq!(session.state.borrow().snapshot.timing.samples, 301);
    assert_eq!(session.state.borrow().assessment().samples, 300, "a twentieth more is not there");
    events.send(end()).await.unwrap();
    let state = session.state.clone();
    let result = session.result.await.unwrap();
    let assessed = result.measured.channels.iter().find_map(|channel| Some(channel.noise.as_ref()?.samples));
    assert_eq!((result.measured.timing.samples, assessed), (301, Some(301)));
    assert!(matches!(*result.end, End::SourceEnded) && result.measured.source.end.is_some() && result.is_restored);
    let last = state.borrow().clone();
    assert!(matches!(last.stage, Stage::Ended(_)) && last.facts().end.is_some() && last.name() == "a test");
    assert_eq!(last.snapshot.timing.samples, 301);
}

#[tokio::test(start_paused = true)]
async fn the_assessment_is_shared_until_the_record_has_grown_by_a_twentieth() {
    let (events, mut session) = session(Settings::default());
    events.send(rows(100)).await.unwrap();
    samples(&mut session, 100).await;
    let (first, other) = (session.state.borrow().clone(), session.state.borrow().clone());
    assert!(Arc::ptr_eq(&first.assessment(), &other.assessment()));
    events.send(rows(4)).await.unwrap();
    samples(&mut session, 104).await;
    assert!(Arc::ptr_eq(&first.assessment(), &session.state.borrow().assessment()));
    events.send(rows(1)).await.unwrap();
    samples(&mut session, 105).await;
    let later = session.state.borrow().clone();
    assert_eq!(later.assessment().samples, 105);
    assert_eq!(later.assessor.exact(&first.snapshot).samples, 100);
    assert_eq!(later.assessment().confidence, 0.95);
}

#[tokio::test(start_paused = true)]
async fn nothing_is_published_without_events() {
    let (events, mut session) = session(Settings::default());
    events.send(rows(5)).await.unwrap();
    samples(&mut session, 5).await;
    session.state.mark_unchanged();
    time::sleep(Duration::from_secs(60)).await;
    assert!(!session.state.has_changed().unwrap());
    drop(events);
}

#[tokio::test(start_paused = true)]
async fn the_requested_time_ends_it() {
    let (events, session) = session(Settings { duration: Some(Duration::from_secs(2)), ..at_10_hz() });
    for _ in 0..20 {
        events.send(rows(1)).await.unwrap();
    }
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::DurationReached));
    assert_eq!(result.measured.timing.samples, 20);
    assert!(events.is_closed());
}

#[tokio::test(start_paused = true)]
async fn a_goal_that_the_message_cannot_show_ends_it_at_once() {
    for (goal, ends) in [("gyro B ±20%", true), ("gyro_x K ±20%", true), ("gyro N ±0.001%", false)] {
        let (events, session) = session(Settings { until: vec![goal.parse().unwrap()], ..at_10_hz() });
        events.send(rows(1)).await.unwrap();
        let goes_on = events.send(rows(1)).await.is_ok() && events.send(rows(1)).await.is_ok();
        assert_eq!(goes_on, !ends, "{goal}");
        if !ends {
            events.send(end()).await.unwrap();
        }
        let result = session.result.await.unwrap();
        assert_eq!(matches!(*result.end, End::GoalsDecided), ends, "{goal}");
        let [unmet] = &result.unmet[..] else { panic!("{:?}", result.unmet) };
        assert_eq!(result.measured.out_of_reach(unmet).is_some(), ends, "{goal}");
    }
}

#[tokio::test]
async fn the_error_of_the_source_comes_with_the_results_before_it() {
    let (events, session) = session(Settings::default());
    events.send(rows(5)).await.unwrap();
    events
        .send(Event::End(vn100_capture::End { error: Some(io::Error::other("unplugged")), report: None }))
        .await
        .unwrap();
    let result = session.result.await.unwrap();
    assert_eq!(result.measured.timing.samples, 5);
    assert_eq!(*result.end, End::SourceFailed("unplugged".into()));
}

#[tokio::test]
async fn a_source_that_vanishes_without_an_end_is_an_error() {
    let (events, session) = session(Settings::default());
    events.send(rows(5)).await.unwrap();
    drop(events);
    let result = session.result.await.unwrap();
    assert_eq!(result.measured.timing.samples, 5);
    assert!(matches!(*result.end, End::SourceFailed(_)));
}

#[tokio::test]
async fn times_of_rows_since_1970_give_the_start_of_the_record() {
    let epoch_ns = 1_761_939_167_192_566_000;
    for (times, first_ns, expected) in [
        ("t:s", epoch_ns, Some(epoch_ns)),
        ("secs:s+nsecs:ns", epoch_ns, Some(epoch_ns)),
        ("t:s", 5_000_000_000, None),
        // in an unknown time zone
        ("date:iso", epoch_ns, None),
    ] {
        let (events, session) = session(Settings::default());
        let csv = CsvReport { times: Some(times.into()), first_stamp_ns: Some(first_ns), ..CsvReport::default() };
        events.send(Event::End(vn100_capture::End { error: None, report: Some(FileReport::Csv(csv)) })).await.unwrap();
        let recording = session.result.await.unwrap().measured.source.recording;
        assert_eq!(recording.and_then(|recording| recording.started_ns), expected, "{times}");
    }
}

#[tokio::test(start_paused = true)]
async fn the_warm_up_is_ended_and_the_measurement_started_over_by_command() {
    let (events, mut session) = session(at_10_hz());
    events.send(rows(50)).await.unwrap();
    samples(&mut session, 50).await;
    session.commands.send(Command::EndWarmUp).await.unwrap();
    let ended = session.events.recv().await;
    let five = Duration::from_secs(5);
    let Some(SessionEvent::WarmUpEnded { warm_up, excluded }) = ended else { panic!("{ended:?}") };
    assert_eq!((warm_up, excluded), (five, five));
    events.send(rows(20)).await.unwrap();
    samples(&mut session, 20).await;
    assert_eq!(session.state.borrow().snapshot.timing.excluded, 50);
    session.commands.send(Command::StartOver).await.unwrap();
    let over = session.events.recv().await;
    let Some(SessionEvent::StartedOver { after }) = over else { panic!("{over:?}") };
    assert_eq!(after, Duration::from_secs(7));
    events.send(rows(8)).await.unwrap();
    // commands for a playback, which does not exist here
    for command in [Command::TogglePause, Command::Faster, Command::Slower] {
        session.commands.send(command).await.unwrap();
    }
    events.send(end()).await.unwrap();
    let result = session.result.await.unwrap();
    let timing = result.measured.timing;
    assert_eq!((timing.samples, timing.excluded), (8, 70));
    assert_eq!(result.excluded, Duration::from_secs(7));
    assert!(session.events.recv().await.is_none());
}

#[tokio::test(start_paused = true)]
async fn a_command_stops_it_with_the_result_so_far() {
    let (events, mut session) = session(at_10_hz());
    events.send(rows(50)).await.unwrap();
    samples(&mut session, 50).await;
    session.commands.send(Command::Stop).await.unwrap();
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::Stopped));
    assert_eq!(result.measured.timing.samples, 50);
    assert!(events.is_closed());
}

#[tokio::test(start_paused = true)]
async fn without_a_link_there_is_nothing_to_mark() {
    let (_events, mut session) = session(at_10_hz());
    session.commands.send(Command::Mark("the door".into())).await.unwrap();
    let told = time::timeout(Duration::from_secs(1), session.events.recv()).await.unwrap();
    assert!(matches!(told, Some(SessionEvent::Refused(CommandRefusal::NoMark))), "{told:?}");
}

/// The inputs of a link, in sequence.
struct Script(VecDeque<StreamInput>);

impl Source for Script {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        Ok(self.0.pop_front())
    }
}

#[tokio::test]
async fn unsolicited_device_errors_are_warnings_to_the_end() {
    let read = |bytes: &[u8]| StreamInput::Chunk(Chunk { bytes: bytes.to_vec().into(), at_ns: None });
    let refused = LinkEventKind::UnsolicitedError { error: DeviceError::InvalidCommand };
    let (full, restarted) = (read(b"$VNERR,0B*03\r\n"), read(b"$VNERR,01*70\r\n"));
    // the last but one answers a question from another time
    let answer = read(b"$VNERR,08*79\r\n");
    let link = StreamInput::Link(LinkEvent { at_ns: 0, kind: refused });
    let inputs = [read(LINE), full.clone(), full, restarted, link, answer, read(LINE)];
    let snapshot = measured(Script(inputs.into()), ReadOptions::default(), Settings::default()).await.measured;
    let warnings: Vec<_> = (snapshot.warnings.iter())
        .filter(|warning| warning.kind == WarningKind::LinkErrors)
        .map(|warning| (warning.finding.clone(), warning.severity))
        .collect();
    let errors = [
        (DeviceError::OutputBufferOverflow, 2, Severity::Problem),
        (DeviceError::from_code(1), 1, Severity::Caution),
        (DeviceError::InvalidCommand, 1, Severity::Caution),
    ];
    assert_eq!(warnings, errors.map(|(error, count, severity)| (Finding::DeviceError(error, count), severity)));
}

/// Lines of 1 Hz, each with the time of its read.
fn lines_of_1_hz(lines: i64) -> Script {
    let chunk = |second| Chunk { bytes: LINE.to_vec().into(), at_ns: Some(1_000_000_000 * second) };
    Script((0..lines).map(|second| StreamInput::Chunk(chunk(second))).collect())
}

/// A source that stays open after all its inputs.
struct Open(Script);

impl Source for Open {
    async fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        match self.0.next_input().await? {
            Some(input) => Ok(Some(input)),
            None => std::future::pending().await,
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_requested_time_ends_lines_of_unknown_rate_live_and_in_a_replay() {
    let settings = Settings { duration: Some(Duration::from_secs(5)), ..Settings::default() };
    let options = ReadOptions { line_by_line: true, ..ReadOptions::default() };
    let live = measured(Open(lines_of_1_hz(7)), options, settings.clone());
    let live = time::timeout(Duration::from_secs(60), live).await.unwrap().measured;
    assert_eq!((live.timing.samples, live.timing.excluded, live.timing.rate_hz), (5, 2, Some(1.0)));
    for lines in [7, 8, 600] {
        let replay = measured(lines_of_1_hz(lines), options, settings.clone()).await.measured;
        assert_eq!(replay.timing, live.timing, "{lines} lines recorded");
        assert!(
            replay
                .channels
                .iter()
                .zip(&live.channels)
                .all(|(replay, live)| replay.statistics.mean == live.statistics.mean)
        );
    }
}
