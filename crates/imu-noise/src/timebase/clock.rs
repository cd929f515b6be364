//! The clock of the host: stamps out of order, and clocks that are set back.

use std::time::Duration;

use super::{Refusal, State, Timebase};

/// Stamps may go back by so much: not every clock is smooth.
const BACKWARDS_TOLERANCE: Duration = Duration::from_millis(10);

/// When so many lines in a row are stamped before an earlier one, the clock was set back.
const SET_BACK_LINES: usize = 3;

/// Stamps that go back more often than that, and more than once in so many lines, are no time base.
const MAX_BACKWARDS: u64 = 8;
const MIN_LINES_PER_BACKWARDS: u64 = 256;

impl Timebase {
    /// Takes the stamp of the next line, if it is in order.
    pub(super) fn stamp(&mut self, at: Duration) {
        if let State::Refused(_) = self.state {
            return self.place_lines(1);
        }
        if self.last.saturating_sub(at) > BACKWARDS_TOLERANCE {
            return self.fall_behind(at);
        }
        // Lines behind came no later than this one.
        while self.behind.pop().is_some() {
            self.take(at);
        }
        self.take(at);
    }

    /// A stamp lies before the one before it: it is wrong, or the clock was set back.
    #[cold]
    fn fall_behind(&mut self, at: Duration) {
        if self.behind.is_empty() {
            self.backwards += 1;
            if self.backwards > MAX_BACKWARDS && self.backwards * MIN_LINES_PER_BACKWARDS > self.lines {
                self.clear_suspicion();
                self.refuse(Refusal::Backwards { times: self.backwards, lines: self.lines });
                return self.place_lines(1);
            }
        }
        self.behind.push(at);
        if self.behind.len() >= SET_BACK_LINES {
            self.set_clock_back();
        }
    }

    /// The lines behind are by a new clock, by which the first of them came when it was due.
    fn set_clock_back(&mut self) {
        let mut behind = std::mem::take(&mut self.behind).into_iter();
        let Some(first) = behind.next() else { return };
        let mut due_s = 0.0;
        match &mut self.state {
            State::Starting(start) => start.restart(),
            State::Placing(placer) => {
                let decisions;
                (decisions, due_s) = placer.resume();
                decisions.into_iter().for_each(|placed| self.place(placed));
            }
            State::Refused(_) => {}
        }
        self.begin_clock(first, due_s);
        behind.for_each(|at| self.stamp(at));
    }

    /// Takes the next line, by a clock that showed `at` at the time `at_s`.
    pub(super) fn begin_clock(&mut self, at: Duration, at_s: f64) {
        self.origin = (at, at_s);
        self.last = at;
        self.intervals.hold(None);
        self.place_or_hold(at_s);
    }

    /// Takes the next line by its stamp.
    fn take(&mut self, at: Duration) {
        let interval = at.saturating_sub(self.last);
        self.intervals.hold(Some(interval.as_secs() * 1_000_000 + u64::from(interval.subsec_micros())));
        self.last += interval;
        let (origin, origin_s) = self.origin;
        self.place_or_hold(origin_s + self.last.saturating_sub(origin).as_secs_f64());
    }
}
