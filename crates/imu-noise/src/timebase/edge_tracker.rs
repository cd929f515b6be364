//! Gaps at a known period, by the lag of each sample: its arrival minus the time when it was due
//! according to the lower edge of the arrivals.

use std::collections::VecDeque;

use super::envelope::Envelope;
use super::sensor_rates::{RUN, SensorRates};
use super::{gap_event::GapEvent, interval_statistics::TOGETHER_PERIODS};

/// Lag in periods from which a sample is in doubt: above 0.76, an observed shift of the phase of a
/// host, and below 0.88, the part of a period that remained at the end of a real pause.
const LATE_PERIODS: f64 = 0.82;

/// Periods by which a sample must be early to be in doubt: half of the amount by which each sample
/// is early at the next rate of a sensor (1.25 times as high).
const EARLY_PERIODS: f64 = 0.1;

/// Reads, or samples, after which a doubt is decided if none contradicts it. Chosen.
const CONFIRMATIONS: usize = 12;

/// The time that must pass as well: twice the longest usual bunching (USB adapters collect for
/// 16 ms, slow readers up to 50 ms). It grows if a doubt lasted longer and was cleared.
const WINDOW_S: f64 = 0.1;
const LONGEST_WINDOW_S: f64 = 4.0;

/// Decrease of the least lag, in periods per sample, above which it is not steady: the reader
/// catches up, or its reads drift relative to the samples. No clock is off by 4000 ppm.
const FALLING_PERIODS: f64 = 0.004;

/// A few samples that are early by more than this, and by less than a period, end with a full
/// packet of a USB adapter, one in 31 or 62, while the ends of the others wait for the next sample.
/// The edge follows if [`EDGE_SAMPLES`] of [`CONFIRMATIONS`] samples are that early.
const FAR_EARLY_PERIODS: f64 = 0.3;
const EDGE_SAMPLES: usize = 4;

/// The number of reads over which their pattern is averaged, and the tolerance for a time between
/// reads that is a multiple of the period. Chosen.
const AVERAGED_READS: f64 = 32.0;
const JUMPY_PERIODS: f64 = 0.1;

/// The number of samples after which the edge follows the least lag among them, at most by this
/// many periods per sample if they do not arrive steadily. Chosen.
const BLOCK_LEN: u64 = 16;
const FOLLOWED_PERIODS: f64 = 0.001;
const TIGHT_PERIODS: f64 = 0.42;

/// Samples that are early by this many periods show that all samples before them were late. Chosen.
const ALL_LATE_PERIODS: f64 = 4.0;

/// For any sensor, the lag in periods from which the local step is longer than expected, and the most
/// periods by which a sample may be longer. Chosen.
const DRIFTED_PERIODS: f64 = 0.25;
const DRIFT_PERIODS: f64 = 0.05;

/// The most missing samples whose number is exact for any rounding of the period.
const SHORT_GAP: f64 = 16.0;

/// The most samples in doubt, 5 min at 200 Hz: a longer stall counts as a gap.
const MOST_IN_DOUBT: usize = 65_536;

/// Factor per sample by which the greatest recent lag, and the window, decay.
const DECAY: f64 = 0.999;

/// A decision on the first pending samples.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Decision {
    /// Samples without a gap before them, or the samples that are missing before the first one.
    Gap(GapEvent),
    /// The pending samples arrive at this rate in Hz, which differs from that of the tracker.
    OtherRate(f64),
}

/// The pattern of the host's reads: averages over the latest ones.
#[derive(Clone, Copy, Debug, Default)]
struct Reads {
    previous_s: f64,
    /// The end of the last read but one, and the samples after it.
    ended_s: Option<f64>,
    samples: u64,
    /// The number of averaged reads, the time between two, and the share of reads with several samples.
    reads: f64,
    interval_s: f64,
    several: f64,
}

impl Reads {
    fn push(&mut self, at_s: f64, period_s: f64) {
        if at_s - self.previous_s >= TOGETHER_PERIODS * period_s && self.samples > 0 {
            let several = f64::from(u8::from(self.samples > 1));
            let ended_s = self.ended_s.replace(self.previous_s).unwrap_or(f64::NEG_INFINITY);
            if ended_s.is_finite() {
                self.reads = (self.reads + 1.0).min(AVERAGED_READS);
                self.several += (several - self.several) / self.reads;
                self.interval_s += (self.previous_s - ended_s - self.interval_s) / self.reads;
            }
            self.samples = 0;
        }
        self.previous_s = at_s;
        self.samples += 1;
    }

    /// Whether most reads return several samples, at about a multiple of the period: the phase
    /// between reads and samples drifts then, and jumps by a period.
    fn may_jump(&self, period_s: f64) -> bool {
        let periods = self.interval_s / period_s;
        self.several > 0.5 && (periods - periods.round()).abs() < JUMPY_PERIODS
    }
}

