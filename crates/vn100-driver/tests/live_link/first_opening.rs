//! The first opening of a port, or another one, with a receiver that flips bits.

use crate::support::Sensor;
use vn100_driver::LinkOptions;

/// Both rates, with a sufficient baud rate.
const RATES: [(u32, u32); 2] = [(40, 115_200), (200, 921_600)];

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
