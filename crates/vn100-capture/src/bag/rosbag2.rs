//! Bags of ROS 2 in SQLite, `.db3`: a table of topics and one of messages, in schema versions 1 to
//! 4.

use std::{
    collections::BTreeMap,
    io::{self, Read, Seek},
};

use ruzstd::decoding::FrameDecoder;

use super::{
    sqlite::{Database, Row, SqlValue, SqliteTable, TableScan},
    topic::{BagFile, Encoding, MESSAGE_BYTES, MessageHead, Topic, TopicCount, TopicList},
};
use crate::{open_error::Problem, unpack::ZSTD_MAGIC, zstd_reader::ZstdReader};

pub(super) struct Rosbag2<R> {
    database: Database<R>,
    messages: MessageTable,
    scan: TableScan,
    row: Row,
    decoder: FrameDecoder,
    unpacked: Vec<u8>,
    topics: Vec<Topic>,
    places: BTreeMap<i64, usize>,
    /// The number of the last message: of a cut file, pages that are out of use may repeat earlier ones.
    last_id: Option<i64>,
}

struct MessageTable {
    root: u32,
    topic_id: usize,
    timestamp: usize,
    data: usize,
}

impl<R: Read + Seek> Rosbag2<R> {
    /// A bag before its first message; `None` if the database is no bag.
    pub(super) fn open(file: R) -> Result<Option<Self>, Problem> {
        let mut database = Database::open(file)?;
        let tables = database.tables()?;
        let table = |name: &str| tables.iter().find(|table| table.name == name);
        let Some((topics, messages)) = table("topics").zip(table("messages").and_then(MessageTable::of)) else {
            return Ok(None);
        };
        let mut list = TopicList::default();
        let definitions = match table("message_definitions") {
            Some(table) => definitions(&mut database, table, &mut list)?,
            None => BTreeMap::new(),
        };
        let places = read_topics(&mut database, topics, &definitions, &mut list)?;
        let scan = database.scan(messages.root);
        let (row, decoder, unpacked) = (Row::default(), FrameDecoder::new(), Vec::new());
        Ok(Some(Self { database, messages, scan, row, decoder, unpacked, topics: list.topics, places, last_id: None }))
    }
}

impl<R: Read + Seek + Send> BagFile for Rosbag2<R> {
    fn next_head(&mut self) -> io::Result<Option<MessageHead>> {
        while self.database.next_row(&mut self.scan, &mut self.row)? {
            let id = Some(self.row.id);
            if self.last_id < id
                && let Some(head) = self.messages.head(&self.row, &self.places)
            {
                self.last_id = id;
                return Ok(Some(head));
            }
        }
        Ok(None)
    }

    fn read_data(&mut self) -> io::Result<&[u8]> {
        self.database.complete(&mut self.row)?;
        let SqlValue::Blob(data) = self.row.field(self.messages.data) else { return Ok(&[]) };
        if !data.starts_with(ZSTD_MAGIC) {
            return Ok(data);
        }
        unpack(&mut self.decoder, data, &mut self.unpacked)?;
        Ok(&self.unpacked)
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn index(&mut self) -> io::Result<Option<Vec<Option<TopicCount>>>> {
        Ok(Some(vec![None; self.topics.len()]))
    }
}

/// Unpacks a message; only the beginning of a message that is too long.
fn unpack(decoder: &mut FrameDecoder, data: &[u8], unpacked: &mut Vec<u8>) -> io::Result<()> {
    unpacked.clear();
    ZstdReader::new(data, decoder).take(MESSAGE_BYTES as u64).read_to_end(unpacked)?;
    Ok(())
}

impl MessageTable {
    fn of(table: &SqliteTable) -> Option<Self> {
        let (topic_id, timestamp) = (table.column("topic_id")?, table.column("timestamp")?);
        Some(Self { topic_id, timestamp, data: table.column("data")?, root: table.root })
    }

    /// The head of a message; `None` for a row without a topic or a time.
    fn head(&self, row: &Row, places: &BTreeMap<i64, usize>) -> Option<MessageHead> {
        match (row.field(self.topic_id), row.field(self.timestamp)) {
            (SqlValue::Integer(topic), SqlValue::Integer(record_ns)) => {
                Some(MessageHead { topic: *places.get(&topic)?, record_ns })
            }
            _ => None,
        }
    }
}

/// The definitions, by the names of their types.
fn definitions<R: Read + Seek>(
    database: &mut Database<R>,
    table: &SqliteTable,
    topics: &mut TopicList,
) -> io::Result<BTreeMap<String, String>> {
    let places = (table.column("topic_type"), table.column("encoding"), table.column("encoded_message_definition"));
    let (Some(name), Some(encoding), Some(text)) = places else { return Ok(BTreeMap::new()) };
    let mut definitions = BTreeMap::new();
    database.each_row(table.root, |row| {
        if let [SqlValue::Text(name), SqlValue::Text(b"ros2msg"), SqlValue::Text(text)] =
            [name, encoding, text].map(|place| row.field(place))
        {
            definitions.insert(string(name), string(text));
            return topics.add_definition(name.len() + text.len());
        }
        Ok(())
    })?;
    Ok(definitions)
}

/// Lists the topics; returns their places by their numbers in the database.
fn read_topics<R: Read + Seek>(
    database: &mut Database<R>,
    table: &SqliteTable,
    definitions: &BTreeMap<String, String>,
    topics: &mut TopicList,
) -> io::Result<BTreeMap<i64, usize>> {
    let (Some(name), Some(type_name)) = (table.column("name"), table.column("type")) else {
        return Ok(BTreeMap::new());
    };
    let (id, encoding) = (table.column("id"), table.column("serialization_format"));
    let mut places = BTreeMap::new();
    database.each_row(table.root, |row| {
        let text = |place| if let SqlValue::Text(text) = row.field(place) { string(text) } else { String::new() };
        let type_name = text(type_name);
        let definition = definitions.get(&type_name).map(String::as_str);
        let encoding = Encoding::named(&encoding.map_or_else(|| "cdr".into(), text));
        let place = topics.place_of(Topic::new(&text(name), &type_name, encoding, definition))?;
        // a column that is the key is empty in the row; the row number is its value
        let id = match id.map(|place| row.field(place)) {
            Some(SqlValue::Integer(id)) => id,
            _ => row.id,
        };
        places.insert(id, place);
        Ok(())
    })?;
    Ok(places)
}

fn string(text: &[u8]) -> String {
    String::from_utf8_lossy(text).into_owned()
}

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    #[test]
    fn a_message_is_unpacked_with_any_claimed_length() {
        let mut decoder = FrameDecoder::new();
        let mut unpacked = Vec::new();
        let message = |bytes: usize| compress_to_vec(&*vec![7; bytes], CompressionLevel::Fastest);
        for bytes in [0, 300, MESSAGE_BYTES, MESSAGE_BYTES + 1] {
            unpack(&mut decoder, &message(bytes), &mut unpacked).unwrap();
            assert_eq!(unpacked.len(), bytes.min(MESSAGE_BYTES));
        }
        // a frame of one segment that claims 2^50 bytes and holds three in its last block
        let mut boasts = [ZSTD_MAGIC, &[0xe0], &(1_u64 << 50).to_le_bytes(), &[0x19, 0, 0], b"abc"].concat();
        assert!(unpack(&mut decoder, &boasts, &mut unpacked).is_err());
        // without a length it is complete: a window of one kilobyte instead
        boasts.splice(4..13, [0x00, 0x00]);
        unpack(&mut decoder, &boasts, &mut unpacked).unwrap();
        assert_eq!(unpacked, b"abc");
    }
}
