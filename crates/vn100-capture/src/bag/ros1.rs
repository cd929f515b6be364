//! Bags of ROS 1, version 2.0: a sequence of records, most of them inside chunks.
//!
//! The form: <https://wiki.ros.org/Bags/Format/2.0>.

use std::{
    collections::BTreeMap,
    io::{self, BufRead, BufReader, Cursor, ErrorKind, Read, Seek, SeekFrom},
    mem,
};

use bzip2::bufread::BzDecoder;
use lz4_flex::frame::FrameDecoder as Lz4Decoder;

use super::topic::{BagFile, Encoding, MESSAGE_BYTES, MessageHead, Topic, TopicCount, TopicList, damaged};
use crate::mcap_records::RECORD_BYTES;

pub(super) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// Bytes of one read, from the file and from a compressed chunk.
const READ_BYTES: usize = 64 * 1024;

/// Longest header of a record: it holds a few numbers, or the definitions of a type.
const HEADER_BYTES: u32 = 4 * 1024 * 1024;

const MOST_CONNECTIONS: usize = 65_536;

mod op {
    pub(super) const MESSAGE: u8 = 0x02;
    pub(super) const BAG_HEADER: u8 = 0x03;
    pub(super) const CHUNK: u8 = 0x05;
    pub(super) const CHUNK_INFO: u8 = 0x06;
    pub(super) const CONNECTION: u8 = 0x07;
}

/// The messages of a bag, in the order they were written. Memory is bounded by its longest message
/// and its longest chunk that is packed, of 64 MiB at most.
pub(super) struct Ros1Bag<R: Read> {
    file: BufReader<R>,
    /// The rest of the chunk that is read.
    chunk: Option<Box<dyn BufRead + Send>>,
    /// Whether the file ends inside that chunk.
    is_chunk_cut: bool,
    /// The index of the topic of each connection.
    connections: BTreeMap<u32, usize>,
    topics: TopicList,
    header: Vec<u8>,
    data: Vec<u8>,
    /// Bytes of the message that were not read.
    unread_bytes: u32,
}

impl<R: Read + Seek> Ros1Bag<R> {
    pub(super) fn open(mut file: R) -> io::Result<Self> {
        file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
        Ok(Self {
            file: BufReader::with_capacity(READ_BYTES, file),
            chunk: None,
            is_chunk_cut: false,
            connections: BTreeMap::new(),
            topics: TopicList::default(),
            header: Vec::new(),
            data: Vec::new(),
            unread_bytes: 0,
        })
    }

    /// Reads up to the data of the next record; returns its kind and the length of its data, `None`
    /// at the end of the file.
    fn next_record(&mut self) -> io::Result<Option<(u8, u32)>> {
        while bytes(&mut self.chunk, &mut self.file).fill_buf().map_err(cut)?.is_empty() {
            if self.is_chunk_cut {
                return Err(cut(ErrorKind::UnexpectedEof.into()));
            }
            if self.chunk.take().is_none() {
                return Ok(None);
            }
        }
        let header_bytes = self.read_length()?;
        if header_bytes > HEADER_BYTES {
            return Err(damaged(&format!(
                "the header of a record has {header_bytes} bytes, at most {HEADER_BYTES} are read"
            )));
        }
        read_into(&mut self.header, header_bytes, bytes(&mut self.chunk, &mut self.file))?;
        let data_bytes = self.read_length()?;
        let op = field(&self.header, b"op").and_then(|op| op.first().copied());
        let op = op.ok_or_else(|| damaged("a record without its kind"))?;
        Ok(Some((op, data_bytes)))
    }

    fn read_length(&mut self) -> io::Result<u32> {
        let mut length = [0; 4];
        bytes(&mut self.chunk, &mut self.file).read_exact(&mut length).map_err(cut)?;
        Ok(u32::from_le_bytes(length))
    }

