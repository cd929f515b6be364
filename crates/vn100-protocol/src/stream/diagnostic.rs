//! What passes on a stream beside its samples, for the diagnosis of a link.

use alloc::{
    boxed::Box,
    string::{String, ToString},
};
use core::fmt;

use crate::{RejectedSentence, Sentence};

/// One thing that passed beside the samples. Printed, it is one line of ASCII that steers no
/// terminal, whatever came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Diagnostic {
    /// A command was written to the sensor.
    Sent(Box<[u8]>),
    /// The sensor answered, or reported an error.
    Reply(Box<[u8]>),
    /// A sentence was rejected.
    Refused {
        /// Why, in words.
        reason: String,
        /// Where its `$` stands, in bytes from the beginning of the stream.
        offset: u64,
        /// Its bytes, as far as they were taken for a part of it.
        raw: Box<[u8]>,
    },
}

impl Diagnostic {
    pub(super) fn reply(sentence: &Sentence<'_>) -> Self {
        Self::Reply(sentence.raw.trim_ascii_end().into())
    }

    pub(super) fn refused(bad: &RejectedSentence<'_>) -> Self {
        Self::Refused { reason: bad.kind.to_string(), offset: bad.offset, raw: bad.raw.into() }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sent(line) => write!(f, "sent {}", line.trim_ascii_end().escape_ascii()),
            Self::Reply(line) => write!(f, "reply {}", line.escape_ascii()),
            Self::Refused { reason, offset, raw } => {
                write!(f, "refused at byte {offset}, {reason}: {}", raw.escape_ascii())
            }
        }
    }
}
