//! Which lines are missing: the lag of each line behind the time it was due.

use std::collections::VecDeque;

use super::envelope::Envelope;
use super::stretches::snap;
use super::reads::{MIN_WINDOW_S, Reads};
use super::Placed;

/// A lag below this part of a period is no loss.
const DOUBT_PERIODS: f64 = 0.8;

/// Where reads bring several lines, the place of a read among the lines moves the least lag by up to a period more.
const BUNCHED_DOUBT_PERIODS: f64 = 1.8;

/// The least lag must have stood for so many lines,
const DOUBT_LINES: usize = 12;

/// and not fall by more than this part of a period in each line: a reader that catches up, or drifts past the lines.
const FALLING_PERIODS: f64 = 0.004;

/// Most lines held in doubt: 5 min at 200 Hz.
const MAX_HELD: usize = 65_536;

/// Lines that come so much too early show that those before were late; a read's place among the lines moves by one.
const EARLY_PERIODS: f64 = 4.0;

/// Lines after which the due time follows the least lag among them.
const BLOCK_LINES: u32 = 16;

/// Their rate is within this part of one of the sensor's: regular losses can come near.
const CHANGE_TOLERANCE: f64 = 0.01;

/// Evenly spaced lines that make a lower rate.
const SLOWER_LINES: usize = 32;

/// Lags in doubt.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    /// When the first held line was due.
    first_due_s: f64,
    least_lag_s: f64,
    /// Stamp of the line with the least lag, and its place among the held.
    least_at_s: f64,
    least_place: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Placer {
    rates_hz: &'static [f64],
    period_s: f64,
    /// When the next line to be judged is due, at the earliest.
    due_s: f64,
    held: VecDeque<f64>,
    judged: usize,
    doubt: Option<Doubt>,
    block_lines: u32,
    block_start_s: f64,
    block_least_s: f64,
    /// How early lines may come after a loss without being taken for the new earliest: they show that the loss was
    /// counted one too large, and the next one is counted less.
    overcount_s: f64,
    /// Place in the stream of the next line to be settled, lost lines included.
    index: u64,
    envelope: Envelope,
    reads: Reads,
    fit_tolerance: f64,
    /// By how much lines came before they were due, since the caller last asked.
    early_s: f64,
}

/// What a line brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    Placed(Placed),
    /// The lines held come evenly at this rate.
    Slower(f64),
}

impl Placer {
    pub(super) fn new(rates_hz: &'static [f64], nominal_hz: f64, due_s: f64, reads: Reads, fit_tolerance: f64) -> Self {
        Self {
            rates_hz,
            period_s: nominal_hz.recip(),
            due_s,
            held: VecDeque::new(),
            judged: 0,
            doubt: None,
            block_lines: 0,
            block_start_s: due_s,
            block_least_s: f64::INFINITY,
            overcount_s: 0.0,
            index: 0,
            envelope: Envelope::new(1.0 / nominal_hz),
            reads,
            fit_tolerance,
            early_s: 0.0,
        }
    }

    /// Adds a line's stamp. Verdicts come from [`next`](Self::next).
    pub(super) fn push(&mut self, at_s: f64) {
        self.reads.push(at_s);
        self.held.push_back(at_s);
    }

    /// The next decision.
    pub(super) fn next(&mut self) -> Option<Verdict> {
        while let Some(&at_s) = self.held.get(self.judged) {
            let lag_s = at_s - self.due_s;
            if lag_s < self.threshold_periods() * self.period_s {
                return Some(self.settle(at_s, lag_s));
            }
            if let Some(verdict) = self.hold(at_s, lag_s) {
                return Some(verdict);
            }
        }
        None
    }

    /// Decides on the lines still held as if nothing followed: a loss is what exceeds any bunching.
    pub(super) fn finish(&mut self) -> Option<Verdict> {
        match self.doubt {
            Some(doubt) if doubt.least_lag_s >= self.threshold_periods() * self.period_s + MIN_WINDOW_S => Some(self.lose(doubt)),
            Some(_) => {
                self.doubt = None;
                let lines = self.held.len() as u64;
                self.held.clear();
                self.judged = 0;
                Some(Verdict::Placed(Placed::Lines(lines)))
            }
            None => None,
        }
    }

    pub(super) fn fitted_period_s(&self) -> Option<f64> {
        self.envelope.fitted_period_s()
    }

    pub(super) fn take_early_periods(&mut self) -> f64 {
        std::mem::take(&mut self.early_s) / self.period_s
    }

    pub(super) fn into_held(self) -> VecDeque<f64> {
        self.held
    }

    fn threshold_periods(&self) -> f64 {
        if self.reads.bunched() && !self.reads.mixed() {
            BUNCHED_DOUBT_PERIODS
        } else {
            DOUBT_PERIODS
        }
    }

