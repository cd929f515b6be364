//! Unattended sessions: they end by the clock.

use super::*;

fn limits(give_up_s: Option<u64>, wall_s: Option<u64>) -> WallLimits {
    let duration = |seconds: Option<u64>| seconds.map(Duration::from_secs);
    WallLimits { give_up: duration(give_up_s), wall: duration(wall_s) }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_is_lost_for_good_is_given_up() {
    let sensor = sensor();
    let spec = LiveSpec { limits: limits(Some(5), None), settings: duration(20), ..of(&sensor) };
    let mut session = Session::live(spec);
    until(&mut session, |state| state.snapshot.timing.samples >= 80).await;
    let began = time::Instant::now();
    sensor.world().plugged = false;
    let (result, _) = ended(session).await;
    let End::GaveUp { after, cause: Some(_) } = &*result.end else { panic!("{:?}", result.end) };
    assert_eq!(*after, Duration::from_secs(5));
    let waited_s = began.elapsed().as_secs_f64();
    assert!((4.9..5.2).contains(&waited_s), "{waited_s}");
    let shortfall = result.shortfall.unwrap();
    assert_eq!(shortfall.wanted, Duration::from_secs(20));
    assert_eq!(shortfall.measured.as_secs_f64(), result.measured.timing.duration_s);
    let outages = result.measured.link.outages;
    assert_eq!((outages.times, outages.seconds()), (1, Some(5.0)), "the outage at the end is told");
    assert_eq!(result.measured.source.end, Some(EndKind::GaveUp));
}

#[tokio::test(start_paused = true)]
async fn a_sensor_without_a_sample_is_given_up_from_when_it_was_there() {
    let sensor = sensor();
    sensor.world().line = OTHER_LINE;
    let mut session = Session::live(LiveSpec { limits: limits(Some(2), None), ..of(&sensor) });
    until(&mut session, |state| matches!(state.link, Some(LinkState::Up(_)))).await;
    let there = time::Instant::now();
    let (result, _) = ended(session).await;
    assert!(matches!(*result.end, End::GaveUp { cause: None, .. }), "{:?}", result.end);
    assert!((1.9..2.2).contains(&there.elapsed().as_secs_f64()), "{:?}", there.elapsed());
}

#[tokio::test(start_paused = true)]
async fn the_measurement_of_a_sensor_that_returns_in_time_continues() {
    let sensor = sensor();
    let spec = LiveSpec { limits: limits(Some(5), Some(60)), settings: duration(10), ..of(&sensor) };
    let mut session = Session::live(spec);
    for samples in [80, 160] {
        until(&mut session, |state| state.snapshot.timing.samples >= samples).await;
        sensor.world().plugged = false;
        time::sleep(Duration::from_secs(3)).await;
        sensor.world().plugged = true;
    }
    let (result, _) = ended(session).await;
    assert!(matches!(*result.end, End::DurationReached), "{:?}", result.end);
    assert_eq!((result.shortfall, result.measured.source.end), (None, Some(EndKind::Duration)));
}

#[tokio::test(start_paused = true)]
async fn the_wall_time_ends_the_session_in_any_case() {
    for plugged in [true, false] {
        let sensor = sensor();
        let mut session = Session::live(LiveSpec { limits: limits(None, Some(7)), ..of(&sensor) });
        let began = time::Instant::now();
        until(&mut session, |state| state.snapshot.timing.samples >= 80).await;
        sensor.world().plugged = plugged;
        let (result, _) = ended(session).await;
        let End::WallTime(wall) = &*result.end else { panic!("{:?}", result.end) };
        assert_eq!((*wall, result.shortfall), (Duration::from_secs(7), None), "no duration was asked for");
        assert!((7.0..7.1).contains(&began.elapsed().as_secs_f64()));
        assert!(result.measured.timing.samples >= 80);
    }
}

#[tokio::test(start_paused = true)]
async fn a_stop_before_the_duration_leaves_a_shortfall() {
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { settings: duration(20), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples >= 80).await;
    session.commands.send(Command::Stop).await.unwrap();
    let (result, _) = ended(session).await;
    assert_eq!(result.measured.source.end, Some(EndKind::Stopped));
    assert_eq!(result.shortfall.unwrap().wanted, Duration::from_secs(20));
}

/// A source that sends nothing, and never ends.
struct Mute(std::sync::mpsc::Receiver<()>);

impl io::Read for Mute {
    fn read(&mut self, _buffer: &mut [u8]) -> io::Result<usize> {
        // ends when its sender is dropped, with the test
        let _ = self.0.recv();
        Ok(0)
    }
}

#[tokio::test(start_paused = true)]
async fn a_stream_that_brings_nothing_is_given_up() {
    let (_alive, mute) = std::sync::mpsc::channel();
    let source = LiveSource::stream(Mute(mute));
    let (result, _) = ended(Session::live(LiveSpec { limits: limits(Some(5), None), ..spec(source) })).await;
    assert!(matches!(*result.end, End::GaveUp { cause: None, .. }), "{:?}", result.end);
}

#[tokio::test(start_paused = true)]
async fn a_recording_replays_with_the_outage_at_its_end() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    let spec = LiveSpec { limits: limits(Some(5), None), recording: recording(&folder), ..of(&sensor) };
    let mut session = Session::live(spec);
    until(&mut session, |state| state.snapshot.timing.samples >= 80).await;
    sensor.world().plugged = false;
    let (live, _) = ended(session).await;
    let path = live.recording.unwrap().path;
    assert_eq!(reason(&path), "the sensor was lost");
    let replay = Session::replay(ReplaySpec::of(path)).result.await.unwrap();
    assert_eq!(replay.measured.link.outages.seconds(), live.measured.link.outages.seconds());
    assert_eq!(replay.measured.source.end, Some(EndKind::EndOfInput));
}

