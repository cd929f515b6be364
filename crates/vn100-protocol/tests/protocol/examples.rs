//! Lines printed by sensors and their maker, and lines printed here according to the maker's manual.

use proptest::prelude::*;
use vn100_protocol::{
    Decoder, Frame, GrammarError, Item, Layout, Options, PrintFormat, RejectReason, Sample, Suffix, VNIMU, VNMAR,
    VNQMR, VNYMR, xor8,
};

use crate::support::{body, counts, frames, sentence};

/// Bodies as recorded, by firmware 2 and 3 of several sensors, with their recorded check digits.
const YMR: [(&str, &str); 14] = [
    (
        "VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391",
        "63",
    ),
    (
        "VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391",
        "0B58",
    ),
    (
        "VNYMR,-085.476,+074.973,+063.745,-00.5552,+00.4334,+00.9062,+08.992,-02.114,-01.105,+00.002040,-00.000298,-00.000980",
        "6C",
    ),
    (
        "VNYMR,-085.481,+074.976,+063.739,-00.5530,+00.4392,+00.9042,+08.963,-02.140,-01.046,-00.000959,+00.000204,-00.001733",
        "68",
    ),
    (
        "VNYMR,+148.954,+001.254,+000.995,-00.5664,-00.1587,+00.4170,+00.212,-00.169,-09.817,-00.000168,+00.000295,-00.000137",
        "68",
    ),
    (
        "VNYMR,+170.786,-005.153,+009.880,-00.1957,+00.2218,+00.6401,-00.952,-02.181,-09.775,-00.074567,+00.621957,-01.272982",
        "68",
    ),
    (
        "VNYMR,-133.974,-000.382,-000.760,-00.1565,+00.1618,+00.3073,-00.083,+00.134,-09.922,+00.001379,+00.000812,+00.000381",
        "63",
    ),
    (
        "VNYMR,-046.363,-001.254,-000.357,+00.2658,+00.4994,+00.1309,-00.281,-01.077,-09.525,-00.016486,-00.004867,-00.327177",
        "6B",
    ),
    (
        "VNYMR,-077.616,-001.322,+000.143,+00.0452,+00.2449,-00.3347,-00.249,-00.019,-09.893,+00.001117,+00.000227,-00.000329",
        "63",
    ),
    (
        "VNYMR,+015.169,+001.134,-000.930,+00.3679,+00.0580,+00.5148,+00.470,-00.577,-10.014,+00.002068,-00.103333,-00.305281",
        "63",
    ),
    (
        "VNYMR,-082.171,-044.329,-135.904,+00.3385,-00.2514,+00.0610,-32.044,+06.154,+01.762,+09.803607,-11.823348,-04.562857",
        "60",
    ),
    (
        "VNYMR,-118.034,-024.276,-062.915,+00.3261,-00.2790,+00.2276,-39.242,+123.931,-58.612,-00.223137,+02.140320,-03.657718",
        "52",
    ),
    (
        "VNYMR,-000.326,+088.263,-034.861,-00.2266,+00.2469,-00.5156,-19.679,-40.886,-143.685,-06.326948,-00.046931,-00.119262",
        "55",
    ),
    ("VNYMR,-170.94,+007.34,+000.70,-1.7866,+0.1747,+2.2113,-00.085,+00.005,-09.847,+00.0003,-00.0012,-00.0001", "61"),
];

const IMU: &str =
    "VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322";

