//! Topics of a bag, their messages, and why a bag cannot be read.

use std::{fmt, io, path::PathBuf, sync::Arc};

/// Longest message that is read. Those of sensors have some hundred bytes; images may have more.
pub(super) const MESSAGE_BYTES: usize = 4 * 1024 * 1024;

/// More topics than any bag has.
pub(super) const MOST_TOPICS: usize = 4096;

/// Most bytes of all definitions together.
pub(super) const DEFINITION_BYTES: usize = 16 * 1024 * 1024;

/// Where a message belongs; its bytes are read if they are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MessageHead {
    /// The place of its topic.
    pub(super) topic: usize,
    /// When it was recorded, in nanoseconds since 1970-01-01 UTC, or by simulated time since its
    /// start.
    pub(super) record_ns: i64,
}

/// A file of a bag: its messages in the order they were written.
pub(crate) trait BagFile: Send {
    /// Goes to the next message; `None` at the end.
    fn next_head(&mut self) -> io::Result<Option<MessageHead>>;

    /// The bytes of that message; once for each.
    fn read_data(&mut self) -> io::Result<&[u8]>;

    /// The topics seen so far; one for each definition that its messages have.
    fn topics(&self) -> &[Topic];

    /// The topics, where an index lists them and the file need not be read whole. No message can be
    /// read then.
    fn index(&mut self) -> io::Result<Index>;
}

/// What an index shows.
pub(crate) enum Index {
    /// Nothing: there is none.
    None,
    /// The topics alone.
    Topics,
    /// The topics, and how many messages each has.
    Counts(Vec<TopicCount>),
}

/// How many messages a topic has, and from when to when.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct TopicCount {
    pub(super) messages: u64,
    /// Of the first and the last, or of the parts of the file that hold them.
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

    /// Of both together.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let mut both = *self;
        if let Some((first_ns, last_ns)) = other.times_ns {
            both.add(other.messages, first_ns, last_ns);
        }
        both
    }

    /// Messages in a second, on average.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let (first_ns, last_ns) = self.times_ns?;
        let seconds = (last_ns as f64 - first_ns as f64) / 1e9;
        (self.messages > 1 && seconds > 0.0).then(|| (self.messages - 1) as f64 / seconds)
    }
}

/// What the messages of a topic are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Topic {
    pub(crate) name: String,
    /// As `package/Type`, without `msg` between them.
    pub(super) type_name: String,
    pub(super) encoding: Encoding,
    /// The definition of the type and those it is made of, as text; `None` where the bag has none.
    pub(super) definition: Option<Arc<str>>,
}

impl Topic {
    pub(super) fn new(name: &str, type_name: &str, encoding: Encoding, definition: Option<&str>) -> Self {
        let definition = definition.filter(|text| !text.trim().is_empty()).map(Arc::from);
        Self { name: name.into(), type_name: short_type(type_name), encoding, definition }
    }

    /// Whether it is the same in another file, or in another pass. Its messages may be of another
    /// definition there, as in bags that were merged.
    pub(super) fn is(&self, other: &Self) -> bool {
        (&self.name, &self.type_name, &self.encoding) == (&other.name, &other.type_name, &other.encoding)
    }
}

/// `package/msg/Type` as `package/Type`.
pub(super) fn short_type(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// How numbers stand in the messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// One behind the other, the lowest byte first.
    Ros1,
    /// CDR of the Data Distribution Service: each at a multiple of its size.
    Cdr,
    /// Another, by its name.
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

/// A topic, as a user chooses from.
#[derive(Debug, Clone, PartialEq)]
pub struct TopicSummary {
    /// Its name.
    pub name: String,
    /// The type of its messages, as `package/Type`.
    pub type_name: String,
    /// How many messages it has.
    pub messages: u64,
    /// How many there are in a second, on average; `None` for fewer than two, or of one time.
    pub rate_hz: Option<f64>,
}

impl fmt::Display for TopicSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, type_name, messages, rate_hz } = self;
        let plural = if *messages == 1 { "" } else { "s" };
        write!(f, "{name:.80} ({type_name:.80}, {messages} message{plural}")?;
        match rate_hz {
            Some(hz) => write!(f, ", {hz:.4} Hz)"),
            None => f.write_str(")"),
        }
    }
}

