//! Files of packets, with the clock of the sensor.

use vn100_protocol::{MEASUREMENTS_PER_S, PacketMessage};

use crate::{
    capture::{Generator, UnsupportedRate, values_of},
    device::binary::{PacketContents, PacketOutput},
    profile::Profile,
    sensor::Deltas,
    sensor_clock::SensorClock,
};

/// The time of the first packet of a sensor in a capture, in nanoseconds since the sensor started.
const FIRST_NS: u64 = 1_250_000_000;

/// The rate at which thermometer and barometer are read.
const SURROUNDINGS_HZ: u64 = 120;

/// The endless, seeded stream of an emulated sensor's packets.
#[derive(Debug)]
pub struct PacketStream {
    generator: Generator,
    output: PacketOutput,
    clock: SensorClock,
    rate_hz: u64,
    packets: u64,
    surroundings: [f32; 2],
}

impl PacketStream {
    /// Packets of `profile` at `rate_hz`. Equal arguments give equal bytes. The angular rates are
    /// those of the profile: no attitude filter removes a bias.
    ///
    /// # Errors
    /// [`UnsupportedRate`] unless 800 Hz is a multiple of the rate.
    pub fn new(profile: &Profile, packets: PacketMessage, rate_hz: u32, seed: u64) -> Result<Self, UnsupportedRate> {
        let rates = || (1..=MEASUREMENTS_PER_S).filter(|hz| MEASUREMENTS_PER_S.is_multiple_of(*hz)).collect();
        let unsupported = || UnsupportedRate { rate_hz, rates: rates() };
        let setting = packets.output(1, rate_hz).ok_or_else(unsupported)?.to_string();
        let parameters: Vec<&str> = setting.split(',').collect();
        Ok(Self {
            output: PacketOutput::parse(&parameters).map_err(|_| unsupported())?,
            generator: Generator::at_any_rate(profile, rate_hz, seed).ok_or_else(unsupported)?,
            clock: SensorClock::new(seed),
            rate_hz: rate_hz.into(),
            packets: 0,
            surroundings: [0.0; 2],
        })
    }

    /// Appends the next packet.
    pub fn write_next(&mut self, bytes: &mut Vec<u8>) {
        let row = self.generator.next_row();
        let readings_until = |packets: u64| (packets * SURROUNDINGS_HZ).div_ceil(self.rate_hz);
        if readings_until(self.packets + 1) > readings_until(self.packets) {
            self.surroundings = self.generator.surroundings_at(self.packets as f64 / self.rate_hz as f64);
        }
        let time_ns = self.clock.read(FIRST_NS + self.packets * 1_000_000_000 / self.rate_hz);
        self.packets += 1;
        bytes.extend(self.output.packet(&PacketContents {
            measured: &values_of(&row, self.surroundings),
            deltas: &Deltas::default(),
            time_ns,
            sync_out_count: 0,
        }));
    }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::PACKET_MESSAGES;

    use super::*;

    #[test]
    fn packets_come_at_whole_fractions_of_800_hz() {
        let new = |rate_hz| PacketStream::new(&Profile::lab3(), PACKET_MESSAGES[0], rate_hz, 1);
        for rate_hz in [1, 32, 200, 400, 800] {
            assert!(new(rate_hz).is_ok(), "{rate_hz}");
        }
        let error = new(300).unwrap_err().to_string();
        assert!(error.starts_with("the sensor has no output rate of 300 Hz: use one of 1, 2, 4, 5, 8, 10"), "{error}");
    }

    #[test]
    fn the_same_seed_gives_the_same_packets_and_time_continues() {
        let bytes = |seed| {
            let mut stream = PacketStream::new(&Profile::lab3(), PACKET_MESSAGES[1], 800, seed).unwrap();
            let mut bytes = Vec::new();
            (0..1000).for_each(|_| stream.write_next(&mut bytes));
            bytes
        };
        assert_eq!(bytes(3), bytes(3));
        assert_ne!(bytes(3), bytes(4));
        let packets = bytes(3);
        let times: Vec<u64> =
            packets.chunks(60).map(|packet| u64::from_le_bytes(packet[6..14].try_into().unwrap())).collect();
        let steps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (1_200_000..1_300_000).contains(step) && step % 1000 == 0));
        let mean = steps.iter().sum::<u64>() as f64 / steps.len() as f64;
        assert!((mean - 1_250_000.0).abs() < 50.0, "{mean}");
    }
}
