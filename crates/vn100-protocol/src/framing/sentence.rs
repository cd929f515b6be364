//! A sentence: `$`, a body, and its protection; or the reason for its rejection.

use alloc::string::ToString;

use thiserror::Error;

use crate::{
    framing::checksum::{Check, CheckDigits},
    message::{GrammarError, RangeError},
};

/// The longest accepted body: with `$`, `*`, four digits, CR and LF it has 320 bytes, twice the
/// longest stock message.
pub const MAX_BODY: usize = 312;

/// A sentence with a correct checksum, or without one if this was allowed.
///
/// ```text
/// $ VNRRG,01,VN-100S-CR * 35 CR LF
///   '------ body -----'
/// '---------- raw ---------'
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sentence<'a> {
    /// The bytes between `$` and `*`: printable ASCII without those two, at most [`MAX_BODY`].
    pub body: &'a [u8],
    /// The bytes from the `$` to the last check digit, without CR and LF.
    pub raw: &'a [u8],
    /// Its protection.
    pub check: Check,
    /// The offset of its `$`, in bytes from the beginning of the stream.
    pub offset: u64,
}

impl<'a> Sentence<'a> {
    /// The text before the first comma, such as `VNRRG`.
    pub fn header(&self) -> &'a [u8] {
        let end = self.body.iter().position(|&byte| byte == b',').unwrap_or(self.body.len());
        &self.body[..end]
    }

    /// Whether the header can be the name of a message: `VN` and three letters; or, for other
    /// devices, a letter and at least two letters or digits.
    pub fn has_name(&self) -> bool {
        match self.header() {
            [b'V', b'N', name @ ..] => name.len() == 3 && name.iter().all(u8::is_ascii_alphabetic),
            name @ [first, _, _, ..] => first.is_ascii_alphabetic() && name.iter().all(u8::is_ascii_alphanumeric),
            _ => false,
        }
    }

    /// Whether this is the reply of a VN-100 to a command: the command's own name, or `VNERR`.
    pub fn is_reply(&self) -> bool {
        #[rustfmt::skip]
        const REPLIES: [&[u8]; 16] = [
            b"VNRRG", b"VNWRG", b"VNWNV", b"VNRFS", b"VNRST", b"VNTAR", b"VNKMD", b"VNKAD",
            b"VNSGB", b"VNSFB", b"VNASY", b"VNBOM", b"VNSIH", b"VNERR", b"VNFWU", b"VNCMD",
        ];
        REPLIES.contains(&self.header())
    }
}

/// A start of a sentence without a valid sentence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RejectedSentence<'a> {
    /// The reason.
    pub kind: RejectReason,
    /// Its bytes, from the `$` to the last byte that was counted to it, without CR and LF.
    pub raw: &'a [u8],
    /// The offset of its `$`, in bytes from the beginning of the stream.
    pub offset: u64,
}

/// The reason why a sentence is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum RejectReason {
    /// The check digits do not fit the line, or are no check digits.
    #[error("checksum: computed {computed}, received {}",
        .received.map_or("neither two nor four hexadecimal digits".into(), |digits| digits.to_string()))]
    Checksum {
        /// The computed check of the body, in the kind of check of the line.
        computed: CheckDigits,
        /// The digits of the line; `None` unless exactly two or four upper-case hexadecimal digits
        /// follow the `*`.
        received: Option<CheckDigits>,
    },
    /// The line ends without check digits, and such lines are not accepted.
    #[error("unchecked: the sentence has no checksum; such sentences are accepted only on request")]
    Unchecked,
    /// The checksum is correct, but the content does not fit the header.
    #[error("grammar: {0}")]
    Grammar(#[from] GrammarError),
    /// Checksum and form are correct, but no VN-100 measures such a value.
    #[error("range: {0}")]
    Range(#[from] RangeError),
    /// Another `$`, a byte that is not printable ASCII, or the end of the stream came first.
    #[error("truncated: the sentence ends before its checksum")]
    Truncated,
    /// No end within the length of the longest sentence.
    #[error("too long: no end after {} bytes, more than any sentence has", MAX_BODY)]
    TooLong,
}
