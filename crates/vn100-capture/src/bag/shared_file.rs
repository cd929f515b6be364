//! A file that several readers share.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
};

use super::files::{ReadSeek, StoredFile};

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
