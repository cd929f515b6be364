//! The schedule for reading the temperature between the frames of the output.

use std::time::Duration;

/// The length of a reply with the temperature on the line.
const REPLY_BYTES: f64 = 128.0;

/// A poll at an interval, skipped if the line has no room for the reply.
pub(super) struct TemperaturePoll {
    every: Duration,
    last: Duration,
    /// Bytes received since the interval began.
    bytes: u64,
}

impl TemperaturePoll {
    pub(super) const fn new(every: Duration) -> Self {
        Self { every, last: Duration::ZERO, bytes: 0 }
    }

    pub(super) fn restart(&mut self, now: Duration) {
        (self.last, self.bytes) = (now, 0);
    }

    pub(super) fn handle_read(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
    }

    pub(super) fn next_at(&self) -> Duration {
        self.last + self.every
    }

    /// Whether a read is due and its reply fits between the frames. A due read ends the interval,
    /// even if the reply does not fit.
    pub(super) fn is_due(&mut self, now: Duration, baud: Option<u32>) -> bool {
        let passed = now.saturating_sub(self.last);
        if passed < self.every {
            return false;
        }
        let bytes_per_s = self.bytes as f64 / passed.as_secs_f64();
        self.restart(now);
        // ten bits per byte; the reply must have been sent within a second
        baud.is_none_or(|baud| bytes_per_s + REPLY_BYTES <= f64::from(baud) / 10.0)
    }
}
