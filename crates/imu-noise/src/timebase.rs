//! Time base of a stream that has neither time nor counter: its rate and its lost lines, from arrival stamps alone.
//!
//! Lines arrive late, never early: an arrival is the time the line was sent plus a delay that is not negative. So the
//! lower edge of the arrivals over the line number is the sensor's clock, and a lost line lifts that edge by a period
//! for good, while bunching and stalls lift single lines and come back to it.
//!
//! ```text
//! lag behind
//! the due time            stall                        2 lost
//!   3 |                   o                             o
//!   2 |                    o                           o o oo o   <- the least lag stands: Gap { missing: 2 }
//!   1 |      o     o        o        o         o
//!   0 | oo oo oo oo oo oo o  oo oo ooo ooo oo oo                  <- lower edge
//!     +----------------------------------------------------- line
//! ```
//!
//! - *Nominal rate*: a stretch is 32 lines (31 intervals), prolonged to the last line of a read. The 90th percentile
//!   (nearest rank) of the rates of the stretches so far is snapped to the nearest rate of the sensor within 5 %. If
//!   there is none, the highest rate is taken whose period at least half the intervals have within 10 %. Lines are held
//!   until then. After 16 stretches, or 1024 lines, or at the end, the percentile is kept as measured. Without a whole
//!   stretch the mean rate stands for it.
//! - *Fitted rate*: the median slope (Theil 1950, Sen 1968) between the earliest arrivals of at most 64 blocks of the
//!   record, lost lines counted. The length of a loss is counted with it.
//! - *Due time*: that of the line before plus the nominal period, or the fitted one of a rate kept as measured. It
//!   follows an earlier arrival at once, and the least lag of each block of 16 lines.
//! - *Gap*: a line is in doubt when it is 0.82 periods late. Lines are lost when the least lag has stood for 12 lines
//!   and 0.1 s; then floor(lag / period + 0.18) of them. Where reads bring several lines it must stand for 16 reads, and
//!   if these always end near the same phase of the period, lines are in doubt from 1.82 periods: such reads shift by a
//!   whole line when the clocks drift past each other, and single lost lines cannot be told from that.
//! - A gap counted one too large shows when lines then come a period early; it is taken off the next gap.
//! - *Rate change*: lines in doubt that come evenly at a lower rate of the sensor, 32 of them, or two stretches in a
//!   row whose lines come too early at the same higher rate. Time starts anew there.

use std::collections::VecDeque;
use std::time::Duration;

mod arrivals;
mod envelope;
mod placer;
mod reads;
mod stretches;
mod summary;

pub use summary::{Arrivals, NominalRate, Refusal, TimebaseSummary};

use arrivals::Intervals;
use placer::{Placer, Verdict};
use stretches::{SNAP_TOLERANCE, Stretches, percentile_90, snap, steady};

/// Stamps may go back by so much: not every clock is smooth.
const BACKWARDS_TOLERANCE: Duration = Duration::from_millis(10);

/// Most stretches, and lines, held at the start while no rate of the sensor is seen.
const START_STRETCHES: usize = 16;
const START_LINES: usize = 1024;

/// Above the sensor's fastest rate by this factor, lines come from no sensor.
const TOO_FAST: f64 = 1.25;

/// A higher rate is another rate from this factor on.
const FASTER: f64 = 1.1;

/// Periods by which the lines of a stretch come too early at a higher rate, at least.
const FASTER_EARLY_PERIODS: f64 = 2.0;

/// Lines and losses in order, as their places become sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// The next so many lines follow each other.
    Lines(u64),
    /// Lines are missing here.
    Gap {
        /// How many, at least 1.
        missing: u64,
    },
    /// From here on lines come at another of the sensor's rates, and time is not connected with that before. A higher
    /// rate is seen some 70 lines late.
    RateChanged {
        /// Rate before, in Hz.
        from_hz: f64,
        /// Rate from here on, in Hz.
        to_hz: f64,
    },
}

/// Places the lines of a stream by their arrival stamps; streaming, in bounded memory, without a clock of its own.
///
/// Every line pushed comes out once, in order, in a [`Placed::Lines`]. No stamp is an error: stamps that are no time
/// base are refused, see [`Refusal`], and lines are placed without gaps from there on.
///
/// ```
/// use std::time::Duration;
/// use imu_noise::{Placed, Timebase};
///
/// let mut timebase = Timebase::new(&[10.0, 40.0, 100.0]);
/// for line in (0..500).filter(|line| !(300..305).contains(line)) {
///     timebase.push(Duration::from_millis(25 * line));
/// }
/// timebase.finish();
///
/// let placed: Vec<_> = std::iter::from_fn(|| timebase.poll()).collect();
/// assert_eq!(placed, [Placed::Lines(300), Placed::Gap { missing: 5 }, Placed::Lines(195)]);
/// ```
#[derive(Clone, Debug)]
pub struct Timebase {
    rates_hz: &'static [f64],
    state: State,
    nominal: Option<NominalRate>,
    /// First and last stamp; the last one never goes back.
    origin: Duration,
    last: Duration,
    lines: u64,
    stretches: Stretches,
    /// Higher rate at which the lines of the last stretch came too early.
    faster_hz: Option<f64>,
    /// Stretches in a row at no sensor's rate.
    too_fast: usize,
    intervals: Intervals,
    placed: VecDeque<Placed>,
    missing: u64,
    gaps: u64,
}

