//! The first opening of a port, or another one: a sensor that boots, no sensor, and a receiver that
//! flips bits.

use std::time::Duration;

use crate::support::{LINE, Sensor};
use vn100_driver::LinkOptions;

/// Both rates, with a sufficient baud rate.
const RATES: [(u32, u32); 2] = [(40, 115_200), (200, 921_600)];

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_boots_is_waited_for_at_the_first_speed() {
    let asked_elsewhere = |sensor: &Sensor| sensor.world().written.iter().any(|(baud, _)| *baud != 115_200);
    let sensor = Sensor::new(115_200, 40);
    let boots = |boots: bool| (sensor.world().streams, sensor.world().answers) = (!boots, !boots);
    boots(true);
    let mut link = sensor.link(LinkOptions::default());
    for plugged in [true, false] {
        if !plugged {
            sensor.world().cut_at = Some(LINE.len());
            link.until_down().await;
            boots(true);
            sensor.world().plugged = true;
            sensor.world().stray = b"-00.9".into();
        }
        link.run(ms(1300)).await;
        boots(false);
        link.until_up().await;
        assert!(!asked_elsewhere(&sensor));
        link.run(ms(1000)).await;
    }
    // a sensor that sends is not booting
    let sensor = Sensor::new(921_600, 40);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    assert!(link.told.link.last().unwrap().0 < 1000, "{:?}", link.told.link);
}

#[tokio::test(start_paused = true)]
async fn a_link_that_never_was_up_ends_with_the_reason() {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().plugged = false;
    let told = sensor.link(LinkOptions::default()).end().await;
    assert!(told.error.unwrap().contains("cannot open /dev/imu at 115200 baud"));
    assert_eq!(sensor.world().opened.len(), 1);

    let sensor = Sensor::new(115_200, 40);
    let told = sensor.link(LinkOptions { baud: Some(9600), ..LinkOptions::default() }).end().await;
    let error = told.error.unwrap();
    assert!(error.starts_with("no sensor found on /dev/imu at 9600 baud: "), "{error}");
    assert!(error.contains("bytes received without a valid sentence"), "{error}");
    assert_eq!(told.counts.baud_scan_bytes, sensor.world().bytes);
    assert!(sensor.world().opened.len() == 2, "a sensor that was just switched on says nothing at first");
}

#[tokio::test(start_paused = true)]
async fn a_port_that_is_garbled_when_it_is_opened_first_is_opened_again() {
    // answers would stay readable
    let listening = || LinkOptions { listen_only: true, ..LinkOptions::default() };
    for (rate_hz, baud) in RATES {
        let sensor = Sensor::new(baud, rate_hz);
        sensor.world().garbled = true;
        sensor.world().bad_openings = 3;
        let mut link = sensor.link(listening());
        link.until_up().await;
        assert_eq!(link.stop().await.counts.connects, 1);
        assert_eq!(sensor.world().opened.len(), 5);
    }
    let sensor = Sensor::new(115_200, 40);
    sensor.world().garbled = true;
    sensor.world().bad_openings = 100;
    let told = sensor.link(listening()).end().await;
    assert!(told.error.unwrap().contains("without a valid sentence"));
    assert_eq!(sensor.world().opened.len(), 5, "it may be no sensor at all");
}
