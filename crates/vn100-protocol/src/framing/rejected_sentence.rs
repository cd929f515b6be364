//! A rejected sentence, with the evidence.

use thiserror::Error;

use crate::{
    framing::checksum::CheckDigits,
    message::{GrammarError, RangeError},
};

/// A start of a sentence that is not a valid one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RejectedSentence<'a> {
    /// What is wrong with it.
    pub kind: RejectReason,
    /// Its bytes, from the `$` to the last one that was taken for a part of it; without CR and LF.
    pub raw: &'a [u8],
    /// Where its `$` stands, in bytes from the beginning of the stream.
    pub offset: u64,
}

/// Why a sentence is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum RejectReason {
    /// The check digits do not fit the line, or are no check digits.
    #[error("checksum: the line gives {computed}, its end says {}", Received(*.received))]
    Checksum {
        /// What the body of the line gives, in the kind of check it carries.
        computed: CheckDigits,
        /// What the line says; `None` when behind the `*` are not exactly two or four upper-case
        /// hexadecimal digits.
        received: Option<CheckDigits>,
    },
    /// The line ends without any check digits, and such lines were not asked for.
    #[error("unchecked: the line ends without a checksum; such lines are taken only on request")]
    Unchecked,
    /// The checksum is right, but the message is not what its header promises.
    #[error("grammar: {0}")]
    Grammar(#[from] GrammarError),
    /// All is well but a value that no VN-100 measures.
    #[error("range: {0}")]
    Range(#[from] RangeError),
    /// Another `$`, a byte that is not printable ASCII, or the end of the stream came first.
    #[error("truncated: the line breaks off before its end")]
    Truncated,
    /// No end within the length of the longest sentence.
    #[error("too long: no end after {} bytes, more than any sentence has", crate::framing::sentence::MAX_BODY)]
    TooLong,
}

struct Received(Option<CheckDigits>);

impl core::fmt::Display for Received {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            Some(digits) => digits.fmt(f),
            None => f.write_str("neither two nor four hexadecimal digits"),
        }
    }
}
