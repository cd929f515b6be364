//! Hours of packets at 800 Hz, with faults, as fast as the machine can.

use super::*;

/// The number of packets, of 1.25 ms each, in a read.
const PACKETS: u64 = 13;
const PERIOD_NS: u64 = 1_250_000;

/// Time since startup, angular rate and acceleration.
fn put_packet(index: u64, bytes: &mut Vec<u8>) {
    let numbers = [index as f32 * 1e-9, -0.002, 0.0, 0.01, 0.02, -9.8];
    bytes.push(0xFA);
    let body = bytes.len();
    bytes.push(1);
    bytes.extend(0x0121_u16.to_le_bytes());
    bytes.extend((index * PERIOD_NS).to_le_bytes());
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    let crc = vn100_protocol::crc16(&bytes[body..]);
    bytes.extend(crc.to_be_bytes());
}

/// A linear congruential generator (Knuth's MMIX).
struct Chance(u64);

impl Chance {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }
}

/// A quarter of an hour; with `VN100_LINK_HOURS=24`, a day.
#[test]
fn hours_of_packets_at_800_hz_with_faults_lose_the_damaged_ones_alone() {
    let hours: f64 = std::env::var("VN100_LINK_HOURS").map_or(0.25, |hours| hours.parse().unwrap());
    let reads = (hours * 3600.0 * 800.0 / PACKETS as f64) as u64;
    let mut bench = Bench::new(LinkOptions::default());
    let (mut chance, mut index, mut whole) = (Chance(7), 0, 0);
    let (mut bytes, mut losses, mut damaged) = (Vec::new(), 0, 0);
    for _ in 0..reads {
        bench.wait(Duration::from_nanos(PACKETS * PERIOD_NS));
        bytes.clear();
        for _ in 0..PACKETS {
            put_packet(index, &mut bytes);
            index += 1;
        }
        // bytes that the port does not read are lost
        if !bench.machine.is_open() {
            continue;
        }
        whole += PACKETS;
        let place = chance.below(bytes.len() as u64) as usize;
        match chance.below(3000) {
            // a byte is changed, or lost
            0 => {
                damaged += 1;
                bytes[place] ^= 1 << chance.below(8);
            }
            1 => {
                damaged += 1;
                bytes.remove(place);
            }
            // other bytes between two packets
            2 => drop(bytes.splice(0..0, *b"\x00$VN?\xFA\xFF\r\n")),
            3 if chance.below(10) == 0 => {
                losses += 1;
                whole -= PACKETS;
                bench.input(Input::Lost(LinkError::Disconnected));
                continue;
            }
            4 => bench.wait(ms(400)),
            _ => {}
        }
        let chunk = bench.chunk(&bytes);
        bench.input(Input::Received(chunk));
    }
    bench.assert_ledger();
    assert_eq!(bench.rows as u64, whole - damaged);
    assert_eq!((bench.ups(), bench.count(|kind| matches!(kind, LinkEventKind::Down { .. }))), (1 + losses, losses));
    assert!(damaged > 20 && losses > 1, "{damaged} damaged, {losses} losses");
}
