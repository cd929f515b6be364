//! The file of the page, read piece by piece.

use std::io::{self, Read, Seek, SeekFrom};

use vn100_capture::{ReadSeek, StoredFile};

#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Copies bytes of the file from `offset` on to `to`, at most `length` of them; how many, or -1
    /// if the file cannot be read.
    fn read_file(offset: f64, to: *mut u8, length: usize) -> i32;
}

/// Bytes of the file from `offset` on; `None` if it cannot be read.
fn read_at(offset: u64, to: &mut [u8]) -> Option<usize> {
    // SAFETY: the page writes at most `length` bytes, to a slice of that length
    let count = unsafe { read_file(offset as f64, to.as_mut_ptr(), to.len()) };
    usize::try_from(count).ok().map(|count| count.min(to.len()))
}

/// Bytes of one call of the page.
const PIECE_BYTES: usize = 256 * 1024;

#[derive(Debug, Clone, Copy)]
pub(super) struct PageFile {
    pub(super) bytes: u64,
}

impl StoredFile for PageFile {
    fn open(&self) -> io::Result<Box<dyn ReadSeek>> {
        Ok(Box::new(Opened { bytes: self.bytes, at: 0, piece: Vec::new(), piece_at: 0 }))
    }

    fn bytes(&self) -> Option<u64> {
        Some(self.bytes)
    }
}

/// A reader with the piece that it read last: a reader of an index goes to and fro within it.
struct Opened {
    bytes: u64,
    at: u64,
    piece: Vec<u8>,
    piece_at: u64,
}

impl Read for Opened {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let is_in_piece = (self.piece_at..self.piece_at + self.piece.len() as u64).contains(&self.at);
        if !is_in_piece {
            let left = usize::try_from(self.bytes.saturating_sub(self.at)).unwrap_or(usize::MAX);
            self.piece.resize(left.min(PIECE_BYTES), 0);
            let count = read_at(self.at, &mut self.piece);
            self.piece.truncate(count.unwrap_or(0));
            self.piece_at = self.at;
            count.ok_or_else(|| io::Error::other("the browser cannot read it: it was moved or changed, or it is a folder (of a bag, drop the file in it)"))?;
        }
        let count = (&self.piece[(self.at - self.piece_at) as usize..]).read(buffer)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Opened {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (base, offset) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::End(offset) => (self.bytes, offset),
            SeekFrom::Current(offset) => (self.at, offset),
        };
        self.at = base.checked_add_signed(offset).ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
