//! Bytes are copied only if a piece of the stream ends within a sentence: items point into the
//! pushed piece.

use vn100_protocol::{Decoder, Item, Options};

/// A sentence that is passed on with its bytes.
const LINE: &[u8] = b"$VNYPR,-129.867,-000.355,-000.296*61\r\n";

#[test]
fn items_point_into_the_piece_but_for_one_at_its_border() {
    let bytes = LINE.repeat(10_000);
    for size in [40, 1000, 65_536, bytes.len()] {
        let mut decoder = Decoder::new(Options::default());
        let (mut in_place, mut pieces) = (0, 0);
        for piece in bytes.chunks(size) {
            pieces += 1;
            decoder.push(piece, |item| {
                if let Item::Other(sentence) = item {
                    in_place += u64::from(piece.as_ptr_range().contains(&sentence.raw.as_ptr()));
                }
            });
        }
        let copied = decoder.tally().other - in_place;
        assert_eq!(decoder.tally().other, 10_000);
        assert!(copied < pieces, "{copied} sentences were copied in {pieces} pieces of {size} bytes");
    }
}
