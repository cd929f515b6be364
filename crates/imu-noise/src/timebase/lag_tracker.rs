//! Detects gaps at a known rate, by the lag of each sample: its arrival less the time when it was
//! due.

use std::collections::VecDeque;

use super::envelope::Envelope;
use super::gap_event::GapEvent;
use super::judgement::{CONFIRMATIONS, Judgement};
use super::rate_estimates::{LISTED_TOLERANCE, RUN, WHOLE_TOLERANCE, snap};
use super::rate_increase::SuspectedIncrease;
use super::rate_search::TrackedRate;
use super::read_pattern::ReadPattern;

/// Lag in periods from which a sample is in doubt: above 0.76, by which the phase of a host was
/// seen to shift, and below 0.88, the fraction of a period that remained at the end of a real
/// pause. Between these, only streams that drop every fourth sample depend on the value.
const DOUBT_PERIODS: f64 = 0.82;

/// The same lag where the phase of the reads may jump by a period, see [`ReadPattern::may_jump`].
const JUMPY_DOUBT_PERIODS: f64 = 1.0 + DOUBT_PERIODS;

/// Decrease of the least lag, in periods per sample, above which it is not steady: the reader
/// catches up with a backlog, or its reads drift relative to the samples. No clock is off by 4000
/// ppm.
const FALLING_PERIODS: f64 = 0.004;

/// The most pending samples in doubt, 5 min at 200 Hz: a longer stall counts as a gap.
const MAX_PENDING: usize = 65_536;

/// Factor per sample by which the greatest recent lag decays, so that it is remembered for some
/// thousand samples.
const LATE_DECAY: f64 = 0.999;

/// Greatest recent lag in periods of a stream whose samples arrive steadily. Chosen.
const STEADY_PERIODS: f64 = 0.3;

/// The number of samples after which the due time follows the least lag among them. Chosen.
const BLOCK_LEN: u64 = 16;

/// A sample that is early by this many periods shows that all samples before it were late: a jump
/// of the phase is one period only.
const ALL_LATE_PERIODS: f64 = 4.0;

/// A sample that is early by this many periods raises the suspicion of a higher rate: half of the
/// amount by which each sample is early at the next rate of the sensor (1.25 times as high).
const SUSPICIOUS_PERIODS: f64 = 0.1;

/// Samples that are early by this many periods or more move the due time only if there are
/// [`FAR_EARLY_SAMPLES`] of them in [`CONFIRMATIONS`] decisions: fewer may be those that end with a
/// full packet of a USB adapter, one in 31 or 62 and at times a few more, while the ends of the
/// others wait for the sample after. Chosen: where the due time follows one that is early by
/// less, and then another one, the others are still not in doubt behind them.
const FAR_EARLY_PERIODS: f64 = 0.3;
const FAR_EARLY_SAMPLES: usize = 4;

/// A lower rate is below the present one by at least this factor. Chosen.
const LOWER: f64 = 0.9;

/// Lags that are a gap if they persist.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    /// When the first pending sample was due.
    first_due_s: f64,
    least_lag_s: f64,
    most_lag_s: f64,
    /// Time and place of the pending sample since which the least lag has not decreased, and the
    /// number of reads since then.
    steady_since_s: f64,
    steady_since: usize,
    reads: usize,
}

/// Samples early by [`FAR_EARLY_PERIODS`] or more.
#[derive(Clone, Copy, Debug, Default)]
struct FarEarly {
    samples: usize,
    /// The number of decisions from the first of them on, or since the last one once there are
    /// [`FAR_EARLY_SAMPLES`].
    decisions: usize,
    /// The part of their earliness that an increase has counted, but the due time has not followed.
    counted_s: f64,
}