/// What is done with a line.
#[derive(Clone, Debug)]
enum State {
    /// It is held: the rate is not known.
    Starting { held_s: Vec<f64>, stretch_rates_hz: Vec<f64> },
    /// It is judged by its lag.
    Placing(Box<Placer>),
    /// It follows the line before.
    Refused(Refusal),
}

impl Timebase {
    /// A time base for a sensor that has these rates, in Hz, finite and positive.
    #[must_use]
    pub fn new(rates_hz: &'static [f64]) -> Self {
        Self {
            rates_hz,
            state: State::Starting { held_s: Vec::new(), stretch_rates_hz: Vec::new() },
            nominal: None,
            origin: Duration::ZERO,
            last: Duration::ZERO,
            lines: 0,
            stretches: Stretches::default(),
            faster_hz: None,
            too_fast: 0,
            intervals: Intervals::new(),
            placed: VecDeque::new(),
            missing: 0,
            gaps: 0,
        }
    }

    /// A time base for a sensor known to send at `known_hz`, so that no line is held to find that out. A change of the
    /// rate is seen all the same. A rate that is not finite and positive is ignored.
    #[must_use]
    pub fn with_known_rate(rates_hz: &'static [f64], known_hz: f64) -> Self {
        let usable = known_hz.is_finite() && known_hz > 0.0;
        Self { nominal: usable.then_some(NominalRate::Known(known_hz)), ..Self::new(rates_hz) }
    }

    /// Adds the next line and its arrival since any origin. Lines of one read may share a stamp.
    pub fn push(&mut self, at: Duration) {
        if self.lines == 0 {
            (self.origin, self.last) = (at, at);
        } else {
            let back = self.last.saturating_sub(at);
            if back > BACKWARDS_TOLERANCE {
                self.refuse(Refusal::Backwards { line: self.lines, by: back });
            }
            let interval = at.saturating_sub(self.last);
            let interval_us = interval.as_secs() * 1_000_000 + u64::from(interval.subsec_micros());
            self.intervals.push(interval_us);
            self.last += interval;
        }
        self.lines += 1;
        let at_s = (self.last - self.origin).as_secs_f64();
        let stretch_hz = self.stretches.push(at_s);
        match &mut self.state {
            State::Starting { held_s, stretch_rates_hz } => {
                held_s.push(at_s);
                stretch_rates_hz.extend(stretch_hz);
                let full = stretch_rates_hz.len() >= START_STRETCHES || held_s.len() >= START_LINES;
                if full || stretch_hz.is_some() || self.nominal.is_some() {
                    self.start(full);
                }
            }
            State::Placing(placer) => {
                placer.push(at_s);
                self.judge();
                if let Some(stretch_hz) = stretch_hz {
                    self.watch_faster(stretch_hz, at_s);
                }
            }
            State::Refused(_) => self.place(Placed::Lines(1)),
        }
    }

    /// The next lines or losses whose place is sure.
    pub fn poll(&mut self) -> Option<Placed> {
        self.placed.pop_front()
    }

    /// Nothing follows: decides on the lines still held, for [`poll`](Self::poll) to tell. Lags in doubt are a loss when
    /// the last line is so late that bunching of 0.1 s would not explain it.
    pub fn finish(&mut self) {
        self.start(true);
        while let State::Placing(placer) = &mut self.state {
            let Some(verdict) = placer.finish() else {
                return;
            };
            self.apply(verdict);
            self.judge();
        }
    }

    /// What the stamps said so far.
    #[must_use]
    pub fn summary(&self) -> TimebaseSummary {
        let (refusal, measured_hz) = match &self.state {
            State::Starting { .. } => (None, None),
            State::Placing(placer) => (None, placer.fitted_period_s().map(f64::recip)),
            State::Refused(refusal) => (Some(*refusal), None),
        };
        let nominal = self.nominal.filter(|_| refusal.is_none());
        let offset_ppm =
            nominal.zip(measured_hz).map(|(nominal, measured_hz)| (measured_hz / nominal.hz() - 1.0) * 1e6);
        TimebaseSummary {
            lines: self.lines,
            nominal,
            measured_hz,
            offset_ppm,
            refusal,
            missing: self.missing,
            gaps: self.gaps,
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
        }
    }

    /// Ends the start when the rate is clear, or at any rate when `full`.
    fn start(&mut self, full: bool) {
        let State::Starting { held_s, stretch_rates_hz } = &mut self.state else {
            return;
        };
        let nominal = self.nominal.or_else(|| nominal_rate(self.rates_hz, held_s, stretch_rates_hz, full));
        let Some(nominal) = nominal else {
            if full {
                self.give_up();
            }
            return;
        };
        let fastest_hz = fastest(self.rates_hz);
        if let NominalRate::Measured(measured_hz) = nominal
            && measured_hz > TOO_FAST * fastest_hz
        {
            return self.refuse(Refusal::TooFast { measured_hz, fastest_hz });
        }
        let held_s = std::mem::take(held_s);
        let Some(&first_s) = held_s.first() else {
            return;
        };
        self.place_at(nominal, first_s, held_s);
    }

