//! A live link on a scripted sensor: the search for its speed, losses of the link, and what is told of both.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod support;

use std::time::Duration;

use support::{LINE, QUESTION, Sensor};
use tokio::sync::mpsc;
use vn100_driver::{BAUD_RATES, Input, LinkEventKind, LinkOptions, LinkState};

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[tokio::test(start_paused = true)]
async fn a_sensor_is_found_at_each_speed_and_no_byte_is_lost() {
    for baud in BAUD_RATES {
        let sensor = Sensor::new(baud, 5);
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        link.run(ms(2000)).await;
        let told = link.stop().await;
        let up = LinkEventKind::Up { port: "/dev/imu".into(), baud: Some(baud) };
        assert_eq!(told.link.last().unwrap().1, up);
        assert_eq!(told.error, None);
        // every line at the right speed is a sample, from the one it was found by on; every byte is accounted for
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
        assert_eq!(link.stop().await.counts.tally.bad.total(), 0);
        assert_eq!(sensor.world().written, []);
    }
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_sends_nothing_is_asked() {
    let sensor = Sensor::new(57_600, 40);
    sensor.world().streams = false;
    let mut link = sensor.link(LinkOptions::default());
    let mut state = link.handle.state();
    link.until_up().await;
    link.run(ms(4000)).await;
    assert!(matches!(&*state.borrow_and_update(), LinkState::Silent(up) if up.baud == Some(57_600)));
    sensor.world().streams = true;
    link.run(ms(100)).await;
    assert!(matches!(&*state.borrow_and_update(), LinkState::Up(_)));
    let told = link.stop().await;
    assert_eq!(told.counts.tally.replies, 1, "the answer by which it was found");
    assert!(sensor.world().written.iter().all(|(_, bytes)| bytes == QUESTION));
    assert!(matches!(&*state.borrow_and_update(), LinkState::Closed));
}

#[tokio::test(start_paused = true)]
async fn an_unplug_in_the_middle_of_a_line_is_a_new_segment() {
    let sensor = Sensor::new(115_200, 40);
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
    // with good data the waits begin from the shortest again
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
    assert_eq!(told.counts.tally.bad.truncated, 1);
    assert_eq!(told.counts.bytes(), sensor.world().bytes);
    // the last whole line came with the hang-up
    assert_eq!(told.rows, sensor.world().lines + 1);
}

#[tokio::test(start_paused = true)]
async fn the_speed_it_had_is_tried_first() {
    let sensor = Sensor::new(9600, 5);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    link.run(ms(1000)).await;
    sensor.world().cut_at = Some(LINE.len());
    link.until_down().await;
    sensor.world().plugged = true;
    link.until_up().await;
    let told = link.stop().await;
    let [.., (down, _), (up, _)] = told.link[..] else { panic!("{:?}", told.link) };
    // the first wait, and at most a line's time and the question
    assert!(up - down < 500, "{:?}", told.link);
}

#[tokio::test(start_paused = true)]
async fn a_garbled_session_is_closed_within_a_third_of_a_second_and_opened_again() {
    let sensor = Sensor::new(115_200, 40);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    link.run(ms(1000)).await;
    sensor.world().garbled = true;
    let garbled_at = sensor.world().bytes;
    let began = tokio::time::Instant::now();
    link.until_down().await;
    assert!(began.elapsed() <= ms(350), "{:?}", began.elapsed());
    let bytes = sensor.world().bytes - garbled_at;
    let cause = format!("{bytes} bytes came in 300 ms and no good line was among them");
    assert_eq!(link.told.link.last().unwrap().1, LinkEventKind::Down { cause });
    link.until_up().await;
    link.run(ms(500)).await;
    let told = link.stop().await;
    assert_eq!((told.counts.connects, told.rows), (2, sensor.world().lines));
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
    assert!(error.starts_with("no sensor is heard on /dev/imu at 9600 baud: "), "{error}");
    assert!(error.contains("bytes came and none of them made a good line"), "{error}");
    assert_eq!(told.counts.probed_bytes, sensor.world().bytes);
    assert!(sensor.world().opened.len() == 2, "a sensor that was just switched on says nothing at first");
}

#[tokio::test(start_paused = true)]
async fn the_recording_holds_what_came_and_never_delays() {
    let sensor = Sensor::new(115_200, 40);
    let (recording, mut recorded) = mpsc::channel(10);
    let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
    link.until_up().await;
    link.run(ms(1000)).await;
    let lines = sensor.world().lines;
    assert!(lines > 35, "not delayed by a recording that nobody takes");
    assert_eq!(link.handle.unrecorded_bytes(), (lines - 9) * LINE.len() as u64);
    assert!(
        matches!(recorded.recv().await, Some(Input::Link(event)) if matches!(event.kind, LinkEventKind::Up { .. }))
    );
    while recorded.try_recv().is_ok() {}
    link.run(ms(30)).await;
    let unrecorded = link.handle.unrecorded_bytes();
    let overrun = LinkEventKind::Overrun { bytes: unrecorded };
    assert!(matches!(recorded.recv().await, Some(Input::Link(event)) if event.kind == overrun));
    assert!(matches!(recorded.recv().await, Some(Input::Chunk(_))));
    assert_eq!(link.stop().await.counts.overrun_bytes, 0, "nothing was lost for the measurement");
}

#[tokio::test(start_paused = true)]
async fn it_ends_when_nobody_listens() {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().streams = false;
    let mut link = sensor.link(LinkOptions::default());
    let mut state = link.handle.state();
    link.until_up().await;
    drop(link.events);
    while state.changed().await.is_ok() {}
}
