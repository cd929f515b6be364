//! The transmit side of the serial line: a buffer of 2048 bytes, sent at ten bits per byte.

use std::{collections::VecDeque, time::Duration};

const TRANSMIT_BUFFER: usize = 2048;

/// Start bit, eight data bits, stop bit.
const BITS_PER_BYTE: u64 = 10;

/// The transmit FIFO of the usual UART: a receiver sees pieces of about this length.
const PIECE_BYTES: usize = 16;

const NS_PER_S: u64 = 1_000_000_000;

/// A byte that has left the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SentByte {
    /// The time when the last bit of the byte was on the line, since power-up.
    pub at: Duration,
    /// The byte.
    pub byte: u8,
    /// The baud rate of the byte.
    pub baud: u32,
}

/// Bytes sent without a pause between them, at the same rate.
#[derive(Debug, Clone)]
struct Burst {
    start_ns: u64,
    baud: u32,
    bytes: Vec<u8>,
    taken: usize,
}

impl Burst {
    /// The time when the first `count` bytes are on the line.
    fn end_ns(&self, count: usize) -> u64 {
        self.start_ns + count as u64 * BITS_PER_BYTE * NS_PER_S / u64::from(self.baud)
    }

    fn sent(&self, now_ns: u64) -> usize {
        let elapsed_ns = now_ns.saturating_sub(self.start_ns);
        let mut count = (elapsed_ns / BITS_PER_BYTE * u64::from(self.baud) / NS_PER_S) as usize;
        // rounded down above, so at most one byte short
        while count < self.bytes.len() && self.end_ns(count + 1) <= now_ns {
            count += 1;
        }
        count.min(self.bytes.len())
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Uart {
    pub(crate) baud: u32,
    bursts: VecDeque<Burst>,
}

impl Uart {
    pub(crate) fn new(baud: u32) -> Self {
        Self { baud, bursts: VecDeque::new() }
    }

    /// Queues a whole message; `false` if it does not fit.
    pub(crate) fn send(&mut self, now_ns: u64, message: Vec<u8>) -> bool {
        let unsent = |burst: &Burst| burst.bytes.len() - burst.sent(now_ns);
        let waiting: usize = self.bursts.iter().rev().map(unsent).take_while(|count| *count > 0).sum();
        if waiting + message.len() > TRANSMIT_BUFFER {
            return false;
        }
        let start_ns = now_ns.max(self.idle_ns());
        self.bursts.push_back(Burst { start_ns, baud: self.baud, bytes: message, taken: 0 });
        true
    }

    /// The time when all pending bytes are sent; 0 if there are none.
    pub(crate) fn idle_ns(&self) -> u64 {
        self.bursts.back().map_or(0, |burst| burst.end_ns(burst.bytes.len()))
    }

    /// Takes the bytes that are on the line by `now_ns`, in order.
    pub(crate) fn take(&mut self, now_ns: u64, sink: &mut impl FnMut(SentByte)) {
        while let Some(burst) = self.bursts.front_mut() {
            let sent = burst.sent(now_ns);
            for index in burst.taken..sent {
                let at = Duration::from_nanos(burst.end_ns(index + 1));
                sink(SentByte { at, byte: burst.bytes[index], baud: burst.baud });
            }
            burst.taken = sent;
            if sent < burst.bytes.len() {
                return;
            }
            self.bursts.pop_front();
        }
    }

    pub(crate) fn next_piece_ns(&self) -> Option<u64> {
        let burst = self.bursts.front()?;
        Some(burst.end_ns((burst.taken + PIECE_BYTES).min(burst.bytes.len())))
    }
}
