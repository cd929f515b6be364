//! Which lines are missing: the lag of each line behind the time it was due.

use std::collections::VecDeque;

use super::Placed;
use super::envelope::Envelope;
use super::listed::snap;
use super::reads::Reads;
use super::start::Placing;
use super::suspicion::{Outcome, Suspicion};

/// A lag of fewer periods is no loss. Above the 0.76 by which a host was seen to shift its phase,
/// below the 0.88 that were left of a period at the end of a real pause; within that only streams
/// that lose every fourth line depend on it.
const DOUBT_PERIODS: f64 = 0.82;

/// The same where the phase of the reads may jump by a period, see [`Reads`].
const JUMPY_DOUBT_PERIODS: f64 = 1.0 + DOUBT_PERIODS;

/// The least lag must have stood for so many reads, besides the time in which these show the
/// earliest arrival: of the lines of one read only the last is about as early as it can be.
const DOUBT_READS: usize = 12;

/// A least lag that falls by more periods than this in each line does not stand: the reader catches
/// up, or its reads drift past the lines. No clock is that far off.
const FALLING_PERIODS: f64 = 0.004;

/// Most lines held in doubt, 5 min at 200 Hz: a longer stall is taken for a loss.
const MAX_HELD: usize = 65_536;

/// Part by which the greatest lag of lines that have their place fades with each line: it is
/// remembered for some thousand of them.
const LATE_KEPT: f64 = 0.999;

/// Lines come steadily when no line of late was later by so many periods without a loss.
const STEADY_PERIODS: f64 = 0.3;

/// Lines after which the due time follows the least lag among them.
const BLOCK_LINES: u64 = 16;

/// Periods by which lines come too early that show that all lines before were late. A jump of the
/// phase is one.
const EARLY_PERIODS: f64 = 4.0;

/// Periods by which a line comes too early that make a higher rate suspected: half of what each
/// line of the next one of the sensor's rates does.
const SUSPECT_PERIODS: f64 = 0.1;

/// How near a lower rate must be to one of the sensor's: a reader that loses lines evenly can come
/// within 5 %.
const CHANGE_TOLERANCE: f64 = 0.01;

/// Evenly spaced lines that make a lower rate.
const SLOWER_LINES: usize = 32;

/// What the lines say that were judged last.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// They, or losses before them, have their place.
    Placed(Placed),
    /// More than that.
    Changed(Change),
}

/// What becomes of many lines at once.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// Those that were suspected to come at a higher rate have their place.
    Cleared(Vec<Placed>),
    /// Those judged come evenly at this lower rate, in Hz.
    Slower(f64),
    /// Those suspected come at this higher rate, in Hz.
    Faster(f64),
    /// Those suspected come at this rate in Hz, which no sensor has.
    TooFast(f64),
}

/// Lags that are a loss if they stand.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    /// When the first held line was due.
    first_due_s: f64,
    least_lag_s: f64,
    most_lag_s: f64,
    /// Since which stamp, and which place among the held lines, the least lag has not fallen, and
    /// reads since then.
    stands_since_s: f64,
    stands_since: usize,
    reads: usize,
}

/// Judges lines at one rate, in order.
#[derive(Clone, Debug)]
pub(super) struct Placer {
    rates_hz: &'static [f64],
    period_s: f64,
    /// When the next line to be judged is due, at the earliest.
    due_s: f64,
    /// Stamps of the lines without a place; the first `judged` of them are in doubt.
    held: VecDeque<f64>,
    judged: usize,
    doubt: Option<Doubt>,
    /// The present block: its lines, first stamp and least lag.
    block_lines: u64,
    block_start_s: f64,
    block_least_s: f64,
    /// Lines were lost in it.
    lost_in_block: bool,
    /// How early lines may come after a loss without being taken for the new earliest: they show
    /// that the loss was counted one too large, and the next one is counted less.
    overcount_s: f64,
    /// Place in the stream of the next line, lost lines included.
    index: u64,
    envelope: Envelope,
    /// Due times follow the fitted rate, not the nominal one.
    follow_fit: bool,
    reads: Reads,
    /// The greatest lag of late that was no loss.
    late_s: f64,
    /// Lines that have a place unless the rate is higher.
    suspicion: Option<Box<Suspicion>>,
}

impl Placer {
    /// Judges lines from the one due at `due_s`.
    pub(super) fn new(rates_hz: &'static [f64], placing: Placing, due_s: f64) -> Self {
        let period_s = placing.hz().recip();
        Self {
            rates_hz,
            period_s,
            due_s,
            held: VecDeque::new(),
            judged: 0,
            doubt: None,
            block_lines: 0,
            block_start_s: due_s,
            block_least_s: f64::INFINITY,
            lost_in_block: false,
            overcount_s: 0.0,
            index: 0,
            envelope: Envelope::new(period_s),
            // A fit counts the losses seen so far; following it would feed their errors back.
            follow_fit: matches!(placing, Placing::Measured(_)),
            late_s: 0.0,
            reads: Reads::new(period_s),
            suspicion: None,
        }
    }

