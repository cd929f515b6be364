//! The output of another device, recognised by its sentences, its packets or its lines of text.

use std::{fmt, mem};

use vn100_protocol::{Check, Sentence};

/// The number of sentences of another device that are named.
const NAMED_SENTENCES: usize = 3;

/// This many lines of text, or packets, are no noise.
const SURE: u32 = 2;

/// Up to this many characters of text before a line end may be noise.
const NOISE_CHARACTERS: usize = 8;

/// The length of a line as shown, in characters.
const SHOWN_CHARACTERS: usize = 40;

/// A longer line of text or packet is noise, and is not examined.
const LONGEST: usize = 1000;

/// The output of another device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum OtherOutput {
    /// Sentences with a correct checksum, by the first few names.
    Sentences(Vec<String>),
    /// Packets of a known maker, with the words for the devices that send such packets.
    Packets(&'static str),
    /// Lines of text; the last of them.
    Text(String),
}

/// Packets with a length and a checksum.
struct PacketFormat {
    /// The words for the devices that send such packets.
    device: &'static str,
    sync: [u8; 2],
    /// Bytes between the sync bytes and the payload.
    header: usize,
    /// The length of the payload, from the bytes after the sync bytes.
    length: fn(&[u8]) -> usize,
    is_good: fn(&[u8]) -> bool,
    checksum: usize,
}

/// The formats are from the protocol manuals of u-blox (UBX), MicroStrain (MIP) and Xsens (Xbus).
static PACKET_FORMATS: [PacketFormat; 3] = [
    PacketFormat {
        device: "a device that sends UBX packets, such as a u-blox GPS",
        sync: [0xb5, 0x62],
        header: 4,
        length: |header| usize::from(u16::from_le_bytes([header[2], header[3]])),
        is_good: |packet| ends_with_fletcher(&packet[2..]),
        checksum: 2,
    },
    PacketFormat {
        device: "a device that sends MIP packets, such as a MicroStrain IMU",
        sync: [0x75, 0x65],
        header: 2,
        length: |header| usize::from(header[1]),
        is_good: ends_with_fletcher,
        checksum: 2,
    },
    PacketFormat {
        device: "a device that sends Xbus messages, such as an Xsens IMU",
        sync: [0xfa, 0xff],
        header: 2,
        length: |header| usize::from(header[1]),
        is_good: |packet| packet[1..].iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)) == 0,
        checksum: 1,
    },
];

/// Whether the last two bytes are the Fletcher sums of the bytes before them.
fn ends_with_fletcher(bytes: &[u8]) -> bool {
    let (summed, sums) = bytes.split_at(bytes.len() - 2);
    let add = |(a, b): (u8, u8), byte: &u8| (a.wrapping_add(*byte), b.wrapping_add(a.wrapping_add(*byte)));
    let (a, b) = summed.iter().fold((0, 0), add);
    sums == [a, b]
}

impl PacketFormat {
    /// The length of the packet that begins here: 0 if none does, `None` until all of it is
    /// received.
    fn packet_at(&self, bytes: &[u8]) -> Option<usize> {
        let sync = bytes.len().min(self.sync.len());
        if bytes[..sync] != self.sync[..sync] {
            return Some(0);
        }
        let header = bytes.get(2..2 + self.header)?;
        let length = 2 + self.header + (self.length)(header) + self.checksum;
        if length > LONGEST {
            return Some(0);
        }
        let packet = bytes.get(..length)?;
        Some(if (self.is_good)(packet) { length } else { 0 })
    }
}

impl fmt::Display for OtherOutput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sentences(names) if names.iter().all(|name| is_nmea(name)) => {
                write!(f, "a device that sends NMEA sentences, such as a GPS: ${}", names.join(", $"))
            }
            Self::Sentences(names) => write!(f, "another device that sends sentences: ${}", names.join(", $")),
            Self::Packets(device) => f.write_str(device),
            Self::Text(line) => write!(f, "another device that sends text: \"{line}\""),
        }
    }
}

