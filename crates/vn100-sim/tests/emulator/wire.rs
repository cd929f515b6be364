//! Sensor, cable and adapter on a clock that the test controls, with faults.

use std::{num::NonZeroU32, time::Duration};

use vn100_protocol::{Decoder, Item, Options};
use vn100_sim::{Device, DeviceConfig, fault::PlugEvent, wire::Wire};

const START: Duration = Duration::from_secs(2);

fn baud(rate: u32) -> NonZeroU32 {
    NonZeroU32::new(rate).unwrap()
}

fn wire_with(plan: &str, seed: u64) -> Wire {
    Wire::new(Device::new(DeviceConfig::default()), &plan.parse().unwrap(), seed, baud(115_200))
}

/// A wire opened two seconds after power-up.
fn opened(plan: &str) -> Wire {
    let mut wire = wire_with(plan, 1);
    while wire.poll_plug(START).is_some() {}
    assert_eq!(wire.open(START), b"");
    wire
}

/// The bytes that the host reads in an interval, polled whenever the wire requests it.
fn read(wire: &mut Wire, from: Duration, until: Duration) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut now = from;
    while now < until {
        bytes.extend(wire.poll(now));
        while wire.poll_plug(now).is_some() {}
        now = wire.next_wakeup(now).min(until);
    }
    bytes.extend(wire.poll(until));
    bytes
}

fn seconds(count: u64) -> Duration {
    Duration::from_secs(count)
}

/// Good and bad lines.
fn lines(bytes: &[u8]) -> (u32, u32) {
    let (mut good, mut bad) = (0, 0);
    let mut decoder = Decoder::new(Options::default());
    decoder.push(bytes, |item| match item {
        Item::Sample(_) => good += 1,
        Item::Rejected(_) => bad += 1,
        _ => {}
    });
    (good, bad)
}

fn without(plan: &str) -> (Vec<u8>, Vec<u8>) {
    (read(&mut opened(""), START, seconds(12)), read(&mut opened(plan), START, seconds(12)))
}

#[test]
fn without_faults_every_byte_arrives() {
    let bytes = read(&mut opened(""), START, seconds(12));
    assert_eq!(lines(&bytes), (400, 0));
    assert_eq!(bytes.len(), 400 * 122);
}

#[test]
fn one_byte_is_lost() {
    let (clean, faulty) = without("drop@5.003s");
    assert_eq!(faulty.len(), clean.len() - 1);
    assert_eq!(lines(&faulty), (399, 1));
}

#[test]
fn a_while_is_lost() {
    let (clean, faulty) = without("drop@5s+1s");
    let lost = clean.len() - faulty.len();
    assert!((40 * 122 - 61..40 * 122 + 61).contains(&lost), "{lost}");
}

#[test]
fn bytes_are_lost_and_inverted_by_chance() {
    let (clean, faulty) = without("drop@1%");
    let lost = clean.len() - faulty.len();
    assert!((400..580).contains(&lost), "{lost} of {}", clean.len());
    let (clean, faulty) = without("flip@1%:bit3");
    let changed = clean.iter().zip(&faulty).filter(|(one, other)| one != other).inspect(|(one, other)| {
        assert_eq!(*one ^ *other, 0b1000);
    });
    assert!((400..580).contains(&changed.count()));
    assert_eq!(clean.len(), faulty.len());
}

#[test]
fn one_bit_or_all_bits_6_are_inverted() {
    let (clean, faulty) = without("flip@5.003s");
    let changed: Vec<_> = clean.iter().zip(&faulty).filter(|(one, other)| one != other).collect();
    assert_eq!(changed.len(), 1);
    assert_eq!((changed[0].0 ^ changed[0].1).count_ones(), 1);
    let (clean, faulty) = without("flip@0s+100h:bit6");
    assert!(clean.iter().zip(&faulty).all(|(one, other)| one ^ other == 0x40));
    assert_eq!(lines(&faulty).0, 0);
}

#[test]
fn two_lines_become_one() {
    let (clean, faulty) = without("splice@5.003s");
    let (good, bad) = lines(&faulty);
    assert_eq!((good, bad), (398, 1));
    let longest = faulty.split(|byte| *byte == b'\n').map(<[u8]>::len).max().unwrap();
    assert!(longest != 121 && clean.len() > faulty.len(), "{longest}");
}

#[test]
fn stalled_bytes_come_at_once_and_none_is_lost() {
    let mut wire = opened("stall@5s+2s");
    let before = read(&mut wire, START, seconds(5));
    let stalled = read(&mut wire, seconds(5), Duration::from_millis(6999));
    let burst = wire.poll(seconds(7));
    let after = read(&mut wire, seconds(7), seconds(12));
    assert!(stalled.len() < 16 && burst.len() > 70 * 122, "{} {}", stalled.len(), burst.len());
    let all = [before, stalled, burst, after].concat();
    assert_eq!(all, read(&mut opened(""), START, seconds(12)));
}

