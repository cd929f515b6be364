//! Captures: opened, decompressed, and their format detected.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicU64},
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    bag::{self, Bag, BagError, BagSamples},
    capture_options::CaptureOptions,
    counted_reader::CountedReader,
    csv::{CsvError, CsvReader, Said},
    detect_format::{Detected, Format, detect_format},
    read_samples::{Event, FileEvents, FileReader, read_file, read_samples},
    recording::{LaterParts, Recorded, RecordingError, RecordingReader, RecordingSamples},
    source::ReaderSource,
    stored_file::StoredFile,
    telnet::Undoubled,
    timing_sidecar::{BytesReader, Sidecar},
    unpack::{ArchiveError, UnpackError, unpacked, unpacked_file, unpacked_stored},
};
use vn100_protocol::stream::{MeasuredFrames, ReadOptions};

/// An opened capture, whose format was detected from its content, ready to be read from its first
/// byte.
pub struct Capture {
    /// The format after decompression.
    pub format: Format,
    /// Size of the file in bytes, as stored; `None` for a stream.
    pub stored_bytes: Option<u64>,
    /// Number of stored bytes that were read so far; grows while the source is read.
    pub stored_bytes_read: Arc<AtomicU64>,
    /// Whether the capture holds numbers that may be of any sensor, and no messages of a VN-100. No
    /// default rate is assumed for such a capture if its times do not show the rate.
    pub holds_values: bool,
    /// Whether the capture holds values without times, so that their rate must be given.
    pub lacks_times: bool,
    /// The topic of a bag or the group of columns of a table that is read; `None` if there is no
    /// choice.
    pub topic: Option<String>,
    /// The metadata of a recording of this program; `None` for any other capture.
    pub recorded: Option<Recorded>,
    start_reading: StartReading,
}

type StartReading = Box<dyn FnOnce(ReadOptions) -> io::Result<Reading> + Send>;

