//! Recorded captures: opened, decompressed, detected.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Cursor, Read},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use flate2::bufread::GzDecoder;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use crate::{
    csv::{ColumnMap, CsvError, CsvReader},
    detect_format::{Detected, Format, detect_format},
    read_samples::{Event, read_file, read_samples},
    recording::{Recorded, RecordingError, RecordingReader, RecordingSamples},
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
            return Err(OpenError::Directory(path.to_owned()));
        }
        let stored_bytes = metadata.is_file().then_some(metadata.len());
        let sidecar = Sidecar::beside(path).map_err(failed)?;
        let again = stored_bytes.is_some().then(|| path.to_owned());
        Self::start(file, stored_bytes, sidecar, columns, path, again)
    }

    /// Takes any reader: standard input, or bytes in memory.
    ///
    /// # Errors
    /// As [`Capture::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, columns: Option<&ColumnMap>) -> Result<Self, OpenError> {
        Self::start(reader, None, None, columns, Path::new("-"), None)
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
        reader: impl Read + Send + 'static,
        stored_bytes: Option<u64>,
        sidecar: Option<Sidecar>,
        columns: Option<&ColumnMap>,
        path: &Path,
        again: Option<PathBuf>,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Io { path: path.to_owned(), source };
        let stored_bytes_read = Arc::new(AtomicU64::new(0));
        let counted = CountedReader { inner: reader, read: Arc::clone(&stored_bytes_read) };
        let mut reader = decompressed(counted).map_err(failed)?;
        let (head, detected) = detect_format(&mut reader, columns).map_err(failed)?;
        let reader: Box<dyn Read + Send> = Box::new(head.chain(reader));
        let mut recorded = None;
        let (holds_values, lacks_times) = match &detected {
            Detected::Csv(plan) => (plan.holds_values(), plan.lacks_times()),
            _ => (false, false),
        };
        let (format, start_reading): (_, StartReading) = match detected {
            Detected::Csv(plan) => {
                let again = again.map(|path| decompressed(File::open(path)?)).transpose().map_err(failed)?;
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
    /// Readable, but not a capture of a VN-100.
    #[error(
        "{} is not a capture this program reads: looked for VectorNav sentences ($VNYMR,… or $VNIMU,… with a checksum), 0xFA \
         binary packets, CSV columns of known names and MCAP recordings, also inside gzip and zstd; found {found}",
        path.display()
    )]
    NotACapture {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The content instead.
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

/// Unpacks gzip data, member behind member, and behind the last one the zeros that fill up a block.
struct Gunzip<R> {
    /// `None` behind the last member.
    member: Option<GzDecoder<BufReader<R>>>,
}

impl<R: Read> Gunzip<R> {
    fn new(packed: R) -> Self {
        Self { member: Some(GzDecoder::new(BufReader::new(packed))) }
    }
}

impl<R: Read> Read for Gunzip<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                return Ok(n);
            }
            let ended = skip_zeros(member.get_mut())?;
            let packed = self.member.take().map(GzDecoder::into_inner);
            self.member = packed.filter(|_| !ended).map(GzDecoder::new);
        }
        Ok(0)
    }
}

/// Whether nothing but zeros was left.
fn skip_zeros(packed: &mut impl BufRead) -> io::Result<bool> {
    loop {
        let waiting = packed.fill_buf()?;
        let length = waiting.len();
        let zeros = waiting.iter().take_while(|&&byte| byte == 0).count();
        packed.consume(zeros);
        if zeros < length || length == 0 {
            return Ok(length == 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    /// The bytes unpacked, and whether they ended without an error.
    fn unpacked(bytes: &[u8]) -> (Vec<u8>, bool) {
        let mut unpacked = Vec::new();
        let outcome = Gunzip::new(bytes).read_to_end(&mut unpacked);
        (unpacked, outcome.is_ok())
    }

    #[test]
    fn members_and_zeros_behind_them_are_one_file() {
        let (one, two) = (packed(b"one "), packed(b"two"));
        for zeros in [0, 1, 511, 100_000] {
            let padding = vec![0; zeros];
            assert_eq!(unpacked(&[&*one, &two, &padding].concat()), (b"one two".to_vec(), true), "{zeros}");
        }
        assert_eq!(unpacked(&[&packed(b"")[..], &one].concat()), (b"one ".to_vec(), true));
    }

    #[test]
    fn other_bytes_behind_and_a_cut_are_errors() {
        let one = packed(b"one ");
        assert_eq!(unpacked(&[&one, &b"\0\0more"[..]].concat()), (b"one ".to_vec(), false));
        assert!(!unpacked(&one[..one.len() - 1]).1);
        assert!(!unpacked(&[&one[..], &one[..5]].concat()).1);
        // an interrupted read is not the end
        struct Interrupted<'a>(&'a [u8], bool);
        impl Read for Interrupted<'_> {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                self.1 = !self.1;
                if self.1 { Err(io::ErrorKind::Interrupted.into()) } else { self.0.by_ref().take(3).read(buffer) }
            }
        }
        let bytes = [&one[..], &[0; 9], &one].concat();
        let mut whole = Vec::new();
        let mut reader = Interrupted(&bytes, false);
        let outcome = Gunzip::new(&mut reader).read_to_end(&mut whole);
        assert_eq!((whole, outcome.is_ok()), (b"one one ".to_vec(), true));
    }
}
