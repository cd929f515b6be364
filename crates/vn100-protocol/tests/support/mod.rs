//! What the tests of this crate share: lines printed by the standard library, pieces of a stream,
//! and ways to cut it.
#![allow(dead_code, reason = "each test uses its part")]
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

pub(crate) mod bench;

use proptest::{
    collection::vec,
    prelude::*,
    sample::{Index, select},
};
use vn100_protocol::{
    Check, Command, Decoder, Frame, Framer, Item, Options, RegisterContents, Reply, ReplyError, Tally, crc16, xor8,
};

/// The largest count of each channel that is in range.
pub(crate) const LIMITS: [i32; 12] = [
    180_000, 180_000, 180_000, 100_000, 100_000, 100_000, 200_000, 200_000, 200_000, 40_000_000, 40_000_000, 40_000_000,
];

/// A sentence from `body`, XOR-8, CR LF.
pub(crate) fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

/// The body of a `VNYMR` as C's printf of floats writes it.
pub(crate) fn ymr_body(counts: [i32; 12]) -> String {
    let value = |index: usize, scale: f64| f64::from(counts[index]) / scale;
    let angle = |i| format!("{:+08.3}", value(i, 1e3));
    let mag = |i| format!("{:+08.4}", value(i, 1e4));
    let accel = |i| format!("{:+07.3}", value(i, 1e3));
    let gyro = |i| format!("{:+010.6}", value(i, 1e6));
    let fields = [0, 1, 2]
        .map(angle)
        .into_iter()
        .chain([3, 4, 5].map(mag))
        .chain([6, 7, 8].map(accel))
        .chain([9, 10, 11].map(gyro));
    fields.fold("VNYMR".into(), |body, field| body + "," + &field)
}

/// The same in the widths of old firmware, which prints fewer decimals; `counts` are in those.
pub(crate) fn old_ymr_body(counts: [i32; 12]) -> String {
    let value = |index: usize, scale: f64| f64::from(counts[index]) / scale;
    let angle = |i| format!("{:+07.2}", value(i, 1e2));
    let mag = |i| format!("{:+07.4}", value(i, 1e4));
    let accel = |i| format!("{:+07.3}", value(i, 1e3));
    let gyro = |i| format!("{:+08.4}", value(i, 1e4));
    let fields = [0, 1, 2]
        .map(angle)
        .into_iter()
        .chain([3, 4, 5].map(mag))
        .chain([6, 7, 8].map(accel))
        .chain([9, 10, 11].map(gyro));
    fields.fold("VNYMR".into(), |body, field| body + "," + &field)
}

/// Counts within the range of their channels.
pub(crate) fn counts() -> impl Strategy<Value = [i32; 12]> {
    LIMITS.map(|limit| prop_oneof![4 => -limit..=limit, 1 => -limit / 1000..=limit / 1000, 1 => Just(0), 1 => Just(limit), 1 => Just(-limit)])
}

/// A packet with the fields of `mask` 01 (common group) and a right CRC.
pub(crate) fn packet(time: u64, values: [f32; 3]) -> Vec<u8> {
    let mut packet = vec![0xFA, 0x01, 0x09, 0x00];
    packet.extend(time.to_le_bytes());
    packet.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    packet.extend(crc16(&packet[1..]).to_be_bytes());
    packet
}

/// One piece of a stream, and whether a reader must find it whole.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) bytes: Vec<u8>,
    pub(crate) whole: bool,
}

