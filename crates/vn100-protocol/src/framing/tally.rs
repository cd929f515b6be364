//! Counts of the content of a stream, by bytes and by sentences.

use crate::framing::sentence::RejectReason;

/// Counts since the beginning of the stream. Every byte is in exactly one of the five byte counts
/// at any moment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes of valid sentences, with the CR and LF after them.
    pub valid_sentence_bytes: u64,
    /// Bytes of rejected sentences, with the CR and LF after them.
    pub rejected_sentence_bytes: u64,
    /// Bytes of binary packets.
    pub packet_bytes: u64,
    /// Bytes between all these.
    pub skipped_bytes: u64,
    /// Bytes pending until more of them arrive: the beginning of a sentence or packet.
    pub buffered_bytes: u64,
    /// Samples: sentences of the [`MESSAGES`](crate::MESSAGES).
    pub samples: u64,
    /// Answers to commands.
    pub replies: u64,
    /// Other valid sentences.
    pub other: u64,
    /// Valid sentences without a checksum, accepted on request.
    pub unchecked_sentences: u64,
    /// Binary packets.
    pub packets: u64,
    /// The measured packets among these, good or not.
    pub measured_packets: MeasuredPackets,
    /// Parts of packets that firmware 3 has split; they are not decoded, and their bytes are skipped.
    pub split_packets: u64,
    /// Damaged packets, whose bytes are skipped: they begin with the groups and field words of an
    /// earlier packet and fail their CRC, and do not lie within the length of another.
    pub damaged_packets: u64,
    /// Rejected sentences.
    pub rejected: RejectedCounts,
}

/// Packets of the form that is measured. The decoder does not count them: the
/// [`SampleReader`](crate::stream::SampleReader) does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MeasuredPackets {
    /// Samples.
    pub samples: u64,
    /// Packets with a number that no VN-100 measures.
    pub rejected: u64,
    /// Packets with the same device time as the packet before.
    pub repeated: u64,
}

/// Rejected sentences by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub struct RejectedCounts {
    /// The checksum differs.
    pub checksum: u64,
    /// There is no checksum.
    pub unchecked: u64,
    /// The fields are not those of the message.
    pub grammar: u64,
    /// A number is beyond what the sensor can give.
    pub range: u64,
    /// The sentence is cut short.
    pub truncated: u64,
    /// The sentence is longer than any message.
    pub too_long: u64,
}

impl Tally {
    /// All bytes received.
    pub fn bytes(&self) -> u64 {
        self.valid_sentence_bytes
            + self.rejected_sentence_bytes
            + self.packet_bytes
            + self.skipped_bytes
            + self.buffered_bytes
    }

    /// The same counts if these rejected sentences, with this many bytes, are parts of damaged packets.
    pub(crate) fn without_fragments(mut self, fragments: &RejectedCounts, bytes: u64) -> Self {
        self.rejected = self.rejected.without(fragments);
        self.rejected_sentence_bytes -= bytes;
        self.skipped_bytes += bytes;
        self
    }

    /// Samples, replies and other valid sentences.
    pub fn valid_sentences(&self) -> u64 {
        self.samples + self.replies + self.other
    }
}

impl RejectedCounts {
    /// Rejected sentences of any reason.
    pub fn total(&self) -> u64 {
        self.checksum + self.unchecked + self.grammar + self.range + self.truncated + self.too_long
    }

    fn without(&self, part: &Self) -> Self {
        Self {
            checksum: self.checksum - part.checksum,
            unchecked: self.unchecked - part.unchecked,
            grammar: self.grammar - part.grammar,
            range: self.range - part.range,
            truncated: self.truncated - part.truncated,
            too_long: self.too_long - part.too_long,
        }
    }

    pub(crate) fn count(&mut self, kind: RejectReason) {
        let count = match kind {
            RejectReason::Checksum { .. } => &mut self.checksum,
            RejectReason::Unchecked => &mut self.unchecked,
            RejectReason::Grammar(_) => &mut self.grammar,
            RejectReason::Range(_) => &mut self.range,
            RejectReason::Truncated => &mut self.truncated,
            RejectReason::TooLong => &mut self.too_long,
        };
        *count += 1;
    }
}
