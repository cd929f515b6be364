//! Time base of a stream without time or counter: rate and lost lines, from arrival stamps alone.

use std::collections::VecDeque;
use std::time::Duration;

mod arrivals;
mod envelope;
mod placer;
mod reads;
mod stretches;

use arrivals::Intervals;
use placer::{Placer, Verdict};
use reads::Reads;
use stretches::{SNAP_TOLERANCE, Stretches, nominal, percentile_90, snap};

/// Stamps may go back by so much; threads that stamp are not always in order.
const BACKWARDS_TOLERANCE: Duration = Duration::from_millis(10);

/// Most stretches, and lines, held at the start while no rate of the sensor is seen.
const START_STRETCHES: usize = 16;
const START_LINES: usize = 1024;

/// A rate above the fastest by this factor is no sensor's.
const TOO_FAST: f64 = 1.25;

/// Lines in order, as their places become sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// The next so many lines follow each other.
    Lines(u64),
    /// Lines are missing here.
    Gap {
        /// How many, at least 1.
        missing: u64,
    },
    /// From here on lines come at another of the sensor's rates.
    RateChanged {
        /// Rate before, in Hz.
        from_hz: f64,
        /// Rate from here on, in Hz.
        to_hz: f64,
    },
}

/// Rate the lines stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NominalRate {
    /// Given beforehand, in Hz.
    Known(f64),
    /// One of the sensor's rates, within 5 % of the measured one, in Hz.
    Snapped(f64),
    /// As measured, in Hz: no rate of the sensor is near.
    Measured(f64),
}

impl NominalRate {
    /// The rate in Hz.
    #[must_use]
    pub const fn hz(self) -> f64 {
        match self {
            Self::Known(hz) | Self::Snapped(hz) | Self::Measured(hz) => hz,
        }
    }
}

/// Why stamps are no time base. Missing lines cannot be seen then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// A stamp lies before the one before it.
    Backwards {
        /// Number of the line, from 0.
        line: u64,
        /// How far it goes back.
        by: Duration,
    },
    /// Lines come faster than any sensor sends them: a file read, not a port.
    TooFast {
        /// Measured rate in Hz.
        measured_hz: f64,
        /// The sensor's fastest rate in Hz.
        fastest_hz: f64,
    },
    /// All lines have one stamp.
    NoTimePasses {
        /// How many lines.
        lines: u64,
    },
}

/// What the stamps say about the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimebaseSummary {
    /// Lines seen.
    pub lines: u64,
    /// Rate the lines stand for; absent before it is known and after a refusal.
    pub nominal: Option<NominalRate>,
    /// Fitted rate in Hz.
    pub measured_hz: Option<f64>,
    /// The fitted rate against the nominal one, in parts per million.
    pub offset_ppm: Option<f64>,
    /// Why the stamps are no time base.
    pub refusal: Option<Refusal>,
    /// Lines missing.
    pub missing: u64,
    /// Places where lines are missing.
    pub gaps: u64,
    /// Part of the lines that came within 0.2 periods of the one before.
    pub share_together: Option<f64>,
    /// Quantiles 0.5, 0.99 and 1 of the time between lines, in microseconds.
    pub interval_us: Option<[u64; 3]>,
}

/// What is done with lines at present.
#[derive(Clone, Debug)]
enum State {
    Starting { held: Vec<f64>, stretch_rates_hz: Vec<f64> },
    Placing(Box<Placer>),
    Refused(Refusal),
}

/// Places lines by their arrival stamps.
#[derive(Clone, Debug)]
pub struct Timebase {
    rates_hz: &'static [f64],
    state: State,
    nominal: Option<NominalRate>,
    origin: Option<Duration>,
    previous: Duration,
    lines: u64,
    stretches: Stretches,
    /// The rate two stretches in a row must agree on.
    faster_hz: Option<f64>,
    intervals: Intervals,
    placed: VecDeque<Placed>,
    missing: u64,
    gaps: u64,
}

