//! Finds a bag: in a file, a folder, or a stream that is unpacked to a temporary file first.

use std::{
    ffi::OsString,
    fs::{self, File},
    io::{self, BufReader, Cursor, Read, Seek, SeekFrom},
    path::Path,
};

use ruzstd::decoding::FrameDecoder;

use super::{
    files::{Bag, BagForm, StoredFile, is_foreign_mcap},
    folder,
    topic::BagError,
};
use crate::{recording, unpack::ZSTD_MAGIC, zstd_reader::ZstdReader};

/// The most bytes that are unpacked to a temporary file.
const UNPACKED_BYTES: u64 = 64 * 1024 * 1024 * 1024;

impl Bag {
    /// The bag in a file or a folder; `None` for any other file, compressed ones included.
    pub(crate) fn at(path: &Path) -> Result<Option<Self>, BagError> {
        let metadata = fs::metadata(path)?;
        if metadata.is_dir() {
            return Self::in_folder(path).map(Some);
        }
        // a pipe can be read only once
        if !metadata.is_file() {
            return Ok(None);
        }
        let mut file = File::open(path)?;
        let Some(form) = BagForm::of(&head(&mut file)?) else { return Ok(None) };
        if form == BagForm::Mcap && !is_foreign_mcap(&file)? {
            return Ok(None);
        }
        check_log(form, path)?;
        Ok(Some(Self::new(form, vec![Box::new(file)])))
    }

    fn in_folder(folder: &Path) -> Result<Self, BagError> {
        let (mut form_of_all, mut files) = (None, Vec::<Box<dyn StoredFile>>::new());
        let mut unpacked_bytes = 0;
        for path in folder::files(folder)? {
            let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
            let mut file = File::open(&path).map_err(named)?;
            let mut found = head(&mut file)?;
            if found.starts_with(ZSTD_MAGIC) {
                let bytes;
                (file, bytes) = to_temporary_file(ZstdReader::new(BufReader::new(file), FrameDecoder::new()))?;
                unpacked_bytes += bytes;
                found = head(&mut file)?;
            }
            let form = BagForm::of(&found).filter(|form| *form_of_all.get_or_insert(*form) == *form);
            let form = form.ok_or_else(|| {
                BagError::Unusable(format!("{} is not of the same form as the other files of the bag", path.display()))
            })?;
            check_log(form, &path)?;
            files.push(Box::new(file));
        }
        let form = form_of_all.ok_or_else(folder::not_a_bag)?;
        Ok(Self { unpacked_bytes, ..Self::new(form, files) })
    }
}

pub(crate) enum Stream {
    Bag(Bag),
    Other(Box<dyn Read + Send>),
}

/// Searches a bag in a stream; the stream is then unpacked to a temporary file without a name.
pub(crate) fn detect_bag(mut stream: Box<dyn Read + Send>) -> Result<Stream, BagError> {
    let head = head_of(&mut stream)?;
    let form = BagForm::of(&head).filter(|form| *form != BagForm::Mcap || !recording::is_ours(&head));
    let whole = Cursor::new(head).chain(stream);
    let Some(form) = form else { return Ok(Stream::Other(Box::new(whole))) };
    let (mut file, unpacked_bytes) = to_temporary_file(whole)?;
    if form == BagForm::Mcap && !is_foreign_mcap(&file)? {
        file.seek(SeekFrom::Start(0))?;
        return Ok(Stream::Other(Box::new(file)));
    }
    Ok(Stream::Bag(Bag { unpacked_bytes, ..Bag::new(form, vec![Box::new(file)]) }))
}

/// Copies a stream to a file without a name. Returns the file and its length in bytes.
fn to_temporary_file(stream: impl Read) -> Result<(File, u64), BagError> {
    let mut file = tempfile::tempfile()?;
    let bytes = io::copy(&mut stream.take(UNPACKED_BYTES + 1), &mut file)
        .map_err(|source| io::Error::new(source.kind(), format!("cannot unpack it to a temporary file: {source}")))?;
    if bytes > UNPACKED_BYTES {
        return Err(BagError::Unusable(format!(
            "unpacked it is larger than {UNPACKED_BYTES} bytes, which is as much as is kept: unpack it to a file first"
        )));
    }
    file.seek(SeekFrom::Start(0))?;
    Ok((file, bytes))
}

fn head(file: &mut File) -> io::Result<Vec<u8>> {
    let head = head_of(file)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(head)
}

fn head_of(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    stream.by_ref().take(recording::HEAD_BYTES).read_to_end(&mut head)?;
    Ok(head)
}

/// An error if a database was not closed, because its last messages are in a separate file.
fn check_log(form: BagForm, path: &Path) -> Result<(), BagError> {
    let mut log = OsString::from(path);
    log.push("-wal");
    match fs::metadata(&log) {
        Ok(found) if form == BagForm::Db3 && found.len() > 0 => Err(BagError::Unusable(format!(
            "its last messages are still in {}, as its recorder did not end: open and close it once, as `sqlite3 {} \
                 'PRAGMA wal_checkpoint(TRUNCATE)'` does",
            Path::new(&log).display(),
            path.display()
        ))),
        _ => Ok(()),
    }
}
