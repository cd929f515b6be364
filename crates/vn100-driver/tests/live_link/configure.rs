//! Setting a sensor over a live link: the writes, their restoration, and that its output continues
//! in any case.

use std::{slice, time::Duration};

use crate::support::{LINE, Link, OTHER_LINE, Sensor, packet};
use tokio::{join, task::JoinHandle, time::Instant};
use tokio_util::sync::CancellationToken;
use vn100_driver::{Change, ConfigureError, Configured, LinkOptions, LinkState, OutputSettings, configure, restore};
use vn100_protocol::{Register, RegisterFields};

const PROTOCOL: (u8, &str) = (30, "0,0,0,0,1,0,1");
const FILTER: (u8, &str) = (85, "0,4,4,4,0,0,3,3,3,0");

fn sensor() -> Sensor {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().registers.extend([PROTOCOL, FILTER].map(|(register, fields)| (register, fields.to_owned())));
    sensor
}

/// A link to the sensor that is up.
async fn up(sensor: &Sensor) -> Link {
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    link
}

/// The same link, with a task that sets the sensor.
async fn configuring(
    sensor: &Sensor,
    settings: OutputSettings,
    stop: &CancellationToken,
) -> (Link, JoinHandle<Result<Configured, ConfigureError>>) {
    let link = up(sensor).await;
    let (handle, stop) = (link.handle.clone(), stop.clone());
    (link, tokio::spawn(async move { configure(&handle, &settings, &stop).await }))
}

#[tokio::test(start_paused = true)]
async fn rate_and_baud_rate_are_changed_measured_and_restored() {
    let sensor = sensor();
    let mut link = up(&sensor).await;
    let handle = link.handle.clone();
    let work = tokio::spawn(async move {
        let settings =
            OutputSettings { baud: Some(921_600), rate_hz: Some(200), window: Some(4), ..OutputSettings::default() };
        let configured = configure(&handle, &settings, &CancellationToken::new()).await.unwrap();
        assert!(matches!(&*handle.state().borrow(), LinkState::Up(up) if up.baud == Some(921_600)));
        let written: Vec<_> = configured.changes.iter().map(|change| change.register).collect();
        assert_eq!(written, [Register::BAUD_RATE, Register::ASYNC_RATE], "the window is what it was");
        assert!((configured.measured_hz - 200.0).abs() < 1.0 && configured.rate_is_kept(), "{configured:?}");
        restore(&handle, &configured.changes).await.unwrap();
    });
    link.run(Duration::from_secs(8)).await;
    work.await.unwrap();
    let told = link.stop().await;
    let world = sensor.world();
    assert_eq!((world.registers[&5].as_str(), world.registers[&7].as_str()), ("115200", "40"));
    assert!(world.streams);
    let resumed = world.written.iter().filter(|(_, bytes)| bytes.starts_with(b"$VNASY,1")).count();
    assert_eq!(resumed, 2, "once each way");
    assert_eq!(told.rows, world.lines);
    assert_eq!((told.counts.connects, told.counts.tally.rejected.total()), (1, 0));
}

