//! The samples of a session for a writer in parallel with the measurement.

use std::{
    collections::VecDeque,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::stream::Batch;

/// Batches that may wait for the writer: ten seconds of 800 packets.
const WAITING_BATCHES: usize = 8192;

/// Sends the samples of a session to a writer. A link never waits for the writer: if its channel of
/// 8192 batches is full, batches are dropped and their samples counted. A capture or a stream
/// waits until it is stopped.
#[derive(Debug, Clone)]
pub struct SampleTap {
    batches: mpsc::Sender<Box<Batch>>,
    dropped: Arc<AtomicU64>,
}

impl SampleTap {
    /// A tap, and the receiver of its batches, which closes at the end of the session.
    pub fn new() -> (Self, mpsc::Receiver<Box<Batch>>) {
        let (batches, receiver) = mpsc::channel(WAITING_BATCHES);
        (Self { batches, dropped: Arc::default() }, receiver)
    }

    /// The number of samples that were dropped. The counter is shared and keeps counting.
    pub fn dropped(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.dropped)
    }

    /// Sends the samples of a batch. A writer that has ended takes no more samples, which is not counted as a
    /// loss: the writer reports why it ended.
    pub(crate) async fn send(&self, batch: Box<Batch>, can_wait: bool, stop: &CancellationToken) {
        if can_wait {
            let samples = batch.row_count() as u64;
            tokio::select! {
                // checked first: what the writer can take is not dropped
                biased;
                _ = self.batches.send(batch) => {}
                // after a stop the writer is not waited for
                () = stop.cancelled() => {
                    self.dropped.fetch_add(samples, Ordering::Relaxed);
                }
            }
        } else if let Err(mpsc::error::TrySendError::Full(batch)) = self.batches.try_send(batch) {
            self.dropped.fetch_add(batch.row_count() as u64, Ordering::Relaxed);
        }
    }
}

/// The samples of a measurement until it is known that they precede its end: no more than those whose gaps
/// are undecided.
#[derive(Debug, Default)]
pub(crate) struct UntappedSamples {
    /// Each with the number of its rows that repeat no others.
    batches: VecDeque<(Box<Batch>, u64)>,
    rows: u64,
}

impl UntappedSamples {
    /// Adds a batch, of which this many rows repeat others.
    pub(crate) fn push(&mut self, batch: &Batch, repeated: u64) {
        if batch.row_count() > 0 {
            let rows = batch.row_count() as u64 - repeated;
            self.rows += rows;
            self.batches.push_back((batch.clone().into(), rows));
        }
    }

    /// The next batch that is before the last rows, this many.
    pub(crate) fn next_before(&mut self, last: u64) -> Option<Box<Batch>> {
        let (_, rows) = self.batches.front().filter(|(_, rows)| self.rows >= rows + last)?;
        self.rows -= rows;
        self.batches.pop_front().map(|(batch, _)| batch)
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::protocol::VNYMR;

    use super::*;

    fn rows(count: usize) -> Box<Batch> {
        let layout = Arc::new(VNYMR.clone());
        let counts = vec![0; layout.channels.len() * count];
        Batch { counts, layout: Some(layout), ..Batch::default() }.into()
    }

    #[tokio::test(start_paused = true)]
    async fn a_link_waits_for_no_writer_and_every_dropped_sample_is_counted() {
        let (tap, mut receiver) = SampleTap::new();
        let stop = CancellationToken::new();
        for _ in 0..WAITING_BATCHES + 10 {
            tap.send(rows(3), false, &stop).await;
        }
        assert_eq!(tap.dropped().load(Ordering::Relaxed), 30);
        receiver.close();
        tap.send(rows(3), false, &stop).await;
        assert_eq!(tap.dropped().load(Ordering::Relaxed), 30, "a writer that has ended says why itself");
    }

    #[tokio::test(start_paused = true)]
    async fn a_source_that_can_wait_drops_nothing() {
        let (tap, mut receiver) = SampleTap::new();
        let writer = tokio::spawn(async move {
            let mut batches = 0;
            while receiver.recv().await.is_some() {
                tokio::time::sleep(std::time::Duration::from_millis(1)).await;
                batches += 1;
            }
            batches
        });
        let (stop, dropped) = (CancellationToken::new(), tap.dropped());
        for _ in 0..5 * WAITING_BATCHES {
            tap.send(rows(1), true, &stop).await;
        }
        // a stop drops only what does not fit
        let (after, mut receiver) = SampleTap::new();
        stop.cancel();
        for _ in 0..WAITING_BATCHES + 10 {
            after.send(rows(3), true, &stop).await;
        }
        assert_eq!((after.dropped().load(Ordering::Relaxed), receiver.len()), (30, WAITING_BATCHES));
        receiver.close();
        drop(tap);
        assert_eq!((writer.await.unwrap(), dropped.load(Ordering::Relaxed)), (5 * WAITING_BATCHES, 0));
    }
}
