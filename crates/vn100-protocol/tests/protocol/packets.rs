//! Packets of the maker's manual and of real sensors, and their measured values.

use proptest::{collection::vec, prelude::*};
use vn100_protocol::{
    BinaryOutput, Decoder, Item, MESSAGES, Options, PacketForm, Quantity, crc16,
    stream::{Batch, MarkKind, MeasuredFrames, ReadOptions, SampleReader},
};

use crate::support::{decode_in_pieces, packet};

/// Manual UM001, revision 2.02: only attitude.
const ATTITUDE: &str = "FA01080093502E42833EF13F48B504BB9288";
/// The second case in the same manual, as printed and corrected: attitude and temperature.
const MISPRINT: &str = "FA01080001 00A4150242 4DDFEB3F F61A36BE BF2DA441A83A";
const ATTITUDE_TEMPERATURE: &str = "FA0508001000A41502424DDFEB3FF61A36BEBF2DA441AF1A";
/// A real sensor (`UWOrbital/OBC-firmware`, test_vn100_unpack.cpp): 62 bytes.
const COMPENSATED: &str = "FA012805A802C33FE789B0423DA96AC1D083543A923E0BBB1C2530BA047D1C413BB2833D4EEA9CBEF1BD93BEA4558CBD26C7773E\
                           F428E64157CEC142C0E9";
/// A real sensor with firmware 3.1 at 800 Hz (`rw-vn100`): 110 bytes.
const EVERYTHING: &str = "FA0139070805539ED30F0000B3291AC20E4E984226B7AC42572A283FE9AB7C3E4D7A16BFFB21CE3E00AD75BA0039A438C0A42539\
                          842C11419D980DC06B98FDBD842C11419D980DC06B98FDBD271F943C060DC9BC49A312BC043D43BEA71B673D3FACC5BEEAD1024215\
                          2ECA429F60";
/// The values of that packet as inertial groups: time, acceleration, rate, temperature.
const INERTIAL: &str = "FA0501001C000805539ED30F0000842C11419D980DC06B98FDBD271F943C060DC9BC49A312BCEAD10242B82E";
/// The same values with the time in its own group; with magnetic field and pressure; with saturation.
const TIME_GROUP: &str = "FA0601001C000805539ED30F0000842C11419D980DC06B98FDBD271F943C060DC9BC49A312BCEAD10242612F";
const MAG_PRESSURE: &str = "FA0501003E000805539ED30F0000043D43BEA71B673D3FACC5BE842C11419D980DC06B98FDBD271F943C060DC9BC49A312BCEAD10242152ECA42150C";
const SATURATION: &str = "FA0501001C080805539ED30F0000842C11419D980DC06B98FDBD271F943C060DC9BC49A312BCEAD1024200007779";
/// Numbers that are exact floats, 1.25 ms, 2.5 ms and 5 ms after the start: one sample is missing.
const EXACT: [&str; 3] = [
    "FA0501001C00D0121300000000000000803E000000BF00001CC10000803A000000BB0000803B0000CC416587",
    "FA0501001C00A0252600000000000000803E000000BF00001CC10000803A000000BB0000803B0000CC417032",
    "FA0501001C00404B4C00000000000000803E000000BF00001CC10000803A000000BB0000803B0000CC415B58",
];

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<_> = hex.bytes().filter(|byte| *byte != b' ').collect();
    digits.chunks(2).map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
}

/// The same payload with its correct CRC.
fn sealed(mut packet: Vec<u8>) -> Vec<u8> {
    let crc = crc16(&packet[1..packet.len() - 2]);
    let end = packet.len() - 2;
    packet[end..].copy_from_slice(&crc.to_be_bytes());
    packet
}

fn reader(measured: MeasuredFrames) -> SampleReader {
    SampleReader::new(ReadOptions { measured, ..ReadOptions::default() })
}

fn read(measured: MeasuredFrames, pieces: &[&[u8]]) -> Vec<Batch> {
    let mut reader = reader(measured);
    let mut batches = Vec::new();
    for piece in pieces.iter().filter(|piece| !piece.is_empty()) {
        reader.push(piece, None);
        batches.extend(reader.take_batches());
    }
    batches.extend(reader.finish());
    batches
}