fn only_item(line: &str, check: impl FnOnce(Item<'_>)) {
    let mut decoder = Decoder::new(Options::default());
    let mut check = Some(check);
    let mut take = |item: Item<'_>| check.take().expect("one item")(item);
    decoder.push(line.as_bytes(), &mut take);
    decoder.finish(&mut take);
    assert!(check.is_none(), "no item in {line}");
    assert_eq!(decoder.tally().bytes(), line.len() as u64);
}

fn sample(line: &str) -> Sample {
    let mut found = None;
    only_item(line, |item| match item {
        Item::Sample(sample) => found = Some(sample),
        other => panic!("{other:?}"),
    });
    found.expect("a sample")
}

fn bad(line: &str) -> RejectReason {
    let mut found = None;
    only_item(line, |item| match item {
        Item::Rejected(bad) => found = Some(bad.kind),
        other => panic!("{other:?}"),
    });
    found.expect("a bad line")
}

fn grammar(body: &str) -> GrammarError {
    match bad(&sentence(body)) {
        RejectReason::Grammar(error) => error,
        other => panic!("{other:?}"),
    }
}

fn with_suffix(suffix: &str) -> String {
    YMR[0].0.to_owned() + suffix
}

/// The sentence is one of `layout`, with the printed values.
fn assert_read(layout: &Layout, line: &str) -> Sample {
    let sample = sample(line);
    assert_eq!(sample.layout, layout);
    let body = line.split('*').next().unwrap();
    let printed = body.split(',').skip(1).filter(|field| field.starts_with(['+', '-']));
    let printed: Vec<f64> = printed.map(|field| field.parse().unwrap()).collect();
    assert_eq!(sample.values().collect::<Vec<_>>(), printed);
    assert_eq!(sample.counts().len(), layout.channels.len());
    sample
}

#[test]
fn recorded_lines_have_their_values() {
    for (body, digits) in YMR {
        assert_read(&VNYMR, &format!("${body}*{digits}\r\n"));
    }
}

#[test]
fn old_lines_count_in_the_same_units() {
    let old = sample(&format!("${}*61\r\n", YMR[13].0));
    assert_eq!(old.print_format, PrintFormat::Old);
    assert_eq!(old.counts(), [-170_940, 7_340, 700, -17_866, 1_747, 22_113, -85, 5, -9_847, 300, -1_200, -100]);
    let decimals: Vec<_> = VNYMR.channels.iter().map(|channel| PrintFormat::Old.decimals(channel)).collect();
    assert_eq!(decimals, [2, 2, 2, 4, 4, 4, 3, 3, 3, 4, 4, 4]);
}

#[test]
fn check_digits_in_lower_case_come_from_programs_that_rewrite_sentences() {
    let mut in_letters = 0;
    for (body, digits) in YMR {
        let lower = digits.to_ascii_lowercase();
        in_letters += usize::from(lower != digits);
        // a byte at a time, with different bytes after the digits
        for behind in ["\r\n", "\n", ",7\r\n", "'\r\n", "zz\n"] {
            let expected = format!("${body}*{digits}{behind}");
            let text = format!("${body}*{lower}{behind}");
            let expected_counts = decoded_in_pieces(expected.as_bytes(), expected.len());
            assert_eq!(expected_counts.len(), 12, "{expected}");
            for piece in [1, 3, text.len()] {
                assert_eq!(decoded_in_pieces(text.as_bytes(), piece), expected_counts, "{text}");
            }
        }
        // letters after upper-case digits are no digits, and others are rejected
        assert_eq!(decoded_in_pieces(format!("${body}*{digits}ab\r\n").as_bytes(), 2).len(), 12);
        let wrong = format!("${body}*{}\r\n", lower.replace(['3', '8', 'b', 'c', '0', '2'], "a"));
        assert!(decoded_in_pieces(wrong.as_bytes(), 2).is_empty() || wrong.contains(&lower), "{wrong}");
    }
    assert!(in_letters > 2, "{in_letters}");
}

#[test]
fn a_quote_that_closes_a_sentence_without_a_checksum_is_none_of_it() {
    let (body, _) = YMR[0];
    let mut decoder = Decoder::new(Options { accept_unchecked: true });
    let mut samples = 0;
    for closing in ["", "\"", "'", "\\r\\n'", "\\r\\n\"", " \" "] {
        decoder.push(format!("x '${body}{closing}\r\n").as_bytes(), |item| {
            samples += usize::from(matches!(item, Item::Sample(_)))
        });
    }
    assert_eq!(samples, 6, "{:?}", decoder.tally());
}

/// The counts of all samples in `bytes`.
fn decoded_in_pieces(bytes: &[u8], piece: usize) -> Vec<i32> {
    let mut decoder = Decoder::new(Options::default());
    let mut counts = Vec::new();
    let mut take = |item: Item<'_>| {
        if let Item::Sample(sample) = item {
            counts.extend_from_slice(sample.counts());
        }
    };
    bytes.chunks(piece).for_each(|piece| decoder.push(piece, &mut take));
    decoder.finish(&mut take);
    counts
}

#[test]
fn the_uncompensated_message_is_read() {
    let uncompensated = assert_read(&VNIMU, &format!("${IMU}*66\r\n"));
    let counts = [-350, 4_222, -6_643, -15, 19, 9_948, 2_066, -8_442, -44_656, 207, 84_322];
    assert_eq!(uncompensated.counts(), counts);
    // the pressure with five whole digits, as in one edition of the manual, is the same pressure
    assert_eq!(sample(&sentence(&IMU.replace("+084.322", "+00084.322"))).counts(), counts);
}

