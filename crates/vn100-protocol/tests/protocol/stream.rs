//! Properties of any stream, for every division and any content.

use proptest::{collection::vec, prelude::*, sample::Index};
use vn100_protocol::{
    CheckDigits, Decoder, Frame, Item, Options, RejectReason, crc16,
    stream::{ReadOptions, SampleReader},
    xor8,
};

use crate::support::{YMR, concat, counts, decode_in_pieces, frames, packet, piece, sentence, ymr_body};

/// A naive reader of a whole text: every frame with its place and length, found by trying each `$`
/// separately.
///
/// `Some(true)` is a good sentence, `Some(false)` a bad one. Knows nothing of packets.
fn naive_lines(bytes: &[u8]) -> Vec<(usize, usize, bool)> {
    let mut lines = Vec::new();
    let is_end_of_body = |&byte: &u8| byte == b'$' || byte == b'*' || !(b' '..=b'~').contains(&byte);
    for start in (0..bytes.len()).filter(|&at| bytes[at] == b'$') {
        let behind = &bytes[start + 1..];
        let body = behind.iter().position(is_end_of_body).unwrap_or(behind.len());
        if body > 312 {
            lines.push((start, 1 + 313, false));
            continue;
        }
        let (body, tail) = behind.split_at(body);
        let Some((b'*', tail)) = tail.split_first() else {
            lines.push((start, 1 + body.len(), false));
            continue;
        };
        let text: String = tail.iter().map(|&byte| char::from(byte)).collect();
        // a lower-case letter is a digit if only that makes the checksum correct
        let digits_of = |set: &str| text.chars().take_while(|c| set.contains(*c)).take(5).collect::<String>();
        let is_good = |digits: &str| {
            let digits = digits.to_uppercase();
            digits == format!("{:02X}", xor8(body)) || digits == format!("{:04X}", crc16(body))
        };
        let (upper, any) = (digits_of("0123456789ABCDEF"), digits_of("0123456789ABCDEFabcdef"));
        let takes_any = is_good(&any) || !matches!(upper.len(), 2 | 4);
        let digits = if takes_any && !is_good(&upper) { any } else { upper };
        let good = is_good(&digits);
        let written = match digits.len() {
            2 | 4 => digits.len(),
            _ => text.chars().take_while(char::is_ascii_alphanumeric).count().min(5),
        };
        lines.push((start, 1 + body.len() + 1 + written, good));
    }
    lines
}

