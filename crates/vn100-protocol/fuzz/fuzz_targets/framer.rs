//! Any bytes, cut anyhow: the same items, every byte counted, no panic.
//!
//! `cargo fuzz run -s none framer` runs on a stable compiler. The first byte of the input sets the options, the second the size of the
//! pieces.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vn100_protocol::{Decoder, Options, Tally};

fuzz_target!(|input: &[u8]| {
    let [options, size, bytes @ ..] = input else { return };
    let options = Options { accept_unchecked: options & 1 == 1 };
    let size = usize::from(*size) + 1;
    assert_eq!(decode(bytes, size, options), decode(bytes, usize::MAX, options));
});

fn decode(bytes: &[u8], size: usize, options: Options) -> (Vec<String>, Tally) {
    let mut decoder = Decoder::new(options);
    let mut items = Vec::new();
    let mut pushed = 0;
    for piece in bytes.chunks(size) {
        decoder.push(piece, |item| items.push(format!("{item:?}")));
        pushed += piece.len() as u64;
        assert_eq!(decoder.tally().bytes(), pushed);
    }
    decoder.finish(|item| items.push(format!("{item:?}")));
    let tally = decoder.tally();
    assert_eq!((tally.bytes(), tally.buffered_bytes), (pushed, 0));
    (items, tally)
}
