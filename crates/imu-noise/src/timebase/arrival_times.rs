//! Gaps and the rate of a stream from the arrival times of its samples.

use std::collections::VecDeque;
use std::time::Duration;

use super::edge_tracker::{Decision, EdgeTracker};
use super::gap_event::{FASTEST_HZ, GapEvent, NominalRate, Refusal, TimebaseSummary};
use super::interval_statistics::IntervalStatistics;
use super::local_steps::{LocalSteps, Stretch, Unevenness};
use super::rate_search::{Found, RateSearch};
use super::sensor_rates::{RUN, SensorRates, TOO_FAST};

/// The decrease of a stamp that has no effect: disciplined clocks step back as well.
const BACKWARDS_TOLERANCE: Duration = Duration::from_millis(10);

/// The number of successive stamps before an earlier one that shows a clock that was set back.
/// Chosen: two stamps may be out of order.
const SET_BACK_SAMPLES: usize = 3;

/// Stamps that decrease more often than this, and more than once in this many samples, are no time
/// base. Chosen.
const MAX_BACKWARDS: u64 = 8;
const MIN_SAMPLES_PER_BACKWARDS: u64 = 256;

/// The relative change of a measured rate that is reported before the end.
const REPORTED_CHANGE: f64 = 0.01;

#[derive(Clone, Debug)]
pub(super) struct ArrivalTimes {
    rates: SensorRates,
    phase: ArrivalPhase,
    nominal: Option<NominalRate>,
    /// Whether the nominal rate is reported by the sensor, so that it gives way to even arrivals at
    /// another of its rates.
    is_reported: bool,
    unevenness: Option<Unevenness>,
    /// The first stamp of the present clock, and its time in seconds.
    origin: (Duration, f64),
    /// The last stamp; it never decreases unless the clock does.
    last: Duration,
    /// The latest stamps, if they lie before `last`.
    out_of_order: Vec<Duration>,
    samples: u64,
    backwards: u64,
    intervals: IntervalStatistics,
    pub(super) events: VecDeque<GapEvent>,
    missing: u64,
    gaps: u64,
}

/// The treatment of the samples.
#[derive(Clone, Debug)]
enum ArrivalPhase {
    /// The samples are pending, because their rate is not known.
    Searching(RateSearch),
    /// Each sample is judged by its lag.
    Tracking(Box<EdgeTracker>),
    /// No rate is known, and none is listed: each sample is judged by its lag, when its local step
    /// is known. There is no tracker before the first step.
    Stepping(LocalSteps, Option<Box<EdgeTracker>>),
    /// Arrival times are not used: each sample follows the one before.
    Refused(Refusal),
}

impl ArrivalPhase {
    fn tracker(&mut self) -> Option<&mut EdgeTracker> {
        match self {
            Self::Tracking(tracker) | Self::Stepping(_, Some(tracker)) => Some(tracker),
            Self::Searching(_) | Self::Stepping(_, None) | Self::Refused(_) => None,
        }
    }
}

impl ArrivalTimes {
    pub(super) fn new(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        let rates = SensorRates(rates_hz);
        let mut arrivals = Self {
            rates,
            phase: match rates_hz {
                [] => ArrivalPhase::Stepping(LocalSteps::new(), None),
                _ => ArrivalPhase::Searching(RateSearch::new(rates)),
            },
            nominal: None,
            is_reported: false,
            unevenness: None,
            origin: (Duration::ZERO, 0.0),
            last: Duration::ZERO,
            out_of_order: Vec::new(),
            samples: 0,
            backwards: 0,
            intervals: IntervalStatistics::new(),
            events: VecDeque::new(),
            missing: 0,
            gaps: 0,
        };
        if let Some(hz) = known_hz {
            arrivals.start(NominalRate::Known(hz));
        }
        arrivals
    }

    pub(super) fn set_reported_rate(&mut self, reported_hz: f64) {
        if matches!(self.phase, ArrivalPhase::Searching(_)) {
            self.is_reported = true;
            self.start(NominalRate::Known(reported_hz));
        }
    }

    pub(super) fn push(&mut self, at: Duration) {
        self.samples += 1;
        if self.samples == 1 { self.begin_clock(at, 0.0) } else { self.push_stamp(at) }
    }

    pub(super) fn restart_intervals(&mut self) {
        self.intervals.restart();
    }

    /// Ends the stream, because no sample follows.
    pub(super) fn finish(&mut self) {
        let out_of_order = std::mem::take(&mut self.out_of_order).len();
        self.finish_clock();
        self.emit_samples(out_of_order as u64);
        if let Some(hz) = self.rate_of_all() {
            self.set_measured(hz);
        }
    }

