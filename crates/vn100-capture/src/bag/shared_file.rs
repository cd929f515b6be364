//! A file that several readers share.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
};

/// A file with a position of its own, in contrast to clones of a file, which share one.
pub(super) struct SharedFile {
    file: File,
    at: u64,
}

impl SharedFile {
    pub(super) const fn new(file: File) -> Self {
        Self { file, at: 0 }
    }

    pub(super) const fn position(&self) -> u64 {
        self.at
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
