//! The time that bytes are stamped with.

use std::time::{Duration, SystemTime};

#[cfg(target_os = "linux")]
use rustix::time::{ClockId, clock_gettime};

/// Unix time that runs evenly: what the wall clock said at the start, plus what has passed since.
///
/// Steps of the wall clock do not bend it. On Linux the time in suspend counts; elsewhere that is
/// up to the system.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    wall_at_start: Duration,
    start: Moment,
}

impl Clock {
    /// A clock that agrees with the wall clock now.
    #[must_use]
    pub fn start() -> Self {
        // a machine without a set clock may believe in a time before 1970; its stamps then count from there
        let wall_at_start = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self { wall_at_start, start: Moment::now() }
    }

    /// Nanoseconds since 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        nanoseconds(self.wall_at_start.saturating_add(self.start.elapsed()))
    }
}

/// The year 2262 is the last.
fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

/// A point on the clock that no one sets. The standard library's stands still during suspend.
#[cfg(target_os = "linux")]
#[derive(Debug, Clone, Copy)]
struct Moment(Duration);

#[cfg(target_os = "linux")]
impl Moment {
    fn now() -> Self {
        Self(clock_gettime(ClockId::Boottime).try_into().unwrap_or_default())
    }

    fn elapsed(self) -> Duration {
        Self::now().0.saturating_sub(self.0)
    }
}

#[cfg(not(target_os = "linux"))]
#[derive(Debug, Clone, Copy)]
struct Moment(std::time::Instant);

#[cfg(not(target_os = "linux"))]
impl Moment {
    fn now() -> Self {
        Self(std::time::Instant::now())
    }

    fn elapsed(self) -> Duration {
        self.0.elapsed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_starts_at_the_wall_clock_and_never_goes_back() {
        let before = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
        let clock = Clock::start();
        let mut last = clock.now_ns();
        assert!(last >= nanoseconds(before));
        for _ in 0..1000 {
            let now = clock.now_ns();
            assert!(now >= last);
            last = now;
        }
    }

    #[test]
    fn only_what_passes_after_the_start_moves_it() {
        // as after a step of the wall clock: the start says another year, the steady clock runs on
        let stepped = Clock { wall_at_start: Duration::from_secs(7), start: Moment::now() };
        let now = stepped.now_ns();
        assert!((7_000_000_000..7_000_000_000 + 3_600_000_000_000).contains(&now), "{now}");
        assert_eq!(nanoseconds(Duration::MAX), i64::MAX);
    }
}
