//! The output: sentences, suffixes and packets.

use std::time::Duration;

use vn100_protocol::{Decoder, Item, Options, Packet, VNIMU, VNMAR, VNQMR, VNYMR};
use vn100_sim::{DeviceConfig, Profile, noise::NoiseTruth};

use super::bench::Bench;

/// Number in register 6, header, the register with the same contents, bytes, fields.
const MESSAGES: [(u32, &str, u32, usize, usize); 10] = [
    (1, "VNYPR", 8, 38, 3),
    (2, "VNQTN", 9, 51, 4),
    (8, "VNQMR", 15, 135, 13),
    (10, "VNMAG", 17, 38, 3),
    (11, "VNACC", 18, 35, 3),
    (12, "VNGYR", 19, 44, 3),
    (13, "VNMAR", 20, 95, 9),
    (14, "VNYMR", 27, 122, 12),
    (19, "VNIMU", 54, 112, 11),
    (30, "VNDTV", 80, 75, 7),
];

/// A sensor without noise whose channels all have the same mean.
fn constant(mean: f64) -> DeviceConfig {
    let mut profile = Profile::datasheet();
    for channel in &mut profile.channels {
        channel.noise = NoiseTruth { mean, ..NoiseTruth::default() };
    }
    DeviceConfig { profile, ..DeviceConfig::default() }
}

/// The first line of a message.
fn line(bench: &mut Bench) -> String {
    bench.send("$VNASY,1*4E\r\n");
    let output = bench.wait_ms(100);
    bench.ask("VNASY,0");
    output.lines().nth(1).unwrap().to_owned()
}

#[test]
fn every_message_has_its_header_length_and_fields_and_equals_its_register() {
    let mut bench = Bench::quiet();
    for (message, header, register, bytes, fields) in MESSAGES {
        bench.set(&format!("06,{message}"));
        // integrals restart
        bench.ask(&format!("VNRRG,{register}"));
        let line = line(&mut bench);
        assert!(line.starts_with(&format!("${header},")), "{line}");
        assert_eq!((line.len() + 2, line.matches(',').count()), (bytes, fields), "{line}");
        let reply = bench.ask(&format!("VNRRG,{register}"));
        let shape = |text: &str| text.bytes().filter(|byte| matches!(byte, b'.' | b',')).collect::<Vec<_>>();
        let (values, _) = reply.split_once('*').unwrap();
        let values = &values[format!("$VNRRG,{register:02}").len()..];
        assert_eq!(shape(values), shape(line[6..].split('*').next().unwrap()), "{reply}");
        assert_eq!(values.len(), line.len() - 9, "{reply}");
    }
}

#[test]
fn negative_zero_and_wide_values_are_printed_as_the_sensor_does() {
    let mut bench = Bench::quiet_with(constant(-1e-9));
    assert_eq!(
        line(&mut bench),
        "$VNYMR,-000.000,-000.000,-000.000,-00.0000,-00.0000,-00.0000,-00.000,-00.000,-00.000,-00.000000,-00.000000,-00.000000*6E"
    );
    let mut wide = Bench::quiet_with(constant(-123.9306));
    wide.set("06,13");
    let text = line(&mut wide);
    assert!(text.contains(",-123.9306,") && text.contains(",-123.931,") && text.contains(",-123.930603,"), "{text}");
    assert_eq!(text.len(), 95 - 2 + 3 * (1 + 1 + 1));
}

#[test]
fn the_decoder_accepts_every_line_of_the_measuring_messages() {
    for (message, layout) in [(14, &VNYMR), (19, &VNIMU), (13, &VNMAR), (8, &VNQMR)] {
        let mut bench = Bench::quiet();
        bench.set(&format!("06,{message}"));
        bench.set("07,50");
        bench.send("$VNASY,1*4E\r\n");
        let output = bench.wait(Duration::from_millis(10_015));
        let mut samples = 0;
        let mut decoder = Decoder::new(Options::default());
        decoder.push(&output, |item| match item {
            Item::Sample(sample) if sample.layout == layout => samples += 1,
            Item::Rejected(line) => panic!("{}", line.kind),
            _ => {}
        });
        assert_eq!(samples, 500, "{}", layout.message);
    }
}

