//! The records of an MCAP file, including records inside chunks, up to its end or to the place
//! where it was cut. The format: <https://mcap.dev/spec>.
//!
//! The readers of the `mcap` crate trust the lengths of records inside chunks, and reserve memory
//! for the claimed length of a text; here all lengths are checked first.

use std::{
    io::{self, ErrorKind, Read, Seek, SeekFrom},
    ops::Range,
};

use lz4_flex::frame::FrameDecoder as Lz4Decoder;
use mcap::records::{Footer, Record, op};
use ruzstd::decoding::FrameDecoder as ZstdDecoder;

use crate::zstd_reader::ZstdReader;

/// Longest record that is read, and longest chunk, compressed or not. Records of this program hold
/// one read of a port; others may hold images.
pub(crate) const RECORD_BYTES: usize = 64 * 1024 * 1024;

/// Bytes of one read of the file; more if a long record is known to follow.
const READ_BYTES: usize = 64 * 1024;
const LONG_READ_BYTES: usize = 1024 * 1024;

/// Kind and length, before each record.
const HEAD_BYTES: usize = 1 + 8;

/// Bytes of the content of the footer, and of everything after the summary.
const FOOTER_BYTES: usize = 8 + 8 + 4;
const TAIL_BYTES: usize = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len();

/// The records of a file in the order they were written. Memory is bounded by its longest record
/// and its longest chunk.
pub(crate) struct McapRecords<R> {
    pub(crate) file: R,
    /// Bytes of the file, `next..filled` are not taken yet.
    buffer: Vec<u8>,
    next: usize,
    filled: usize,
    /// The records of the current chunk, and the start of the next record.
    chunk: Vec<u8>,
    next_in_chunk: usize,
    /// Whether the file ends inside that chunk.
    is_chunk_cut: bool,
    /// The content of the last record, in the chunk or else in the buffer.
    data: Range<usize>,
    is_in_chunk: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    /// A record of this kind; its content is [`McapRecords::data`].
    Record(u8),
    /// The end of the data. An index may follow.
    End,
    Cut,
}

impl<R: Read> McapRecords<R> {
    /// Opens a file at its first byte; `None` if it is no MCAP file.
    pub(crate) fn open(mut file: R) -> io::Result<Option<Self>> {
        let mut magic = Vec::new();
        file.by_ref().take(mcap::MAGIC.len() as u64).read_to_end(&mut magic)?;
        Ok(mcap::MAGIC.starts_with(&magic).then(|| Self::new(file)))
    }

    /// The records of the summary after the data, up to the footer; `None` for a file without a
    /// summary, such as one that was cut.
    pub(crate) fn open_summary(mut file: R) -> io::Result<Option<Self>>
    where
        R: Seek,
    {
        let size = file.seek(SeekFrom::End(0))?;
        let Some(tail_start) = size.checked_sub(TAIL_BYTES as u64) else { return Ok(None) };
        file.seek(SeekFrom::Start(tail_start))?;
        let mut tail = [0; TAIL_BYTES];
        file.read_exact(&mut tail)?;
        let footer = match head(&tail) {
            Some((op::FOOTER, bytes)) if bytes == FOOTER_BYTES as u64 && tail.ends_with(mcap::MAGIC) => {
                parse_record(op::FOOTER, &tail[HEAD_BYTES..][..FOOTER_BYTES])?
            }
            _ => return Ok(None),
        };
        match footer {
            Record::Footer(Footer { summary_start, .. }) if (1..tail_start).contains(&summary_start) => {
                file.seek(SeekFrom::Start(summary_start))?;
                Ok(Some(Self::new(file)))
            }
            _ => Ok(None),
        }
    }

    fn new(file: R) -> Self {
        Self {
            file,
            buffer: Vec::new(),
            next: 0,
            filled: 0,
            chunk: Vec::new(),
            next_in_chunk: 0,
            is_chunk_cut: false,
            data: 0..0,
            is_in_chunk: false,
        }
    }

    /// Goes to the next record. The records of chunks come one by one; chunks themselves are not
    /// returned.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged, or has another one after its end. No valid record
    /// follows.
    pub(crate) fn advance(&mut self) -> io::Result<Next> {
        let next = self.next_record()?;
        if next == Next::End {
            self.check_end()?;
        }
        Ok(next)
    }

    fn next_record(&mut self) -> io::Result<Next> {
        loop {
            if let Some(next) = self.advance_in_chunk()? {
                return Ok(next);
            }
            self.is_in_chunk = false;
            self.fill(HEAD_BYTES)?;
            let (opcode, bytes) = match head(&self.buffer[self.next..self.filled]) {
                // a file system that lost power leaves zeros in allocated space
                None | Some((0, _)) => return Ok(Next::Cut),
                Some((opcode, bytes)) if bytes <= RECORD_BYTES as u64 => (opcode, bytes as usize),
                Some((opcode, bytes)) => {
                    let problem = format!("a record of kind {opcode:#04x} has {bytes} bytes");
                    return Err(damaged(&format!("{problem}, and at most {RECORD_BYTES} are read")));
                }
            };
            let is_whole = self.fill(HEAD_BYTES + bytes)?;
            let start = self.next + HEAD_BYTES;
            self.next = self.filled.min(start + bytes);
            self.data = start..self.next;
            match opcode {
                op::CHUNK => {
                    self.next_in_chunk = 0;
                    let unpacked = unpack(&self.buffer[self.data.clone()], is_whole, &mut self.chunk);
                    self.is_chunk_cut = unpacked.inspect_err(|_| self.chunk.clear())?;
                }
                _ if !is_whole => return Ok(Next::Cut),
                op::DATA_END => return Ok(Next::End),
                _ => return Ok(Next::Record(opcode)),
            }
        }
    }

