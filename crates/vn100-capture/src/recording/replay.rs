//! Recordings in, batches of samples out.

use std::{
    io::{self, Read},
    thread,
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use super::reader::{Entry, RecordingReader};
use crate::{event::End, event::Event, read_samples::WAITING_BATCHES, source::READ_BYTES};
use vn100_protocol::stream::{ReadOptions, SampleReader, StreamInput};

/// Starts a thread that reads a recording to its end, or until `stop`; tells as
/// [`read_samples`](crate::read_samples) does, but with one batch for many reads: a recorded read
/// can bring a few bytes.
pub(crate) fn read_recording(
    mut recording: RecordingReader<impl Read + Send + 'static>,
    options: ReadOptions,
    stop: CancellationToken,
) -> io::Result<mpsc::Receiver<Event>> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    let work = move || {
        let mut parser = SampleReader::new(options);
        let error = match read(&mut recording, &mut parser, &events, &stop) {
            Ok(Flow::Ended) => None,
            Ok(Flow::NobodyListens) => return,
            Err(error) => Some(error),
        };
        for batch in parser.finish() {
            // a receiver that left has no use for the end either
            let _ = events.blocking_send(Event::Batch(batch));
        }
        let _ = events.blocking_send(Event::End(End { error, csv: None }));
    };
    // ends with the recording, with `stop`, or when the inbox is dropped
    thread::Builder::new().name("recording-reader".into()).spawn(work)?;
    Ok(inbox)
}

enum Flow {
    Ended,
    NobodyListens,
}

fn read(
    recording: &mut RecordingReader<impl Read>,
    parser: &mut SampleReader,
    events: &mpsc::Sender<Event>,
    stop: &CancellationToken,
) -> io::Result<Flow> {
    let mut unsent = 0;
    while !stop.is_cancelled() {
        let shown = recording.next_entry(|entry| match entry {
            Entry::Bytes { at_ns, bytes } => {
                parser.push(&bytes, at_ns);
                unsent += bytes.len();
                None
            }
            Entry::Link(event) => Some(event),
            Entry::Metadata(_) => None,
        })?;
        let told: Vec<Event> = match shown {
            None => break,
            Some(Some(event)) => Event::from_input(parser, StreamInput::Link(event)).collect(),
            Some(None) if unsent >= READ_BYTES => parser.take_batches().into_iter().map(Event::Batch).collect(),
            Some(None) => continue,
        };
        unsent = 0;
        for event in told {
            if events.blocking_send(event).is_err() {
                return Ok(Flow::NobodyListens);
            }
        }
    }
    Ok(Flow::Ended)
}
