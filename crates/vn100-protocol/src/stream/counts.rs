//! Counts of the content of a stream so far.

use alloc::string::String;
use core::fmt;

use super::RejectedRowCounts;
use crate::{DeviceError, PacketHeader, Tally};

/// Counts of the content of a stream so far, by bytes and by frames.
///
/// In a CSV file a row is a sentence, valid or rejected, with all its columns and its line end;
/// header, comments and blank lines are skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StreamCounts {
    /// The parser's own count; its byte classes add up to the bytes read.
    pub tally: Tally,
    /// Sentences of a measurement other than the first one of this stream; part of the valid
    /// sentences, not of the samples.
    pub foreign_samples: u64,
    /// Bytes that were discarded during a baud scan or while the sensor was identified; not in the
    /// tally.
    pub baud_scan_bytes: u64,
    /// Bytes known to be lost between the port and this program.
    pub overrun_bytes: u64,
    /// Sentences that the end of the stream, or of a connection, cut; part of the rejected ones.
    pub cut_sentences: u64,
    /// Reads of the host that the line echoed; part of the tally's replies, but no answers.
    pub echoes: u64,
    /// Unsolicited device errors: `VNERR` messages that answer no command of this program.
    pub unsolicited_errors: UnsolicitedErrors,
    /// Number of times that the output of the sensor was found paused and was resumed.
    pub outputs_resumed: u64,
    /// Number of connects of the link; 0 for a capture that has no link.
    pub connects: u64,
    /// The first valid sentence that is neither a sample of this stream nor a reply.
    pub other_message: Option<MessageName>,
    /// The first sentence that a VN-200, VN-210, VN-300 or VN-310 sends, but not a VN-100 or VN-110.
    pub other_model: Option<MessageName>,
    /// The header of the first packet of another form than the measured one.
    pub other_packet: Option<PacketHeader>,
    /// Rejected rows of a CSV file; they are among the rejected sentences. `None` for other
    /// sources.
    pub rejected_rows: Option<RejectedRowCounts>,
}

impl StreamCounts {
    /// Samples in batches.
    pub fn samples(&self) -> u64 {
        self.tally.samples - self.foreign_samples + self.tally.measured_packets.samples
    }

    /// Bytes received.
    pub fn bytes(&self) -> u64 {
        self.tally.bytes() + self.baud_scan_bytes
    }

    /// Bytes without a frame, and bytes that were not searched.
    pub fn skipped_bytes(&self) -> u64 {
        self.tally.skipped_bytes + self.baud_scan_bytes
    }

    /// Replies to commands, and device errors.
    pub fn answers(&self) -> u64 {
        self.tally.replies - self.echoes
    }

    /// Valid sentences that are neither samples of this stream nor replies.
    pub fn other_messages(&self) -> u64 {
        self.tally.other + self.foreign_samples
    }
}

/// The name of a message, such as `VNYPR`; at most eight bytes long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MessageName {
    // printable ASCII, padded with spaces
    bytes: [u8; 8],
}

impl MessageName {
    /// The name in the header of a sentence.
    pub fn new(header: &[u8]) -> Self {
        let mut bytes = [b' '; 8];
        bytes.iter_mut().zip(header).for_each(|(to, from)| *to = *from);
        Self { bytes }
    }
}

impl fmt::Display for MessageName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(String::from_utf8_lossy(&self.bytes).trim_end())
    }
}

const KNOWN: [DeviceError; 13] = DeviceError::KNOWN;

/// Counts of unsolicited errors by their code.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct UnsolicitedErrors {
    /// The errors in the manual; all others share the last count.
    counts: [u64; KNOWN.len() + 1],
    first_unknown: Option<DeviceError>,
}

impl UnsolicitedErrors {
    /// Counts an error.
    pub fn count(&mut self, error: DeviceError) {
        let place = KNOWN.iter().position(|&known| known == error).unwrap_or(KNOWN.len());
        self.counts[place] += 1;
        if place == KNOWN.len() {
            self.first_unknown.get_or_insert(error);
        }
    }

    /// The received errors with their counts, by code. Codes that are not in the manual count as
    /// the first of these.
    pub fn iter(&self) -> impl Iterator<Item = (DeviceError, u64)> {
        let errors = KNOWN.into_iter().map(Some).chain([self.first_unknown]);
        errors.zip(self.counts).filter(|(_, count)| *count > 0).filter_map(|(error, count)| Some((error?, count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_code_has_its_count_and_unknown_ones_share_one() {
        let mut errors = UnsolicitedErrors::default();
        for code in 0..=u8::MAX {
            errors.count(DeviceError::from_code(code));
        }
        errors.count(DeviceError::OutputBufferOverflow);
        let counted: Vec<_> = errors.iter().map(|(error, count)| (error.code(), count)).collect();
        let mut expected: Vec<_> = KNOWN.map(DeviceError::code).map(|code| (code, 1 + u64::from(code == 0x0B))).into();
        expected.push((0, 256 - KNOWN.len() as u64));
        assert_eq!(counted, expected);
    }
}
