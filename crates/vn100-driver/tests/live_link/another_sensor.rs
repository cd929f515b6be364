//! No line of another sensor is measured, whether it is found on a port that returns or on an
//! adapter that stays; every line of the same sensor is measured.

use std::time::Duration;

use crate::support::{Link, Sensor};
use vn100_driver::{Change, LinkOptions, LinkState};
use vn100_protocol::stream::LinkEventKind;
use vn100_protocol::{Register, RegisterFields};

const KNOWN: &str = "0100099887";
const OTHER: &str = "0100012345";

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The rate was set to 20 Hz.
fn slowed() -> Vec<Change> {
    let fields = |text| RegisterFields::new(text).unwrap();
    vec![Change { register: Register::ASYNC_RATE, before: fields("40"), after: fields("20") }]
}

/// A sensor that has reported its serial number, with a link that is up.
async fn known(keep: Vec<Change>) -> (Sensor, Link) {
    let rate_hz = if keep.is_empty() { 40 } else { 20 };
    let sensor = Sensor::new(115_200, rate_hz);
    sensor.world().registers.insert(3, KNOWN.into());
    let mut link = sensor.link(LinkOptions { desired_settings: keep, ..LinkOptions::default() });
    link.until_up().await;
    // the serial number is read early
    link.run(ms(500)).await;
    assert!(link.told.registers.contains(&(3, KNOWN.into())));
    (sensor, link)
}

/// The port disappears.
async fn lost(sensor: &Sensor, link: &mut Link) {
    sensor.world().plugged = false;
    link.until_down().await;
}

/// No bytes come for a while, as when the sensor is disconnected from an adapter that stays.
async fn silent(sensor: &Sensor, link: &mut Link) {
    (sensor.world().streams, sensor.world().answers) = (false, false);
    link.run(ms(1000)).await;
    assert!(matches!(&*link.handle.state().borrow(), LinkState::Silent(_)));
}

fn speak(sensor: &Sensor) {
    (sensor.world().streams, sensor.world().answers) = (true, true);
}

/// The numbers of connects and disconnects.
fn ups_and_downs(link: &[(i64, LinkEventKind)]) -> (usize, usize) {
    let count = |is: fn(&LinkEventKind) -> bool| link.iter().filter(|(_, kind)| is(kind)).count();
    (count(|kind| matches!(kind, LinkEventKind::Up { .. })), count(|kind| matches!(kind, LinkEventKind::Down { .. })))
}

