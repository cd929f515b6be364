//! The text of a sentence with a correct checksum is read correctly, or refused; settings that were
//! read are unchanged by a write.

use std::fmt::Debug;

use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, Check, Decoder, ImuFilter, Item, Options, ProtocolControl,
    ReferenceFrameRotation, RegisterContents, RegisterValue, Reply, Sample, Sentence, SyncControl, VNIMU,
    WritableValue, crc16, xor8,
};

/// The first byte chooses the checksum; the others that may occur between `$` and `*` are the text.
pub(crate) fn check(input: &[u8]) {
    let [kind, text @ ..] = input else { return };
    let check = if kind & 1 == 0 { Check::Xor8 } else { Check::Crc16 };
    let mut body: Vec<u8> =
        text.iter().copied().filter(|byte| matches!(byte, b' '..=b'~') && !b"$*".contains(byte)).collect();
    body.truncate(vn100_protocol::MAX_BODY);
    let line = line(&body, check);
    let sentence = Sentence { body: &body, raw: line.trim_ascii_end(), check, offset: 0 };

    let sample = Sample::parse(&sentence);
    let reply = Reply::parse(&sentence);
    _ = format!("{:?}{reply:?}", sample.map(|sample| sample.map_err(|error| error.to_string())));
    assert!(reply.is_none() || sentence.is_reply());

    // the decoder, with its fast path, gives the same
    only_item(&line, |item| match item {
        Item::Sample(found) => assert_eq!(Some(Ok(found)), sample),
        Item::Rejected(_) => assert!(matches!(sample, Some(Err(_))) || !sentence.has_name()),
        Item::Reply(found) | Item::Other(found) => {
            assert_eq!((found, sample), (sentence, None));
            assert_eq!(matches!(item, Item::Reply(_)), sentence.is_reply());
        }
        Item::Packet(packet) => panic!("{packet:?} in a sentence"),
    });

    if let Some(Ok(sample)) = sample {
        assert_printed(&sample, &body);
    }
    if let Some(Reply::Register(contents) | Reply::Written(contents)) = reply {
        check_register(&contents);
    }
}

fn line(body: &[u8], check: Check) -> Vec<u8> {
    let digits = match check {
        Check::Crc16 => format!("{:04X}", crc16(body)),
        _ => format!("{:02X}", xor8(body)),
    };
    [b"$", body, b"*", digits.as_bytes(), b"\r\n"].concat()
}

/// A good line is one item, and all of its bytes are used.
fn only_item(line: &[u8], mut expect: impl FnMut(Item<'_>)) {
    let mut decoder = Decoder::new(Options::default());
    let mut items = 0;
    decoder.push(line, |item| {
        items += 1;
        expect(item);
    });
    let tally = decoder.tally();
    assert_eq!((items, tally.valid_sentence_bytes + tally.rejected_sentence_bytes), (1, line.len() as u64));
}

/// Each value equals that read by the standard library from its field, and is in range.
fn assert_printed(sample: &Sample, body: &[u8]) {
    let text = std::str::from_utf8(body).unwrap();
    let channels = &sample.layout.channels;
    assert_eq!(sample.counts().len(), channels.len());
    for (((field, value), count), channel) in
        text.split(',').skip(1).zip(sample.values()).zip(sample.counts()).zip(&**channels)
    {
        assert_eq!(field.parse::<f64>().ok(), Some(value), "{} of {text}", channel.name);
        assert!(count.unsigned_abs() <= channel.limit_counts.unsigned_abs(), "{} of {count}", channel.name);
    }
}

fn check_register(contents: &RegisterContents) {
    fn reads<T: RegisterValue + Debug>(contents: &RegisterContents) {
        _ = contents.value::<T>().map_err(|error| error.to_string());
    }
    fn comes_back<T: WritableValue + PartialEq + Debug>(contents: &RegisterContents) {
        if let Ok(value) = contents.value::<T>() {
            let written = RegisterContents { register: value.register(), fields: value.fields() };
            assert_eq!(written.value::<T>().as_ref(), Ok(&value), "{written:?}");
            assert_eq!(written.register, contents.register);
        }
    }
    reads::<ReferenceFrameRotation>(contents);
    _ = Sample::from_contents(contents, &VNIMU).map_err(|error| error.to_string());
    comes_back::<AsyncRate>(contents);
    comes_back::<AsyncType>(contents);
    comes_back::<BaudRate>(contents);
    reads::<BinaryOutput>(contents);
    comes_back::<ImuFilter>(contents);
    comes_back::<ProtocolControl>(contents);
    comes_back::<SyncControl>(contents);
    assert!(contents.is_as_written(&contents.fields), "{contents:?}");
}
