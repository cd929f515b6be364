//! Captures: opened, decompressed, and their format detected.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::Path,
    sync::{Arc, atomic::AtomicU64},
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    bag::{self, Bag, BagSamples},
    capture_options::CaptureOptions,
    counted_reader::CountedReader,
    csv::{CsvReader, Said},
    detect_format::{Detected, Format, detect_format, is_capture_ending},
    open_error::{OpenError, Problem},
    read_samples::{Event, FileEvents, FileReader, read_file, read_samples},
    recording::{self, Recorded},
    source::ReaderSource,
    stored_file::StoredFile,
    telnet::{Undoubled, doubles_ff},
    timing_sidecar::{BytesReader, Sidecar},
    unpack::{KnownBy, unpacked, unpacked_stored},
};
use vn100_protocol::stream::{CsvReport, MeasuredFrames, ReadOptions};

/// An opened capture, whose format was detected from its content, ready to be read from its first
/// byte.
pub struct Capture {
    /// The format after decompression.
    pub format: Format,
    /// Number of stored bytes that were read so far; grows while the source is read.
    pub stored_bytes_read: Arc<AtomicU64>,
    /// Whether the capture holds numbers that may be of any sensor, and no messages of a VN-100. No
    /// default rate is assumed for such a capture if its times do not show the rate.
    pub holds_values: bool,
    /// What is known of a table before its first row is read, with nothing counted; `None` for any
    /// other capture.
    pub csv: Option<CsvReport>,
    /// The topic of a bag or the group of columns of a table that is read; `None` if there is no
    /// choice.
    pub topic: Option<String>,
    /// The metadata of a recording of this program; `None` for any other capture.
    pub recorded: Option<Recorded>,
    start_reading: Box<dyn FnOnce(ReadOptions) -> io::Result<Reading> + Send>,
}

/// A capture that is read.
enum Reading {
    File(FileEvents),
    /// A read of a stream may wait for bytes indefinitely.
    Stream(ReaderSource, ReadOptions),
}

impl Reading {
    fn of(file: impl FileReader) -> io::Result<Self> {
        Ok(Self::File(FileEvents::new(Box::new(file))))
    }
}

impl Capture {
    /// Opens a file. Content of gzip, zstd, bzip2 and xz is decompressed, independent of its name, and
    /// so is the only capture in a ZIP archive; zeros after gzip data are its end. The file
    /// `NAME.timing` in the same folder, with a row `t_ns,offset` for each read of the port, gives the
    /// bytes their arrival times. If its rows end too early, the capture ends there with an error.
    ///
    /// One topic of a bag, or of the folder of a bag, is read: the one named in `options`, else the
    /// only one of a sensor.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be read, contains nothing of a sensor, or contains several
    /// streams and `options` name none of them.
    pub fn open(path: impl AsRef<Path>, options: &CaptureOptions) -> Result<Self, OpenError> {
        let path = path.as_ref();
        Self::at(path, options).map_err(|problem| problem.at(path))
    }

    fn at(path: &Path, options: &CaptureOptions) -> Result<Self, Problem> {
        let metadata = fs::metadata(path)?;
        if metadata.is_file() {
            bag::check_log(path)?;
            return Self::of_stored(Box::new(File::open(path)?), Sidecar::beside(path)?, options, path);
        }
        let read = Arc::default();
        if metadata.is_dir() {
            return Self::of_bag(Bag::in_folder(path)?, read, options);
        }
        // a pipe can be read only once
        let reader = unpacked(CountedReader { inner: File::open(path)?, read: Arc::clone(&read) })?;
        Self::start(reader, false, read, Sidecar::beside(path)?, options, path)
    }

    /// Opens a file wherever its bytes are, under this name. It has no times beside it, and of a
    /// packed bag there is no place to unpack it to.
    ///
    /// # Errors
    /// As for [`Capture::open`].
    pub fn of_file(file: Box<dyn StoredFile>, name: &str, options: &CaptureOptions) -> Result<Self, OpenError> {
        let path = Path::new(name);
        Self::of_stored(file, None, options, path).map_err(|problem| problem.at(path))
    }

    fn of_stored(
        file: Box<dyn StoredFile>,
        sidecar: Option<Sidecar>,
        options: &CaptureOptions,
        path: &Path,
    ) -> Result<Self, Problem> {
        let (is_file, read) = (file.bytes().is_some(), Arc::new(AtomicU64::new(0)));
        if let Some(form) = bag::form_of(&*file)? {
            return Self::of_bag(Bag::new(form, vec![file]), read, options);
        }
        let counted = |inner| CountedReader { inner, read: Arc::clone(&read) };
        let reader = unpacked_stored(&*file, counted, IN_ARCHIVE)?;
        Self::start(reader, is_file, read, sidecar, options, path)
    }

