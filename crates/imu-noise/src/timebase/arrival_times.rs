//! Gaps and the rate of a stream by the arrival times of its samples.

use std::collections::VecDeque;
use std::time::Duration;

use super::gap_event::{GapEvent, NominalRate, Refusal, TimebaseSummary};
use super::interval_statistics::IntervalStatistics;
use super::judgement::Judgement;
use super::lag_tracker::LagTracker;
use super::rate_estimates::fastest;
use super::rate_search::{InitialRate, RateSearch, TrackedRate};

/// The time by which a stamp may go back without effect: disciplined clocks step back as well.
const BACKWARDS_TOLERANCE: Duration = Duration::from_millis(10);

/// The number of stamps before an earlier one from which the clock counts as set back. Chosen: two
/// stamps may be out of order.
const SET_BACK_SAMPLES: usize = 3;

/// Stamps that go back more often than this, and more than once in so many samples, are no time
/// base. Chosen.
const MAX_BACKWARDS: u64 = 8;
const MIN_SAMPLES_PER_BACKWARDS: u64 = 256;

#[derive(Clone, Debug)]
pub(super) struct ArrivalTimes {
    rates_hz: &'static [f64],
    phase: ArrivalPhase,
    nominal: Option<NominalRate>,
    /// The first stamp of the present clock, and its time in seconds.
    origin: (Duration, f64),
    /// The last stamp; it never goes back unless the clock does.
    last: Duration,
    /// The latest stamps, where they lie before `last`.
    behind: Vec<Duration>,
    samples: u64,
    backwards: u64,
    intervals: IntervalStatistics,
    pub(super) events: VecDeque<GapEvent>,
    missing: u64,
    gaps: u64,
}

/// How the samples are handled.
#[derive(Clone, Debug)]
enum ArrivalPhase {
    /// The samples are pending: their rate is not known.
    Searching(RateSearch),
    /// Each sample is judged by its lag.
    Tracking(Box<LagTracker>),
    /// Arrival times are not used: each sample follows the one before.
    Refused(Refusal),
}

impl ArrivalTimes {
    pub(super) fn new(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        Self {
            rates_hz,
            phase: ArrivalPhase::Searching(RateSearch::new(rates_hz, known_hz)),
            nominal: None,
            origin: (Duration::ZERO, 0.0),
            last: Duration::ZERO,
            behind: Vec::new(),
            samples: 0,
            backwards: 0,
            intervals: IntervalStatistics::new(),
            events: VecDeque::new(),
            missing: 0,
            gaps: 0,
        }
    }

    pub(super) fn set_reported_rate(&mut self, reported_hz: f64) {
        if let ArrivalPhase::Searching(search) = &mut self.phase {
            search.set_reported_rate(reported_hz);
        }
    }

    pub(super) fn push(&mut self, at: Duration) {
        self.samples += 1;
        if self.samples == 1 { self.begin_clock(at, 0.0) } else { self.push_stamp(at) }
    }

    pub(super) fn restart_intervals(&mut self) {
        self.intervals.restart();
    }

    /// No sample follows.
    pub(super) fn finish(&mut self) {
        let behind = std::mem::take(&mut self.behind).len();
        if let ArrivalPhase::Searching(search) = &mut self.phase {
            let decision = search.finish();
            let without_rate = if decision.is_none() { search.samples() } else { 0 };
            self.end_search(decision);
            self.emit_samples(without_rate);
        }
        self.clear_increase();
        while let ArrivalPhase::Tracking(tracker) = &mut self.phase
            && let Some(event) = tracker.finish()
        {
            self.emit(event);
            self.judge();
            self.clear_increase();
        }
        self.emit_samples(behind as u64);
    }

    pub(super) fn summary(&self) -> TimebaseSummary {
        let (refusal, fitted_s) = match &self.phase {
            ArrivalPhase::Searching(_) => (None, None),
            ArrivalPhase::Tracking(tracker) => (None, tracker.envelope.fitted_period_s),
            ArrivalPhase::Refused(refusal) => (Some(*refusal), None),
        };
        self.summary_of(refusal, fitted_s)
    }

