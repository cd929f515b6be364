//! The decoder with its fast path against the framer and the message parser, which do not have one.

use proptest::{collection::vec, prelude::*, sample::select};
use vn100_protocol::{Frame, GrammarError, Item, Options, RejectReason, RejectedSentence, Sample, xor8};

use crate::support::{YMR, counts, decode_in_pieces, describe, frames, sentence, ymr_body};

/// The items of a stream of `VNYMR` lines without the fast path.
fn items_of_the_general_path(bytes: &[u8]) -> Vec<String> {
    let items = frames(bytes, Options::default()).into_iter().map(|frame| match frame {
        Frame::Packet(packet) => Item::Packet(packet),
        Frame::Rejected(bad) => Item::Rejected(bad),
        Frame::Sentence(sentence) => match Sample::parse(&sentence) {
            Some(Ok(sample)) => Item::Sample(sample),
            Some(Err(kind)) => Item::Rejected(RejectedSentence { kind, raw: sentence.raw, offset: sentence.offset }),
            None if !sentence.has_name() => {
                let kind = RejectReason::Grammar(GrammarError::Name);
                Item::Rejected(RejectedSentence { kind, raw: sentence.raw, offset: sentence.offset })
            }
            None if sentence.is_reply() => Item::Reply(sentence),
            None => Item::Other(sentence),
        },
    });
    items.map(describe).collect()
}

fn assert_paths_agree(bytes: &[u8]) {
    let (items, _) = decode_in_pieces(bytes, &[], Options::default());
    assert_eq!(items, items_of_the_general_path(bytes), "{}", String::from_utf8_lossy(bytes));
}

/// Puts the correct digits after the `*` at its usual place, so that only the content decides.
fn correct_checksum(line: &mut [u8]) {
    let digits = format!("{:02X}", xor8(&line[1..117]));
    line[118..120].copy_from_slice(digits.as_bytes());
}

const LINES: [&str; 3] = [
    "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n",
    "$VNYMR,-179.999,-000.000,+180.000,+09.9999,-10.0000,+00.0000,-99.999,+00.000,-00.000,+40.000000,-00.000000,-39.999999*6D\r\n",
    "$VNYMR,+000.000,+000.000,+000.000,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,+00.000000,+00.000000,+00.000000*60\r\n",
];

#[test]
fn every_change_of_one_byte_is_judged_alike() {
    for line in LINES {
        let mut line = line.as_bytes().to_vec();
        correct_checksum(&mut line);
        assert_paths_agree(&line);
        for at in 0..line.len() {
            for byte in 0..=u8::MAX {
                let mut changed = line.clone();
                changed[at] = byte;
                assert_paths_agree(&changed);
                if (1..117).contains(&at) {
                    correct_checksum(&mut changed);
                    assert_paths_agree(&changed);
                }
            }
        }
    }
}

#[test]
fn limits_are_the_same() {
    for (index, &crate::support::Form(.., limit)) in YMR.iter().enumerate() {
        for count in [limit - 1, limit, limit + 1, -limit + 1, -limit, -limit - 1] {
            let mut row = [0; 12];
            row[index] = count;
            let line = sentence(&ymr_body(&row));
            assert_paths_agree(line.as_bytes());
            let (items, _) = decode_in_pieces(line.as_bytes(), &[], Options::default());
            assert_eq!(items[0].starts_with("Sample"), count.abs() <= limit, "{line}");
        }
    }
}

proptest! {
    #[test]
    fn good_lines_are_read_alike_and_right(rows in vec(counts(YMR), 1..8)) {
        let bytes: String = rows.iter().map(|row| sentence(&ymr_body(row))).collect();
        assert_paths_agree(bytes.as_bytes());
        let mut decoder = vn100_protocol::Decoder::new(Options::default());
        let mut read = Vec::new();
        decoder.push(bytes.as_bytes(), |item| match item {
            Item::Sample(sample) => read.push(sample.counts().to_vec()),
            other => panic!("{other:?}"),
        });
        prop_assert_eq!(read, rows);
    }

    #[test]
    fn changes_of_many_bytes_are_judged_alike(
        row in counts(YMR),
        changes in vec((1_usize..120, prop_oneof![any::<u8>(), select(&b"+-,.0123456789*$"[..])]), 1..6),
        correct: bool,
        neighbour in counts(YMR),
    ) {
        let mut line = sentence(&ymr_body(&row)).into_bytes();
        for (at, byte) in changes {
            line[at] = byte;
        }
        if correct {
            correct_checksum(&mut line);
        }
        line.extend(sentence(&ymr_body(&neighbour)).bytes());
        assert_paths_agree(&line);
    }
}
