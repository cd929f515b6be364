//! The byte ledger: every byte read from the port is counted and recorded, for every end of the
//! link.

use std::time::Duration;

use crate::support::{Sensor, Told};
use tokio::sync::mpsc;
use vn100_driver::LinkOptions;
use vn100_protocol::stream::{LinkEventKind, StreamInput};

/// The last baud rate in the order of the baud scan.
const LAST_BAUD: u32 = 128_000;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The bytes that a recording accounts for: the recorded ones, and those reported as missing.
async fn accounted_for(mut recorded: mpsc::Receiver<StreamInput>) -> u64 {
    let mut bytes = 0;
    while let Some(input) = recorded.recv().await {
        bytes += match input {
            StreamInput::Chunk(chunk) => chunk.bytes.len() as u64,
            StreamInput::Link(event) => match event.kind {
                LinkEventKind::DiscardedDuringBaudScan { bytes } | LinkEventKind::Overrun { bytes } => bytes,
                _ => 0,
            },
        };
    }
    bytes
}

async fn assert_ledger(told: &Told, recorded: mpsc::Receiver<StreamInput>, sensor: &Sensor, case: &str) {
    let bytes = sensor.world().bytes;
    assert_eq!(told.counts.bytes(), bytes, "counted, {case}");
    assert_eq!(accounted_for(recorded).await, bytes, "recorded, {case}");
}

#[tokio::test(start_paused = true)]
async fn bytes_of_a_baud_scan_that_an_error_ends_are_counted_and_recorded() {
    for at_ms in (0..2400).step_by(75) {
        let sensor = Sensor::new(LAST_BAUD, 20);
        let (recording, recorded) = mpsc::channel(10_000);
        let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
        tokio::time::sleep(ms(at_ms)).await;
        sensor.world().cut_at = Some(50);
        let told = link.end().await;
        assert!(told.error.is_some(), "{at_ms} ms");
        assert_ledger(&told, recorded, &sensor, &format!("error after {at_ms} ms")).await;
    }
}

#[tokio::test(start_paused = true)]
async fn bytes_of_a_baud_scan_that_a_stop_ends_are_counted_and_recorded() {
    for at_ms in (0..2400).step_by(75) {
        let sensor = Sensor::new(LAST_BAUD, 20);
        let (recording, recorded) = mpsc::channel(10_000);
        let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
        link.run(ms(at_ms)).await;
        let told = link.stop().await;
        assert_eq!(told.error, None, "{at_ms} ms");
        assert_ledger(&told, recorded, &sensor, &format!("stop after {at_ms} ms")).await;
    }
}

#[tokio::test(start_paused = true)]
async fn bytes_lost_to_a_full_recording_are_recorded_as_missing() {
    let sensor = Sensor::new(115_200, 40);
    let (recording, recorded) = mpsc::channel(10);
    let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
    link.until_up().await;
    link.run(ms(1000)).await;
    let told = link.stop().await;
    assert_ledger(&told, recorded, &sensor, "full recording").await;
}

#[tokio::test(start_paused = true)]
async fn bytes_that_come_while_an_output_is_paused_again_are_counted_and_recorded() {
    let sensor = Sensor::new(115_200, 40);
    sensor.world().streams = false;
    let (recording, recorded) = mpsc::channel(10_000);
    let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
    link.until(|kind| *kind == LinkEventKind::OutputResumed).await;
    link.run(ms(1000)).await;
    let told = link.stop().await;
    assert!(!sensor.world().streams, "paused again");
    assert_ledger(&told, recorded, &sensor, "output paused again").await;
}
