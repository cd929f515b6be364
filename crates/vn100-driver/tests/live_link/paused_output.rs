//! A sensor whose output another program has paused: it is resumed, reported, and left as it was found.

use std::time::Duration;

use crate::support::{LINE, Link, Sensor, Told, packet};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use vn100_driver::{
    ConfigureError, Configured, LinkOptions, LinkState, OutputLeft, OutputSettings, configure, restore,
};
use vn100_protocol::SensorCommand;
use vn100_protocol::stream::LinkEventKind;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A sensor at this rate whose output is paused.
fn paused(rate_hz: u32) -> Sensor {
    let sensor = Sensor::new(115_200, rate_hz);
    sensor.world().streams = false;
    sensor.world().registers.insert(30, "0,0,0,0,1,0,1".into());
    sensor
}

/// A link to the sensor that is up.
async fn up(sensor: &Sensor) -> Link {
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    link
}

/// Stops a link: returns its events, and whether an output that was found paused is paused again.
async fn stop(link: Link) -> (Told, Option<bool>) {
    let mut state = link.handle.state();
    let told = link.stop().await;
    let closed = state.wait_for(|state| matches!(state, LinkState::Closed { .. })).await.unwrap().clone();
    let LinkState::Closed { paused_again } = closed else { panic!("{closed:?}") };
    (told, paused_again)
}

fn count(told: &Told, wanted: LinkEventKind) -> usize {
    told.link.iter().filter(|(_, kind)| *kind == wanted).count()
}

/// After a stall the host reads the answer and the first line of the output at once.
#[tokio::test(start_paused = true)]
async fn a_paused_output_whose_first_line_comes_with_the_answer_is_paused_again() {
    for rate_hz in [1, 40] {
        let sensor = paused(rate_hz);
        sensor.world().answers_with_output = true;
        let mut link = up(&sensor).await;
        link.run(ms(8000)).await;
        let (told, paused_again) = stop(link).await;
        assert_eq!((told.counts.outputs_resumed, paused_again), (1, Some(true)), "{rate_hz} Hz: {:?}", told.link);
        assert!(!sensor.world().streams);
    }
}

/// A part of an answer is no output: it does not delay the detection of a paused output.
#[tokio::test(start_paused = true)]
async fn a_paused_output_is_found_in_three_seconds_where_answers_come_in_two_reads() {
    let sensor = paused(40);
    sensor.world().answers_in_two = true;
    let mut link = up(&sensor).await;
    let connected = Instant::now();
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    assert!(connected.elapsed() < ms(3500), "{:?}", connected.elapsed());
    stop(link).await;
}

#[tokio::test(start_paused = true)]
async fn a_slow_output_whose_frames_are_damaged_was_not_paused() {
    // a wrong checksum; a lost beginning; a packet that fails its CRC
    for (line, damaged) in [
        ("$VNYMR,-085.469,+074.972*00\r\n", None),
        ("VNYMR,-085.469,+074.972,+063.752*63\r\n", None),
        (LINE, Some(&packet(&[5, 0x01, 0x00, 0x1C, 0x00], 36)[..40])),
    ] {
        let sensor = paused(1);
        sensor.world().registers.insert(75, "1,1,05,0001,001C".into());
        sensor.world().streams = true;
        (sensor.world().line, sensor.world().packet) = (line, damaged);
        let mut link = up(&sensor).await;
        link.run(ms(4500)).await;
        (sensor.world().line, sensor.world().packet) = (LINE, None);
        link.run(ms(4000)).await;
        let (told, paused_again) = stop(link).await;
        assert!(told.rows > 2, "{:?}", told.counts);
        assert_eq!((told.counts.outputs_resumed, paused_again), (0, None), "{line}");
    }
}

