//! Lines that come too early: their rate is higher, or those before them were late.

use super::Placed;
use super::listed::{TOO_FAST, fastest, snap};
use super::stretches::{STRETCH_TOLERANCE, Stretches};

/// Another rate is higher from this factor on.
const FASTER: f64 = 1.1;

/// Periods by which the lines of a stretch come too early at a higher rate, at least.
const FASTER_EARLY_PERIODS: f64 = 2.0;

/// Stretches in a row at no sensor's rate that are no time base.
const TOO_FAST_STRETCHES: usize = 16;

/// Lines in a row that are not early clear a suspicion, when they also last a window of the reads.
const QUIET_LINES: usize = 12;

/// Most lines held back.
const MAX_SUSPECTED: usize = 4096;

/// What became of a suspicion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outcome {
    /// It stays.
    Open,
    /// The lines before were late; nothing else.
    Cleared,
    /// Lines come at this higher rate, in Hz.
    Faster(f64),
    /// Lines come at this rate in Hz, which no sensor has.
    TooFast(f64),
}

/// Lines from the first early one on, and what was decided on them as if the rate had not changed.
#[derive(Clone, Debug)]
pub(super) struct Suspicion {
    rates_hz: &'static [f64],
    period_s: f64,
    /// When the line before the first one was due.
    before_s: f64,
    /// The period fitted without these lines.
    fitted_before_s: Option<f64>,
    stamps_s: Vec<f64>,
    decisions: Vec<Placed>,
    stretches: Stretches,
    /// By how much lines of the present stretch came before they were due.
    early_s: f64,
    /// Place among the lines, and stamp, of the last early one.
    last_early: (usize, f64),
    /// Higher rate of the last stretch.
    faster_hz: Option<f64>,
    /// Stretches in a row at no sensor's rate.
    too_fast: usize,
    outcome: Outcome,
}

impl Suspicion {
    /// Begins before an early line; the one before it was due at `before_s`, and the period fitted
    /// until then is this.
    pub(super) fn new(rates_hz: &'static [f64], period_s: f64, before_s: f64, fitted_before_s: Option<f64>) -> Self {
        Self {
            rates_hz,
            period_s,
            before_s,
            fitted_before_s,
            stamps_s: Vec::new(),
            decisions: Vec::new(),
            stretches: Stretches::default(),
            early_s: 0.0,
            last_early: (0, before_s),
            faster_hz: None,
            too_fast: 0,
            outcome: Outcome::Open,
        }
    }

    /// The next line is so much too early.
    pub(super) fn add_early(&mut self, early_s: f64) {
        self.early_s += early_s;
    }

    /// The next line is early by more than the tolerance.
    pub(super) fn note_early(&mut self, at_s: f64) {
        self.last_early = (self.stamps_s.len(), at_s);
    }

    /// By how much lines of the present stretch came too early.
    pub(super) const fn early_s(&self) -> f64 {
        self.early_s
    }

    /// Adds a line's stamp.
    pub(super) fn push(&mut self, at_s: f64, window_s: f64) {
        self.stamps_s.push(at_s);
        if let Some(stretch) = self.stretches.push(at_s) {
            self.end_stretch(stretch.hz());
        }
        let (early, early_at_s) = self.last_early;
        let quiet = self.stamps_s.len() > early + QUIET_LINES && at_s - early_at_s >= window_s;
        if self.outcome == Outcome::Open && (quiet || self.stamps_s.len() >= MAX_SUSPECTED) {
            self.outcome = Outcome::Cleared;
        }
    }

    /// Keeps what was decided on the lines added.
    pub(super) fn keep(&mut self, decision: Placed) -> Outcome {
        self.decisions.push(decision);
        self.outcome
    }

    /// The period fitted without these lines.
    pub(super) const fn fitted_before_s(&self) -> Option<f64> {
        self.fitted_before_s
    }

    /// Lines held back.
    pub(super) const fn lines(&self) -> usize {
        self.stamps_s.len()
    }

    /// The decisions, which hold.
    pub(super) fn into_decisions(self) -> Vec<Placed> {
        self.decisions
    }

    /// The decisions on the lines before the rate changed to `to_hz`, and the stamps of those
    /// after.
    ///
    /// Against a rate between both the lag rises before the change and falls after it.
    pub(super) fn split(mut self, to_hz: f64) -> (Vec<Placed>, Vec<f64>) {
        let between_s = 0.5 * (self.period_s + to_hz.recip());
        let (mut place, mut most_lag_s) = (0, self.before_s + between_s);
        for (line, at_s) in self.stamps_s.iter().enumerate() {
            let lag_s = at_s - line as f64 * between_s;
            if lag_s > most_lag_s {
                (place, most_lag_s) = (line + 1, lag_s);
            }
        }
        let mut left = place as u64;
        let before = std::mem::take(&mut self.decisions).into_iter().map_while(|decision| match decision {
            _ if left == 0 => None,
            Placed::Lines(lines) => {
                let lines = lines.min(left);
                left -= lines;
                Some(Placed::Lines(lines))
            }
            other => Some(other),
        });
        (before.collect(), self.stamps_s.split_off(place))
    }

    fn end_stretch(&mut self, stretch_hz: f64) {
        let early = std::mem::take(&mut self.early_s) > FASTER_EARLY_PERIODS * self.period_s;
        self.too_fast = if early && stretch_hz > TOO_FAST * fastest(self.rates_hz) { self.too_fast + 1 } else { 0 };
        if self.too_fast >= TOO_FAST_STRETCHES {
            self.outcome = Outcome::TooFast(stretch_hz);
        }
        let faster_hz =
            snap(self.rates_hz, stretch_hz, STRETCH_TOLERANCE).filter(|&hz| early && hz * self.period_s > FASTER);
        match faster_hz {
            Some(to_hz) if self.faster_hz == faster_hz => self.outcome = Outcome::Faster(to_hz),
            _ => self.faster_hz = faster_hz,
        }
    }
}