#[test]
fn suffixes_precede_the_check_digits() {
    let mut bench = Bench::quiet();
    bench.set("06,1");
    let body = |bench: &mut Bench| line(bench).split('*').next().unwrap().to_owned();
    assert_eq!(body(&mut bench).matches(',').count(), 3);
    bench.set("30,1,0,0,0,1,0,1");
    assert!(body(&mut bench).ends_with(",T0"));
    bench.set("30,0,1,0,0,1,0,1");
    assert!(body(&mut bench).ends_with(",S0000"));
    bench.set("30,3,1,0,0,1,0,1");
    assert!(body(&mut bench).ends_with(",T0,S0000"));
}

#[test]
fn the_count_of_edges_counts_lines() {
    for (settings, per_line) in [("1,0,0", 20), ("2,0,0", 20), ("2,0,1", 10), ("3,0,0", 10), ("1,0,19", 1)] {
        let mut bench = Bench::quiet();
        bench.set("30,3,0,0,0,1,0,1");
        bench.set("06,1");
        bench.set(&format!("32,3,0,0,0,{settings},100000000,0"));
        bench.send("$VNASY,1*4E\r\n");
        let output = bench.wait_ms(1000);
        let counts: Vec<i64> = output
            .lines()
            .skip(1)
            .filter_map(|line| line.split_once(",T")?.1.split('*').next()?.parse().ok())
            .collect();
        assert!(counts.len() > 30);
        assert!(counts.windows(2).all(|pair| pair[1] - pair[0] == per_line), "{settings}: {counts:?}");
        // read and cleared
        bench.send("$VNASY,0*4F\r\n");
        bench.wait_ms(20);
        assert!(!bench.ask("VNRRG,33").starts_with("$VNRRG,33,0,0,0*"));
        assert_eq!(bench.ask("VNWRG,33,0,0,0"), "$VNWRG,33,0,0,0*6A\r\n");
        let count: i64 = bench.ask("VNRRG,33")[14..].split('*').next().unwrap().parse().unwrap();
        assert!(count <= 600 * 800 / 1000, "{count}");
    }
}