    /// The streams of a file, by the names that [`topic`](CaptureOptions::topic) takes: the
    /// measured topics of a bag, or the columns of a table with the same rate. A single `None` for
    /// a file with one stream, and for a file that cannot be opened.
    pub fn streams(path: impl AsRef<Path>, options: &CaptureOptions) -> Vec<Option<String>> {
        let path = path.as_ref();
        let names = || match fs::metadata(path).ok()? {
            found if found.is_dir() => topics(&Bag::in_folder(path).ok()?, options),
            found if found.is_file() && bag::check_log(path).is_ok() => {
                stream_names(Box::new(File::open(path).ok()?), path, options)
            }
            // a pipe or a device can be read only once
            _ => None,
        };
        one_or_several(names(), options)
    }

    /// The same of a file wherever its bytes are.
    pub fn streams_of_file(file: Box<dyn StoredFile>, name: &str, options: &CaptureOptions) -> Vec<Option<String>> {
        one_or_several(stream_names(file, Path::new(name), options), options)
    }

    /// Opens any reader: standard input, or bytes in memory. A bag is unpacked to a temporary file
    /// without a name.
    ///
    /// # Errors
    /// As for [`Capture::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, options: &CaptureOptions) -> Result<Self, OpenError> {
        let (path, read) = (Path::new("-"), Arc::new(AtomicU64::new(0)));
        let counted = CountedReader { inner: reader, read: Arc::clone(&read) };
        let started = unpacked(counted).and_then(|reader| Self::start(reader, false, read, None, options, path));
        started.map_err(|problem| problem.at(path))
    }

    /// Whether the capture holds values without times, so that their rate must be given.
    pub fn lacks_times(&self) -> bool {
        self.holds_values && self.csv.as_ref().is_some_and(|csv| csv.times.is_none())
    }

    /// Starts to read. The events are those of [`read_samples`].
    ///
    /// # Errors
    /// If no thread can be started.
    ///
    /// # Panics
    /// If called outside a tokio runtime.
    pub fn read(self, options: ReadOptions, stop: CancellationToken) -> io::Result<mpsc::Receiver<Event>> {
        match (self.start_reading)(options)? {
            Reading::File(events) => read_file(events, stop),
            Reading::Stream(source, options) => Ok(read_samples(source, options, stop)),
        }
    }

    /// The same events, read on this thread as they are asked for.
    ///
    /// # Errors
    /// If the file cannot be read, or the capture is a stream that may wait.
    pub fn events(self, options: ReadOptions) -> io::Result<FileEvents> {
        match (self.start_reading)(options)? {
            Reading::File(events) => Ok(events),
            Reading::Stream(..) => Err(io::ErrorKind::Unsupported.into()),
        }
    }

    fn of_bag(bag: Bag, read: Arc<AtomicU64>, options: &CaptureOptions) -> Result<Self, Problem> {
        let stream = bag::choose(&bag, options, 1)?.pop();
        let mut stream = stream.ok_or_else(|| Problem::new("it has no topic"))?;
        stream.fit(&bag)?;
        // the bytes read of an unpacked bag are not the stored bytes
        let stored_bytes_read = if bag.unpacked_bytes > 0 { read } else { Arc::default() };
        let counted = if bag.unpacked_bytes > 0 { Arc::default() } else { Arc::clone(&stored_bytes_read) };
        let (format, holds_values, topic) = (Format::Bag(bag.form), stream.holds_values(), stream.topic.name.clone());
        let capture = Self::new(format, stored_bytes_read, move |options| {
            Reading::of(BagSamples::open(&bag, stream, options, &counted).map_err(io::Error::other)?)
        });
        Ok(Self { holds_values, topic: Some(topic), ..capture })
    }

    /// A capture of sentences or packets that `start` begins to read.
    fn new(
        format: Format,
        stored_bytes_read: Arc<AtomicU64>,
        start: impl FnOnce(ReadOptions) -> io::Result<Reading> + Send + 'static,
    ) -> Self {
        let start_reading = Box::new(start);
        let (holds_values, csv, topic, recorded) = (false, None, None, None);
        Self { format, stored_bytes_read, holds_values, csv, topic, recorded, start_reading }
    }

    fn start(
        reader: Box<dyn Read + Send>,
        is_file: bool,
        stored_bytes_read: Arc<AtomicU64>,
        sidecar: Option<Sidecar>,
        options: &CaptureOptions,
        path: &Path,
    ) -> Result<Self, Problem> {
        let mut reader = match bag::detect_bag(reader)? {
            bag::Stream::Bag(bag) => return Self::of_bag(bag, stored_bytes_read, options),
            bag::Stream::Other(reader) => reader,
        };
        let file = path.file_name().map(|name| name.to_string_lossy());
        let said = Said { map: options.columns.as_ref(), stream: options.topic.as_deref(), file: file.as_deref() };
        let (head, detected) = detect_format(&mut reader, said)?;
        // how much of a stream is here depends on how it comes: its doubled bytes are damage that is counted
        let is_raw_file = is_file && sidecar.is_none() && matches!(detected, Detected::Bytes(Format::Raw, _));
        let is_of_telnet = is_raw_file && doubles_ff(&head.bytes);
        let whole = head.chain(reader);
        let reader: Box<dyn Read + Send> = if is_of_telnet { Box::new(Undoubled::new(whole)) } else { Box::new(whole) };
        let capture = match detected {
            Detected::Mcap => {
                let (recorded, samples) = recording::open(reader, options, &stored_bytes_read)?;
                let start = |options| Reading::of(samples.with_options(options));
                Self { recorded: Some(recorded), ..Self::new(Format::Mcap, stored_bytes_read, start) }
            }
            Detected::Csv(plan) => {
                let holds_values = plan.holds_values();
                let (csv, topic) = (Some(plan.report.clone()), options.topic.clone().filter(|_| holds_values));
                let start = |options| Reading::of(CsvReader::new(*plan, reader, options));
                Self { holds_values, csv, topic, ..Self::new(Format::Csv, stored_bytes_read, start) }
            }
            Detected::Bytes(format, measured) => {
                let chosen = move |options: ReadOptions| match options.measured {
                    MeasuredFrames::First => ReadOptions { measured, ..options },
                    _ => options,
                };
                if sidecar.is_some() || is_file {
                    let start = move |options| Reading::of(BytesReader::new(reader, sidecar, chosen(options)));
                    Self::new(format, stored_bytes_read, start)
                } else {
                    let source = ReaderSource::spawn(reader, None)?;
                    Self::new(format, stored_bytes_read, move |options| Ok(Reading::Stream(source, chosen(options))))
                }
            }
        };
        match (&options.topic, &options.columns) {
            (_, Some(_)) if capture.format != Format::Csv => {
                let format = capture.format.code();
                Err(Problem::new(format!("it is of the format {format} and has no columns; name none")))
            }
            (Some(asked), _) if capture.topic.is_none() => {
                Err(Problem::new(format!("it has one stream and no {asked:?}; name none")))
            }
            _ => Ok(capture),
        }
    }
}

