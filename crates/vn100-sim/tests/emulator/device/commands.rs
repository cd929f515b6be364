//! Commands, registers and errors.

use proptest::prelude::*;
use vn100_protocol::{crc16, xor8};
use vn100_sim::{DeviceConfig, device::Firmware};

use super::bench::Bench;

/// Replies of real units and of the maker's documents, to reads of a sensor with factory defaults.
const READ: [&str; 23] = [
    "$VNRRG,01,VN-100S-CR*35",
    "$VNRRG,02,7*6A",
    "$VNRRG,03,0100130608*51",
    "$VNRRG,04,3.1.0.0*77",
    "$VNRRG,05,115200*5D",
    "$VNRRG,05,115200,1*40",
    "$VNRRG,06,14*5C",
    "$VNRRG,06,14,1*41",
    "$VNRRG,07,40*5C",
    "$VNRRG,07,40,1*41",
    "$VNRRG,21,1,0,1.8,0,0,-9.793746*64",
    "$VNRRG,23,1,0,0,0,1,0,0,0,1,0,0,0*73",
    "$VNRRG,25,1,0,0,0,1,0,0,0,1,0,0,0*75",
    "$VNRRG,26,1,0,0,0,1,0,0,0,1*6A",
    "$VNRRG,30,0,0,0,0,1,0,1*6C",
    "$VNRRG,32,3,0,0,0,0,0,0,100000000,0*6C",
    "$VNRRG,33,0,0,0*6F",
    "$VNRRG,35,1,1,1,1*75",
    "$VNRRG,43,+00.000000,+00.000000,+00.000000*5D",
    "$VNRRG,44,0,1,5*6B",
    "$VNRRG,75,0,0,01,0001*71",
    "$VNRRG,82,0,0,0,0,0*65",
    "$VNRRG,85,0,4,4,4,0,0,3,3,3,0*79",
];

/// Published writes, whose echo is the line itself.
const WRITE: [&str; 37] = [
    "$VNWRG,06,0*6C",
    "$VNWRG,06,1*6D",
    "$VNWRG,06,13*5E",
    "$VNWRG,06,14*59",
    "$VNWRG,06,19*54",
    "$VNWRG,06,30*5F",
    "$VNWRG,06,14,2*47",
    "$VNWRG,06,0*6C",
    "$VNWRG,07,0*6D",
    "$VNWRG,07,1*6C",
    "$VNWRG,07,2*6F",
    "$VNWRG,07,4*69",
    "$VNWRG,07,5*68",
    "$VNWRG,07,10*5C",
    "$VNWRG,07,20*5F",
    "$VNWRG,07,25*5A",
    "$VNWRG,07,40*59",
    "$VNWRG,07,50*58",
    "$VNWRG,07,100*6C",
    "$VNWRG,07,200*6F",
    "$VNWRG,05,9600*50",
    "$VNWRG,05,19200*65",
    "$VNWRG,05,38400*60",
    "$VNWRG,05,57600*6B",
    "$VNWRG,05,128000*54",
    "$VNWRG,05,230400*5A",
    "$VNWRG,05,460800*55",
    "$VNWRG,05,921600*53",
    "$VNWRG,05,115200*58",
    "$VNWRG,32,3,0,0,0,1,1,0,500000,0*5D",
    "$VNWRG,75,0,0,01,0001*74",
    "$VNWRG,75,1,4,01,0201*73",
    "$VNWRG,75,1,5,01,0601*76",
    "$VNWRG,75,1,20,01,0609*49",
    "$VNWRG,75,1,4,06,0001,001E*2E",
    "$VNWRG,82,0,1,1,0,0*60",
    "$VNWRG,85,0,20,20,4,0,0,3,3,3,0*7C",
];

fn answer(bench: &mut Bench, line: &str) -> String {
    bench.send(&format!("{line}\r\n"));
    bench.wait_ms(300).trim_end().to_owned()
}

