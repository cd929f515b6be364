//! MCAP files of ROS, with any compression of their chunks.

use std::{
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Seek, SeekFrom},
};

use mcap::{
    McapError, Summary,
    records::{Record, op},
    sans_io::{
        linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
        summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions},
    },
};

use super::topic::{BagFile, Encoding, Index, MessageHead, Topic, TopicCount};
use crate::recording::{at_ns, io_error};

/// Bytes of one read of the file.
const READ_BYTES: usize = 64 * 1024;

/// Longest record that is read: a chunk, unpacked or not.
const RECORD_BYTES: usize = 64 * 1024 * 1024;

/// The messages of a file in the order they were written.
pub(super) struct McapBag<R> {
    file: R,
    records: LinearReader,
    schemas: BTreeMap<u16, Schema>,
    /// The place of the topic of each channel.
    channels: BTreeMap<u16, usize>,
    topics: Vec<Topic>,
    data: Vec<u8>,
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
        let options = LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(RECORD_BYTES);
        Ok(Self {
            file,
            records: LinearReader::new_with_options(options),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            topics: Vec::new(),
            data: Vec::new(),
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

    fn take_channel(&mut self, id: u16, name: &str, encoding: &str, schema: Option<&Schema>) {
        let (type_name, definition) = schema.map_or(("", None), |schema| (&schema.name, schema.definition.as_deref()));
        let new = Topic::new(name, type_name, Encoding::named(encoding), definition);
        let same = |topic: &Topic| topic.name == new.name && topic.type_name == new.type_name;
        let place = self.topics.iter().position(same).unwrap_or_else(|| {
            self.topics.push(new);
            self.topics.len() - 1
        });
        self.channels.insert(id, place);
    }
}

impl<R: Read + Seek + Send> BagFile for McapBag<R> {
    fn next_head(&mut self) -> io::Result<Option<MessageHead>> {
        loop {
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
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                        continue;
                    }
                    match mcap::parse_record(opcode, data).map_err(io_error)? {
                        Record::Schema { header, data } => {
                            self.schemas.insert(header.id, Schema::of(&header.name, &header.encoding, &data));
                        }
                        Record::Channel(channel) => {
                            let schema = self.schemas.remove(&channel.schema_id);
                            self.take_channel(channel.id, &channel.topic, &channel.message_encoding, schema.as_ref());
                            self.schemas.extend(schema.map(|schema| (channel.schema_id, schema)));
                        }
                        Record::Message { header, data } => {
                            let Some(&topic) = self.channels.get(&header.channel_id) else {
                                return Err(damaged("a message comes before its channel"));
                            };
                            self.data.clear();
                            self.data.extend_from_slice(&data);
                            let record_ns = at_ns(header.log_time);
                            return Ok(Some(MessageHead { topic, record_ns }));
                        }
                        _ => {}
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
        Ok(&self.data)
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// From the summary at its end, which a file lacks that was cut.
    fn index(&mut self) -> io::Result<Index> {
        let Some(summary) = self.summary() else { return Ok(Index::None) };
        let Some(stats) = &summary.stats else { return Ok(Index::None) };
        let channels: BTreeMap<_, _> = summary.channels.iter().collect();
        for (&id, channel) in channels {
            let schema = channel.schema.as_ref().map(|schema| Schema::of(&schema.name, &schema.encoding, &schema.data));
            self.take_channel(id, &channel.topic, &channel.message_encoding, schema.as_ref());
        }
        let mut counts = vec![TopicCount::default(); self.topics.len()];
        for (channel, messages) in &stats.channel_message_counts {
            let Some(&topic) = self.channels.get(channel) else { return Ok(Index::None) };
            counts[topic].add(*messages, at_ns(stats.message_start_time), at_ns(stats.message_end_time));
        }
        Ok(Index::Counts(counts))
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
