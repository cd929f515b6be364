//! A stream that can be read again, because its bytes are kept in a temporary file without a name.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom, Write},
};

/// The most bytes that are kept; bytes after them cannot be read again.
const MOST_BYTES: u64 = 64 * 1024 * 1024 * 1024;

/// A reader, and the bytes that it has delivered.
pub(super) struct Kept<R> {
    reader: R,
    /// The temporary file; `None` where nothing is kept.
    file: Option<File>,
    kept_bytes: u64,
    /// The place up to which the bytes were read since the last rewind.
    at: u64,
}

impl<R: Read> Kept<R> {
    /// A stream that keeps nothing.
    pub(super) const fn nothing(reader: R) -> Self {
        Self { reader, file: None, kept_bytes: 0, at: 0 }
    }

    /// A stream that keeps all bytes, unless no temporary file can be made.
    pub(super) fn all(reader: R) -> Self {
        Self { file: tempfile::tempfile().ok(), ..Self::nothing(reader) }
    }

    /// Rewinds to the first byte; `false` where the bytes are not kept.
    pub(super) fn rewind(&mut self) -> bool {
        let is_at_start = self.file.as_mut().is_some_and(|file| file.seek(SeekFrom::Start(0)).is_ok());
        if is_at_start {
            self.at = 0;
        }
        is_at_start
    }

    fn keep(&mut self, bytes: &[u8]) {
        self.kept_bytes += bytes.len() as u64;
        // on a full disk the stream is still read once
        let is_kept = |file: &mut File| file.write_all(bytes).is_ok();
        if self.kept_bytes > MOST_BYTES || !self.file.as_mut().is_some_and(is_kept) {
            self.file = None;
        }
    }
}

impl<R: Read> Read for Kept<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let from_file = self.kept_bytes.saturating_sub(self.at).min(buffer.len() as u64) as usize;
        let n = match &mut self.file {
            Some(file) if from_file > 0 => match file.read(&mut buffer[..from_file])? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                n => n,
            },
            _ => {
                let n = self.reader.read(buffer)?;
                if self.file.is_some() {
                    self.keep(&buffer[..n]);
                }
                n
            }
        };
        self.at += n as u64;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_byte_comes_again_behind_each_rewind(
            bytes in proptest::collection::vec(any::<u8>(), 0..200),
            places in proptest::collection::vec(0_usize..200, 0..6),
        ) {
            let mut kept = Kept::all(&bytes[..]);
            for place in places {
                let mut head = Vec::new();
                kept.by_ref().take(place as u64).read_to_end(&mut head).unwrap();
                prop_assert_eq!(&head[..], &bytes[..place.min(bytes.len())]);
                prop_assert!(kept.rewind());
            }
            let mut all = Vec::new();
            kept.read_to_end(&mut all).unwrap();
            prop_assert_eq!(all, bytes);
        }
    }

    #[test]
    fn what_is_not_kept_comes_once() {
        let mut kept = Kept::nothing(&b"abc"[..]);
        let mut all = Vec::new();
        kept.read_to_end(&mut all).unwrap();
        assert!(!kept.rewind());
        assert_eq!(all, b"abc");
    }
}
