//! Bytes with a correct CRC after them: a packet or none, and the lines around it remain lines.

use vn100_protocol::{BinaryOutput, Decoder, Item, MAX_PACKET, Options, crc16};

const LINE: &[u8] = b"$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

/// The bytes after 0xFA in a packet, without its CRC.
pub(crate) fn check(content: &[u8]) {
    let crc = crc16(content).to_be_bytes();
    let stream = [LINE, &[0xFA], content, &crc, LINE].concat();
    let whole = super::framer::decode(&stream, usize::MAX, Options::default());
    assert_eq!(super::framer::decode(&stream, 7, Options::default()), whole);

    let mut decoder = Decoder::new(Options::default());
    let mut first_line = false;
    let mut found = None;
    let mut take = |item: Item<'_>| match item {
        Item::Sample(_) => first_line |= found.is_none(),
        Item::Packet(packet) => {
            assert_eq!((packet.raw[0], crc16(&packet.raw[1..])), (0xFA, 0));
            assert!(packet.raw.len() <= MAX_PACKET && packet.offset >= LINE.len() as u64);
            assert_eq!(announced_length(packet.raw), Some(packet.raw.len()));
            found.get_or_insert(packet.raw.len());
        }
        _ => {}
    };
    decoder.push(&stream, &mut take);
    decoder.finish(&mut take);
    assert!(first_line, "the line before it");
    // the stream begins with its line, and no good line reaches into a packet: a packet with a valid head and CRC is
    // found
    if announced_length(&stream[LINE.len()..]) == Some(content.len() + 3) && !content.contains(&b'$') {
        assert_eq!(found, Some(content.len() + 3));
        assert_eq!(decoder.tally().samples, 2, "the line behind it");
    }
}

/// The length according to the masks at the head of `packet`, from the register that requests such
/// packets.
fn announced_length(packet: &[u8]) -> Option<usize> {
    let groups = *packet.get(1)?;
    let words = packet.get(2..2 + 2 * groups.count_ones() as usize)?;
    let field_words = words.chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]])).collect();
    BinaryOutput { async_mode: 1, rate_divisor: 1, groups, field_words }.packet_length()
}
