//! Topics of a bag and their messages.

use std::{io, sync::Arc};

/// The longest message that is read. Those of sensors have some hundred bytes; images may have
/// more.
pub(super) const MESSAGE_BYTES: usize = 4 * 1024 * 1024;

const MOST_TOPICS: usize = 4096;

/// Most bytes of all definitions together.
pub(super) const DEFINITION_BYTES: usize = 16 * 1024 * 1024;

/// The head of a message; the data of the message are read on demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MessageHead {
    pub(super) topic: usize,
    /// When the message was recorded, in nanoseconds since 1970-01-01 UTC, or since the start of a
    /// simulation in simulated time.
    pub(super) record_ns: i64,
}

/// A file of a bag: its messages in the order they were written.
pub(crate) trait BagFile: Send {
    /// Goes to the next message; `None` at the end.
    fn next_head(&mut self) -> io::Result<Option<MessageHead>>;

    /// The bytes of the message that [`next_head`](Self::next_head) went to; may be called once per
    /// message.
    fn read_data(&mut self) -> io::Result<&[u8]>;

    /// The topics seen so far; one entry for each definition that messages of a topic have.
    fn topics(&self) -> &[Topic];

    /// The number of messages of each topic, if an index lists the topics and the file need not be
    /// read to its end; `None` for a topic that the index does not count. After this no message can
    /// be read.
    fn index(&mut self) -> io::Result<Option<Vec<Option<TopicCount>>>>;
}

/// The number of messages of a topic, and their first and last time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct TopicCount {
    pub(super) messages: u64,
    /// Times of the first and the last message, or of the parts of the file that contain them.
    pub(super) times_ns: Option<(i64, i64)>,
}

impl TopicCount {
    pub(super) fn add(&mut self, messages: u64, first_ns: i64, last_ns: i64) {
        if messages > 0 {
            self.messages = self.messages.saturating_add(messages);
            let (first, last) = self.times_ns.unwrap_or((first_ns, last_ns));
            self.times_ns = Some((first.min(first_ns), last.max(last_ns)));
        }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let mut both = *self;
        if let Some((first_ns, last_ns)) = other.times_ns {
            both.add(other.messages, first_ns, last_ns);
        }
        both
    }

    /// Mean number of messages per second; `None` if the times are not known or do not differ.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let (first_ns, last_ns) = self.times_ns?;
        let seconds = (last_ns as f64 - first_ns as f64) / 1e9;
        (self.messages > 1 && seconds > 0.0).then(|| (self.messages - 1) as f64 / seconds)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Topic {
    pub(crate) name: String,
    /// The type, as `package/Type`, without `msg` between them.
    pub(super) type_name: String,
    pub(super) encoding: Encoding,
    /// The definitions of the type and of the types it contains, as text; `None` if the bag has none.
    pub(super) definition: Option<Arc<str>>,
}

impl Topic {
    pub(super) fn new(name: &str, type_name: &str, encoding: Encoding, definition: Option<&str>) -> Self {
        let definition = definition.filter(|text| !text.trim().is_empty()).map(Arc::from);
        Self { name: name.into(), type_name: short_type(type_name), encoding, definition }
    }

    /// Whether this is the same topic in another file or another pass, even if the definition
    /// differs.
    pub(super) fn is(&self, other: &Self) -> bool {
        (&self.name, &self.type_name, &self.encoding) == (&other.name, &other.type_name, &other.encoding)
    }
}

/// The topics of a file, one for each definition that messages of a topic have.
#[derive(Default)]
pub(super) struct TopicList {
    pub(super) topics: Vec<Topic>,
    definition_bytes: usize,
}

impl TopicList {
    pub(super) fn add_definition(&mut self, bytes: usize) -> io::Result<()> {
        self.definition_bytes += bytes;
        self.check()
    }

    /// The place of a topic in the list; a new topic is added.
    pub(super) fn place_of(&mut self, topic: Topic) -> io::Result<usize> {
        let place = self.topics.iter().position(|other| *other == topic).unwrap_or_else(|| {
            self.topics.push(topic);
            self.topics.len() - 1
        });
        self.check().map(|()| place)
    }

    fn check(&self) -> io::Result<()> {
        let is_large = self.topics.len() > MOST_TOPICS || self.definition_bytes > DEFINITION_BYTES;
        if is_large { Err(damaged("it has more topics or definitions than any bag")) } else { Ok(()) }
    }
}

pub(super) fn damaged(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("the bag is damaged: {problem}"))
}

/// `package/msg/Type` as `package/Type`.
pub(super) fn short_type(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// How numbers are encoded in the messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// One after the other, little-endian.
    Ros1,
    /// CDR of the Data Distribution Service: the offset of each number is a multiple of its length.
    Cdr,
    Other(String),
}

impl Encoding {
    pub(super) fn named(name: &str) -> Self {
        match name {
            "ros1" => Self::Ros1,
            "cdr" => Self::Cdr,
            other => Self::Other(other.into()),
        }
    }
}
