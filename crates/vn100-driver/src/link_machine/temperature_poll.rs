//! When the temperature is read between the frames of the output.

use std::time::Duration;

/// Bytes that the reply to a read of register 54 takes from the line.
const REPLY_BYTES: f64 = 128.0;

#[derive(Debug)]
pub(super) struct TemperaturePoll {
    every: Duration,
    last: Duration,
    /// Bytes that were received since then.
    bytes: u64,
}

impl TemperaturePoll {
    pub(super) fn new(every: Duration) -> Self {
        Self { every, last: Duration::ZERO, bytes: 0 }
    }

    /// Starts a period.
    pub(super) fn restart(&mut self, now: Duration) {
        (self.last, self.bytes) = (now, 0);
    }

    /// Counts received bytes.
    pub(super) fn handle_read(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
    }

    pub(super) fn due_at(&self) -> Duration {
        self.last + self.every
    }

    /// Whether a read is due and its reply fits between the frames; a period ends when it is due.
    pub(super) fn is_due(&mut self, now: Duration, baud: Option<u32>) -> bool {
        let passed = now.saturating_sub(self.last);
        if passed < self.every {
            return false;
        }
        let bytes_per_s = self.bytes as f64 / passed.as_secs_f64();
        self.restart(now);
        // ten bits a byte; the reply must be through within a second
        baud.is_none_or(|baud| bytes_per_s + REPLY_BYTES <= f64::from(baud) / 10.0)
    }
}