#[test]
fn an_unplugged_sensor_boots_when_it_is_back() {
    let mut wire = wire_with("unplug@3s+4s:other unplug@20s", 1);
    _ = wire.open(START);
    assert_eq!(wire.poll_plug(Duration::from_millis(2999)), None);
    assert_eq!(wire.poll_plug(seconds(3)), Some(PlugEvent::Unplugged));
    assert_eq!(wire.poll(seconds(4)), b"");
    // no host receives it
    wire.write(b"$VNWRG,06,0*6C\r\n", seconds(4));
    assert!(wire.next_wakeup(Duration::from_millis(6500)) == seconds(7));
    assert_eq!(wire.poll_plug(seconds(30)), Some(PlugEvent::Replugged { other_name: true }));
    wire.close(seconds(7));
    _ = wire.open(seconds(7));
    assert_eq!(wire.poll(seconds(7) + Duration::from_millis(1250)), b"");
    assert_eq!(lines(&wire.poll(seconds(10))), (70, 0));
    assert_eq!(wire.poll_plug(seconds(30)), Some(PlugEvent::Unplugged));
    assert_eq!(wire.poll_plug(seconds(3000)), None);
}

#[test]
fn a_reboot_reports_a_fault_and_forgets_the_pause() {
    let mut wire = opened("reboot@5s");
    wire.write(b"$VNASY,0*4F\r\n", START);
    read(&mut wire, START, seconds(3));
    let text = String::from_utf8(read(&mut wire, seconds(3), seconds(7))).unwrap();
    assert!(text.starts_with("$VNERR,01*70\r\n$VNYMR,"), "{text}");
}

#[test]
fn a_line_at_another_rate_is_junk_in_both_directions() {
    let mut wire = opened("baud@3s:57600");
    read(&mut wire, START, seconds(3));
    let junk = read(&mut wire, seconds(3), seconds(5));
    assert!(junk.len() > 1000);
    assert!(lines(&junk).0 <= 1, "the line that was being sent");
    wire.write(b"$VNASY,0*4F\r\n", seconds(5));
    assert!(!read(&mut wire, seconds(5), seconds(6)).is_empty());
    wire.set_host_baud(baud(57_600));
    read(&mut wire, seconds(6), Duration::from_millis(6100));
    assert!(lines(&read(&mut wire, Duration::from_millis(6100), seconds(8))).0 > 70);
    wire.write(b"$VNASY,0*4F\r\n", seconds(8));
    let last = read(&mut wire, seconds(8), seconds(9));
    assert!(last.ends_with(b"$VNASY,0*4F\r\n"));
}

#[test]
fn a_port_that_is_opened_may_begin_with_old_bytes() {
    let mut wire = wire_with("stale", 1);
    // bytes sent before the first opening are old as well
    assert_eq!(wire.open(START).len(), 40);
    let session = read(&mut wire, START, START + Duration::from_millis(110));
    wire.close(seconds(3));
    let stale = wire.open(seconds(4));
    assert_eq!(stale.len(), 40);
    assert!(!stale.starts_with(b"$") && session.len() > 40);
}

#[test]
fn some_openings_are_bad_until_the_next() {
    let mut wire = wire_with("badopen@20%", 7);
    let mut now = START;
    let mut bad = 0;
    for _ in 0..500 {
        _ = wire.open(now);
        now += Duration::from_millis(60);
        let bytes = wire.poll(now);
        let inverted = bytes.iter().filter(|byte| **byte == b'$' ^ 0x40).count();
        assert!(inverted == 0 || !bytes.contains(&b'$'), "all of a session or nothing");
        bad += u32::from(inverted > 0);
        wire.close(now);
    }
    assert!((60..140).contains(&bad), "{bad}");
}

#[test]
fn equal_seeds_give_equal_faults() {
    let session = |seed| {
        let mut wire = wire_with("drop@0.5% flip@0.5%", seed);
        _ = wire.open(START);
        read(&mut wire, START, seconds(8))
    };
    assert_eq!(session(1), session(1));
    assert_ne!(session(1), session(2));
}

#[test]
fn nothing_is_kept_for_an_absent_host() {
    let mut wire = wire_with("stall@3s+60s", 1);
    assert_eq!(wire.poll(seconds(60)), b"");
    assert_eq!(wire.next_wakeup(seconds(60)), seconds(61));
    assert_eq!(wire.open(seconds(61)), b"");
    assert_eq!(wire.poll(Duration::from_millis(62_999)), b"");
    assert!((79..=81).contains(&lines(&wire.poll(seconds(63))).0), "two seconds and not sixty");
}
