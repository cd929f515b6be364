//! Time base of a stream that has neither time nor counter: its rate and its lost lines, from
//! arrival stamps alone.
//!
//! Lines arrive late, never early: an arrival is the time the line was sent plus a delay that is
//! not negative. So the lower edge of the arrivals over the line number is the sensor's clock, and
//! a lost line lifts that edge by a period for good, while bunching and stalls lift single lines
//! and come back to it.
//!
//! ```text
//! lag behind
//! the due time            stall                        2 lost
//!   3 |                   o                             o
//!   2 |                    o                           o o oo o   <- stays: Gap { missing: 2 }
//!   1 |      o     o        o        o         o
//!   0 | oo oo oo oo oo oo o  oo oo ooo ooo oo oo                  <- lower edge
//!     +----------------------------------------------------- line
//! ```
//!
//! - *Nominal rate*: told by the intervals when they are whole numbers of one period, at least half
//!   of them a single one: losses change nothing. And by the stretches, of 32 lines prolonged to
//!   the last line of a read, when their ends lie on a straight line within 1.5 periods: bunching
//!   changes little. A rate of the sensor within 1 % of both is taken after one stretch; of one of
//!   them after 4, if the other does not contradict; else by the stretches after 16. After these,
//!   or 1024 lines, or at the end, another rate is kept, rounded by 50 ppm at most. Where neither
//!   tells one the rate is that of the lower edge, by the median step of the earliest of 32 lines:
//!   a backlog that drains bends a few steps. But losses bend all, and the stretches, too: it must
//!   be one of the sensor's within 1 %, and neither counts where the intervals are whole periods,
//!   some of them single ones, of one that is 1.75 times as high. Then the rate is that one, or
//!   that of the fastest stretch, or the mean, snapped within 5 %. A rate known beforehand is taken
//!   as soon as four intervals in a row, and a second of them, are within 0.1 periods of it, and 1
//!   % in the mean. Or after 4 stretches, or at the end, when nine in ten intervals are whole
//!   periods of it, one in twenty at least a single one, and the stretches are not even at another
//!   rate: most lines may be lost. Until then it is one more of the sensor's; where neither tells
//!   one of these it is kept if it lies within 5 % of the lower edge, or, where they tell none at
//!   all, of the fastest stretch. Else it has until line 1024.
//! - *Fitted rate*: the median slope (Theil 1950, Sen 1968) between the earliest arrivals of at
//!   most 64 blocks of the record, lost lines counted. The length of a loss is counted with it.
//! - *Due time*: that of the line before plus the nominal period, or the fitted one of a rate kept
//!   as measured. It follows an earlier arrival at once, and the least lag of each block of 16
//!   lines.
//! - *Gap*: a line is in doubt when it is 0.82 periods late. Lines are lost when the least lag has
//!   stood for 12 reads and 0.1 s; then floor(lag / period + 0.18) of them. Lines that came
//!   together are one read: only the last of them tells how late it is. Where some reads bring
//!   several lines the least lag must stand for 16 reads. Where most do, and always end near the
//!   same phase of the period, lines are in doubt from 1.82 periods: such reads shift by a whole
//!   line when the clocks drift past each other, and single lost lines cannot be told from that. At
//!   the end lines in doubt are a loss where none of late was 0.3 periods late without one, else
//!   from 0.1 s of bunching on.
//! - A gap counted one too large shows when lines then come a period early; it is taken off the
//!   next gap.
//! - *Rate change*: lines in doubt that come evenly at a lower rate of the sensor, 32 of them. Or
//!   lines that come too early: from the first one that is by 0.1 periods they are held, until 12
//!   lines and 0.1 s pass without another, or two stretches in a row are at the same higher rate.
//!   That then begins where the lag behind the mean of both periods is greatest. Time, and the
//!   fitted rate, start anew there. Bunched lines are not even: a lower rate of theirs is taken for
//!   losses.
//! - *Stamps that go back* by more than 10 ms: up to two lines in a row are out of order, and came
//!   no later than the next one that is not. With the third the clock was set back: by the new one,
//!   the first of them came when it was due.

use std::collections::VecDeque;
use std::time::Duration;

mod arrivals;
mod clock;
pub(crate) mod counter;
mod envelope;
mod listed;
mod placed;
mod placer;
mod rate;
mod reads;
mod start;
mod stretches;
mod summary;
mod suspicion;
#[cfg(test)]
mod tests;

pub use placed::Placed;
pub use summary::{Arrivals, NominalRate, Refusal, TimebaseSummary};

use arrivals::Intervals;
use listed::fastest;
use placer::{Change, Placer, Verdict};
use start::{Beginning, Placing, Start};