    /// Adds a line's stamp, not before the one before. Then [`judge`](Self::judge) until there is
    /// no verdict.
    pub(super) fn push(&mut self, at_s: f64) {
        self.reads.push(at_s);
        self.held.push_back(at_s);
    }

    /// The next verdict; none while the lines held are in doubt, or suspected.
    pub(super) fn judge(&mut self) -> Option<Verdict> {
        loop {
            let decision = match self.judge_lag()? {
                Verdict::Placed(decision) => decision,
                change => return Some(change),
            };
            let Some(suspicion) = &mut self.suspicion else {
                return Some(Verdict::Placed(decision));
            };
            match suspicion.keep(decision) {
                Outcome::Open => {}
                Outcome::Cleared => return Some(Verdict::Changed(Change::Cleared(self.clear_suspicion()))),
                Outcome::Faster(to_hz) => return Some(Verdict::Changed(Change::Faster(to_hz))),
                Outcome::TooFast(measured_hz) => return Some(Verdict::Changed(Change::TooFast(measured_hz))),
            }
        }
    }

    /// The verdict on the next lines by their lag alone.
    fn judge_lag(&mut self) -> Option<Verdict> {
        while let Some(&at_s) = self.held.get(self.judged) {
            let lag_s = at_s - self.due_s;
            if lag_s < self.doubt_s() {
                return Some(Verdict::Placed(self.settle(at_s, lag_s)));
            }
            if let Some(verdict) = self.hold(at_s, lag_s) {
                return Some(verdict);
            }
        }
        None
    }

    /// The decision on lines in doubt behind which none follow: lost is what bunching cannot delay.
    pub(super) fn finish(&mut self) -> Option<Placed> {
        let doubt = self.doubt?;
        let last_lag_s = self.held.back()? - (self.due_s - self.period_s);
        if self.is_steady() || last_lag_s >= self.doubt_s() + self.reads.window_s() {
            return Some(self.lose(doubt));
        }
        Some(Placed::Lines(self.take_held().len() as u64))
    }

    /// The clock goes back here: places the lines that wait, without a loss, and tells when the
    /// next one is due.
    pub(super) fn resume(&mut self) -> (Vec<Placed>, f64) {
        let mut decisions = self.clear_suspicion();
        let lines = self.take_held().len() as u64;
        if lines > 0 {
            decisions.push(Placed::Lines(lines));
        }
        self.index += lines;
        (decisions, self.due_s)
    }

    /// Hands back the lines without a place.
    pub(super) fn take_held(&mut self) -> VecDeque<f64> {
        self.doubt = None;
        self.judged = 0;
        std::mem::take(&mut self.held)
    }

    /// The decisions on the lines suspected hold.
    pub(super) fn clear_suspicion(&mut self) -> Vec<Placed> {
        self.suspicion.take().map_or_else(Vec::new, |suspicion| suspicion.into_decisions())
    }

    /// The decisions on the lines before the rate changed to `to_hz`, a higher one, and the stamps
    /// of those after.
    pub(super) fn split(&mut self, to_hz: f64) -> (Vec<Placed>, Vec<f64>) {
        let (before, mut after_s) =
            self.suspicion.take().map_or_else(Default::default, |suspicion| suspicion.split(to_hz));
        after_s.extend(self.take_held());
        (before, after_s)
    }

    /// Lines held or suspected.
    pub(super) fn waiting(&self) -> usize {
        self.held.len() + self.suspicion.as_ref().map_or(0, |suspicion| suspicion.lines())
    }

    /// Period of the fitted rate, once some blocks of lines are in.
    pub(super) const fn fitted_period_s(&self) -> Option<f64> {
        self.envelope.fitted_period_s()
    }

    /// The same without the lines suspected.
    pub(super) fn fitted_unsuspected_s(&self) -> Option<f64> {
        self.suspicion.as_ref().map_or(self.fitted_period_s(), |suspicion| suspicion.fitted_before_s())
    }

    /// A line that is late shows a loss.
    fn is_steady(&self) -> bool {
        self.late_s <= STEADY_PERIODS * self.period_s
    }

    /// Lag from which a line is in doubt.
    fn doubt_s(&self) -> f64 {
        let periods = if self.reads.may_jump() { JUMPY_DOUBT_PERIODS } else { DOUBT_PERIODS };
        periods * self.period_s
    }

