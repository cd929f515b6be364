//! When the temperature is read between the lines.

use std::time::Duration;

/// Bytes that a reading of the temperature (register 54) takes from the line.
const READING_BYTES: f64 = 128.0;

#[derive(Debug)]
pub(super) struct TemperaturePoll {
    every: Duration,
    last: Duration,
    /// Bytes that came since then.
    bytes: u64,
}

impl TemperaturePoll {
    pub(super) fn new(every: Duration) -> Self {
        Self { every, last: Duration::ZERO, bytes: 0 }
    }

    /// Begins anew.
    pub(super) fn begin(&mut self, now: Duration) {
        (self.last, self.bytes) = (now, 0);
    }

    /// Takes the number of bytes that a read brought.
    pub(super) fn read(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
    }

    pub(super) fn due_at(&self) -> Duration {
        self.last + self.every
    }

    /// Whether a reading is due and fits between the lines.
    pub(super) fn is_due(&mut self, now: Duration, baud: Option<u32>) -> bool {
        let passed = now.saturating_sub(self.last);
        if passed < self.every {
            return false;
        }
        let bytes_per_s = self.bytes as f64 / passed.as_secs_f64();
        self.begin(now);
        // ten bits a byte; the reading must be through within a second
        baud.is_none_or(|baud| bytes_per_s + READING_BYTES <= f64::from(baud) / 10.0)
    }
}
