//! The load of a line: the tables that follow from the recorded lengths, and settings that sensors
//! have accepted and refused.

use vn100_protocol::{AsyncRate, AsyncType, BaudRate, BinaryOutput, LinkLoad, ProtocolControl};

fn baud(bits_per_s: u32) -> BaudRate {
    BaudRate::new(bits_per_s).unwrap()
}

fn lines(message: AsyncType, hz: u32) -> LinkLoad {
    LinkLoad::of_lines(message.line_length(&ProtocolControl::default()).unwrap(), AsyncRate::new(hz).unwrap())
}

fn packets(rate_divisor: u16, groups: u8, field_words: &[u16]) -> BinaryOutput {
    let (async_mode, field_words) = (1, field_words.to_vec());
    BinaryOutput { async_mode, rate_divisor, groups, field_words }
}

fn highest_rate(message: AsyncType, bits_per_s: u32) -> Option<u32> {
    let length = message.line_length(&ProtocolControl::default()).unwrap();
    LinkLoad::NONE.highest_rate_beside(length, baud(bits_per_s)).map(AsyncRate::hz)
}

#[test]
fn lengths_are_those_of_recorded_lines() {
    for line in [
        "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63",
        "$VNYPR,-129.867,-000.355,-000.296*61",
        "$VNYBA,+059.745,+003.857,-004.949,+00.001,-00.008,+00.150,+00.000478,-00.000896,-00.001366*5B",
    ] {
        let message = AsyncType::from_header(&line.as_bytes()[1..6]).unwrap();
        assert_eq!(message.line_length(&ProtocolControl::default()), Some(line.len() as u32 + 2), "{line}");
    }
    let suffixed = "$VNQMR,+0.004183,+0.001149,+0.089285,+0.995997,+00.0113,-00.2384,+00.1800,+00.020,-00.092,-09.683,\
                    -00.000272,+00.000824,+00.000073,T0000000543*3D";
    let count = ProtocolControl { serial_count: 3, ..ProtocolControl::default() };
    assert_eq!(AsyncType::QMR.line_length(&count), Some(suffixed.len() as u32 + 2));
    // 3 is a CRC, and a kind of check that is not known counts as one
    for serial_checksum in [3, 9] {
        let all = ProtocolControl { serial_status: 1, serial_checksum, ..count };
        assert_eq!(AsyncType::YMR.line_length(&all), Some(122 + 12 + 6 + 2));
        assert_eq!(AsyncType::OFF.line_length(&all), Some(0));
        assert_eq!(AsyncType::HVE.line_length(&all), None);
    }
}

#[test]
fn the_highest_rates_at_115200() {
    use AsyncType as A;
    for (messages, hz) in [
        (&[A::YPR, A::QTN, A::MAG, A::ACC, A::GYR][..], 200),
        (&[A::QMR, A::YMR], 50),
        (&[A::MAR, A::YBA, A::YIA, A::DTV, A::IMU], 100),
    ] {
        for &message in messages {
            assert_eq!(highest_rate(message, 115_200), Some(hz), "{message:?}");
        }
    }
}

#[test]
fn packets_have_the_length_of_their_masks_and_their_highest_rate() {
    // packets per second at 57600, 115200, 230400, 460800 and 921600 baud
    for (groups, words, length, highest) in [
        (0x01, &[0x0101][..], 26, [222, 443, 886, 1772, 3545]),
        (0x01, &[0x0201], 38, [152, 303, 606, 1213, 2425]),
        (0x06, &[0x0001, 0x001C], 44, [131, 262, 524, 1047, 2095]),
        (0x06, &[0x0001, 0x001E], 56, [103, 206, 411, 823, 1646]),
        (0x01, &[0x0601], 58, [99, 199, 397, 794, 1589]),
        (0x01, &[0x0609], 70, [82, 165, 329, 658, 1317]),
        (0x01, &[0x0739], 110, [52, 105, 209, 419, 838]),
        (0x01, &[0x0128], 42, [137, 274, 549, 1097, 2194]),
    ] {
        let output = packets(4, groups, words);
        assert_eq!(output.packet_length(), Some(length), "{words:X?}");
        for (bits_per_s, highest) in [57_600, 115_200, 230_400, 460_800, 921_600].into_iter().zip(highest) {
            let sustained = f64::from(baud(bits_per_s).bytes_per_s()) / length as f64;
            assert_eq!(sustained.round() as u32, highest, "{words:X?} at {bits_per_s}");
        }
    }
}

#[test]
fn accepted_settings_fit_and_refused_ones_do_not() {
    let packets = |divisor, words: &[u16]| LinkLoad::of_packets(&packets(divisor, 0x01, words)).unwrap();
    // 58 bytes at 200 Hz are more than 11520 bytes per second, at 160 Hz less
    assert!(!packets(4, &[0x0601]).fits(baud(115_200)));
    assert!(packets(5, &[0x0601]).fits(baud(115_200)));
    assert!(!packets(1, &[0x0601]).fits(baud(460_800)));
    assert!(packets(1, &[0x0601]).fits(baud(921_600)));
    assert!(!lines(AsyncType::YMR, 100).fits(baud(115_200)));
    // 4880 and 1040 bytes per second, together more than the 5760 of 57600 baud
    let both = [lines(AsyncType::YMR, 40), packets(20, &[0x0101])].into_iter().sum::<LinkLoad>();
    assert_eq!(both.bytes_per_s, 5920.0);
    assert!(!both.fits(baud(57_600)));
    assert_eq!(both.lowest_baud_rate(), Some(baud(115_200)));
}

#[test]
fn an_exact_fit_fits() {
    let full = LinkLoad::of_lines(2304, AsyncRate::new(5).unwrap());
    assert!(full.fits(baud(115_200)));
    assert!(!LinkLoad::of_lines(2305, AsyncRate::new(5).unwrap()).fits(baud(115_200)));
    assert_eq!(LinkLoad::of_lines(92_161, AsyncRate::new(1).unwrap()).lowest_baud_rate(), None);
    assert_eq!(full.highest_rate_beside(1, baud(115_200)), None);
    assert_eq!(full.highest_rate_beside(0, baud(115_200)), AsyncRate::new(200));
}

#[test]
fn packets_that_are_not_sent_weigh_nothing_and_unknown_ones_are_unknown() {
    let sent = packets(4, 0x01, &[0x0001]);
    assert_eq!((sent.rate_hz(), packets(3, 0x01, &[1]).rate_hz()), (200.0, 800.0 / 3.0));
    for unsent in [BinaryOutput { async_mode: 0, ..sent.clone() }, BinaryOutput { rate_divisor: 0, ..sent.clone() }] {
        assert_eq!(LinkLoad::of_packets(&unsent), Some(LinkLoad::NONE));
    }
    for (groups, words) in
        [(0x08, &[1][..]), (0x00, &[]), (0x01, &[]), (0x01, &[1, 1]), (0x01, &[0]), (0x01, &[0x8000]), (0x81, &[1, 1])]
    {
        assert_eq!(LinkLoad::of_packets(&packets(4, groups, words)), None, "{groups:X} {words:X?}");
    }
}