    /// No rate can be had from the lines held.
    fn give_up(&mut self) {
        match self.lines {
            0 => {}
            1 => self.release_held(),
            lines => self.refuse(Refusal::NoTimePasses { lines }),
        }
    }

    /// Places lines at this rate, from one due at `due_s`.
    fn place_at(&mut self, nominal: NominalRate, due_s: f64, held_s: impl IntoIterator<Item = f64>) {
        // A fit counts the losses seen so far; following it would feed their errors back. A rate as measured is too
        // coarse to do without.
        let follow_fit = matches!(nominal, NominalRate::Measured(_));
        let mut placer = Placer::new(self.rates_hz, nominal.hz(), follow_fit, due_s);
        held_s.into_iter().for_each(|at_s| placer.push(at_s));
        self.nominal = Some(nominal);
        self.state = State::Placing(Box::new(placer));
        self.judge();
    }

    fn judge(&mut self) {
        while let State::Placing(placer) = &mut self.state
            && let Some(verdict) = placer.judge()
        {
            self.apply(verdict);
        }
    }

    fn apply(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Placed(placed) => self.place(placed),
            Verdict::Slower(to_hz) => self.change_rate(to_hz, None),
        }
    }

    fn place(&mut self, placed: Placed) {
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

    /// Looks whether lines that came too early make a higher rate, or one that no sensor has.
    fn watch_faster(&mut self, stretch_hz: f64, at_s: f64) {
        let (State::Placing(placer), Some(nominal)) = (&mut self.state, self.nominal) else {
            return;
        };
        let early = placer.take_early_periods() > FASTER_EARLY_PERIODS;
        let fastest_hz = fastest(self.rates_hz);
        self.too_fast = if early && stretch_hz > TOO_FAST * fastest_hz { self.too_fast + 1 } else { 0 };
        if self.too_fast == START_STRETCHES {
            return self.refuse(Refusal::TooFast { measured_hz: stretch_hz, fastest_hz });
        }
        let faster_hz =
            snap(self.rates_hz, stretch_hz, SNAP_TOLERANCE).filter(|&hz| early && hz > FASTER * nominal.hz());
        match faster_hz {
            Some(to_hz) if self.faster_hz == faster_hz => self.change_rate(to_hz, Some(at_s)),
            _ => self.faster_hz = faster_hz,
        }
    }

    /// Starts anew with the lines held, or behind the one that came last at `last_s`.
    fn change_rate(&mut self, to_hz: f64, last_s: Option<f64>) {
        let (State::Placing(placer), Some(nominal)) = (&mut self.state, self.nominal) else {
            return;
        };
        let from_hz = nominal.hz();
        let held_s = placer.take_held();
        let next_s = last_s.map_or(0.0, |last_s| last_s + to_hz.recip());
        let due_s = held_s.front().copied().unwrap_or(next_s);
        self.place(Placed::RateChanged { from_hz, to_hz });
        self.faster_hz = None;
        self.place_at(NominalRate::Snapped(to_hz), due_s, held_s);
    }

    fn refuse(&mut self, refusal: Refusal) {
        if !matches!(self.state, State::Refused(_)) {
            self.release_held();
            self.state = State::Refused(refusal);
        }
    }

    /// Places the lines held without gaps.
    fn release_held(&mut self) {
        let lines = match &mut self.state {
            State::Starting { held_s, .. } => std::mem::take(held_s).len(),
            State::Placing(placer) => placer.take_held().len(),
            State::Refused(_) => 0,
        };
        if lines > 0 {
            self.place(Placed::Lines(lines as u64));
        }
    }
}

/// The sensor's fastest rate in Hz; no limit when none is listed.
fn fastest(rates_hz: &[f64]) -> f64 {
    let fastest_hz = rates_hz.iter().copied().max_by(f64::total_cmp);
    fastest_hz.unwrap_or(f64::INFINITY)
}

/// The rate the lines held at the start stand for; as measured only when they are all there will be.
fn nominal_rate(rates_hz: &[f64], held_s: &[f64], stretch_rates_hz: &[f64], full: bool) -> Option<NominalRate> {
    let span_s = held_s.last()? - held_s.first()?;
    let mean_hz = (full && span_s > 0.0).then(|| (held_s.len() - 1) as f64 / span_s);
    let measured_hz = percentile_90(stretch_rates_hz).or(mean_hz)?;
    snap(rates_hz, measured_hz, SNAP_TOLERANCE)
        .or_else(|| steady(rates_hz, measured_hz, held_s))
        .map(NominalRate::Snapped)
        .or_else(|| full.then_some(NominalRate::Measured(measured_hz)))
}
