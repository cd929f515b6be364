//! Recorded captures: opened, decompressed, detected.

use std::{
    fs::File,
    io::{self, Cursor, Read},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    csv::{ColumnMap, CsvError, CsvPlan, CsvReader},
    detect_format::{Detected, Format, detect_format},
    event::Event,
    gunzip::Gunzip,
    read_samples::{read_file, read_samples},
    recording::{Recorded, RecordingError, RecordingReader, Replay},
    source::ReaderSource,
    timing_sidecar::{Sidecar, TimedReader},
};
use vn100_protocol::stream::ReadOptions;

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];
const ZSTD_MAGIC: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// An opened capture, detected by its content and ready to be read from its first byte.
pub struct Capture {
    /// What it is.
    pub format: Format,
    /// Size of the file in bytes, as stored; `None` for a stream.
    pub stored_bytes: Option<u64>,
    /// How many stored bytes have been read so far; grows while the source is read.
    pub stored_bytes_read: Arc<AtomicU64>,
    /// What it says of itself, where it is a recording of this program.
    pub recorded: Option<Recorded>,
    input: StreamInput,
}

enum StreamInput {
    Bytes(ReaderSource),
    TimedBytes(Box<dyn Read + Send>, Sidecar),
    Rows(CsvPlan, Box<dyn Read + Send>),
    Recording(Box<RecordingReader<Box<dyn Read + Send>>>),
}

impl Capture {
    /// Opens a file. Gzip and zstd content is decompressed, whatever the name says; zeros behind
    /// gzip data are its end. A file `NAME.timing` beside it, with a row `t_ns,offset` for each
    /// read of the port, gives the bytes their arrival times. Where its rows end too early, so does
    /// the capture, with an error.
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
            return Err(OpenError::Directory { path: path.to_owned() });
        }
        let stored_bytes = metadata.is_file().then_some(metadata.len());
        let sidecar = Sidecar::beside(path).map_err(failed)?;
        Self::start(file, stored_bytes, sidecar, columns, path)
    }

    /// Takes any reader: standard input, or bytes in memory.
    ///
    /// # Errors
    /// As [`Capture::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, columns: Option<&ColumnMap>) -> Result<Self, OpenError> {
        Self::start(reader, None, None, columns, Path::new("-"))
    }

    /// Starts to read, as [`read_samples`] does from any source.
    ///
    /// # Errors
    /// When no thread can be started.
    ///
    /// # Panics
    /// Outside a tokio runtime.
    pub fn read(self, options: ReadOptions, stop: CancellationToken) -> io::Result<mpsc::Receiver<Event>> {
        match self.input {
            StreamInput::Bytes(source) => Ok(read_samples(source, options, stop)),
            StreamInput::TimedBytes(reader, sidecar) => read_file(TimedReader::new(reader, sidecar, options), stop),
            StreamInput::Rows(plan, reader) => read_file(CsvReader::new(plan, reader, options), stop),
            StreamInput::Recording(recording) => read_file(Replay::new(*recording, options), stop),
        }
    }

    fn start(
        reader: impl Read + Send + 'static,
        stored_bytes: Option<u64>,
        sidecar: Option<Sidecar>,
        columns: Option<&ColumnMap>,
        path: &Path,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = CountedReader { inner: reader, read: Arc::clone(&stored_bytes_read) };
        let mut reader = decompressed(counted).map_err(failed)?;
        let (head, detected) = detect_format(&mut reader, columns).map_err(failed)?;
        let reader: Box<dyn Read + Send> = Box::new(head.chain(reader));
        let mut recorded = None;
        let (format, input) = match detected {
            Detected::Csv(plan) => (Format::Csv, StreamInput::Rows(plan, reader)),
            Detected::Text => (Format::Text, bytes(reader, sidecar).map_err(failed)?),
            Detected::Raw => (Format::Raw, bytes(reader, sidecar).map_err(failed)?),
            Detected::Mcap => {
                let recording = RecordingReader::open(reader).map_err(|problem| match problem {
                    RecordingError::Io(source) => failed(source),
                    problem => OpenError::Recording { path: path.to_owned(), problem },
                })?;
                recorded = Some(recording.recorded().clone());
                (Format::Mcap, StreamInput::Recording(Box::new(recording)))
            }
            Detected::UnusableCsv(problem) => return Err(OpenError::Csv { path: path.to_owned(), problem }),
            Detected::Unknown(found) => return Err(OpenError::NotACapture { path: path.to_owned(), found }),
        };
        Ok(Self { format, stored_bytes, stored_bytes_read, recorded, input })
    }
}

fn bytes(reader: Box<dyn Read + Send>, sidecar: Option<Sidecar>) -> io::Result<StreamInput> {
    match sidecar {
        Some(sidecar) => Ok(StreamInput::TimedBytes(reader, sidecar)),
        None => ReaderSource::spawn(reader).map(StreamInput::Bytes),
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
        /// What it said.
        source: io::Error,
    },
    /// A folder was named.
    #[error("{} is a folder: name the captures in it", path.display())]
    Directory {
        /// The folder.
        path: PathBuf,
    },
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
    /// Readable, but not a capture of a VN-100.
    #[error(
        "{} is not a capture this program reads: looked for VectorNav sentences ($VNYMR,… or $VNIMU,… with a checksum), 0xFA \
         binary packets, CSV columns of known names and MCAP recordings, also inside gzip and zstd; found {found}",
        path.display()
    )]
    NotACapture {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// What stands there instead.
        found: String,
    },
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

fn decompressed(mut reader: impl Read + Send + 'static) -> io::Result<Box<dyn Read + Send>> {
    let mut magic = Vec::new();
    reader.by_ref().take(ZSTD_MAGIC.len() as u64).read_to_end(&mut magic)?;
    let (gzip, zstd) = (magic.starts_with(GZIP_MAGIC), magic.starts_with(ZSTD_MAGIC));
    let whole = Cursor::new(magic).chain(reader);
    Ok(if gzip {
        Box::new(Gunzip::new(whole))
    } else if zstd {
        Box::new(zstd::Decoder::new(whole)?)
    } else {
        Box::new(whole)
    })
}