/// Samples that are late or early, until others show the reason.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    is_early: bool,
    /// The time when the first sample in doubt was due.
    first_due_s: f64,
    /// The least and the greatest lag.
    least_s: f64,
    most_s: f64,
    /// The sample in doubt since which the least lag has not decreased, its time, and the reads since.
    steady_from: usize,
    steady_s: f64,
    reads: usize,
}

#[derive(Clone, Debug, Default)]
pub(super) struct EdgeTracker {
    /// The rates to which the sensor may change; `None` if another part examines its steps.
    rates: Option<SensorRates>,
    pub(super) period_s: f64,
    /// Whether the period comes from few samples, and follows the fit to all of them.
    pub(super) follows_fit: bool,
    /// The earliest time when the next sample to be judged is due.
    due_s: f64,
    pending: VecDeque<f64>,
    /// The number of pending samples in doubt, which are the first ones.
    judged: usize,
    doubt: Option<Doubt>,
    /// The time by which samples may come early after a gap that was counted too large.
    owed_s: f64,
    /// The possible jump of the phase of the arrivals, if their reads do not show it.
    pub(super) jump_s: f64,
    reads: Reads,
    /// The shortest time of a doubt.
    window_s: f64,
    /// The present block: its samples, first time, least and greatest lag.
    block: (u64, f64, f64, f64),
    /// The greatest recent lag that was no gap, and the least one.
    late_s: f64,
    recent_s: f64,
    /// Index of the next sample, including dropped ones.
    index: u64,
    /// Number of decided samples.
    pub(super) settled: u64,
    /// The time of the last decided sample; `last_s` is `None` after a long gap.
    previous_s: f64,
    last_s: Option<f64>,
    /// The number of intervals without a long gap, dropped samples included, and their sum.
    pub(super) even: (u64, f64),
    /// Decided samples after the last one whose stamp differs from that before.
    together: u64,
    /// Number of samples at the beginning that arrived together, after they were due.
    pub(super) flushed: u64,
    pub(super) envelope: Envelope,
}

impl EdgeTracker {
    /// A tracker of samples at this rate, the first one due at `due_s`.
    pub(super) fn new(rates: Option<SensorRates>, hz: f64, due_s: f64) -> Self {
        let period_s = hz.recip();
        Self {
            rates,
            period_s,
            due_s,
            window_s: WINDOW_S,
            block: (0, due_s, f64::INFINITY, 0.0),
            previous_s: f64::NEG_INFINITY,
            envelope: Envelope::new(period_s),
            ..Self::default()
        }
    }

    /// Adds a sample that is not earlier than the one before.
    pub(super) fn push(&mut self, at_s: f64) {
        self.reads.push(at_s, self.period_s);
        self.pending.push_back(at_s);
    }

    /// Takes the times of all undecided samples.
    pub(super) fn take_pending(&mut self) -> Vec<f64> {
        self.doubt = None;
        self.judged = 0;
        std::mem::take(&mut self.pending).into()
    }

    /// Ends the present clock. Returns the pending samples, and when the next one is due.
    pub(super) fn restart_clock(&mut self) -> (u64, f64) {
        let pending = self.take_pending().len() as u64;
        self.index += pending;
        self.last_s = None;
        (pending, self.due_s)
    }

    /// The next decision; `None` while the first pending sample is in doubt.
    pub(super) fn decide(&mut self) -> Option<Decision> {
        while let Some(&at_s) = self.pending.get(self.judged) {
            let lag_s = at_s - self.due_s;
            let jump_s = if self.reads.may_jump(self.period_s) { self.period_s } else { self.jump_s };
            let is_late = lag_s >= LATE_PERIODS * self.period_s + jump_s;
            let is_early = lag_s < -EARLY_PERIODS * self.period_s - self.owed_s;
            let Some(doubt) = &self.doubt else {
                if !is_late && !is_early {
                    return Some(self.settle(1, lag_s));
                }
                self.begin_doubt(at_s, lag_s, is_early);
                continue;
            };
            if !doubt.is_early && !is_late {
                // the samples before this one were late
                if doubt.steady_s < at_s {
                    self.window_s = self.window_s.max(2.0 * (at_s - self.pending[0])).min(LONGEST_WINDOW_S);
                }
                self.late_s = self.late_s.max(doubt.most_s);
                self.block.3 = self.block.3.max(doubt.most_s);
                return Some(self.drop(self.judged));
            }
            if let Some(decision) = self.add_to_doubt(at_s, lag_s) {
                return Some(decision);
            }
        }
        None
    }

