//! MCAP files of ROS; for the format see <https://mcap.dev/spec>.

use std::{
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Seek, SeekFrom},
};

use mcap::records::{Record, op};

use super::topic::{BagFile, Encoding, MESSAGE_BYTES, MessageHead, Topic, TopicCount, TopicList, damaged};
use crate::{
    mcap_records::{McapRecords, Next, parse_record},
    recording::at_ns,
};

/// Bytes of a message before its data: channel, number, and two times.
const MESSAGE_HEAD_BYTES: usize = 2 + 4 + 8 + 8;

pub(super) struct McapBag<R> {
    records: McapRecords<R>,
    contents: Contents,
}

/// The definitions of the records read so far.
#[derive(Default)]
struct Contents {
    /// The name of each schema, and its definition, if that is in the language of ROS.
    schemas: BTreeMap<u16, (String, Option<String>)>,
    /// The index of the topic of each channel.
    channels: BTreeMap<u16, usize>,
    topics: TopicList,
}

impl<R: Read + Seek> McapBag<R> {
    pub(super) fn open(mut file: R) -> io::Result<Self> {
        file.seek(SeekFrom::Start(0))?;
        let records = McapRecords::open(file)?.ok_or_else(|| damaged("it does not begin as an MCAP file"))?;
        Ok(Self { records, contents: Contents::default() })
    }
}

impl Contents {
    /// Takes a record; returns the head of the message if the record is a message.
    fn take(&mut self, opcode: u8, data: &[u8]) -> io::Result<Option<MessageHead>> {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(None);
        }
        match parse_record(opcode, data)? {
            Record::Schema { header, data } => {
                self.topics.add_definition(data.len())?;
                let is_ros = matches!(&*header.encoding, "ros1msg" | "ros2msg");
                let definition = is_ros.then(|| String::from_utf8_lossy(&data).into_owned());
                self.schemas.insert(header.id, (header.name, definition));
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id);
                let (type_name, definition) =
                    schema.map_or(("", None), |(name, definition)| (name, definition.as_deref()));
                let encoding = Encoding::named(&channel.message_encoding);
                let new = Topic::new(&channel.topic, type_name, encoding, definition);
                self.channels.insert(channel.id, self.topics.place_of(new)?);
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
        &self.contents.topics.topics
    }

    /// Reads the index from the summary at the end of the file, which is missing in a file that was cut.
    fn index(&mut self) -> io::Result<Option<Vec<Option<TopicCount>>>> {
        let Some(mut records) = McapRecords::open_summary(&mut self.records.file)? else { return Ok(None) };
        let mut statistics = None;
        loop {
            match records.advance()? {
                Next::Record(op::FOOTER) => break,
                Next::Record(opcode @ (op::SCHEMA | op::CHANNEL)) => drop(self.contents.take(opcode, records.data())?),
                Next::Record(op::STATISTICS) => {
                    if let Record::Statistics(found) = parse_record(op::STATISTICS, records.data())? {
                        statistics = Some(found);
                    }
                }
                Next::Record(_) => {}
                Next::End | Next::Cut => return Ok(None),
            }
        }
        let Some(stats) = statistics else { return Ok(None) };
        let mut counts = vec![TopicCount::default(); self.contents.topics.topics.len()];
        for (channel, messages) in &stats.channel_message_counts {
            let Some(&topic) = self.contents.channels.get(channel) else { return Ok(None) };
            counts[topic].add(*messages, at_ns(stats.message_start_time), at_ns(stats.message_end_time));
        }
        // counts are optional in the format
        let counted = counts.iter().fold(0_u64, |sum, count| sum.saturating_add(count.messages));
        let is_counted = counted == stats.message_count && !counts.is_empty();
        Ok(is_counted.then(|| counts.into_iter().map(Some).collect()))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::bag::topic::DEFINITION_BYTES;

    /// The index of a file without data whose summary has these records, and its topics.
    fn index(records: &[(u8, &[u8])]) -> io::Result<(bool, Vec<Topic>)> {
        let record = |opcode: u8, data: &[u8]| [&[opcode], &(data.len() as u64).to_le_bytes()[..], data].concat();
        let mut file = [mcap::MAGIC, &record(op::DATA_END, &[0; 4])].concat();
        let start = (file.len() as u64).to_le_bytes();
        records.iter().for_each(|(opcode, data)| file.extend(record(*opcode, data)));
        file.extend(record(op::FOOTER, &[&start[..], &[0; 12]].concat()));
        file.extend(mcap::MAGIC);
        let mut bag = McapBag::open(Cursor::new(file))?;
        Ok((bag.index()?.is_none(), bag.topics().to_vec()))
    }

    #[test]
    fn a_summary_is_read_without_trust() {
        let channel = b"\x01\0\0\0\x04\0\0\0/imu\x03\0\0\0cdr\0\0\0\0";
        let short: (u8, &[u8]) = (op::ATTACHMENT, b"\0\0\0");
        let (is_none, topics) = index(&[short, (op::CHANNEL, channel)]).unwrap();
        assert!(is_none && topics[0].name == "/imu", "without statistics");
        assert!(index(&[]).unwrap().0);
        let mut lying = *channel;
        lying[7] = 0xC0;
        assert!(index(&[(op::CHANNEL, &lying)]).is_err());
        let large = vec![0; DEFINITION_BYTES / 2 + 1];
        let schema = [&[1, 0, 0, 0, 0, 0, 0, 0, 0, 0], &(large.len() as u32).to_le_bytes()[..], &large].concat();
        assert!(index(&[(op::SCHEMA, &schema)]).is_ok());
        assert!(index(&[(op::SCHEMA, &schema), (op::SCHEMA, &schema)]).is_err());
    }
}
