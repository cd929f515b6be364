//! A capture whose format is known, ready to be read from its first byte.

use std::io;

use vn100_protocol::stream::ReadOptions;

use crate::{
    read_samples::{FileEvents, FileReader},
    recording::reader::Recorded,
    source::ReaderSource,
};

/// A capture whose format is known.
pub(crate) struct Readable {
    /// Whether it holds numbers that may be of any sensor, and no messages of a VN-100.
    pub(crate) holds_values: bool,
    /// Whether it holds values without times.
    pub(crate) lacks_times: bool,
    /// What is read of it; `None` if there is no choice.
    pub(crate) topic: Option<String>,
    /// The metadata of a recording of this program.
    pub(crate) recorded: Option<Recorded>,
    pub(crate) start: StartReading,
}

pub(crate) type StartReading = Box<dyn FnOnce(ReadOptions) -> io::Result<Reading> + Send>;

impl Readable {
    /// A capture of sentences or packets that is read by `start`.
    pub(crate) fn new(start: impl FnOnce(ReadOptions) -> io::Result<Reading> + Send + 'static) -> Self {
        Self { holds_values: false, lacks_times: false, topic: None, recorded: None, start: Box::new(start) }
    }
}

/// A capture that is read.
pub(crate) enum Reading {
    File(FileEvents),
    /// A read of a stream may wait for bytes indefinitely.
    Stream(ReaderSource, ReadOptions),
}

impl Reading {
    pub(crate) fn of(file: impl FileReader) -> io::Result<Self> {
        Ok(Self::File(FileEvents::new(Box::new(file))))
    }
}
