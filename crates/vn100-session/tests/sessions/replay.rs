//! Sessions of captures: as fast as the machine can, every second, and at a pace. Time is virtual.

use std::{
    fs,
    io::Write,
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use tempfile::NamedTempFile;
use tokio::time;
use vn100_analysis::End;
use vn100_analysis::Settings;
use vn100_capture::{Event, OpenError, RecordingWriter};
use vn100_protocol::stream::{Chunk, StreamInput};
use vn100_session::{
    Command, CommandRefusal, Playback, ReplaySpec, SampleTap, Session, SessionEvent, SourceState, Speed, Stage,
    StartError,
};

const LINE: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

/// Twenty seconds at the assumed rate.
const SAMPLES: u64 = 800;

fn capture(samples: u64) -> NamedTempFile {
    let mut file = NamedTempFile::with_suffix(".vnymr").unwrap();
    file.write_all(LINE.repeat(samples as usize).as_bytes()).unwrap();
    file
}

/// A table of white noise at 100 Hz, whose rows stand twice now and then.
fn table(samples: u64, seed: u64) -> NamedTempFile {
    let mut state = seed;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let mut row = |at| format!("{:.2},{:.7}\n", at as f64 / 100.0, 1e-3 * (uniform() + uniform() + uniform()));
    let rows = (0..samples).map(|at| row(at).repeat(if (at + seed).is_multiple_of(97) { 2 } else { 1 }));
    let mut file = NamedTempFile::with_suffix(".csv").unwrap();
    write!(file, "time,gyro_x\n{}", rows.collect::<String>()).unwrap();
    file
}

fn paced(file: &NamedTempFile, speed: Speed) -> Session {
    Session::replay(ReplaySpec { speed: Some(speed), ..ReplaySpec::of(file.path()) })
}

async fn until(session: &mut Session, mut is_there: impl FnMut(Playback, &SourceState) -> bool) -> Playback {
    let there = |state: &SourceState| state.playback.is_some_and(|playback| is_there(playback, state));
    session.state.wait_for(there).await.unwrap().playback.unwrap()
}

async fn counted(session: &mut Session) {
    until(session, |playback, _| playback.total == Some(SAMPLES)).await;
}

async fn command(session: &Session, command: Command) {
    session.commands.send(command).await.unwrap();
}

#[tokio::test]
async fn a_capture_is_measured_to_its_end() {
    let file = capture(SAMPLES);
    let seen = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&seen);
    let observer = Arc::new(move |event: &Event| {
        if let Event::Batch(batch) = event {
            count.fetch_add(batch.row_count(), Ordering::Relaxed);
        }
    });
    let session = Session::replay(ReplaySpec { observer: Some(observer), ..ReplaySpec::of(file.path()) });
    let (state, mut seconds) = (session.state.clone(), session.seconds);
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::SourceEnded) && result.excluded.is_zero());
    assert_eq!((result.measured.timing.samples, seen.load(Ordering::Relaxed)), (SAMPLES, SAMPLES as usize));
    assert_eq!(result.measured.source.name, file.path().file_name().unwrap().to_str().unwrap());
    assert_eq!((result.measured.source.kind, result.measured.source.playback), (Some("text"), None));
    assert_eq!(state.borrow().stored_bytes_read, SAMPLES * LINE.len() as u64);
    assert!(seconds.recv().await.is_none(), "not asked for");
}

#[tokio::test]
async fn a_writer_of_samples_gets_each_sample_once_and_nothing_else() {
    let mut file = NamedTempFile::new().unwrap();
    // more lines without a sample than a read takes
    write!(file, "{}{}", LINE.repeat(SAMPLES as usize), "$VNYPR,-129.867,-000.355,-000.296*61\r\n".repeat(10_000))
        .unwrap();
    let (tap, mut batches) = SampleTap::new();
    let session = Session::replay(ReplaySpec { samples: Some(tap), ..ReplaySpec::of(file.path()) });
    let mut samples = 0;
    while let Some(batch) = batches.recv().await {
        assert!(batch.row_count() > 0);
        samples += batch.row_count() as u64;
    }
    assert_eq!((samples, session.result.await.unwrap().measured.timing.samples), (SAMPLES, SAMPLES));
}