    /// The line at `judged` has its place, and so have those held before it.
    fn settle(&mut self, at_s: f64, lag_s: f64) -> Placed {
        let most_lag_s = self.doubt.take().map_or(lag_s, |doubt| doubt.most_lag_s);
        self.late_s = most_lag_s.max(LATE_KEPT * self.late_s);
        let lines = self.judged + 1;
        self.due_s += self.period_s;
        if lag_s < -self.overcount_s {
            let early_s = -self.overcount_s - lag_s;
            self.suspect(at_s, early_s, lines);
            self.due_s -= early_s;
            self.block_least_s = -self.overcount_s;
        } else {
            self.block_least_s = self.block_least_s.min(lag_s);
        }
        self.judged = 0;
        if let Some(suspicion) = &mut self.suspicion {
            let all_late = suspicion.early_s() > EARLY_PERIODS * self.period_s;
            let window_s = self.reads.window_s();
            self.held.drain(..lines).for_each(|at_s| suspicion.push(at_s, window_s));
            if all_late {
                self.envelope.restart();
            }
        } else if lines == 1 {
            self.held.pop_front();
        } else {
            self.held.drain(..lines);
        }
        self.index += lines as u64;
        self.fit(at_s);
        self.block_lines += lines as u64;
        if self.block_lines >= BLOCK_LINES && at_s - self.block_start_s >= self.reads.window_s() {
            self.end_block(at_s);
        }
        Placed::Lines(lines as u64)
    }

    /// The line to be settled, with those in doubt before it, is the earliest by `early_s`; it was
    /// due a period ago.
    #[cold]
    fn suspect(&mut self, at_s: f64, early_s: f64, lines: usize) {
        let suspicious = early_s > SUSPECT_PERIODS * self.period_s;
        if suspicious && self.suspicion.is_none() {
            let before_s = self.due_s - (lines + 1) as f64 * self.period_s;
            self.suspicion =
                Some(Box::new(Suspicion::new(self.rates_hz, self.period_s, before_s, self.fitted_period_s())));
        }
        if let Some(suspicion) = &mut self.suspicion {
            suspicion.add_early(early_s);
            if suspicious {
                suspicion.note_early(at_s);
            }
        }
    }

    /// The due time follows the least lag of the block. A loss counted too much stays owed, until a
    /// block without a loss shows that none was.
    fn end_block(&mut self, at_s: f64) {
        let owed = self.block_least_s < -0.5 * self.overcount_s;
        if !owed && !self.lost_in_block {
            self.overcount_s = 0.0;
        }
        self.due_s += self.block_least_s + if owed { self.overcount_s } else { 0.0 };
        self.lost_in_block = false;
        self.block_lines = 0;
        self.block_start_s = at_s;
        self.block_least_s = f64::INFINITY;
    }

    /// Lines held before they were placed were late: only a line placed at once may lie on the
    /// envelope.
    fn fit(&mut self, at_s: f64) {
        let fit_is_new = self.envelope.push(self.index, at_s);
        if fit_is_new && self.follow_fit {
            self.period_s = self.envelope.credible_period_s();
        }
    }

    /// The line at `judged` is in doubt; the verdict, once the least lag has stood.
    #[cold]
    fn hold(&mut self, at_s: f64, lag_s: f64) -> Option<Verdict> {
        let place = self.judged;
        self.judged += 1;
        let doubt = self.doubt.get_or_insert(Doubt {
            first_due_s: self.due_s,
            least_lag_s: lag_s,
            most_lag_s: lag_s,
            stands_since_s: at_s,
            stands_since: place,
            reads: 0,
        });
        self.due_s += self.period_s;
        if place > 0 && self.reads.are_apart(self.held[place - 1], at_s) {
            doubt.reads += 1;
        }
        let stood_lines = place - doubt.stands_since;
        let fall_s = FALLING_PERIODS * self.period_s * stood_lines as f64;
        if lag_s < doubt.least_lag_s - fall_s {
            doubt.stands_since_s = at_s;
            doubt.stands_since = place;
            doubt.reads = 0;
        }
        doubt.least_lag_s = doubt.least_lag_s.min(lag_s);
        doubt.most_lag_s = doubt.most_lag_s.max(lag_s);
        let doubt = *doubt;
        let stood_s = at_s - doubt.stands_since_s;
        let stands = doubt.reads >= DOUBT_READS && stood_s >= self.reads.window_s();
        if !stands && self.held.len() < MAX_HELD {
            return None;
        }
        if let Some(slower_hz) = self.slower() {
            return (self.judged >= SLOWER_LINES).then_some(Verdict::Changed(Change::Slower(slower_hz)));
        }
        Some(Verdict::Placed(self.lose(doubt)))
    }

    /// Lines are lost before the first held; the held ones are judged anew.
    fn lose(&mut self, doubt: Doubt) -> Placed {
        // Over a long pause a small error of the period counts.
        let period_s = self.envelope.credible_period_s();
        let missing = (doubt.least_lag_s / period_s + (1.0 - DOUBT_PERIODS)).floor();
        // A lag of exactly the threshold may round down.
        let missing = missing.max(1.0);
        self.doubt = None;
        self.due_s = doubt.first_due_s + missing * period_s;
        self.judged = 0;
        self.overcount_s = self.period_s;
        // The lags on both sides of it are comparable only where lines come steadily.
        self.lost_in_block = self.is_steady();
        if !self.lost_in_block {
            self.block_lines = 0;
            self.block_least_s = f64::INFINITY;
        }
        self.index += missing as u64;
        Placed::Gap { missing: missing as u64 }
    }

    /// The lower rate of the sensor at which the judged lines came, if three in four intervals fit
    /// it.
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
