//! Shared parts of the tests of this crate: lines printed by the standard library, pieces of a
//! stream, and ways to cut it.

pub(crate) mod bench;

use proptest::{
    collection::vec,
    prelude::*,
    sample::{Index, select},
};
use vn100_protocol::{
    Check, Decoder, Frame, Framer, Item, Options, RegisterContents, Reply, SensorCommand, Tally, crc16, xor8,
};

/// The printed form of a number in the maker's manual: the minimum width and the decimals of C's
/// printf, and the largest accepted magnitude, in units of the last decimal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Form(pub(crate) usize, pub(crate) usize, pub(crate) i32);

const ANGLE: Form = Form(8, 3, 180_000);
const QUATERNION: Form = Form(9, 6, 2_000_000);
const MAG: Form = Form(8, 4, 100_000);
const ACCEL: Form = Form(7, 3, 200_000);
const RATE: Form = Form(10, 6, 40_000_000);

/// The messages according to the manual, and the form of the first in old firmware, counted in its
/// own decimals.
pub(crate) const YMR: &[Form] = &[ANGLE, ANGLE, ANGLE, MAG, MAG, MAG, ACCEL, ACCEL, ACCEL, RATE, RATE, RATE];
pub(crate) const IMU: &[Form] =
    &[MAG, MAG, MAG, ACCEL, ACCEL, ACCEL, RATE, RATE, RATE, Form(5, 1, 2_000), Form(10, 3, 200_000)];
pub(crate) const MAR: &[Form] = &[MAG, MAG, MAG, ACCEL, ACCEL, ACCEL, RATE, RATE, RATE];
pub(crate) const QMR: &[Form] =
    &[QUATERNION, QUATERNION, QUATERNION, QUATERNION, MAG, MAG, MAG, ACCEL, ACCEL, ACCEL, RATE, RATE, RATE];
const OLD_ANGLE: Form = Form(7, 2, 18_000);
const OLD_MAG: Form = Form(7, 4, 100_000);
const OLD_RATE: Form = Form(8, 4, 400_000);
#[rustfmt::skip]
pub(crate) const OLD_YMR: &[Form] = &[
    OLD_ANGLE, OLD_ANGLE, OLD_ANGLE, OLD_MAG, OLD_MAG, OLD_MAG, ACCEL, ACCEL, ACCEL, OLD_RATE, OLD_RATE, OLD_RATE,
];

/// Every message that is measured.
pub(crate) const MESSAGES: [(&str, &[Form]); 4] = [("VNYMR", YMR), ("VNIMU", IMU), ("VNMAR", MAR), ("VNQMR", QMR)];

/// A sentence from `body`, XOR-8, CR LF.
pub(crate) fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

/// The body of a message as C's printf of floats writes it.
pub(crate) fn body(header: &str, forms: &[Form], counts: &[i32]) -> String {
    forms.iter().zip(counts).fold(header.to_owned(), |body, (&Form(width, decimals, _), &count)| {
        let value = f64::from(count) / 10_f64.powi(decimals as i32);
        format!("{body},{value:+0width$.decimals$}")
    })
}

pub(crate) fn ymr_body(counts: &[i32]) -> String {
    body("VNYMR", YMR, counts)
}

/// Counts within the range of their channels.
pub(crate) fn counts(forms: &'static [Form]) -> impl Strategy<Value = Vec<i32>> {
    let count = |limit: i32| prop_oneof![4 => -limit..=limit, 1 => -limit / 1000..=limit / 1000, 1 => Just(0), 1 => Just(limit), 1 => Just(-limit)];
    forms.iter().map(|form| count(form.2)).collect::<Vec<_>>()
}

/// A message and its counts.
pub(crate) fn sample() -> impl Strategy<Value = (&'static str, &'static [Form], Vec<i32>)> {
    select(&MESSAGES[..]).prop_flat_map(|(header, forms)| counts(forms).prop_map(move |counts| (header, forms, counts)))
}

/// A packet with the fields of `mask` 01 (common group) and a correct CRC.
pub(crate) fn packet(time: u64, values: [f32; 3]) -> Vec<u8> {
    let mut packet = vec![0xFA, 0x01, 0x09, 0x00];
    packet.extend(time.to_le_bytes());
    packet.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    packet.extend(crc16(&packet[1..]).to_be_bytes());
    packet
}

/// One piece of a stream, and whether a reader must find it complete.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) bytes: Vec<u8>,
    pub(crate) whole: bool,
}

/// Good lines, packets, pieces of both, and bytes with a meaning for a reader.
pub(crate) fn piece() -> impl Strategy<Value = Piece> {
    let whole = |bytes: Vec<u8>| Piece { bytes, whole: true };
    let noise = || vec(prop_oneof![3 => select(&b"$*\r\n0AF,X \xFA\x01\x09\x00VN"[..]), 1 => any::<u8>()], 0..40);
    let line = || {
        prop_oneof![
            4 => sample().prop_map(|(header, forms, counts)| sentence(&body(header, forms, &counts))),
            1 => (-5_000_i32..5_000).prop_map(|n| sentence(&format!("VNRRG,{n}"))),
            1 => Just("$VNRRG,75,3,400,01,0321*3B31\r\n".to_owned()),
        ]
        .prop_map(String::into_bytes)
    };
    let packet = || (any::<u64>(), any::<[f32; 3]>()).prop_map(|(time, values)| packet(time, values));
    prop_oneof![
        4 => line().prop_map(whole),
        2 => packet().prop_map(whole),
        2 => noise().prop_map(|bytes| Piece { bytes, whole: false }),
        1 => (line(), any::<Index>()).prop_map(|(line, cut)| cut_at(line, cut)),
        // without only its last byte, a packet would be completed by a `$` after it, once in 256 times
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

/// An item as text, with its bytes as evidence: enough to compare items with different lifetimes.
pub(crate) fn describe(item: Item<'_>) -> String {
    format!("{item:?}")
}

/// Decodes `bytes` in pieces of the given sizes, in turn; checks the tally after each piece.
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

/// All frames that the framer finds in the undivided `bytes`.
pub(crate) fn frames(bytes: &[u8], options: Options) -> Vec<Frame<'_>> {
    let mut framer = Framer::new(options);
    let mut frames = Vec::new();
    let mut at = 0;
    loop {
        let (consumed, frame) = framer.next(&bytes[at..], true);
        at += consumed;
        match frame {
            Some(frame) => frames.push(frame),
            None => break,
        }
    }
    assert_eq!(at, bytes.len());
    frames
}

/// The reply in a line, with or without CR and LF.
pub(crate) fn parse_reply(line: &str) -> Option<Reply> {
    match frames(line.as_bytes(), Options::default())[..] {
        [Frame::Sentence(sentence)] => Reply::parse(&sentence),
        ref other => panic!("{line}: {other:?}"),
    }
}

pub(crate) fn reply(body: &str) -> Reply {
    parse_reply(&sentence(body)).unwrap()
}

/// The contents of a register, from the line that answers a read.
pub(crate) fn contents(line: &str) -> RegisterContents {
    match parse_reply(line) {
        Some(Reply::Register(contents)) => contents,
        other => panic!("{line}: {other:?}"),
    }
}

/// The line of a command, without CR and LF.
pub(crate) fn line(command: &SensorCommand, check: Check) -> String {
    let line = command.sentence(check);
    line.strip_suffix("\r\n").unwrap().to_owned()
}
