//! What a source of bytes delivers: the bytes of each read, and events of the link.

use alloc::string::String;

use bytes::Bytes;

use crate::DeviceError;

/// Bytes as one read returned them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// The bytes; never empty.
    pub bytes: Bytes,
    /// When the read returned, in nanoseconds from an origin of the source's choice; `None` where
    /// it does not know, as for a plain file.
    pub at_ns: Option<i64>,
}

/// What a source delivers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StreamInput {
    /// What a read brought.
    Chunk(Chunk),
    /// An event of the link, at this place among the bytes.
    Link(LinkEvent),
}

impl From<Chunk> for StreamInput {
    fn from(chunk: Chunk) -> Self {
        Self::Chunk(chunk)
    }
}

/// A change of the link to a live sensor, or to the one that a recording was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkEvent {
    /// When, in nanoseconds from the origin of the [`Chunk`]s' times.
    pub at_ns: i64,
    /// What.
    pub kind: LinkEventKind,
}

/// What a [`LinkEvent`] is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkEventKind {
    /// The link is connected; the samples of a new segment follow.
    Up {
        /// The port by its name, such as `/dev/ttyUSB0`.
        port: String,
        /// The baud rate; `None` where the link has none, as over TCP.
        baud: Option<u32>,
    },
    /// The link is lost; a frame that is incomplete is cut off.
    Down {
        /// What happened, in words.
        cause: String,
    },
    /// Bytes that arrived during a baud scan, or before the identity and settings of the sensor
    /// were verified. They are counted and not decoded.
    DiscardedDuringBaudScan {
        /// How many.
        bytes: u64,
    },
    /// Bytes were lost between the port and this program, because it did not take them in time.
    Overrun {
        /// How many.
        bytes: u64,
    },
    /// An unsolicited device error: the sensor refused a command that this program did not send.
    /// Errors that are always unsolicited are counted in the stream and have no event.
    UnsolicitedError {
        /// What it said.
        error: DeviceError,
    },
    /// The async output of the sensor was found paused by another program, and was resumed.
    OutputResumed,
    /// The async output was paused again when the link was stopped, as it had been found.
    OutputPaused,
    /// Another program has the port open too: each of both gets a part of the bytes.
    PortShared {
        /// Its name, and the number of its process.
        program: String,
    },
    /// The link was closed for good while it was lost: until then it was down.
    Closed,
    /// The user marked this place.
    Marked {
        /// In the user's words.
        text: String,
    },
}
