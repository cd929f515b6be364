//! Sessions of a live sensor, from its configuration to the end of its recording, in virtual time.

mod settings;
mod wall_limits;

use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::Duration,
};

use crate::support::{LINE, OTHER_LINE, Sensor};
use tempfile::TempDir;
use tokio::time;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{End, EndKind, LinkStatus, Settings};
use vn100_capture::{Event, RecordError, RecordingReader, Rotation};
use vn100_driver::{ConfigureError, LinkState, OutputLeft, OutputSettings};
use vn100_protocol::stream::{LinkEvent, LinkEventKind, StreamInput};
use vn100_session::{
    Command, LiveError, LiveSource, LiveSpec, RateEvent, RecordingSpec, ReplaySpec, Session, SessionEvent,
    SessionResult, SetupError, SourceState, Stage, StartError, WallLimits,
};

fn sensor() -> Sensor {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().registers.insert(30, "0,0,0,0,1,0,1".into());
    sensor
}

fn spec(mut source: LiveSource) -> LiveSpec {
    source.options.baud = Some(115_200);
    LiveSpec {
        name: "imu".into(),
        kind: Some("serial"),
        source: Ok(source),
        settings: Settings::default(),
        temperature: false,
        output: None,
        conditions: BTreeMap::new(),
        recording: None,
        each_second: false,
        samples: None,
        limits: WallLimits::default(),
        stop: CancellationToken::new(),
    }
}

fn of(sensor: &Sensor) -> LiveSpec {
    spec(LiveSource::link(sensor.clone()))
}

fn duration(seconds: u64) -> Settings {
    Settings { duration: Some(Duration::from_secs(seconds)), ..Settings::default() }
}

fn recording(folder: &TempDir) -> Option<RecordingSpec> {
    let path = folder.path().join("bench.mcap");
    Some(RecordingSpec { path, resume: false, rotation: None })
}

/// The recorded reason of the end.
fn reason(path: &Path) -> String {
    let mut reader = RecordingReader::open(std::fs::File::open(path).unwrap()).unwrap();
    while reader.next_input().unwrap().is_some() {}
    reader.recorded().end.get().unwrap().reason.clone().unwrap()
}

async fn until(session: &mut Session, is_there: impl FnMut(&SourceState) -> bool) -> SourceState {
    session.state.wait_for(is_there).await.unwrap().clone()
}

async fn ended(session: Session) -> (SessionResult, Vec<SessionEvent>) {
    let Session { mut events, result, .. } = session;
    let result = result.await.unwrap();
    let mut all = Vec::new();
    while let Some(event) = events.recv().await {
        all.push(event);
    }
    (result, all)
}

fn rate(rate_hz: u32) -> Option<OutputSettings> {
    Some(OutputSettings { rate_hz: Some(rate_hz), ..OutputSettings::default() })
}

#[tokio::test(start_paused = true)]
async fn a_sensor_is_measured_for_the_requested_time() {
    let sensor = sensor();
    let conditions = BTreeMap::from([("place".to_owned(), "bench".to_owned())]);
    let mut session = Session::live(LiveSpec { settings: duration(3), conditions: conditions.clone(), ..of(&sensor) });
    assert!(matches!(session.state.borrow().stage, Stage::Preparing));
    let up = until(&mut session, |state| matches!(state.link, Some(LinkState::Up(_)))).await;
    assert!(matches!(up.stage, Stage::Measuring));
    let facts = up.facts();
    assert_eq!(
        (facts.name.as_str(), facts.kind, facts.meta, facts.end),
        ("imu", Some("serial"), Some(conditions), None)
    );
    let link = facts.link.unwrap();
    assert_eq!(
        (link.status, link.baud, link.port.as_deref()),
        (LinkStatus::Connected, Some(115_200), Some("/dev/imu"))
    );
    let state = session.state.clone();
    let (result, events) = ended(session).await;
    assert!(matches!(*result.end, End::DurationReached), "{:?}", result.end);
    assert_eq!(result.measured.timing.samples, 120);
    let assessed = result.measured.channels.iter().find_map(|channel| Some(channel.noise.as_ref()?.samples));
    assert_eq!((assessed, result.excluded), (Some(120), Duration::ZERO));
    assert!(
        result.unmet.is_empty()
            && result.recording.is_none()
            && result.is_restored
            && result.measured.source.end.is_some()
    );
    assert!(events.is_empty(), "{events:?}");
    let state = state.borrow().clone();
    assert!(matches!(&state.stage, Stage::Ended(reason) if Arc::ptr_eq(reason, &result.end)));
    assert!(state.facts().end.is_some() && matches!(state.link, Some(LinkState::Closed { .. })));
    assert_eq!(state.facts().link.unwrap().status, LinkStatus::Closed);
}

