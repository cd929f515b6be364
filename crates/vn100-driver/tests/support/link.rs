//! A link under test, and its events.

use std::time::Duration;

use tokio::{select, sync::mpsc, task::JoinHandle, time::Instant};
use tokio_util::sync::CancellationToken;
use vn100_capture::Event;
use vn100_driver::LinkHandle;
use vn100_protocol::stream::{LinkEventKind, StreamCounts};

/// A link under test with its events.
pub(crate) struct Link {
    pub(crate) handle: LinkHandle,
    pub(crate) events: mpsc::Receiver<Event>,
    pub(crate) stop: CancellationToken,
    pub(crate) told: Told,
}

#[derive(Debug, Default)]
pub(crate) struct Told {
    pub(crate) rows: u64,
    /// The register contents that the sensor reported.
    pub(crate) registers: Vec<(u8, String)>,
    pub(crate) counts: StreamCounts,
    /// Link events, with their times in milliseconds since the start.
    pub(crate) link: Vec<(i64, LinkEventKind)>,
    pub(crate) error: Option<String>,
}

impl Link {
    /// Takes events until the wanted link event.
    pub(crate) async fn until(&mut self, wanted: impl Fn(&LinkEventKind) -> bool) {
        while let Some(event) = self.events.recv().await {
            if self.take(event) && wanted(&self.told.link.last().unwrap().1) {
                return;
            }
        }
        panic!("ended without it: {:?}", self.told);
    }

    pub(crate) async fn until_up(&mut self) {
        self.until(|kind| matches!(kind, LinkEventKind::Up { .. })).await;
    }

    pub(crate) async fn until_down(&mut self) {
        self.until(|kind| matches!(kind, LinkEventKind::Down { .. })).await;
    }

    /// Takes events for a time.
    pub(crate) async fn run(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while let Ok(event) = tokio::time::timeout_at(end, self.events.recv()).await {
            self.take(event.unwrap());
        }
    }

    /// Takes events until a task is done.
    pub(crate) async fn until_done<T>(&mut self, mut work: JoinHandle<T>) -> T {
        loop {
            select! {
                done = &mut work => return done.unwrap(),
                () = self.run(Duration::from_secs(1)) => {}
            }
        }
    }

    /// Stops the link and takes the remaining events.
    pub(crate) async fn stop(mut self) -> Told {
        self.stop.cancel();
        self.end().await
    }

    /// Takes events to the end.
    pub(crate) async fn end(&mut self) -> Told {
        while let Some(event) = self.events.recv().await {
            self.take(event);
        }
        std::mem::take(&mut self.told)
    }

    /// Whether it was a link event.
    fn take(&mut self, event: Event) -> bool {
        match event {
            Event::Batch(batch) => {
                self.told.rows += batch.row_count() as u64;
                self.told.counts = batch.link;
                self.told
                    .registers
                    .extend(batch.registers.into_iter().map(|value| (value.register.0, value.fields.to_string())));
                let tally = batch.link.tally;
                let told =
                    batch.link.samples() + batch.link.answers() + batch.link.echoes + batch.link.other_messages();
                assert_eq!(tally.valid_sentences() + tally.measured_packets.samples, told);
                false
            }
            Event::Link(event) => {
                self.told.link.push((event.at_ns / 1_000_000, event.kind));
                true
            }
            Event::End(end) => {
                self.told.error = end.error.map(|error| error.to_string());
                false
            }
        }
    }
}
