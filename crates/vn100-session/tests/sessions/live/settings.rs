//! The settings that a session changes, and their restoration.

use super::*;

#[tokio::test(start_paused = true)]
async fn a_sensor_is_configured_before_and_restored_after() {
    let sensor = sensor();
    let session = Session::live(LiveSpec { output: rate(20), settings: duration(3), ..of(&sensor) });
    let (result, events) = ended(session).await;
    assert_eq!(result.measured.timing.samples, 60);
    let [SessionEvent::SensorConfigured(set), SessionEvent::SettingsRestored { output_paused: false }] = &events[..]
    else {
        panic!("{events:?}")
    };
    assert_eq!((set.rate_hz, set.changes.len()), (20.0, 1));
    assert!(result.is_restored);
    assert_eq!(sensor.world().registers[&7], "40");
}

#[tokio::test(start_paused = true)]
async fn a_lost_sensor_stays_changed_and_the_result_reports_it() {
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { output: rate(20), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples > 20).await;
    sensor.world().plugged = false;
    session.commands.send(Command::Stop).await.unwrap();
    let (result, events) = ended(session).await;
    assert!(!result.is_restored);
    let [SessionEvent::SensorConfigured(_), SessionEvent::SettingsNotRestored { error, changes, output: None }] =
        &events[..]
    else {
        panic!("{events:?}")
    };
    assert!(matches!(error, SetupError::Live(LiveError::NoSensor(_))), "{error:?}");
    assert_eq!(changes.len(), 1);
}

#[tokio::test(start_paused = true)]
async fn an_output_that_was_found_paused_is_paused_again() {
    for (gone, left) in [(false, None), (true, Some(OutputLeft::On))] {
        let sensor = sensor();
        sensor.world().streams = false;
        let mut session = Session::live(LiveSpec { output: rate(20), ..of(&sensor) });
        until(&mut session, |state| state.snapshot.timing.samples > 20).await;
        sensor.world().plugged = !gone;
        session.commands.send(Command::Stop).await.unwrap();
        let (result, events) = ended(session).await;
        match (&events[..], left) {
            ([SessionEvent::SensorConfigured(set), SessionEvent::SettingsRestored { output_paused: true }], None) => {
                assert!(set.was_paused && result.is_restored && !sensor.world().streams);
            }
            ([SessionEvent::SensorConfigured(_), SessionEvent::SettingsNotRestored { output, .. }], Some(_)) => {
                assert_eq!(*output, left);
            }
            _ => panic!("{events:?}"),
        }
    }
}