#[tokio::test(start_paused = true)]
async fn it_is_paused_again_after_the_receiver_of_events_is_dropped() {
    let sensor = paused(40);
    let mut link = up(&sensor).await;
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    let mut state = link.handle.state();
    drop(link.events);
    state.wait_for(|state| *state == LinkState::Closed { paused_again: Some(true) }).await.unwrap();
    assert!(!sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn an_output_paused_during_a_measurement_is_detected() {
    let sensor = paused(40);
    sensor.world().streams = true;
    let mut link = up(&sensor).await;
    link.run(ms(8000)).await;
    sensor.world().streams = false;
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    let (told, paused_again) = stop(link).await;
    assert_eq!((told.counts.outputs_resumed, told.counts.connects, paused_again), (1, 1, Some(true)));
    assert!(!sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn a_failed_pause_is_reported() {
    let sensor = paused(40);
    let mut link = up(&sensor).await;
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    sensor.world().answers = false;
    let (told, paused_again) = stop(link).await;
    assert_eq!((count(&told, LinkEventKind::OutputPaused), paused_again), (0, Some(false)));
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_is_silent_for_another_reason_was_not_paused() {
    // it has no output; it has no power for a while, and boots; it sends late
    for (case, away) in [(0, 0), (1, 1000), (2, 4000)] {
        let sensor = paused(40);
        sensor.world().streams = case > 0;
        if case == 0 {
            sensor.world().period = ms(3_600_000);
            sensor.world().registers.insert(6, "0".into());
        }
        let mut link = up(&sensor).await;
        link.run(ms(7000)).await;
        (sensor.world().streams, sensor.world().answers) = (case == 0, case == 0);
        link.run(ms(away)).await;
        (sensor.world().streams, sensor.world().answers) = (true, true);
        link.run(ms(30_000)).await;
        let (told, paused_again) = stop(link).await;
        assert_eq!((count(&told, LinkEventKind::OutputResumed), paused_again), (0, None), "case {case}");
        assert!(sensor.world().streams, "case {case}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_user_who_resumes_the_output_keeps_it_on() {
    let sensor = paused(40);
    let mut link = up(&sensor).await;
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    let handle = link.handle.clone();
    let asked = tokio::spawn(async move { handle.request(SensorCommand::Async(true)).await });
    link.run(ms(500)).await;
    asked.await.unwrap().unwrap();
    assert_eq!(stop(link).await.1, None);
    assert!(sensor.world().streams);
}

/// Sets the rate; the link is stopped after that.
async fn set(
    sensor: &Sensor,
    rate_hz: u32,
    stop: &CancellationToken,
    after: Duration,
) -> Result<Configured, ConfigureError> {
    let mut link = up(sensor).await;
    let (handle, stopping) = (link.handle.clone(), stop.clone());
    let settings = OutputSettings { rate_hz: Some(rate_hz), ..OutputSettings::default() };
    let work = tokio::spawn(async move { configure(&handle, &settings, &stopping).await });
    link.run(after).await;
    stop.cancel();
    link.run(ms(10_000)).await;
    link.stop().await;
    work.await.unwrap()
}

/// Restores the changes, over another link.
async fn put_back(sensor: &Sensor, configured: Configured) {
    let mut link = up(sensor).await;
    let handle = link.handle.clone();
    let work = tokio::spawn(async move { restore(&handle, &configured.changes).await });
    link.run(ms(5000)).await;
    work.await.unwrap().unwrap();
    link.stop().await;
}

#[tokio::test(start_paused = true)]
async fn a_user_who_sets_the_output_learns_that_it_was_paused() {
    for rate_hz in [40, 20] {
        let sensor = paused(40);
        let configured = set(&sensor, rate_hz, &CancellationToken::new(), ms(10_000)).await.unwrap();
        assert!(configured.was_paused && configured.rate_is_kept(), "{configured:?}");
        assert!(sensor.world().streams);
        // restored by a link that finds it in this state
        put_back(&sensor, configured).await;
        let world = sensor.world();
        assert_eq!((world.registers[&7].as_str(), world.streams), ("40", true));
    }
}

#[tokio::test(start_paused = true)]
async fn told_to_stop_at_any_time_it_leaves_the_output_paused() {
    for after in (0..5000).step_by(61).map(Duration::from_millis) {
        for rate_hz in [40, 20] {
            let sensor = paused(40);
            let told = set(&sensor, rate_hz, &CancellationToken::new(), after).await;
            let (rate, streams) = if told.is_ok() { (rate_hz, true) } else { (40, false) };
            let world = sensor.world();
            assert_eq!((&world.registers[&7], world.streams), (&rate.to_string(), streams), "{after:?}: {told:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn an_output_that_cannot_be_paused_again_is_reported() {
    let sensor = paused(40);
    let mut link = up(&sensor).await;
    let handle = link.handle.clone();
    let settings = OutputSettings { rate_hz: Some(40), ..OutputSettings::default() };
    let stop = CancellationToken::new();
    let stopping = stop.clone();
    let work = tokio::spawn(async move { configure(&handle, &settings, &stopping).await });
    // its output is on, and counted
    link.run(ms(3000)).await;
    assert!(sensor.world().streams);
    sensor.world().answers = false;
    stop.cancel();
    link.run(ms(10_000)).await;
    let error = work.await.unwrap().unwrap_err();
    assert!(matches!(error, ConfigureError::Left { output: Some(OutputLeft::On), .. }), "{error:?}");
    assert!(error.to_string().ends_with("changed: its output, which may be on"), "{error}");
    link.stop().await;
}

#[tokio::test(start_paused = true)]
async fn restoring_a_paused_sensor_leaves_it_paused() {
    let sensor = paused(40);
    sensor.world().streams = true;
    let configured = set(&sensor, 20, &CancellationToken::new(), ms(10_000)).await.unwrap();
    assert!(!configured.was_paused);
    sensor.world().streams = false;
    put_back(&sensor, configured).await;
    let world = sensor.world();
    assert_eq!((world.registers[&7].as_str(), world.streams), ("40", false));
}

#[tokio::test(start_paused = true)]
async fn slow_and_absent_output_are_not_a_paused_one() {
    for (message, rate_hz) in [("14", "1"), ("0", "1"), ("14", "0")] {
        let sensor = paused(1);
        sensor.world().streams = (message, rate_hz) == ("14", "1");
        sensor.world().registers.insert(6, message.into());
        sensor.world().registers.insert(7, rate_hz.into());
        let configured = set(&sensor, 2, &CancellationToken::new(), ms(10_000)).await.unwrap();
        assert!(!configured.was_paused, "{message} at {rate_hz} Hz");
    }
}