#[test]
fn a_sensor_with_factory_defaults_replies_like_real_units() {
    let mut bench = Bench::quiet_with(DeviceConfig { serial: 100_130_608, ..DeviceConfig::default() });
    for reply in READ {
        let number = &reply[7..9];
        let port = if reply.ends_with(",1*40") || reply.ends_with(",1*41") { ",1" } else { "" };
        assert_eq!(bench.ask(&format!("VNRRG,{number}{port}")).trim_end(), reply);
    }
}

#[test]
fn firmware_2_1_differs_as_documented() {
    let mut old = Bench::quiet_with(DeviceConfig { firmware: Firmware::V2_1, ..DeviceConfig::default() });
    assert_eq!(old.ask("VNRRG,04"), "$VNRRG,04,2.1.0.0*76\r\n");
    assert!(old.ask("VNRRG,44").starts_with("$VNRRG,44,1,3,5*"));
    assert_eq!(old.ask("VNTAR"), "$VNTAR*5F\r\n");
    assert_eq!(old.error("VNWRG,07,0"), "07");
    let mut new = Bench::quiet();
    assert_eq!(new.error("VNTAR"), "04");
    new.set("07,0");
}

#[test]
fn firmwares_differ_in_their_packets() {
    for (firmware, off) in [(Firmware::V2_1, "0,0,0"), (Firmware::V3_1, "0,0,01,0001")] {
        let mut bench = Bench::quiet_with(DeviceConfig { firmware, ..DeviceConfig::default() });
        assert!(bench.ask("VNRRG,75").starts_with(&format!("$VNRRG,75,{off}*")), "{firmware:?}");
        for fields in ["0,16,02,0001", "0,16,10,0100", "0,16,05,0001,001C", "0,0,01,0001", "0,16,10,0002"] {
            bench.set(&format!("75,{fields}"));
        }
        assert_eq!(bench.error("VNWRG,75,0,0,00"), "07", "no group at all");
    }
}

#[test]
fn rate_message_and_frequency_of_either_port_are_written_by_its_number() {
    let mut bench = Bench::quiet();
    for (register, first, second) in [("05", "115200", "57600"), ("06", "14", "1"), ("07", "40", "10")] {
        bench.set(&format!("{register},{second},2"));
        assert!(bench.ask(&format!("VNRRG,{register},1")).starts_with(&format!("$VNRRG,{register},{first},1*")));
        assert!(bench.ask(&format!("VNRRG,{register},2")).starts_with(&format!("$VNRRG,{register},{second},2*")));
    }
}

#[test]
fn published_writes_are_echoed_unchanged() {
    let mut bench = Bench::quiet();
    for line in WRITE {
        assert_eq!(answer(&mut bench, line), line);
        let number = &line[7..9];
        let port = if line.contains("14,2") { ",2" } else { "" };
        let settings = &line[7..line.len() - 3];
        assert!(bench.ask(&format!("VNRRG,{number}{port}")).starts_with(&format!("$VNRRG,{settings}*")), "{line}");
    }
}

#[test]
fn numbers_of_registers_are_replied_with_two_digits_and_settings_as_stored() {
    let mut bench = Bench::quiet();
    assert!(bench.ask("VNRRG,8").starts_with("$VNRRG,08,"));
    assert!(bench.ask("VNRRG,006").starts_with("$VNRRG,06,14*"));
    assert_eq!(bench.ask("VNWRG,6,14"), "$VNWRG,06,14*59\r\n");
    assert!(bench.ask("VNWRG,75,0,04,1,601").starts_with("$VNWRG,75,0,4,01,0601*"));
    assert!(bench.ask("VNWRG,21,1.002110,0,1.80,0,0,-9.5").starts_with("$VNWRG,21,1.00211,0,1.8,0,0,-9.5*"));
    assert_eq!(bench.ask("VNWRG,00,SENSOR_A14").trim_end(), "$VNWRG,00,SENSOR_A14*57");
    assert_eq!(bench.ask("VNRRG,0").trim_end(), "$VNRRG,00,SENSOR_A14*52");
}