/// All batches in one, with the link counts of the last.
fn whole(measured: MeasuredFrames, stream: &[u8]) -> Batch {
    let mut batches = read(measured, &[stream]);
    let last = batches.pop().unwrap();
    let mut batch = batches.pop().unwrap();
    assert!(batches.is_empty());
    // rows may stay pending until the end
    if batch.counts.is_empty() {
        return last;
    }
    assert!(last.counts.is_empty());
    batch.link = last.link;
    batch
}

/// The names and values of the rows.
fn values(batch: &Batch) -> Vec<(String, f64)> {
    let Some(layout) = &batch.layout else { return Vec::new() };
    batch
        .rows()
        .flat_map(|row| {
            layout.channels.iter().zip(row).map(|(channel, count)| (channel.name.to_string(), channel.value(*count)))
        })
        .collect()
}

fn assert_values(hex: &str, expected: &[(&str, f64)]) {
    let batch = whole(MeasuredFrames::First, &bytes(hex));
    let found = values(&batch);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((name, value), (expected_name, expected)) in found.iter().zip(expected) {
        assert_eq!(name, expected_name);
        assert!((value - expected).abs() <= 7e-8_f64.max(1.2e-7 * expected.abs()), "{name}: {value}, not {expected}");
    }
}

const IMU: [(&str, f64); 7] = [
    ("accel_x", 9.073368),
    ("accel_y", -2.212_439_8),
    ("accel_z", -0.123_825_87),
    ("gyro_x", 0.018_081_261),
    ("gyro_y", -0.024_542_343),
    ("gyro_z", -0.008_950_063),
    ("temperature", 32.704_994),
];

#[test]
fn real_packets_become_rows() {
    let compensated = [
        ("yaw", 1.523_518_6),
        ("pitch", 88.269_34),
        ("roll", -14.666_318),
        ("mag_x", -0.288_558_5),
        ("mag_y", -0.068_522_72),
        ("mag_z", 0.241_970_63),
        ("accel_x", 9.780_521),
        ("accel_y", 0.064_304_79),
        ("accel_z", -0.306_475_1),
        ("gyro_x", 8.106_8e-4),
        ("gyro_y", -2.124_701_2e-3),
        ("gyro_z", -6.719_397e-4),
        ("temperature", 28.769_997),
        ("pressure", 96.903_01),
    ];
    assert_values(COMPENSATED, &compensated);
    assert_eq!(whole(MeasuredFrames::First, &bytes(COMPENSATED)).layout.unwrap().compensated, Some(true));
    for hex in [INERTIAL, TIME_GROUP, SATURATION] {
        assert_values(hex, &IMU);
        let batch = whole(MeasuredFrames::First, &bytes(hex));
        assert_eq!((batch.layout.unwrap().compensated, &batch.device_ns[..]), (Some(false), &[17_401_568_757_000][..]));
        assert!(batch.marks.is_empty());
    }
    let with_mag = [&[("mag_x", -0.190_662_44), ("mag_y", 0.056_422_856), ("mag_z", -0.386_079_76)], &IMU[..]].concat();
    let with_pressure = [&with_mag[..], &[("pressure", 101.090_004)]].concat();
    assert_values(MAG_PRESSURE, &with_pressure);
}

#[test]
fn undocumented_fields_count_as_compensated() {
    let batch = whole(MeasuredFrames::First, &bytes(EVERYTHING));
    let layout = batch.layout.clone().unwrap();
    assert_eq!((layout.compensated, layout.channels.len()), (Some(true), 14));
    let rate = values(&batch).into_iter().find(|(name, _)| name == "gyro_x").unwrap().1;
    assert!((rate + 9.371_8e-4).abs() < 1e-7, "the compensated rate, not that of the undocumented field: {rate}");
}

/// The output of a logger of uncompensated measurements and attitude, and packets with the
/// compensated field: a filter removes only the bias of rates.
#[test]
fn attitude_and_field_do_not_make_rates_compensated() {
    for (groups, words, compensated) in [
        (0x14, &[0x003E, 0x003A][..], Some(false)),
        (0x05, &[0x0009, 0x010C], Some(false)),
        (0x04, &[0x0600], Some(true)),
        // the acceleration compensated and the rate not, and vice versa
        (0x04, &[0x0208], Some(false)),
        (0x04, &[0x0404], Some(true)),
        (0x04, &[0x0200], Some(true)),
        (0x04, &[0x0004], Some(false)),
        // the rate by its increments, for any acceleration
        (0x04, &[0x0244], None),
    ] {
        let form = PacketForm::new(groups, words).unwrap();
        assert_eq!(form.layout.compensated, compensated, "{groups:02X} {words:04X?}");
    }
}

