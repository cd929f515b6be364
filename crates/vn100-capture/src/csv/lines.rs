//! A CSV file cut into its lines, through one buffer that never grows. A line break inside quotes
//! ends a record, so a lost quote damages only one line.

use std::io::{self, Read};

use memchr::memchr;

use super::BYTE_ORDER_MARK;

/// The size of the buffer: a longer line is not kept.
pub(super) const LONGEST_LINE: usize = 64 * 1024;

/// Finds the lines of a byte stream.
pub(super) struct Lines<R> {
    reader: R,
    line_end: u8,
    buffer: Box<[u8]>,
    /// The bytes that were read but not yet returned are in `buffer[begin..end]`.
    begin: usize,
    end: usize,
    number: u64,
    /// Number of bytes dropped from the beginning of the present line.
    dropped: u64,
    ended: bool,
}

pub(super) struct CsvLine<'a> {
    /// Number of the line, from 1.
    pub(super) number: u64,
    /// Number of bytes of the line, with its line end.
    pub(super) bytes: u64,
    /// The line without its line end; for an overlong line, its last bytes.
    pub(super) text: &'a [u8],
    pub(super) completeness: Completeness,
}

/// How complete a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Completeness {
    Whole,
    /// The last line of the data, without a line end: it may be truncated.
    Unended,
    Overlong,
}

impl<R: Read> Lines<R> {
    pub(super) fn new(reader: R, line_end: u8) -> Self {
        Self {
            reader,
            line_end,
            buffer: vec![0; LONGEST_LINE].into(),
            begin: 0,
            end: 0,
            number: 0,
            dropped: 0,
            ended: false,
        }
    }

    #[inline]
    pub(super) fn next_buffered(&mut self) -> Option<CsvLine<'_>> {
        let waiting = &self.buffer[self.begin..self.end];
        let (length, taken) = match memchr(self.line_end, waiting) {
            Some(length) => (length, length + 1),
            None if self.ended && (self.dropped > 0 || !waiting.is_empty()) => (waiting.len(), waiting.len()),
            None => return None,
        };
        self.begin += taken;
        self.number += 1;
        let mut text = &waiting[..length];
        if self.number == 1 {
            text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        }
        // a CR is half a line end
        let (text, ended) = match text.strip_suffix(b"\r") {
            Some(text) => (text, true),
            None => (text, taken > length),
        };
        let dropped = std::mem::take(&mut self.dropped);
        let completeness = match (dropped, ended) {
            (1.., _) => Completeness::Overlong,
            (0, true) => Completeness::Whole,
            (0, false) => Completeness::Unended,
        };
        Some(CsvLine { number: self.number, bytes: dropped + taken as u64, text, completeness })
    }

    /// Reads once if no line is buffered; `false` at the end of the data.
    ///
    /// # Errors
    /// The error of the reader. The bytes read before are kept, and the next call continues after them.
    pub(super) fn fill(&mut self) -> io::Result<bool> {
        if self.ended {
            return Ok(false);
        }
        self.buffer.copy_within(self.begin..self.end, 0);
        self.end -= self.begin;
        self.begin = 0;
        if self.end == self.buffer.len() {
            self.dropped += self.end as u64;
            self.end = 0;
        }
        loop {
            match self.reader.read(&mut self.buffer[self.end..]) {
                Ok(n) => {
                    self.end += n;
                    self.ended = n == 0;
                    // the last line may have no line end
                    return Ok(n > 0 || self.end > 0 || self.dropped > 0);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Whether `line` is no row: only spaces, or a `#` and any text after it.
#[inline]
pub(super) fn is_comment_or_blank(line: &[u8]) -> bool {
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace());
    matches!(first, None | Some(b'#'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_without_their_ends() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\n\r\n\nb\rc\n d"[..], b'\n');
        let mut found = Vec::new();
        while lines.fill().unwrap() {
            while let Some(line) = lines.next_buffered() {
                found.push((line.number, line.bytes, line.text.to_vec(), line.completeness));
            }
        }
        let expected: [(u64, &[u8], Completeness); 5] = [
            (6, b"a", Completeness::Whole),
            (2, b"", Completeness::Whole),
            (1, b"", Completeness::Whole),
            (4, b"b\rc", Completeness::Whole),
            (2, b" d", Completeness::Unended),
        ];
        let expected = (1..).zip(expected).map(|(number, (bytes, text, state))| (number, bytes, text.to_vec(), state));
        assert_eq!(found, expected.collect::<Vec<_>>());
    }
}
