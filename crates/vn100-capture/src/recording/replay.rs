//! Recordings in, batches of samples out.

use std::io::{self, Read};

use super::reader::{Entry, RecordingReader};
use crate::{event::Event, read_samples::FileReader, source::READ_BYTES};
use vn100_protocol::stream::{Batch, CsvReport, ReadOptions, SampleReader, StreamInput};

/// Reads a recording, with one batch for many reads: a recorded read can bring a few bytes.
pub(crate) struct Replay<R> {
    recording: RecordingReader<R>,
    samples: SampleReader,
    /// Bytes since the last batch.
    unsent: usize,
}

impl<R: Read> Replay<R> {
    pub(crate) fn new(recording: RecordingReader<R>, options: ReadOptions) -> Self {
        Self { recording, samples: SampleReader::new(options), unsent: 0 }
    }
}

impl<R: Read + Send + 'static> FileReader for Replay<R> {
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let Self { recording, samples, unsent } = self;
        let link_event = recording.next_entry(|entry| match entry {
            Entry::Bytes { at_ns, bytes } => {
                samples.push(&bytes, at_ns);
                *unsent += bytes.len();
                None
            }
            Entry::Link(event) => Some(event),
            Entry::Metadata(_) => None,
        })?;
        let due: Vec<Event> = match link_event {
            None => return Ok(None),
            Some(Some(event)) => Event::from_input(samples, StreamInput::Link(event)).collect(),
            Some(None) if *unsent >= READ_BYTES => samples.take_batches().into_iter().map(Event::Batch).collect(),
            Some(None) => return Ok(Some(Vec::new())),
        };
        *unsent = 0;
        Ok(Some(due))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<CsvReport>) {
        (self.samples.finish(), None)
    }
}