/// Why a bag cannot be read, or nothing of a sensor be taken from it.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The file could not be read, or is damaged.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A database of another program.
    #[error("it is an SQLite database without the tables of rosbag2 (topics, messages): export its table as CSV")]
    OtherDatabase,
    /// No message in it.
    #[error("it is {form} without a message{}", if topics.is_empty() { String::new() } else { format!(". Its topics:{}", lines(topics)) })]
    Empty {
        /// What the file is.
        form: &'static str,
        /// Its topics.
        topics: Vec<TopicSummary>,
    },
    /// No topic holds sentences, or numbers of a sensor.
    #[error(
        "it is {form} in which no topic has VectorNav sentences or messages of an inertial sensor. It holds:{}",
        lines(topics)
    )]
    NoSensor {
        /// What the file is.
        form: &'static str,
        /// What it holds.
        topics: Vec<TopicSummary>,
    },
    /// More than one topic may be meant.
    #[error("it is {form} with several topics that may be meant:{}", lines(topics))]
    SeveralTopics {
        /// What the file is.
        form: &'static str,
        /// Those that may be meant.
        topics: Vec<TopicSummary>,
    },
    /// No topic has the numbers that were asked for.
    #[error("no topic has the numbers {}. It holds:{}", paths.join(", "), lines(topics))]
    NoTopicWithFields {
        /// Their paths.
        paths: Vec<String>,
        /// What it holds.
        topics: Vec<TopicSummary>,
    },
    /// A topic that was asked for is not there.
    #[error("it has no topic {name:?}. It holds:{}", lines(topics))]
    NoTopic {
        /// What was asked for.
        name: String,
        /// What it holds.
        topics: Vec<TopicSummary>,
    },
    /// The messages of the topic have no known form.
    #[error(
        "the bag does not say how messages of topic {topic:?} are built, and {type_name} is no standard type: convert the \
         bag where that package is installed (`ros2 bag convert` to MCAP), or record a topic of sensor_msgs/Imu"
    )]
    NoDefinition {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
    },
    /// The messages of the topic hold nothing of a sensor.
    #[error(
        "messages of topic {topic:?} ({type_name}) hold neither VectorNav sentences nor a message of an inertial sensor; \
         their numbers are: {}",
        fields.join(", ")
    )]
    NotOfSensor {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// Paths of their numbers.
        fields: Vec<String>,
    },
    /// All numbers of a sensor are zero, as those are that it does not have.
    #[error(
        "messages of topic {topic:?} ({type_name}) have {}, and all of it is zero in the first {messages} messages: is the \
         sensor read? Name their numbers as columns if they are not zero later",
        paths.join(", ")
    )]
    OnlyZero {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// Messages that were looked at.
        messages: usize,
        /// What is zero.
        paths: Vec<String>,
    },
    /// A field that was asked for is not there.
    #[error(
        "messages of topic {topic:?} ({type_name}) have no number {path:?}; they have {}",
        fields.join(", ")
    )]
    NoField {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// What was asked for.
        path: String,
        /// Paths of their numbers.
        fields: Vec<String>,
    },
    /// A time that was asked for is not there.
    #[error(
        "messages of topic {topic:?} ({type_name}) have no time {path:?}; {}",
        if times.is_empty() { "they have none".into() } else { format!("they have {}", times.join(", ")) }
    )]
    NoTime {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// What was asked for.
        path: String,
        /// Paths of their times.
        times: Vec<String>,
    },
    /// A number that shall be read as a date or a time of day.
    #[error("{path:?} in messages of topic {topic:?} is a number, and no date: say whether it is in s, ms, us or ns")]
    TimeAsText {
        /// The topic.
        topic: String,
        /// What was asked for.
        path: String,
    },
    /// Messages of one topic by definitions of which one does not fit.
    #[error(
        "topic {topic:?} has messages by several definitions of {type_name}, as in bags that were merged, and one of \
         them cannot be used: {problem}. Read the bags one by one"
    )]
    OtherDefinition {
        /// The topic.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A definition that cannot be used.
    #[error("the definition of {type_name} cannot be used: {problem}")]
    Definition {
        /// The type.
        type_name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A database whose last messages are in another file.
    #[error(
        "its last messages are still in {}, as its recorder did not end: open and close it once, as `sqlite3 {} \
         'PRAGMA wal_checkpoint(TRUNCATE)'` does",
        log.display(),
        database.display()
    )]
    PendingWrites {
        /// The database.
        database: PathBuf,
        /// The file beside it.
        log: PathBuf,
    },
    /// A folder that is no bag.
    #[error("it is a folder without files of a bag (metadata.yaml, *.db3, *.mcap): name the captures in it")]
    NotABagFolder,
    /// A folder of files of several forms.
    #[error("{} is not of the same form as the other files of the bag", path.display())]
    OtherFile {
        /// The file.
        path: PathBuf,
    },
    /// More than a temporary file may take.
    #[error("unpacked it is larger than {most_bytes} bytes, which is as much as is kept: unpack it to a file first")]
    TooLarge {
        /// The limit in bytes.
        most_bytes: u64,
    },
}

fn lines(topics: &[TopicSummary]) -> String {
    const LISTED: usize = 40;
    let listed: String = topics.iter().take(LISTED).map(|topic| format!("\n  {topic}")).collect();
    match topics.len() {
        0 => " no topic".into(),
        count if count > LISTED => format!("{listed}\n  and {} more", count - LISTED),
        _ => listed,
    }
}