#[test]
fn attitude_alone_is_no_measurement() {
    for hex in [ATTITUDE, ATTITUDE_TEMPERATURE] {
        let batch = whole(MeasuredFrames::First, &bytes(hex));
        assert_eq!((batch.link.tally.packets, batch.link.samples(), batch.layout), (1, 0, None));
    }
    let tally = whole(MeasuredFrames::First, &bytes(MISPRINT)).link.tally;
    assert_eq!((tally.packets, tally.skipped_bytes), (0, 24), "the printed form has a wrong CRC");
}

#[test]
fn exact_floats_are_exact_counts() {
    let stream: Vec<u8> = EXACT.iter().flat_map(|hex| bytes(hex)).collect();
    let batch = whole(MeasuredFrames::First, &stream);
    let expected = [0.25, -0.5, -9.75, 0.5_f64.powi(10), -0.5_f64.powi(9), 0.5_f64.powi(8), 25.5];
    let found: Vec<f64> = values(&batch).into_iter().map(|(_, value)| value).collect();
    assert_eq!(found, [expected; 3].concat());
    assert_eq!(batch.device_ns, [1_250_000, 2_500_000, 5_000_000]);
    assert_eq!((batch.link.samples(), batch.link.tally.packet_bytes), (3, 132));
}

#[test]
fn increments_become_rates() {
    let mut packet = vec![0xFA, 0x05, 0x01, 0x00, 0xC0, 0x00];
    packet.extend(1_000_000_000_u64.to_le_bytes());
    // 1.8 degrees and 0.05 m/s in 25 ms
    for value in [0.025_f32, 1.8, -1.8, 0.0, 0.05, 0.0, -0.245] {
        packet.extend(value.to_le_bytes());
    }
    packet.extend([0, 0]);
    let batch = whole(MeasuredFrames::First, &sealed(packet.clone()));
    assert_eq!(batch.layout.as_ref().unwrap().compensated, None, "what register 82 says is not known");
    let found: Vec<f64> = values(&batch).into_iter().map(|(_, value)| value).collect();
    let expected = [2.0, 0.0, -9.8, 0.4 * std::f64::consts::PI, -0.4 * std::f64::consts::PI, 0.0];
    assert!(found.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 2e-6), "{found:?}");
    // invalid intervals of increments
    for interval_s in [0.0, -0.025, f32::INFINITY, f32::NAN, 1e38] {
        packet[14..18].copy_from_slice(&interval_s.to_le_bytes());
        let mut reader = SampleReader::new(ReadOptions { diagnostics: true, ..ReadOptions::default() });
        reader.push(&sealed(packet.clone()), None);
        let [batch] = &reader.take_batches()[..] else { panic!("one batch") };
        assert_eq!((batch.row_count(), batch.link.tally.measured_packets.rejected), (0, 1), "{interval_s}");
        let told = batch.diagnostics[0].to_string();
        assert!(told.contains("the interval of the increments is "), "{told}");
    }
}

#[test]
fn printed_increments_are_the_same_rates() {
    let sentence = |body: &str| vn100_protocol::Check::Xor8.sentence(body).into_bytes();
    // 1.8 degrees and 0.05 m/s in 25 ms
    let good = "VNDTV,+0.025000,+001.800,-001.800,+000.000,+000.050,+000.000,-000.245";
    let batch = whole(MeasuredFrames::First, &sentence(good));
    let layout = batch.layout.as_ref().unwrap();
    assert_eq!((&*layout.message, layout.compensated), ("VNDTV", None));
    assert!(layout.channels.iter().all(|channel| channel.increment_step.is_some()));
    let found: Vec<f64> = values(&batch).into_iter().map(|(_, value)| value).collect();
    let expected = [2.0, 0.0, -9.8, 0.4 * std::f64::consts::PI, -0.4 * std::f64::consts::PI, 0.0];
    assert!(found.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-7), "{found:?}");
    for (bad, reason) in [
        (good.replace("+0.025000", "+0.000000"), "accel_x of 9223372036854775807 counts"),
        (good.replace("+0.025000", "-0.025000"), "accel_x of 9223372036854775807 counts"),
        (good.replace("-000.245", "-006.245"), "accel_z of -"),
        (good.replace(",+000.050", ""), "grammar: the sentence has 6 fields, 7 are expected"),
        (good.replace("+001.800", "+1.8000"), "delta_theta_x has 4 decimals, 3 are expected"),
    ] {
        let mut reader = SampleReader::new(ReadOptions { diagnostics: true, ..ReadOptions::default() });
        reader.push(&[sentence(good), sentence(&bad)].concat(), None);
        let [batch] = &reader.take_batches()[..] else { panic!("one batch") };
        let told = batch.diagnostics[0].to_string();
        assert!(batch.row_count() == 1 && told.contains(reason), "{told}");
        assert_eq!((batch.link.samples(), batch.link.tally.rejected.total()), (1, 1));
    }
}