/// Places the lines of a stream by their arrival stamps; streaming, in bounded memory, without a
/// clock of its own.
///
/// Every line pushed comes out once, in order, in a [`Placed::Lines`]. No stamp is an error: stamps
/// that are no time base are refused, see [`Refusal`], and lines are placed without gaps from there
/// on. Rate and refusal come out at their place among the lines: what is made of them does not
/// depend on when they are polled.
///
/// ```
/// use std::time::Duration;
/// use imu_noise::{NominalRate, Placed, Timebase};
///
/// let mut timebase = Timebase::new(&[10.0, 40.0, 100.0]);
/// for line in (0..500).filter(|line| !(300..305).contains(line)) {
///     timebase.push(Duration::from_millis(25 * line));
/// }
/// timebase.finish();
///
/// let placed: Vec<_> = std::iter::from_fn(|| timebase.poll()).collect();
/// let rate = Placed::Rate(NominalRate::Snapped(40.0));
/// assert_eq!(placed, [rate, Placed::Lines(300), Placed::Gap { missing: 5 }, Placed::Lines(195)]);
/// ```
#[derive(Clone, Debug)]
pub struct Timebase {
    rates_hz: &'static [f64],
    state: State,
    nominal: Option<NominalRate>,
    /// The first stamp of the present clock, and the time in seconds that it stands for.
    origin: (Duration, f64),
    /// The last stamp; it never goes back unless the clock does.
    last: Duration,
    /// Stamps that lie before the last one, in a row.
    behind: Vec<Duration>,
    lines: u64,
    backwards: u64,
    intervals: Intervals,
    placed: VecDeque<Placed>,
    missing: u64,
    gaps: u64,
}

/// What is done with a line.
#[derive(Clone, Debug)]
enum State {
    /// It is held: the rate is not known.
    Starting(Start),
    /// It is judged by its lag.
    Placing(Box<Placer>),
    /// It follows the line before.
    Refused(Refusal),
}

impl Timebase {
    /// A time base for a sensor that has these rates, in Hz, finite and positive; for any sensor if
    /// there are none: then the measured rate is kept, none is too fast, and a change of it is not
    /// told.
    #[must_use]
    pub fn new(rates_hz: &'static [f64]) -> Self {
        Self::with_start(rates_hz, None)
    }

    /// A time base for a sensor said to send at `known_hz`, one of its rates or not. Lines are held
    /// as by [`new`](Self::new), or shorter where they come evenly, until the stamps agree. They
    /// are refused when the rate measured is not within 5 % of it, see [`Refusal::OtherRate`], and
    /// is another of the sensor's, or still contradicts it after 1024 lines. Few lines agree when
    /// bunching of 0.1 s explains the difference, or lost lines do. A change of the rate later is
    /// told all the same. A rate that is not finite and positive is ignored.
    #[must_use]
    pub fn with_known_rate(rates_hz: &'static [f64], known_hz: f64) -> Self {
        Self::with_start(rates_hz, is_rate(known_hz).then_some(known_hz))
    }

    fn with_start(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        Self {
            rates_hz,
            state: State::Starting(Start::new(rates_hz, known_hz)),
            nominal: None,
            origin: (Duration::ZERO, 0.0),
            last: Duration::ZERO,
            behind: Vec::new(),
            lines: 0,
            backwards: 0,
            intervals: Intervals::new(),
            placed: VecDeque::new(),
            missing: 0,
            gaps: 0,
        }
    }

    /// The sensor is said to send at `known_hz`, as for [`with_known_rate`](Self::with_known_rate),
    /// from the lines on that are still held; nothing changes once a rate was told, or the stamps
    /// refused.
    pub fn know_rate(&mut self, known_hz: f64) {
        if let (State::Starting(start), true) = (&mut self.state, is_rate(known_hz)) {
            start.know(known_hz);
        }
    }

    /// Adds the next line and its arrival since any origin. Lines of one read may share a stamp.
    pub fn push(&mut self, at: Duration) {
        self.lines += 1;
        if self.lines == 1 { self.begin_clock(at, 0.0) } else { self.stamp(at) }
    }

    /// The next lines or losses whose place is sure.
    pub fn poll(&mut self) -> Option<Placed> {
        self.placed.pop_front()
    }

    /// Nothing follows: decides on the lines still held, for [`poll`](Self::poll) to tell.
    pub fn finish(&mut self) {
        let behind = std::mem::take(&mut self.behind).len();
        if let State::Starting(start) = &mut self.state {
            let decision = start.finish();
            let of_no_rate = if decision.is_none() { start.lines() } else { 0 };
            self.start(decision);
            self.place_lines(of_no_rate);
        }
        self.clear_suspicion();
        while let State::Placing(placer) = &mut self.state
            && let Some(placed) = placer.finish()
        {
            self.place(placed);
            self.judge();
            self.clear_suspicion();
        }
        self.place_lines(behind as u64);
    }

    /// What the stamps said so far.
    #[must_use]
    pub fn summary(&self) -> TimebaseSummary {
        let (refusal, fitted_s) = match &self.state {
            State::Starting(_) => (None, None),
            State::Placing(placer) => (None, placer.fitted_period_s()),
            State::Refused(refusal) => (Some(*refusal), None),
        };
        self.summary_of(refusal, fitted_s)
    }

