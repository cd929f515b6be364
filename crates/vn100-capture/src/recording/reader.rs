//! Reads a recording, up to its end or to the place where it was cut.

use std::{
    collections::{BTreeMap, VecDeque},
    fs::{self, File},
    io::{self, ErrorKind, Read},
    path::Path,
    sync::{Arc, OnceLock},
};

use bytes::Bytes;
use mcap::records::{Channel, Metadata, Record, op};

use super::{
    BYTES_TOPIC, CALLER_METADATA, END_METADATA, FORMAT, FORMAT_1, LINK_TOPIC, READS_TOPIC, RECORDING_METADATA, RESUMED,
    UNSTAMPED, at_ns, link_from_json,
    part::{PART_METADATA, RecordingPart},
    reads::reads_of,
};
use crate::{
    mcap_records::{McapRecords, Next, parse_record},
    unpack::{KnownBy, unpacked_stored},
};
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, StreamInput};

/// Bytes of a file that are searched for a topic of recordings: a tool that merges files may put
/// much before it.
const SEARCHED_BYTES: usize = 64 * 1024 * 1024;

/// A recording among the files of an archive.
pub(super) const IN_ARCHIVE: KnownBy =
    KnownBy { ending: |ending| ending.eq_ignore_ascii_case("mcap"), beginning: |_, _| false };

/// The metadata of a recording.
#[derive(Debug, Clone, Default)]
pub struct Recorded {
    /// Time of the first input in nanoseconds since 1970-01-01 UTC; `None` if the recording has no
    /// input.
    pub started_ns: Option<i64>,
    /// The program that wrote the recording, such as `vn100 1.0.0`; `None` if the file does not
    /// name it.
    pub program: Option<String>,
    /// The metadata that the caller of the recorder gave.
    pub metadata: BTreeMap<String, String>,
    /// Whether the recording was resumed: the length in `metadata` is then that of the first part
    /// alone.
    pub resumed: bool,
    /// The part of a recording that the file is; `None` for an undivided recording and for joined
    /// parts.
    pub part: Option<RecordingPart>,
    /// The end of the recording; set when it is read to its end.
    pub end: Arc<OnceLock<RecordingEnd>>,
}

impl Recorded {
    /// Whether it ends when its one measurement did: a resumed recording has the limits of the
    /// measurement before the break, and a part does not end at the end of the whole.
    pub fn is_one_measurement(&self) -> bool {
        !self.resumed && self.part.is_none()
    }
}

/// The end of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingEnd {
    /// Time of the last input in nanoseconds since 1970-01-01 UTC; `None` if the recording has no
    /// input.
    pub ended_ns: Option<i64>,
    /// Whether the file was finished, and no part before it is missing or cut; a loss of power, for
    /// example, leaves a cut file.
    pub complete: bool,
    /// The reason of the end, in words; `None` if the file does not contain it.
    pub reason: Option<String>,
}

impl RecordingEnd {
    /// The event with which a resumed recording continues; `None` if the recording has no earlier
    /// input, because nothing was interrupted.
    pub(super) fn interruption(&self) -> Option<LinkEvent> {
        let cause = match &self.reason {
            Some(reason) => format!("recording ended ({reason}) and resumed"),
            None => "recording interrupted".into(),
        };
        Some(LinkEvent { at_ns: self.ended_ns?, kind: LinkEventKind::Down { cause } })
    }
}

/// The reason why a file is no recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file could not be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is not MCAP.
    #[error("it is no MCAP file")]
    NotMcap,
    /// The file was cut before its first topic.
    #[error("it was cut before it began")]
    NotBegun,
    /// The MCAP file is that of another program, with these topics.
    #[error("it is an MCAP file without the topic {BYTES_TOPIC}; it has {}", list(.0))]
    Foreign(Vec<String>),
    /// Another program has added these topics to the recording, which a copy would lose.
    #[error("it also holds what this program did not record: {}", list(.0))]
    Mixed(Vec<String>),
    /// The times of the recording count from zero, as for an emulated sensor; times of a clock
    /// cannot continue them.
    #[error("its times count from zero, as in a capture by `vn100 sim`, and are no dates: record to a new file")]
    Undated,
    /// This program does not know the form of the recording.
    #[error(
        "it has the form \"{0}\", and this program reads the form \"{FORMAT}\": use the program that made it, or a newer one"
    )]
    Format(String),
}

/// The content of a recording, in the order of writing.
pub(super) enum Entry {
    Input(StreamInput),
    Metadata(Metadata),
}

