//! Finds a bag: in a file, a folder, or a stream that is unpacked first.

use std::{
    ffi::OsString,
    fs::{self, File},
    io::{self, BufReader, Cursor, ErrorKind, Read},
    path::Path,
    sync::Arc,
};

use ruzstd::decoding::FrameDecoder;

use super::{
    files::{Bag, BagForm, is_foreign_mcap},
    folder,
};
use crate::{open_error::Problem, recording, stored_file::StoredFile, unpack::ZSTD_MAGIC, zstd_reader::ZstdReader};

/// The most bytes that are unpacked to a temporary file.
const UNPACKED_BYTES: u64 = 64 << 30;

/// The most bytes that are unpacked to memory on a platform without files, such as a browser.
const UNPACKED_BYTES_IN_MEMORY: u64 = 512 << 20;

impl Bag {
    /// The bag whose files are in a folder.
    pub(crate) fn in_folder(folder: &Path) -> Result<Self, Problem> {
        let (mut form_of_all, mut files) = (None, Vec::<Box<dyn StoredFile>>::new());
        let (mut unpacked_bytes, mut error) = (0, None);
        for path in folder::files(folder)? {
            let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
            let mut file: Box<dyn StoredFile> = Box::new(File::open(&path).map_err(named)?);
            let mut found = head_of(&mut file.open()?)?;
            if found.starts_with(ZSTD_MAGIC) {
                let packed = BufReader::new(file.open()?);
                let mut packed = UpToError::of(ZstdReader::new(packed, FrameDecoder::new()));
                let bytes;
                (file, bytes) = kept(&mut packed)?;
                unpacked_bytes += bytes;
                error = error.or(packed.error.map(named));
                found = head_of(&mut file.open()?)?;
            }
            let form = BagForm::of(&found).filter(|form| *form_of_all.get_or_insert(*form) == *form);
            if form.is_none() {
                let name = path.display();
                return Err(Problem::new(format!("{name} is not of the same form as the other files of the bag")));
            }
            check_log(&path)?;
            files.push(file);
        }
        let form = form_of_all.ok_or_else(folder::not_a_bag)?;
        Ok(Self { unpacked_bytes, unpack_error: error, ..Self::new(form, files) })
    }
}

/// The form of the bag in a file; `None` for any other file, compressed ones included.
pub(crate) fn form_of(file: &dyn StoredFile) -> io::Result<Option<BagForm>> {
    match BagForm::of(&head_of(&mut file.open()?)?) {
        Some(BagForm::Mcap) if !is_foreign_mcap(file)? => Ok(None),
        form => Ok(form),
    }
}

pub(crate) enum Stream {
    Bag(Bag),
    Other(Box<dyn Read + Send>),
}

/// Searches a bag in a stream; the stream is then unpacked.
pub(crate) fn detect_bag(mut stream: Box<dyn Read + Send>) -> Result<Stream, Problem> {
    let head = head_of(&mut stream)?;
    let form = BagForm::of(&head).filter(|form| *form != BagForm::Mcap || !recording::is_ours(&head));
    let whole = Cursor::new(head).chain(stream);
    let Some(form) = form else { return Ok(Stream::Other(Box::new(whole))) };
    let mut whole = UpToError::of(whole);
    let (file, unpacked_bytes) = kept(&mut whole)?;
    let unpack_error = whole.error;
    if form == BagForm::Mcap && !is_foreign_mcap(&*file)? {
        return unpack_error.map_or(Ok(Stream::Other(Box::new(file.open()?))), |error| Err(error.into()));
    }
    Ok(Stream::Bag(Bag { unpacked_bytes, unpack_error, ..Bag::new(form, vec![file]) }))
}

/// A stream that ends at its first error.
struct UpToError<R> {
    stream: R,
    error: Option<io::Error>,
}

impl<R> UpToError<R> {
    const fn of(stream: R) -> Self {
        Self { stream, error: None }
    }
}

impl<R: Read> Read for UpToError<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.read(buffer).or_else(|error| {
            let is_end = error.kind() != ErrorKind::Interrupted;
            if is_end {
                self.error = Some(error);
                Ok(0)
            } else {
                Err(error)
            }
        })
    }
}

/// Copies a stream to a file without a name, or to memory on a platform without files. Returns the
/// file and its length in bytes.
fn kept(stream: impl Read) -> Result<(Box<dyn StoredFile>, u64), Problem> {
    let (file, bytes, most): (Box<dyn StoredFile>, _, _) = match tempfile::tempfile() {
        Ok(mut file) => {
            let bytes = io::copy(&mut stream.take(UNPACKED_BYTES + 1), &mut file).map_err(|source| {
                io::Error::new(source.kind(), format!("cannot unpack it to a temporary file: {source}"))
            })?;
            (Box::new(file), bytes, UNPACKED_BYTES)
        }
        Err(error) if error.kind() == ErrorKind::Unsupported => {
            let mut bytes = Vec::new();
            let count = stream.take(UNPACKED_BYTES_IN_MEMORY + 1).read_to_end(&mut bytes)?;
            let file: Arc<[u8]> = bytes.into();
            (Box::new(file), count as u64, UNPACKED_BYTES_IN_MEMORY)
        }
        Err(error) => return Err(error.into()),
    };
    if bytes > most {
        return Err(Problem::new(format!(
            "unpacked it is larger than {most} bytes, which is as much as is kept: unpack it to a file first"
        )));
    }
    Ok((file, bytes))
}

fn head_of(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    stream.by_ref().take(recording::HEAD_BYTES).read_to_end(&mut head)?;
    Ok(head)
}

/// An error if a file is a database that was not closed, because its last messages are in a
/// separate file.
pub(crate) fn check_log(path: &Path) -> Result<(), Problem> {
    let mut log = OsString::from(path);
    log.push("-wal");
    let is_open = fs::metadata(&log).is_ok_and(|found| found.len() > 0);
    if !is_open || BagForm::of(&head_of(&mut File::open(path)?)?) != Some(BagForm::Db3) {
        return Ok(());
    }
    let (log, path) = (Path::new(&log).display(), path.display());
    Err(Problem::new(format!(
        "its last messages are still in {log}, as its recorder did not end: open and close it once, as `sqlite3 {path} \
         'PRAGMA wal_checkpoint(TRUNCATE)'` does"
    )))
}
