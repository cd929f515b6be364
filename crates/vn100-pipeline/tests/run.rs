//! The task around the analysis: what watchers see, what every second brings, how it ends. Time is
//! paused.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

use std::{collections::VecDeque, io, sync::Arc};

use tokio::{sync::mpsc, time};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Settings, WarningKind};
use vn100_capture::{End, Event, Source, read_samples};
use vn100_pipeline::{every_second, start};
use vn100_protocol::stream::{Batch, Chunk, Input, LinkEvent, LinkEventKind, ReadOptions};
use vn100_protocol::{DeviceError, VNYMR};

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

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

#[tokio::test(start_paused = true)]
async fn a_goal_that_the_message_cannot_show_ends_the_measurement_at_once() {
    for (goal, ends) in [("gyro B ±20%", true), ("gyro_x K ±20%", true), ("gyro N ±0.001%", false)] {
        let (events, inbox) = mpsc::channel(1);
        let until = vec![goal.parse().unwrap()];
        let measurement = start(inbox, Settings { rate_hz: Some(10.0), until, ..Settings::default() }, None);
        events.send(rows(1)).await.unwrap();
        let goes_on = events.send(rows(1)).await.is_ok() && events.send(rows(1)).await.is_ok();
        assert_eq!(goes_on, !ends, "{goal}");
        drop(events);
        let outcome = measurement.outcome().await.unwrap();
        assert_eq!(outcome.source_error.is_none(), ends, "{goal}");
    }
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

/// What a link delivered, one after the other.
struct Script(VecDeque<Input>);

impl Source for Script {
    async fn next_input(&mut self) -> io::Result<Option<Input>> {
        Ok(self.0.pop_front())
    }
}

#[tokio::test]
async fn errors_that_the_sensor_tells_unasked_are_warnings_to_the_end() {
    let read = |bytes: &[u8]| Input::Chunk(Chunk { bytes: bytes.to_vec().into(), at_ns: None });
    let refused = LinkEventKind::UnsolicitedError { error: DeviceError::InvalidCommand };
    let (full, restarted) = (read(b"$VNERR,0B*03\r\n"), read(b"$VNERR,01*70\r\n"));
    // the last but one answers a question of another moment
    let answer = read(b"$VNERR,08*79\r\n");
    let link = Input::Link(LinkEvent { at_ns: 0, kind: refused });
    let inputs = [read(LINE), full.clone(), full, restarted, link, answer, read(LINE)];
    let events = read_samples(Script(inputs.into()), ReadOptions::default(), CancellationToken::new());
    let snapshot = start(events, Settings::default(), None).outcome().await.unwrap().snapshot;
    let told: Vec<_> = (snapshot.warnings.iter())
        .filter(|warning| matches!(warning.kind, WarningKind::LinkBudget | WarningKind::DeviceErrors))
        .map(ToString::to_string)
        .collect();
    let [fault, refused, full] = &told[..] else { panic!("{told:?}") };
    assert!(fault.contains("unasked, 1 time, VNERR 01") && fault.contains("supply voltage"), "{fault}");
    assert!(refused.starts_with("device-errors: ") && refused.contains("another program"), "{refused}");
    assert!(full.starts_with("link-budget: ") && full.contains("2 times") && full.contains("lower the output rate"));
}

/// Lines of 1 Hz, each with the time of its read.
fn lines_of_1_hz(lines: i64) -> Script {
    let chunk = |second| Chunk { bytes: LINE.to_vec().into(), at_ns: Some(1_000_000_000 * second) };
    Script((0..lines).map(|second| Input::Chunk(chunk(second))).collect())
}

/// A source that stays open when all is told.
struct Open(Script);

impl Source for Open {
    async fn next_input(&mut self) -> io::Result<Option<Input>> {
        match self.0.next_input().await? {
            Some(input) => Ok(Some(input)),
            None => std::future::pending().await,
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_time_asked_for_ends_lines_of_unknown_rate_live_and_in_a_replay() {
    let settings = Settings { duration: Some(time::Duration::from_secs(5)), ..Settings::default() };
    let options = ReadOptions { line_by_line: true, ..ReadOptions::default() };
    let stop = CancellationToken::new();
    let live = read_samples(Open(lines_of_1_hz(6)), options, stop.clone());
    let live = start(live, settings.clone(), None).outcome();
    let live = time::timeout(time::Duration::from_secs(60), live).await.unwrap().unwrap().snapshot;
    assert_eq!((live.timing.samples, live.timing.left_out, live.timing.rate_hz), (5, 1, 1.0));
    for lines in [6, 7, 600] {
        let replay = read_samples(lines_of_1_hz(lines), options, stop.clone());
        let replay = start(replay, settings.clone(), None).outcome().await.unwrap().snapshot;
        assert_eq!(replay.timing, live.timing, "{lines} lines recorded");
        assert!(replay.channels.iter().zip(&live.channels).all(|(replay, live)| replay.moments == live.moments));
    }
}
