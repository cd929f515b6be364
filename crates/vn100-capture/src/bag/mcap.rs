//! MCAP files of ROS, with any compression of their chunks. The form: <https://mcap.dev/spec>.
//!
//! Chunks are unpacked here: the reader of the crate trusts the lengths of the records inside.

use std::{
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Seek, SeekFrom},
    ops::Range,
};

use mcap::{
    McapError, Summary,
    records::{Record, op},
    sans_io::{
        linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
        summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions},
    },
};

use super::files::SharedFile;
use super::topic::{
    BagFile, DEFINITION_BYTES, Encoding, Index, MESSAGE_BYTES, MOST_TOPICS, MessageHead, Topic, TopicCount,
};
use crate::recording::{at_ns, io_error};

/// Bytes of one read of the file.
const READ_BYTES: usize = 64 * 1024;

/// Bytes of a message before its data: channel, number, and two times.
const MESSAGE_HEAD_BYTES: usize = 2 + 4 + 8 + 8;

/// Longest record that is read: a chunk, unpacked or not.
const RECORD_BYTES: usize = 64 * 1024 * 1024;

/// The messages of a file in the order they were written.
pub(super) struct McapBag<R> {
    file: R,
    records: LinearReader,
    contents: Contents,
    /// The records of the chunk that is being read, and where the next one begins.
    chunk: Vec<u8>,
    chunk_at: usize,
    /// The message, in the chunk or, where there are no chunks, in `single`.
    message: Range<usize>,
    single: Vec<u8>,
    is_single: bool,
}

/// What was learned from the records so far.
#[derive(Default)]
struct Contents {
    schemas: BTreeMap<u16, Schema>,
    /// The place of the topic of each channel.
    channels: BTreeMap<u16, usize>,
    topics: Vec<Topic>,
    definition_bytes: usize,
}

struct Schema {
    name: String,
    /// Where it is in the form of ROS.
    definition: Option<String>,
}

impl<R: Read + Seek> McapBag<R> {
    /// A file from its first byte on.
    pub(super) fn open(mut file: R) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_emit_chunks(true)
            .with_record_length_limit(RECORD_BYTES);
        Ok(Self {
            file,
            records: LinearReader::new_with_options(options),
            contents: Contents::default(),
            chunk: Vec::new(),
            chunk_at: 0,
            message: 0..0,
            single: Vec::new(),
            is_single: false,
        })
    }

    fn summary(&mut self) -> Option<Summary> {
        let size = self.file.seek(SeekFrom::End(0)).ok()?;
        let options = SummaryReaderOptions::default().with_file_size(size).with_record_length_limit(RECORD_BYTES);
        let mut reader = SummaryReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event.ok()? {
                SummaryReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(reader.insert(bytes.min(RECORD_BYTES))).ok()?;
                    reader.notify_read(read);
                }
                SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(self.file.seek(to).ok()?),
            }
        }
        reader.finish()
    }

    /// The next message of the chunk; `None` behind its last record.
    fn next_in_chunk(&mut self) -> io::Result<Option<MessageHead>> {
        while self.chunk_at < self.chunk.len() {
            let record = &self.chunk[self.chunk_at..];
            let head = record.first_chunk::<9>().ok_or_else(|| damaged("a chunk ends inside of a record"))?;
            let [opcode, length @ ..] = *head;
            let data = usize::try_from(u64::from_le_bytes(length)).ok().and_then(|length| record[9..].get(..length));
            let data = data.ok_or_else(|| damaged("a record is longer than its chunk"))?;
            let data_at = self.chunk_at + 9;
            self.chunk_at = data_at + data.len();
            if let Some(head) = self.contents.take(opcode, data)? {
                self.message = data_at + MESSAGE_HEAD_BYTES..self.chunk_at;
                self.is_single = false;
                return Ok(Some(head));
            }
        }
        Ok(None)
    }
}

impl McapBag<SharedFile> {
    /// Bytes read of the file.
    pub(super) const fn position(&self) -> u64 {
        self.file.position()
    }
}

impl Contents {
    /// Learns from a record; the head of the message if it is one.
    fn take(&mut self, opcode: u8, data: &[u8]) -> io::Result<Option<MessageHead>> {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(None);
        }
        match mcap::parse_record(opcode, data).map_err(io_error)? {
            Record::Schema { header, data } => {
                self.definition_bytes += data.len();
                self.schemas.insert(header.id, Schema::of(&header.name, &header.encoding, &data));
            }
            Record::Channel(channel) => {
                let schema = self.schemas.remove(&channel.schema_id);
                self.take_channel(channel.id, &channel.topic, &channel.message_encoding, schema.as_ref())?;
                self.schemas.extend(schema.map(|schema| (channel.schema_id, schema)));
            }
            Record::Message { header, .. } => {
                let topic = self.channels.get(&header.channel_id).copied();
                let topic = topic.ok_or_else(|| damaged("a message comes before its channel"))?;
                return Ok(Some(MessageHead { topic, record_ns: at_ns(header.log_time) }));
            }
            _ => {}
        }
        Ok(None)
    }

    fn take_channel(&mut self, id: u16, name: &str, encoding: &str, schema: Option<&Schema>) -> io::Result<()> {
        let (type_name, definition) = schema.map_or(("", None), |schema| (&schema.name, schema.definition.as_deref()));
        let new = Topic::new(name, type_name, Encoding::named(encoding), definition);
        let place = self.topics.iter().position(|topic| topic.is(&new)).unwrap_or_else(|| {
            self.topics.push(new);
            self.topics.len() - 1
        });
        self.channels.insert(id, place);
        if self.topics.len() > MOST_TOPICS || self.definition_bytes > DEFINITION_BYTES {
            return Err(damaged("it has more topics or definitions than any bag"));
        }
        Ok(())
    }
}