    pub(super) fn summary(&self) -> TimebaseSummary {
        let refusal = if let ArrivalPhase::Refused(refusal) = &self.phase { Some(*refusal) } else { None };
        let nominal = self.nominal.filter(|_| refusal.is_none());
        let measured_hz = match &self.phase {
            ArrivalPhase::Tracking(tracker) => tracker.envelope.fitted_period_s.map(f64::recip),
            ArrivalPhase::Stepping(..) => self.rate_of_all().or(nominal.map(NominalRate::hz)),
            ArrivalPhase::Searching(_) | ArrivalPhase::Refused(_) => None,
        };
        let is_nominal = !matches!(self.phase, ArrivalPhase::Stepping(..));
        let offset_ppm = nominal.zip(measured_hz).filter(|_| is_nominal);
        TimebaseSummary {
            samples: self.samples,
            backwards: self.backwards,
            nominal,
            measured_hz,
            offset_ppm: offset_ppm.map(|(nominal, measured_hz)| (measured_hz / nominal.hz() - 1.0) * 1e6),
            refusal,
            missing: self.missing,
            gaps: self.gaps,
            unevenness: self.unevenness,
            flushed: match &self.phase {
                ArrivalPhase::Stepping(_, Some(tracker)) if self.unevenness.is_none() => tracker.flushed,
                _ => 0,
            },
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
        }
    }

    /// The number of all samples divided by all time without gaps, in Hz, for a stream without a
    /// nominal rate.
    fn rate_of_all(&self) -> Option<f64> {
        let ArrivalPhase::Stepping(_, Some(tracker)) = &self.phase else { return None };
        let (samples, seconds) = tracker.even;
        (samples > 0 && seconds > 0.0).then(|| rounded(samples as f64 / seconds))
    }
}

/// From stamps to times: handles stamps out of order, and clocks that are set back.
impl ArrivalTimes {
    fn push_stamp(&mut self, at: Duration) {
        if let ArrivalPhase::Refused(_) = self.phase {
            return self.emit_samples(1);
        }
        if self.last.saturating_sub(at) > BACKWARDS_TOLERANCE {
            return self.push_out_of_order(at);
        }
        // samples whose stamps are before the last one arrived no later than this one
        while self.out_of_order.pop().is_some() {
            self.push_ordered(at);
        }
        self.push_ordered(at);
    }

    /// Takes a stamp before the last one: the stamp is wrong, or the clock was set back.
    #[cold]
    fn push_out_of_order(&mut self, at: Duration) {
        if self.out_of_order.is_empty() {
            self.backwards += 1;
            if self.backwards > MAX_BACKWARDS && self.backwards * MIN_SAMPLES_PER_BACKWARDS > self.samples {
                self.refuse(Refusal::Backwards { times: self.backwards, samples: self.samples });
                return self.emit_samples(1);
            }
        }
        self.out_of_order.push(at);
        if self.out_of_order.len() >= SET_BACK_SAMPLES {
            self.set_clock_back();
        }
    }

    /// The stamps before the last one are those of a new clock, on which the first of them arrived
    /// when it was due.
    fn set_clock_back(&mut self) {
        let mut stamps = std::mem::take(&mut self.out_of_order).into_iter();
        let Some(first) = stamps.next() else { return };
        if let ArrivalPhase::Stepping(..) = &self.phase {
            self.finish_clock();
        }
        let mut due_s = 0.0;
        match &mut self.phase {
            ArrivalPhase::Searching(search) => search.restart_clock(),
            ArrivalPhase::Tracking(tracker) | ArrivalPhase::Stepping(_, Some(tracker)) => {
                let pending;
                (pending, due_s) = tracker.restart_clock();
                self.emit_samples(pending);
            }
            ArrivalPhase::Stepping(_, None) | ArrivalPhase::Refused(_) => {}
        }
        self.begin_clock(first, due_s);
        stamps.for_each(|at| self.push_stamp(at));
    }

    /// Takes the next sample, on a clock that showed `at` at the time `at_s`.
    fn begin_clock(&mut self, at: Duration, at_s: f64) {
        self.origin = (at, at_s);
        self.last = at;
        self.push_time(at_s);
    }