#[test]
fn every_register_of_the_checklist_is_there() {
    let mut bench = Bench::quiet();
    let all = [
        0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 17, 18, 19, 20, 21, 23, 25, 26, 27, 30, 32, 33, 35, 36, 38, 43, 44, 47, 54,
        75, 76, 77, 80, 82, 83, 84, 85,
    ];
    for number in 0..300 {
        let answer = bench.ask(&format!("VNRRG,{number}"));
        let expected =
            if all.contains(&number) { format!("$VNRRG,{number:02},") } else { "$VNERR,08*79\r\n".to_owned() };
        assert!(answer.starts_with(&expected), "{answer}");
    }
}

#[test]
fn a_wrong_command_is_answered_by_the_error_of_its_kind() {
    let mut bench = Bench::quiet();
    for (body, code) in [
        ("VNXYZ", "04"),
        ("GPGGA,1", "04"),
        ("VNFWU", "04"),
        ("VNRRG", "05"),
        ("VNWRG,07", "05"),
        ("VNWRG,30,0,0,0,0,1,0", "05"),
        ("VNWRG,75,1,4,01", "05"),
        ("VNWRG,75,1,4", "05"),
        ("VNASY", "05"),
        ("VNRRG,01,1", "06"),
        ("VNRRG,06,1,1", "06"),
        ("VNWRG,07,40,1,1", "06"),
        ("VNWRG,30,0,0,0,0,1,0,1,0", "06"),
        ("VNWRG,75,1,4,01,0001,0001", "06"),
        ("VNWNV,1", "06"),
        ("VNASY,0,1", "06"),
        ("VNWRG,07,30", "07"),
        ("VNWRG,07,fast", "07"),
        ("VNWRG,06,20", "07"),
        ("VNWRG,06,14,3", "07"),
        ("VNWRG,05,115201", "07"),
        ("VNWRG,30,0,0,0,0,2,0,1", "07"),
        ("VNWRG,21,1,0,nan,0,0,0", "07"),
        ("VNWRG,21,1,0,inf,0,0,0", "07"),
        ("VNWRG,26,1,0,0,0,1,0,0,0,1.1", "07"),
        ("VNWRG,75,1,4,08,0001", "07"),
        ("VNWRG,75,4,4,01,0001", "07"),
        ("VNWRG,75,1,4,01,8001", "07"),
        ("VNWRG,33,1,0,0", "07"),
        ("VNWRG,00,a name of 21 letters!", "07"),
        ("VNASY,2", "07"),
        ("VNBOM,4", "07"),
        ("VNRRG,22", "08"),
        ("VNRRG,70000", "08"),
        ("VNWRG,22,1", "08"),
        ("VNWRG,, 40", "08"),
        ("VNWRG,01,mine", "09"),
        ("VNWRG,03,1", "09"),
        ("VNWRG,04,2.0", "09"),
        ("VNWRG,27,0", "09"),
        ("VNWRG,47,1,0,0,0,1,0,0,0,1,0,0,0", "09"),
    ] {
        assert_eq!(bench.error(body), code, "{body}");
    }
    // nothing has changed
    for reply in READ.iter().filter(|reply| !reply.starts_with("$VNRRG,03")) {
        assert!(bench.ask(&reply[1..9]).starts_with(&reply[..9]));
    }
    assert_eq!(bench.ask("VNRRG,26").trim_end(), "$VNRRG,26,1,0,0,0,1,0,0,0,1*6A");
}

#[test]
fn check_digits_are_of_either_kind_or_left_out() {
    let mut bench = Bench::quiet();
    let hardware = "$VNRRG,01,VN-100S-CR*35";
    for line in ["$VNRRG,01*72", "$VNRRG,01*E15F", "$VNRRG,01*e15f", "$VNRRG,01*XX", "$VNRRG,01*XXXX"] {
        assert_eq!(answer(&mut bench, line), hardware, "{line}");
    }
    for line in
        ["$VNRRG,01*73", "$VNRRG,01*E15E", "$VNRRG,01*xx", "$VNRRG,01*7", "$VNRRG,01*+72", "$VNRRG,01*", "$VNRRG,01"]
    {
        assert_eq!(answer(&mut bench, line), "$VNERR,03*72", "{line}");
    }
    // a line feed is enough, and bytes before the last $ belong to no command
    bench.send("noise\r\n$VNR$VNRRG,01*72\n");
    assert_eq!(bench.wait_ms(100).trim_end(), hardware);
    bench.send("$VNRRG,01*72");
    assert_eq!(bench.wait_ms(1000), "");
}

