//! Any bytes in any pieces: the same items, every byte and every line counted.

use vn100_protocol::{Decoder, Item, Options, Tally};

/// The first byte sets the options, the second the size of the pieces.
pub(crate) fn check(input: &[u8]) {
    let [options, size, bytes @ ..] = input else { return };
    let options = Options { accept_unchecked: options & 1 == 1 };
    let whole = decode(bytes, usize::MAX, options);
    assert_eq!(decode(bytes, usize::from(*size) + 1, options), whole);
}

/// Every item as text, and the counts.
pub(super) fn decode(bytes: &[u8], size: usize, options: Options) -> (Vec<String>, Tally) {
    let mut decoder = Decoder::new(options);
    let (mut items, mut pushed, mut good, mut bad) = (Vec::new(), 0, 0, 0);
    let mut take = |item: Item<'_>| {
        match item {
            Item::Rejected(line) => {
                bad += 1;
                // the evidence equals the bytes at its place
                assert_eq!(&bytes[line.offset as usize..][..line.raw.len()], line.raw);
            }
            Item::Packet(packet) => assert_eq!(&bytes[packet.offset as usize..][..packet.raw.len()], packet.raw),
            _ => good += 1,
        }
        items.push(format!("{item:?}"));
    };
    for piece in bytes.chunks(size) {
        decoder.push(piece, &mut take);
        pushed += piece.len() as u64;
        assert_eq!(decoder.tally().bytes(), pushed);
    }
    decoder.finish(&mut take);
    let tally = decoder.tally();
    assert_eq!((tally.bytes(), tally.buffered_bytes), (pushed, 0));
    assert_eq!((tally.valid_sentences(), tally.rejected.total()), (good, bad));
    (items, tally)
}
