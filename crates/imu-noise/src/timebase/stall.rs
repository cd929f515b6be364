//! Stalls: times without an arrival, after which all delayed samples arrive at once.

use std::time::Duration;

/// The largest delay of the last sample of a measurement on a busy computer.
pub const LATEST_ARRIVAL: Duration = Duration::from_millis(500);

/// Finds stalls in arrival times. A stall is longer than the longest interval before it by more
/// than [`LATEST_ARRIVAL`]; the first interval is none.
#[derive(Debug, Clone, Default)]
pub struct StallDetector {
    last: Option<Duration>,
    /// The longest interval, except stalls.
    longest: Duration,
    /// The start and the end of the latest stall; dropped if a later time is before its end.
    stall: Option<(Duration, Duration)>,
}

impl StallDetector {
    /// Takes the next arrival time, since any origin.
    pub fn push(&mut self, at: Duration) {
        // a single time that is far too late is no stall
        self.stall = self.stall.filter(|(_, to)| *to <= at);
        let Some(last) = self.last.replace(at) else { return };
        let interval = at.saturating_sub(last);
        if !self.longest.is_zero() && interval > LATEST_ARRIVAL + self.longest {
            self.stall = Some((last, at));
        } else {
            self.longest = self.longest.max(interval);
        }
    }

    /// The start of a stall that ended less than [`LATEST_ARRIVAL`] ago, so that delayed samples
    /// may still arrive; `None` if there is none, as before the third arrival.
    pub fn recent(&self) -> Option<Duration> {
        let (from, to) = self.stall?;
        self.last.filter(|last| *last < to + LATEST_ARRIVAL).map(|_| from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_stall_is_recent_for_half_a_second_unless_time_decreases() {
        let mut stalls = StallDetector::default();
        let mut recent = |at_ms| {
            stalls.push(ms(at_ms));
            stalls.recent()
        };
        for at_ms in [0, 1000, 2000, 3500] {
            assert_eq!(recent(at_ms), None, "{at_ms} ms");
        }
        assert_eq!(
            [recent(5501), recent(5501), recent(6000), recent(6001)],
            [Some(ms(3500)), Some(ms(3500)), Some(ms(3500)), None]
        );
        assert_eq!([recent(90_000), recent(7000)], [Some(ms(6001)), None]);
    }
}
