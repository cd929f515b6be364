//! A recording of a link replays as it was measured.

use std::{collections::BTreeMap, time::Duration};

use crate::support::Sensor;
use tokio::{sync::mpsc, time::sleep};
use tokio_util::sync::CancellationToken;
use vn100_capture::{Capture, CaptureOptions, Event, Recorder};
use vn100_driver::{LinkOptions, open_link};
use vn100_protocol::stream::{Arrival, LinkEvent, ReadOptions, StreamCounts};

/// The content of the events: rows, their arrival times, link events with the number of rows before
/// them, counts.
async fn told(mut events: mpsc::Receiver<Event>) -> (Vec<i32>, Vec<Arrival>, Vec<(usize, LinkEvent)>, StreamCounts) {
    let (mut counts, mut arrivals, mut link, mut totals) =
        (Vec::new(), Vec::new(), Vec::new(), StreamCounts::default());
    let mut rows = 0;
    while let Some(event) = events.recv().await {
        match event {
            Event::Batch(batch) => {
                let place = |arrival: &Arrival| Arrival { from_row: rows + arrival.from_row, ..*arrival };
                arrivals.extend(batch.arrivals.iter().map(place));
                counts.extend_from_slice(&batch.counts);
                rows += batch.row_count();
                totals = batch.link;
            }
            Event::Link(event) => link.push((rows, event)),
            Event::End(end) => assert!(end.error.is_none()),
        }
    }
    (counts, arrivals, link, totals)
}

#[tokio::test(start_paused = true)]
async fn a_link_that_was_lost_and_found_replays_as_it_was_measured() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("day.mcap");
    let recorder = Recorder::create(&path, &BTreeMap::new()).unwrap();
    let sensor = Sensor::new(57_600, 40);
    let stop = CancellationToken::new();
    let options = LinkOptions { recording: Some(recorder.inputs()), ..LinkOptions::default() };
    let (handle, events) = open_link(sensor.clone(), options, stop.clone());
    let live = tokio::spawn(told(events));
    sleep(Duration::from_secs(6)).await;
    sensor.world().cut_at = Some(50);
    sleep(Duration::from_secs(1)).await;
    sensor.world().plugged = true;
    sleep(Duration::from_secs(6)).await;
    stop.cancel();
    let live = live.await.unwrap();
    assert_eq!((live.3.connects, handle.unrecorded_bytes()), (2, 0));
    assert!(recorder.finish("stopped").await.error.is_none());
    let capture = Capture::open(&path, &CaptureOptions::default()).unwrap();
    let replayed = told(capture.read(ReadOptions::default(), CancellationToken::new()).unwrap()).await;
    assert_eq!(replayed, live);
}
