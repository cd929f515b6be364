//! The byte ledger of a recording: bytes that it cannot take are recorded as missing, to its end.

use std::time::Duration;

use crate::support::Sensor;
use tokio::sync::mpsc;
use vn100_driver::LinkOptions;
use vn100_protocol::stream::{LinkEventKind, StreamInput};

#[tokio::test(start_paused = true)]
async fn bytes_lost_to_a_full_recording_are_recorded_as_missing() {
    let sensor = Sensor::new(115_200, 40);
    let (recording, mut recorded) = mpsc::channel(10);
    let mut link = sensor.link(LinkOptions { recording: Some(recording), ..LinkOptions::default() });
    link.until_up().await;
    link.run(Duration::from_millis(1000)).await;
    let told = link.stop().await;
    let mut accounted_for = 0;
    while let Some(input) = recorded.recv().await {
        accounted_for += match input {
            StreamInput::Chunk(chunk) => chunk.bytes.len() as u64,
            StreamInput::Link(event) => match event.kind {
                LinkEventKind::DiscardedDuringBaudScan { bytes } | LinkEventKind::Overrun { bytes } => bytes,
                _ => 0,
            },
        };
    }
    let bytes = sensor.world().bytes;
    assert_eq!((told.counts.bytes(), accounted_for), (bytes, bytes));
}