    /// The decision if no sample follows: a gap if samples arrive steadily, else the part of the
    /// lag that bunching cannot explain.
    pub(super) fn finish(&mut self) -> Option<Decision> {
        let mut doubt = self.doubt?;
        if doubt.is_early
            && let judged = self.in_doubt().collect::<Vec<_>>()
            && let Some(hz) = self.rates.and_then(|rates| rates.too_fast(&judged))
        {
            return Some(Decision::OtherRate(hz));
        }
        let last_lag_s = self.pending.back()? - (self.due_s - self.period_s);
        let late_s = if self.late_s > FAR_EARLY_PERIODS * self.period_s { self.late_s } else { 0.0 };
        doubt.least_s = doubt.least_s.min(last_lag_s - late_s);
        if !doubt.is_early && doubt.least_s >= LATE_PERIODS * self.period_s {
            return Some(self.gap(doubt));
        }
        Some(self.end_early(doubt, self.judged))
    }

    fn begin_doubt(&mut self, at_s: f64, lag_s: f64, is_early: bool) {
        self.doubt = Some(Doubt {
            is_early,
            first_due_s: self.due_s,
            least_s: lag_s,
            most_s: lag_s,
            steady_from: 0,
            steady_s: at_s,
            reads: 0,
        });
        self.due_s += self.period_s;
        self.judged = 1;
    }

    #[cold]
    fn add_to_doubt(&mut self, at_s: f64, lag_s: f64) -> Option<Decision> {
        let place = self.judged;
        self.judged += 1;
        self.due_s += self.period_s;
        let is_apart = at_s - self.pending[place - 1] >= TOGETHER_PERIODS * self.period_s;
        let doubt = self.doubt.as_mut()?;
        doubt.reads += usize::from(is_apart);
        let falls = if doubt.is_early {
            lag_s < doubt.least_s - EARLY_PERIODS * self.period_s
        } else {
            lag_s < doubt.least_s - FALLING_PERIODS * self.period_s * (place - doubt.steady_from) as f64
        };
        if falls {
            (doubt.steady_from, doubt.steady_s, doubt.reads) = (place, at_s, 0);
        }
        doubt.least_s = doubt.least_s.min(lag_s);
        doubt.most_s = doubt.most_s.max(lag_s);
        let doubt = *doubt;
        let is_steady = doubt.reads >= CONFIRMATIONS && at_s - doubt.steady_s >= self.window_s;
        if doubt.is_early {
            let judged: Vec<f64> = if self.judged.is_multiple_of(RUN) { self.in_doubt().collect() } else { Vec::new() };
            return match self.rates.and_then(|rates| rates.higher(&judged, self.period_s)) {
                Some(hz) => Some(Decision::OtherRate(hz)),
                None => is_steady.then(|| self.end_early(doubt, doubt.steady_from + 1)),
            };
        }
        if !is_steady && self.judged < MOST_IN_DOUBT {
            return None;
        }
        let judged: Vec<f64> = self.in_doubt().collect();
        let is_unconfirmed = self.settled < RUN as u64;
        match self.rates.and_then(|rates| rates.lower(&judged, self.period_s, is_unconfirmed)) {
            Some(hz) => (self.judged >= RUN).then_some(Decision::OtherRate(hz)),
            None if self.is_drift(doubt) => {
                self.due_s = doubt.first_due_s + doubt.least_s;
                self.recent_s = 0.0;
                (self.doubt, self.judged) = (None, 0);
                None
            }
            None => Some(self.gap(doubt)),
        }
    }

    /// Whether the samples in doubt follow at about one local step, which was a little longer for a
    /// while: the lag of the samples before them has risen, and that of these is not much greater.
    fn is_drift(&self, doubt: Doubt) -> bool {
        let step_s = self.pending[0] - self.previous_s;
        let late_s = LATE_PERIODS * self.period_s + self.jump_s;
        // a step that is late by itself is a gap in any case
        let is_longer = self.recent_s > DRIFTED_PERIODS * self.period_s
            && doubt.least_s - self.recent_s < late_s
            && step_s - self.period_s < late_s;
        self.rates.is_none() && is_longer
    }

    fn in_doubt(&self) -> impl Iterator<Item = f64> {
        self.pending.iter().take(self.judged).copied()
    }

    /// Decides that the first `samples` have no gap before them; the last of them lags by `lag_s`.
    fn settle(&mut self, samples: usize, lag_s: f64) -> Decision {
        let at_s = self.pending[samples - 1];
        self.due_s += self.period_s;
        self.late_s = lag_s.max(DECAY * self.late_s);
        self.recent_s = lag_s.min(self.recent_s + DRIFT_PERIODS * self.period_s);
        self.window_s = (DECAY * self.window_s).max(WINDOW_S);
        if lag_s < 0.0 && self.owed_s == 0.0 {
            self.due_s += lag_s;
        }
        let (count, start_s, least_s, most_s) = &mut self.block;
        *least_s = least_s.min(lag_s);
        *most_s = most_s.max(lag_s);
        if *count >= BLOCK_LEN && at_s - *start_s >= self.window_s {
            self.end_block(at_s);
        }
        self.drop(samples)
    }

