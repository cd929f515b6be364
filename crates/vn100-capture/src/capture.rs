//! Recorded captures: opened, decompressed, detected.

use std::{
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    csv::{ColumnMap, CsvError, CsvReader},
    detect_format::{Detected, Format, detect_format},
    read_samples::{Event, read_file, read_samples},
    recording::{Recorded, RecordingError, RecordingReader, RecordingSamples},
    source::ReaderSource,
    timing_sidecar::{Sidecar, TimedReader},
    unpack::{ArchiveError, UnpackError, unpacked, unpacked_file},
};
use vn100_protocol::stream::ReadOptions;

/// An opened capture, detected by its content and ready to be read from its first byte.
pub struct Capture {
    /// What it is.
    pub format: Format,
    /// Size of the file in bytes, as stored; `None` for a stream.
    pub stored_bytes: Option<u64>,
    /// How many stored bytes have been read so far; grows while the source is read.
    pub stored_bytes_read: Arc<AtomicU64>,
    /// Whether it holds numbers that may be of any sensor, and no messages of a VN-100: then no
    /// default stands in for a rate that its times do not show.
    pub holds_values: bool,
    /// Whether it holds values without times: then its rate must be given.
    pub lacks_times: bool,
    /// Its metadata, where it is a recording of this program.
    pub recorded: Option<Recorded>,
    start_reading: StartReading,
}

type StartReading = Box<dyn FnOnce(ReadOptions, CancellationToken) -> io::Result<mpsc::Receiver<Event>> + Send>;

impl Capture {
    /// Opens a file. Content of gzip, zstd, bzip2 and xz is decompressed, whatever the name says,
    /// and so is the one capture in a ZIP archive; zeros behind gzip data are its end. A file
    /// `NAME.timing` beside it, with a row `t_ns,offset` for each read of the port, gives the bytes
    /// their arrival times. Where its rows end too early, so does the capture, with an error.
    ///
    /// # Errors
    /// [`OpenError`] when the file cannot be read, or when it is text or an MCAP file that holds
    /// nothing of a VN-100.
    pub fn open(path: impl AsRef<Path>, columns: Option<&ColumnMap>) -> Result<Self, OpenError> {
        let path = path.as_ref();
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        let metadata = file.metadata().map_err(failed)?;
        if metadata.is_dir() {
            return Err(OpenError::Directory(path.to_owned()));
        }
        let stored_bytes = metadata.is_file().then_some(metadata.len());
        let sidecar = Sidecar::beside(path).map_err(failed)?;
        let again = stored_bytes.is_some().then(|| path.to_owned());
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = |inner| CountedReader { inner, read: Arc::clone(&stored_bytes_read) };
        let reader = unpacked_file(file, counted).map_err(|error| OpenError::packed(path, error))?;
        Self::start(reader, stored_bytes, stored_bytes_read, sidecar, columns, path, again)
    }

    /// Takes any reader: standard input, or bytes in memory.
    ///
    /// # Errors
    /// As [`Capture::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, columns: Option<&ColumnMap>) -> Result<Self, OpenError> {
        let path = Path::new("-");
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = CountedReader { inner: reader, read: Arc::clone(&stored_bytes_read) };
        let reader = unpacked(counted).map_err(|error| OpenError::packed(path, error))?;
        Self::start(reader, None, stored_bytes_read, None, columns, path, None)
    }

    /// Starts to read, as [`read_samples`] does from any source.
    ///
    /// # Errors
    /// When no thread can be started.
    ///
    /// # Panics
    /// Outside a tokio runtime.
    pub fn read(self, options: ReadOptions, stop: CancellationToken) -> io::Result<mpsc::Receiver<Event>> {
        (self.start_reading)(options, stop)
    }

    fn start(
        mut reader: Box<dyn Read + Send>,
        stored_bytes: Option<u64>,
        stored_bytes_read: Arc<AtomicU64>,
        sidecar: Option<Sidecar>,
        columns: Option<&ColumnMap>,
        path: &Path,
        again: Option<PathBuf>,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let (head, detected) = detect_format(&mut reader, columns).map_err(failed)?;
        let reader: Box<dyn Read + Send> = Box::new(head.chain(reader));
        let mut recorded = None;
        let (holds_values, lacks_times) = match &detected {
            Detected::Csv(plan) => (plan.holds_values(), plan.lacks_times()),
            _ => (false, false),
        };
        let (format, start_reading): (_, StartReading) = match detected {
            Detected::Csv(plan) => {
                let again = again.map(|path| unpacked_file(File::open(path)?, |file| file)).transpose();
                let again = again.map_err(|error| OpenError::packed(path, error))?;
                (Format::Csv, Box::new(|options, stop| read_file(CsvReader::new(plan, reader, again, options), stop)))
            }
            Detected::Bytes(format) => (
                format,
                match sidecar {
                    Some(sidecar) => {
                        Box::new(|options, stop| read_file(TimedReader::new(reader, sidecar, options), stop))
                    }
                    None => {
                        let source = ReaderSource::spawn(reader, None).map_err(failed)?;
                        Box::new(|options, stop| Ok(read_samples(source, options, stop)))
                    }
                },
            ),
            Detected::Mcap => {
                let recording = RecordingReader::open(reader).map_err(|problem| match problem {
                    RecordingError::Io(source) => failed(source),
                    problem => OpenError::Recording { path: path.to_owned(), problem },
                })?;
                recorded = Some(recording.recorded().clone());
                (Format::Mcap, Box::new(|options, stop| read_file(RecordingSamples::new(recording, options), stop)))
            }
            Detected::UnusableCsv(problem) => return Err(OpenError::Csv { path: path.to_owned(), problem }),
            Detected::Unknown(found) => return Err(OpenError::NotACapture { path: path.to_owned(), found }),
        };
        Ok(Self { format, stored_bytes, stored_bytes_read, holds_values, lacks_times, recorded, start_reading })
    }
}

/// Why a capture could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The operating system, or the decompressor, refused.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// Its error.
        source: io::Error,
    },
    /// A folder was named.
    #[error("{} is a folder: name the captures in it", .0.display())]
    Directory(PathBuf),
    /// A CSV file whose columns cannot be used.
    #[error("{}: {problem}", path.display())]
    Csv {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// What is wrong with its columns.
        problem: CsvError,
    },
    /// An MCAP file that is not read.
    #[error("{} is not a recording this program reads: {problem}", path.display())]
    Recording {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// What it is instead.
        problem: RecordingError,
    },
    /// A ZIP archive that is not read.
    #[error("{}: {problem}", path.display())]
    Archive {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// Why.
        problem: ArchiveError,
    },
    /// Readable, but not a capture of a VN-100.
    #[error(
        "{} is not a capture this program reads: looked for VectorNav sentences ($VNYMR,… or $VNIMU,… with a checksum), 0xFA \
         binary packets, CSV columns of known names and MCAP recordings, also inside gzip, zstd, bzip2, xz and ZIP; found {found}",
        path.display()
    )]
    NotACapture {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The content instead.
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
}

/// Counts the bytes that pass, for a progress display on another thread.
struct CountedReader<R> {
    inner: R,
    read: Arc<AtomicU64>,
}

impl<R: Read> Read for CountedReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.read.fetch_add(n as u64, Ordering::Relaxed);
        Ok(n)
    }
}
