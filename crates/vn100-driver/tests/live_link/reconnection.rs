//! A live link to a scripted sensor: the baud scan, losses of the link, and the events for both.

use std::time::Duration;

use crate::support::{LINE, Sensor};
use tokio::sync::mpsc;
use vn100_driver::{BAUD_RATES, Change, LinkOptions, LinkState};
use vn100_protocol::stream::{LinkEventKind, StreamInput};
use vn100_protocol::{Register, RegisterFields};

/// Both rates, with a sufficient baud rate.
const RATES: [(u32, u32); 2] = [(40, 115_200), (200, 921_600)];

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[tokio::test(start_paused = true)]
async fn a_sensor_is_found_at_each_baud_rate_and_no_byte_is_lost() {
    for baud in BAUD_RATES {
        let sensor = Sensor::new(baud, 5);
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        link.run(ms(2000)).await;
        let told = link.stop().await;
        let up = LinkEventKind::Up { port: "/dev/imu".into(), baud: Some(baud) };
        assert_eq!(told.link.last().unwrap().1, up);
        assert_eq!(told.error, None);
        // every line at the correct rate is a sample, beginning with the first one found; every byte is accounted
        // for
        assert_eq!(told.rows, sensor.world().lines, "at {baud}");
        assert_eq!(told.counts.bytes(), sensor.world().bytes, "at {baud}");
        assert!(told.rows >= 9);
    }
}