    fn enter_chunk(&mut self, data_bytes: u32) -> io::Result<()> {
        if self.chunk.is_some() {
            return Err(damaged("a chunk inside a chunk"));
        }
        let compression = field(&self.header, b"compression").unwrap_or(b"none");
        // its records stand in the file as they are
        if compression == b"none" {
            return Ok(());
        }
        if data_bytes as usize > RECORD_BYTES {
            return Err(damaged(&format!("a chunk of {data_bytes} packed bytes, at most {RECORD_BYTES} are read")));
        }
        let mut packed = Vec::new();
        self.file.by_ref().take(data_bytes.into()).read_to_end(&mut packed)?;
        self.is_chunk_cut = packed.len() < data_bytes as usize;
        let packed = Cursor::new(packed);
        self.chunk = Some(match compression {
            b"bz2" => Box::new(BufReader::with_capacity(READ_BYTES, BzDecoder::new(packed))),
            b"lz4" => Box::new(BufReader::with_capacity(READ_BYTES, Lz4Decoder::new(packed))),
            other => {
                let name = String::from_utf8_lossy(other);
                return Err(damaged(&format!("a chunk is packed by {name:?}; none, bz2 and lz4 are known")));
            }
        });
        Ok(())
    }

    fn take_connection(&mut self, data_bytes: u32) -> io::Result<()> {
        let connection = field(&self.header, b"conn").and_then(number_4);
        let name = field(&self.header, b"topic").map(|topic| String::from_utf8_lossy(topic).into_owned());
        let (Some(connection), Some(name)) = (connection, name) else {
            return Err(damaged("a connection without number or topic"));
        };
        if data_bytes > HEADER_BYTES {
            return Err(damaged(&format!("a connection has {data_bytes} bytes, at most {HEADER_BYTES} are read")));
        }
        self.read_data_of(data_bytes)?;
        let text = |name| field(&self.data, name).map(|text| String::from_utf8_lossy(text).into_owned());
        let type_name = text(b"type").unwrap_or_default();
        let new = Topic::new(&name, &type_name, Encoding::Ros1, text(b"message_definition").as_deref());
        self.topics.add_definition(self.data.len())?;
        self.connections.insert(connection, self.topics.place_of(new)?);
        if self.connections.len() > MOST_CONNECTIONS {
            return Err(damaged(&format!("it has more than {MOST_CONNECTIONS} connections")));
        }
        Ok(())
    }

    fn read_data_of(&mut self, data_bytes: u32) -> io::Result<()> {
        read_into(&mut self.data, data_bytes, bytes(&mut self.chunk, &mut self.file))
    }

    fn skip(&mut self, data_bytes: u32) -> io::Result<()> {
        let mut rest = bytes(&mut self.chunk, &mut self.file).take(data_bytes.into());
        let skipped = io::copy(&mut rest, &mut io::sink()).map_err(cut)?;
        if skipped < data_bytes.into() { Err(cut(ErrorKind::UnexpectedEof.into())) } else { Ok(()) }
    }
}

impl<R: Read + Seek + Send> BagFile for Ros1Bag<R> {
    fn next_head(&mut self) -> io::Result<Option<MessageHead>> {
        let unread_bytes = mem::take(&mut self.unread_bytes);
        self.skip(unread_bytes)?;
        while let Some((op, data_bytes)) = self.next_record()? {
            match op {
                op::CHUNK => self.enter_chunk(data_bytes)?,
                op::CONNECTION => self.take_connection(data_bytes)?,
                op::MESSAGE => {
                    let connection = field(&self.header, b"conn").and_then(number_4);
                    let at_ns = field(&self.header, b"time").and_then(time_ns);
                    let (Some(connection), Some(record_ns)) = (connection, at_ns) else {
                        return Err(damaged("a message without connection or time"));
                    };
                    self.unread_bytes = data_bytes;
                    if let Some(&topic) = self.connections.get(&connection) {
                        return Ok(Some(MessageHead { topic, record_ns }));
                    }
                    return Err(damaged(&format!("a message of connection {connection}, which is not there")));
                }
                _ => self.skip(data_bytes)?,
            }
        }
        Ok(None)
    }