    /// Checks that no second file follows, as after `cat`.
    fn check_end(&mut self) -> io::Result<()> {
        // a damaged summary is no error, as nothing of it is needed
        while matches!(self.next_record(), Ok(Next::Record(opcode)) if opcode != op::FOOTER) {}
        self.fill(2 * mcap::MAGIC.len())?;
        let rest = &self.buffer[self.next..self.filled];
        if rest.strip_prefix(mcap::MAGIC).is_some_and(|rest| rest.starts_with(mcap::MAGIC)) {
            let problem = "another MCAP file follows the end of this one and is not read: keep each in its own file";
            return Err(io::Error::new(ErrorKind::InvalidData, problem));
        }
        Ok(())
    }

    /// The content of the last record.
    pub(crate) fn data(&self) -> &[u8] {
        let bytes = if self.is_in_chunk { &self.chunk } else { &self.buffer };
        &bytes[self.data.clone()]
    }

    /// Goes to the next record of the chunk; `None` after the last record of a whole chunk.
    fn advance_in_chunk(&mut self) -> io::Result<Option<Next>> {
        let rest = &self.chunk[self.next_in_chunk..];
        if rest.is_empty() && !self.is_chunk_cut {
            return Ok(None);
        }
        let left = rest.len().saturating_sub(HEAD_BYTES);
        match head(rest) {
            Some((0, _)) => Ok(Some(Next::Cut)),
            Some((opcode @ (op::CHUNK | op::DATA_END), _)) => {
                Err(damaged(&format!("a record of kind {opcode:#04x} stands inside of a chunk")))
            }
            Some((opcode, bytes)) if bytes <= left as u64 => {
                let start = self.next_in_chunk + HEAD_BYTES;
                self.next_in_chunk = start + bytes as usize;
                (self.data, self.is_in_chunk) = (start..self.next_in_chunk, true);
                Ok(Some(Next::Record(opcode)))
            }
            _ if self.is_chunk_cut => Ok(Some(Next::Cut)),
            Some((_, bytes)) => {
                Err(damaged(&format!("a record of {bytes} bytes stands in a chunk that has {left} more")))
            }
            None => Err(damaged("a chunk ends inside of a record")),
        }
    }

    /// Reads until this many bytes of the file are buffered; `false` if the file ends before.
    fn fill(&mut self, bytes: usize) -> io::Result<bool> {
        if self.filled - self.next < bytes {
            self.buffer.copy_within(self.next..self.filled, 0);
            (self.next, self.filled) = (0, self.filled - self.next);
        }
        while self.filled - self.next < bytes {
            // memory grows with the bytes read, not with the length that the record claims
            let room = (bytes - self.filled).clamp(READ_BYTES, LONG_READ_BYTES);
            if self.buffer.len() < self.filled + room {
                self.buffer.resize(self.filled + room, 0);
            }
            match self.file.read(&mut self.buffer[self.filled..]) {
                Ok(0) => return Ok(false),
                Ok(read) => self.filled += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(true)
    }
}

/// Parses a record; of the kinds with texts, only schemas, channels and metadata are read.
pub(crate) fn parse_record(opcode: u8, data: &[u8]) -> io::Result<Record<'_>> {
    check_texts(opcode, data).ok_or_else(|| {
        let bytes = data.len();
        damaged(&format!("a record of kind {opcode:#04x} has {bytes} bytes, and texts in it claim more"))
    })?;
    mcap::parse_record(opcode, data).map_err(io_error)
}

/// Checks that the texts of a record end inside the record and do not exceed their claimed length;
/// `None` otherwise.
fn check_texts(opcode: u8, data: &[u8]) -> Option<()> {
    match opcode {
        op::SCHEMA => two_texts(data.get(2..)?).map(drop),
        op::CHANNEL => check_map(two_texts(data.get(4..)?)?),
        op::METADATA => check_map(text(data)?.1),
        _ => Some(()),
    }
}

/// The text after its length, and the remaining bytes.
fn text(data: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = data.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

fn two_texts(data: &[u8]) -> Option<&[u8]> {
    Some(text(text(data)?.1)?.1)
}

fn check_map(data: &[u8]) -> Option<()> {
    let (mut pairs, _) = text(data)?;
    while !pairs.is_empty() {
        pairs = two_texts(pairs)?;
    }
    Some(())
}

/// Kind and length of the record that begins here.
fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let [opcode, length @ ..] = *bytes.first_chunk::<HEAD_BYTES>()?;
    Some((opcode, u64::from_le_bytes(length)))
}

/// The fields before the packed records of a chunk.
struct ChunkHead<'a> {
    unpacked_bytes: u64,
    /// Checksum of the records; 0 for none.
    crc: u32,
    compression: &'a [u8],
    packed_bytes: u64,
}