#[tokio::test(start_paused = true)]
async fn another_sensor_behind_the_name_is_neither_measured_nor_written_to() {
    let (sensor, mut link) = known(slowed()).await;
    lost(&sensor, &mut link).await;
    let (rows, written) = (link.told.rows, sensor.world().written.len());
    sensor.world().registers.insert(3, OTHER.into());
    sensor.world().plugged = true;
    let told = link.end().await;
    assert_eq!(told.error.unwrap(), "another sensor is on the port: serial number 0100012345, expected 0100099887");
    let world = sensor.world();
    assert_eq!((told.rows, told.counts.bytes()), (rows, world.bytes));
    let reads = world.written[written..].iter().all(|(_, line)| line.starts_with(b"$VNRRG,"));
    assert!(reads, "{:?}", &world.written[written..]);
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_is_known_from_before_is_measured_and_another_one_is_not() {
    for serial in [KNOWN, OTHER] {
        let sensor = Sensor::new(115_200, 40);
        sensor.world().registers.insert(3, serial.into());
        let known_serial = Some(KNOWN.into());
        let mut link = sensor.link(LinkOptions { desired_settings: slowed(), known_serial, ..LinkOptions::default() });
        if serial == KNOWN {
            link.until_up().await;
            link.run(ms(1000)).await;
            assert!(link.stop().await.rows > 30);
        } else {
            let told = link.end().await;
            assert_eq!(
                told.error.unwrap(),
                "another sensor is on the port: serial number 0100012345, expected 0100099887"
            );
            assert_eq!((told.rows, told.counts.connects), (0, 0));
        }
        assert!(sensor.world().written.iter().all(|(_, line)| line.starts_with(b"$VNRRG,")), "nothing is set");
    }
}

#[tokio::test(start_paused = true)]
async fn the_same_sensor_is_measured_on() {
    let (sensor, mut link) = known(slowed()).await;
    lost(&sensor, &mut link).await;
    sensor.world().plugged = true;
    link.until_up().await;
    assert_eq!(sensor.world().registers[&7], "20");
    link.stop().await;
}

#[tokio::test(start_paused = true)]
async fn no_line_of_another_sensor_behind_an_adapter_that_stays_is_measured() {
    for (answers_after, keep) in [(ms(20), Vec::new()), (ms(400), Vec::new()), (ms(20), slowed())] {
        let (sensor, mut link) = known(keep).await;
        silent(&sensor, &mut link).await;
        let rows = link.told.rows;
        sensor.world().registers.insert(3, OTHER.into());
        sensor.world().answers_after = answers_after;
        // it is plugged in while it sends a line
        sensor.world().garbled = true;
        speak(&sensor);
        link.run(ms(40)).await;
        sensor.world().garbled = false;
        let told = link.end().await;
        assert_eq!(told.error.unwrap(), "another sensor is on the port: serial number 0100012345, expected 0100099887");
        assert_eq!(told.rows, rows, "answers after {answers_after:?}");
        // the lines that were pending while it was verified
        assert!(sensor.world().lines > rows);
        assert_eq!(told.counts.bytes(), sensor.world().bytes);
    }
}

#[tokio::test(start_paused = true)]
async fn the_answer_of_another_sensor_without_output_ends_the_link() {
    let (sensor, mut link) = known(Vec::new()).await;
    link.run(ms(2500)).await;
    sensor.world().registers.insert(3, OTHER.into());
    // until the link asks whether it is connected
    sensor.world().streams = false;
    let error = link.end().await.error.unwrap();
    assert!(error.contains(OTHER), "{error}");
}

#[tokio::test(start_paused = true)]
async fn every_line_of_the_same_sensor_after_a_silence_is_measured() {
    for (answers_after, mute_of) in [(ms(20), None), (ms(400), None), (ms(20), Some(3))] {
        for keep in [Vec::new(), slowed()] {
            let (sensor, mut link) = known(keep).await;
            silent(&sensor, &mut link).await;
            (sensor.world().answers_after, sensor.world().mute_of) = (answers_after, mute_of);
            speak(&sensor);
            link.run(ms(5000)).await;
            assert!(matches!(&*link.handle.state().borrow(), LinkState::Up(_)));
            let told = link.stop().await;
            assert_eq!(ups_and_downs(&told.link), (1, 0), "{:?}", told.link);
            assert_eq!(
                (told.rows, told.counts.baud_scan_bytes),
                (sensor.world().lines, 0),
                "{answers_after:?} {mute_of:?}"
            );
            assert_eq!(told.counts.bytes(), sensor.world().bytes);
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_lost_its_settings_in_a_silence_is_reconfigured() {
    let (sensor, mut link) = known(slowed()).await;
    silent(&sensor, &mut link).await;
    let rows = link.told.rows;
    sensor.world().registers.insert(7, "40".into());
    sensor.world().period = ms(25);
    speak(&sensor);
    link.run(ms(200)).await;
    let cause = "the sensor was silent, and may have restarted".into();
    assert_eq!(link.told.link.last().unwrap().1, LinkEventKind::Down { cause });
    assert_eq!(link.told.rows, rows);
    link.until_up().await;
    assert_eq!(link.told.rows, rows, "what came at the other rate is no sample");
    assert_eq!(sensor.world().registers[&7], "20");
    link.run(ms(2000)).await;
    let told = link.stop().await;
    assert!(told.rows > rows + 30);
    assert_eq!(told.counts.bytes(), sensor.world().bytes);
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_only_answers_is_kept_and_not_asked_for_its_number_each_time() {
    let (sensor, mut link) = known(Vec::new()).await;
    link.run(ms(6000)).await;
    let written = sensor.world().written.len();
    sensor.world().period = ms(3_600_000);
    link.run(ms(60_000)).await;
    assert!(matches!(&*link.handle.state().borrow(), LinkState::Silent(_)));
    let asked = sensor.world().written.len() - written;
    assert!(asked <= 7, "{asked} commands in a minute");
    sensor.world().says = Some("VNYPR,-129.867,-000.355,-000.296");
    link.run(ms(60_000)).await;
    assert_eq!(ups_and_downs(&link.stop().await.link), (1, 0));
}

#[tokio::test(start_paused = true)]
async fn a_link_that_only_listens_does_not_verify_an_overheard_serial_number() {
    let sensor = Sensor::new(115_200, 40);
    let mut link = sensor.link(LinkOptions { listen_only: true, ..LinkOptions::default() });
    link.until_up().await;
    sensor.world().says = Some("VNRRG,03,0100099887");
    link.run(ms(1000)).await;
    assert!(link.told.registers.contains(&(3, KNOWN.into())));
    silent(&sensor, &mut link).await;
    speak(&sensor);
    link.run(ms(1000)).await;
    lost(&sensor, &mut link).await;
    sensor.world().plugged = true;
    link.until_up().await;
    assert_eq!(link.stop().await.rows, sensor.world().lines);
    assert_eq!(sensor.world().written, []);
}