/// The [`StreamInput`]s of a recording, in order.
///
/// Memory is bounded for recordings of any length.
pub struct RecordingReader<R> {
    records: McapRecords<R>,
    /// The content of each channel of a recording.
    carries: BTreeMap<u16, Carries>,
    other_topics: BTreeMap<u16, String>,
    /// Bytes of records before the first topic of recordings.
    searched_bytes: usize,
    /// All metadata before the first input.
    pub(super) head: Vec<Metadata>,
    /// Entries of the last record that were not returned yet.
    due: VecDeque<Entry>,
    /// The time of the last input that was returned.
    last_ns: Option<i64>,
    /// The reason in the end mark after the last input.
    reason: Option<String>,
    recorded: Recorded,
    done: bool,
}

/// The content of a channel of a recording.
#[derive(Debug, Clone, Copy)]
enum Carries {
    Bytes { stamped: bool },
    Reads,
    Link,
}

impl<R: Read> RecordingReader<R> {
    /// Reads up to the first input. A file that was cut before its first topic counts as a
    /// recording without inputs.
    ///
    /// # Errors
    /// [`RecordingError`] if the file is no recording, or cannot be read.
    pub fn open(reader: R) -> Result<Self, RecordingError> {
        let mut new = Self {
            records: McapRecords::open(reader)?.ok_or(RecordingError::NotMcap)?,
            carries: BTreeMap::new(),
            other_topics: BTreeMap::new(),
            searched_bytes: 0,
            head: Vec::new(),
            due: VecDeque::new(),
            last_ns: None,
            reason: None,
            recorded: Recorded::default(),
            done: false,
        };
        while new.fill()? {
            match new.due.pop_front() {
                Some(Entry::Metadata(metadata)) => new.take_head(metadata)?,
                Some(Entry::Input(input)) => {
                    new.recorded.started_ns = time_of(&input);
                    new.due.push_front(Entry::Input(input));
                    break;
                }
                None => {}
            }
        }
        if let Some(part) = &mut new.recorded.part {
            part.resumed = new.recorded.resumed;
        }
        let cut = new.recorded.end.get().is_some_and(|end| !end.complete);
        if new.carries.is_empty() && !(cut && new.other_topics.is_empty()) {
            return Err(RecordingError::Foreign(new.other_topics()));
        }
        Ok(new)
    }

    /// The metadata of the recording.
    pub fn recorded(&self) -> &Recorded {
        &self.recorded
    }

    /// The next input; `None` at the end of the recording, which [`RecordingReader::recorded`] then
    /// describes.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged. No input follows; earlier inputs are valid.
    pub fn next_input(&mut self) -> io::Result<Option<StreamInput>> {
        while let Some(entry) = self.next_entry()? {
            if let Entry::Input(input) = entry {
                return Ok(Some(input));
            }
        }
        Ok(None)
    }

    /// Whether a topic of recordings was read.
    pub(super) fn has_our_topics(&self) -> bool {
        !self.carries.is_empty()
    }

    /// The topics of other programs, as far as the file was read.
    pub(super) fn other_topics(&self) -> Vec<String> {
        self.other_topics.values().cloned().collect()
    }

    /// The next entry; `None` at the end.
    pub(super) fn next_entry(&mut self) -> io::Result<Option<Entry>> {
        if !self.fill()? {
            return Ok(None);
        }
        let entry = self.due.pop_front();
        if let Some(Entry::Input(input)) = &entry {
            self.last_ns = time_of(input).or(self.last_ns);
        }
        Ok(entry)
    }

    /// Reads until an entry is due; `false` at the end.
    fn fill(&mut self) -> io::Result<bool> {
        while self.due.is_empty() && !self.done {
            // nothing is read after an error
            self.done = true;
            match self.records.advance()? {
                Next::Record(opcode) => {
                    self.take(opcode)?;
                    self.done = self.searched_bytes > SEARCHED_BYTES;
                }
                end => {
                    let (ended_ns, reason) = (self.last_ns, self.reason.take());
                    let end = RecordingEnd { ended_ns, complete: end == Next::End, reason };
                    self.recorded.end.get_or_init(|| end);
                }
            }
        }
        Ok(!self.due.is_empty())
    }

    /// Takes the content of a record.
    fn take(&mut self, opcode: u8) -> io::Result<()> {
        let data = self.records.data();
        if self.carries.is_empty() {
            self.searched_bytes += data.len();
        }
        if !matches!(opcode, op::CHANNEL | op::MESSAGE | op::METADATA) {
            return Ok(());
        }
        match parse_record(opcode, data)? {
            Record::Channel(channel) => match Carries::of(&channel) {
                Some(carries) => _ = self.carries.insert(channel.id, carries),
                None => _ = self.other_topics.insert(channel.id, channel.topic),
            },
            Record::Metadata(metadata) => {
                if metadata.name == END_METADATA {
                    self.reason = metadata.metadata.get("reason").cloned();
                }
                self.due.push_back(Entry::Metadata(metadata));
            }
            Record::Message { header, data } => {
                let carries = self.carries.get(&header.channel_id).filter(|_| !data.is_empty());
                let Some(carries) = carries else { return Ok(()) };
                let inputs = carries.inputs(at_ns(header.log_time), data.into_owned())?;
                self.due.extend(inputs.into_iter().map(Entry::Input));
                self.reason = None;
            }
            _ => {}
        }
        Ok(())
    }