#[tokio::test]
async fn a_writer_of_samples_gets_no_row_behind_the_end() {
    for seed in 1..=12 {
        let file = table(6000, seed);
        let skip_s = seed % 3;
        let settings = match seed % 4 {
            0 => Settings { until: vec!["gyro N ±8%".parse().unwrap()], ..Settings::default() },
            _ => Settings { duration: Some(Duration::from_millis(3000 + 2510 * seed)), ..Settings::default() },
        };
        let settings = Settings { skip: Duration::from_secs(skip_s), ..settings };
        let (tap, mut batches) = SampleTap::new();
        let session = Session::replay(ReplaySpec { samples: Some(tap), settings, ..ReplaySpec::of(file.path()) });
        let mut values = Vec::new();
        while let Some(batch) = batches.recv().await {
            values.push(batch.counts[0]);
        }
        // a row that stands twice has equal neighbours
        values.dedup();
        let result = session.result.await.unwrap();
        assert!(matches!(*result.end, End::DurationReached | End::GoalsDecided), "{seed}: {:?}", result.end);
        assert_eq!(values.len() as u64, 100 * skip_s + result.measured.timing.samples, "{seed}");
    }
}

#[tokio::test]
async fn of_a_table_the_lines_up_to_the_end_of_the_measurement_are_reported() {
    let report = async |text: &str, duration| {
        let mut file = NamedTempFile::with_suffix(".csv").unwrap();
        file.write_all(text.as_bytes()).unwrap();
        let settings = Settings { duration, ..Settings::default() };
        let spec = ReplaySpec { settings, ..ReplaySpec::of(file.path()) };
        Session::replay(spec).result.await.unwrap().measured.source.csv.unwrap()
    };
    for seed in 1..=8 {
        let noise = fs::read_to_string(table(6000, seed).path()).unwrap();
        let row = |(line, row): (u64, &str)| match (line + seed) % 61 {
            _ if line == 0 => format!("{row},gyro_y\n"),
            0 => "broken\n".into(),
            5 => format!("{row},\n"),
            _ => format!("{row},{}\n", row.rsplit(',').next().unwrap()),
        };
        let text: String = (0..).zip(noise.lines()).map(row).collect();
        let ended = report(&text, Some(Duration::from_millis(3000 + 2510 * seed))).await;
        assert!(ended.lines < 5000 && !ended.rejected.is_empty() && !ended.absent.is_empty(), "{seed}: {ended:?}");
        let first: String = text.split_inclusive('\n').take(ended.lines as usize).collect();
        assert_eq!(report(&first, None).await, ended, "{seed}");
    }
}

#[tokio::test]
async fn numbers_are_measured_at_the_rate_of_their_times_and_not_at_a_guess() {
    let measured = async |rows: &[&str], settings| {
        let mut file = NamedTempFile::with_suffix(".csv").unwrap();
        write!(file, "time,gyro_x\n{}\n", rows.join("\n")).unwrap();
        Session::replay(ReplaySpec { settings, ..ReplaySpec::of(file.path()) }).result.await.unwrap()
    };
    let even = ["0.0,1.0", "0.1,2.0", "0.2,1.5", "0.3,1.0", "0.4,2.5"];
    let result = measured(&even, Settings::default()).await;
    assert!(matches!(*result.end, End::SourceEnded), "{:?}", result.end);
    assert_eq!((result.measured.timing.samples, result.measured.timing.rate_hz), (5, Some(10.0)));
    // one sample has no rate, and nothing is said of it that needs one
    let result = measured(&even[..1], Settings::default()).await;
    assert!(matches!(*result.end, End::SourceEnded), "{:?}", result.end);
    assert_eq!(result.measured.timing.samples, 1);
    let at_once = ["0.0,1.0", "0.0,2.0"];
    let result = measured(&at_once, Settings::default()).await;
    assert!(matches!(result.start_error, Some(StartError::RateUnknown { .. })), "{:?}", result.end);
    assert_eq!(result.measured.timing.samples, 0);
    let given = Settings { rate_hz: Some(20.0), ..Settings::default() };
    assert_eq!(measured(&at_once, given).await.measured.timing.samples, 2);
}