    /// The line at `judged` is in place, and so are those held before it.
    fn settle(&mut self, at_s: f64, lag_s: f64) -> Verdict {
        self.doubt = None;
        self.due_s += self.period_s;
        if lag_s < -self.overcount_s {
            let early_s = -self.overcount_s - lag_s;
            self.due_s -= early_s;
            self.early_s += early_s;
            self.block_least_s = -self.overcount_s;
        } else {
            self.block_least_s = self.block_least_s.min(lag_s);
        }
        let lines = self.judged + 1;
        self.judged = 0;
        if lines == 1 {
            self.held.pop_front();
        } else {
            self.held.drain(..lines);
        }
        self.index += lines as u64;
        if self.early_s > EARLY_PERIODS * self.period_s {
            self.envelope.restart();
        }
        self.fit(at_s);
        self.block_lines += lines as u32;
        if self.block_lines >= BLOCK_LINES && at_s - self.block_start_s >= self.reads.window_s() {
            self.end_block(at_s);
        }
        Verdict::Placed(Placed::Lines(lines as u64))
    }

    /// After a block without a loss the due time follows its least lag; a loss counted too much stays owed.
    fn end_block(&mut self, at_s: f64) {
        let overcounted = self.block_least_s < -0.5 * self.overcount_s;
        if !overcounted {
            self.overcount_s = 0.0;
        }
        self.due_s += self.block_least_s + self.overcount_s;
        self.block_lines = 0;
        self.block_start_s = at_s;
        self.block_least_s = f64::INFINITY;
    }

    /// Lines held before they were placed were late: only a line placed at once may lie on the envelope.
    fn fit(&mut self, at_s: f64) {
        if !self.envelope.push(self.index, at_s) {
            return;
        }
        let nominal_period_s = self.envelope.nominal_period_s();
        let fitted_period_s = self.envelope.fitted_period_s().unwrap_or(nominal_period_s);
        let credible = (fitted_period_s / nominal_period_s - 1.0).abs() < self.fit_tolerance;
        self.period_s = if credible { fitted_period_s } else { nominal_period_s };
    }

    /// The line at `judged` is too late to be sure of its place.
    fn hold(&mut self, at_s: f64, lag_s: f64) -> Option<Verdict> {
        let place = self.judged;
        let doubt = self.doubt.get_or_insert(Doubt {
            first_due_s: self.due_s,
            least_lag_s: f64::INFINITY,
            least_at_s: at_s,
            least_place: place,
        });
        let since = place - doubt.least_place;
        if lag_s < doubt.least_lag_s - FALLING_PERIODS * self.period_s * since as f64 {
            (doubt.least_lag_s, doubt.least_at_s, doubt.least_place) = (lag_s, at_s, place);
        } 
        doubt.least_lag_s = doubt.least_lag_s.min(lag_s);
        let doubt = *doubt;
        self.judged += 1;
        self.due_s += self.period_s;
        let stood = place - doubt.least_place >= DOUBT_LINES && at_s - doubt.least_at_s >= self.reads.window_s();
        if !stood && self.held.len() < MAX_HELD {
            return None;
        }
        if let Some(slower_hz) = self.slower() {
            return (self.judged >= SLOWER_LINES).then_some(Verdict::Slower(slower_hz));
        }
        Some(self.lose(doubt))
    }

    /// Lines are lost before the first held; the held ones are judged anew.
    fn lose(&mut self, doubt: Doubt) -> Verdict {
        let missing = (doubt.least_lag_s / self.period_s + (1.0 - DOUBT_PERIODS)).floor();
        self.doubt = None;
        self.due_s = doubt.first_due_s + missing * self.period_s;
        self.judged = 0;
        self.overcount_s = self.period_s;
        self.block_lines = 0;
        self.block_least_s = f64::INFINITY;
        self.index += missing as u64;
        Verdict::Placed(Placed::Gap { missing: missing as u64 })
    }

    /// The lower rate of the sensor at which the judged lines came, if three in four intervals fit it.
    fn slower(&self) -> Option<f64> {
        let last = self.judged.checked_sub(1)?;
        let span_s = self.held[last] - self.held[0];
        let slower_hz = snap(self.rates_hz, last as f64 / span_s, CHANGE_TOLERANCE)?;
        if slower_hz * self.period_s > 0.9 {
            return None;
        }
        let judged = self.held.iter().take(self.judged);
        let intervals = judged.clone().skip(1).zip(judged).map(|(later, earlier)| later - earlier);
        let even = intervals.filter(|interval_s| (interval_s * slower_hz - 1.0).abs() < 0.2);
        (4 * even.count() >= 3 * last).then_some(slower_hz)
    }
}
