//! A CSV file cut into its lines, through one buffer that never grows, and a line into its fields.
//! A line break inside quotes ends a record, so that one lost quote damages one line only. Fields
//! are read where they stand: to have csv-core copy them out first takes 2.5 times as long, as
//! measured with the numbers of 720 000 rows of ten columns.

use std::io::{self, Read};

use memchr::{memchr, memchr_iter};

use super::{BYTE_ORDER_MARK, number::Number};

/// The size of the buffer: a line longer than this is not kept.
pub(super) const LONGEST_LINE: usize = 64 * 1024;

/// Finds the lines of a byte stream.
pub(super) struct Lines<R> {
    reader: R,
    line_end: u8,
    buffer: Box<[u8]>,
    /// What is read and not yet handed out lies in `buffer[begin..end]`.
    begin: usize,
    end: usize,
    number: u64,
    /// Bytes dropped from the beginning of the line at hand.
    dropped: u64,
    /// The reader has ended.
    ended: bool,
}

/// A line.
pub(super) struct CsvLine<'a> {
    /// From 1.
    pub(super) number: u64,
    /// All of them, with the line end.
    pub(super) bytes: u64,
    /// Without the line end; the last bytes of an overlong line.
    pub(super) text: &'a [u8],
    pub(super) completeness: Completeness,
}

/// What is there of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Completeness {
    Whole,
    /// The last line of the data, without a line end: it may be cut.
    Unended,
    /// Longer than [`LONGEST_LINE`].
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

    /// The next line that needs no read.
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

/// The fields of a line, without the spaces and quotes around them.
pub(super) struct Fields<'a> {
    /// `None` behind the last field.
    rest: Option<&'a [u8]>,
    separator: u8,
}

impl<'a> Fields<'a> {
    pub(super) fn new(line: &'a [u8], separator: u8) -> Self {
        Self { rest: Some(line), separator }
    }

    /// How many there are, and the last one.
    pub(super) fn count_and_last(self) -> (usize, &'a [u8]) {
        self.fold((0, &[]), |(count, _), field| (count + 1, field))
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let end = field_end(rest, self.separator);
        self.rest = rest.get(end + 1..);
        Some(unquoted(&rest[..end]))
    }
}

/// The length of the field at the head of `rest`. A quoted field may hold separators.
#[inline]
pub(super) fn field_end(rest: &[u8], separator: u8) -> usize {
    if let Some(quote) = opening_quote(rest) {
        return memchr_iter(b'"', &rest[quote + 1..])
            .map(|at| quote + 1 + at)
            .find_map(|closing| {
                let behind = closing + 1;
                let spaces = rest[behind..].iter().take_while(|&&b| b == b' ').count();
                let end = behind + spaces;
                (end == rest.len() || rest[end] == separator).then_some(end)
            })
            .unwrap_or(rest.len());
    }
    memchr(separator, rest).unwrap_or(rest.len())
}

/// The position of the quote that begins the field at the head of `rest`.
pub(super) fn opening_quote(rest: &[u8]) -> Option<usize> {
    let at = rest.iter().position(|&b| b != b' ')?;
    (rest[at] == b'"').then_some(at)
}

/// Whether `field` begins with a quote that is not closed.
pub(super) fn has_open_quote(field: &[u8]) -> bool {
    match field.trim_ascii().strip_prefix(b"\"") {
        Some(behind) => !behind.ends_with(b"\""),
        None => false,
    }
}

/// `field` without spaces and quotes around it; a quote that is not closed is one, too.
pub(super) fn unquoted(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    match field.strip_prefix(b"\"") {
        Some(inner) => inner.strip_suffix(b"\"").unwrap_or(inner).trim_ascii(),
        None => field,
    }
}

/// Whether `line` is no row: nothing but spaces, or a `#` and what follows it.
#[inline]
pub(super) fn is_comment_or_blank(line: &[u8]) -> bool {
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace());
    matches!(first, None | Some(b'#'))
}

/// What the last fields of rows have in common in how they are printed. It shows whether a last row
/// without a line end is whole or cut: many writers leave that line end out.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LastField {
    /// Digits after the point, at least one: a truncated whole number looks complete.
    decimals: Option<u32>,
    width: Option<usize>,
}

impl LastField {
    pub(super) fn of(field: &[u8]) -> Self {
        let decimals = Number::parse(field).map(|number| number.decimals());
        Self { decimals: decimals.filter(|&decimals| decimals > 0), width: Some(field.len()) }
    }

    pub(super) fn common(self, other: Self) -> Self {
        Self {
            decimals: self.decimals.filter(|_| self.decimals == other.decimals),
            width: self.width.filter(|_| self.width == other.width),
        }
    }

    /// Whether `field` has the decimals or the width that all others have, if they have any in
    /// common.
    pub(super) fn is_whole(self, field: &[u8]) -> bool {
        let common = self.common(Self::of(field));
        common.decimals.is_some() || common.width.is_some()
    }
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

    fn fields(line: &str, separator: u8) -> Vec<&str> {
        Fields::new(line.as_bytes(), separator).map(|field| std::str::from_utf8(field).unwrap()).collect()
    }

    #[test]
    fn quotes_hold_separators() {
        assert_eq!(fields("a, b ,,c", b','), ["a", "b", "", "c"]);
        assert_eq!(fields("1,\"$A,b*63\",2", b','), ["1", "$A,b*63", "2"]);
        assert_eq!(fields("1; \"x;y\" ;2", b';'), ["1", "x;y", "2"]);
        assert_eq!(fields("\"say \"\"a,b\"\"\",2", b','), ["say \"\"a,b\"\"", "2"]);
        assert_eq!(fields("\t1\t", b'\t'), ["", "1", ""]);
        assert_eq!(fields("", b','), [""]);
    }

    #[test]
    fn an_open_quote_ends_with_its_line() {
        assert_eq!(fields("1,\"$A,b*63", b','), ["1", "$A,b*63"]);
        assert_eq!(fields("\"", b','), [""]);
        for (field, open) in [("\"$A", true), ("\"", true), (" \"$A\" ", false), ("\"\"", false), ("a\"", false)] {
            assert_eq!(has_open_quote(field.as_bytes()), open, "{field:?}");
        }
    }

    #[test]
    fn a_field_is_whole_with_the_decimals_or_the_width_of_all_others() {
        for (others, field, whole) in [
            (&["+00.000301", "-00.000391"][..], "+00.000724", true),
            (&["+00.000301", "-00.000391"], "+00.00072", false),
            (&["0.301", "-12.391"], "7.724", true),
            (&["0.301", "-12.391"], "7.72", false),
            (&["1234", "1235"], "1236", true),
            (&["1234", "1235"], "123", false),
            (&["9", "10"], "11", false),
            (&["0.5", "0.25"], "0.125", false),
            (&["12:00:01", "12:00:02"], "12:00:03", true),
            (&["12:00:01", "12:00:02"], "12:00", false),
            (&["", ""], "", true),
            (&[], "0.5", false),
        ] {
            let others_forms = others.iter().map(|other| LastField::of(other.as_bytes()));
            let last = others_forms.reduce(LastField::common).unwrap_or_default();
            assert_eq!(last.is_whole(field.as_bytes()), whole, "{field} behind {others:?}");
        }
    }
}