#[tokio::test(start_paused = true)]
async fn every_second_brings_one_state_and_waits_until_it_is_taken() {
    let file = capture(SAMPLES);
    let mut session = Session::replay(ReplaySpec { each_second: true, ..ReplaySpec::of(file.path()) });
    session.state.wait_for(|state| state.snapshot.timing.samples >= 200).await.unwrap();
    time::sleep(Duration::from_secs(10)).await;
    // four states wait, and the fifth waits for room
    assert_eq!(session.state.borrow().snapshot.timing.samples, 200);
    let mut taken = Vec::new();
    while let Some(state) = session.seconds.recv().await {
        assert!(matches!(state.stage, Stage::Measuring));
        taken.push(state.snapshot.timing.samples);
    }
    assert_eq!(taken, (1..=20).map(|second| 40 * second).collect::<Vec<_>>());
    assert_eq!(session.result.await.unwrap().measured.timing.samples, SAMPLES);
}

#[tokio::test(start_paused = true)]
async fn a_capture_that_cannot_be_opened_reports_the_reason() {
    let missing = Path::new("/nonexistent/night.vnymr");
    let result = Session::replay(ReplaySpec::of(missing)).result.await.unwrap();
    let Some(StartError::Capture(error)) = &result.start_error else { panic!("{:?}", result.end) };
    assert!(matches!(error, OpenError::Io { .. }));
    assert_eq!((result.measured.source.name.as_str(), result.measured.source.kind), ("night.vnymr", None));
    assert_eq!(result.measured.timing.samples, 0);
    // in a view it is shown until the view is closed
    let paced = ReplaySpec { speed: Some(Speed::Max), ..ReplaySpec::of(missing) };
    let stop = paced.stop.clone();
    let mut session = Session::replay(paced);
    session.state.wait_for(|state| matches!(state.stage, Stage::Ended(_))).await.unwrap();
    time::sleep(Duration::from_secs(60)).await;
    assert!(!session.result.is_finished());
    stop.cancel();
    assert!(matches!(*session.result.await.unwrap().end, End::NotStarted { .. }));
}

#[tokio::test]
async fn once_stopped_no_capture_is_begun() {
    let file = capture(10);
    let stopped = ReplaySpec::of(file.path());
    stopped.stop.cancel();
    let result = Session::replay(stopped).result.await.unwrap();
    assert!(matches!(result.start_error, Some(StartError::Stopped)), "{:?}", result.end);
}

#[tokio::test(start_paused = true)]
async fn a_stop_ends_a_capture_with_the_result_so_far() {
    // several reads: samples that were read are measured
    let file = capture(10 * SAMPLES);
    let spec = ReplaySpec { each_second: true, ..ReplaySpec::of(file.path()) };
    let stop = spec.stop.clone();
    let mut session = Session::replay(spec);
    let first = session.seconds.recv().await.unwrap();
    assert_eq!(first.snapshot.timing.samples, 40);
    stop.cancel();
    let mut taken = vec![first.snapshot.timing.samples];
    while let Some(state) = session.seconds.recv().await {
        taken.push(state.snapshot.timing.samples);
    }
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::Stopped), "{:?}", result.end);
    assert!(result.measured.timing.samples < 10 * SAMPLES);
    // none is missing between others
    assert!(taken.windows(2).all(|pair| pair[1] == pair[0] + 40), "{taken:?}");
}