#[test]
fn messages_with_a_quaternion_or_without_attitude_are_read() {
    // a recorded line of firmware 2, and one of old firmware
    let quaternion = assert_read(
        &VNQMR,
        "$VNQMR,+0.004183,+0.001149,+0.089285,+0.995997,+00.0113,-00.2384,+00.1800,+00.020,-00.092,-09.683,-00.000272,\
         +00.000824,+00.000073,T0000000543*3D\r\n",
    );
    assert_eq!(quaternion.suffix, Suffix { count: Some(543), status: None });
    let old = assert_read(
        &VNQMR,
        "$VNQMR,+0.021375,-0.049923,+0.797361,-0.601055,-0.2354,+0.8029,+1.8875,+00.795,-00.412,-09.709,-00.0201,\
         -00.0055,-00.0149*76\r\n",
    );
    assert_eq!((old.print_format, old.counts()[10]), (PrintFormat::Old, -20_100));
    // the length according to the formats of the manual
    let line = sentence("VNMAR,-01.0640,-00.2531,+03.0614,+00.005,+00.344,-09.758,-00.001222,-00.000450,-00.001218");
    assert_eq!((line.len(), assert_read(&VNMAR, &line).print_format), (95, PrintFormat::Current));
}

#[test]
fn other_lines_of_the_maker_are_replies_or_other() {
    for (line, reply) in [
        ("$VNRRG,01,VN-200T-CR*31", true),
        ("$VNRRG,75,3,400,01,0321*3B31", true),
        ("$VNWRG,75,0,4,01,0128*7A", true),
        ("$VNERR,0C*02", true),
        ("$VNERR,01*70", true),
        ("$VNERR,FF*71", true),
        ("$VNWNV*57", true),
        ("$VNRFS*5F", true),
        ("$VNRST*4D", true),
        ("$VNTAR*5F", true),
        ("$VNKMD,1*47", true),
        ("$VNKAD,0*4A", true),
        ("$VNSGB*4E", true),
        ("$VNSFB*4F", true),
        ("$VNASY,0*4F", true),
        ("$VNBOM,1*45", true),
        ("$VNFWU*5C", true),
        ("$VNCMD*52", true),
        ("$VNSIH,+045.000*62", true),
        ("$VNRRG,239,-124.743,+001.019,-000.203,+00.019,-00.001,+00.039,+00.001665,-00.000785,+00.000647*55", true),
        ("$VNYPR,-129.867,-000.355,-000.296*61", false),
        ("$VNYPR,+010.071,+000.278,-002.026,T1162704,S0000*50", false),
        ("$VNYBA,+059.745,+003.857,-004.949,+00.001,-00.008,+00.150,+00.000478,-00.000896,-00.001366*5B", false),
    ] {
        only_item(&format!("{line}\r\n"), |item| match item {
            Item::Reply(sentence) => assert!(reply && sentence.raw == line.as_bytes(), "{line}"),
            Item::Other(sentence) => assert!(!reply && sentence.raw == line.as_bytes(), "{line}"),
            other => panic!("{line}: {other:?}"),
        });
    }
    for misprint in ["$VNRRG,01,VN-310*58\r\n", "$VNRRG,01,VN-200*4B\r\n", "$VNYPR,-129.867,-000.355,-000.296*62\r\n"] {
        assert!(matches!(bad(misprint), RejectReason::Checksum { received: Some(_), .. }), "{misprint}");
    }
}

#[test]
fn the_grammar_rejects_lines_that_pass_the_checksum() {
    use GrammarError::{Decimals, FieldCount, Number, Suffix};
    let usual = YMR[0].0;
    assert_eq!(bad("$VNYMR,-165.918,-008.770,+000.198*7D\r\n"), FieldCount { expected: 12, found: 3 }.into());
    assert_eq!(grammar("VNYMR"), FieldCount { expected: 12, found: 0 });
    assert_eq!(grammar(&with_suffix(",+00.000001")), FieldCount { expected: 12, found: 13 });
    assert_eq!(grammar(&with_suffix(",")), FieldCount { expected: 12, found: 13 });
    assert_eq!(grammar(&with_suffix(",T")), Suffix);
    assert_eq!(grammar(&with_suffix(",T1,T2")), Suffix);
    assert_eq!(grammar(&with_suffix(",S00ff")), Suffix);
    for field in ["nan", " +074.972", "+1e3", "+.972", "+074.", "+074", "", "+74972000000.000"] {
        assert_eq!(grammar(&usual.replace("+074.972", field)), Number { channel: "pitch" }, "{field}");
    }
    let too_fine = Decimals { channel: "pitch", expected: 3, found: 4 };
    assert_eq!(grammar(&usual.replace("+074.972", "+074.9720")), too_fine);
    let mixed = Decimals { channel: "pitch", expected: 2, found: 3 };
    assert_eq!(grammar(&usual.replace("-085.469", "-085.46")), mixed);
    assert_eq!(grammar(&IMU.replace("+20.7", "+20.70")), Decimals { channel: "temperature", expected: 1, found: 2 });
    // 24 spaces are an even number of equal bytes, which XOR-8 does not detect
    let spaced = usual.replace(',', ",  ");
    assert_eq!(xor8(spaced.as_bytes()), 0x63);
    assert!(matches!(grammar(&spaced), Number { channel: "yaw" }));
}

