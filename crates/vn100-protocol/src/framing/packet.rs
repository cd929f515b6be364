//! Binary packets between the sentences: found, checked and skipped as a whole.
//!
//! ```text
//! FA | groups u8 | field word u16 LE, one per set bit of groups | payload | CRC-16 high byte first
//! ```
//!
//! A packet has no length field; its length follows from the sizes of the fields in its masks. Only
//! the CRC decides, over any bytes: one in 65 536 false starts with known masks is taken for a
//! packet.

use crate::{
    framing::checksum::crc16,
    packet::{
        field::{GROUPS, PacketField},
        header::PacketHeader,
    },
};

pub(crate) use crate::packet::header::START;

/// The first byte of a part of a packet that firmware 3 has split.
pub(crate) const SPLIT_START: u8 = 0xFB;

/// The longest packet a VN-100 can send: every field of all its groups.
pub const MAX_PACKET: usize = 627;

/// A binary packet with a correct CRC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// All its bytes, from the 0xFA to the second of the CRC; at most [`MAX_PACKET`].
    pub raw: &'a [u8],
    /// The offset of its 0xFA, in bytes from the beginning of the stream.
    pub offset: u64,
}

/// The classification of the bytes after a 0xFA.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum PacketStart {
    Packet(usize),
    /// A packet only if further bytes confirm it.
    Incomplete,
    No,
}

const KNOWN_GROUPS: u8 = 0x01 | 0x02 | 0x04 | 0x10;

/// The heads of the packets so far, with their lengths: a sensor has three outputs, whose settings
/// may change.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SeenHeads {
    /// The most recent head first; unused ones have no length.
    heads: [(PacketHeader, usize); 8],
}

impl SeenHeads {
    /// Remembers the head of a packet whose length was not known.
    #[cold]
    pub(crate) fn remember(&mut self, packet: &[u8]) {
        self.heads.rotate_right(1);
        self.heads[0] = (PacketHeader::of(packet), packet.len());
    }

    /// The length of the packet at the head of `input`, if one with the same head was seen.
    #[inline]
    pub(crate) fn length_of(&self, input: &[u8]) -> Option<usize> {
        let header = PacketHeader::of(input);
        self.heads.iter().find(|(seen, length)| *length > 0 && *seen == header).map(|(_, length)| *length)
    }
}

/// Classifies `input`, which begins with 0xFA.
pub(crate) fn classify(input: &[u8]) -> PacketStart {
    let Some(&groups) = input.get(1) else {
        return PacketStart::Incomplete;
    };
    // the CRC of zeros is zero: a packet without a field would be found in any run of zeros
    if groups == 0 || groups & !KNOWN_GROUPS != 0 {
        return PacketStart::No;
    }
    let mut words = input[2..].chunks_exact(2);
    let mut length = 2 + 2;
    for (_, fields) in GROUPS.iter().filter(|(bit, _)| groups & bit != 0) {
        let Some(word) = words.next() else {
            return PacketStart::Incomplete;
        };
        match payload_length(u16::from_le_bytes([word[0], word[1]]), fields) {
            Some(payload) => length += 2 + payload,
            None => return PacketStart::No,
        }
    }
    checked(input, length)
}

/// Whether the first `length` bytes of `input` are a packet by their CRC.
#[inline]
pub(crate) fn checked(input: &[u8], length: usize) -> PacketStart {
    match input.get(1..length) {
        None => PacketStart::Incomplete,
        Some(checked) if crc16(checked) == 0 => PacketStart::Packet(length),
        Some(_) => PacketStart::No,
    }
}

/// Classifies `input`, which begins with 0xFB, as a part of a split packet:
///
/// ```text
/// FB | type 0 | message | parts and number, four bits each | length u16 LE | payload | CRC-16
/// ```
pub(crate) fn classify_part(input: &[u8]) -> PacketStart {
    const HEAD: usize = 6;
    let has_type = input.get(1).is_none_or(|kind| *kind == 0);
    let is_part = input.get(3).is_none_or(|place| place >> 4 >= 2 && place & 0xF <= place >> 4);
    if !has_type || !is_part {
        return PacketStart::No;
    }
    let Some([.., low, high]) = input.first_chunk::<HEAD>() else { return PacketStart::Incomplete };
    let length = HEAD + usize::from(u16::from_le_bytes([*low, *high])) + 2;
    if length > MAX_PACKET {
        return PacketStart::No;
    }
    checked(input, length)
}

/// The bytes of a packet with these groups and a word of fields for each; `None` if one is unknown,
/// or if the numbers of groups and words differ.
pub(crate) fn length(groups: u8, words: &[u16]) -> Option<usize> {
    if groups & !KNOWN_GROUPS != 0 || groups == 0 || groups.count_ones() as usize != words.len() {
        return None;
    }
    let fields = GROUPS.iter().filter(|(bit, _)| groups & bit != 0).map(|(_, fields)| fields);
    words.iter().zip(fields).try_fold(2 + 2, |length, (&word, fields)| Some(length + 2 + payload_length(word, fields)?))
}

