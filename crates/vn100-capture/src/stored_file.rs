//! A file that several readers share, wherever its bytes are.

use std::{
    fmt,
    fs::File,
    io::{self, Cursor, Read, Seek, SeekFrom},
    sync::Arc,
};

/// A file wherever its bytes are: of the operating system, in memory, in a browser.
pub trait StoredFile: fmt::Debug + Send {
    /// Opens the file at its first byte; each opening has a position of its own.
    ///
    /// # Errors
    /// If it can no longer be opened.
    fn open(&self) -> io::Result<Box<dyn ReadSeek>>;

    /// Length in bytes; `None` if it is not known.
    fn bytes(&self) -> Option<u64>;
}

/// A reader that can be set to any place.
pub trait ReadSeek: Read + Seek + Send {}

impl<T: Read + Seek + Send> ReadSeek for T {}

/// A file with a position of its own, unlike clones of a file, which share a position.
struct SharedFile {
    file: File,
    at: u64,
}

impl StoredFile for File {
    fn open(&self) -> io::Result<Box<dyn ReadSeek>> {
        Ok(Box::new(SharedFile { file: self.try_clone()?, at: 0 }))
    }

    fn bytes(&self) -> Option<u64> {
        Some(self.metadata().ok()?.len())
    }
}

impl StoredFile for Arc<[u8]> {
    fn open(&self) -> io::Result<Box<dyn ReadSeek>> {
        Ok(Box::new(Cursor::new(Arc::clone(self))))
    }

    fn bytes(&self) -> Option<u64> {
        Some(self.len() as u64)
    }
}

impl Read for SharedFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.file.seek(SeekFrom::Start(self.at))?;
        let n = self.file.read(buffer)?;
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for SharedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if let SeekFrom::Start(at) = to {
            self.at = at;
        } else {
            self.file.seek(SeekFrom::Start(self.at))?;
            self.at = self.file.seek(to)?;
        }
        Ok(self.at)
    }
}