#[test]
fn numbers_that_no_sensor_measures_are_rejected_with_evidence() {
    for (value, reason) in [
        (f32::NAN, "accel_x is NaN, beyond ±200"),
        (f32::INFINITY, "accel_x is inf, beyond ±200"),
        (-200.1, "accel_x is -200.100006103515"),
    ] {
        let mut bad = bytes(EXACT[1]);
        bad[14..18].copy_from_slice(&value.to_le_bytes());
        let stream = [bytes(EXACT[0]), sealed(bad), bytes(EXACT[2])].concat();
        let mut reader = SampleReader::new(ReadOptions { diagnostics: true, ..ReadOptions::default() });
        reader.push(&stream, None);
        let [batch] = &reader.take_batches()[..] else { panic!("one batch") };
        let measured = batch.link.tally.measured_packets;
        assert_eq!((measured.samples, measured.rejected, batch.link.samples()), (2, 1, 2));
        assert_eq!((batch.marks[0].before_row, batch.marks[0].kind), (1, MarkKind::Rejected));
        let told = batch.diagnostics[0].to_string();
        assert!(told.contains(reason), "{told}");
        assert_eq!(batch.device_ns.len(), 2);
    }
}

#[test]
fn a_packet_that_comes_twice_is_one_sample() {
    let stream: Vec<u8> = [EXACT[0], EXACT[0], EXACT[1], EXACT[0]].iter().flat_map(|hex| bytes(hex)).collect();
    let batch = whole(MeasuredFrames::First, &stream);
    let measured = batch.link.tally.measured_packets;
    assert_eq!((measured.samples, measured.repeated), (3, 1));
    assert_eq!(batch.device_ns, [1_250_000, 2_500_000, 1_250_000], "an earlier time is no repetition");
}

#[test]
fn saturated_axes_are_marked() {
    let mut saturated = bytes(SATURATION);
    saturated[42] = 0x48;
    let stream = [bytes(SATURATION), sealed(saturated)].concat();
    let mut later = stream.clone();
    // the byte of its time
    later[46 + 6] ^= 0x10;
    let end = later.len();
    let crc = crc16(&later[47..end - 2]);
    later[end - 2..].copy_from_slice(&crc.to_be_bytes());
    let batch = whole(MeasuredFrames::First, &later);
    let marks: Vec<_> = batch.marks.iter().map(|mark| (mark.before_row, mark.kind)).collect();
    assert_eq!(marks, [(1, MarkKind::Saturated(0x48))], "accel_x and gyro_x");
}

const YMR: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";

#[test]
fn the_first_or_the_requested_kind_of_frame_is_measured() {
    let packet = bytes(INERTIAL);
    let both = [YMR.as_bytes(), &packet].concat();
    for (stream, measured, message) in [
        (&both, MeasuredFrames::First, "VNYMR"),
        (&both, MeasuredFrames::Packets, "BINARY"),
        (&both, MeasuredFrames::Sentences, "VNYMR"),
        (&[&packet, YMR.as_bytes()].concat(), MeasuredFrames::First, "BINARY"),
        (&[&packet, YMR.as_bytes()].concat(), MeasuredFrames::Sentences, "VNYMR"),
    ] {
        let batch = whole(measured, stream);
        assert_eq!((&*batch.layout.clone().unwrap().message, batch.rows().len()), (message, 1));
        let link = batch.link;
        assert_eq!((link.tally.samples, link.tally.packets, link.samples()), (1, 1, 1));
        assert_eq!(link.foreign_samples, u64::from(message == "BINARY"));
    }
    let none = whole(MeasuredFrames::Packets, YMR.as_bytes());
    assert_eq!((none.layout, none.link.samples(), none.link.foreign_samples), (None, 0, 1));
}