    fn push_ordered(&mut self, at: Duration) {
        let interval = at.saturating_sub(self.last);
        self.intervals.push(interval.as_micros() as u64);
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
                let found = search.push(at_s);
                self.end_search(found);
            }
            ArrivalPhase::Tracking(tracker) => {
                tracker.push(at_s);
                self.decide();
            }
            ArrivalPhase::Stepping(steps, _) => {
                let stretch = steps.push(at_s);
                self.take_stretch(stretch);
            }
            ArrivalPhase::Refused(_) => self.emit_samples(1),
        }
    }

    /// Decides all samples of the present clock.
    fn finish_clock(&mut self) {
        if let ArrivalPhase::Searching(search) = &self.phase {
            match search.finish() {
                // a single sample has no rate
                None => self.emit_samples(search.samples()),
                found => self.end_search(found),
            }
        }
        while let ArrivalPhase::Stepping(steps, _) = &mut self.phase
            && let Some(stretch) = steps.finish()
        {
            self.take_stretch(Some(stretch));
        }
        self.finish_tracker();
    }

    fn finish_tracker(&mut self) {
        while let Some(decision) = self.phase.tracker().and_then(EdgeTracker::finish) {
            self.take(decision);
            self.decide();
        }
    }

    fn end_search(&mut self, found: Option<Found>) {
        let ArrivalPhase::Searching(search) = &self.phase else { return };
        let samples = search.samples();
        match found {
            None => {}
            Some(Found::Listed(hz)) => self.start(NominalRate::Snapped(hz)),
            Some(Found::Unlisted(hz)) => self.start(NominalRate::Measured(hz)),
            Some(Found::Uneven(measured_hz)) => {
                let fastest_hz = self.rates.fastest();
                self.refuse(match () {
                    () if measured_hz.is_infinite() => Refusal::NoTimePasses { samples },
                    () if measured_hz > TOO_FAST * fastest_hz => Refusal::TooFast { measured_hz, fastest_hz },
                    () => Refusal::Uneven { measured_hz },
                });
            }
        }
    }

    /// Tracks all samples from the first pending one on, at this rate.
    fn start(&mut self, nominal: NominalRate) {
        let (unstamped, pending_s) = match &mut self.phase {
            ArrivalPhase::Searching(search) => search.take_pending(),
            ArrivalPhase::Tracking(tracker) => (0, tracker.take_pending()),
            ArrivalPhase::Stepping(..) | ArrivalPhase::Refused(_) => (0, Vec::new()),
        };
        self.emit(GapEvent::Rate(nominal));
        self.emit_samples(unstamped);
        self.nominal = Some(nominal);
        self.track(nominal.hz(), pending_s);
    }

    fn track(&mut self, hz: f64, pending_s: Vec<f64>) {
        let mut tracker = EdgeTracker::new(Some(self.rates), hz, pending_s.first().copied().unwrap_or_default());
        tracker.follows_fit = matches!(self.nominal, Some(NominalRate::Measured(_)));
        pending_s.into_iter().for_each(|at_s| tracker.push(at_s));
        self.phase = ArrivalPhase::Tracking(Box::new(tracker));
        self.decide();
    }

    /// Tracks samples whose local step is known.
    fn take_stretch(&mut self, stretch: Option<Stretch>) {
        let Some(stretch) = stretch else { return };
        if stretch.begins {
            self.finish_tracker();
            if let Some(hz) = self.rate_of_all() {
                self.set_measured(hz);
            }
        }
        let ArrivalPhase::Stepping(_, tracker) = &mut self.phase else { return };
        let period_s = match (&stretch.steps, &tracker) {
            (Some(steps), _) => steps.period_s,
            (None, Some(tracker)) => tracker.period_s,
            (None, None) => return self.refuse_steps(&stretch),
        };
        let hz = period_s.recip();
        let are_pairs = stretch.steps.is_some_and(|steps| steps.unevenness == Some(Unevenness::Pairs));
        if hz > FASTEST_HZ || (are_pairs && tracker.is_none()) {
            return self.refuse_steps(&stretch);
        }
        let first_s = stretch.stamps_s.first().copied().unwrap_or_default();
        let unevenness = stretch.steps.and_then(|steps| steps.unevenness);
        if !stretch.begins
            && let Some(tracker) = tracker
        {
            tracker.period_s = period_s;
        } else {
            let until = Box::new(self.summary());
            let ArrivalPhase::Stepping(_, tracker) = &mut self.phase else { return };
            *tracker = Some(Box::new(EdgeTracker::new(None, hz, first_s)));
            match self.nominal.replace(NominalRate::Measured(hz)) {
                Some(before) => self.emit(GapEvent::RateChanged { from_hz: before.hz(), to_hz: hz, until }),
                None => self.emit(GapEvent::Rate(NominalRate::Measured(hz))),
            }
            self.unevenness = None;
        }
        self.unevenness = self.unevenness.or(unevenness);
        if let Some(tracker) = self.phase.tracker() {
            tracker.jump_s = stretch.steps.map_or(tracker.jump_s, |steps| steps.jump_s);
            stretch.stamps_s.iter().for_each(|at_s| tracker.push(*at_s));
        }
        self.decide();
        let nominal_hz = self.nominal.map_or(0.0, NominalRate::hz);
        if let Some(hz) = self.rate_of_all().filter(|hz| (hz / nominal_hz - 1.0).abs() > REPORTED_CHANGE) {
            self.set_measured(hz);
        }
    }

    fn set_measured(&mut self, hz: f64) {
        self.nominal = Some(NominalRate::Measured(hz));
        self.emit(GapEvent::Rate(NominalRate::Measured(hz)));
    }

    /// Refuses the stamps of samples without an even step.
    fn refuse_steps(&mut self, stretch: &Stretch) {
        let samples = stretch.stamps_s.len() as u64;
        let measured_hz = match &stretch.steps {
            Some(steps) => steps.period_s.recip(),
            None => super::sensor_rates::mean_hz(&stretch.stamps_s).unwrap_or(f64::INFINITY),
        };
        match () {
            () if samples == 1 => {}
            () if measured_hz.is_infinite() => self.refuse(Refusal::NoTimePasses { samples }),
            () if measured_hz > FASTEST_HZ => self.refuse(Refusal::TooFast { measured_hz, fastest_hz: FASTEST_HZ }),
            () if stretch.steps.is_some() => self.refuse(Refusal::Pairs { measured_hz }),
            () => self.refuse(Refusal::Uneven { measured_hz }),
        }
        self.emit_samples(samples);
    }

    fn decide(&mut self) {
        while let Some(decision) = self.phase.tracker().and_then(EdgeTracker::decide) {
            self.take(decision);
        }
    }

    fn take(&mut self, decision: Decision) {
        match decision {
            Decision::Samples(samples) => self.emit_samples(samples),
            Decision::Missing(missing) => self.emit(GapEvent::Missing(missing)),
            Decision::OtherRate(hz) => self.take_other_rate(hz),
        }
    }

    /// The pending samples arrive evenly at another rate, or faster than samples can.
    fn take_other_rate(&mut self, hz: f64) {
        let ArrivalPhase::Tracking(tracker) = &mut self.phase else { return };
        let (Some(nominal), fastest_hz) = (self.nominal, self.rates.fastest()) else { return };
        let is_listed = self.rates.nearest(hz, 0.0).is_some();
        let is_new = tracker.settled < RUN as u64;
        match () {
            () if hz.is_infinite() => self.refuse(Refusal::NoTimePasses { samples: self.samples }),
            () if hz > TOO_FAST * fastest_hz => self.refuse(Refusal::TooFast { measured_hz: hz, fastest_hz }),
            () if is_listed && is_new && self.is_reported => {
                self.is_reported = false;
                self.start(NominalRate::Snapped(hz));
            }
            () if is_listed && !is_new => {
                let until = Box::new(self.summary());
                let ArrivalPhase::Tracking(tracker) = &mut self.phase else { return };
                let pending_s = tracker.take_pending();
                self.emit(GapEvent::RateChanged { from_hz: nominal.hz(), to_hz: hz, until });
                self.nominal = Some(NominalRate::Snapped(hz));
                self.track(hz, pending_s);
            }
            () => self.refuse(Refusal::OtherRate { known_hz: nominal.hz(), measured_hz: hz }),
        }
    }

    /// Refuses arrival times: the pending samples, and all later ones, have no gap before them.
    fn refuse(&mut self, refusal: Refusal) {
        let pending = match &mut self.phase {
            ArrivalPhase::Searching(search) => search.samples(),
            ArrivalPhase::Tracking(tracker) => tracker.take_pending().len() as u64,
            ArrivalPhase::Stepping(steps, tracker) => {
                let tracked = tracker.as_mut().map_or(0, |tracker| tracker.take_pending().len());
                (steps.pending_s.len() + tracked) as u64
            }
            ArrivalPhase::Refused(_) => return,
        };
        self.phase = ArrivalPhase::Refused(refusal);
        self.emit(GapEvent::Refused(refusal));
        self.emit_samples(pending);
    }

    fn emit(&mut self, event: GapEvent) {
        match event {
            GapEvent::Samples(more) => {
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

/// Rounds to twelve digits: further digits are errors of sums of doubles.
fn rounded(hz: f64) -> f64 {
    let unit = 10_f64.powf(11.0 - hz.log10().floor());
    (hz * unit).round() / unit
}