/// The bytes of the fields in `word`; `None` if a field is unknown, or if there is none.
fn payload_length(word: u16, fields: &[PacketField; 16]) -> Option<usize> {
    let mut length = 0;
    for (_, field) in fields.iter().enumerate().filter(|(bit, _)| word >> bit & 1 == 1) {
        if field.bytes == 0 {
            return None;
        }
        length += usize::from(field.bytes);
    }
    (length > 0).then_some(length)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Decoder, Item, Options};

    proptest! {
        /// Packets of every length.
        #[test]
        fn packets_are_good_only_with_a_correct_crc(
            mut bytes in proptest::collection::vec(any::<u8>(), 7..MAX_PACKET - 2),
            at: prop::sample::Index,
            bit in 0_u8..8,
        ) {
            bytes.extend(crc16(&bytes[1..]).to_be_bytes());
            prop_assert_eq!(checked(&bytes, bytes.len()), PacketStart::Packet(bytes.len()));
            let at = 1 + at.index(bytes.len() - 1);
            bytes[at] ^= 1 << bit;
            prop_assert_eq!(checked(&bytes, bytes.len()), PacketStart::No);
        }
    }

    fn bytes(hex: &str) -> Vec<u8> {
        let digits: Vec<_> = hex.bytes().filter(|byte| *byte != b' ').collect();
        digits.chunks(2).map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
    }

    const RECORDED: [&str; 4] = [
        "FA 01 0800 93502E42 833EF13F 48B504BB 9288",
        "FA 05 0800 1000 A4150242 4DDFEB3F F61A36BE BF2DA441 AF1A",
        "FA 01 0900 700500030A000000 480E2C42 084C37C1 10388BC2 D4CB",
        "fa0139073065d926f60a00008432abc2ef02964232847e42fe8928bf6c74c3bd438a313fa69b8dbe00a59939508ea5bae0ac163a1eed0f4140620ac028a3\
         89bf1eed0f4140620ac028a389bfa76aa23cf068f4bc94302cbc367d0dbf5d45e03e62fe673f299c064294d8ca429e60",
    ];

    #[test]
    fn recorded_packets_are_found_whole() {
        for (hex, length) in RECORDED.iter().zip([18, 24, 26, 110]) {
            let packet = bytes(hex);
            assert_eq!(packet.len(), length);
            assert_eq!(classify(&packet), PacketStart::Packet(length));
            for cut in 1..length {
                assert_eq!(classify(&packet[..cut]), PacketStart::Incomplete, "{cut} of {length} bytes");
            }
        }
    }

    /// The shortest packet, of seven bytes: the CRC of zeros is zero, and so is its remembered head.
    #[test]
    fn zeros_after_a_short_packet_are_no_packets() {
        let stream = [bytes("FA 02 0002 00 8B0A"), vec![0; 40]].concat();
        let count = |piece: usize| {
            let (mut decoder, mut packets) = (Decoder::new(Options::default()), 0);
            for piece in stream.chunks(piece) {
                decoder.push(piece, |item| packets += u32::from(matches!(item, Item::Packet(_))));
            }
            decoder.finish(|_| ());
            (packets, decoder.tally().skipped_bytes)
        };
        for piece in [1, 7, 47] {
            assert_eq!(count(piece), (1, 40), "{piece}");
        }
    }

    /// No public capture has one: these are two parts of a packet in the form of the maker's library.
    #[test]
    fn parts_of_split_packets_are_counted_and_skipped() {
        let part = |number: u8| {
            let mut part = vec![SPLIT_START, 0, 7, 0x20 | number, 5, 0, b'$', START, 1, 2, 3];
            part.extend(crc16(&part[1..]).to_be_bytes());
            part
        };
        let mut damaged = part(1);
        damaged[8] ^= 1;
        let stream = [part(0), bytes(RECORDED[0]), part(1), damaged.clone(), bytes(RECORDED[1])].concat();
        for piece in 1..stream.len() {
            let (mut decoder, mut packets) = (Decoder::new(Options::default()), 0);
            for piece in stream.chunks(piece) {
                decoder.push(piece, |item| packets += u32::from(matches!(item, Item::Packet(_))));
            }
            decoder.finish(|_| ());
            let tally = decoder.tally();
            let others = stream.len() as u64 - tally.packet_bytes - tally.rejected_sentence_bytes;
            assert_eq!((packets, tally.split_packets, tally.skipped_bytes), (2, 2, others), "{piece}");
        }
        for other in [&[SPLIT_START, 1][..], &[SPLIT_START, 0, 0, 0x10], &[SPLIT_START, 0, 0, 0x23], &damaged] {
            assert_eq!(classify_part(other), PacketStart::No, "{other:02X?}");
        }
        assert_eq!(classify_part(&[SPLIT_START, 0, 0, 0x21, 0xFF, 0xFF]), PacketStart::No, "too long");
        assert_eq!(classify_part(&part(0)[..9]), PacketStart::Incomplete);
    }

    #[test]
    fn unknown_masks_are_no_packet() {
        for head in [
            "FA 00",
            "FA 08",
            "FA 20",
            "FA 40",
            "FA 80",
            "FA FA",
            "FA 01 0000",
            "FA 01 0080",
            "FA 02 0004",
            "FA 04 0020",
            "FA 10 0040",
        ] {
            assert_eq!(classify(&bytes(head)), PacketStart::No, "{head}");
        }
    }

    #[test]
    fn the_longest_packet_has_every_field() {
        let header = bytes("FA 17 FF7F FF03 FF1F FF3F");
        let mut packet = [&header[..], &[0x5A; 198 + 59 + 152 + 206]].concat();
        packet.extend(crc16(&packet[1..]).to_be_bytes());
        assert_eq!(packet.len(), MAX_PACKET);
        assert_eq!(classify(&packet), PacketStart::Packet(MAX_PACKET));
    }
}