#[test]
fn the_decimals_of_one_number_choose_the_format_for_all() {
    let mar = "VNMAR,-01.0640,-00.2531,+03.0614,+00.005,+00.344,-09.758,-00.001222,-00.000450,-00.001218";
    let mixed = mar.replace("-00.000450", "-00.0004");
    assert_eq!(grammar(&mixed), GrammarError::Decimals { channel: "gyro_y", expected: 6, found: 4 });
    // no old firmware is known that prints a temperature
    let old_imu = IMU.replace("+00.002066,-00.008442,-00.044656", "+00.0020,-00.0084,-00.0446");
    assert_eq!(grammar(&old_imu), GrammarError::Decimals { channel: "gyro_x", expected: 6, found: 4 });
}

#[test]
fn a_sentence_of_another_message_is_no_sample() {
    for line in ["$VNYPR,-129.867,-000.355,-000.296*61\r\n", "$VNRRG,01,VN-100S-CR*35\r\n"] {
        let frames = frames(line.as_bytes(), Options::default());
        let [Frame::Sentence(sentence)] = frames[..] else { panic!("{frames:?}") };
        assert_eq!(Sample::parse(&sentence), None);
    }
}

#[test]
fn impossible_values_are_reported() {
    for (field, wrong, message) in [
        ("-085.469", "-180.001", "range: yaw of -180001 counts is beyond ±180000 counts (180 deg)"),
        ("+00.9048", "+10.0001", "range: mag_z of 100001 counts is beyond ±100000 counts (10 gauss)"),
        ("+08.971", "+999.000", "range: accel_x of 999000 counts is beyond ±200000 counts (200 m/s^2)"),
        ("-00.000391", "-40.000001", "range: gyro_z of -40000001 counts is beyond ±40000000 counts (40 rad/s)"),
    ] {
        let kind = bad(&sentence(&YMR[0].0.replace(field, wrong)));
        assert!(matches!(kind, RejectReason::Range(_)));
        assert_eq!(kind.to_string(), message);
    }
    // an old count scaled by a hundred exceeds 32 bits
    let old = YMR[13].0.replace("+00.0003", "+99999.9999");
    assert_eq!(
        bad(&sentence(&old)).to_string(),
        "range: gyro_x of 99999999900 counts is beyond ±40000000 counts (40 rad/s)"
    );
    for (field, wrong) in [("+20.7", "+200.1"), ("+084.322", "+200.001")] {
        assert!(matches!(bad(&sentence(&IMU.replace(field, wrong))), RejectReason::Range(_)));
    }
}

proptest! {
    #[test]
    fn printed_sentences_are_read(
        (header, forms, counts) in crate::support::sample(), count: Option<u64>, status: Option<u16>, status_first: bool,
    ) {
        let mut suffix = [count.map(|count| format!(",T{count}")), status.map(|status| format!(",S{status:04X}"))];
        if status_first {
            suffix.reverse();
        }
        let sample = sample(&sentence(&(body(header, forms, &counts) + &suffix.into_iter().flatten().collect::<String>())));
        prop_assert_eq!(&*sample.layout.message, header);
        prop_assert_eq!(sample.counts(), counts);
        prop_assert_eq!(sample.print_format, PrintFormat::Current);
        prop_assert_eq!(sample.suffix, Suffix { count, status });
    }

    #[test]
    fn sentences_of_old_firmware_are_read(counts in counts(crate::support::OLD_YMR)) {
        let sample = sample(&sentence(&body("VNYMR", crate::support::OLD_YMR, &counts)));
        let missing = [10, 10, 10, 1, 1, 1, 1, 1, 1, 100, 100, 100];
        prop_assert_eq!(sample.counts(), counts.iter().zip(missing).map(|(count, by)| count * by).collect::<Vec<_>>());
        prop_assert_eq!(sample.print_format, PrintFormat::Old);
    }
}

#[test]
fn a_sentence_without_the_name_of_a_message_is_malformed() {
    for (body, is_message) in [
        ("", false),
        ("VN", false),
        ("VNYMR(+0,1", false),
        ("VNYM1,1", false),
        ("VNXYZQ,1", false),
        ("1GP,2", false),
        ("GP-GA,2", false),
        ("VNXYZ,1", true),
        ("GPGGA,123519", true),
        ("PUBX,00", true),
    ] {
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let line = format!("${body}*{checksum:02X}\r\n");
        let mut items = 0;
        Decoder::new(Options::default()).push(line.as_bytes(), |item| {
            items += 1;
            match item {
                Item::Other(_) => assert!(is_message, "{line}"),
                Item::Rejected(rejected) => {
                    assert!(!is_message && rejected.kind == RejectReason::Grammar(GrammarError::Name), "{line}");
                }
                item => panic!("{line}: {item:?}"),
            }
        });
        assert_eq!(items, 1, "{line}");
    }
}