    fn summary_of(&self, refusal: Option<Refusal>, fitted_s: Option<f64>) -> TimebaseSummary {
        let measured_hz = fitted_s.map(f64::recip);
        let nominal = self.nominal.filter(|_| refusal.is_none());
        let offset_ppm =
            nominal.zip(measured_hz).map(|(nominal, measured_hz)| (measured_hz / nominal.hz() - 1.0) * 1e6);
        TimebaseSummary {
            samples: self.samples,
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
}

/// From stamps to times: stamps out of order, and clocks that are set back.
impl ArrivalTimes {
    fn push_stamp(&mut self, at: Duration) {
        if let ArrivalPhase::Refused(_) = self.phase {
            return self.emit_samples(1);
        }
        if self.last.saturating_sub(at) > BACKWARDS_TOLERANCE {
            return self.push_behind(at);
        }
        // samples whose stamps lie before the last one arrived no later than this one
        while self.behind.pop().is_some() {
            self.push_ordered(at);
        }
        self.push_ordered(at);
    }

    /// Takes a stamp before the last one: the stamp is wrong, or the clock was set back.
    #[cold]
    fn push_behind(&mut self, at: Duration) {
        if self.behind.is_empty() {
            self.backwards += 1;
            if self.backwards > MAX_BACKWARDS && self.backwards * MIN_SAMPLES_PER_BACKWARDS > self.samples {
                self.clear_increase();
                self.refuse(Refusal::Backwards { times: self.backwards, samples: self.samples });
                return self.emit_samples(1);
            }
        }
        self.behind.push(at);
        if self.behind.len() >= SET_BACK_SAMPLES {
            self.set_clock_back();
        }
    }

    /// The stamps before the last one are those of a new clock, by which the first of them arrived
    /// when it was due.
    fn set_clock_back(&mut self) {
        let mut behind = std::mem::take(&mut self.behind).into_iter();
        let Some(first) = behind.next() else { return };
        let mut due_s = 0.0;
        self.clear_increase();
        match &mut self.phase {
            ArrivalPhase::Searching(search) => search.restart(),
            ArrivalPhase::Tracking(tracker) => {
                let pending;
                (pending, due_s) = tracker.restart_clock();
                self.emit_samples(pending);
            }
            ArrivalPhase::Refused(_) => {}
        }
        self.begin_clock(first, due_s);
        behind.for_each(|at| self.push_stamp(at));
    }

    /// Takes the next sample, by a clock that showed `at` at the time `at_s`.
    fn begin_clock(&mut self, at: Duration, at_s: f64) {
        self.origin = (at, at_s);
        self.last = at;
        self.intervals.push(None);
        self.push_time(at_s);
    }

    fn push_ordered(&mut self, at: Duration) {
        let interval = at.saturating_sub(self.last);
        self.intervals.push(Some(interval.as_secs() * 1_000_000 + u64::from(interval.subsec_micros())));
        self.last += interval;
        let (origin, origin_s) = self.origin;
        self.push_time(origin_s + self.last.saturating_sub(origin).as_secs_f64());
    }
}

/// From times to events.
impl ArrivalTimes {
    fn push_time(&mut self, at_s: f64) {
        match &mut self.phase {
            ArrivalPhase::Searching(search) => {
                let decision = search.push(at_s);
                self.end_search(decision);
            }
            ArrivalPhase::Tracking(tracker) => {
                tracker.push(at_s);
                self.judge();
            }
            ArrivalPhase::Refused(_) => self.emit_samples(1),
        }
    }

    fn end_search(&mut self, decision: Option<Result<InitialRate, Refusal>>) {
        let ArrivalPhase::Searching(search) = &mut self.phase else {
            return;
        };
        match decision {
            None => {}
            Some(Err(refusal)) => self.refuse(refusal),
            Some(Ok((nominal, tracked))) => {
                let (unstamped, pending_s) = search.take_pending();
                self.emit(GapEvent::Rate(nominal));
                self.emit_samples(unstamped);
                self.track(nominal, tracked, pending_s);
            }
        }
    }

    fn track(&mut self, nominal: NominalRate, rate: TrackedRate, pending_s: Vec<f64>) {
        let due_s = pending_s.first().copied().unwrap_or_default();
        let mut tracker = LagTracker::new(self.rates_hz, rate, due_s);
        // all samples are added before the first is judged: their reads show whether the phase may
        // jump
        pending_s.into_iter().for_each(|at_s| tracker.push(at_s));
        self.nominal = Some(nominal);
        self.phase = ArrivalPhase::Tracking(Box::new(tracker));
        self.judge();
    }

    fn judge(&mut self) {
        while let ArrivalPhase::Tracking(tracker) = &mut self.phase
            && let Some(judgement) = tracker.judge()
        {
            match judgement {
                Judgement::Event(event) => self.emit(event),
                Judgement::IncreaseCleared => self.clear_increase(),
                Judgement::Decreased(to_hz) => {
                    self.clear_increase();
                    self.change_rate(to_hz);
                }
                Judgement::Increased(to_hz) => self.change_rate(to_hz),
                Judgement::TooFast(measured_hz) => {
                    self.refuse(Refusal::TooFast { measured_hz, fastest_hz: fastest(self.rates_hz) });
                }
            }
        }
    }

    fn clear_increase(&mut self) {
        if let ArrivalPhase::Tracking(tracker) = &mut self.phase {
            let events = tracker.clear_increase();
            events.into_iter().for_each(|event| self.emit(event));
        }
    }

    /// Starts the time base again from the pending samples, which arrive at this rate.
    fn change_rate(&mut self, to_hz: f64) {
        let (ArrivalPhase::Tracking(tracker), Some(nominal)) = (&mut self.phase, self.nominal) else {
            return;
        };
        let fitted_s = tracker.fitted_before_increase_s();
        let (before, after_s) = tracker.split(to_hz);
        before.into_iter().for_each(|event| self.emit(event));
        let until = Box::new(self.summary_of(None, fitted_s));
        self.emit(GapEvent::RateChanged { from_hz: nominal.hz(), to_hz, until });
        self.track(NominalRate::Snapped(to_hz), TrackedRate::Listed(to_hz), after_s);
    }

    /// Refuses arrival times: the pending samples, and all that follow, have no gap before them.
    fn refuse(&mut self, refusal: Refusal) {
        let pending = match &mut self.phase {
            ArrivalPhase::Searching(search) => search.samples(),
            ArrivalPhase::Tracking(tracker) => tracker.samples_pending() as u64,
            ArrivalPhase::Refused(_) => return,
        };
        self.phase = ArrivalPhase::Refused(refusal);
        self.emit(GapEvent::Refused(refusal));
        self.emit_samples(pending);
    }

    fn emit(&mut self, event: GapEvent) {
        match event {
            GapEvent::Samples(more) => {
                self.intervals.resolve(more);
                if let Some(GapEvent::Samples(samples)) = self.events.back_mut() {
                    *samples += more;
                    return;
                }
            }
            GapEvent::Missing(missing) => {
                self.missing += missing;
                self.gaps += 1;
            }
            _ => {}
        }
        self.events.push_back(event);
    }

    fn emit_samples(&mut self, samples: u64) {
        if samples > 0 {
            self.emit(GapEvent::Samples(samples));
        }
    }
}