fn one_or_several(names: Option<Vec<String>>, options: &CaptureOptions) -> Vec<Option<String>> {
    match names {
        Some(names) if names.len() > 1 => names.into_iter().map(Some).collect(),
        _ => vec![options.topic.clone()],
    }
}

fn topics(bag: &Bag, options: &CaptureOptions) -> Option<Vec<String>> {
    let streams = bag::choose(bag, options, usize::MAX).ok()?;
    Some(streams.into_iter().map(|stream| stream.topic.name).collect())
}

/// The names of the topics of a bag, or of the groups of columns of a table.
fn stream_names(file: Box<dyn StoredFile>, path: &Path, options: &CaptureOptions) -> Option<Vec<String>> {
    if let Some(form) = bag::form_of(&*file).ok()? {
        return topics(&Bag::new(form, vec![file]), options);
    }
    if options.topic.is_some() {
        return None;
    }
    let mut reader = unpacked_stored(&*file, |file| file, IN_ARCHIVE).ok()?;
    let name = path.file_name().map(|name| name.to_string_lossy());
    let said = Said { map: options.columns.as_ref(), stream: None, file: name.as_deref() };
    match detect_format(&mut reader, said).ok()? {
        (_, Detected::Csv(plan)) => Some(plan.streams),
        _ => None,
    }
}

/// How a capture is known among the files of an archive. Of two more endings there are many files
/// that are none, so that in folders they do not count.
const IN_ARCHIVE: KnownBy = KnownBy {
    ending: |ending| is_capture_ending(ending) || ["asc", "dat"].iter().any(|also| ending.eq_ignore_ascii_case(also)),
    beginning: is_capture,
};

/// Whether a file of this name begins like a capture.
fn is_capture(mut bytes: &mut dyn Read, name: &str) -> bool {
    detect_format(&mut bytes, Said { file: Some(name), ..Said::default() }).is_ok()
}