/// From ten in the evening; the sensor is lost for good at three.
#[tokio::test(start_paused = true)]
async fn a_sensor_lost_at_night_leaves_five_hours_and_the_reason() {
    // two minutes: a night of whole hours passes as well, but takes a minute and a half
    const HOUR_S: u64 = 120;
    let folder = TempDir::new().unwrap();
    let sensor = Sensor::new(115_200, 4);
    sensor.world().registers.insert(30, "0,0,0,0,1,0,1".into());
    let rotation = Some(Rotation::Time(Duration::from_secs(HOUR_S)));
    let recording = recording(&folder).map(|recording| RecordingSpec { rotation, ..recording });
    let spec = LiveSpec {
        limits: limits(Some(HOUR_S / 2), Some(10 * HOUR_S)),
        settings: duration(9 * HOUR_S),
        recording,
        ..of(&sensor)
    };
    let (session, began) = (Session::live(spec), time::Instant::now());
    let unplugged = sensor.clone();
    tokio::spawn(async move {
        time::sleep(Duration::from_secs(5 * HOUR_S)).await;
        unplugged.world().plugged = false;
    });
    let (live, _) = ended(session).await;
    let End::GaveUp { after, cause: Some(_) } = &*live.end else { panic!("{:?}", live.end) };
    assert_eq!(after.as_secs(), HOUR_S / 2);
    let took_s = began.elapsed().as_secs_f64() - (5 * HOUR_S + HOUR_S / 2) as f64;
    assert!((-1.0..1.0).contains(&took_s), "{took_s}");
    let timing = live.measured.timing;
    assert!((5 * HOUR_S * 4 - 8..=5 * HOUR_S * 4).contains(&timing.samples), "{timing:?}");
    assert_eq!((timing.missing_at_least, live.measured.link.outages.seconds()), (0, Some((HOUR_S / 2) as f64)));
    let shortfall = live.shortfall.unwrap();
    assert_eq!(shortfall.wanted.as_secs(), 9 * HOUR_S);
    assert_eq!(shortfall.measured.as_secs_f64(), timing.duration_s);

    let part = |number: u32| folder.path().join(format!("bench.{number:04}.mcap"));
    let parts: Vec<PathBuf> = (1..).map(part).take_while(|part| part.exists()).collect();
    assert!((5..=6).contains(&parts.len()), "{parts:?}");
    assert_eq!(reason(parts.last().unwrap()), "the sensor was lost");
    let mut samples = 0;
    for part in &parts {
        samples += Session::replay(ReplaySpec::of(part.clone())).result.await.unwrap().measured.timing.samples;
    }
    assert!((timing.samples - parts.len() as u64..=timing.samples).contains(&samples), "{samples} of {timing:?}");
}
