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
pub enum Input {
    /// What a read brought.
    Chunk(Chunk),
    /// Something befell the link, at this place among the bytes.
    Link(LinkEvent),
}

impl From<Chunk> for Input {
    fn from(chunk: Chunk) -> Self {
        Self::Chunk(chunk)
    }
}

/// What befell the link to a live sensor, or the one that a recording was made of.
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
    /// The sensor can be heard; samples follow, of a new segment.
    Up {
        /// The port by its name, such as `/dev/ttyUSB0`.
        port: String,
        /// Speed of the line in baud; `None` where the link has none, as over TCP.
        baud: Option<u32>,
    },
    /// The sensor is not heard any more; a line that was under way is cut off.
    Down {
        /// What happened, in words.
        cause: String,
    },
    /// Bytes that came while the speed of the line was looked for. No line is searched in them.
    Probed {
        /// How many.
        bytes: u64,
    },
    /// Bytes were lost between the port and this program, because it did not take them in time.
    Overrun {
        /// How many.
        bytes: u64,
    },
    /// The sensor refused a command that did not come from here. Errors that it never tells but
    /// unasked stand in the stream and have no such event.
    UnaskedError {
        /// What it said.
        error: DeviceError,
    },
    /// The output of the sensor had been paused by somebody else, and was made to go on from here.
    OutputResumed,
    /// It was paused again when the link was stopped, as it had been found.
    OutputPaused,
}
