//! The lines of a reader, through one buffer that never grows.

use std::io::{self, Read};

use memchr::memchr;

use super::BYTE_ORDER_MARK;

/// The size of the buffer: a line longer than this is not kept.
pub(super) const LONGEST_LINE: usize = 64 * 1024;

/// Finds the lines of a byte stream.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Box<[u8]>,
    /// What is read and not yet handed out lies in `buffer[begin..end]`.
    begin: usize,
    end: usize,
    /// Bytes of lines handed out or dropped, line ends included.
    bytes: u64,
    number: u64,
    /// The beginning of the line at hand was dropped.
    overlong: bool,
    /// The reader has ended.
    ended: bool,
}

/// A line, without its line end.
pub(super) enum Line<'a> {
    Whole(&'a [u8]),
    /// Longer than [`LONGEST_LINE`]: its last bytes.
    Overlong(&'a [u8]),
}

impl<R: Read> Lines<R> {
    pub(super) fn new(reader: R) -> Self {
        Self {
            reader,
            buffer: vec![0; LONGEST_LINE].into(),
            begin: 0,
            end: 0,
            bytes: 0,
            number: 0,
            overlong: false,
            ended: false,
        }
    }

    /// The next line that needs no read, and its number from 1.
    #[inline]
    pub(super) fn next_buffered(&mut self) -> Option<(u64, Line<'_>)> {
        let waiting = &self.buffer[self.begin..self.end];
        let (length, taken) = match memchr(b'\n', waiting) {
            Some(length) => (length, length + 1),
            None if self.ended && (self.overlong || !waiting.is_empty()) => (waiting.len(), waiting.len()),
            None => return None,
        };
        self.begin += taken;
        self.bytes += taken as u64;
        self.number += 1;
        let mut line = &waiting[..length];
        if self.number == 1 {
            line = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line);
        }
        line = line.strip_suffix(b"\r").unwrap_or(line);
        let line = if std::mem::take(&mut self.overlong) { Line::Overlong(line) } else { Line::Whole(line) };
        Some((self.number, line))
    }

    /// Reads once, when no line is buffered; `false` at the end of the data.
    ///
    /// # Errors
    /// That of the reader. What was read before is kept, and the next call reads on.
    pub(super) fn fill(&mut self) -> io::Result<bool> {
        if self.ended {
            return Ok(false);
        }
        self.buffer.copy_within(self.begin..self.end, 0);
        self.end -= self.begin;
        self.begin = 0;
        if self.end == self.buffer.len() {
            self.bytes += self.end as u64;
            self.end = 0;
            self.overlong = true;
        }
        loop {
            match self.reader.read(&mut self.buffer[self.end..]) {
                Ok(n) => {
                    self.end += n;
                    self.ended = n == 0;
                    // the last line may have no line end
                    return Ok(n > 0 || self.end > 0 || self.overlong);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Bytes of the lines handed out, line ends included.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_without_their_ends() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\n\r\n\nb\rc\n d"[..]);
        let mut found = Vec::new();
        while lines.fill().unwrap() {
            while let Some((number, line)) = lines.next_buffered() {
                let Line::Whole(line) = line else { panic!("line {number} is short") };
                found.push((number, line.to_vec()));
            }
        }
        let expected = [&b"a"[..], b"", b"", b"b\rc", b" d"];
        assert_eq!(found, (1..).zip(expected.map(<[u8]>::to_vec)).collect::<Vec<_>>());
        assert_eq!(lines.bytes(), 15);
    }
}
