//! A machine or an adapter that stalls for a while and then delivers all bytes at once: a stall of
//! two seconds loses nothing, and a longer one loses the link, which reconnects at the former baud
//! rate.

use std::time::Duration;

use crate::support::Sensor;
use tokio::{sync::watch, task::JoinHandle, time::Instant};
use vn100_driver::{Change, LinkOptions, LinkState};
use vn100_protocol::stream::LinkEventKind;
use vn100_protocol::{Register, RegisterFields};

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The states of the link until it is closed.
fn states(mut state: watch::Receiver<LinkState>) -> JoinHandle<Vec<&'static str>> {
    tokio::spawn(async move {
        let mut told = Vec::new();
        while state.changed().await.is_ok() {
            let name = match &*state.borrow_and_update() {
                LinkState::Up(_) => "up",
                LinkState::Silent(_) => "silent",
                LinkState::Down { .. } => "down",
                _ => "other",
            };
            if told.last() != Some(&name) {
                told.push(name);
            }
        }
        told
    })
}

/// The rate was set to this.
fn set_to(rate_hz: u32) -> Vec<Change> {
    let fields = |rate_hz: u32| RegisterFields::new(rate_hz.to_string()).unwrap();
    vec![Change { register: Register::ASYNC_RATE, before: fields(10), after: fields(rate_hz) }]
}

#[tokio::test(start_paused = true)]
async fn a_stall_costs_a_link_nothing() {
    for (rate_hz, baud) in [(40, 115_200), (200, 921_600)] {
        for (answers, keep) in [(true, Vec::new()), (false, Vec::new()), (true, set_to(rate_hz))] {
            let sensor = Sensor::new(baud, rate_hz);
            sensor.world().registers.insert(3, "0100099887".into());
            let mut link = sensor.link(LinkOptions { desired_settings: keep, ..LinkOptions::default() });
            let states = states(link.handle.state());
            link.until_up().await;
            link.run(ms(6000)).await;
            // a sensor that does not report its serial number must not lose a line either
            sensor.world().answers = answers;
            let before = sensor.world().lines;
            let stalled_until = Instant::now() + ms(2000);
            sensor.world().stalled_until = Some(stalled_until);
            link.run(ms(1995)).await;
            assert_eq!((sensor.world().lines, link.told.rows), (before, before));
            link.run(ms(10)).await;
            let in_burst = sensor.world().lines - before;
            assert!(in_burst >= 2 * u64::from(rate_hz) - 1, "{in_burst} lines at once");
            link.run(ms(5000)).await;
            let told = link.stop().await;
            {
                let world = sensor.world();
                assert_eq!((told.rows, told.counts.bytes()), (world.lines, world.bytes), "answers: {answers}");
            }
            // no event after the sensor was found
            assert!(matches!(told.link.last(), Some((_, LinkEventKind::Up { .. }))), "{:?}", told.link);
            assert_eq!((told.counts.connects, told.counts.tally.rejected.total()), (1, 0));
            assert_eq!(states.await.unwrap(), ["other", "up", "silent", "up", "other"]);
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_delayed_for_long_is_found_at_its_baud_rate() {
    for (rate_hz, baud) in [(40, 115_200), (200, 921_600)] {
        for listen_only in [false, true] {
            // an attempt at one of the other baud rates takes 0.2 to 0.5 s, or 1.2 s without a question
            for stall_ms in (3500..=8000).step_by(500) {
                let start = Instant::now();
                let sensor = Sensor::new(baud, rate_hz);
                let mut link = sensor.link(LinkOptions { listen_only, ..LinkOptions::default() });
                link.until_up().await;
                link.run(ms(6000)).await;
                // if no question is sent, it is given up after ten seconds
                let stall = ms(stall_ms + if listen_only { 15_000 } else { 0 });
                let rows = link.told.rows;
                sensor.world().stalled_until = Some(Instant::now() + stall);
                link.run(stall + ms(5000)).await;
                let end_ms = start.elapsed().as_millis() as i64;
                let told = link.stop().await;
                let case = format!("{rate_hz} Hz, {stall:?}, listen only: {listen_only}: {:?}", told.link);
                let downs = told.link.iter().filter(|(_, kind)| matches!(kind, LinkEventKind::Down { .. })).count();
                assert_eq!((downs, told.counts.connects, told.counts.tally.rejected.total()), (1, 2, 0), "{case}");
                let up = LinkEventKind::Up { port: "/dev/imu".into(), baud: Some(baud) };
                assert_eq!(told.link.last().unwrap().1, up, "{case}");
                assert!(told.link.last().unwrap().0 <= end_ms - 3000, "{case}");
                assert_eq!(told.counts.bytes(), sensor.world().bytes, "{case}");
                // bytes delayed for longer than the first attempt must not begin a segment
                let since_up = end_ms - told.link.last().unwrap().0;
                let most = rows + (since_up.unsigned_abs() + 260) * u64::from(rate_hz) / 1000;
                assert!(told.rows > rows && told.rows <= most, "{} and {rows} rows, {case}", told.rows);
            }
        }
    }
}
