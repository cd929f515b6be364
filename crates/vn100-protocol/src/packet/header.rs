//! The beginning of a packet.

use alloc::vec::Vec;
use core::fmt;

use super::field::{GROUPS, present};

/// The first byte of a packet.
pub(crate) const START: u8 = 0xFA;

/// `FA`, groups and a word for each of the four groups.
const MAX_HEADER: usize = 2 + 2 * GROUPS.len();

/// The groups and words at the beginning of a packet, which distinguish the packets of one binary
/// output from those of another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PacketHeader([u8; MAX_HEADER]);

impl PacketHeader {
    /// The header of packets with these groups and a word of fields for each, as in registers 75 to
    /// 77; further words than four are ignored.
    pub fn new(groups: u8, words: &[u16]) -> Self {
        let mut header = [0; MAX_HEADER];
        (header[0], header[1]) = (START, groups);
        for (bytes, word) in header[2..].chunks_exact_mut(2).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self(header)
    }

    /// The groups, and their words.
    pub fn parts(&self) -> (u8, Vec<u16>) {
        let words = self.0[2..].chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]]));
        (self.0[1], words.take(self.0[1].count_ones() as usize).collect())
    }

    /// The header of the packet that these bytes begin with.
    #[inline]
    pub(crate) fn of(bytes: &[u8]) -> Self {
        let mut header = [0; MAX_HEADER];
        let groups = bytes.get(1).map_or(0, |groups| groups.count_ones() as usize);
        let length = (2 + 2 * groups).min(bytes.len()).min(MAX_HEADER);
        header[..length].copy_from_slice(&bytes[..length]);
        Self(header)
    }
}

/// The known fields by their names in the manual, in the order of the wire.
impl fmt::Display for PacketHeader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (groups, words) = self.parts();
        let names: Vec<_> = present(groups, &words).map(|field| field.name).filter(|name| !name.is_empty()).collect();
        f.write_str(&names.join(", "))
    }
}