    fn place_or_hold(&mut self, at_s: f64) {
        match &mut self.state {
            State::Starting(start) => {
                let decision = start.push(at_s);
                self.start(decision);
            }
            State::Placing(placer) => {
                placer.push(at_s);
                self.judge();
            }
            State::Refused(_) => self.place_lines(1),
        }
    }

    /// Ends the start when there is a decision.
    fn start(&mut self, decision: Option<Result<Beginning, Refusal>>) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        match decision {
            None => {}
            Some(Err(refusal)) => self.refuse(refusal),
            Some(Ok(Beginning { nominal, placing })) => {
                let (unstamped, held_s) = start.take_held();
                self.place(Placed::Rate(nominal));
                self.place_lines(unstamped);
                self.place_at(nominal, placing, held_s);
            }
        }
    }

    /// Places lines at this rate, from the first of these on.
    fn place_at(&mut self, nominal: NominalRate, placing: Placing, held_s: Vec<f64>) {
        let due_s = held_s.first().copied().unwrap_or_default();
        let mut placer = Placer::new(self.rates_hz, placing, due_s);
        // Before the first is judged the placer sees how all of them were read.
        held_s.into_iter().for_each(|at_s| placer.push(at_s));
        self.nominal = Some(nominal);
        self.state = State::Placing(Box::new(placer));
        self.judge();
    }

    fn judge(&mut self) {
        while let State::Placing(placer) = &mut self.state
            && let Some(verdict) = placer.judge()
        {
            match verdict {
                Verdict::Placed(placed) => self.place(placed),
                Verdict::Changed(change) => self.change(change),
            }
        }
    }

    #[cold]
    fn change(&mut self, change: Change) {
        match change {
            Change::Cleared(decisions) => decisions.into_iter().for_each(|placed| self.place(placed)),
            Change::Slower(to_hz) => {
                self.clear_suspicion();
                self.change_rate(to_hz);
            }
            Change::Faster(to_hz) => self.change_rate(to_hz),
            Change::TooFast(measured_hz) => {
                self.refuse(Refusal::TooFast { measured_hz, fastest_hz: fastest(self.rates_hz) });
            }
        }
    }

    fn place(&mut self, placed: Placed) {
        if let Placed::Lines(lines) = placed {
            self.intervals.place(lines);
        }
        match (placed, self.placed.back_mut()) {
            (Placed::Lines(more), Some(Placed::Lines(lines))) => {
                *lines += more;
                return;
            }
            (Placed::Gap { missing }, _) => {
                self.missing += missing;
                self.gaps += 1;
            }
            _ => {}
        }
        self.placed.push_back(placed);
    }

    fn place_lines(&mut self, lines: u64) {
        if lines > 0 {
            self.place(Placed::Lines(lines));
        }
    }

    fn clear_suspicion(&mut self) {
        if let State::Placing(placer) = &mut self.state {
            let decisions = placer.clear_suspicion();
            decisions.into_iter().for_each(|placed| self.place(placed));
        }
    }

    fn summary_of(&self, refusal: Option<Refusal>, fitted_s: Option<f64>) -> TimebaseSummary {
        let measured_hz = fitted_s.map(f64::recip);
        let nominal = self.nominal.filter(|_| refusal.is_none());
        let offset_ppm =
            nominal.zip(measured_hz).map(|(nominal, measured_hz)| (measured_hz / nominal.hz() - 1.0) * 1e6);
        TimebaseSummary {
            lines: self.lines,
            backwards: self.backwards,
            nominal,
            measured_hz,
            offset_ppm,
            refusal,
            missing: self.missing,
            gaps: self.gaps,
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
        }
    }

    /// Starts anew where the lines suspected, or else the lines held, begin to come at this rate.
    fn change_rate(&mut self, to_hz: f64) {
        let (State::Placing(placer), Some(nominal)) = (&mut self.state, self.nominal) else {
            return;
        };
        let fitted_s = placer.fitted_unsuspected_s();
        let (before, after_s) = placer.split(to_hz);
        before.into_iter().for_each(|placed| self.place(placed));
        let until = self.summary_of(None, fitted_s);
        self.place(Placed::RateChanged { from_hz: nominal.hz(), to_hz, until });
        self.place_at(NominalRate::Snapped(to_hz), Placing::Listed(to_hz), after_s);
    }

    /// Places the lines that wait, and all that follow, without gaps.
    fn refuse(&mut self, refusal: Refusal) {
        let waiting = match &mut self.state {
            State::Starting(start) => start.lines(),
            State::Placing(placer) => placer.waiting() as u64,
            State::Refused(_) => return,
        };
        self.state = State::Refused(refusal);
        self.place(Placed::Refused(refusal));
        self.place_lines(waiting);
    }
}

fn is_rate(hz: f64) -> bool {
    hz.is_finite() && hz > 0.0
}