/// Names of NMEA 0183 have two letters for the talker and three for the message, or a `P` and the
/// letters of a maker.
fn is_nmea(name: &str) -> bool {
    name.starts_with('P') || name.len() == 5 && !name.contains(|c: char| c.is_ascii_digit())
}

/// Collects evidence of another device, from bytes in any pieces.
#[derive(Debug, Default)]
pub(super) struct OtherDevice {
    sentences: Vec<String>,
    packets: [u32; PACKET_FORMATS.len()],
    /// The beginning of a packet that is not complete.
    incomplete: Vec<u8>,
    lines: TextLines,
}

impl OtherDevice {
    pub(super) fn push_sentence(&mut self, sentence: &Sentence<'_>) {
        if let Some(name) = name_of_other(sentence).filter(|name| !self.sentences.contains(name)) {
            self.sentences.push(name);
            self.sentences.truncate(NAMED_SENTENCES);
        }
    }

    pub(super) fn push(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.lines.push(*byte));
        self.incomplete.extend_from_slice(bytes);
        let mut at = 0;
        while at < self.incomplete.len() {
            let rest = &self.incomplete[at..];
            let packets = PACKET_FORMATS.each_ref().map(|format| format.packet_at(rest));
            if let Some(format) = packets.iter().position(|length| length.is_some_and(|length| length > 0)) {
                self.packets[format] += 1;
                at += packets[format].unwrap_or(1);
            } else if packets.contains(&None) {
                break;
            } else {
                at += 1;
            }
        }
        self.incomplete.drain(..at);
    }

    /// Whether there is a sentence or a packet of another device.
    pub(super) fn has_frames(&self) -> bool {
        !self.sentences.is_empty() || self.packets.iter().any(|packets| *packets > 0)
    }

    /// Whether a line of text arrived that is not one of these copies of a question; only further
    /// lines show another device.
    pub(super) fn has_text(&self, echoes: u64) -> bool {
        self.lines.ended > echoes
    }

    /// The output of another device, as far as the bytes show one: `None` for a sensor, for noise,
    /// and for bytes at a wrong baud rate.
    pub(super) fn output(&self) -> Option<OtherOutput> {
        let packets = || self.packets.iter().position(|packets| *packets >= SURE);
        match () {
            () if !self.sentences.is_empty() => Some(OtherOutput::Sentences(self.sentences.clone())),
            () if let Some(format) = packets() => Some(OtherOutput::Packets(PACKET_FORMATS[format].device)),
            () => self.lines.shown().map(|line| OtherOutput::Text(line.into())),
        }
    }
}

/// The name of a sentence of another device: one with a checksum and a name of capital letters and
/// digits, which does not result from damaged bytes.
fn name_of_other(sentence: &Sentence<'_>) -> Option<String> {
    let name = sentence.header();
    let is_name = (3..=8).contains(&name.len()) && name.iter().all(|b| matches!(b, b'A'..=b'Z' | b'0'..=b'9'));
    (is_name && sentence.check != Check::None).then(|| String::from_utf8_lossy(name).into_owned())
}

/// Lines of text only, which a wrong baud rate and noise do not produce.
#[derive(Debug, Default)]
struct TextLines {
    count: u32,
    last: String,
    /// The incomplete line; `None` if its beginning is missing.
    line: Option<String>,
    /// Number of characters of the incomplete line since the last noise.
    characters: usize,
    /// Lines of text that have ended since the last noise.
    ended: u64,
    /// Whether a sentence of a sensor, even a damaged one, was among the lines.
    has_sensor: bool,
}

impl TextLines {
    fn push(&mut self, byte: u8) {
        self.characters += 1;
        match (byte, &mut self.line) {
            (b'\n', _) => self.end_line(),
            (b' '..=b'~', Some(line)) if line.len() < LONGEST => line.push(char::from(byte)),
            (b'\r' | b'\t' | b' '..=b'~', _) => {}
            _ => *self = Self { has_sensor: self.has_sensor, ..Self::default() },
        }
    }