#[tokio::test(start_paused = true)]
async fn a_paced_replay_is_paused_and_resumed() {
    let file = capture(SAMPLES);
    let mut session = paced(&file, Speed::Times(1.0));
    until(&mut session, |playback, _| playback.samples >= 20).await;
    command(&session, Command::TogglePause).await;
    let paused = until(&mut session, |playback, _| playback.paused).await;
    time::sleep(Duration::from_secs(60)).await;
    assert_eq!(session.state.borrow().playback.unwrap().samples, paused.samples);
    command(&session, Command::Faster).await;
    command(&session, Command::Faster).await;
    command(&session, Command::Slower).await;
    until(&mut session, |playback, _| playback.speed == Speed::Times(2.0)).await;
    command(&session, Command::TogglePause).await;
    let began = time::Instant::now();
    until(&mut session, |playback, _| playback.samples >= paused.samples + 400).await;
    // 400 samples at 40 Hz and double speed
    assert!((4.9..5.3).contains(&began.elapsed().as_secs_f64()), "{:?}", began.elapsed());
    command(&session, Command::Stop).await;
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::Stopped));
    assert!(result.measured.timing.samples < SAMPLES && !result.measured.source.playback.unwrap().at_end);
}

#[tokio::test(start_paused = true)]
async fn at_its_end_a_replay_stays_until_it_is_stopped() {
    let file = capture(SAMPLES);
    let mut session = paced(&file, Speed::Max);
    counted(&mut session).await;
    until(&mut session, |playback, state| playback.at_end && state.snapshot.timing.samples == SAMPLES).await;
    time::sleep(Duration::from_secs(60)).await;
    assert!(matches!(session.state.borrow().stage, Stage::Measuring));
    for (refused, why) in [
        (Command::TogglePause, CommandRefusal::AtEnd),
        (Command::EndWarmUp, CommandRefusal::Over),
        (Command::StartOver, CommandRefusal::Over),
    ] {
        command(&session, refused).await;
        let event = session.events.recv().await.unwrap();
        assert!(matches!(event, SessionEvent::Refused(refusal) if refusal == why), "{event:?}");
    }
    command(&session, Command::Slower).await;
    let slower = until(&mut session, |playback, _| playback.speed == Speed::Times(1000.0)).await;
    assert!(slower.at_end && !slower.paused);
    command(&session, Command::Stop).await;
    let result = session.result.await.unwrap();
    assert!(matches!(*result.end, End::SourceEnded), "it had come to its end");
    assert_eq!(result.measured.timing.samples, SAMPLES);
    let playback = result.measured.source.playback.unwrap();
    assert_eq!((playback.samples, playback.total, playback.at_end), (SAMPLES, Some(SAMPLES), true));
}

#[tokio::test(start_paused = true)]
async fn the_requested_duration_is_an_end_as_well() {
    let file = capture(SAMPLES);
    let settings = Settings { duration: Some(Duration::from_secs(5)), ..Settings::default() };
    let mut session = Session::replay(ReplaySpec { speed: Some(Speed::Max), settings, ..ReplaySpec::of(file.path()) });
    let end = until(&mut session, |playback, _| playback.at_end).await;
    assert_eq!(end.samples, 200);
    command(&session, Command::Stop).await;
    assert!(matches!(*session.result.await.unwrap().end, End::DurationReached));
}

#[tokio::test]
async fn the_goals_that_end_a_table_are_met_by_the_samples_that_decided() {
    for seed in 1..=16 {
        let file = table(6000, seed);
        let until = vec![format!("gyro N ±{}%", 6 + seed % 5).parse().unwrap()];
        let settings = Settings { until, ..Settings::default() };
        let result = Session::replay(ReplaySpec { settings, ..ReplaySpec::of(file.path()) }).result.await.unwrap();
        assert!(matches!(*result.end, End::GoalsDecided), "{seed}: {:?}", result.end);
        assert!(result.unmet.is_empty(), "{seed}: {:?}", result.measured.half_widths(&result.unmet[0]));
    }
}