#[derive(Clone, Debug)]
pub(super) struct LagTracker {
    rates_hz: &'static [f64],
    period_s: f64,
    /// The earliest time at which the next sample to be judged is due.
    due_s: f64,
    /// Stamps of the pending samples; the first `judged` of them are in doubt.
    pending: VecDeque<f64>,
    judged: usize,
    doubt: Option<Doubt>,
    /// The present block: its samples, first stamp, least lag, and whether it has a gap.
    block_samples: u64,
    block_start_s: f64,
    block_least_s: f64,
    block_has_gap: bool,
    /// How early samples may arrive after a gap: where the gap was counted one sample too large,
    /// the next gap is one smaller.
    overcount_s: f64,
    /// Index in the stream of the next sample, dropped ones counted.
    index: u64,
    pub(super) envelope: Envelope,
    /// The recent samples that were far early.
    far_early: Option<FarEarly>,
    /// Whether due times follow the fitted rate instead of the nominal one.
    follows_fit: bool,
    reads: ReadPattern,
    /// The greatest recent lag that was no gap.
    late_s: f64,
    increase: Option<Box<SuspectedIncrease>>,
}

impl LagTracker {
    pub(super) fn new(rates_hz: &'static [f64], rate: TrackedRate, due_s: f64) -> Self {
        let period_s = rate.hz().recip();
        Self {
            rates_hz,
            period_s,
            due_s,
            pending: VecDeque::new(),
            judged: 0,
            doubt: None,
            block_samples: 0,
            block_start_s: due_s,
            block_least_s: f64::INFINITY,
            block_has_gap: false,
            overcount_s: 0.0,
            far_early: None,
            index: 0,
            envelope: Envelope::new(period_s),
            // a fit counts the gaps so far: following it would feed their errors back
            follows_fit: matches!(rate, TrackedRate::Measured(_)),
            late_s: 0.0,
            reads: ReadPattern::new(period_s),
            increase: None,
        }
    }

    /// Adds a sample that is not earlier than the one before. Then [`judge`](Self::judge) until it
    /// gives `None`.
    pub(super) fn push(&mut self, at_s: f64) {
        self.reads.push(at_s);
        self.pending.push_back(at_s);
    }

    /// The next judgement; `None` while pending samples are in doubt or an increase is suspected.
    pub(super) fn judge(&mut self) -> Option<Judgement> {
        loop {
            match (self.judge_lag()?, &mut self.increase) {
                (Judgement::Event(event), Some(increase)) => {
                    if let Some(judgement) = increase.hold(event) {
                        return Some(judgement);
                    }
                }
                (judgement, _) => return Some(judgement),
            }
        }
    }

    /// Judges the next sample by its lag alone.
    fn judge_lag(&mut self) -> Option<Judgement> {
        while let Some(&at_s) = self.pending.get(self.judged) {
            let lag_s = at_s - self.due_s;
            if lag_s < self.doubt_s() {
                return Some(Judgement::Event(self.settle(at_s, lag_s)));
            }
            if let Some(judgement) = self.hold(at_s, lag_s) {
                return Some(judgement);
            }
        }
        None
    }

    /// The decision if no sample follows: a gap where samples arrive steadily, else the part of the
    /// lag that bunching cannot explain.
    pub(super) fn finish(&mut self) -> Option<GapEvent> {
        let doubt = self.doubt?;
        let last_lag_s = self.pending.back()? - (self.due_s - self.period_s);
        if self.is_steady() || last_lag_s >= self.doubt_s() + self.reads.window_s {
            return Some(self.gap(doubt));
        }
        Some(GapEvent::Samples(self.take_pending().len() as u64))
    }

    /// Ends the present clock. Returns the number of pending samples, without a gap before them,
    /// and when the next sample is due.
    pub(super) fn restart_clock(&mut self) -> (u64, f64) {
        let samples = self.take_pending().len() as u64;
        self.index += samples;
        (samples, self.due_s)
    }

    /// The events that were pending because of a suspected increase, which has not happened.
    pub(super) fn clear_increase(&mut self) -> Vec<GapEvent> {
        self.increase.take().map_or_else(Vec::new, |increase| increase.events)
    }

    /// The events before the rate changed to `to_hz`, and the stamps of the samples after.
    pub(super) fn split(&mut self, to_hz: f64) -> (Vec<GapEvent>, Vec<f64>) {
        let (before, mut after_s) =
            self.increase.take().map_or_else(Default::default, |increase| increase.split(to_hz));
        after_s.extend(self.take_pending());
        (before, after_s)
    }

    pub(super) fn samples_pending(&self) -> usize {
        self.pending.len() + self.increase.as_ref().map_or(0, |increase| increase.stamps_s.len())
    }