#[tokio::test(start_paused = true)]
async fn listen_only_writes_nothing_and_waits_for_slow_lines() {
    for baud in [115_200, 9600] {
        let sensor = Sensor::new(baud, 1);
        let mut link = sensor.link(LinkOptions { listen_only: true, ..LinkOptions::default() });
        link.until_up().await;
        sensor.world().streams = false;
        link.run(ms(20_000)).await;
        let told = link.stop().await;
        assert_eq!(told.counts.tally.rejected.total(), 0);
        let [.., (_, LinkEventKind::Down { .. }), (_, LinkEventKind::Closed)] = told.link[..] else {
            panic!("silent for so long, it is looked for again: {:?}", told.link)
        };
        assert_eq!(sensor.world().written, []);
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_whose_output_is_paused_is_identified_and_resumed() {
    for (rate_hz, baud) in RATES {
        let sensor = Sensor::new(baud, rate_hz);
        sensor.world().streams = false;
        let mut link = sensor.link(LinkOptions::default());
        let mut state = link.handle.state();
        link.until_up().await;
        link.run(ms(2900)).await;
        assert!(!sensor.world().streams);
        state.wait_for(|state| matches!(state, LinkState::Silent(up) if up.baud == Some(baud))).await.unwrap();
        link.run(ms(200)).await;
        assert!(sensor.world().streams);
        assert!(matches!(&*state.borrow_and_update(), LinkState::Up(_)));
        link.stop().await;
        state.wait_for(|state| matches!(state, LinkState::Closed { .. })).await.unwrap();
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_without_output_is_kept_and_one_that_is_gone_is_not() {
    for (rate_hz, baud) in RATES {
        let sensor = Sensor::new(baud, rate_hz);
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        link.run(ms(1000)).await;
        // no message is selected: the sensor answers, but sends nothing
        sensor.world().period = ms(3_600_000);
        link.run(ms(60_000)).await;
        assert!(matches!(&*link.handle.state().borrow(), LinkState::Silent(_)));
        assert_eq!(link.told.counts.connects, 1);
        let written = sensor.world().written.len();
        assert!(written < 40, "{written} commands: asked every ten seconds, not identified again and again");
        // switched off, with its adapter still connected
        sensor.world().answers = false;
        link.until_down().await;
        let cause = "the sensor sends nothing and does not reply".into();
        assert_eq!(link.told.link.last().unwrap().1, LinkEventKind::Down { cause });
        link.run(ms(5000)).await;
        sensor.world().answers = true;
        sensor.world().period = ms(1000 / u64::from(rate_hz));
        link.until_up().await;
    }
}

#[tokio::test(start_paused = true)]
async fn an_unplug_in_the_middle_of_a_line_is_a_new_segment() {
    for (rate_hz, baud) in RATES {
        let sensor = Sensor::new(baud, rate_hz);
        let mut link = sensor.link(LinkOptions::default());
        let mut state = link.handle.state();
        link.until_up().await;
        link.run(ms(1000)).await;
        sensor.world().cut_at = Some(50);
        link.until_down().await;
        let down_at = sensor.world().opened.len();
        // 0.1 + 0.2 + 0.4 + 0.8 + 1.6 + 3.2 + 5 + 5 s
        link.run(ms(17_000)).await;
        {
            let world = sensor.world();
            let at: Vec<_> = world.opened[down_at..].iter().map(|(at, _)| at.as_millis()).collect();
            let waits: Vec<_> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert_eq!(waits, [200, 400, 800, 1600, 3200, 5000, 5000]);
        }
        assert!(matches!(&*state.borrow_and_update(), LinkState::Down { retry_in, .. } if *retry_in == ms(5000)));
        sensor.world().plugged = true;
        link.until_up().await;
        link.run(ms(500)).await;
        // with good data the delays are reset to the shortest
        sensor.world().cut_at = Some(LINE.len());
        link.until_down().await;
        sensor.world().plugged = true;
        link.until_up().await;
        assert!(matches!(&*state.borrow_and_update(), LinkState::Up(_)));
        let told = link.stop().await;
        let ups: Vec<_> = told.link.iter().filter(|(_, kind)| matches!(kind, LinkEventKind::Up { .. })).collect();
        let downs: Vec<_> = told.link.iter().filter(|(_, kind)| matches!(kind, LinkEventKind::Down { .. })).collect();
        assert_eq!((ups.len(), downs.len(), told.counts.connects), (3, 2, 3));
        assert!(ups[2].0 - downs[1].0 < 200, "{:?}", told.link);
        assert_eq!(told.counts.tally.rejected.truncated, 1);
        assert_eq!(told.counts.bytes(), sensor.world().bytes);
        // the last whole line came with the hang-up
        assert_eq!(told.rows, sensor.world().lines + 1);
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_needs_the_baud_rate_it_lost_with_its_power_is_reconfigured() {
    // a rate that does not fit 115 200 baud, and one that does
    for (rate_hz, baud, periods) in [("200", 460_800, 200), ("50", 115_200, 50)] {
        let sensor = Sensor::new(460_800, periods);
        let fields = |text| RegisterFields::new(text).unwrap();
        let keep = vec![Change { register: Register::ASYNC_RATE, before: fields("100"), after: fields(rate_hz) }];
        let mut link = sensor.link(LinkOptions { desired_settings: keep, ..LinkOptions::default() });
        link.until_up().await;
        link.run(ms(2000)).await;
        sensor.world().cut_at = Some(LINE.len());
        link.until_down().await;
        {
            let mut world = sensor.world();
            world.registers.extend([(5, "115200".into()), (7, "40".into())]);
            (world.baud, world.period, world.plugged) = (115_200, ms(25), true);
        }
        link.until_up().await;
        let rows = link.told.rows;
        link.run(ms(1000)).await;
        let rows = link.told.rows - rows;
        assert!(rows.abs_diff(u64::from(periods)) <= 1, "{rows}");
        link.stop().await;
        let world = sensor.world();
        assert_eq!((world.baud, world.registers[&7].as_str(), world.streams), (baud, rate_hz, true));
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_changes_its_baud_rate_by_itself_is_found_at_the_new_one() {
    for (rate_hz, baud) in RATES {
        let sensor = Sensor::new(baud, rate_hz);
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        link.run(ms(6000)).await;
        let before = sensor.world().lines;
        sensor.world().baud = 460_800;
        link.until_down().await;
        assert_eq!(sensor.world().lines, before, "junk is no line");
        link.until_up().await;
        link.run(ms(1000)).await;
        let told = link.stop().await;
        let up = LinkEventKind::Up { port: "/dev/imu".into(), baud: Some(460_800) };
        assert_eq!((&told.link.last().unwrap().1, told.counts.connects), (&up, 2));
        let world = sensor.world();
        assert_eq!((told.rows, told.counts.bytes()), (world.lines, world.bytes));
    }
}

#[tokio::test(start_paused = true)]
async fn the_recording_holds_what_came_and_never_delays() {
    let sensor = Sensor::new(115_200, 40);
    let (recording, mut recorded) = mpsc::channel(10);
    let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
    link.until_up().await;
    link.run(ms(1000)).await;
    assert!(sensor.world().lines > 35, "not delayed by a recording that nobody takes");
    assert!(
        matches!(recorded.recv().await, Some(StreamInput::Link(event)) if matches!(event.kind, LinkEventKind::Up { .. }))
    );
    let mut recorded_bytes = 0;
    while let Ok(StreamInput::Chunk(chunk)) = recorded.try_recv() {
        recorded_bytes += chunk.bytes.len() as u64;
    }
    assert_eq!(link.handle.unrecorded_bytes() + recorded_bytes, sensor.world().bytes);
    link.run(ms(30)).await;
    let unrecorded = link.handle.unrecorded_bytes();
    let overrun = LinkEventKind::Overrun { bytes: unrecorded };
    assert!(matches!(recorded.recv().await, Some(StreamInput::Link(event)) if event.kind == overrun));
    assert!(matches!(recorded.recv().await, Some(StreamInput::Chunk(_))));
    assert_eq!(link.stop().await.counts.overrun_bytes, 0, "nothing was lost for the measurement");
}

#[tokio::test(start_paused = true)]
async fn it_ends_without_a_receiver() {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().streams = false;
    let mut link = sensor.link(LinkOptions::default());
    let mut state = link.handle.state();
    link.until_up().await;
    drop(link.events);
    while state.changed().await.is_ok() {}
}
