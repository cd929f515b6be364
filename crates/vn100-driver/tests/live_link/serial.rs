//! A serial port on a pseudo-terminal: the transferred bytes, a hang-up, and other programs that open it.

use std::io::{ErrorKind, Read, Write};

use serialport::{SerialPort, TTYPort};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Clock, Event, Source};
use vn100_driver::{
    Connect, ConnectError, Connection, LinkOptions, LinkState, PortProblem, SerialConnection, SerialPorts, open_link,
};
use vn100_protocol::stream::{StreamCounts, StreamInput};

/// The sensor's end, and the name of our end.
fn terminal() -> (TTYPort, String) {
    let (sensor, ours) = TTYPort::pair().unwrap();
    let name = ours.name().unwrap();
    (sensor, name)
}

async fn open(name: &str) -> SerialConnection {
    SerialPorts::new(name, Clock::start()).open(115_200).await.unwrap()
}

async fn receive(connection: &mut SerialConnection, length: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while bytes.len() < length {
        match connection.next_input().await.unwrap() {
            Some(StreamInput::Chunk(chunk)) => {
                assert!(chunk.at_ns.is_some());
                bytes.extend_from_slice(&chunk.bytes);
            }
            other => panic!("{other:?} after {} bytes", bytes.len()),
        }
    }
    bytes
}

#[tokio::test]
async fn every_byte_passes_both_ways_unchanged() {
    let (mut sensor, name) = terminal();
    let mut connection = open(&name).await;
    // line ends, control characters and all others: no byte may be interpreted on the way
    let all: Vec<u8> = (0..=255).cycle().take(2000).collect();
    sensor.write_all(&all).unwrap();
    assert_eq!(receive(&mut connection, all.len()).await, all);

    connection.write(b"$VNRRG,01*72\r\n").await.unwrap();
    let mut command = [0; 14];
    sensor.read_exact(&mut command).unwrap();
    assert_eq!(&command, b"$VNRRG,01*72\r\n");
    assert!(connection.latency_timer().is_none(), "a pseudo terminal has none");
}

#[tokio::test]
async fn the_speed_changes_on_the_open_port() {
    let (mut sensor, name) = terminal();
    let mut connection = open(&name).await;
    assert_eq!(sensor.baud_rate().unwrap(), 115_200);
    for baud in [9600, 128_000, 921_600] {
        connection.set_baud(baud).unwrap();
        assert_eq!(sensor.baud_rate().unwrap(), baud);
    }
    sensor.write_all(b"still here").unwrap();
    assert_eq!(receive(&mut connection, 10).await, b"still here");
}

#[tokio::test]
async fn a_hang_up_is_an_error_and_the_name_is_free_again() {
    let (sensor, name) = terminal();
    let mut connection = open(&name).await;
    drop(sensor);
    assert_eq!(connection.next_input().await.unwrap_err().kind(), ErrorKind::BrokenPipe);
    assert!(connection.write(b"$VNRRG,01*72\r\n").await.is_err());
    connection.close().await;
}

#[tokio::test]
async fn a_port_is_opened_once_and_again_after_it_was_closed() {
    let (_sensor, name) = terminal();
    let first = open(&name).await;
    let error = SerialPorts::new(&name, Clock::start()).open(115_200).await.map(drop).unwrap_err();
    // this process has the other side as well, and the device is not reported as a user of the port
    assert!(matches!(&error, ConnectError::Port { problem: PortProblem::Busy(None), .. }), "{error}");
    first.close().await;
    open(&name).await.close().await;
}

#[tokio::test]
async fn ports_that_cannot_be_opened_are_reported_by_kind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("capture.vnymr");
    std::fs::write(&file, "").unwrap();
    for (name, missing) in [
        ("/dev/no-such-port", true),
        ("/dev/null", false),
        (folder.path().to_str().unwrap(), false),
        (file.to_str().unwrap(), false),
    ] {
        let error = SerialPorts::new(name, Clock::start()).open(9600).await.map(drop).unwrap_err();
        assert!(error.to_string().starts_with(&format!("cannot open {name} at 9600 baud: ")), "{error}");
        let ConnectError::Port { problem, .. } = error else { panic!("{error}") };
        assert_eq!(matches!(problem, PortProblem::NotFound(_)), missing, "{problem:?}");
        assert_eq!(matches!(problem, PortProblem::NotASerialPort(_)), !missing, "{problem:?}");
    }
}

#[tokio::test]
async fn inputs_that_wait_when_a_link_is_stopped_are_counted() {
    const LINES: usize = 200;
    let (mut sensor, name) = terminal();
    let stop = CancellationToken::new();
    let (link, mut events) = open_link(SerialPorts::new(&name, Clock::start()), LinkOptions::default(), stop.clone());
    link.state().wait_for(|state| matches!(state, LinkState::Probing { .. })).await.unwrap();
    let line = b"$VNYPR,-129.867,-000.355,-000.296*61\r\n".repeat(25);
    let writer = std::thread::spawn(move || {
        (0..LINES).for_each(|_| sensor.write_all(&line).unwrap());
        (sensor, LINES * line.len())
    });
    // no event is taken meanwhile, so the bytes wait before the link
    let (_sensor, written) = tokio::task::spawn_blocking(|| writer.join().unwrap()).await.unwrap();
    stop.cancel();
    let mut counts = StreamCounts::default();
    while let Some(event) = events.recv().await {
        if let Event::Batch(batch) = event {
            counts = batch.link;
        }
    }
    // bytes in the buffer of the system were not read
    const UNREAD: usize = 80_000;
    let counted = (counts.bytes() + counts.overrun_bytes) as usize;
    assert!(counted + UNREAD >= written, "{counted} of {written} bytes");
}
