//! The buffer of a USB serial adapter: bytes reach the host in packets, or when a timer runs out.
//!
//! An FTDI chip sends a packet of 62 bytes when it is full. Otherwise it sends its pending bytes
//! when the latency timer, 16 ms unless the host changes it, has expired since the last packet
//! (FTDI application note AN232B-04).

use std::time::Duration;

/// Without its two bytes of status.
const PACKET_BYTES: usize = 62;

#[derive(Debug, Clone)]
pub(crate) struct UsbBuffer {
    latency: Duration,
    waiting: Vec<u8>,
    last_packet: Duration,
}

impl UsbBuffer {
    /// An adapter whose timer starts at time zero. A latency of zero counts as one millisecond, the
    /// shortest possible setting.
    pub(crate) fn new(latency: Duration) -> Self {
        Self { latency: latency.max(Duration::from_millis(1)), waiting: Vec::new(), last_packet: Duration::ZERO }
    }

    /// Takes a byte from the line, and appends the bytes that reach the host because of it to
    /// `host`. Bytes come in order of time.
    pub(crate) fn push(&mut self, at: Duration, byte: u8, host: &mut Vec<u8>) {
        self.poll(at, host);
        self.waiting.push(byte);
        if self.waiting.len() == PACKET_BYTES {
            host.append(&mut self.waiting);
            self.last_packet = at;
        }
    }

    /// Appends the bytes that reach the host by `now`.
    pub(crate) fn poll(&mut self, now: Duration, host: &mut Vec<u8>) {
        let periods = now.saturating_sub(self.last_packet).as_nanos() / self.latency.as_nanos();
        if periods > 0 {
            // an empty packet restarts the timer as well
            host.append(&mut self.waiting);
            let periods = u32::try_from(periods).unwrap_or(u32::MAX);
            self.last_packet = self.last_packet.saturating_add(self.latency.saturating_mul(periods));
        }
    }

    /// The next time when the timer sends bytes; `None` if none are pending.
    pub(crate) fn next_wakeup(&self) -> Option<Duration> {
        (!self.waiting.is_empty()).then(|| self.last_packet + self.latency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The factory default of the latency timer.
    const DEFAULT_LATENCY: Duration = Duration::from_millis(16);

    const BYTE: Duration = Duration::from_nanos(86_806);

    /// A line of 122 bytes at 115200 baud whose first byte begins at `start`: the times at which
    /// bytes reach the host, and their number.
    fn deliver(start: Duration, latency: Duration) -> Vec<(Duration, usize)> {
        let mut usb = UsbBuffer::new(latency);
        let mut deliveries = Vec::new();
        let mut host = Vec::new();
        for index in 1..=122 {
            usb.push(start + BYTE * index, b'x', &mut host);
            if !host.is_empty() {
                deliveries.push((start + BYTE * index, host.len()));
                host.clear();
            }
        }
        while let Some(wakeup) = usb.next_wakeup() {
            usb.poll(wakeup, &mut host);
            deliveries.push((wakeup, host.len()));
            host.clear();
        }
        deliveries
    }

    #[test]
    fn the_tail_of_a_line_waits_for_the_timer() {
        // the timer has just expired: the first packet is full after 5.38 ms, the rest comes 16 ms after it
        let start = DEFAULT_LATENCY * 100;
        let full = start + BYTE * 62;
        assert_eq!(deliver(start, DEFAULT_LATENCY), [(full, 62), (full + DEFAULT_LATENCY, 60)]);
    }

    #[test]
    fn a_short_timer_follows_the_line() {
        let latency = Duration::from_millis(1);
        let deliveries = deliver(latency * 1600, latency);
        assert_eq!(deliveries.iter().map(|(_, bytes)| bytes).sum::<usize>(), 122);
        assert_eq!(deliveries.len(), 11);
        assert!(deliveries.iter().all(|(_, bytes)| *bytes <= 12));
    }

    #[test]
    fn nothing_waits_in_an_empty_buffer() {
        let mut usb = UsbBuffer::new(Duration::ZERO);
        let mut host = Vec::new();
        usb.poll(Duration::from_secs(3600), &mut host);
        assert_eq!((usb.next_wakeup(), host.len()), (None, 0));
    }
}