    fn take_head(&mut self, metadata: Metadata) -> Result<(), RecordingError> {
        let values = &metadata.metadata;
        match &*metadata.name {
            RECORDING_METADATA => {
                let is_other = |format: &&String| ![FORMAT, FORMAT_1].contains(&format.as_str());
                if let Some(found) = values.get("format").filter(is_other) {
                    return Err(RecordingError::Format(found.clone()));
                }
                self.recorded.program = values.get("program").cloned();
                self.recorded.resumed = values.contains_key(RESUMED);
            }
            CALLER_METADATA => self.recorded.metadata = values.clone(),
            PART_METADATA => self.recorded.part = RecordingPart::from_metadata(values),
            _ => {}
        }
        self.head.push(metadata);
        Ok(())
    }
}

impl RecordingPart {
    /// The part that a file is; `None` if it is no part of a recording. A pipe or a device can be
    /// read only once, and is not read for this.
    pub fn of(path: &Path) -> Option<Self> {
        if !fs::metadata(path).ok()?.is_file() {
            return None;
        }
        let reader = unpacked_stored(&File::open(path).ok()?, |file| file, IN_ARCHIVE).ok()?;
        RecordingReader::open(reader).ok()?.recorded().part.clone()
    }
}

impl Carries {
    /// The content of a channel; `None` for a topic of another program.
    fn of(channel: &Channel) -> Option<Self> {
        let is_unstamped = channel.metadata.get(UNSTAMPED.0).is_some_and(|arrival| arrival == UNSTAMPED.1);
        match &*channel.topic {
            BYTES_TOPIC => Some(Self::Bytes { stamped: !is_unstamped }),
            READS_TOPIC => Some(Self::Reads),
            LINK_TOPIC => Some(Self::Link),
            _ => None,
        }
    }

    fn inputs(self, at_ns: i64, data: Vec<u8>) -> io::Result<Vec<StreamInput>> {
        let damaged = |problem: String| io::Error::new(ErrorKind::InvalidData, problem);
        Ok(match self {
            Self::Bytes { stamped } => {
                vec![Chunk { bytes: data.into(), at_ns: stamped.then_some(at_ns) }.into()]
            }
            Self::Reads => {
                let problem = || damaged(format!("a message on {READS_TOPIC} does not hold the reads that it lists"));
                let reads = reads_of(at_ns, &data).ok_or_else(problem)?;
                let data = Bytes::from(data);
                let reads = reads.into_iter().filter(|(_, place)| !place.is_empty());
                reads.map(|(at_ns, place)| Chunk { bytes: data.slice(place), at_ns: Some(at_ns) }.into()).collect()
            }
            Self::Link => vec![StreamInput::Link(link_from_json(at_ns, &data).ok_or_else(|| {
                let text = String::from_utf8_lossy(&data);
                damaged(format!("a message on {LINK_TOPIC} is no event of a link: {text:.200}"))
            })?)],
        })
    }
}

const fn time_of(input: &StreamInput) -> Option<i64> {
    match input {
        StreamInput::Chunk(chunk) => chunk.at_ns,
        StreamInput::Link(event) => Some(event.at_ns),
    }
}

/// Some names in words, with a bounded length for any content of the file.
fn list(topics: &[String]) -> String {
    const NAMED: usize = 8;
    let named: Vec<String> = topics.iter().take(NAMED).map(|topic| format!("{topic:.60}")).collect();
    match topics.len() {
        0 => "no topic".into(),
        count if count <= NAMED => named.join(", "),
        count => format!("{} and {} more", named.join(", "), count - NAMED),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_names_eight_topics_and_counts_the_others() {
        let topics = |count: usize| (1..=count).map(|number| number.to_string()).collect::<Vec<_>>();
        assert_eq!(list(&topics(0)), "no topic");
        assert_eq!(list(&topics(8)), "1, 2, 3, 4, 5, 6, 7, 8");
        assert_eq!(list(&topics(10)), "1, 2, 3, 4, 5, 6, 7, 8 and 2 more");
        assert_eq!(list(&["a".repeat(100)]), "a".repeat(60));
    }
}