/// A capture that is ready to be read.
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
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let no_bag = |problem| OpenError::of_bag(path, problem);
        let metadata = fs::metadata(path).map_err(failed)?;
        let stored_bytes = metadata.is_file().then_some(metadata.len());
        if let Some(bag) = Bag::at(path).map_err(no_bag)? {
            let stored_bytes = stored_bytes.or_else(|| bag.stored_bytes());
            return Self::of_bag(bag, stored_bytes, Arc::default(), options).map_err(no_bag);
        }
        let file = File::open(path).map_err(failed)?;
        let sidecar = Sidecar::beside(path).map_err(failed)?;
        let is_file = stored_bytes.is_some();
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = |inner| CountedReader { inner, read: Arc::clone(&stored_bytes_read) };
        let reader = unpacked_file(file, counted, &is_capture).map_err(|error| OpenError::packed(path, error))?;
        Self::start(reader, stored_bytes, stored_bytes_read, sidecar, options, path, is_file)
    }

    /// Opens a file wherever its bytes are, under this name. One without a folder has no times
    /// beside it. Of a packed bag there is no place to unpack it to.
    ///
    /// # Errors
    /// As for [`Capture::open`].
    pub fn of_file(file: Box<dyn StoredFile>, name: &str, options: &CaptureOptions) -> Result<Self, OpenError> {
        let path = Path::new(name);
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let stored_bytes = file.bytes();
        if let Some(form) = bag::form_of(&*file).map_err(failed)? {
            let bag = Bag::new(form, vec![file]);
            return Self::of_bag(bag, stored_bytes, Arc::default(), options)
                .map_err(|problem| OpenError::of_bag(path, problem));
        }
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = |inner| CountedReader { inner, read: Arc::clone(&stored_bytes_read) };
        let reader = unpacked_stored(&*file, counted, &is_capture).map_err(|error| OpenError::packed(path, error))?;
        Self::start(reader, stored_bytes, stored_bytes_read, None, options, path, true)
    }

    /// The streams of a file, by the names that [`topic`](CaptureOptions::topic) takes: the
    /// measured topics of a bag, or the columns of a table with the same rate. A single `None` for
    /// a file with one stream, and for a file that cannot be opened.
    #[must_use]
    pub fn streams(path: impl AsRef<Path>, options: &CaptureOptions) -> Vec<Option<String>> {
        let path = path.as_ref();
        let names = || match Bag::at(path).ok()? {
            Some(bag) => topics(&bag, options),
            // a pipe or a device can be read only once
            None if !fs::metadata(path).ok()?.is_file() => None,
            None => groups_of_columns(&File::open(path).ok()?, path, options),
        };
        one_or_several(names().unwrap_or_default(), options)
    }

    /// The same of a file wherever its bytes are.
    #[must_use]
    pub fn streams_of_file(file: Box<dyn StoredFile>, name: &str, options: &CaptureOptions) -> Vec<Option<String>> {
        let names = match bag::form_of(&*file) {
            Ok(Some(form)) => topics(&Bag::new(form, vec![file]), options),
            _ => groups_of_columns(&*file, Path::new(name), options),
        };
        one_or_several(names.unwrap_or_default(), options)
    }

    /// Opens any reader: standard input, or bytes in memory. A bag is unpacked to a temporary file
    /// without a name.
    ///
    /// # Errors
    /// As for [`Capture::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, options: &CaptureOptions) -> Result<Self, OpenError> {
        let path = Path::new("-");
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = CountedReader { inner: reader, read: Arc::clone(&stored_bytes_read) };
        let reader = unpacked(counted).map_err(|error| OpenError::packed(path, error))?;
        Self::start(reader, None, stored_bytes_read, None, options, path, false)
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

    fn of_bag(
        bag: Bag,
        stored_bytes: Option<u64>,
        read: Arc<AtomicU64>,
        options: &CaptureOptions,
    ) -> Result<Self, BagError> {
        let mut stream = bag::choose_one(&bag, options)?;
        stream.fit(&bag)?;
        // the bytes read of an unpacked bag are not the stored bytes
        let stored_bytes_read = if bag.unpacked_bytes > 0 { read } else { Arc::default() };
        let counted = if bag.unpacked_bytes > 0 { Arc::default() } else { Arc::clone(&stored_bytes_read) };
        Ok(Self {
            format: Format::Bag(bag.form),
            stored_bytes,
            stored_bytes_read,
            holds_values: stream.holds_values(),
            lacks_times: false,
            recorded: None,
            topic: Some(stream.topic.name.clone()),
            start_reading: Box::new(move |options| {
                Reading::of(BagSamples::open(&bag, stream, options, &counted).map_err(io::Error::other)?)
            }),
        })
    }

    fn start(
        reader: Box<dyn Read + Send>,
        stored_bytes: Option<u64>,
        stored_bytes_read: Arc<AtomicU64>,
        sidecar: Option<Sidecar>,
        options: &CaptureOptions,
        path: &Path,
        is_file: bool,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let no_bag = |problem| OpenError::of_bag(path, problem);
        let mut reader = match bag::detect_bag(reader).map_err(no_bag)? {
            bag::Stream::Bag(bag) => {
                return Self::of_bag(bag, stored_bytes, stored_bytes_read, options).map_err(no_bag);
            }
            bag::Stream::Other(reader) => reader,
        };
        let file = path.file_name().map(|name| name.to_string_lossy());
        let said = Said { map: options.columns.as_ref(), stream: options.topic.as_deref(), file: file.as_deref() };
        let (head, detected) = detect_format(&mut reader, said).map_err(failed)?;
        let is_of_telnet =
            matches!(detected, Detected::Bytes(Format::Raw, _)) && sidecar.is_none() && head.doubles_ff();
        let whole = head.chain(reader);
        let reader: Box<dyn Read + Send> = if is_of_telnet { Box::new(Undoubled::new(whole)) } else { Box::new(whole) };
        let mut recorded = None;
        let (holds_values, lacks_times) = match &detected {
            Detected::Csv(plan) => (plan.holds_values(), plan.lacks_times()),
            _ => (false, false),
        };
        let (format, start_reading): (_, StartReading) = match detected {
            Detected::Csv(plan) => {
                (Format::Csv, Box::new(|options| Reading::of(CsvReader::new(*plan, reader, options))))
            }
            Detected::Bytes(format, measured) => {
                let chosen = move |options: ReadOptions| match options.measured {
                    MeasuredFrames::First => ReadOptions { measured, ..options },
                    _ => options,
                };
                let start: StartReading = if sidecar.is_some() || is_file {
                    Box::new(move |options| Reading::of(BytesReader::new(reader, sidecar, chosen(options))))
                } else {
                    let source = ReaderSource::spawn(reader, None).map_err(failed)?;
                    Box::new(move |options| Ok(Reading::Stream(source, chosen(options))))
                };
                (format, start)
            }
            Detected::Mcap => {
                let recording = RecordingReader::open(reader).map_err(|problem| match problem {
                    RecordingError::Io(source) => failed(source),
                    problem => OpenError::Recording { path: path.to_owned(), problem },
                })?;
                let later = LaterParts::new(&options.later_parts, &stored_bytes_read);
                recorded = Some(match options.later_parts.is_empty() {
                    true => recording.recorded().clone(),
                    false => later.joined(recording.recorded()),
                });
                let start: StartReading =
                    Box::new(|options| Reading::of(RecordingSamples::new(recording, later, options)));
                (Format::Mcap, start)
            }
            Detected::UnusableCsv(problem) => return Err(OpenError::Csv { path: path.to_owned(), problem }),
            Detected::Unknown(found) => return Err(OpenError::NotACapture { path: path.to_owned(), found }),
        };
        Ok(Self {
            format,
            stored_bytes,
            stored_bytes_read,
            holds_values,
            lacks_times,
            recorded,
            topic: options.topic.clone().filter(|_| format == Format::Csv && holds_values),
            start_reading,
        })
    }
}

