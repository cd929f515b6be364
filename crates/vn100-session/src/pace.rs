//! The times at which samples of a paced replay are due. Pure: the time is an argument.

use std::time::Duration;

use tokio::time::Instant;
use vn100_analysis::{Playback, Speed};

use crate::command::Command;

#[derive(Debug)]
pub(crate) struct Pace {
    pub(crate) playback: Playback,
    rate_hz: f64,
    /// The time when the clock of the pace was set, and the sample that was due then.
    since: (Instant, u64),
}

/// The condition for the next sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Due {
    Now,
    At(Instant),
    /// The next sample is not due before a command.
    Never,
}

impl Pace {
    pub(crate) fn new(speed: Speed, rate_hz: f64, now: Instant) -> Self {
        Self { playback: Playback::begin(speed), rate_hz, since: (now, 0) }
    }

    pub(crate) fn due(&self) -> Due {
        match self.playback.speed {
            _ if self.playback.paused => Due::Never,
            Speed::Max => Due::Now,
            Speed::Times(times) => {
                let data_s = (self.playback.samples - self.since.1) as f64 / self.rate_hz;
                let wait = Duration::try_from_secs_f64(data_s / times).unwrap_or(Duration::MAX);
                self.since.0.checked_add(wait).map_or(Due::Never, Due::At)
            }
        }
    }

    /// Executes a command for the playback. At the end only the speed can be changed.
    pub(crate) fn handle(&mut self, command: Command, now: Instant) {
        let playback = &mut self.playback;
        match command {
            Command::TogglePause if !playback.at_end => playback.paused = !playback.paused,
            Command::Faster => playback.speed = playback.speed.next(true),
            Command::Slower => playback.speed = playback.speed.next(false),
            _ => return,
        }
        self.since = (now, playback.samples);
    }

    pub(crate) fn set_rate(&mut self, rate_hz: f64, now: Instant) {
        if rate_hz != self.rate_hz {
            self.rate_hz = rate_hz;
            self.since = (now, self.playback.samples);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 40.0;

    struct VirtualReplay {
        pace: Pace,
        now: Instant,
    }

    impl VirtualReplay {
        fn new(speed: Speed) -> Self {
            let now = Instant::now();
            Self { pace: Pace::new(speed, RATE_HZ, now), now }
        }

        /// Lets this many seconds pass; returns the number of samples, at most a thousand in total.
        fn run(&mut self, seconds: f64) -> u64 {
            let until = self.now + Duration::from_secs_f64(seconds);
            let before = self.pace.playback.samples;
            while self.pace.playback.samples < 1000 {
                match self.pace.due() {
                    Due::Now => {}
                    Due::At(time) if time <= until => self.now = self.now.max(time),
                    Due::At(_) | Due::Never => break,
                }
                self.pace.playback.samples += 1;
            }
            self.now = until;
            self.pace.playback.samples - before
        }

        fn command(&mut self, command: Command) {
            self.pace.handle(command, self.now);
        }
    }

    #[test]
    fn samples_come_at_the_requested_pace() {
        assert_eq!(VirtualReplay::new(Speed::Times(1.0)).run(2.01), 81);
        assert_eq!(VirtualReplay::new(Speed::Times(10.0)).run(2.001), 801);
        assert_eq!(VirtualReplay::new(Speed::Max).run(0.001), 1000);
        let mut replay = VirtualReplay::new(Speed::Times(1.0));
        replay.run(1.01);
        replay.pace.set_rate(80.0, replay.now);
        assert_eq!(replay.run(1.01), 81);
        replay.pace.set_rate(80.0, replay.now + Duration::from_secs(9));
        assert_eq!(replay.run(1.0), 80, "the same rate changes nothing");
    }

    #[test]
    fn time_spent_paused_is_not_made_up_for() {
        let mut replay = VirtualReplay::new(Speed::Times(1.0));
        replay.command(Command::TogglePause);
        assert_eq!(replay.run(60.0), 0);
        replay.command(Command::TogglePause);
        assert_eq!(replay.run(1.001), 41);
        replay.command(Command::Faster);
        assert_eq!((replay.run(1.001), replay.pace.playback.speed), (81, Speed::Times(2.0)));
        replay.command(Command::TogglePause);
        assert_eq!((replay.run(5.0), replay.pace.playback.paused), (0, true));
    }

    #[test]
    fn speeds_are_read_and_stepped_through() {
        for (text, speed) in [("1x", Speed::Times(1.0)), ("0.5x", Speed::Times(0.5)), ("max", Speed::Max)] {
            assert_eq!(text.parse(), Ok(speed));
        }
        for wrong in ["", "x", "0x", "-1x", "fast", "10", "nanx", "1e9x"] {
            assert!(wrong.parse::<Speed>().is_err(), "{wrong}");
        }
        assert_eq!(Speed::Times(1000.0).next(true), Speed::Max);
        assert_eq!(Speed::Max.next(true), Speed::Max);
        assert_eq!(Speed::Max.next(false), Speed::Times(1000.0));
        assert_eq!(Speed::Times(3.0).next(false), Speed::Times(2.0));
        assert_eq!(Speed::Times(0.05).next(false), Speed::Times(0.1));
        assert_eq!(Speed::Times(1.0).next(true), Speed::Times(2.0));
    }
}
