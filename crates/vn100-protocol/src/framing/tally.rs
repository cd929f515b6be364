//! What a stream has carried, byte by byte and line by line.

use crate::framing::bad_line::BadKind;

/// Counts since the beginning of the stream. Every byte is in exactly one of the five byte counts
/// at any moment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes of good lines, with the CR and LF behind them.
    pub good_line_bytes: u64,
    /// Bytes of bad lines, with the CR and LF behind them.
    pub bad_line_bytes: u64,
    /// Bytes of binary packets.
    pub packet_bytes: u64,
    /// Bytes between all these.
    pub skipped_bytes: u64,
    /// Bytes held back until more of them arrive: the beginning of a sentence or packet.
    pub buffered_bytes: u64,
    /// Samples: sentences of the [`MESSAGES`](crate::MESSAGES).
    pub samples: u64,
    /// Answers to commands.
    pub replies: u64,
    /// Other good sentences.
    pub other: u64,
    /// Of the good lines, those that carry no checksum and were taken on request.
    pub unchecked_lines: u64,
    /// Binary packets.
    pub packets: u64,
    /// Bad lines.
    pub bad: BadTally,
}

/// Bad lines by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BadTally {
    /// [`BadKind::Checksum`].
    pub checksum: u64,
    /// [`BadKind::Unchecked`].
    pub unchecked: u64,
    /// [`BadKind::Grammar`].
    pub grammar: u64,
    /// [`BadKind::Range`].
    pub range: u64,
    /// [`BadKind::Truncated`].
    pub truncated: u64,
    /// [`BadKind::TooLong`].
    pub too_long: u64,
}

impl Tally {
    /// All bytes taken in.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.good_line_bytes + self.bad_line_bytes + self.packet_bytes + self.skipped_bytes + self.buffered_bytes
    }

    /// Samples, replies and other good sentences.
    #[must_use]
    pub fn good_lines(&self) -> u64 {
        self.samples + self.replies + self.other
    }
}

impl BadTally {
    /// Bad lines of any kind.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.checksum + self.unchecked + self.grammar + self.range + self.truncated + self.too_long
    }

    pub(crate) fn count(&mut self, kind: BadKind) {
        let count = match kind {
            BadKind::Checksum { .. } => &mut self.checksum,
            BadKind::Unchecked => &mut self.unchecked,
            BadKind::Grammar(_) => &mut self.grammar,
            BadKind::Range(_) => &mut self.range,
            BadKind::Truncated => &mut self.truncated,
            BadKind::TooLong => &mut self.too_long,
        };
        *count += 1;
    }
}
