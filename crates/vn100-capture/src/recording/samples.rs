//! The samples of a recording, or of its parts in sequence.

use std::{
    collections::VecDeque,
    fs::File,
    io::{self, Read},
    mem,
    path::{Path, PathBuf},
    sync::{Arc, OnceLock, atomic::AtomicU64},
};

use vn100_protocol::stream::{
    Batch, Chunk, FileReport, LinkEvent, LinkEventKind, ReadOptions, SampleReader, StreamInput,
};

use super::{
    part::RecordingPart,
    reader::{Entry, IN_ARCHIVE, Recorded, RecordingEnd, RecordingError, RecordingReader},
};
use crate::{
    capture_options::CaptureOptions,
    counted_reader::CountedReader,
    open_error::Problem,
    read_samples::{Event, FileReader},
    source,
    unpack::unpacked_stored,
};

type Stored = Box<dyn Read + Send>;

/// Opens a recording, with the parts after it that the options name.
pub(crate) fn open(
    reader: Stored,
    options: &CaptureOptions,
    stored_bytes_read: &Arc<AtomicU64>,
) -> Result<(Recorded, RecordingSamples), Problem> {
    let recording = RecordingReader::open(reader).map_err(|problem| match problem {
        RecordingError::Io(error) => Problem::Io(error),
        problem => Problem::NotACapture(format!("a recording this program reads: {problem}")),
    })?;
    let later = LaterParts::new(&options.later_parts, stored_bytes_read);
    let recorded = match options.later_parts.is_empty() {
        true => recording.recorded().clone(),
        false => later.joined(recording.recorded()),
    };
    let samples = SampleReader::new(ReadOptions::default());
    Ok((recorded, RecordingSamples { recording, later, samples, unsent: 0, up: None, ended_ns: None }))
}

/// The parts after the current one.
struct LaterParts {
    paths: VecDeque<PathBuf>,
    stored_bytes_read: Arc<AtomicU64>,
    /// Whether none was missing or cut so far.
    are_whole: bool,
    /// The end of all parts, set after the last part.
    end: Arc<OnceLock<RecordingEnd>>,
}

impl LaterParts {
    /// The parts in these files, in order; the bytes read from them are counted.
    fn new(paths: &[PathBuf], stored_bytes_read: &Arc<AtomicU64>) -> Self {
        let paths = paths.iter().cloned().collect();
        Self { paths, stored_bytes_read: Arc::clone(stored_bytes_read), are_whole: true, end: Arc::default() }
    }

    /// The metadata of the recording that `first` and these parts form.
    fn joined(&self, first: &Recorded) -> Recorded {
        let resumed = |path: &PathBuf| RecordingPart::of(path).is_some_and(|part| part.resumed);
        let resumed = first.resumed || self.paths.iter().any(resumed);
        Recorded { resumed, part: None, end: Arc::clone(&self.end), ..first.clone() }
    }

    fn open(&self, path: &Path) -> io::Result<RecordingReader<Stored>> {
        let failed = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        let counted = |inner| CountedReader { inner, read: Arc::clone(&self.stored_bytes_read) };
        let file = File::open(path).map_err(failed)?;
        let reader = unpacked_stored(&file, counted, IN_ARCHIVE).map_err(|problem| match problem {
            Problem::Io(error) => failed(error),
            problem => failed(io::Error::other(problem)),
        })?;
        RecordingReader::open(reader).map_err(|problem| failed(io::Error::other(problem)))
    }
}

/// Reads a recording, with one batch for many reads, because a recorded read may have only a few bytes.
pub(crate) struct RecordingSamples {
    recording: RecordingReader<Stored>,
    later: LaterParts,
    samples: SampleReader,
    /// Bytes since the last batch.
    unsent: usize,
    /// The latest connection.
    up: Option<LinkEventKind>,
    /// The time of the last input in the parts read so far.
    ended_ns: Option<i64>,
}

impl RecordingSamples {
    pub(crate) fn with_options(self, options: ReadOptions) -> Self {
        Self { samples: SampleReader::new(options), ..self }
    }

    /// Continues with the next part; `None` after the last. If a part, or the end of one, is
    /// missing, the link counts as lost meanwhile.
    fn next_part(&mut self) -> io::Result<Option<Vec<Event>>> {
        let end = self.recording.recorded().end.get().cloned();
        self.ended_ns = end.as_ref().and_then(|end| end.ended_ns).or(self.ended_ns);
        // a part that was cut at once has no time
        let end = end.map(|end| RecordingEnd { ended_ns: self.ended_ns, ..end });
        let Some(path) = self.later.paths.pop_front() else {
            let whole = |end: RecordingEnd| RecordingEnd { complete: end.complete && self.later.are_whole, ..end };
            end.map(whole).into_iter().for_each(|end| _ = self.later.end.set(end));
            return Ok(None);
        };
        let next = self.later.open(&path)?;
        let last = mem::replace(&mut self.recording, next);
        let number = |recorded: &Recorded| recorded.part.as_ref().map_or(0, |part| part.number);
        let (last_number, now) = (number(last.recorded()), self.recording.recorded());
        let is_cut = end.as_ref().is_some_and(|end| !end.complete);
        let cause = if number(now) > last_number + 1 {
            format!("part {} of the recording is missing", last_number + 1)
        } else if is_cut && !now.resumed {
            format!("part {last_number} of the recording is cut")
        } else {
            // the break is in the part that was begun after it
            return Ok(Some(Vec::new()));
        };
        self.later.are_whole = false;
        let Some(at_ns) = end.and_then(|end| end.ended_ns) else { return Ok(Some(Vec::new())) };
        let lost = LinkEvent { at_ns, kind: LinkEventKind::Down { cause } };
        let found = self.up.clone().zip(now.started_ns).filter(|_| !now.resumed);
        let found = found.map(|(kind, at_ns)| LinkEvent { at_ns, kind });
        self.unsent = 0;
        let mut events = Vec::new();
        for event in [Some(lost), found].into_iter().flatten() {
            events.extend(Event::from_input(&mut self.samples, StreamInput::Link(event)));
        }
        Ok(Some(events))
    }
}

impl FileReader for RecordingSamples {
    fn next_events(&mut self) -> io::Result<Option<Vec<Event>>> {
        let Self { recording, samples, unsent, up, .. } = self;
        let due: Vec<Event> = match recording.next_entry()? {
            None => return self.next_part(),
            Some(Entry::Metadata(_)) => return Ok(Some(Vec::new())),
            Some(Entry::Input(StreamInput::Chunk(Chunk { bytes, at_ns }))) => {
                samples.push(&bytes, at_ns);
                *unsent += bytes.len();
                if *unsent < source::READ_BYTES {
                    return Ok(Some(Vec::new()));
                }
                samples.take_batches().into_iter().map(Event::from).collect()
            }
            Some(Entry::Input(StreamInput::Link(event))) => {
                if let kind @ LinkEventKind::Up { .. } = &event.kind {
                    *up = Some(kind.clone());
                }
                Event::from_input(samples, StreamInput::Link(event)).collect()
            }
        };
        *unsent = 0;
        Ok(Some(due))
    }

    fn finish(&mut self) -> (Vec<Batch>, Option<FileReport>) {
        (self.samples.finish(), None)
    }
}
