//! The text of a sentence with a right checksum: read as what it is, or refused; what is read comes
//! back when it is written.

use std::fmt::Debug;

use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, Calibration, Check, Decimal, Decoder, DeltaSettings, Firmware,
    HardwareRevision, HsiControl, HsiResult, Imu, ImuFilter, Item, Layout, Model, Options, ProtocolControl,
    ReferenceFrameRotation, ReferenceVectors, RegisterContents, RegisterValue, Reply, Sentence, SerialNumber, Setting,
    StartupGyroBias, SyncControl, VNIMU, VNYMR, VpeControl, Ymr, crc16, xor8,
};

/// The first byte chooses the checksum; what can stand between `$` and `*` of the others is the
/// text.
pub(crate) fn check(input: &[u8]) {
    let [kind, text @ ..] = input else { return };
    let check = if kind & 1 == 0 { Check::Xor8 } else { Check::Crc16 };
    let mut body: Vec<u8> =
        text.iter().copied().filter(|byte| matches!(byte, b' '..=b'~') && !b"$*".contains(byte)).collect();
    body.truncate(vn100_protocol::MAX_BODY);
    let line = line(&body, check);
    let sentence = Sentence { body: &body, raw: line.trim_ascii_end(), check, offset: 0 };

    let ymr = Ymr::parse(&sentence);
    let imu = Imu::parse(&sentence);
    let reply = Reply::parse(&sentence);
    _ = (format!("{:?}{:?}", ymr.map_err(|e| e.to_string()), imu.map_err(|e| e.to_string())), format!("{reply:?}"));
    assert!(reply.is_err() || sentence.is_reply());

    // the decoder, with its fast path, says the same
    let header = sentence.header();
    only_item(&line, |item| match item {
        Item::Ymr(found) => assert_eq!(Ok(found), ymr),
        Item::Imu(found) => assert_eq!(Ok(found), imu),
        Item::Bad(_) => assert!(header == b"VNYMR" && ymr.is_err() || header == b"VNIMU" && imu.is_err()),
        Item::Reply(found) | Item::Other(found) => {
            assert_eq!((found, ymr.is_err(), imu.is_err()), (sentence, true, true));
            assert_eq!(matches!(item, Item::Reply(_)), sentence.is_reply());
        }
        Item::Packet(packet) => panic!("{packet:?} in a sentence"),
    });

    if let Ok(ymr) = ymr {
        assert_in_range(ymr.counts(), &VNYMR);
        let mut again = String::new();
        ymr.encode(check, &mut again).unwrap();
        only_item(again.as_bytes(), |item| assert_eq!(item, Item::Ymr(ymr)));
    }
    if let Ok(imu) = imu {
        assert_in_range(imu.counts(), &VNIMU);
        let mut again = String::new();
        imu.encode(check, &mut again).unwrap();
        only_item(again.as_bytes(), |item| assert_eq!(item, Item::Imu(imu)));
    }
    if let Ok(Reply::Register(contents) | Reply::Written(contents)) = reply {
        check_register(&contents);
    }
    body.split(|&byte| byte == b',').for_each(check_decimal);
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
    assert_eq!((items, tally.good_line_bytes + tally.bad_line_bytes), (1, line.len() as u64));
}

fn assert_in_range(counts: &[i32], layout: &Layout) {
    for (count, channel) in counts.iter().zip(&*layout.channels) {
        assert!(count.unsigned_abs() <= channel.limit_counts.unsigned_abs(), "{} of {count}", channel.name);
    }
}

fn check_decimal(field: &[u8]) {
    if let Ok(number) = Decimal::parse(field) {
        let mut again = String::new();
        number.write(&mut again, 1).unwrap();
        assert_eq!(Decimal::parse(again.as_bytes()), Ok(number), "{}", field.escape_ascii());
    }
}

fn check_register(contents: &RegisterContents) {
    fn reads<T: RegisterValue + Debug>(contents: &RegisterContents) {
        _ = contents.value::<T>().map_err(|error| error.to_string());
    }
    fn comes_back<T: Setting + PartialEq + Debug>(contents: &RegisterContents) {
        if let Ok(value) = contents.value::<T>() {
            let written = RegisterContents { register: value.register(), fields: value.fields(), ..contents.clone() };
            assert_eq!(written.value::<T>().as_ref(), Ok(&value), "{written:?}");
            assert_eq!(written.register, contents.register);
        }
    }
    reads::<Model>(contents);
    reads::<HardwareRevision>(contents);
    reads::<SerialNumber>(contents);
    reads::<Firmware>(contents);
    reads::<HsiResult>(contents);
    reads::<Imu>(contents);
    comes_back::<AsyncRate>(contents);
    comes_back::<AsyncType>(contents);
    comes_back::<BaudRate>(contents);
    comes_back::<BinaryOutput>(contents);
    comes_back::<Calibration>(contents);
    comes_back::<DeltaSettings>(contents);
    comes_back::<HsiControl>(contents);
    comes_back::<ImuFilter>(contents);
    comes_back::<ProtocolControl>(contents);
    comes_back::<ReferenceFrameRotation>(contents);
    comes_back::<ReferenceVectors>(contents);
    comes_back::<StartupGyroBias>(contents);
    comes_back::<SyncControl>(contents);
    comes_back::<VpeControl>(contents);
    assert!(contents.is_as_written(&contents.fields), "{contents:?}");
}