#[test]
fn a_dollar_in_a_damaged_packet_is_no_line() {
    let mut damaged = bytes(EXACT[1]);
    damaged[14] ^= 1;
    damaged[20..24].copy_from_slice(b"$a*b");
    let stream = [bytes(EXACT[0]), damaged, bytes(EXACT[2])].concat();
    let batch = whole(MeasuredFrames::First, &stream);
    let tally = batch.link.tally;
    assert_eq!((batch.row_count(), tally.rejected.total(), tally.rejected_sentence_bytes), (2, 0, 0));
    assert_eq!((tally.skipped_bytes, tally.bytes()), (bytes(EXACT[1]).len() as u64, stream.len() as u64));
}

/// The number of damaged packets that a decoder counts, for every division of the stream.
fn acceleration(ms: u64) -> Vec<u8> {
    let mut packet = bytes("FA0501000400");
    packet.extend((ms * 1_000_000).to_le_bytes());
    [0.25_f32, -0.5, -9.75].iter().for_each(|value| packet.extend(value.to_le_bytes()));
    packet.extend([0, 0]);
    sealed(packet)
}

fn damaged_packets(stream: &[u8]) -> u64 {
    let counts =
        [1, 7, stream.len()].map(|size| decode_in_pieces(stream, &[size], Options::default()).1.damaged_packets);
    assert_eq!([counts[0]; 3], counts);
    counts[0]
}

#[test]
fn packets_that_fail_their_checksum_are_counted() {
    let [first, second, third] = EXACT.map(bytes);
    let damaged = |at: usize| {
        let mut packet = second.clone();
        packet[at] ^= 0x10;
        packet
    };
    for at in 6..second.len() {
        assert_eq!(damaged_packets(&[first.clone(), damaged(at), third.clone()].concat()), 1, "byte {at}");
    }
    // two in sequence, or without some bytes
    assert_eq!(damaged_packets(&[first.clone(), damaged(9), damaged(30), third.clone()].concat()), 2);
    assert_eq!(damaged_packets(&[&first[..], &second[..20], &second[24..], &third].concat()), 1);
    // from two outputs
    let other = acceleration(4);
    let mut damaged_other = acceleration(8);
    damaged_other[20] ^= 1;
    let both = [first.clone(), other.clone(), damaged(20), other, damaged_other, third.clone()].concat();
    assert_eq!(damaged_packets(&both), 2);
    // a sentence replaces its end
    let cut = [&first[..], &second[..30], YMR.as_bytes(), &third].concat();
    assert_eq!(damaged_packets(&cut), 1);
}

#[test]
fn other_bytes_are_no_damaged_packet() {
    let [first, second, third] = EXACT.map(bytes);
    // no packet with this head came before
    let mut damaged = second.clone();
    damaged[30] ^= 1;
    assert_eq!(damaged_packets(&[damaged.clone(), first.clone()].concat()), 0);
    let mut of_another_form = acceleration(4);
    of_another_form[20] ^= 1;
    assert_eq!(damaged_packets(&[first.clone(), of_another_form, third.clone()].concat()), 0);
    // the start byte alone, in text, between packets and inside one; and other masks
    let text = [YMR.as_bytes(), b"\xFA word \xFA\x01\xFF\xFF", YMR.as_bytes()].concat();
    assert_eq!(damaged_packets(&[&first[..], b"\xFA\xFA\x05\xFA\x01\x08\x00", &text, &third].concat()), 0);
    // a head in the payload of a good packet; and in that of a damaged packet, which is one packet
    let mut with_head = second.clone();
    with_head[20..26].copy_from_slice(&first[..6]);
    assert_eq!(damaged_packets(&[first.clone(), sealed(with_head.clone()), third.clone()].concat()), 0);
    assert_eq!(damaged_packets(&[first.clone(), with_head, third.clone()].concat()), 1);
    // the beginning of a packet at the end of the stream
    assert_eq!(damaged_packets(&[&first[..], &second[..30]].concat()), 0);
}