#[test]
fn register_30_chooses_the_check_digits_of_all_output() {
    let mut bench = Bench::quiet();
    assert!(bench.ask("VNWRG,30,0,0,0,0,3,0,1").ends_with("\r\n"));
    assert_eq!(bench.ask("VNXYZ"), format!("$VNERR,04*{:04X}\r\n", crc16(b"VNERR,04")));
    assert_eq!(answer(&mut bench, "$VNERR,03*00"), "$VNERR,03*B43A");
    bench.set("06,1");
    let lines = format!("{}{}", bench.ask("VNASY,1"), bench.wait_ms(200));
    let line = lines.lines().nth(1).unwrap();
    let (body, digits) = line[1..].split_once('*').unwrap();
    assert_eq!(digits, format!("{:04X}", crc16(body.as_bytes())));
    assert_ne!(digits, format!("{:02X}", xor8(body.as_bytes())));
}

#[test]
fn error_mode_suppresses_or_sends_and_stops() {
    let mut bench = Bench::quiet();
    bench.set("30,0,0,0,0,1,0,0");
    assert_eq!(bench.ask("VNXYZ"), "");
    bench.set("30,0,0,0,0,1,0,2");
    assert!(bench.ask("VNASY,1").contains("$VNYMR,"));
    assert!(bench.ask("VNXYZ").contains("$VNERR,04*75"));
    assert_eq!(bench.wait_ms(1000), "");
    assert_eq!(bench.ask("VNRRG,06"), "$VNRRG,06,0*69\r\n");
}

#[test]
fn a_command_beyond_the_buffer_overflows_it_once() {
    let mut bench = Bench::quiet();
    let body = format!("$VNWRG,00,{}", "x".repeat(245));
    assert_eq!(body.len(), 255);
    bench.send(&body);
    assert_eq!(bench.wait_ms(100), "");
    bench.send("xx");
    assert_eq!(bench.wait_ms(100), "$VNERR,02*73\r\n");
    bench.send(&"x".repeat(1000));
    bench.send("*XX\r\n$VNRRG,06*75\r\n");
    assert_eq!(bench.wait_ms(100), "$VNRRG,06,14*5C\r\n");
}

#[test]
fn the_bias_estimate_can_be_kept() {
    let mut bench = Bench::quiet();
    assert_eq!(bench.ask("VNSGB"), "$VNSGB*4E\r\n");
    assert!(!bench.ask("VNRRG,43").contains("+00.000000,+00.000000"));
}

fn commands() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        Just(b"$VNRRG,01*72\r\n".to_vec()),
        Just(b"$VNWRG,07,50*58\n".to_vec()),
        Just(b"$VNXYZ*00\r\n".to_vec()),
        Just(b"$VNWRG,75,1,4,01,0601*BE74\r\n".to_vec()),
        Just(b"$VNBOM,1*45\r\n".to_vec()),
        Just(vec![b'x'; 300]),
        prop::collection::vec(any::<u8>(), 0..40),
        prop::collection::vec(prop::sample::select(b"$VNRWG0123456789,*X\r\n".to_vec()), 0..60),
    ];
    prop::collection::vec(part, 0..12).prop_map(|parts| parts.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The test also shows that no bytes make the sensor panic.
    #[test]
    fn the_division_of_a_command_has_no_effect(bytes in commands(), cuts in prop::collection::vec(1_usize..50, 1..40)) {
        let mut whole = Bench::quiet();
        let mut cut = Bench::quiet();
        whole.device.receive(&bytes, whole.now);
        let mut rest = &bytes[..];
        for length in cuts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (piece, behind) = rest.split_at((*length).min(rest.len()));
            cut.device.receive(piece, cut.now);
            rest = behind;
        }
        let time = std::time::Duration::from_secs(2);
        prop_assert_eq!(whole.wait(time), cut.wait(time));
    }
}
