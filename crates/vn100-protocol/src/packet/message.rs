//! The packets that this project requests from a sensor, by name.

use alloc::sync::Arc;

use super::form::PacketForm;
use crate::{
    link_budget::LinkLoad,
    message::layout::Layout,
    register::{BaudRate, BinaryOutput},
};

/// A choice of fields that a [`BinaryOutput`] requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PacketMessage {
    /// Its name, such as `BINARY`.
    pub name: &'static str,
    /// Its content, in words.
    pub description: &'static str,
    groups: u8,
    words: &'static [u16],
}

/// Every such choice. All have the device time, and measurements that are not filtered.
pub const PACKET_MESSAGES: [PacketMessage; 2] = [
    PacketMessage {
        name: "BINARY",
        description: "packets of device time, uncompensated acceleration and angular rate, temperature",
        groups: 0x05,
        words: &[0x0001, 0x001C],
    },
    PacketMessage {
        name: "BINARY+MAG",
        description: "the same with the uncompensated magnetic field and the pressure",
        groups: 0x05,
        words: &[0x0001, 0x003E],
    },
];

/// Measurements of the sensor per second; packets come at this rate or a whole fraction of it.
pub const MEASUREMENTS_PER_S: u32 = 800;

impl PacketMessage {
    /// The choice with this name, in upper or lower case.
    pub fn named(name: &str) -> Option<Self> {
        PACKET_MESSAGES.into_iter().find(|message| message.name.eq_ignore_ascii_case(name))
    }

    /// The setting that sends it `rate_hz` times a second to the ports of `async_mode`; `None` if
    /// the sensor has no such rate.
    pub fn output(&self, async_mode: u16, rate_hz: u32) -> Option<BinaryOutput> {
        let rate_divisor = u16::try_from(MEASUREMENTS_PER_S.checked_div(rate_hz)?).ok()?;
        let is_whole = MEASUREMENTS_PER_S.is_multiple_of(rate_hz);
        is_whole.then(|| BinaryOutput {
            async_mode,
            rate_divisor,
            groups: self.groups,
            field_words: self.words.to_vec(),
        })
    }

    /// The highest rate in hertz that fits `baud_rate` without other output; `None` if not even 1
    /// Hz does.
    pub fn highest_rate_hz(&self, baud_rate: BaudRate) -> Option<u32> {
        let load = |hz: u32| LinkLoad::of_packets(&self.output(1, hz)?);
        (1..=MEASUREMENTS_PER_S).rev().find(|hz| load(*hz).is_some_and(|load| load.fits(baud_rate)))
    }

    /// Whether `output` requests these fields.
    pub fn is_of(&self, output: &BinaryOutput) -> bool {
        (output.groups, &*output.field_words) == (self.groups, self.words)
    }

    /// The channels that are measured.
    pub fn layout(&self) -> Option<Arc<Layout>> {
        PacketForm::new(self.groups, self.words).map(|form| form.layout)
    }

    /// The length of a packet in bytes.
    pub fn packet_length(&self) -> usize {
        crate::framing::packet::length(self.groups, self.words).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_is_measured_with_its_device_time() {
        for message in PACKET_MESSAGES {
            let form = PacketForm::new(message.groups, message.words).unwrap();
            assert_eq!(form.layout.compensated, Some(false));
            assert_eq!(PacketMessage::named(&message.name.to_lowercase()), Some(message));
        }
        assert_eq!(PACKET_MESSAGES.map(|message| message.packet_length()), [44, 60]);
        assert_eq!(PacketMessage::named("VNYMR"), None);
    }

    /// The rates that a VN-100 accepts at each baud rate (VN-100 User Manual: a tenth of it in
    /// bytes per second).
    #[test]
    fn packets_fit_the_baud_rate_at_the_documented_rates() {
        let rates = |message: PacketMessage| {
            [9_600, 115_200, 230_400, 460_800, 921_600]
                .map(|bits_per_s| message.highest_rate_hz(BaudRate::new(bits_per_s).unwrap()))
        };
        assert_eq!(rates(PACKET_MESSAGES[0]), [Some(20), Some(200), Some(400), Some(800), Some(800)]);
        assert_eq!(rates(PACKET_MESSAGES[1]), [Some(16), Some(160), Some(200), Some(400), Some(800)]);
    }

    #[test]
    fn rates_are_whole_parts_of_the_measurements() {
        let message = PACKET_MESSAGES[0];
        assert_eq!(message.output(1, 800).unwrap().to_string(), "1,1,05,0001,001C");
        assert_eq!(message.output(2, 200).unwrap().to_string(), "2,4,05,0001,001C");
        for rate_hz in [0, 3, 300, 801, 1600] {
            assert_eq!(message.output(1, rate_hz), None, "{rate_hz}");
        }
        assert!(
            message.is_of(&message.output(3, 1).unwrap()) && !PACKET_MESSAGES[1].is_of(&message.output(3, 1).unwrap())
        );
    }
}