/// Streams of lines with any kind of damage and no packet in them.
fn damaged_text() -> impl Strategy<Value = Vec<u8>> {
    #[derive(Debug, Clone)]
    enum Edit {
        Flip(Index, u8),
        Delete(Index, usize),
        Insert(Index, Vec<u8>),
        Splice(Index, Index),
        Truncate(Index),
    }
    let edit = prop_oneof![
        (any::<Index>(), 0_u32..8).prop_map(|(at, bit)| Edit::Flip(at, 1 << bit)),
        (any::<Index>(), 1_usize..150).prop_map(|(at, count)| Edit::Delete(at, count)),
        (any::<Index>(), vec(any::<u8>(), 1..20)).prop_map(|(at, bytes)| Edit::Insert(at, bytes)),
        (any::<Index>(), "[$*\r\n 0-9A-Fx]{1,8}").prop_map(|(at, text)| Edit::Insert(at, text.into_bytes())),
        any::<Index>().prop_map(|at| Edit::Insert(at, vec![b'-'; 320])),
        (any::<Index>(), any::<Index>()).prop_map(|(from, to)| Edit::Splice(from, to)),
        any::<Index>().prop_map(Edit::Truncate),
    ];
    (vec(counts(YMR), 1..6), vec(edit, 0..8)).prop_map(|(rows, edits)| {
        let mut bytes: Vec<u8> = rows.into_iter().flat_map(|row| sentence(&ymr_body(&row)).into_bytes()).collect();
        for edit in edits {
            let length = bytes.len();
            if length == 0 {
                break;
            }
            match edit {
                Edit::Flip(at, mask) => bytes[at.index(length)] ^= mask,
                Edit::Delete(at, count) => drop(bytes.drain(at.index(length)..(at.index(length) + count).min(length))),
                Edit::Insert(at, more) => drop(bytes.splice(at.index(length)..at.index(length), more)),
                Edit::Splice(a, b) => {
                    let (from, to) = (a.index(length).min(b.index(length)), a.index(length).max(b.index(length)));
                    bytes.drain(from..to);
                }
                Edit::Truncate(at) => bytes.truncate(at.index(length)),
            }
        }
        bytes.iter_mut().filter(|byte| **byte == 0xFA).for_each(|byte| *byte = 0xFB);
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn stepping_gives_the_same_as_pushing(pieces in vec(piece(), 0..12), more in 1_usize..200) {
        let bytes = concat(&pieces);
        let (pushed, tally) = decode_in_pieces(&bytes, &[], Options::default());
        let mut decoder = Decoder::new(Options::default());
        let (mut at, mut end, mut items) = (0, 0, Vec::new());
        loop {
            let (consumed, item) = decoder.next(&bytes[at..end], end == bytes.len());
            at += consumed;
            prop_assert_eq!(decoder.tally().bytes(), at as u64);
            match item {
                Some(item) => items.push(crate::support::describe(item)),
                None if end == bytes.len() => break,
                None => {
                    prop_assert!(end - at <= 522, "{} bytes wait", end - at);
                    end = (end + more).min(bytes.len());
                }
            }
        }
        prop_assert_eq!((items, decoder.tally()), (pushed, tally));
    }

    #[test]
    fn whole_lines_and_packets_are_found_next_to_anything(pieces in vec(piece(), 0..12)) {
        let bytes = concat(&pieces);
        let found: Vec<_> = frames(&bytes, Options::default())
            .into_iter()
            .filter_map(|frame| match frame {
                Frame::Sentence(sentence) => Some((sentence.offset, sentence.raw.to_vec())),
                Frame::Packet(packet) => Some((packet.offset, packet.raw.to_vec())),
                Frame::Rejected(_) => None,
            })
            .collect();
        let mut offset = 0;
        for piece in pieces {
            let line_end = piece.bytes.strip_suffix(b"\r\n").filter(|_| piece.bytes.starts_with(b"$"));
            let raw = line_end.unwrap_or(&piece.bytes).to_vec();
            prop_assert!(!piece.whole || found.contains(&(offset, raw)), "lost: {:?}", String::from_utf8_lossy(&piece.bytes));
            offset += piece.bytes.len() as u64;
        }
    }

    #[test]
    fn damaged_lines_agree_with_a_naive_reader(bytes in damaged_text()) {
        let found: Vec<_> = frames(&bytes, Options::default())
            .into_iter()
            .map(|frame| match frame {
                Frame::Sentence(sentence) => (sentence.offset as usize, sentence.raw.len(), true),
                Frame::Rejected(bad) => (bad.offset as usize, bad.raw.len(), false),
                Frame::Packet(packet) => panic!("{packet:?}"),
            })
            .collect();
        let naive = naive_lines(&bytes);
        prop_assert_eq!(&found, &naive);

        let (_, tally) = decode_in_pieces(&bytes, &[], Options::default());
        let line_bytes: usize = naive
            .iter()
            .map(|&(start, length, _)| length + bytes[start + length..].iter().take_while(|byte| b"\r\n".contains(byte)).count())
            .sum();
        prop_assert_eq!(tally.valid_sentence_bytes + tally.rejected_sentence_bytes, line_bytes as u64);
        prop_assert_eq!(tally.skipped_bytes, (bytes.len() - line_bytes) as u64);
        prop_assert_eq!(tally.valid_sentences() + tally.rejected.grammar + tally.rejected.range, naive.iter().filter(|line| line.2).count() as u64);
        prop_assert_eq!(tally.valid_sentences() + tally.rejected.total(), naive.len() as u64);
    }
}

const GOOD: &str = "$VNRRG,01*72\r\n";

/// The items in `bytes`: `good` for the line above, `packet`, or the reason of a rejected line; and
/// the number of skipped bytes.
fn story(bytes: &[u8]) -> (Vec<String>, u64) {
    let mut items = Vec::new();
    let mut decoder = Decoder::new(Options::default());
    let mut tell = |item: Item<'_>| {
        items.push(match item {
            Item::Reply(sentence) => {
                assert_eq!(sentence.raw, GOOD.trim_end().as_bytes());
                "good".into()
            }
            Item::Packet(_) => "packet".into(),
            Item::Rejected(bad) => bad.kind.to_string().split(':').take(1).collect(),
            other => panic!("{other:?}"),
        });
    };
    decoder.push(bytes, &mut tell);
    decoder.finish(&mut tell);
    (items, decoder.tally().skipped_bytes)
}

#[test]
fn a_good_line_is_not_lost_next_to() {
    let packet = packet(7, [1.0, 2.0, 3.0]);
    /// Its name, the pieces of the stream, the items in it, and the number of skipped bytes.
    type Case<'a> = (&'a str, &'a [&'a [u8]], &'a [&'a str], u64);
    let cases: &[Case<'_>] = &[
        ("a dollar", &[b"$", GOOD.as_bytes()], &["truncated", "good"], 0),
        ("dollars", &[b"$$$$", GOOD.as_bytes()], &["truncated", "truncated", "truncated", "truncated", "good"], 0),
        ("a packet's start", &[b"\xFA", GOOD.as_bytes()], &["good"], 1),
        ("a packet's header", &[b"\xFA\x01\x39\x07", GOOD.as_bytes()], &["good"], 4),
        ("packet starts", &[b"\xFA\xFA\xFA", GOOD.as_bytes()], &["good"], 3),
        ("a cut packet", &[&packet[..20], GOOD.as_bytes()], &["good"], 20),
        ("a line without its CR LF", &[GOOD.trim_end().as_bytes(), GOOD.as_bytes()], &["good", "good"], 0),
        ("a bad line without its CR LF", &[b"$VNRRG,01*73", GOOD.as_bytes()], &["checksum", "good"], 0),
        ("a line cut before its checksum", &[b"$VNRRG,01", GOOD.as_bytes()], &["truncated", "good"], 0),
        ("a line cut in its checksum", &[b"$VNRRG,01*7", GOOD.as_bytes()], &["checksum", "good"], 0),
        ("a packet", &[GOOD.as_bytes(), &packet, GOOD.as_bytes()], &["good", "packet", "good"], 0),
        ("a packet right behind the digits", &[GOOD.trim_end().as_bytes(), &packet], &["good", "packet"], 0),
        ("junk in place of its CR", &[b"$VNRRG,01*72\x8D\n"], &["good"], 2),
        ("the end of the stream", &[b"$VNRRG,01*72"], &["good"], 0),
    ];
    for (name, pieces, items, skipped) in cases {
        let told = story(&pieces.concat());
        assert_eq!(told, (items.iter().map(|item| (*item).to_owned()).collect(), *skipped), "{name}");
    }
}