    fn end_line(&mut self) {
        self.ended += u64::from(mem::take(&mut self.characters) > NOISE_CHARACTERS);
        let Some(line) = self.line.replace(String::new()) else { return };
        // the answer to a question may begin with an echo of the question
        let is_question = line.contains("$VNRRG,01*72");
        self.has_sensor |= line.contains("VN") && !is_question;
        // a sentence without its beginning has a checksum, or few letters
        let letters = line.bytes().filter(u8::is_ascii_alphabetic).count();
        if letters >= 3 && !line.contains('*') && !line.contains("VN") {
            self.count += 1;
            self.last = line.chars().take(SHOWN_CHARACTERS).collect();
        }
    }

    fn shown(&self) -> Option<&str> {
        (self.count >= SURE && !self.has_sensor).then_some(&self.last)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn output(pieces: &[&[u8]]) -> Option<String> {
        let mut device = OtherDevice::default();
        pieces.iter().for_each(|piece| device.push(piece));
        device.output().map(|output| output.to_string())
    }

    /// Packets from the examples of the protocol manuals.
    const UBX_POLL: &[u8] = &[0xb5, 0x62, 0x0a, 0x04, 0x00, 0x00, 0x0e, 0x34];
    const MIP_PING: &[u8] = &[0x75, 0x65, 0x01, 0x02, 0x02, 0x01, 0xe0, 0xc6];
    const XBUS_GO_TO_CONFIG: &[u8] = &[0xfa, 0xff, 0x30, 0x00, 0xd1];

    #[test]
    fn packets_of_other_makers_are_recognized_by_two_of_them() {
        for (packet, name) in [(UBX_POLL, "u-blox"), (MIP_PING, "MicroStrain"), (XBUS_GO_TO_CONFIG, "Xsens")] {
            let twice = [b"noise", packet, &[0x00], packet].concat();
            assert!(output(&[&twice]).unwrap().contains(name));
            let bytewise: Vec<&[u8]> = twice.chunks(1).collect();
            assert_eq!(output(&bytewise), output(&[&twice]));
            assert_eq!(output(&[packet]), None, "one may be chance");
            let mut damaged = packet.to_vec();
            *damaged.last_mut().unwrap() ^= 1;
            assert_eq!(output(&[&damaged, packet]), None);
        }
    }

    #[test]
    fn text_is_recognized_by_two_lines_and_is_none_of_a_sensor() {
        assert_eq!(
            output(&[b"3 9\r\nGYRO: 1 3 7\r\n", b"GYRO: 2 6 14\r\nGY"]).as_deref(),
            Some("another device that sends text: \"GYRO: 2 6 14\"")
        );
        assert_eq!(output(&[b"GYRO: 1 3 7\n"]), None, "one may be chance");
        assert_eq!(output(&[b"\nGYRO: 1 3 7\n\x80GYRO: 2 6 14\nGYRO: 3 9 21\n"]), None, "noise between");
        let sensor = b"\n$VNYMR,-085.469,+0x4.972*63\r\nVNYMR,-085.469,+074.972*63\r\n$XNYMR,-085.469*63\r\n";
        assert_eq!(output(&[sensor]), None);
        for noise in ["", "\u{80}\n"] {
            let beside = format!("\n$VNYMR,-085.469,+0\r\n{noise}GYRO: 1 3 7\r\nGYRO: 2 6 14\r\n");
            assert_eq!(output(&[beside.as_bytes()]), None, "a sensor before it, and {noise:?}");
        }
        let tails = b"\n+00.004,-00.003,+09.8*\r\n,-000.355,-000.296*61\r\nMR,-085.469,+074.972\r\n";
        assert_eq!(output(&[tails]), None);
        let shell = b"\n$VNRRG,01*72\r\nunknown command\r\nlogin: \r\n";
        assert!(output(&[shell]).unwrap().contains("login"));
        assert_eq!(output(&[&b"1234567890".repeat(200)]), None);
    }

    proptest! {
        #[test]
        fn any_bytes_in_any_pieces_show_the_same(bytes in prop::collection::vec(any::<u8>(), 0..300), at in 0..300_usize) {
            let at = at.min(bytes.len());
            prop_assert_eq!(output(&[&bytes[..at], &bytes[at..]]), output(&[&bytes]));
        }
    }
}