#[tokio::test(start_paused = true)]
async fn a_session_is_stopped_by_a_command_or_by_its_token() {
    for by_command in [true, false] {
        let sensor = sensor();
        let spec = of(&sensor);
        let stop = spec.stop.clone();
        let mut session = Session::live(spec);
        until(&mut session, |state| state.snapshot.timing.samples > 50).await;
        if by_command {
            session.commands.send(Command::Stop).await.unwrap();
        } else {
            stop.cancel();
        }
        let (result, _) = ended(session).await;
        assert!(matches!(*result.end, End::Stopped));
        assert!(result.measured.timing.samples > 50);
        assert_eq!(stop.is_cancelled(), !by_command, "the session alone ends");
    }
}

#[tokio::test(start_paused = true)]
async fn a_silent_sensor_is_an_error_of_the_source() {
    let sensor = sensor();
    sensor.world().plugged = false;
    let (result, _) = ended(Session::live(of(&sensor))).await;
    assert!(matches!(*result.end, End::SourceFailed(_)), "{:?}", result.end);
    assert_eq!(result.measured.timing.samples, 0);
}

#[tokio::test(start_paused = true)]
async fn the_link_and_its_loss_are_shown() {
    let sensor = sensor();
    let mut session = Session::live(of(&sensor));
    until(&mut session, |state| state.snapshot.timing.samples > 50).await;
    sensor.world().plugged = false;
    let down = until(&mut session, |state| matches!(state.link, Some(LinkState::Down { .. }))).await;
    let link = down.facts().link.unwrap();
    assert_eq!(link.status, LinkStatus::Lost);
    assert!(link.cause.is_some());
    sensor.world().plugged = true;
    until(&mut session, |state| state.snapshot.link.connects == 2).await;
    session.commands.send(Command::Stop).await.unwrap();
    assert!(ended(session).await.0.measured.timing.samples > 50);
}

#[tokio::test(start_paused = true)]
async fn a_recording_can_be_replayed_to_the_same_end() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let conditions = BTreeMap::from([("place".to_owned(), "bench".to_owned())]);
    let spec = LiveSpec { settings: duration(3), conditions: conditions.clone(), ..of(&sensor) };
    let session = Session::live(LiveSpec { recording: recording(&folder), ..spec });
    let state = session.state.clone();
    let (result, _) = ended(session).await;
    let recording = result.recording.unwrap();
    assert!(recording.ended && recording.error.is_none() && recording.bytes >= 120 * LINE.len() as u64);
    assert_eq!(state.borrow().facts().recorder.unwrap().bytes, recording.bytes);
    assert_eq!(reason(&recording.path), "duration reached");
    let replay = Session::replay(ReplaySpec::of(recording.path)).result.await.unwrap();
    assert!(matches!(*replay.end, End::DurationReached));
    assert_eq!(replay.measured.timing.samples, result.measured.timing.samples);
    assert!(replay.measured.source.recording.unwrap().started_ns.is_some());
    assert_eq!((replay.measured.source.kind, replay.measured.source.meta), (Some("mcap"), Some(conditions)));
}

#[tokio::test(start_paused = true)]
async fn a_mark_is_at_its_place_in_the_recording() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { recording: recording(&folder), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples >= 40).await;
    session.commands.send(Command::Mark("the door".into())).await.unwrap();
    until(&mut session, |state| state.snapshot.timing.samples >= 80).await;
    session.commands.send(Command::Stop).await.unwrap();
    let (result, events) = ended(session).await;
    assert!(events.is_empty(), "{events:?}");
    let marks = marks(result);
    let [(text, before)] = &marks[..] else { panic!("{marks:?}") };
    assert_eq!(text, "the door");
    assert!((40..60).contains(&(before / LINE.len())), "{marks:?}");
}

/// The marks in the recording of a session, each with the bytes before it.
fn marks(result: SessionResult) -> Vec<(String, usize)> {
    let file = std::fs::File::open(result.recording.unwrap().path).unwrap();
    let mut reader = RecordingReader::open(file).unwrap();
    let (mut bytes, mut marks) = (0, Vec::new());
    while let Some(input) = reader.next_input().unwrap() {
        match input {
            StreamInput::Chunk(chunk) => bytes += chunk.bytes.len(),
            StreamInput::Link(LinkEvent { kind: LinkEventKind::Marked { text }, .. }) => marks.push((text, bytes)),
            StreamInput::Link(_) => {}
        }
    }
    marks
}