proptest! {
    /// Flipped bits after the head, lines and other bytes between packets.
    #[test]
    fn damaged_packets_are_counted_one_by_one(
        pieces in vec((any::<u64>(), any::<[f32; 3]>(), prop::option::weighted(0.3, (4_usize..26, 0_u8..8)), 0..4), 1..20),
        sizes in vec(1_usize..60, 1..6),
    ) {
        let mut stream = packet(0, [0.0; 3]);
        for (time, values, flip, between) in &pieces {
            let mut packet = packet(*time, *values);
            prop_assume!(!packet[1..].contains(&0xFA));
            if let Some((at, bit)) = flip {
                let end = packet.len() - 1;
                packet[(*at).min(end)] ^= 1 << bit;
                prop_assume!(!packet[1..].contains(&0xFA));
            }
            stream.extend(packet);
            stream.extend([&b""[..], YMR.as_bytes(), b"\xFA\x01", b"noise"][*between as usize]);
        }
        let expected = pieces.iter().filter(|(_, _, flip, _)| flip.is_some()).count() as u64;
        let (_, whole) = decode_in_pieces(&stream, &[], Options::default());
        let (_, cut) = decode_in_pieces(&stream, &sizes, Options::default());
        prop_assert_eq!((whole.damaged_packets, cut), (expected, whole));
    }
}

/// A damaged sentence between packets does not replace a packet.
#[test]
fn damaged_sentences_between_packets_are_no_samples() {
    let damaged = YMR.replace("+00.000040", "+00.000041");
    let stream = [bytes(EXACT[0]), damaged.into_bytes(), bytes(EXACT[1])].concat();
    let batch = whole(MeasuredFrames::First, &stream);
    assert_eq!((batch.row_count(), batch.link.tally.rejected.total(), batch.marks.len()), (2, 1, 0));
}

#[test]
fn packets_of_another_form_are_counted_only() {
    let stream = [bytes(INERTIAL), bytes(COMPENSATED), bytes(EXACT[0])].concat();
    let batch = whole(MeasuredFrames::First, &stream);
    assert_eq!((batch.link.tally.packets, batch.link.samples()), (3, 2));
}

#[test]
fn registers_and_packets_have_one_form() {
    let form = PacketForm::new(0x05, &[0x0001, 0x081C]).unwrap();
    let mut decoder = Decoder::new(Options::default());
    decoder.push(&bytes(SATURATION), |item| {
        let Item::Packet(packet) = item else { panic!("no packet") };
        assert_eq!(PacketForm::of(&packet).as_ref(), Some(&form));
    });
    let quantities: Vec<_> = form.layout.channels.iter().map(|channel| channel.quantity).collect();
    assert_eq!(quantities[0], Quantity::Acceleration);
    let logged = BinaryOutput { async_mode: 1, rate_divisor: 80, groups: 0x14, field_words: vec![0x003E, 0x003A] };
    let names: Vec<_> = logged.field_names().collect();
    let inertial = ["UncompMag", "UncompAccel", "UncompGyro", "Temp", "Pres"];
    assert_eq!(names, [&inertial[..], &["YawPitchRoll", "Dcm", "MagNed", "AccelNed"]].concat());
    for (groups, words) in [(0x05, &[0x0001][..]), (0x08, &[1]), (0x01, &[0x0009]), (0x04, &[0x2000]), (0, &[])] {
        assert_eq!(PacketForm::new(groups, words), None, "{groups:02X} {words:04X?}");
    }
}

#[test]
fn quantities_measured_less_often_are_used_less_often() {
    let form = PacketForm::new(0x05, &[0x0001, 0x003E]).unwrap();
    let strides = |rate_hz| {
        let channels = ["mag_x", "accel_x", "gyro_x", "temperature", "pressure"]
            .map(|name| form.layout.channels.iter().find(|channel| channel.name == name).unwrap());
        channels.map(|channel| channel.stride(rate_hz))
    };
    for (rate_hz, expected) in [
        (800.0, [4, 1, 1, 8, 8]),
        (400.0, [2, 1, 1, 4, 4]),
        (200.0, [1, 1, 1, 2, 2]),
        (120.0, [1, 1, 1, 1, 1]),
        (1.0, [1, 1, 1, 1, 1]),
    ] {
        assert_eq!(strides(rate_hz), expected, "{rate_hz} Hz");
    }
    // sentences have no device time that could show a refresh
    assert!(MESSAGES.iter().flat_map(|layout| &*layout.channels).all(|channel| channel.stride(800.0) == 1));
}
