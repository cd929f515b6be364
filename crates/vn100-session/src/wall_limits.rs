//! The limits of a live session by the clock. Pure: the time is an argument.

use std::time::Duration;

use tokio::time::Instant;

/// The limits that end a live session by the clock; by default there are none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WallLimits {
    /// The longest time without a sample after the sensor was first connected; `None` for no limit.
    pub give_up: Option<Duration>,
    /// The longest duration of the session from its start; `None` for no limit.
    pub wall: Option<Duration>,
}

#[derive(Debug)]
pub(crate) struct Deadlines {
    pub(crate) limits: WallLimits,
    start: Instant,
    /// The arrival of the latest sample, or else the first connection of the sensor.
    last_sign: Option<Instant>,
}

impl Deadlines {
    pub(crate) const fn new(limits: WallLimits, start: Instant) -> Self {
        Self { limits, start, last_sign: None }
    }

    /// The sensor is connected: from now on its samples are expected.
    pub(crate) fn note_connected(&mut self, now: Instant) {
        self.last_sign.get_or_insert(now);
    }

    pub(crate) fn note_sample(&mut self, now: Instant) {
        self.last_sign = Some(now);
    }

    /// The time when the session ends, with or without samples; `None` for never.
    pub(crate) fn wall_at(&self) -> Option<Instant> {
        self.start.checked_add(self.limits.wall?)
    }

    /// The time when the source is given up unless a sample arrives before; `None` for never.
    pub(crate) fn give_up_at(&self) -> Option<Instant> {
        self.last_sign?.checked_add(self.limits.give_up?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn every_sample_postpones_giving_up_and_nothing_the_wall_time() {
        let start = Instant::now();
        let limits = WallLimits { give_up: Some(5 * SECOND), wall: Some(60 * SECOND) };
        let mut deadlines = Deadlines::new(limits, start);
        assert_eq!((deadlines.give_up_at(), deadlines.wall_at()), (None, Some(start + 60 * SECOND)));
        deadlines.note_connected(start + 2 * SECOND);
        deadlines.note_connected(start + 3 * SECOND);
        assert_eq!(deadlines.give_up_at(), Some(start + 7 * SECOND), "since it was first there");
        deadlines.note_sample(start + 6 * SECOND);
        deadlines.note_connected(start + 9 * SECOND);
        assert_eq!(deadlines.give_up_at(), Some(start + 11 * SECOND), "a connection is no sample");
        assert_eq!(deadlines.wall_at(), Some(start + 60 * SECOND));
    }

    #[test]
    fn without_limits_nothing_ends() {
        let mut deadlines = Deadlines::new(WallLimits::default(), Instant::now());
        deadlines.note_sample(Instant::now());
        assert_eq!((deadlines.give_up_at(), deadlines.wall_at()), (None, None));
    }

    #[test]
    fn a_time_that_no_clock_reaches_is_no_limit() {
        let limits = WallLimits { give_up: Some(Duration::MAX), wall: Some(Duration::MAX) };
        let mut deadlines = Deadlines::new(limits, Instant::now());
        deadlines.note_sample(Instant::now());
        assert_eq!((deadlines.give_up_at(), deadlines.wall_at()), (None, None));
    }
}