#[tokio::test]
async fn the_end_of_a_recording_is_known_if_the_replay_ends_with_it() {
    let metadata = [("measured.duration".to_owned(), "1s".to_owned())].into();
    let mut recording = RecordingWriter::new(Vec::new(), &metadata).unwrap();
    // far more than is read ahead
    for at_s in 0..100 {
        let bytes = LINE.repeat(400).into();
        recording.write(&StreamInput::Chunk(Chunk { bytes, at_ns: Some(at_s * 10_000_000_000) })).unwrap();
    }
    let file = NamedTempFile::with_suffix(".mcap").unwrap();
    fs::write(&file, recording.finish(Some("done")).unwrap()).unwrap();
    let replayed = async |duration| {
        let settings = Settings { duration, ..Settings::default() };
        let session = Session::replay(ReplaySpec { settings, ..ReplaySpec::of(file.path()) });
        let state = session.state.clone();
        let result = session.result.await.unwrap();
        assert!(matches!(*result.end, End::DurationReached), "{:?}", result.end);
        state.borrow().facts().recording.unwrap().end
    };
    let end = replayed(None).await.unwrap();
    assert_eq!((end.complete, end.ended_ns, end.reason.as_deref()), (true, Some(990_000_000_000), Some("done")));
    // reading the end ahead is a matter of timing, and has no effect
    for seconds in [1, 2, 900] {
        assert_eq!(replayed(Some(Duration::from_secs(seconds))).await, None);
    }
}

#[tokio::test]
async fn a_replay_measures_the_frames_that_its_recording_names() {
    let samples = async |frames: &str| {
        let metadata = [("measured.frames".to_owned(), frames.to_owned())].into();
        let mut recording = RecordingWriter::new(Vec::new(), &metadata).unwrap();
        recording.write(&StreamInput::Chunk(Chunk { bytes: LINE.repeat(100).into(), at_ns: Some(0) })).unwrap();
        let file = NamedTempFile::with_suffix(".mcap").unwrap();
        fs::write(&file, recording.finish(None).unwrap()).unwrap();
        Session::replay(ReplaySpec::of(file.path())).result.await.unwrap().measured.timing.samples
    };
    assert_eq!((samples("sentences").await, samples("packets").await), (100, 0));
}

#[tokio::test]
async fn a_recording_whose_rate_changes_is_read_to_its_end() {
    let mut recording = RecordingWriter::new(Vec::new(), &Default::default()).unwrap();
    let mut at_ns = 0;
    for (lines, period_ns) in [(600, 25_000_000), (200, 100_000_000)] {
        for _ in 0..lines {
            at_ns += period_ns;
            recording.write(&StreamInput::Chunk(Chunk { bytes: LINE.into(), at_ns: Some(at_ns) })).unwrap();
        }
    }
    let file = NamedTempFile::with_suffix(".mcap").unwrap();
    fs::write(&file, recording.finish(Some("done")).unwrap()).unwrap();
    let result = Session::replay(ReplaySpec::of(file.path())).result.await.unwrap();
    let change = result.measured.timing.rate_change.unwrap();
    assert_eq!((change.from_hz, change.to_hz), (40.0, 10.0));
    assert!(matches!(*result.end, End::SourceEnded), "{:?}", result.end);
}

#[tokio::test(start_paused = true)]
async fn the_pace_is_that_of_the_rate_in_the_capture() {
    let body = "VNRRG,07,10";
    let check = body.bytes().fold(0, |xor, byte| xor ^ byte);
    let mut file = capture(1);
    write!(file, "${body}*{check:02X}\r\n{}", LINE.repeat(200)).unwrap();
    let mut session = paced(&file, Speed::Times(1.0));
    until(&mut session, |playback, state| playback.samples >= 10 && state.snapshot.timing.rate_hz == 10.0).await;
    let (began, first) = (time::Instant::now(), session.state.borrow().playback.unwrap().samples);
    until(&mut session, |playback, _| playback.samples >= first + 40).await;
    assert!((3.7..4.4).contains(&began.elapsed().as_secs_f64()), "{:?}", began.elapsed());
}
