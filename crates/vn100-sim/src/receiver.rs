//! The receiving end of a serial line: samples the line at its own rate, and reads garbled bytes if
//! the sender's rate differs.

use std::{collections::VecDeque, time::Duration};

use crate::device::{SentByte, ns};

/// Start bit, eight data bits, stop bit.
const BITS: u64 = 10;

/// Longer than a byte at the slowest rate: bytes that began earlier are known completely.
const KNOWN_AFTER: Duration = Duration::from_millis(2);

/// A receiver for eight data bits, no parity, one stop bit, at any rate from 9600 baud up.
#[derive(Debug, Clone)]
pub(crate) struct Receiver {
    pub(crate) baud: u32,
    /// Bytes that still affect the line.
    line: VecDeque<SentByte>,
    /// The time from which it searches a start bit.
    free_ns: u64,
}

impl Receiver {
    pub(crate) fn new(baud: u32) -> Self {
        Self { baud, line: VecDeque::new(), free_ns: 0 }
    }

    /// A byte is on the line. Bytes come in order.
    pub(crate) fn push(&mut self, sent: SentByte) {
        self.line.push_back(sent);
    }

    /// Passes on the bytes that were read by `now`, each with its time.
    pub(crate) fn poll(&mut self, now: Duration, mut sink: impl FnMut(Duration, u8)) {
        let Some(last) = self.line.back() else { return };
        let known_ns = ns(last.at.max(now.saturating_sub(KNOWN_AFTER)));
        while let Some(start_ns) = self.next_low_ns() {
            if let Some(sent) = self.line.front().filter(|sent| sent.baud == self.baud && timing(sent).0 == start_ns) {
                // for a byte at its own rate, every bit is sampled in its middle
                let end_ns = start_ns + (2 * BITS - 1) * 500_000_000 / u64::from(self.baud);
                if end_ns > known_ns {
                    return;
                }
                sink(Duration::from_nanos(start_ns + 2 * BITS * 500_000_000 / u64::from(self.baud)), sent.byte);
                self.free_ns = end_ns;
                self.line.pop_front();
                continue;
            }
            let half_bits = |count: u64| start_ns + count * 500_000_000 / u64::from(self.baud);
            // the middle of the stop bit
            let end_ns = half_bits(2 * BITS - 1);
            if end_ns > known_ns {
                return;
            }
            let byte = (0..8).fold(0, |byte, bit| byte | u8::from(self.level(half_bits(2 * bit + 3))) << bit);
            sink(Duration::from_nanos(half_bits(2 * BITS)), byte);
            self.free_ns = end_ns;
            while self.line.front().is_some_and(|sent| ns(sent.at) <= end_ns) {
                self.line.pop_front();
            }
        }
        self.line.retain(|sent| ns(sent.at) > known_ns);
    }

    /// The next time, from the end of the last byte on, at which the line is low.
    fn next_low_ns(&self) -> Option<u64> {
        self.line.iter().find_map(|sent| {
            let (start_ns, bit_ns) = timing(sent);
            let first = self.free_ns.saturating_sub(start_ns) / bit_ns;
            (first..BITS).find(|bit| !is_high(sent.byte, *bit)).map(|bit| self.free_ns.max(start_ns + bit * bit_ns))
        })
    }

    /// Whether the line is high, as it is when idle.
    fn level(&self, time_ns: u64) -> bool {
        let begun = |sent: &&SentByte| timing(sent).0 <= time_ns;
        self.line.iter().take_while(begun).all(|sent| {
            let (start_ns, bit_ns) = timing(sent);
            is_high(sent.byte, (time_ns - start_ns) / bit_ns)
        })
    }
}

/// The start of the start bit of a byte, and the duration of each bit.
fn timing(sent: &SentByte) -> (u64, u64) {
    let bit_ns = (1_000_000_000 / u64::from(sent.baud)).max(1);
    (ns(sent.at).saturating_sub(BITS * bit_ns), bit_ns)
}

fn is_high(byte: u8, bit: u64) -> bool {
    match bit {
        0 => false,
        1..=8 => byte >> (bit - 1) & 1 == 1,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Bytes sent without a pause at one rate, as read by a receiver at another rate.
    fn read(bytes: &[u8], sent_baud: u32, read_baud: u32) -> Vec<u8> {
        let mut receiver = Receiver::new(read_baud);
        let mut read = Vec::new();
        let mut at = Duration::from_secs(1);
        for byte in bytes {
            at += Duration::from_nanos(BITS * 1_000_000_000 / u64::from(sent_baud));
            receiver.push(SentByte { at, byte: *byte, baud: sent_baud });
            receiver.poll(at, |_, byte| read.push(byte));
        }
        receiver.poll(at + Duration::from_secs(1), |_, byte| read.push(byte));
        read
    }

    #[test]
    fn a_slow_sender_is_read_as_stretched_bits() {
        // U is 0 1 0 1 0 1 0 1 0 1 on the line, here each twice as long: start bit 0, then 0 1 1 0 0 1 1 0, lowest bit first
        let read = read(b"U", 9600, 19_200);
        assert_eq!((read[0], read.len()), (0b0110_0110, 2));
    }

    #[test]
    fn a_fast_sender_is_read_as_fewer_bytes_and_no_line_survives() {
        let line = b"$VNRRG,01,VN-100S-CR*35\r\n".repeat(20);
        for baud in [9600, 57_600, 230_400, 921_600] {
            let garbled = read(&line, 115_200, baud);
            assert!(!garbled.is_empty());
            assert!(!garbled.windows(6).any(|bytes| bytes == b"$VNRRG"), "{baud}");
            assert_eq!(garbled.len() < line.len(), baud < 115_200, "{baud}");
        }
    }

    proptest! {
        #[test]
        fn equal_rates_read_the_sent_bytes(bytes: Vec<u8>, baud in prop::sample::select(vec![9600, 57_600, 115_200, 128_000, 921_600])) {
            prop_assert_eq!(read(&bytes, baud, baud), bytes);
        }

        #[test]
        fn any_rates_read_something_in_the_end(bytes: Vec<u8>, sent in 9600_u32..=4_000_000, own in 9600_u32..=4_000_000) {
            let most = bytes.len() as u64 * u64::from(own) / u64::from(sent) + 2 + bytes.len() as u64;
            prop_assert!(read(&bytes, sent, own).len() as u64 <= most);
        }
    }
}