fn packets(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut packets = Vec::new();
    Decoder::new(Options::default()).push(bytes, |item| {
        if let Item::Packet(Packet { raw, .. }) = item {
            packets.push(raw.to_vec());
        }
    });
    packets
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn a_poll_is_answered_only_by_the_packet() {
    let mut bench = Bench::quiet();
    bench.set("75,0,0,01,0739");
    bench.send("$VNBOM,1*749D\r\n");
    let output = bench.wait(Duration::from_millis(20));
    assert_eq!(output.len(), 110);
    let packet = &packets(&output)[0];
    assert_eq!(packet[..4], [0xFA, 0x01, 0x39, 0x07]);
    let time_ns = u64::from_le_bytes(packet[4..12].try_into().unwrap());
    assert_eq!(time_ns / 10_000_000, bench.now.as_millis() as u64 / 10 - 2);
    assert!((float(packet, 60) + 9.8).abs() < 0.2, "acceleration z");
    // by default a poll gives the time
    bench.send("$VNBOM,2*46\r\n");
    assert_eq!(bench.wait(Duration::from_millis(20)).len(), 14);
}

#[test]
fn an_output_without_a_divisor_sends_only_on_request() {
    let mut bench = Bench::quiet();
    bench.set("75,1,0,01,0001");
    bench.set("06,0");
    bench.send("$VNASY,1*4E\r\n");
    assert_eq!(bench.wait_ms(1000), "$VNASY,1*4E\r\n");
    bench.send("$VNBOM,1*45\r\n");
    assert_eq!(packets(&bench.wait(Duration::from_millis(20))).len(), 1);
}

#[test]
fn every_field_alone_is_a_packet_of_its_length() {
    let groups: [(u8, &[usize]); 4] = [
        (0x01, &[8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8]),
        (0x02, &[8, 8, 8, 2, 8, 8, 8, 4, 4, 1]),
        (0x04, &[2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2]),
        (0x10, &[2, 12, 16, 36, 12, 12, 12, 12, 12]),
    ];
    let mut bench = Bench::quiet();
    for (group, sizes) in groups {
        for (bit, size) in sizes.iter().enumerate() {
            bench.set(&format!("77,0,0,{group:02X},{:04X}", 1 << bit));
            bench.send("$VNBOM,3*47\r\n");
            let packets = packets(&bench.wait(Duration::from_millis(20)));
            assert_eq!(packets.len(), 1, "{group} {bit}");
            assert_eq!(packets[0].len(), 6 + size);
        }
    }
}

#[test]
fn a_packet_comes_before_the_line_of_its_tick_with_the_same_values() {
    let mut bench = Bench::quiet();
    bench.set("05,921600");
    bench.set("75,1,20,01,0128");
    bench.send("$VNASY,1*4E\r\n");
    let output = bench.wait(Duration::from_secs(1));
    let mut packet_values: Option<Vec<f32>> = None;
    let mut pairs = 0;
    Decoder::new(Options::default()).push(&output, |item| match item {
        Item::Packet(Packet { raw, .. }) => {
            assert!(packet_values.is_none());
            packet_values = Some((0..9).map(|index| float(raw, 4 + 4 * index)).collect());
        }
        Item::Sample(sample) => {
            let values = packet_values.take().unwrap();
            let printed = |values: &[f32], decimals: usize| {
                values.iter().map(|value| format!("{value:.decimals$}").parse().unwrap()).collect::<Vec<f64>>()
            };
            let sampled: Vec<f64> = sample.values().collect();
            assert_eq!(printed(&values[..3], 3), sampled[..3]);
            assert_eq!(printed(&values[3..6], 6), sampled[9..]);
            assert_eq!(printed(&values[6..9], 3), sampled[6..9]);
            pairs += 1;
        }
        _ => {}
    });
    assert!(pairs >= 39);
}

#[test]
fn attitude_agrees_with_a_recorded_packet() {
    // angles and quaternion as sent by a real unit
    let angles = [-85.59866, 75.00573, 63.62910];
    let recorded: Vec<u8> = (0..16)
        .map(|index| {
            let hex = "fe8928bf6c74c3bd438a313fa69b8dbe";
            u8::from_str_radix(&hex[2 * index..2 * index + 2], 16).unwrap()
        })
        .collect();
    let mut config = constant(0.0);
    for (channel, angle) in config.profile.channels.iter_mut().zip(angles) {
        channel.noise.mean = angle;
    }
    let mut bench = Bench::quiet_with(config);
    bench.set("75,0,0,01,0010");
    bench.send("$VNBOM,1*45\r\n");
    let packet = &packets(&bench.wait(Duration::from_millis(20)))[0];
    let sign = (float(packet, 4) * float(&recorded, 0)).signum();
    for index in 0..4 {
        let difference = sign * float(packet, 4 + 4 * index) - float(&recorded, 4 * index);
        assert!(difference.abs() < 1e-5, "{index}: {difference}");
    }
}

#[test]
fn integrals_are_those_of_the_time_since_they_were_read() {
    let mut config = constant(0.0);
    config.profile.channels[9].noise.mean = 0.5;
    config.profile.channels[8].noise.mean = -9.8;
    let mut bench = Bench::quiet_with(config);
    let read = |bench: &mut Bench| -> Vec<f64> {
        let reply = bench.ask("VNRRG,80");
        reply.split(['*', ',']).skip(2).take(7).map(|field| field.parse().unwrap()).collect()
    };
    read(&mut bench);
    bench.wait_ms(700);
    let fields = read(&mut bench);
    assert!((fields[0] - 1.0).abs() < 0.002, "a second has passed: {fields:?}");
    assert!((fields[6] / fields[0] + 9.8).abs() < 0.01);
    // the bias at turn-on is part of it
    assert!((fields[1] / fields[0] - 0.5_f64.to_degrees()).abs() < 10.0);
}

/// The baud rate of each port carries the fast sentences of such a profile, or no write of packets fits.
#[test]
fn a_sensor_like_one_of_200_hz_sends_packets() {
    let profile = Profile { rate_hz: 200.0, ..Profile::datasheet() };
    let mut bench = Bench::switched_on(DeviceConfig { profile, ..DeviceConfig::default() });
    // it boots
    bench.wait(Duration::from_secs(2));
    bench.send("$VNASY,0*4F\r\n");
    bench.set("06,0");
    bench.set("75,1,4,01,0128");
}
