//! What a capture is, judged by its first bytes and never by its name.

use std::io::{self, Read};

use vn100_protocol::{BadKind, Decoder, Item, Options};

use crate::csv::{self, ColumnMap, CsvError, Plan};

/// How much of a capture is looked at before it is given up as unknown.
const HEAD_BYTES: usize = 64 * 1024;

/// The form a capture has, after decompression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Sentences in text, any line ending, anything else between them.
    Text,
    /// Bytes as they came from the port, sentences and binary packets mixed with whatever else was on the line.
    Raw,
    /// Rows of a CSV file, numbers or sentences with their stamps.
    Csv,
}

/// What the head of a file was taken for.
#[derive(Debug)]
pub(crate) enum Recognised {
    Text,
    Raw,
    Csv(Plan),
    /// A CSV file whose columns cannot be used; holds why.
    UnusableCsv(CsvError),
    /// Nothing of a VN-100 in it; holds what was found instead, in words.
    Unknown(String),
}

/// The first bytes of a capture, and the error that ended them early if one did. Reads as what it was read from.
#[derive(Debug, Default)]
pub(crate) struct Head {
    bytes: Vec<u8>,
    shown: usize,
    fault: Option<io::Error>,
}

impl Read for Head {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = (&self.bytes[self.shown..]).read(buffer)?;
        self.shown += n;
        match self.fault.take_if(|_| n == 0) {
            Some(fault) => Err(fault),
            None => Ok(n),
        }
    }
}

/// Reads the head of `reader` (no more than is needed to be sure) and says what it is.
///
/// Bytes that are not text and hold no sentence count as a raw capture: a port at the wrong baud rate looks exactly like that,
/// and reading on is how its owner learns it. A map of columns says that it is a CSV file.
pub(crate) fn recognise(reader: &mut impl Read, columns: Option<&ColumnMap>) -> io::Result<(Head, Recognised)> {
    let mut head = Head::default();
    let mut decoder = Decoder::new(Options { accept_unchecked: true });
    let mut sentence_seen = false;
    while head.bytes.len() < HEAD_BYTES && !sentence_seen {
        let note = |item: Item<'_>| sentence_seen |= is_evidence(&item);
        let more = head.grow(reader)?;
        if more.is_empty() {
            decoder.finish(note);
            break;
        }
        decoder.push(more, note);
    }
    if columns.is_none() && !is_text(&head.bytes) {
        return Ok((head, Recognised::Raw));
    }
    // a line that begins with a sentence is no row
    if columns.is_some() || !head.bytes.trim_ascii_start().starts_with(b"$") {
        while head.bytes.len() < csv::HEAD_BYTES && !head.grow(reader)?.is_empty() {}
        match csv::recognise(&head.bytes, columns) {
            Ok(Some(plan)) => return Ok((head, Recognised::Csv(plan))),
            Err(error) if columns.is_some() || !sentence_seen => return Ok((head, Recognised::UnusableCsv(error))),
            Ok(None) | Err(_) => {}
        }
    }
    let recognised = if sentence_seen { Recognised::Text } else { Recognised::Unknown(describe(&head.bytes)) };
    Ok((head, recognised))
}

impl Head {
    /// Reads a little more; nothing at the end, or at a fault.
    fn grow(&mut self, reader: &mut impl Read) -> io::Result<&[u8]> {
        let before = self.bytes.len();
        let mut piece = [0; 4096];
        loop {
            match reader.read(&mut piece) {
                Ok(n) => self.bytes.extend_from_slice(&piece[..n]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) if before == 0 => return Err(error),
                // what came before the fault is still a capture
                Err(error) => self.fault = Some(error),
            }
            return Ok(&self.bytes[before..]);
        }
    }
}

/// A whole sentence or packet, or a damaged sentence that still names a VectorNav message.
fn is_evidence(item: &Item<'_>) -> bool {
    match item {
        Item::Bad(bad) => bad.raw.starts_with(b"$VN") && bad.kind != BadKind::Truncated,
        _ => true,
    }
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.iter().all(|&b| matches!(b, b'\t' | b'\r' | b'\n' | 0x20..=0x7e | 0x80..)) && {
        match std::str::from_utf8(bytes) {
            Ok(_) => true,
            // a character cut by the end of the head is no evidence against text
            Err(error) => error.error_len().is_none(),
        }
    }
}

fn describe(head: &[u8]) -> String {
    if head.is_empty() {
        return "the file is empty".into();
    }
    let text = String::from_utf8_lossy(head);
    let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("");
    // U+0080 to U+009F steer a terminal as well as the control characters of ASCII do
    let shown: String = first.chars().take(60).filter(|c| !c.is_control()).collect();
    let ellipsis = if first.chars().count() > 60 { "…" } else { "" };
    format!("{} bytes of text that begin with \"{shown}{ellipsis}\"", head.len())
}