impl Timebase {
    /// A time base for a sensor with these rates in Hz.
    #[must_use]
    pub fn new(rates_hz: &'static [f64]) -> Self {
        Self {
            rates_hz,
            state: State::Starting { held: Vec::new(), stretch_rates_hz: Vec::new() },
            nominal: None,
            origin: None,
            previous: Duration::ZERO,
            lines: 0,
            stretches: Stretches::default(),
            faster_hz: None,
            intervals: Intervals::new(),
            placed: VecDeque::new(),
            missing: 0,
            gaps: 0,
        }
    }

    /// A time base for a sensor known to send at `known_hz`: nothing is held to find that out.
    #[must_use]
    pub fn with_known_rate(rates_hz: &'static [f64], known_hz: f64) -> Self {
        Self { nominal: Some(NominalRate::Known(known_hz)), ..Self::new(rates_hz) }
    }

    /// Adds a line and its arrival.
    pub fn push(&mut self, at: Duration) {
        let origin = *self.origin.get_or_insert(at);
        if self.lines > 0 {
            let back = self.previous.saturating_sub(at);
            if back > BACKWARDS_TOLERANCE {
                self.refuse(Refusal::Backwards { line: self.lines, by: back });
            }
            self.intervals.push(at.saturating_sub(self.previous).as_micros() as u64);
        }
        let at = at.max(self.previous);
        self.previous = at;
        self.lines += 1;
        let at_s = at.saturating_sub(origin).as_secs_f64();
        let stretch_hz = self.stretches.push(at_s);
        match &mut self.state {
            State::Refused(_) => self.place(Placed::Lines(1)),
            State::Starting { held, stretch_rates_hz } => {
                held.push(at_s);
                stretch_rates_hz.extend(stretch_hz);
                let full = stretch_rates_hz.len() >= START_STRETCHES || held.len() >= START_LINES;
                if stretch_hz.is_some() || full || self.nominal.is_some() {
                    self.start(full);
                }
            }
            State::Placing(placer) => {
                placer.push(at_s);
                self.advance();
                if let Some(stretch_hz) = stretch_hz {
                    self.watch_faster(stretch_hz);
                }
            }
        }
    }

    /// The next decision.
    pub fn poll(&mut self) -> Option<Placed> {
        self.placed.pop_front()
    }

    /// No line follows: decides on those still held.
    pub fn finish(&mut self) {
        if let State::Starting { .. } = self.state {
            self.start(true);
        }
        if let State::Starting { held, .. } = &mut self.state {
            let lines = std::mem::take(held).len() as u64;
            if lines > 0 {
                self.place(Placed::Lines(lines));
            }
        }
        loop {
            self.advance();
            let State::Placing(placer) = &mut self.state else { return };
            let Some(verdict) = placer.finish() else { return };
            self.apply(verdict);
        }
    }

    /// What the stamps said so far.
    #[must_use]
    pub fn summary(&self) -> TimebaseSummary {
        let refusal = match self.state {
            State::Refused(refusal) => Some(refusal),
            _ => None,
        };
        let nominal = self.nominal.filter(|_| refusal.is_none());
        let measured_hz = match &self.state {
            State::Placing(placer) => placer.fitted_period_s().map(f64::recip),
            _ => None,
        };
        let some = (self.intervals.count() > 0).then_some(&self.intervals);
        TimebaseSummary {
            lines: self.lines,
            nominal,
            measured_hz,
            offset_ppm: measured_hz.zip(nominal).map(|(measured, nominal)| (measured / nominal.hz() - 1.0) * 1e6),
            refusal,
            missing: self.missing,
            gaps: self.gaps,
            share_together: some.zip(nominal).map(|(i, nominal)| i.share_together(1.0 / nominal.hz())),
            interval_us: some.map(|i| [0.5, 0.99, 1.0].map(|q| i.quantile_us(q))),
        }
    }