#[test]
fn bad_lines_have_a_kind() {
    for (bytes, kind, skipped) in [
        (&b"$VNRRG,01\r\n"[..], "unchecked", 0),
        (b"$VNRRG,01\n", "unchecked", 0),
        (b"$VNRRG,01*\r\n", "unchecked", 0),
        (b"$VNRRG,01*XX\r\n", "checksum", 0),
        (b"$VNRRG,01*7\r\n", "checksum", 0),
        (b"$VNRRG,01*721\r\n", "checksum", 0),
        (b"$VNRRG,01*E15F0\r\n", "checksum", 0),
        (b"$VNRRG,01*7f\r\n", "checksum", 0),
        (b"$VNRRG,01*E15E\r\n", "checksum", 0),
        (b"$VNRRG,01*", "truncated", 0),
        (b"$VNRRG", "truncated", 0),
        (b"$VNR\x07RG,01*72\r\n", "truncated", 11),
        (b"$VNR\xFARG,01*72\r\n", "truncated", 11),
        (b"$VNYMR,+1.0*5D\r\n", "checksum", 0),
    ] {
        assert_eq!(story(bytes), (vec![kind.to_owned()], skipped), "{}", String::from_utf8_lossy(bytes));
    }
    let long = [&b"$"[..], &[b'x'; 400], b"\r\n"].concat();
    assert_eq!(story(&long), (vec!["too long".to_owned()], 401 - 314 + 2));
}

