//! MCAP files of ROS; for the format see <https://mcap.dev/spec>.

use std::{
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Seek, SeekFrom},
};

use mcap::{
    Summary,
    records::{Record, op},
    sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions},
};

use super::shared_file::SharedFile;
use super::topic::{
    BagFile, DEFINITION_BYTES, Encoding, Index, MESSAGE_BYTES, MOST_TOPICS, MessageHead, Topic, TopicCount,
};
use crate::{
    mcap_records::{McapRecords, Next, RECORD_BYTES},
    recording::{at_ns, io_error},
};

/// Bytes of a message before its data: channel, number, and two times.
const MESSAGE_HEAD_BYTES: usize = 2 + 4 + 8 + 8;

/// The messages of a file in the order they were written.
pub(super) struct McapBag<R> {
    records: McapRecords<R>,
    contents: Contents,
}

/// What the records so far define.
#[derive(Default)]
struct Contents {
    schemas: BTreeMap<u16, Schema>,
    /// The place of the topic, for each channel.
    channels: BTreeMap<u16, usize>,
    topics: Vec<Topic>,
    definition_bytes: usize,
}

struct Schema {
    name: String,
    /// The definition, where it is in the language of ROS.
    definition: Option<String>,
}

impl<R: Read + Seek> McapBag<R> {
    /// Opens a file at its first byte.
    pub(super) fn open(mut file: R) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let records = McapRecords::open(file)?.ok_or_else(|| damaged("it does not begin as an MCAP file"))?;
        Ok(Self { records, contents: Contents::default() })
    }

    fn summary(&mut self) -> Option<Summary> {
        let file = &mut self.records.file;
        let size = file.seek(SeekFrom::End(0)).ok()?;
        let options = SummaryReaderOptions::default().with_file_size(size).with_record_length_limit(RECORD_BYTES);
        let mut reader = SummaryReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event.ok()? {
                SummaryReadEvent::ReadRequest(bytes) => {
                    let read = file.read(reader.insert(bytes.min(RECORD_BYTES))).ok()?;
                    reader.notify_read(read);
                }
                SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to).ok()?),
            }
        }
        reader.finish()
    }
}

impl McapBag<SharedFile> {
    /// Bytes read of the file.
    pub(super) const fn position(&self) -> u64 {
        self.records.file.position()
    }
}

impl Contents {
    /// Takes a record; returns the head of the message where the record is one.
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
        let place = self.topics.iter().position(|topic| *topic == new).unwrap_or_else(|| {
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

impl<R: Read + Seek + Send> BagFile for McapBag<R> {
    fn next_head(&mut self) -> io::Result<Option<MessageHead>> {
        loop {
            match self.records.advance()? {
                Next::Record(opcode) => {
                    if let Some(head) = self.contents.take(opcode, self.records.data())? {
                        return Ok(Some(head));
                    }
                }
                Next::End => return Ok(None),
                Next::Cut => {
                    let problem = "the bag was cut: it ends before its summary";
                    return Err(io::Error::new(ErrorKind::UnexpectedEof, problem));
                }
            }
        }
    }

    fn read_data(&mut self) -> io::Result<&[u8]> {
        let data = self.records.data().get(MESSAGE_HEAD_BYTES..).unwrap_or_default();
        Ok(if data.len() <= MESSAGE_BYTES { data } else { &[] })
    }

    fn topics(&self) -> &[Topic] {
        &self.contents.topics
    }

    /// From the summary at the end of the file, which a file that was cut does not have.
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
        // counts are optional in the format
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
