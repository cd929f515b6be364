//! Binary output: registers 75 to 77 and the packets that they request.

use vn100_protocol::{DeviceError, crc16};

use super::{Firmware, command::check_count};
use crate::sensor::{Deltas, SensorValues, single};

#[derive(Debug, Clone, Copy)]
pub(crate) struct PacketContents<'a> {
    pub(crate) measured: &'a SensorValues,
    pub(crate) deltas: &'a Deltas,
    /// Time since start-up, ns.
    pub(crate) time_ns: u64,
    pub(crate) sync_out_count: u32,
}

/// Bytes of each field by its bit, 0 if a VN-100 has none. Fields of a satellite receiver, and those
/// in the axes of the Earth, are sent as zeros.
///
/// The groups in the order of their bits: common, time, inertial, satellites, attitude. A packet
/// with any other group is rejected.
#[rustfmt::skip]
const FIELD_BYTES: [[u32; 16]; 5] = [
    [8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8, 0],
    [8, 8, 8, 2, 8, 8, 8, 4, 4, 1, 0, 0, 0, 0, 0, 0],
    [2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2, 0, 0, 0, 0],
    [0; 16],
    [2, 12, 16, 36, 12, 12, 12, 12, 12, 0, 0, 0, 0, 0, 0, 0],
];

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PacketOutput {
    /// 0 off, 1 first port, 2 second port, 3 both.
    mode: u32,
    /// Ticks of 800 Hz from packet to packet; 0 for packets only on request.
    divisor: u32,
    groups: u8,
    words: Vec<u16>,
}

impl PacketOutput {
    /// Factory default: no packets. With firmware 3 a poll gives the time, with earlier firmware nothing.
    pub(crate) fn off(firmware: Firmware) -> Self {
        let (groups, words) = if firmware == Firmware::V3_1 { (1, vec![1]) } else { (0, Vec::new()) };
        Self { mode: 0, divisor: 0, groups, words }
    }

    pub(crate) fn parse(parameters: &[&str]) -> Result<Self, DeviceError> {
        let [mode, divisor, groups, words @ ..] = parameters else {
            return Err(DeviceError::TooFewParameters);
        };
        let mode = mode.parse().ok().filter(|mode| *mode <= 3).ok_or(DeviceError::InvalidParameter)?;
        let divisor: u16 = divisor.parse().map_err(|_| DeviceError::InvalidParameter)?;
        let groups = u8::from_str_radix(groups, 16).map_err(|_| DeviceError::InvalidParameter)?;
        check_count(words, groups.count_ones() as usize)?;
        let words: Result<Vec<u16>, _> = words.iter().map(|word| u16::from_str_radix(word, 16)).collect();
        let words = words.map_err(|_| DeviceError::InvalidParameter)?;
        let output = Self { mode, divisor: u32::from(divisor), groups, words };
        let known = groups != 0
            && groups < 1 << FIELD_BYTES.len()
            && output.words().all(|(group, word)| word != 0 && bits(word).all(|bit| FIELD_BYTES[group][bit] != 0));
        if known { Ok(output) } else { Err(DeviceError::InvalidParameter) }
    }

    pub(crate) fn print(&self, firmware: Firmware) -> String {
        let digits = if self.groups == 0 && firmware == Firmware::V2_1 { 1 } else { 2 };
        let words: String = self.words.iter().map(|word| format!(",{word:04X}")).collect();
        format!("{},{},{:0digits$X}{words}", self.mode, self.divisor, self.groups)
    }

    /// Ticks from packet to packet on a port, if it sends any by itself.
    pub(crate) fn divisor_on(&self, port: usize) -> Option<u64> {
        (self.mode >> port & 1 == 1 && self.divisor > 0).then_some(u64::from(self.divisor))
    }

    pub(crate) fn bytes_per_800_s(&self, port: usize) -> u64 {
        self.divisor_on(port).map_or(0, |divisor| u64::from(self.packet_bytes()) * 800 * 800 / divisor)
    }

    /// Whether it carries integrals since its last packet.
    pub(crate) fn has_deltas(&self) -> bool {
        self.words().any(|(group, word)| match group {
            0 => word & 1 << 11 != 0,
            2 => word & 0b11 << 6 != 0,
            _ => false,
        })
    }

    fn packet_bytes(&self) -> u32 {
        let payload: u32 =
            self.words().map(|(group, word)| 2 + bits(word).map(|bit| FIELD_BYTES[group][bit]).sum::<u32>()).sum();
        4 + payload
    }

    fn words(&self) -> impl Iterator<Item = (usize, u16)> + '_ {
        bits(u16::from(self.groups)).zip(self.words.iter().copied())
    }

    /// ```text
    /// FA | groups | field word, little-endian, for each group | fields | CRC-16, high byte first
    /// ```
    pub(crate) fn packet(&self, contents: &PacketContents<'_>) -> Vec<u8> {
        let mut packet = vec![0xFA, self.groups];
        packet.extend(self.words.iter().flat_map(|word| word.to_le_bytes()));
        for (group, word) in self.words() {
            for bit in bits(word) {
                let start = packet.len();
                contents.append(group, bit, &mut packet);
                // fields that are not emulated
                packet.resize(start + FIELD_BYTES[group][bit] as usize, 0);
            }
        }
        let crc = crc16(&packet[1..]);
        packet.extend(crc.to_be_bytes());
        packet
    }
}

fn bits(word: u16) -> impl Iterator<Item = usize> {
    (0..16).filter(move |bit| word >> bit & 1 == 1)
}

impl PacketContents<'_> {
    /// Appends a field of one of the groups in `FIELD_BYTES`; nothing for an unknown field.
    fn append(&self, group: usize, bit: usize, out: &mut Vec<u8>) {
        let Self { measured, deltas, .. } = self;
        let mut floats = |values: &[f32]| out.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        match (group, bit) {
            (0 | 1, 0) => out.extend(self.time_ns.to_le_bytes()),
            (1, 8) => out.extend(self.sync_out_count.to_le_bytes()),
            (0, 3) | (4, 1) => floats(&measured.ypr_deg),
            (0, 4) | (4, 2) => floats(&measured.quaternion()),
            (0, 5) | (2, 10) => floats(&measured.gyro_rad_s),
            (0, 8) | (2, 9) => floats(&measured.accel_m_s2),
            (0, 9) => {
                floats(&measured.uncompensated_accel_m_s2);
                floats(&measured.uncompensated_gyro_rad_s);
            }
            (0, 10) => {
                floats(&measured.mag_gauss);
                floats(&[measured.temperature_c, measured.pressure_kpa]);
            }
            (0, 11) => {
                floats(&[deltas.time_s as f32]);
                floats(&single(deltas.theta_deg));
                floats(&single(deltas.velocity_m_s));
            }
            (2, 1) => floats(&measured.uncompensated_mag_gauss),
            (2, 2) => floats(&measured.uncompensated_accel_m_s2),
            (2, 3) => floats(&measured.uncompensated_gyro_rad_s),
            (2, 4) => floats(&[measured.temperature_c]),
            (2, 5) => floats(&[measured.pressure_kpa]),
            (2, 6) => {
                floats(&[deltas.time_s as f32]);
                floats(&single(deltas.theta_deg));
            }
            (2, 7) => floats(&single(deltas.velocity_m_s)),
            (2, 8) => floats(&measured.mag_gauss),
            _ => {}
        }
    }
}
