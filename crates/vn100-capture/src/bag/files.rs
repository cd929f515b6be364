//! The files of a bag, one after the other.

use std::{
    io::{self, Read},
    sync::{Arc, atomic::AtomicU64},
};

use super::{
    mcap::McapBag,
    ros1::{self, Ros1Bag},
    rosbag2::Rosbag2,
    sqlite,
    topic::{BagFile, MessageHead, Topic, TopicCount},
};
use crate::{
    counted_reader::CountedReader,
    open_error::Problem,
    recording::{self, RecordingError, RecordingReader},
    stored_file::StoredFile,
};

/// The form of a bag of ROS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BagForm {
    /// ROS 1, `.bag`.
    Ros1,
    /// ROS 2, in an SQLite database, `.db3`.
    Db3,
    /// ROS 2 or ROS 1 in an MCAP file, `.mcap`.
    Mcap,
}

/// The forms in their order, each with the first bytes of its files, the ending of their names, its
/// code in results, and what it is in words.
const FORMS: [(BagForm, &[u8], &str, &str, &str); 3] = [
    (BagForm::Ros1, ros1::MAGIC, "bag", "ros1-bag", "a ROS 1 bag"),
    (BagForm::Db3, sqlite::MAGIC, "db3", "rosbag2", "a rosbag2 database"),
    (BagForm::Mcap, recording::MAGIC, "mcap", "mcap", "an MCAP file"),
];

impl BagForm {
    /// The form of a file by its first bytes; `None` for any other file.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        FORMS.iter().find(|(_, magic, ..)| head.starts_with(magic)).map(|(form, ..)| *form)
    }

    /// Whether files of bags have names with this ending.
    pub(crate) fn is_ending(ending: &str) -> bool {
        FORMS.iter().any(|(_, _, known, ..)| ending == *known)
    }

    /// The code of the form in results.
    pub const fn code(self) -> &'static str {
        FORMS[self as usize].3
    }

    pub(super) const fn words(self) -> &'static str {
        FORMS[self as usize].4
    }
}

/// Whether an MCAP file is no recording of this program. A recording may have been cut before its
/// first topic.
pub(crate) fn is_foreign_mcap(file: &dyn StoredFile) -> io::Result<bool> {
    let mut head = Vec::new();
    file.open()?.take(recording::HEAD_BYTES).read_to_end(&mut head)?;
    let is_recording = || match RecordingReader::open(file.open()?) {
        Ok(_) | Err(RecordingError::Format(_)) => Ok::<_, io::Error>(true),
        Err(_) => Ok(false),
    };
    Ok(!recording::is_ours(&head) && !is_recording()?)
}

/// A bag: its files in order of time.
#[derive(Debug)]
pub(crate) struct Bag {
    pub(crate) form: BagForm,
    pub(super) files: Vec<Box<dyn StoredFile>>,
    /// Bytes in temporary files if the bag was compressed or came as a stream; else 0.
    pub(crate) unpacked_bytes: u64,
    /// The error that ended the unpacking early.
    pub(super) unpack_error: Option<io::Error>,
}

impl Bag {
    pub(crate) fn new(form: BagForm, files: Vec<Box<dyn StoredFile>>) -> Self {
        Self { form, files, unpacked_bytes: 0, unpack_error: None }
    }

    /// All messages, beginning with the first; `read` counts the bytes that are read from the files.
    pub(super) fn messages(&self, read: &Arc<AtomicU64>) -> Result<Messages, Problem> {
        let files = self.files.iter().map(|file| open(self.form, &**file, read)).collect::<Result<Vec<_>, _>>()?;
        Ok(Messages { files, current: 0, places: Vec::new() })
    }

    /// The topics of the bag, each with its number of messages if the index contains it or
    /// `counted` asks for it.
    pub(super) fn topics(&self, counted: bool) -> Result<Vec<(Topic, Option<TopicCount>)>, Problem> {
        let mut all: Vec<(Topic, Option<TopicCount>)> = Vec::new();
        let mut add = |topic: &Topic, count: Option<TopicCount>| match all.iter_mut().find(|(other, _)| other.is(topic))
        {
            Some((_, so_far)) => *so_far = so_far.zip(count).map(|(so_far, count)| so_far.plus(&count)),
            None => all.push((topic.clone(), count)),
        };
        let unseen = Arc::default();
        for file in &self.files {
            let mut messages = open(self.form, &**file, &unseen)?;
            // a damaged index is treated as none
            let index = messages.index().unwrap_or_default();
            let counts = match index.filter(|counts| !counted || counts.iter().all(Option::is_some)) {
                Some(counts) => counts,
                None => {
                    messages = open(self.form, &**file, &unseen)?;
                    let mut counts: Vec<TopicCount> = Vec::new();
                    // messages before a damaged place or a cut are counted
                    while let Ok(Some(MessageHead { topic, record_ns })) = messages.next_head() {
                        counts.resize_with(messages.topics().len(), TopicCount::default);
                        counts[topic].add(1, record_ns, record_ns);
                    }
                    counts.resize_with(messages.topics().len(), TopicCount::default);
                    counts.into_iter().map(Some).collect()
                }
            };
            messages.topics().iter().zip(counts).for_each(|(topic, count)| add(topic, count));
        }
        Ok(all)
    }
}

/// The messages of all files of a bag.
pub(super) struct Messages {
    files: Vec<Box<dyn BagFile>>,
    current: usize,
    /// The place among the wanted topics, for each topic of that file.
    places: Vec<Option<usize>>,
}

impl Messages {
    /// Goes to the next message; `None` at the end. Returns the place of its topic among the wanted
    /// ones, which `place_of` knows, and the time when it was recorded.
    pub(super) fn next_head(
        &mut self,
        mut place_of: impl FnMut(&Topic) -> io::Result<Option<usize>>,
    ) -> io::Result<Option<(Option<usize>, i64)>> {
        while let Some(file) = self.files.get_mut(self.current) {
            if let Some(MessageHead { topic, record_ns }) = file.next_head()? {
                while self.places.len() <= topic {
                    self.places.push(place_of(&file.topics()[self.places.len()])?);
                }
                return Ok(Some((self.places[topic], record_ns)));
            }
            self.current += 1;
            self.places.clear();
        }
        Ok(None)
    }

    pub(super) fn read_data(&mut self) -> io::Result<&[u8]> {
        match self.files.get_mut(self.current) {
            Some(file) => file.read_data(),
            None => Ok(&[]),
        }
    }
}

fn open(form: BagForm, file: &dyn StoredFile, read: &Arc<AtomicU64>) -> Result<Box<dyn BagFile>, Problem> {
    let file = CountedReader { inner: file.open()?, read: Arc::clone(read) };
    Ok(match form {
        BagForm::Ros1 => Box::new(Ros1Bag::open(file)?),
        BagForm::Mcap => Box::new(McapBag::open(file)?),
        BagForm::Db3 => Box::new(Rosbag2::open(file)?.ok_or_else(|| {
            Problem::new(
                "it is an SQLite database without the tables of rosbag2 (topics, messages): export its table as CSV",
            )
        })?),
    })
}