/// Good lines, packets, pieces of both, and bytes that mean something to a reader.
pub(crate) fn piece() -> impl Strategy<Value = Piece> {
    let whole = |bytes: Vec<u8>| Piece { bytes, whole: true };
    let noise = || vec(prop_oneof![3 => select(&b"$*\r\n0AF,X \xFA\x01\x09\x00VN"[..]), 1 => any::<u8>()], 0..40);
    let line = || {
        prop_oneof![
            counts().prop_map(|counts| sentence(&ymr_body(counts))),
            (-5_000_i32..5_000).prop_map(|n| sentence(&format!("VNRRG,{n}"))),
            Just("$VNRRG,75,3,400,01,0321*3B31\r\n".to_owned()),
        ]
        .prop_map(String::into_bytes)
    };
    let packet = || (any::<u64>(), any::<[f32; 3]>()).prop_map(|(time, values)| packet(time, values));
    prop_oneof![
        4 => line().prop_map(whole),
        2 => packet().prop_map(whole),
        2 => noise().prop_map(|bytes| Piece { bytes, whole: false }),
        1 => (line(), any::<Index>()).prop_map(|(line, cut)| cut_at(line, cut)),
        // without its last byte alone a packet would be made whole by a `$` behind it, once in 256 times
        1 => (packet(), any::<Index>()).prop_map(|(mut packet, cut)| {
            packet.truncate(packet.len() - 2);
            cut_at(packet, cut)
        }),
    ]
}

fn cut_at(mut bytes: Vec<u8>, cut: Index) -> Piece {
    bytes.truncate(cut.index(bytes.len()));
    Piece { bytes, whole: false }
}

pub(crate) fn concat(pieces: &[Piece]) -> Vec<u8> {
    pieces.iter().flat_map(|piece| piece.bytes.clone()).collect()
}

/// An item as text, and the bytes it shows as evidence: enough to compare items that do not live as
/// long.
pub(crate) fn describe(item: Item<'_>) -> String {
    format!("{item:?}")
}

/// Decodes `bytes` in pieces of the given sizes, over and over; checks the tally at every stop.
pub(crate) fn decode_in_pieces(bytes: &[u8], sizes: &[usize], options: Options) -> (Vec<String>, Tally) {
    let mut decoder = Decoder::new(options);
    let mut items = Vec::new();
    let mut rest = bytes;
    let mut sizes = sizes.iter().cycle();
    while !rest.is_empty() {
        let size = sizes.next().copied().unwrap_or(rest.len()).min(rest.len());
        decoder.push(&rest[..size], |item| items.push(describe(item)));
        rest = &rest[size..];
        assert_eq!(decoder.tally().bytes(), (bytes.len() - rest.len()) as u64);
    }
    decoder.finish(|item| items.push(describe(item)));
    let tally = decoder.tally();
    assert_eq!((tally.bytes(), tally.buffered_bytes), (bytes.len() as u64, 0));
    (items, tally)
}

/// Everything the framer finds in `bytes`, offered whole.
pub(crate) fn frames(bytes: &[u8], options: Options) -> Vec<Frame<'_>> {
    let mut framer = Framer::new(options);
    let mut frames = Vec::new();
    let mut at = 0;
    loop {
        let step = framer.next(&bytes[at..], true);
        at += step.consumed;
        match step.item {
            Some(frame) => frames.push(frame),
            None => break,
        }
    }
    assert_eq!(at, bytes.len());
    frames
}

/// The reply in a line, with or without CR and LF.
pub(crate) fn parse_reply(line: &str) -> Result<Reply, ReplyError> {
    match frames(line.as_bytes(), Options::default())[..] {
        [Frame::Sentence(sentence)] => Reply::parse(&sentence),
        ref other => panic!("{line}: {other:?}"),
    }
}

/// The reply with this body.
pub(crate) fn reply(body: &str) -> Reply {
    parse_reply(&sentence(body)).unwrap()
}

/// What a register holds, by the line that answers a read.
pub(crate) fn contents(line: &str) -> RegisterContents {
    match parse_reply(line) {
        Ok(Reply::Register(contents)) => contents,
        other => panic!("{line}: {other:?}"),
    }
}

/// The line of a command, without CR and LF.
pub(crate) fn line(command: &Command, check: Check) -> String {
    let mut line = String::new();
    command.encode(check, &mut line).unwrap();
    line.strip_suffix("\r\n").unwrap().to_owned()
}
