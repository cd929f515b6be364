//! The beginning of a packet.

use alloc::vec::Vec;
use core::fmt;

use super::field::{GROUPS, present};

/// The first byte of a packet.
pub(crate) const START: u8 = 0xFA;

/// `FA`, groups and a word for each of the four groups.
const MAX_HEADER: usize = 2 + 2 * GROUPS.len();

/// The bytes of a number that holds a header.
const BYTES: usize = size_of::<u128>();

/// The groups and words at the beginning of a packet, which distinguish the packets of one binary
/// output from those of another.
///
/// The order is that of the bytes. They are the highest of a number, because two numbers are compared
/// at once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PacketHeader(u128);

impl PacketHeader {
    /// The header of packets with these groups and a word of fields for each, as in registers 75 to
    /// 77; further words than four are ignored.
    pub fn new(groups: u8, words: &[u16]) -> Self {
        let mut header = [0; BYTES];
        (header[0], header[1]) = (START, groups);
        for (bytes, word) in header[2..MAX_HEADER].chunks_exact_mut(2).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self(u128::from_be_bytes(header))
    }

    /// The groups, and their words.
    pub fn parts(&self) -> (u8, Vec<u16>) {
        let header = self.0.to_be_bytes();
        let words = header[2..MAX_HEADER].chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]]));
        (header[1], words.take(header[1].count_ones() as usize).collect())
    }

    /// The header of the packet that these bytes begin with.
    #[inline]
    pub(crate) fn of(bytes: &[u8]) -> Self {
        let first = match bytes.first_chunk() {
            Some(first) => u128::from_be_bytes(*first),
            None => {
                let mut first = [0; BYTES];
                first[..bytes.len()].copy_from_slice(bytes);
                u128::from_be_bytes(first)
            }
        };
        let groups = (first >> (8 * (BYTES - 2))) as u8;
        let length = MAX_HEADER.min(2 + 2 * groups.count_ones() as usize);
        Self(first & (u128::MAX << (8 * (BYTES - length))))
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