    /// Decides that the first `samples` have no gap before them.
    fn drop(&mut self, samples: usize) -> Decision {
        let at_s = self.pending[samples - 1];
        let with_last = self.pending.iter().take(samples).rev().take_while(|other| **other == at_s).count() as u64;
        self.previous_s = at_s;
        self.block.0 += samples as u64;
        self.pending.drain(..samples);
        self.index += samples as u64;
        self.settled += samples as u64;
        // samples with the stamp of the one before count with the next later stamp
        match self.last_s {
            Some(last_s) if at_s > last_s => {
                self.even.0 += std::mem::replace(&mut self.together, with_last - 1) + samples as u64 + 1 - with_last;
                self.even.1 += at_s - last_s;
                self.last_s = Some(at_s);
            }
            Some(_) => self.together += samples as u64,
            None => (self.last_s, self.together) = (Some(at_s), 0),
        }
        // samples that were in doubt were late: only the last of them may be on the envelope
        if self.envelope.push(self.index, at_s) && self.follows_fit {
            self.period_s = self.envelope.credible_period_s();
        }
        self.doubt = None;
        self.judged = 0;
        Decision::Gap(GapEvent::Samples(samples as u64))
    }

    /// Ends a doubt about early samples: those up to `samples` have no gap before them, and the
    /// edge follows unless too few were early.
    fn end_early(&mut self, doubt: Doubt, samples: usize) -> Decision {
        let from_s = |place: usize| doubt.first_due_s + place as f64 * self.period_s;
        let near_s = doubt.least_s + FAR_EARLY_PERIODS * self.period_s;
        let last = self.pending.iter().take(self.judged).enumerate().skip(samples - 1).take(CONFIRMATIONS + 1);
        let near = last.filter(|(place, at_s)| *at_s - from_s(*place) <= near_s).count();
        let is_alone = near < EDGE_SAMPLES
            && (-self.period_s..-FAR_EARLY_PERIODS * self.period_s).contains(&doubt.least_s)
            && doubt.is_early;
        let edge_s = if doubt.is_early && !is_alone { doubt.least_s } else { 0.0 };
        self.due_s = from_s(samples) + edge_s;
        if edge_s < 0.0 {
            self.owed_s = 0.0;
            // the last of them is on the edge
            let (_, _, least_s, most_s) = &mut self.block;
            (*least_s, *most_s) = ((*least_s - edge_s).min(0.0), *most_s - edge_s);
            // a step that is a little shorter for long leads away as far, but later
            let may_have_waited = self.rates.is_some() || self.settled < RUN as u64;
            if may_have_waited && edge_s < -ALL_LATE_PERIODS * self.period_s - self.jump_s {
                self.envelope.restart();
                (self.even, self.last_s) = ((0, 0.0), None);
                if samples > CONFIRMATIONS {
                    self.flushed = self.settled + samples as u64;
                }
            }
        }
        self.drop(samples)
    }

    fn gap(&mut self, doubt: Doubt) -> Decision {
        // over a long pause a small error of the period has an effect
        let period_s = self.envelope.credible_period_s();
        let missing = (doubt.least_s / period_s + (1.0 - LATE_PERIODS)).floor().max(1.0);
        self.due_s = doubt.first_due_s + missing * period_s;
        self.owed_s = (self.owed_s + missing * self.period_s).min(WINDOW_S.max(self.period_s));
        self.doubt = None;
        self.judged = 0;
        if missing <= SHORT_GAP {
            self.even.0 += missing as u64;
        } else {
            self.last_s = None;
        }
        self.index += missing as u64;
        Decision::Gap(GapEvent::Missing(missing as u64))
    }

    /// Ends a block: the edge follows the least lag, except the part that is owed.
    fn end_block(&mut self, at_s: f64) {
        let (count, _, least_s, most_s) = self.block;
        let is_tight = most_s - least_s <= TIGHT_PERIODS * self.period_s;
        // samples that are early after gaps show that the gaps were counted too large; a sample that
        // is late itself is early by less than a period
        let early = -least_s / self.period_s;
        let owed = if is_tight { early.round() } else { (early - EARLY_PERIODS).ceil() };
        let owed = owed.max(0.0) * self.period_s;
        self.owed_s = self.owed_s.min(owed);
        let rest_s = if self.owed_s > 0.0 { 0.0 } else { least_s };
        let most = if is_tight { f64::INFINITY } else { FOLLOWED_PERIODS * self.period_s * count as f64 };
        self.due_s += rest_s.min(most);
        self.block = (0, at_s, f64::INFINITY, 0.0);
    }
}
