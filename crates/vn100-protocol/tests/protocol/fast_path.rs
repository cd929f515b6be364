//! The decoder with its fast path against the framer and the message parser, which do not have one.

use proptest::{
    collection::vec,
    prelude::*,
    sample::{Index, select},
};
use vn100_protocol::{Frame, GrammarError, Item, Options, RejectReason, RejectedSentence, Sample, xor8};

use crate::support::{YMR, counts, decode_in_pieces, describe, frames, sentence, ymr_body};

/// The items of a stream of lines without the fast path.
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

/// Puts the correct digits at the end of a line, so that only the content decides.
fn correct_checksum(line: &mut [u8]) {
    let star = line.len() - 5;
    let digits = format!("{:02X}", xor8(&line[1..star]));
    line[star + 1..star + 3].copy_from_slice(digits.as_bytes());
}

const LINES: [&str; 7] = [
    "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n",
    "$VNYMR,-179.999,-000.000,+180.000,+09.9999,-10.0000,+00.0000,-99.999,+00.000,-00.000,+40.000000,-00.000000,-39.999999*6D\r\n",
    "$VNYMR,+000.000,+000.000,+000.000,+00.0000,+00.0000,+00.0000,+00.000,+00.000,+00.000,+00.000000,+00.000000,+00.000000*60\r\n",
    "$VNIMU,+00.2263,-00.1184,+00.0624,+00.049,-00.009,-09.722,-00.001453,-00.000175,+00.000531,+33.0,+00101.326*63\r\n",
    "$VNIMU,+10.0000,-10.0000,+09.9999,+99.999,-99.999,+00.000,-40.000000,+40.000000,-39.999999,-99.9,+00200.000*00\r\n",
    "$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66\r\n",
    "$VNIMU,-10.0000,+10.0000,-09.9999,-99.999,+99.999,-00.000,+40.000000,-40.000000,+39.999999,+99.9,-200.000*00\r\n",
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
                if (1..line.len() - 5).contains(&at) {
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
        line in prop_oneof![counts(YMR).prop_map(|row| sentence(&ymr_body(&row))), select(&LINES[3..]).prop_map(str::to_owned)],
        changes in vec((any::<Index>(), prop_oneof![any::<u8>(), select(&b"+-,.0123456789*$"[..])]), 1..6),
        correct: bool,
        neighbour in counts(YMR),
    ) {
        let mut line = line.into_bytes();
        for (at, byte) in changes {
            let end = line.len() - 2;
            line[1..end][at.index(end - 1)] = byte;
        }
        if correct {
            correct_checksum(&mut line);
        }
        line.extend(sentence(&ymr_body(&neighbour)).bytes());
        assert_paths_agree(&line);
    }
}
