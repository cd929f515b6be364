//! The events of a stream of samples, and the two loops that read a source to its end and send
//! them: a task for a source that waits, and a thread for a file.

use std::{collections::VecDeque, io, thread};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_protocol::stream::{Batch, FileReport, LinkEvent, ReadOptions, SampleReader, StreamInput};

use crate::source::Source;

/// Batches that may wait: enough to keep both sides busy, with little memory.
pub const WAITING_BATCHES: usize = 4;

/// An event of a stream, in the order of the stream.
#[derive(Debug)]
pub enum Event {
    /// The samples of one read, with the counts of everything else in it.
    Batch(Box<Batch>),
    /// A change of the link, live or recorded. The counts of the batch before it include it.
    Link(LinkEvent),
    /// The end of the stream; nothing follows.
    End(End),
}

impl From<Batch> for Event {
    fn from(batch: Batch) -> Self {
        Self::Batch(Box::new(batch))
    }
}

impl Event {
    /// The events of one input of a source.
    pub fn from_input(reader: &mut SampleReader, input: StreamInput) -> impl Iterator<Item = Self> + use<> {
        let link_event = match input {
            StreamInput::Chunk(chunk) => {
                reader.push(&chunk.bytes, chunk.at_ns);
                None
            }
            StreamInput::Link(event) => {
                reader.take_link_event(&event);
                Some(event)
            }
        };
        reader.take_batches().into_iter().map(Self::from).chain(link_event.map(Self::Link))
    }
}

/// The end of a stream.
#[derive(Debug)]
pub struct End {
    /// The error that ended the stream; `None` at the end of the data, or if reading was stopped.
    pub error: Option<io::Error>,
    /// The counts of the rows or messages of a file; `None` for a stream of bytes.
    pub report: Option<FileReport>,
}

/// Starts a task that reads `source` to its end, or until `stop`, and sends a [`Batch`] for each
/// chunk, then one [`Event::End`].
///
/// While the channel of [`WAITING_BATCHES`] is full, the task and the source wait; when the
/// receiver is dropped, the task ends.
///
/// The first measurement decides the message of the stream; frames of another message are counted
/// and give no samples.
///
/// # Panics
/// If called outside a tokio runtime.
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
            // checked first: a source that always has data must not delay the stop
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
        // a receiver that was dropped does not need the end either
        let _ = events.send(batch.into()).await;
    }
    let _ = events.send(Event::End(End { error, report: None })).await;
}

/// A file whose reads block.
pub(crate) trait FileReader: Send + 'static {
    /// One step: the events that follow from it, or `None` at the end of the file.
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>>;

    /// The last batches, and the counts of the content.
    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>);
}

/// The events of a file, one after the other, read as they are asked for; the last one is
/// [`Event::End`].
pub struct FileEvents {
    /// `None` after the end.
    file: Option<Box<dyn FileReader>>,
    due: VecDeque<Event>,
}

impl FileEvents {
    pub(crate) fn new(file: Box<dyn FileReader>) -> Self {
        Self { file: Some(file), due: VecDeque::new() }
    }

    /// Ends the reading: what was read so far is given, and the end.
    pub fn stop(&mut self) {
        self.end(None);
    }

    fn end(&mut self, error: Option<io::Error>) {
        if let Some(mut file) = self.file.take() {
            let (batches, report) = file.finish();
            self.due.extend(batches.into_iter().map(Event::from).chain([Event::End(End { error, report })]));
        }
    }
}

impl Iterator for FileEvents {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        loop {
            if let Some(event) = self.due.pop_front() {
                return Some(event);
            }
            match self.file.as_mut()?.next_events() {
                Ok(Some(events)) => self.due.extend(events),
                Ok(None) => self.end(None),
                Err(error) => self.end(Some(error)),
            }
        }
    }
}

/// Starts a thread that reads the file to its end, or until `stop`, as [`read_samples`] does.
pub(crate) fn read_file(mut file: FileEvents, stop: CancellationToken) -> io::Result<mpsc::Receiver<Event>> {
    let (events, inbox) = mpsc::channel(WAITING_BATCHES);
    let work = move || {
        loop {
            if stop.is_cancelled() {
                file.stop();
            }
            let Some(event) = file.next() else { return };
            // a receiver that was dropped does not need the end either
            if events.blocking_send(event).is_err() {
                return;
            }
        }
    };
    // ends with the file, with `stop`, or when the inbox is dropped
    thread::Builder::new().name("file-reader".into()).spawn(work)?;
    Ok(inbox)
}