#[tokio::test(start_paused = true)]
async fn a_mark_just_before_the_end_is_kept() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { recording: recording(&folder), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples >= 40).await;
    session.commands.send(Command::Mark("the end".into())).await.unwrap();
    session.commands.send(Command::Stop).await.unwrap();
    let (result, events) = ended(session).await;
    assert!(events.is_empty(), "{events:?}");
    let marks = marks(result);
    assert!(matches!(&marks[..], [(text, _)] if text == "the end"), "{marks:?}");
}

#[tokio::test(start_paused = true)]
async fn time_excluded_by_command_is_noted_in_the_recording() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { recording: recording(&folder), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples >= 100).await;
    session.commands.send(Command::EndWarmUp).await.unwrap();
    until(&mut session, |state| state.snapshot.timing.excluded >= 100 && state.snapshot.timing.samples > 10).await;
    session.commands.send(Command::Stop).await.unwrap();
    let (result, events) = ended(session).await;
    let [SessionEvent::WarmUpEnded { warm_up, excluded }] = events[..] else { panic!("{events:?}") };
    assert_eq!((warm_up, excluded), (result.excluded, result.excluded));
    assert!(excluded >= Duration::from_millis(2500));
    let path = result.recording.unwrap().path;
    assert_eq!(reason(&path), format!("stopped; the first {:.3} s excluded by command", excluded.as_secs_f64()));
}

#[tokio::test(start_paused = true)]
async fn a_recording_is_continued_only_by_its_own_sensor() {
    let folder = TempDir::new().unwrap();
    for (serial, resume, samples) in [("100", false, 120), ("200", true, 0), ("100", true, 120)] {
        let sensor = sensor();
        sensor.world().registers.insert(3, serial.into());
        let recording = recording(&folder).map(|recording| RecordingSpec { resume, ..recording });
        let (result, _) = ended(Session::live(LiveSpec { settings: duration(3), recording, ..of(&sensor) })).await;
        assert_eq!(result.measured.timing.samples, samples, "{serial}: {:?}", result.end);
    }
}

