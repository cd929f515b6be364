//! The task around the analysis: what watchers see, what every second brings, how it ends. Time is paused.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

use std::{io, sync::Arc};

use tokio::{sync::mpsc, time};
use vn100_driver::{Batch, End, Event, protocol::VNYMR};
use vn100_pipeline::{Settings, every_second, start};

fn rows(count: usize) -> Event {
    let layout = Arc::new(VNYMR.clone());
    Event::Batch(Batch { counts: vec![0; count * layout.channels.len()], layout: Some(layout), ..Batch::default() })
}

#[tokio::test(start_paused = true)]
async fn watchers_see_the_latest_and_delay_nobody() {
    let (events, inbox) = mpsc::channel(1);
    let mut measurement = start(inbox, Settings::default(), None);
    for _ in 0..100 {
        events.send(rows(3)).await.unwrap();
    }
    measurement.latest.changed().await.unwrap();
    time::advance(time::Duration::from_millis(200)).await;
    measurement.latest.changed().await.unwrap();
    assert_eq!(measurement.latest.borrow().timing.samples, 300);
    events.send(Event::End(End { error: None, csv: None })).await.unwrap();
    let outcome = measurement.outcome().await.unwrap();
    assert_eq!(outcome.snapshot.timing.samples, 300);
    assert!(outcome.source_error.is_none());
}

#[tokio::test(start_paused = true)]
async fn every_second_of_data_brings_one_snapshot() {
    let (events, inbox) = mpsc::channel(1);
    let (seconds, mut each) = every_second();
    let measurement = start(inbox, Settings { rate_hz: Some(10.0), ..Settings::default() }, Some(seconds));
    tokio::spawn(async move {
        for _ in 0..47 {
            events.send(rows(1)).await.unwrap();
        }
        events.send(Event::End(End { error: None, csv: None })).await.unwrap();
    });
    let mut samples = Vec::new();
    while let Some(snapshot) = each.recv().await {
        samples.push(snapshot.timing.samples);
    }
    assert_eq!(samples, [10, 20, 30, 40]);
    assert_eq!(measurement.outcome().await.unwrap().snapshot.timing.samples, 47);
}

#[tokio::test]
async fn the_error_of_the_source_comes_with_the_results_before_it() {
    let (events, inbox) = mpsc::channel(1);
    let measurement = start(inbox, Settings::default(), None);
    events.send(rows(5)).await.unwrap();
    events.send(Event::End(End { error: Some(io::Error::other("unplugged")), csv: None })).await.unwrap();
    let outcome = measurement.outcome().await.unwrap();
    assert_eq!(outcome.snapshot.timing.samples, 5);
    assert_eq!(outcome.source_error.unwrap().to_string(), "unplugged");
}

#[tokio::test]
async fn a_source_that_vanishes_without_an_end_is_an_error() {
    let (events, inbox) = mpsc::channel(1);
    let measurement = start(inbox, Settings::default(), None);
    events.send(rows(5)).await.unwrap();
    drop(events);
    let outcome = measurement.outcome().await.unwrap();
    assert_eq!(outcome.snapshot.timing.samples, 5);
    assert!(outcome.source_error.is_some());
}

#[tokio::test(start_paused = true)]
async fn a_measurement_obeys_while_it_runs() {
    let (events, inbox) = mpsc::channel(1);
    let measurement = start(inbox, Settings { rate_hz: Some(10.0), ..Settings::default() }, None);
    let controls = measurement.controls.clone();
    let mut latest = measurement.latest.clone();
    events.send(rows(50)).await.unwrap();
    latest.wait_for(|snapshot| snapshot.timing.samples == 50).await.unwrap();
    assert_eq!(controls.end_warm_up().await, Some(time::Duration::from_secs(5)));
    events.send(rows(20)).await.unwrap();
    latest.wait_for(|snapshot| snapshot.timing.samples == 20).await.unwrap();
    assert_eq!(latest.borrow().timing.left_out, 50);
    assert_eq!(controls.start_over().await, Some(time::Duration::from_secs(7)));
    events.send(rows(8)).await.unwrap();
    drop(events);
    let timing = measurement.outcome().await.unwrap().snapshot.timing;
    assert_eq!((timing.samples, timing.left_out), (8, 70));
    assert_eq!(controls.start_over().await, None, "nobody measures any more");
}