    fn place(&mut self, placed: Placed) {
        if let (Placed::Lines(more), Some(Placed::Lines(lines))) = (placed, self.placed.back_mut()) {
            *lines += more;
            return;
        }
        if let Placed::Gap { missing } = placed {
            self.missing += missing;
            self.gaps += 1;
        }
        self.placed.push_back(placed);
    }

    fn advance(&mut self) {
        while let State::Placing(placer) = &mut self.state {
            let Some(verdict) = placer.next() else { return };
            self.apply(verdict);
        }
    }

    fn apply(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Placed(placed) => self.place(placed),
            Verdict::Slower(hz) => self.change_rate(hz),
        }
    }

    fn start(&mut self, full: bool) {
        let State::Starting { held, stretch_rates_hz } = &mut self.state else { return };
        let fastest_hz = self.rates_hz.iter().copied().fold(0.0, f64::max);
        let span_s = held.last().copied().unwrap_or(0.0);
        let mean_hz = (span_s > 0.0).then(|| (held.len() - 1) as f64 / span_s);
        let measured_hz = percentile_90(stretch_rates_hz).or(mean_hz.filter(|_| full));
        let nominal = match (self.nominal, measured_hz) {
            (Some(known), _) => known,
            (None, Some(measured_hz)) => match nominal(self.rates_hz, measured_hz) {
                NominalRate::Measured(_) if !full => return,
                NominalRate::Measured(_) if measured_hz > TOO_FAST * fastest_hz => {
                    return self.refuse(Refusal::TooFast { measured_hz, fastest_hz });
                }
                nominal => nominal,
            },
            (None, None) if !full || held.len() < 2 => return,
            (None, None) => {
                let lines = self.lines;
                return self.refuse(Refusal::NoTimePasses { lines });
            }
        };
        let held = std::mem::take(held);
        let hz = nominal.hz();
        self.nominal = Some(nominal);
        let first_s = held.first().copied().unwrap_or(0.0);
        let mut placer = Placer::new(self.rates_hz, hz, first_s, Reads::new(hz.recip()), 0.002);
        held.into_iter().for_each(|at_s| placer.push(at_s));
        self.state = State::Placing(Box::new(placer));
        self.advance();
    }

    fn watch_faster(&mut self, stretch_hz: f64) {
        let State::Placing(placer) = &mut self.state else { return };
        let early = placer.take_early_periods() > 2.0;
        let nominal_hz = self.nominal.map_or(0.0, NominalRate::hz);
        let faster = snap(self.rates_hz, stretch_hz, SNAP_TOLERANCE).filter(|&hz| early && hz > 1.1 * nominal_hz);
        if let Some(hz) = faster && self.faster_hz == Some(hz) {
            self.change_rate(hz);
        } else {
            self.faster_hz = faster;
        }
    }

    fn change_rate(&mut self, to_hz: f64) {
        let State::Placing(placer) = &mut self.state else { return };
        let from_hz = self.nominal.map_or(to_hz, NominalRate::hz);
        let held: Vec<f64> = placer.clone().into_held().into();
        // Without held lines the next line is due one new period from now.
        let next_s = self.previous.saturating_sub(self.origin.unwrap_or_default()).as_secs_f64() + to_hz.recip();
        let due_s = held.first().copied().unwrap_or(next_s);
        let mut placer = Placer::new(self.rates_hz, to_hz, due_s, Reads::new(to_hz.recip()), 0.002);
        for at_s in held {
            placer.push(at_s);
        }
        self.place(Placed::RateChanged { from_hz, to_hz });
        self.nominal = Some(NominalRate::Snapped(to_hz));
        self.faster_hz = None;
        self.state = State::Placing(Box::new(placer));
        self.advance();
    }

    fn refuse(&mut self, refusal: Refusal) {
        let held = match &self.state {
            State::Starting { held, .. } => held.len(),
            State::Placing(placer) => placer.clone().into_held().len(),
            State::Refused(_) => return,
        };
        if held > 0 {
            self.place(Placed::Lines(held as u64));
        }
        self.state = State::Refused(refusal);
    }
}