#[tokio::test(start_paused = true)]
async fn a_recording_that_cannot_be_made_changes_nothing() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let recording = recording(&folder);
    std::fs::write(&recording.as_ref().unwrap().path, "there").unwrap();
    let (result, events) = ended(Session::live(LiveSpec { recording, ..of(&sensor) })).await;
    let Some(error) = &result.start_error else { panic!("{:?}", result.end) };
    assert!(matches!(error, StartError::Recording(RecordError::Exists { .. })));
    assert!(result.recording.is_none() && events.is_empty() && sensor.world().opened.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_sends_another_message_ends_the_session() {
    let sensor = sensor();
    let mut session = Session::live(of(&sensor));
    until(&mut session, |state| state.snapshot.timing.samples > 80).await;
    sensor.world().line = OTHER_LINE;
    let began = time::Instant::now();
    let (result, _) = ended(session).await;
    let End::OtherMessages { message, other, rate_hz, .. } = &*result.end else { panic!("{:?}", result.end) };
    assert_eq!((message.as_str(), other.unwrap().to_string().as_str(), *rate_hz), ("VNYMR", "VNYPR", None));
    let waited = began.elapsed();
    assert!((5.0..7.0).contains(&waited.as_secs_f64()), "{waited:?}");
}

/// The slowest sensor sends its first line a second after its output was resumed; until then it
/// only replies.
#[tokio::test(start_paused = true)]
async fn a_sensor_whose_output_was_paused_is_measured_at_any_rate() {
    for rate_hz in [1, 2, 40] {
        let sensor = Sensor::new(115_200, rate_hz);
        sensor.world().registers.insert(30, "0,0,0,0,1,0,1".into());
        (0..40).for_each(|register| _ = sensor.world().registers.entry(register).or_insert_with(|| "0".into()));
        sensor.world().streams = false;
        let settings = Settings { duration: Some(Duration::from_secs(5)), ..Settings::default() };
        let mut session = Session::live(LiveSpec { settings, ..of(&sensor) });
        // the watchdog judges the published state
        until(&mut session, |state| state.snapshot.timing.samples > 0).await;
        let (result, _) = ended(session).await;
        let timing = &result.measured.timing;
        assert!(matches!(*result.end, End::DurationReached), "{rate_hz} Hz: {:?}", result.end);
        assert_eq!(timing.samples, 5 * u64::from(rate_hz));
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_never_sends_a_measurement_ends_the_session() {
    let sensor = sensor();
    sensor.world().line = OTHER_LINE;
    let (result, _) = ended(Session::live(of(&sensor))).await;
    assert!(matches!(*result.end, End::NoMeasurement), "{:?}", result.end);
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_sends_at_another_rate_ends_the_session() {
    let sensor = sensor();
    let mut session = Session::live(of(&sensor));
    until(&mut session, |state| state.snapshot.timing.samples > 400).await;
    sensor.world().period = Duration::from_millis(100);
    let (result, events) = ended(session).await;
    let End::OtherRate(change) = &*result.end else { panic!("{:?}", result.end) };
    assert_eq!((change.from_hz, change.to_hz), (40.0, 10.0));
    assert!(matches!(events[..], [SessionEvent::Rate(RateEvent::Changed(_))]), "{events:?}");
}

#[tokio::test]
async fn a_stream_is_measured_recorded_and_takes_no_commands() {
    let folder = TempDir::new().unwrap();
    let bytes = io::Cursor::new(LINE.repeat(50));
    let seen = Arc::new(Mutex::new((0, 0)));
    let count = Arc::clone(&seen);
    let mut source = LiveSource::stream(bytes.clone());
    source.observer = Some(Arc::new(move |event: &Event| match event {
        Event::Batch(batch) => count.lock().unwrap().0 += batch.row_count(),
        Event::End(_) => count.lock().unwrap().1 += 1,
        Event::Link(_) => {}
    }));
    let (result, _) = ended(Session::live(LiveSpec { recording: recording(&folder), ..spec(source) })).await;
    assert!(matches!(*result.end, End::SourceEnded));
    assert_eq!(result.measured.timing.samples, 50);
    assert_eq!(*seen.lock().unwrap(), (50, 1));
    let recording = result.recording.unwrap();
    assert_eq!(recording.bytes, 50 * LINE.len() as u64);
    let setting = LiveSpec { output: rate(20), ..spec(LiveSource::stream(bytes.clone())) };
    let asking = LiveSpec { temperature: true, ..spec(LiveSource::stream(bytes)) };
    let (result, _) = ended(Session::live(setting)).await;
    let Some(StartError::Setup(error)) = &result.start_error else { panic!("{:?}", result.end) };
    assert!(matches!(error, SetupError::Live(LiveError::NoCommands)));
    let (result, _) = ended(Session::live(asking)).await;
    let Some(error) = &result.start_error else { panic!("{:?}", result.end) };
    assert!(matches!(error, StartError::Live(LiveError::NoTemperature)));
}

#[tokio::test(start_paused = true)]
async fn the_temperature_is_read_between_the_lines_on_request() {
    for (asked, read) in [(true, true), (false, false)] {
        let sensor = sensor();
        let ended = ended(Session::live(LiveSpec { temperature: asked, settings: duration(25), ..of(&sensor) })).await;
        assert!(matches!(*ended.0.end, End::DurationReached));
        let written = sensor.world().written.iter().any(|(_, bytes)| bytes.starts_with(b"$VNRRG,54"));
        assert_eq!(written, read);
    }
}

#[tokio::test]
async fn an_input_that_is_none_ends_the_session_at_once() {
    let spec = LiveSpec { source: Err(Box::from("no emulator")), ..spec(LiveSource::stream(io::empty())) };
    let (result, _) = ended(Session::live(spec)).await;
    let Some(error) = &result.start_error else { panic!("{:?}", result.end) };
    assert_eq!(error.to_string(), "no emulator");
}

#[tokio::test(start_paused = true)]
async fn a_source_is_opened_according_to_its_options() {
    let sensor = sensor();
    let rejections = Arc::new(Mutex::new(0));
    let count = Arc::clone(&rejections);
    let mut source = LiveSource::link(sensor.clone());
    source.options.listen_only = true;
    source.options.read.diagnostics = true;
    source.observer = Some(Arc::new(move |event: &Event| {
        if let Event::Batch(batch) = event {
            *count.lock().unwrap() += batch.diagnostics.len();
        }
    }));
    let mut session = Session::live(LiveSpec { settings: duration(2), ..spec(source) });
    until(&mut session, |state| state.snapshot.timing.samples > 10).await;
    sensor.world().stray = b"$VNYMR,1*00\r\n".to_vec();
    let (result, _) = ended(session).await;
    assert!(matches!(*result.end, End::DurationReached));
    assert!(sensor.world().written.is_empty(), "nothing is sent where the link only listens");
    assert_eq!(*rejections.lock().unwrap(), 1);
}