fn one_or_several(names: Vec<String>, options: &CaptureOptions) -> Vec<Option<String>> {
    if names.len() > 1 { names.into_iter().map(Some).collect() } else { vec![options.topic.clone()] }
}

fn topics(bag: &Bag, options: &CaptureOptions) -> Option<Vec<String>> {
    let streams = bag::choose(bag, options).ok()?;
    Some(streams.into_iter().map(|stream| stream.topic.name).collect())
}

fn groups_of_columns(file: &dyn StoredFile, path: &Path, options: &CaptureOptions) -> Option<Vec<String>> {
    if options.topic.is_some() {
        return None;
    }
    let mut reader = unpacked_stored(file, |file| file, &is_capture).ok()?;
    let name = path.file_name().map(|name| name.to_string_lossy());
    let said = Said { map: options.columns.as_ref(), stream: None, file: name.as_deref() };
    match detect_format(&mut reader, said).ok()? {
        (_, Detected::Csv(plan)) => Some(plan.streams),
        _ => None,
    }
}

/// Whether a file of this name begins like a capture.
fn is_capture(mut bytes: &mut dyn Read, name: &str) -> bool {
    let detected = detect_format(&mut bytes, Said { file: Some(name), ..Said::default() });
    detected.is_ok_and(|(_, detected)| !matches!(detected, Detected::Unknown(_) | Detected::UnusableCsv(_)))
}

/// The reason why a capture could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The operating system, or the decompressor, reports an error.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The error.
        source: io::Error,
    },
    /// The columns of a CSV file cannot be used.
    #[error("{}: {problem}", path.display())]
    Csv {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The reason.
        problem: CsvError,
    },
    /// The bag cannot be read, or none or several of its topics qualify.
    #[error("{}: {problem}", path.display())]
    Bag {
        /// The file or folder, `-` for standard input.
        path: PathBuf,
        /// The reason, with the topics of the bag.
        problem: Box<BagError>,
    },
    /// The MCAP file cannot be read as a recording.
    #[error("{} is not a recording this program reads: {problem}", path.display())]
    Recording {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The reason.
        problem: RecordingError,
    },
    /// The ZIP archive cannot be read.
    #[error("{}: {problem}", path.display())]
    Archive {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The reason.
        problem: ArchiveError,
    },
    /// The file can be read and is no capture.
    #[error(
        "{} is not a capture this program reads: searched for VectorNav sentences ($VNYMR,… or $VNIMU,… with a checksum), 0xFA \
         binary packets, CSV columns of known names and MCAP recordings, also inside gzip, zstd, bzip2, xz and ZIP; found {found}",
        path.display()
    )]
    NotACapture {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The kind of content, as far as it is recognised.
        found: String,
    },
}

impl OpenError {
    fn packed(path: &Path, error: UnpackError) -> Self {
        let path = path.to_owned();
        match error {
            UnpackError::Io(source) => Self::Io { path, source },
            UnpackError::Archive(problem) => Self::Archive { path, problem },
        }
    }

    fn of_bag(path: &Path, problem: BagError) -> Self {
        match problem {
            BagError::Io(source) => Self::Io { path: path.to_owned(), source },
            problem => Self::Bag { path: path.to_owned(), problem: problem.into() },
        }
    }
}