#[tokio::test(start_paused = true)]
async fn an_output_that_could_not_be_paused_again_is_paused_over_another_link() {
    let sensor = sensor();
    sensor.world().streams = false;
    let spec = LiveSpec { output: rate(40), ..of(&sensor) };
    let stop = spec.stop.clone();
    let session = Session::live(spec);
    // its output is on, and counted
    time::sleep(Duration::from_secs(3)).await;
    assert!(sensor.world().streams);
    sensor.world().answers = false;
    stop.cancel();
    time::sleep(Duration::from_secs(2)).await;
    sensor.world().answers = true;
    let (result, events) = ended(session).await;
    assert!(matches!(events[..], [SessionEvent::SettingsRestored { output_paused: true }]), "{events:?}");
    assert!(result.is_restored && !sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn an_output_that_the_link_resumed_is_paused_again_at_its_end() {
    let sensor = sensor();
    sensor.world().streams = false;
    let session = Session::live(LiveSpec { settings: duration(2), ..of(&sensor) });
    let (_, events) = ended(session).await;
    assert!(matches!(events[..], [SessionEvent::OutputPausedAgain]), "{events:?}");
    assert!(!sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn another_sensor_on_the_port_is_unchanged() {
    for was_on in [true, false] {
        let sensor = sensor();
        sensor.world().registers.insert(3, "100".into());
        sensor.world().streams = was_on;
        let mut session = Session::live(LiveSpec { output: rate(20), ..of(&sensor) });
        until(&mut session, |state| state.snapshot.timing.samples > 20).await;
        sensor.world().registers.insert(3, "200".into());
        let written = sensor.world().written.len();
        session.commands.send(Command::Stop).await.unwrap();
        let (result, events) = ended(session).await;
        let [_, SessionEvent::SettingsNotRestored { error: SetupError::AnotherSensor { now, known }, .. }] =
            &events[..]
        else {
            panic!("{events:?}")
        };
        assert_eq!((now.as_str(), known.as_str(), result.is_restored), ("200", "100", false));
        let world = sensor.world();
        assert!(world.written[written..].iter().all(|(_, bytes)| bytes.starts_with(b"$VNRRG,")), "{:?}", world.written);
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_cannot_be_configured_is_not_measured() {
    let folder = TempDir::new().unwrap();
    let sensor = sensor();
    sensor.world().read_only = Some(7);
    let recording = recording(&folder);
    let path = recording.as_ref().unwrap().path.clone();
    let (result, events) = ended(Session::live(LiveSpec { output: rate(20), recording, ..of(&sensor) })).await;
    let Some(StartError::Setup(SetupError::Configure(error))) = &result.start_error else { panic!("{:?}", result.end) };
    assert!(matches!(error, ConfigureError::Command(_)), "{error:?}");
    assert!(events.is_empty() && !path.exists() && result.recording.is_none());
    assert_eq!(sensor.world().registers[&7], "40");
}

#[tokio::test(start_paused = true)]
async fn a_stop_while_the_sensor_is_set_is_no_error_and_leaves_it_as_it_was() {
    // after this many milliseconds: before it is read, while it is written, while samples are counted
    for stop_after in [0, 700, 1500, 3000] {
        let sensor = sensor();
        let spec = LiveSpec { output: rate(20), ..of(&sensor) };
        let stop = spec.stop.clone();
        let session = Session::live(spec);
        time::sleep(Duration::from_millis(stop_after)).await;
        stop.cancel();
        let (result, events) = ended(session).await;
        assert!(matches!(*result.end, End::Stopped), "{stop_after}: {:?}", result.end);
        assert!(
            matches!(events[..], [] | [.., SessionEvent::SettingsRestored { output_paused: false }]),
            "{stop_after}: {events:?}"
        );
        assert_eq!(sensor.world().registers[&7], "40", "{stop_after}");
        assert!(sensor.world().streams, "{stop_after}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_is_opened_for_commands_at_its_rate_and_by_its_serial_number() {
    let sensor = sensor();
    sensor.world().registers.insert(3, "0100011981".into());
    let mut source = LiveSource::link(sensor.clone());
    source.options.hint_text = Some(|_| "look at the lamp");
    let stop = CancellationToken::new();
    let connected =
        async |source: &LiveSource, serial| source.with_link(serial, &stop, async |_| Ok::<_, LiveError>(())).await;
    source.options.baud = Some(9600);
    let at_another_rate = connected(&source, None).await.unwrap_err().to_string();
    assert!(at_another_rate.contains("look at the lamp"), "{at_another_rate}");
    source.options.baud = Some(115_200);
    connected(&source, Some("0100011981")).await.unwrap();
    assert!(matches!(connected(&source, Some("42")).await, Err(LiveError::NoSensor(_))));
}

#[tokio::test(start_paused = true)]
async fn a_source_is_opened_for_a_few_commands() {
    let sensor = sensor();
    let mut source = LiveSource::link(sensor.clone());
    source.options.baud = Some(115_200);
    let stop = CancellationToken::new();
    let model = source.with_link(None, &stop, async |link| {
        let model = link.read(vn100_protocol::Register::MODEL).await;
        Ok::<_, SetupError>(model?.unwrap().fields.to_string())
    });
    assert_eq!(model.await.unwrap(), "VN-100S-CR");
    sensor.world().plugged = false;
    let unheard = source.with_link(None, &stop, async |_| Ok::<_, LiveError>(())).await;
    assert!(matches!(unheard, Err(LiveError::NoSensor(_))), "{unheard:?}");
    stop.cancel();
    let stopped = source.with_link(None, &stop, async |_| Ok::<_, LiveError>(())).await;
    assert!(matches!(stopped, Err(LiveError::Stopped)), "{stopped:?}");
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_returns_is_configured_again() {
    let sensor = sensor();
    let mut session = Session::live(LiveSpec { output: rate(20), ..of(&sensor) });
    until(&mut session, |state| state.snapshot.timing.samples > 20).await;
    {
        let mut world = sensor.world();
        world.plugged = false;
        world.registers.insert(7, "40".into());
        world.period = Duration::from_millis(25);
    }
    until(&mut session, |state| matches!(state.link, Some(LinkState::Down { .. }))).await;
    sensor.world().plugged = true;
    until(&mut session, |state| state.snapshot.link.connects == 2).await;
    assert_eq!(sensor.world().registers[&7], "20");
    session.commands.send(Command::Stop).await.unwrap();
    ended(session).await;
}