    /// The fitted period without the samples of a suspected increase.
    pub(super) fn fitted_before_increase_s(&self) -> Option<f64> {
        self.increase.as_ref().map_or(self.envelope.fitted_period_s, |increase| increase.fitted_before_s)
    }

    fn take_pending(&mut self) -> VecDeque<f64> {
        self.doubt = None;
        self.judged = 0;
        std::mem::take(&mut self.pending)
    }

    /// Whether a late sample shows a gap.
    fn is_steady(&self) -> bool {
        self.late_s <= STEADY_PERIODS * self.period_s
    }

    fn doubt_s(&self) -> f64 {
        let periods = if self.reads.may_jump() { JUMPY_DOUBT_PERIODS } else { DOUBT_PERIODS };
        periods * self.period_s
    }

    /// Decides that the sample at `judged` has no gap before it, and neither have the pending ones
    /// before it.
    fn settle(&mut self, at_s: f64, lag_s: f64) -> GapEvent {
        let most_lag_s = self.doubt.take().map_or(lag_s, |doubt| doubt.most_lag_s);
        self.late_s = most_lag_s.max(LATE_DECAY * self.late_s);
        let samples = self.judged + 1;
        self.due_s += self.period_s;
        let early_s = f64::max(0.0, -self.overcount_s - lag_s);
        let counted_s = self.far_early.map_or(0.0, |far_early| far_early.counted_s);
        if early_s > counted_s {
            self.add_early(at_s, early_s - counted_s, samples);
        }
        if self.is_far_early_alone(lag_s, early_s) {
            // all the others are late
            self.late_s = self.late_s.max(-lag_s);
        } else {
            self.due_s -= early_s;
            self.block_least_s = self.block_least_s.min(lag_s) + early_s;
        }
        self.judged = 0;
        if let Some(increase) = &mut self.increase {
            let all_late = increase.early_s > ALL_LATE_PERIODS * self.period_s;
            let window_s = self.reads.window_s;
            self.pending.drain(..samples).for_each(|at_s| increase.push(at_s, window_s));
            if all_late {
                self.envelope.restart();
            }
        } else if samples == 1 {
            self.pending.pop_front();
        } else {
            self.pending.drain(..samples);
        }
        self.index += samples as u64;
        // samples that were pending in doubt were late: only the last of them may be on the
        // envelope
        let is_new_fit = self.envelope.push(self.index, at_s);
        if is_new_fit && self.follows_fit {
            self.period_s = self.envelope.credible_period_s();
        }
        self.block_samples += samples as u64;
        let has_least = self.block_least_s < f64::INFINITY;
        if has_least && self.block_samples >= BLOCK_LEN && at_s - self.block_start_s >= self.reads.window_s {
            self.end_block(at_s);
        }
        GapEvent::Samples(samples as u64)
    }

    /// Whether the decided sample is far early and too few others were: then the due time does not
    /// follow it. `early_s` is the time by which it would.
    fn is_far_early_alone(&mut self, lag_s: f64, early_s: f64) -> bool {
        let is_far_early = lag_s < -FAR_EARLY_PERIODS * self.period_s;
        if self.far_early.is_none() && !is_far_early {
            return false;
        }
        let far_early = self.far_early.get_or_insert_default();
        far_early.decisions += 1;
        far_early.samples += usize::from(is_far_early);
        let is_alone = is_far_early && far_early.samples < FAR_EARLY_SAMPLES;
        if is_alone {
            far_early.counted_s = far_early.counted_s.max(early_s);
        } else {
            far_early.counted_s = f64::max(0.0, far_early.counted_s - early_s);
            if is_far_early {
                far_early.decisions = 0;
            }
        }
        if far_early.decisions >= CONFIRMATIONS {
            self.far_early = None;
        }
        is_alone
    }

