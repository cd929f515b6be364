//! Requests to a scripted sensor over a live link, and its answers between its lines, also on a
//! line that echoes.

use std::time::Duration;

use crate::support::{LINE, Sensor};
use vn100_driver::{BAUD_RATES, CommandError, LinkOptions, OutputSettings};
use vn100_protocol::stream::LinkEventKind;
use vn100_protocol::{AsyncRate, DeviceError, Register, RequestFailure, Response, SensorCommand};

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[tokio::test(start_paused = true)]
async fn the_sensor_is_identified_while_it_streams() {
    let sensor = Sensor::new(115_200, 40);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    let first = sensor.world().lines;
    link.run(ms(6000)).await;
    let told = link.stop().await;
    let expected = [(7, "40"), (6, "14"), (1, "VN-100S-CR"), (5, "115200")];
    let expected: Vec<_> = expected.into_iter().map(|(register, fields)| (register, fields.to_owned())).collect();
    assert_eq!(told.registers, expected);
    assert_eq!(told.counts.tally.replies, 24, "the others do not exist, and the sensor says so");
    assert!(told.rows >= first + 239, "samples flow meanwhile");
}

#[tokio::test(start_paused = true)]
async fn requests_are_answered_between_the_lines() {
    let sensor = Sensor::new(115_200, 40);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    let handle = link.handle.clone();
    let asked = tokio::spawn(async move {
        let read = handle.read(Register::ASYNC_RATE).await;
        let refused = handle.request(SensorCommand::ReadRegister(Register(99))).await;
        let absent = handle.read(Register(99)).await;
        let written = handle.request(SensorCommand::write(&AsyncRate::new(50).unwrap())).await;
        (read, refused, absent, written)
    });
    link.run(ms(2000)).await;
    let (read, refused, absent, written) = asked.await.unwrap();
    let Ok(Response::Register(written)) = written else { panic!("{written:?}") };
    assert_eq!((read.unwrap().unwrap().fields.as_str(), written.fields.as_str()), ("40", "50"));
    let text = refused.unwrap_err().to_string();
    assert!(text.starts_with("the sensor refused $VNRRG,99*73 with VNERR 08: "), "{text}");
    assert_eq!(absent, Ok(None));
    // a lost link answers at once: the pending command, and later ones
    link.run(ms(4000)).await;
    sensor.world().answers = false;
    let handle = link.handle.clone();
    let asked = tokio::spawn(async move { handle.read(Register::ASYNC_RATE).await });
    link.run(ms(30)).await;
    sensor.world().cut_at = Some(LINE.len());
    link.until_down().await;
    let down = |attempts| {
        let failure = RequestFailure::LinkDown { line: "$VNRRG,07*74".into(), attempts };
        Err(CommandError::Failed(failure))
    };
    assert_eq!(asked.await.unwrap(), down(1));
    assert_eq!(link.handle.read(Register::ASYNC_RATE).await, down(0));
    // no sample was lost meanwhile
    let handle = link.handle.clone();
    assert_eq!(link.stop().await.rows, sensor.world().lines + 1);
    assert_eq!(handle.read(Register::ASYNC_RATE).await, Err(CommandError::LinkClosed));
}

#[tokio::test(start_paused = true)]
async fn a_sensor_that_sends_and_does_not_answer_has_a_wire_of_one_way() {
    for sends in [true, false] {
        let sensor = Sensor::new(115_200, 40);
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        let handle = link.handle.clone();
        sensor.world().answers = false;
        sensor.world().streams = sends;
        let asked = tokio::spawn(async move { handle.read(Register::ASYNC_RATE).await });
        link.run(ms(2000)).await;
        let error = asked.await.unwrap().unwrap_err();
        assert_eq!(matches!(error, CommandError::OneWay { .. }), sends, "{error}");
        assert_eq!(error.to_string().contains("though the sensor sends: check the wire"), sends, "{error}");
    }
}

/// A sensor on a line that echoes, such as RS-485 over two wires.
fn echoing(baud: u32) -> Sensor {
    let sensor = Sensor::new(baud, 40);
    sensor.world().echoes = true;
    sensor
}

#[tokio::test(start_paused = true)]
async fn a_sensor_behind_an_echoing_line_is_found_and_identified() {
    for baud in BAUD_RATES {
        let sensor = echoing(baud);
        sensor.world().streams = false;
        let mut link = sensor.link(LinkOptions::default());
        link.until_up().await;
        sensor.world().streams = true;
        link.run(ms(6000)).await;
        let told = link.stop().await;
        assert_eq!(told.registers.iter().filter(|(register, _)| *register == 7).count(), 1);
        // the answer to the baud scan, and the answers to the identification
        assert_eq!((told.counts.echoes, told.counts.answers()), (24, 25), "at {baud}");
        assert_eq!(told.counts.unsolicited_errors.iter().count(), 0);
        assert_eq!(told.rows, sensor.world().lines);
    }
}

#[tokio::test(start_paused = true)]
async fn a_write_over_a_line_that_echoes_counts_after_the_answer_of_the_sensor() {
    let sensor = echoing(115_200);
    let told = [(30, "0,0,0,0,1,0,1"), (85, "0,4,4,4,0,0,3,3,3,0")];
    sensor.world().registers.extend(told.map(|(register, fields)| (register, fields.to_owned())));
    // it answers a write that it does not execute
    sensor.world().read_only = Some(85);
    let mut link = sensor.link(LinkOptions::default());
    link.until_up().await;
    link.run(ms(1000)).await;
    let handle = link.handle.clone();
    let work = tokio::spawn(async move {
        let stop = tokio_util::sync::CancellationToken::new();
        let set = |rate_hz, window| OutputSettings { rate_hz, window, ..OutputSettings::default() };
        let taken = vn100_driver::configure(&handle, &set(Some(20), None), &stop).await.unwrap();
        let refused = vn100_driver::configure(&handle, &set(None, Some(40)), &stop).await.unwrap_err();
        (taken.rate_is_kept(), refused.to_string())
    });
    link.run(ms(8000)).await;
    let (is_kept, refused) = work.await.unwrap();
    assert!(is_kept);
    assert!(refused.starts_with("the sensor refused $VNWRG,85,"), "the write, not what is asked behind it: {refused}");
    let world = sensor.world();
    assert_eq!((world.registers[&7].as_str(), world.streams), ("20", true));
}

#[tokio::test(start_paused = true)]
async fn unsolicited_errors_are_counted() {
    use DeviceError::{InvalidCommand, OutputBufferOverflow};
    for listen_only in [false, true] {
        let sensor = Sensor::new(115_200, 40);
        let mut link = sensor.link(LinkOptions { listen_only, ..LinkOptions::default() });
        link.until_up().await;
        link.run(ms(7000)).await;
        assert_eq!(link.told.counts.unsolicited_errors.iter().count(), 0, "what is asked and refused is none");
        for says in ["VNERR,0B", "VNERR,04", "VNERR,0B"] {
            sensor.world().says = Some(says);
            link.run(ms(100)).await;
        }
        let told = link.stop().await;
        let errors: Vec<_> = told.counts.unsolicited_errors.iter().collect();
        assert_eq!(errors, [(InvalidCommand, 1), (OutputBufferOverflow, 2)]);
        let events = told.link.iter().filter(|(_, kind)| matches!(kind, LinkEventKind::UnsolicitedError { .. }));
        assert_eq!(events.count(), 1, "of what the stream cannot tell");
        assert_eq!(told.counts.connects, 1);
    }
}