impl<'a> ChunkHead<'a> {
    /// Parses the fields; also returns the bytes after them.
    fn split(chunk: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (_times, rest) = chunk.split_first_chunk::<16>()?;
        let (unpacked_bytes, rest) = rest.split_first_chunk()?;
        let (crc, rest) = rest.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let (compression, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        let (packed_bytes, rest) = rest.split_first_chunk()?;
        let unpacked_bytes = u64::from_le_bytes(*unpacked_bytes);
        let (crc, packed_bytes) = (u32::from_le_bytes(*crc), u64::from_le_bytes(*packed_bytes));
        Some((Self { unpacked_bytes, crc, compression, packed_bytes }, rest))
    }
}

/// Unpacks the records of a chunk, or of the existing part of a chunk; returns whether it was cut.
fn unpack(chunk: &[u8], is_whole: bool, records: &mut Vec<u8>) -> io::Result<bool> {
    records.clear();
    let Some((ChunkHead { unpacked_bytes, crc, compression, packed_bytes }, rest)) = ChunkHead::split(chunk) else {
        return if is_whole { Err(damaged("a chunk ends inside of its head")) } else { Ok(true) };
    };
    let packed = usize::try_from(packed_bytes).ok().and_then(|bytes| rest.get(..bytes));
    if packed.is_none() && is_whole {
        let left = rest.len();
        return Err(damaged(&format!("the {packed_bytes} packed bytes of a chunk have room of {left}")));
    }
    if unpacked_bytes > RECORD_BYTES as u64 {
        let problem = format!("a chunk unpacks to {unpacked_bytes} bytes, and at most {RECORD_BYTES} are read");
        return Err(damaged(&problem));
    }
    let there = packed.unwrap_or(rest);
    let unpacked: Box<dyn Read + '_> = match compression {
        b"" => Box::new(there),
        b"lz4" => Box::new(Lz4Decoder::new(there)),
        b"zstd" => Box::new(ZstdReader::new(there, ZstdDecoder::new())),
        other => {
            let name = String::from_utf8_lossy(other);
            return Err(damaged(&format!("a chunk is packed by {name:.40?}; lz4 and zstd are known")));
        }
    };
    let outcome = unpacked.take(unpacked_bytes + 1).read_to_end(records);
    if packed.is_none() {
        records.truncate(unpacked_bytes as usize);
        return Ok(true);
    }
    outcome.map_err(|error| damaged(&format!("a chunk cannot be unpacked: {error}")))?;
    if records.len() as u64 != unpacked_bytes {
        // one more than allowed
        let (found, more) = (records.len(), if records.len() as u64 > unpacked_bytes { " or more" } else { "" });
        return Err(damaged(&format!("a chunk unpacks to {found}{more} bytes and not to {unpacked_bytes}")));
    }
    let found = if crc == 0 { 0 } else { crc32fast::hash(records) };
    if found != crc {
        let problem = format!("the records of a chunk have the checksum {found:#010x} and not {crc:#010x}");
        return Err(damaged(&problem));
    }
    Ok(false)
}

pub(crate) fn io_error(error: mcap::McapError) -> io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        error => io::Error::new(ErrorKind::InvalidData, format!("not readable as MCAP: {error}")),
    }
}

fn damaged(problem: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("the MCAP file is damaged: {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(texts: &[&str]) -> Vec<u8> {
        texts.iter().flat_map(|text| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()).collect()
    }

    #[test]
    fn texts_that_claim_more_than_their_record_reserve_no_memory() {
        let map = texts(&[&String::from_utf8(texts(&["key", "value"])).unwrap()]);
        let named = texts(&["/imu", "cdr"]);
        let records = [
            (op::SCHEMA, [&[1, 0], &named[..], &[0; 4]].concat()),
            (op::CHANNEL, [&[2, 0, 1, 0], &named[..], &map].concat()),
            (op::METADATA, [texts(&["vn100"]), map].concat()),
        ];
        for (opcode, data) in records {
            parse_record(opcode, &data).unwrap();
            let lengths = data.windows(4).enumerate().filter(|(_, bytes)| bytes[0] > 0 && bytes[1..] == [0; 3]);
            let lengths: Vec<usize> = lengths.map(|(at, _)| at).collect();
            assert!(lengths.len() >= 2, "{opcode}");
            for at in lengths {
                let mut lying = data.clone();
                lying[at + 3] = 0xC0;
                let error = parse_record(opcode, &lying).unwrap_err().to_string();
                let problems = ["texts in it claim more", "exceeds space in record"];
                assert!(problems.iter().any(|problem| error.contains(problem)), "{opcode} {at}: {error}");
            }
            (0..data.len()).for_each(|cut| assert!(parse_record(opcode, &data[..cut]).is_err(), "{opcode} {cut}"));
        }
    }
}
