//! When a second by the clock has passed without data. Pure: the time is an argument.

use std::time::Duration;

use tokio::time::Instant;

#[derive(Debug)]
pub(crate) struct Heartbeat {
    samples: u64,
    last_data: Instant,
    next: Instant,
}

impl Heartbeat {
    const PERIOD: Duration = Duration::from_secs(1);

    pub(crate) fn start(now: Instant) -> Self {
        Self { samples: 0, last_data: now, next: now + Self::PERIOD }
    }

    /// The source has given so many samples until now.
    pub(crate) fn note(&mut self, samples: u64, now: Instant) {
        if samples != self.samples {
            *self = Self { samples, ..Self::start(now) };
        }
    }

    /// When the next one is due, unless data comes before.
    pub(crate) const fn next(&self) -> Instant {
        self.next
    }

    /// One is due now: for how long nothing has come.
    pub(crate) fn beat(&mut self, now: Instant) -> Duration {
        // what is late is not made up for
        self.next = now + Self::PERIOD;
        now.duration_since(self.last_data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_due_for_each_second_without_data_and_none_while_it_comes() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut heartbeat = Heartbeat::start(start);
        for second in 1..10 {
            assert_eq!(heartbeat.next(), at(second * 1000));
            assert_eq!(heartbeat.beat(at(second * 1000)), Duration::from_secs(second));
        }
        heartbeat.note(40, at(9500));
        assert_eq!(heartbeat.next(), at(10_500));
        heartbeat.note(40, at(10_000));
        assert_eq!(heartbeat.next(), at(10_500), "the same samples are no data");
        assert_eq!(heartbeat.beat(at(17_000)), Duration::from_millis(7500), "as after a stall");
        assert_eq!(heartbeat.next(), at(18_000));
    }
}