/// Unpacks the records of a chunk.
fn unpack(data: &[u8], records: &mut Vec<u8>) -> io::Result<()> {
    let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, data).map_err(io_error)? else {
        return Err(damaged("a chunk is none"));
    };
    records.clear();
    let unpacked: Box<dyn Read + '_> = match &*header.compression {
        "" => Box::new(&*data),
        "lz4" => Box::new(lz4::Decoder::new(&*data)?),
        "zstd" => Box::new(zstd::Decoder::new(&*data)?),
        other => return Err(damaged(&format!("a chunk is packed by {other:.40?}; lz4 and zstd are known"))),
    };
    unpacked.take(RECORD_BYTES as u64 + 1).read_to_end(records)?;
    if header.uncompressed_size != 0 && records.len() as u64 != header.uncompressed_size {
        let (found, said) = (records.len(), header.uncompressed_size);
        return Err(damaged(&format!("a chunk unpacks to {found} bytes and not to {said}")));
    }
    if records.len() > RECORD_BYTES {
        return Err(damaged(&format!(
            "a chunk unpacks to more than {RECORD_BYTES} bytes, which is as much as is kept"
        )));
    }
    Ok(())
}

impl<R: Read + Seek + Send> BagFile for McapBag<R> {
    fn next_head(&mut self) -> io::Result<Option<MessageHead>> {
        loop {
            if let Some(head) = self.next_in_chunk()? {
                return Ok(Some(head));
            }
            match self.records.next_event() {
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                    let room = self.records.insert(bytes.max(READ_BYTES));
                    match self.file.read(room) {
                        Ok(bytes) => self.records.notify_read(bytes),
                        Err(error) if error.kind() == ErrorKind::Interrupted => {}
                        Err(error) => return Err(error),
                    }
                }
                Some(Ok(LinearReadEvent::Record { opcode: op::DATA_END, .. })) => return Ok(None),
                Some(Ok(LinearReadEvent::Record { opcode: op::CHUNK, data })) => {
                    self.chunk_at = 0;
                    unpack(data, &mut self.chunk)?;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    if let Some(head) = self.contents.take(opcode, data)? {
                        self.single.clear();
                        self.single.extend_from_slice(&data[MESSAGE_HEAD_BYTES..]);
                        self.is_single = true;
                        return Ok(Some(head));
                    }
                }
                Some(Err(McapError::UnexpectedEof)) | None => {
                    let problem = "the bag was cut: it ends before its summary";
                    return Err(io::Error::new(ErrorKind::UnexpectedEof, problem));
                }
                Some(Err(error)) => return Err(io_error(error)),
            }
        }
    }

    fn read_data(&mut self) -> io::Result<&[u8]> {
        let data = if self.is_single { &self.single[..] } else { &self.chunk[self.message.clone()] };
        Ok(if data.len() <= MESSAGE_BYTES { data } else { &[] })
    }

    fn topics(&self) -> &[Topic] {
        &self.contents.topics
    }

    /// From the summary at its end, which a file lacks that was cut.
    fn index(&mut self) -> io::Result<Index> {
        let Some(summary) = self.summary() else { return Ok(Index::None) };
        let Some(stats) = &summary.stats else { return Ok(Index::None) };
        let channels: BTreeMap<_, _> = summary.channels.iter().collect();
        for (&id, channel) in channels {
            let schema = channel.schema.as_ref().map(|schema| Schema::of(&schema.name, &schema.encoding, &schema.data));
            self.contents.take_channel(id, &channel.topic, &channel.message_encoding, schema.as_ref())?;
        }
        let mut counts = vec![TopicCount::default(); self.contents.topics.len()];
        for (channel, messages) in &stats.channel_message_counts {
            let Some(&topic) = self.contents.channels.get(channel) else { return Ok(Index::None) };
            counts[topic].add(*messages, at_ns(stats.message_start_time), at_ns(stats.message_end_time));
        }
        // counts are optional in the form
        let counted = counts.iter().fold(0_u64, |sum, count| sum.saturating_add(count.messages));
        Ok(if counted == stats.message_count && !counts.is_empty() { Index::Counts(counts) } else { Index::None })
    }
}

impl Schema {
    fn of(name: &str, encoding: &str, data: &[u8]) -> Self {
        let is_ros = matches!(encoding, "ros1msg" | "ros2msg");
        Self { name: name.into(), definition: is_ros.then(|| String::from_utf8_lossy(data).into_owned()) }
    }
}

fn damaged(problem: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("the bag is damaged: {problem}"))
}