    fn read_data(&mut self) -> io::Result<&[u8]> {
        let data_bytes = mem::take(&mut self.unread_bytes);
        if data_bytes as usize > MESSAGE_BYTES {
            self.data.clear();
            self.skip(data_bytes)?;
        } else {
            self.read_data_of(data_bytes)?;
        }
        Ok(&self.data)
    }

    fn topics(&self) -> &[Topic] {
        &self.topics.topics
    }

    /// Reads the index at the end of the bag, which is missing in a bag that was never closed.
    fn index(&mut self) -> io::Result<Option<Vec<Option<TopicCount>>>> {
        let end = self.file.seek(SeekFrom::End(0))?;
        self.file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
        let Some((op::BAG_HEADER, _)) = self.next_record()? else { return Ok(None) };
        let Some(index_pos) = field(&self.header, b"index_pos").and_then(number_8) else { return Ok(None) };
        if index_pos == 0 || index_pos >= end {
            return Ok(None);
        }
        self.file.seek(SeekFrom::Start(index_pos))?;
        let mut counts: Vec<TopicCount> = Vec::new();
        while let Some((op, data_bytes)) = self.next_record()? {
            match op {
                op::CONNECTION => self.take_connection(data_bytes)?,
                op::CHUNK_INFO => {
                    let time = |name| field(&self.header, name).and_then(time_ns);
                    let (Some(first_ns), Some(last_ns)) = (time(b"start_time"), time(b"end_time")) else {
                        return Ok(None);
                    };
                    self.read_data_of(data_bytes)?;
                    for pair in self.data.chunks_exact(8) {
                        let (connection, messages) = (number_4(&pair[..4]), number_4(&pair[4..]));
                        let topic = connection.and_then(|connection| self.connections.get(&connection));
                        let (Some(&topic), Some(messages)) = (topic, messages) else { return Ok(None) };
                        counts.resize_with(self.topics.topics.len(), TopicCount::default);
                        counts[topic].add(messages.into(), first_ns, last_ns);
                    }
                }
                _ => self.skip(data_bytes)?,
            }
        }
        counts.resize_with(self.topics.topics.len(), TopicCount::default);
        Ok(Some(counts.into_iter().map(Some).collect()))
    }
}

/// The bytes of the next record: those of the chunk, or else of the file.
fn bytes<'a>(chunk: &'a mut Option<Box<dyn BufRead + Send>>, file: &'a mut impl BufRead) -> &'a mut dyn BufRead {
    match chunk {
        Some(chunk) => chunk,
        None => file,
    }
}

/// Reads this many bytes; memory grows with the bytes that exist, not with the claimed length.
fn read_into(buffer: &mut Vec<u8>, length: u32, from: &mut dyn BufRead) -> io::Result<()> {
    buffer.clear();
    let read = from.take(length.into()).read_to_end(buffer).map_err(cut)?;
    if read < length as usize { Err(cut(ErrorKind::UnexpectedEof.into())) } else { Ok(()) }
}

/// The value of a field; fields are a length, a name, `=` and a value.
fn field<'a>(mut fields: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    while let Some((length, rest)) = fields.split_first_chunk() {
        let (field, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        if let Some(value) = field.strip_prefix(name).and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
        fields = rest;
    }
    None
}

fn number_4(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

fn number_8(bytes: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.try_into().ok()?))
}

fn time_ns(bytes: &[u8]) -> Option<i64> {
    let (seconds, nanoseconds) = bytes.split_at_checked(4)?;
    Some(i64::from(number_4(seconds)?) * 1_000_000_000 + i64::from(number_4(nanoseconds)?))
}

/// The error; in words if the file ends too early.
fn cut(error: io::Error) -> io::Error {
    match error.kind() {
        ErrorKind::UnexpectedEof => {
            io::Error::new(ErrorKind::UnexpectedEof, "the bag was cut: it ends inside a record")
        }
        _ => error,
    }
}
