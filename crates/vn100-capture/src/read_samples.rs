//! Chunks in, batches of samples out: the task between a source and whoever uses its samples.

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_protocol::stream::{ReadOptions, SampleReader};

use crate::{event::End, event::Event, source::Source};

/// Batches that may wait to be used: enough to keep both sides busy, few enough to keep memory
/// flat.
pub const WAITING_BATCHES: usize = 4;

/// Starts a task that reads `source` to its end, or until `stop`, and tells what it holds: a
/// [`Batch`] for each chunk, then one [`Event::End`].
///
/// When the channel is full the task waits, and so does the source behind it; when the receiver is
/// dropped it ends.
///
/// The first measurement decides which message the stream is about; lines of another one are
/// counted, not mixed in.
///
/// # Panics
/// Outside a tokio runtime.
#[must_use]
pub fn read_samples(source: impl Source, options: ReadOptions, stop: CancellationToken) -> mpsc::Receiver<Event> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    // ends with the source, with `stop`, or when the inbox is dropped
    tokio::spawn(read(source, options, events, stop));
    inbox
}

async fn read(mut source: impl Source, options: ReadOptions, events: mpsc::Sender<Event>, stop: CancellationToken) {
    let mut reader = SampleReader::new(options);
    let error = loop {
        let input = tokio::select! {
            // checked first: a source that always has data must not outrun the request to stop
            biased;
            () = stop.cancelled() => break None,
            input = source.next_input() => input,
        };
        let input = match input {
            Ok(Some(input)) => input,
            Ok(None) => break None,
            Err(error) => break Some(error),
        };
        for event in Event::from_input(&mut reader, input) {
            if events.send(event).await.is_err() {
                return;
            }
        }
    };
    for batch in reader.finish() {
        // a receiver that left has no use for the end either
        let _ = events.send(Event::Batch(batch)).await;
    }
    let _ = events.send(Event::End(End { error, csv: None })).await;
}