#[tokio::test(start_paused = true)]
async fn a_setting_that_is_not_kept_is_reported_and_the_output_continues() {
    let sensor = sensor();
    sensor.world().forgets = Some(7);
    let settings = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    link.run(Duration::from_secs(5)).await;
    assert_eq!(work.await.unwrap().unwrap_err().to_string(), "register 07 was to be 20 and reads 40");
    assert!(sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn settings_that_do_not_fit_are_not_written() {
    let sensor = sensor();
    let settings = OutputSettings { rate_hz: Some(200), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    link.run(Duration::from_secs(5)).await;
    assert!(matches!(work.await.unwrap().unwrap_err(), ConfigureError::Plan(_)));
    assert!(sensor.world().written.iter().all(|(_, bytes)| bytes.starts_with(b"$VNRRG,")));
}

#[tokio::test(start_paused = true)]
async fn a_refusal_restores_the_earlier_writes() {
    let sensor = sensor();
    // the register can be read, but not written
    sensor.world().read_only = Some(85);
    let settings = OutputSettings { rate_hz: Some(20), window: Some(40), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    link.run(Duration::from_secs(5)).await;
    let error = work.await.unwrap().unwrap_err();
    assert!(matches!(error, ConfigureError::Command(_)) && error.to_string().contains("VNERR 09"), "{error}");
    let world = sensor.world();
    assert!(world.written.iter().any(|(_, bytes)| bytes.starts_with(b"$VNWRG,07,20*")));
    assert_eq!((world.registers[&7].as_str(), world.streams), ("40", true));
}

const PACKETS_OFF: (u8, &str) = (75, "0,0,01,0001");

/// A sensor that can send packets, and the settings for one packet per measurement.
fn sensor_of_packets() -> (Sensor, OutputSettings) {
    let sensor = sensor();
    sensor.world().registers.insert(PACKETS_OFF.0, PACKETS_OFF.1.into());
    let settings = OutputSettings {
        message: Some("BINARY".into()),
        rate_hz: Some(800),
        window: Some(1),
        ..OutputSettings::default()
    };
    (sensor, settings)
}

#[tokio::test(start_paused = true)]
async fn interrupted_at_any_time_packets_leave_the_sensor_as_it_was() {
    let mut furthest = 0;
    for after in (0..2500).step_by(41).map(Duration::from_millis) {
        let (sensor, settings) = sensor_of_packets();
        let stop = CancellationToken::new();
        let (mut link, work) = configuring(&sensor, settings, &stop).await;
        link.run(after).await;
        stop.cancel();
        link.run(Duration::from_secs(4)).await;
        let error = work.await.unwrap().unwrap_err();
        let ConfigureError::Interrupted { undone } = error else { panic!("after {after:?}: {error}") };
        furthest = furthest.max(undone.len());
        let world = sensor.world();
        let registers = [5, 6, 75, 85].map(|register| world.registers[&register].as_str());
        assert_eq!((registers, world.streams), (["115200", "14", PACKETS_OFF.1, FILTER.1], true), "after {after:?}");
    }
    assert_eq!(furthest, 4, "baud rate, sentences, window and packets");
}

#[tokio::test(start_paused = true)]
async fn packets_missing_on_the_first_port_are_sent_to_the_second() {
    let (sensor, settings) = sensor_of_packets();
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    let configured = link.until_done(work).await.unwrap();
    let packets = configured.changes.iter().find(|change| change.register == Register::BINARY_OUTPUT_1).unwrap();
    assert_eq!((packets.before.as_str(), packets.after.as_str()), (PACKETS_OFF.1, "2,1,05,0001,001C"));
    // this sensor sends no packets on either port
    assert!(!configured.rate_is_kept() && configured.measured_hz == 0.0 && configured.rate_hz == 800.0);
    let asked = |line: &str| sensor.world().written.iter().any(|(_, bytes)| bytes.starts_with(line.as_bytes()));
    assert!(asked("$VNWRG,75,1,1,05") && asked("$VNWRG,75,2,1,05"));
}

/// A sentence replaces the packets of its port; those to another host on the other port go on.
#[tokio::test(start_paused = true)]
async fn a_sentence_replaces_the_packets_of_its_port_alone() {
    for (sent, kept) in [("1,20,05,0001,001C", "0,20,05,0001,001C"), ("2,20,05,0001,001C", "2,20,05,0001,001C")] {
        let (sensor, _) = sensor_of_packets();
        sensor.world().packet = Some(packet(&[5, 0x01, 0x00, 0x1C, 0x00], 36));
        sensor.world().registers.insert(75, sent.into());
        let settings = OutputSettings { message: Some("VNYMR".into()), ..OutputSettings::default() };
        let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
        let configured = link.until_done(work).await.unwrap();
        assert!(configured.rate_is_kept(), "{configured:?}");
        assert_eq!(sensor.world().registers[&75], kept);
        let handle = link.handle.clone();
        let changes = configured.changes;
        let back = tokio::spawn(async move { restore(&handle, &changes).await });
        link.until_done(back).await.unwrap();
        assert_eq!(sensor.world().registers[&75], sent);
    }
}

#[tokio::test(start_paused = true)]
async fn packets_that_a_stall_delays_stay_on_the_first_port() {
    let (sensor, settings) = sensor_of_packets();
    // time since startup, acceleration, angular rate and temperature
    sensor.world().packet = Some(packet(&[5, 0x01, 0x00, 0x1C, 0x00], 36));
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    let is_set = || sensor.world().registers[&75].starts_with("1,") && sensor.world().streams;
    while !is_set() {
        link.run(Duration::from_millis(1)).await;
    }
    sensor.world().stalled_until = Some(Instant::now() + Duration::from_millis(600));
    let configured = link.until_done(work).await.unwrap();
    let packets = configured.changes.iter().find(|change| change.register == Register::BINARY_OUTPUT_1).unwrap();
    assert_eq!(packets.after.as_str(), "1,1,05,0001,001C");
    assert!(configured.measured_hz > 30.0, "{configured:?}");
}

/// A stall too short to be a silence delays frames from the first count into the second.
#[tokio::test(start_paused = true)]
async fn frames_that_a_stall_delays_are_counted_again() {
    for after_ms in (2000..2500).step_by(20) {
        let sensor = sensor();
        let settings = OutputSettings { rate_hz: Some(50), ..OutputSettings::default() };
        let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
        while sensor.world().registers[&7] == "40" || !sensor.world().streams {
            link.run(Duration::from_millis(10)).await;
        }
        link.run(Duration::from_millis(after_ms)).await;
        sensor.world().stalled_until = Some(Instant::now() + Duration::from_millis(220));
        let configured = link.until_done(work).await.unwrap();
        assert!(configured.rate_is_kept(), "{after_ms} ms: {configured:?}");
        link.stop().await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_failed_restoration_is_reported() {
    let sensor = sensor();
    let stop = CancellationToken::new();
    let settings = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &stop).await;
    link.run(Duration::from_secs(2)).await;
    sensor.world().answers = false;
    stop.cancel();
    let error = link.until_done(work).await.unwrap_err().to_string();
    assert_eq!(
        error,
        "interrupted; the sensor may stay changed: the rate (register 07) from 40 to 20, its output, which may be paused"
    );
}

#[tokio::test(start_paused = true)]
async fn the_first_line_of_a_faster_output_may_come_a_whole_old_period_later() {
    // it is set at any time between two of its lines
    for after in (0..1000).step_by(100).map(Duration::from_millis) {
        let sensor = Sensor::new(115_200, 1);
        sensor.world().registers.insert(30, PROTOCOL.1.into());
        let mut link = up(&sensor).await;
        link.run(after).await;
        let (handle, stop) = (link.handle.clone(), CancellationToken::new());
        let settings = OutputSettings { rate_hz: Some(10), ..OutputSettings::default() };
        let work = tokio::spawn(async move { configure(&handle, &settings, &stop).await });
        let configured = link.until_done(work).await.unwrap();
        assert!(configured.rate_is_kept(), "{after:?}: {configured:?}");
        let paused = sensor.world().written.iter().filter(|(_, line)| line.starts_with(b"$VNASY,0")).count();
        assert_eq!(paused, 1, "{after:?}");
        link.stop().await;
    }
}

#[tokio::test(start_paused = true)]
async fn lines_of_a_message_that_is_not_set_are_not_counted() {
    let sensor = sensor();
    sensor.world().line = format!("{LINE}{OTHER_LINE}").leak();
    // where none is asked for, it is the one that the sensor has
    for (message, code) in [(Some("VNYMR"), "14"), (Some("VNYPR"), "1"), (None, "1")] {
        let message = message.map(str::to_owned);
        let settings = OutputSettings { rate_hz: Some(20), message, ..OutputSettings::default() };
        let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
        link.run(Duration::from_secs(5)).await;
        let configured = work.await.unwrap().unwrap();
        assert!(configured.rate_is_kept(), "{code}: {configured:?}");
        assert_eq!(sensor.world().registers[&6], code);
        link.stop().await;
    }
}

#[tokio::test(start_paused = true)]
async fn what_is_lost_with_the_power_while_it_is_counted_is_set_once_more() {
    // the port disappears with the power, and returns before or after the end of the count; or it stays
    for away in [Some(100), Some(1500), Some(4000), None].map(|away| away.map(Duration::from_millis)) {
        let (sensor, mut link, work) = counting().await;
        power_fails(&sensor, away.is_none());
        match away {
            Some(away) => {
                link.run(away).await;
                sensor.world().plugged = true;
            }
            None => {
                link.run(Duration::from_millis(1250)).await;
                let mut world = sensor.world();
                (world.streams, world.answers) = (true, true);
            }
        }
        let configured = link.until_done(work).await.unwrap();
        let told: Vec<_> = configured.changes.iter().map(ToString::to_string).collect();
        assert_eq!(told, ["the rate (register 07) from 40 to 20"], "away for {away:?}");
        assert!(configured.rate_is_kept(), "away for {away:?}: {configured:?}");
        assert_eq!(sensor.world().registers[&7], "20", "away for {away:?}");
        assert!(sensor.world().streams, "away for {away:?}");
        link.stop().await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_does_not_come_back_while_it_is_counted_may_stay_changed() {
    let (sensor, mut link, work) = counting().await;
    power_fails(&sensor, false);
    let error = link.until_done(work).await.unwrap_err().to_string();
    assert!(
        error.starts_with("the link disconnected before the reply to ")
            && error.contains("; the sensor may stay changed: "),
        "{error}"
    );
    link.stop().await;
}

/// A sensor that was set to 20 Hz and has been counted for a second.
async fn counting() -> (Sensor, Link, JoinHandle<Result<Configured, ConfigureError>>) {
    let sensor = sensor();
    let settings = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &CancellationToken::new()).await;
    while sensor.world().registers[&7] == "40" || !sensor.world().streams {
        link.run(Duration::from_millis(10)).await;
    }
    link.run(Duration::from_secs(1)).await;
    assert!(!work.is_finished());
    (sensor, link, work)
}

/// The sensor has its state after power-up; its port disappears as well, or it stays and is silent.
fn power_fails(sensor: &Sensor, port_stays: bool) {
    let mut world = sensor.world();
    world.registers.insert(7, "40".into());
    world.period = Duration::from_millis(25);
    if port_stays {
        (world.streams, world.answers) = (false, false);
    } else {
        world.plugged = false;
    }
}

/// Sets it and closes the link right after that; the stop comes this long after this many written
/// lines.
async fn configured_and_closed(
    sensor: &Sensor,
    settings: OutputSettings,
    stop_at: Option<(usize, Duration)>,
) -> Result<Configured, ConfigureError> {
    let stop = CancellationToken::new();
    let (mut link, work) = configuring(sensor, settings, &stop).await;
    if let Some((lines, after)) = stop_at {
        while !work.is_finished() && sensor.world().written.len() < lines {
            link.run(Duration::from_millis(1)).await;
        }
        link.run(after).await;
        stop.cancel();
    }
    let configured = link.until_done(work).await;
    link.stop().await;
    configured
}

#[tokio::test(start_paused = true)]
async fn stopped_at_any_request_the_output_resumes_although_the_link_closes_at_once() {
    // before the answer, and after it, when the last frames of a paused output may still come
    for after in [0, 50, 120].map(Duration::from_millis) {
        let mut lines = 0;
        let paused_first = loop {
            lines += 1;
            let sensor = sensor();
            let settings = OutputSettings { rate_hz: Some(20), window: Some(40), ..OutputSettings::default() };
            let configured = configured_and_closed(&sensor, settings, Some((lines, after))).await;
            let world = sensor.world();
            let said =
                |command: &str| world.written.iter().filter(|(_, line)| line.starts_with(command.as_bytes())).count();
            assert!(world.streams, "stopped {after:?} after line {lines}");
            let undone = match configured {
                Ok(_) => break said("$VNASY,0"),
                Err(ConfigureError::Interrupted { undone }) => undone,
                Err(error) => panic!("stopped {after:?} after line {lines}: {error}"),
            };
            // each write that was answered is reported, and a pending one may be
            let is_undone = undone.iter().any(|change| change.register == Register::ASYNC_RATE);
            assert_eq!(is_undone, said("$VNWRG,07,20") > 0, "stopped {after:?} after line {lines}");
            assert_eq!((world.registers[&7].as_str(), world.registers[&85].as_str()), ("40", FILTER.1));
        };
        assert_eq!(paused_first, 1, "no stop came before the end");
        assert!(lines > 12, "{lines}");
    }
}

#[tokio::test(start_paused = true)]
async fn the_output_resumes_after_a_refused_first_command_although_the_link_closes_at_once() {
    let sensor = sensor();
    sensor.world().read_only = Some(7);
    let rate = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
    // it has no command for saving its settings
    let save = OutputSettings { save: true, ..OutputSettings::default() };
    for (settings, refusal) in [(rate, "VNERR 09"), (save, "VNERR 04")] {
        let error = configured_and_closed(&sensor, settings, None).await.unwrap_err().to_string();
        assert!(error.contains(refusal) && !error.contains("paused"), "{error}");
        assert!(sensor.world().streams, "{refusal}");
    }
}

#[tokio::test(start_paused = true)]
async fn the_output_resumes_where_it_cannot_be_restored() {
    let sensor = sensor();
    let mut link = up(&sensor).await;
    let handle = link.handle.clone();
    let work = tokio::spawn(async move {
        let settings = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
        let changes = configure(&handle, &settings, &CancellationToken::new()).await.unwrap().changes;
        (handle, changes)
    });
    link.run(Duration::from_secs(4)).await;
    let (handle, changes) = work.await.unwrap();
    sensor.world().read_only = Some(7);
    let (restored, ()) = join!(restore(&handle, &changes), link.run(Duration::from_secs(4)));
    assert!(restored.unwrap_err().to_string().contains("VNERR 09"));
    link.stop().await;
    assert!(sensor.world().streams);
}

#[tokio::test(start_paused = true)]
async fn what_was_lost_with_the_power_is_not_reported_as_changed() {
    let fields = |text| RegisterFields::new(text).unwrap();
    let change = Change { register: Register::ASYNC_RATE, before: fields("100"), after: fields("200") };
    for (reads, stays) in [("40", false), ("100", false), ("200", true)] {
        let sensor = sensor();
        sensor.world().registers.insert(7, reads.into());
        sensor.world().read_only = Some(7);
        let mut link = up(&sensor).await;
        let handle = link.handle.clone();
        let (restored, ()) = join!(restore(&handle, slice::from_ref(&change)), link.run(Duration::from_secs(4)));
        let error = restored.err().map(|error| error.to_string());
        assert_eq!(error.is_none(), reads == "100", "it is as it was: {error:?}");
        assert_eq!(error.is_some_and(|error| error.contains("stays changed: the rate")), stays);
    }
}

#[tokio::test(start_paused = true)]
async fn an_output_that_may_be_left_paused_is_reported() {
    let sensor = sensor();
    let stop = CancellationToken::new();
    let settings = OutputSettings { rate_hz: Some(20), ..OutputSettings::default() };
    let (mut link, work) = configuring(&sensor, settings, &stop).await;
    while sensor.world().streams {
        link.run(Duration::from_millis(1)).await;
    }
    sensor.world().answers = false;
    stop.cancel();
    assert_eq!(
        link.until_done(work).await.unwrap_err().to_string(),
        "interrupted; the sensor stays changed: its output, which may be paused"
    );
}