#[test]
fn a_wrong_checksum_reports_both_values() {
    let mut kinds = Vec::new();
    let mut decoder = Decoder::new(Options::default());
    decoder.push(b"x$VNRRG,01*73\r\n$VNRRG,01*E150\r\n$VNRRG,01*XX\r\n", |item| {
        if let Item::Rejected(bad) = item {
            kinds.push((bad.offset, bad.raw.len(), bad.kind));
        }
    });
    let (xor, crc) = (CheckDigits::Xor8(0x72), CheckDigits::Crc16(0xE15F));
    assert_eq!(
        kinds,
        [
            (1, 12, RejectReason::Checksum { computed: xor, received: Some(CheckDigits::Xor8(0x73)) }),
            (15, 14, RejectReason::Checksum { computed: crc, received: Some(CheckDigits::Crc16(0xE150)) }),
            (31, 12, RejectReason::Checksum { computed: xor, received: None }),
        ]
    );
    assert_eq!(kinds[0].2.to_string(), "checksum: computed 72, received 73");
}

#[test]
fn lines_without_checksum_are_taken_on_request() {
    let mut items = Vec::new();
    let mut decoder = Decoder::new(Options { accept_unchecked: true });
    decoder.push(b"$VNRRG,01\r\n$VNRRG,02*\r\n$VNRRG,01*73\r\n$VNRRG,01*72\r\n", |item| {
        items.push(matches!(item, Item::Reply(_)))
    });
    assert_eq!(items, [true, true, false, true]);
    assert_eq!((decoder.tally().replies, decoder.tally().unchecked_sentences), (3, 2));
}

#[test]
fn a_finished_decoder_begins_a_sentence_of_its_own() {
    let mut decoder = Decoder::new(Options::default());
    let mut good = 0;
    decoder.push(b"$VNRRG,0", |_| good += 1);
    decoder.finish(|item| assert!(matches!(item, Item::Rejected(_))));
    decoder.push(b"1*72\r\n$VNRRG,01*72\r\n", |_| good += 1);
    assert_eq!((good, decoder.tally().replies, decoder.tally().bytes()), (1, 1, 28));
}

#[test]
fn a_cut_packet_does_not_borrow_the_start_of_the_next_line() {
    // a packet whose last byte is a `$`: if it is cut before that byte, the line after it would
    // complete it
    let packet = (0..).map(|time| packet(time, [0.0; 3])).find(|packet| packet.ends_with(b"$")).unwrap();
    let line = b"$VNYPR,-129.867,-000.355,-000.296*61\r\n";
    let cut = [&packet[..packet.len() - 1], line].concat();
    let whole = [&packet[..], line].concat();
    for (bytes, packets) in [(&cut, 0), (&whole, 1)] {
        for size in [1, 7, bytes.len()] {
            let mut decoder = Decoder::new(Options::default());
            bytes.chunks(size).for_each(|piece| decoder.push(piece, |_| {}));
            decoder.finish(|_| {});
            assert_eq!((decoder.tally().other, decoder.tally().packets), (1, packets), "pieces of {size}");
        }
    }
}

#[test]
fn a_sentence_that_the_end_cuts_is_counted_as_such() {
    const BODY: &str =
        "VNIMU,+01.0640,-00.2531,+03.0614,+00.005,+00.344,-09.758,-0.001222,-0.000450,-0.001218,+16.8,+103.186";
    let (line, damaged) = (sentence(BODY), format!("${BODY}*00\r\n"));
    for cut in 1..line.len() {
        let mut reader = SampleReader::new(ReadOptions::default());
        reader.push(format!("{line}{damaged}{}", &line[..cut]).as_bytes(), None);
        let link = reader.finish().last().unwrap().link;
        assert_eq!(link.tally.rejected.total(), 1 + link.cut_sentences, "cut at {cut}");
        assert_eq!(link.samples() + link.cut_sentences, 2, "cut at {cut}");
    }
}