    /// Adds early samples: the last of `samples` decided ones is the earliest, by `early_s`; it was
    /// due a period ago.
    #[cold]
    fn add_early(&mut self, at_s: f64, early_s: f64, samples: usize) {
        let is_suspicious = early_s > SUSPICIOUS_PERIODS * self.period_s;
        if is_suspicious && self.increase.is_none() {
            let due_before_s = self.due_s - (samples + 1) as f64 * self.period_s;
            let fitted_s = self.envelope.fitted_period_s;
            let increase = SuspectedIncrease::new(self.rates_hz, self.period_s, due_before_s, fitted_s);
            self.increase = Some(Box::new(increase));
        }
        if let Some(increase) = &mut self.increase {
            increase.add_early(at_s, early_s, is_suspicious);
        }
    }

    /// Ends a block: the due time follows the least lag. A gap that was counted too large is
    /// corrected in the next block without a gap.
    fn end_block(&mut self, at_s: f64) {
        let is_owed = self.block_least_s < -0.5 * self.overcount_s;
        if !is_owed && !self.block_has_gap {
            self.overcount_s = 0.0;
        }
        self.due_s += self.block_least_s + if is_owed { self.overcount_s } else { 0.0 };
        self.block_has_gap = false;
        self.block_samples = 0;
        self.block_start_s = at_s;
        self.block_least_s = f64::INFINITY;
    }

    /// Keeps the sample at `judged` in doubt. Returns the judgement once the least lag is steady.
    #[cold]
    fn hold(&mut self, at_s: f64, lag_s: f64) -> Option<Judgement> {
        let place = self.judged;
        self.judged += 1;
        let doubt = self.doubt.get_or_insert(Doubt {
            first_due_s: self.due_s,
            least_lag_s: lag_s,
            most_lag_s: lag_s,
            steady_since_s: at_s,
            steady_since: place,
            reads: 0,
        });
        self.due_s += self.period_s;
        if place > 0 && self.reads.are_apart(self.pending[place - 1], at_s) {
            doubt.reads += 1;
        }
        let fall_s = FALLING_PERIODS * self.period_s * (place - doubt.steady_since) as f64;
        if lag_s < doubt.least_lag_s - fall_s {
            doubt.steady_since_s = at_s;
            doubt.steady_since = place;
            doubt.reads = 0;
        }
        doubt.least_lag_s = doubt.least_lag_s.min(lag_s);
        doubt.most_lag_s = doubt.most_lag_s.max(lag_s);
        let doubt = *doubt;
        let is_steady = doubt.reads >= CONFIRMATIONS && at_s - doubt.steady_since_s >= self.reads.window_s;
        if !is_steady && self.pending.len() < MAX_PENDING {
            return None;
        }
        match self.lower_rate() {
            Some(lower_hz) => (self.judged >= RUN).then_some(Judgement::Decreased(lower_hz)),
            None => Some(Judgement::Event(self.gap(doubt))),
        }
    }

    fn gap(&mut self, doubt: Doubt) -> GapEvent {
        // over a long pause a small error of the period has an effect
        let period_s = self.envelope.credible_period_s();
        let missing = (doubt.least_lag_s / period_s + (1.0 - DOUBT_PERIODS)).floor();
        // A lag of exactly the threshold may round down.
        let missing = missing.max(1.0);
        self.doubt = None;
        self.due_s = doubt.first_due_s + missing * period_s;
        self.judged = 0;
        self.overcount_s = self.period_s;
        // the lags before and after the gap are comparable only where samples arrive steadily
        self.block_has_gap = self.is_steady();
        if !self.block_has_gap {
            self.block_samples = 0;
            self.block_least_s = f64::INFINITY;
        }
        self.index += missing as u64;
        GapEvent::Missing(missing as u64)
    }

    /// The lower rate of the sensor at which three in four intervals of the judged samples are.
    fn lower_rate(&self) -> Option<f64> {
        let last = self.judged.checked_sub(1)?;
        let span_s = self.pending[last] - self.pending[0];
        let lower_hz = snap(self.rates_hz, last as f64 / span_s, LISTED_TOLERANCE)?;
        if lower_hz * self.period_s > LOWER {
            return None;
        }
        let judged = self.pending.iter().take(self.judged);
        let intervals_s = judged.clone().skip(1).zip(judged).map(|(later, earlier)| later - earlier);
        let single = intervals_s.filter(|interval_s| (interval_s * lower_hz - 1.0).abs() < WHOLE_TOLERANCE);
        (4 * single.count() >= 3 * last).then_some(lower_hz)
    }
}
