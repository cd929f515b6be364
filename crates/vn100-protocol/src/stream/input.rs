//! The input from a source of bytes: the bytes of each read, and events of the link.

use alloc::string::String;

use bytes::Bytes;

use crate::DeviceError;

/// The bytes of one read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// The bytes; never empty.
    pub bytes: Bytes,
    /// The time when the read returned, in nanoseconds from an origin of the source's choice;
    /// `None` if it is not known, as for a plain file.
    pub at_ns: Option<i64>,
}

/// One input from a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StreamInput {
    /// The bytes of a read.
    Chunk(Chunk),
    /// An event of the link, at this place among the bytes.
    Link(LinkEvent),
}

impl From<Chunk> for StreamInput {
    fn from(chunk: Chunk) -> Self {
        Self::Chunk(chunk)
    }
}

/// A change of the link to a live sensor, or to the sensor of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkEvent {
    /// The time, in nanoseconds from the origin of the [`Chunk`]s' times.
    pub at_ns: i64,
    /// The kind.
    pub kind: LinkEventKind,
}

/// The kind of a [`LinkEvent`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkEventKind {
    /// The link is connected; the samples of a new segment follow.
    Up {
        /// The port by its name, such as `/dev/ttyUSB0`.
        port: String,
        /// The baud rate; `None` if the link has none, as over TCP.
        baud: Option<u32>,
    },
    /// The link is lost; an incomplete frame is cut off.
    Down {
        /// The cause, in words.
        cause: String,
    },
    /// Bytes that arrived during a baud scan, or before the identity and settings of the sensor
    /// were verified. They are counted and not decoded.
    DiscardedDuringBaudScan {
        /// The number of bytes.
        bytes: u64,
    },
    /// Bytes were lost between the port and this program, because it did not read them in time.
    Overrun {
        /// The number of bytes.
        bytes: u64,
    },
    /// An unsolicited device error: the sensor refused a command that this program did not send.
    /// Errors that are always unsolicited are counted in the stream and have no event.
    UnsolicitedError {
        /// The error.
        error: DeviceError,
    },
    /// The async output of the sensor was found paused by another program, and was resumed.
    OutputResumed,
    /// The async output was paused again when the link was stopped, as it had been found.
    OutputPaused,
    /// Another program has the port open as well: each of the two receives a part of the bytes.
    PortShared {
        /// Its name, and the number of its process.
        program: String,
    },
    /// The link was closed finally while it was lost: until then it was down.
    Closed,
    /// The user marked this place.
    Marked {
        /// The user's text.
        text: String,
    },
}
