//! Gaps and the rate of a stream from the arrival times of its samples.

use std::time::Duration;

use super::edge_tracker::{Decision, EdgeTracker};
use super::gap_event::{FASTEST_HZ, GapEvent, GapEvents, NominalRate, Refusal, TimebaseSummary};
use super::interval_statistics::IntervalStatistics;
use super::local_steps::{LocalSteps, Stretch, Unevenness};
use super::rate_search::RateSearch;
use super::sensor_rates::{RUN, SensorRates, TOO_FAST, mean_hz};

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

#[derive(Clone, Debug, Default)]
pub(super) struct ArrivalTimes {
    rates: SensorRates,
    waiting: Waiting,
    /// Judges each sample by its lag; `None` until a period is known, and after a refusal.
    tracker: Option<Box<EdgeTracker>>,
    /// After this each sample follows the one before.
    refusal: Option<Refusal>,
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
    pub(super) events: GapEvents,
}

/// The samples that no tracker judges yet.
#[derive(Clone, Debug, Default)]
enum Waiting {
    #[default]
    None,
    /// Until the rate is known, one of a list.
    ForRate(RateSearch),
    /// Until their local step is known, as no rate is listed.
    ForStep(LocalSteps),
}

impl ArrivalTimes {
    pub(super) fn new(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        let rates = SensorRates(rates_hz);
        let waiting = match rates_hz {
            [] => Waiting::ForStep(LocalSteps::default()),
            _ => Waiting::ForRate(RateSearch::new(rates)),
        };
        let mut arrivals = Self { rates, waiting, ..Self::default() };
        if let Some(hz) = known_hz {
            arrivals.start(NominalRate::Known(hz));
        }
        arrivals
    }

    pub(super) fn set_reported_rate(&mut self, reported_hz: f64) {
        if let Waiting::ForRate(_) = self.waiting {
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
        self.events.push(GapEvent::Samples(out_of_order as u64));
        if let Some(hz) = self.rate_of_all() {
            self.set_measured(hz);
        }
    }

    pub(super) fn summary(&self) -> TimebaseSummary {
        let nominal = self.nominal.filter(|_| self.refusal.is_none());
        let tracker = self.tracker.as_deref();
        let has_nominal = !matches!(self.waiting, Waiting::ForStep(_));
        let measured_hz = match has_nominal {
            true => tracker.and_then(|tracker| tracker.envelope.fitted_period_s).map(f64::recip),
            false => self.rate_of_all().or(nominal.map(NominalRate::hz)),
        };
        let offset_ppm = nominal.zip(measured_hz).filter(|_| has_nominal);
        let flushed = tracker.filter(|_| !has_nominal && self.unevenness.is_none()).map(|tracker| tracker.flushed);
        TimebaseSummary {
            samples: self.samples,
            backwards: self.backwards,
            nominal,
            measured_hz,
            offset_ppm: offset_ppm.map(|(nominal, measured_hz)| (measured_hz / nominal.hz() - 1.0) * 1e6),
            refusal: self.refusal,
            missing: self.events.missing,
            gaps: self.events.gaps,
            unevenness: self.unevenness,
            flushed: flushed.unwrap_or(0),
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
        }
    }

    /// All samples by all time without gaps, in Hz, for a stream without a nominal rate.
    fn rate_of_all(&self) -> Option<f64> {
        let (samples, seconds) = self.tracker.as_ref().filter(|_| matches!(self.waiting, Waiting::ForStep(_)))?.even;
        (samples > 0 && seconds > 0.0).then(|| rounded(samples as f64 / seconds))
    }
}

/// From stamps to times: handles stamps out of order, and clocks that are set back.
impl ArrivalTimes {
    fn push_stamp(&mut self, at: Duration) {
        if self.refusal.is_some() {
            return self.events.push(GapEvent::Samples(1));
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
                return self.events.push(GapEvent::Samples(1));
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
        match &mut self.waiting {
            Waiting::ForRate(search) => search.restart_clock(),
            Waiting::ForStep(_) => self.finish_clock(),
            Waiting::None => {}
        }
        let mut due_s = 0.0;
        if let Some(tracker) = &mut self.tracker {
            let pending;
            (pending, due_s) = tracker.restart_clock();
            self.events.push(GapEvent::Samples(pending));
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

impl ArrivalTimes {
    fn push_time(&mut self, at_s: f64) {
        match &mut self.waiting {
            Waiting::ForRate(search) => {
                if let Some(found) = search.push(at_s) {
                    self.end_search(found);
                }
            }
            Waiting::ForStep(steps) => {
                if let Some(stretch) = steps.push(at_s) {
                    self.take_stretch(&stretch);
                }
            }
            Waiting::None => match &mut self.tracker {
                Some(tracker) => {
                    tracker.push(at_s);
                    self.decide();
                }
                None => self.events.push(GapEvent::Samples(1)),
            },
        }
    }

    /// Decides all samples of the present clock.
    fn finish_clock(&mut self) {
        if let Waiting::ForRate(search) = &self.waiting {
            match search.finish() {
                // a single sample has no rate
                None => self.events.push(GapEvent::Samples(search.samples())),
                Some(found) => self.end_search(found),
            }
        }
        while let Waiting::ForStep(steps) = &mut self.waiting
            && let Some(stretch) = steps.finish()
        {
            self.take_stretch(&stretch);
        }
        self.finish_tracker();
    }

    fn finish_tracker(&mut self) {
        while let Some(decision) = self.tracker.as_mut().and_then(|tracker| tracker.finish()) {
            self.take(decision);
            self.decide();
        }
    }

    /// The rate of a sensor with listed ones, or how many samples a second arrive without showing it.
    fn end_search(&mut self, found: Result<NominalRate, f64>) {
        match found {
            Ok(nominal) => self.start(nominal),
            Err(measured_hz) => self.refuse_rate(measured_hz, Refusal::Uneven { measured_hz }),
        }
    }

    /// Tracks all samples from the first pending one on, at this rate.
    fn start(&mut self, nominal: NominalRate) {
        let (unstamped, pending_s) = match &mut self.waiting {
            Waiting::ForRate(search) => search.take_pending(),
            _ => (0, self.tracker.as_mut().map(|tracker| tracker.take_pending()).unwrap_or_default()),
        };
        self.waiting = Waiting::None;
        self.nominal = Some(nominal);
        self.events.push(GapEvent::Rate(nominal));
        self.events.push(GapEvent::Samples(unstamped));
        self.track(nominal.hz(), pending_s);
    }

    fn track(&mut self, hz: f64, pending_s: Vec<f64>) {
        let mut tracker = EdgeTracker::new(Some(self.rates), hz, pending_s.first().copied().unwrap_or_default());
        tracker.follows_fit = matches!(self.nominal, Some(NominalRate::Measured(_)));
        pending_s.into_iter().for_each(|at_s| tracker.push(at_s));
        self.tracker = Some(Box::new(tracker));
        self.decide();
    }

    /// Tracks samples whose local step is known.
    fn take_stretch(&mut self, stretch: &Stretch) {
        if stretch.begins {
            self.finish_tracker();
            if let Some(hz) = self.rate_of_all() {
                self.set_measured(hz);
            }
        }
        let before_s = self.tracker.as_ref().map(|tracker| tracker.period_s);
        let Some(period_s) = stretch.steps.map(|steps| steps.period_s).or(before_s) else {
            return self.refuse_steps(stretch);
        };
        let hz = period_s.recip();
        let unevenness = stretch.steps.and_then(|steps| steps.unevenness);
        if hz > FASTEST_HZ || (unevenness == Some(Unevenness::Pairs) && self.tracker.is_none()) {
            return self.refuse_steps(stretch);
        }
        match &mut self.tracker {
            Some(tracker) if !stretch.begins => tracker.period_s = period_s,
            _ => {
                let until = Box::new(self.summary());
                let first_s = stretch.stamps_s.first().copied().unwrap_or_default();
                self.tracker = Some(Box::new(EdgeTracker::new(None, hz, first_s)));
                self.events.push(match self.nominal.replace(NominalRate::Measured(hz)) {
                    Some(before) => GapEvent::RateChanged { from_hz: before.hz(), to_hz: hz, until },
                    None => GapEvent::Rate(NominalRate::Measured(hz)),
                });
                self.unevenness = None;
            }
        }
        self.unevenness = self.unevenness.or(unevenness);
        if let Some(tracker) = &mut self.tracker {
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
        self.events.push(GapEvent::Rate(NominalRate::Measured(hz)));
    }

    /// Refuses the stamps of samples without an even step.
    fn refuse_steps(&mut self, stretch: &Stretch) {
        let samples = stretch.stamps_s.len() as u64;
        let measured_hz = match &stretch.steps {
            Some(steps) => steps.period_s.recip(),
            None => mean_hz(&stretch.stamps_s).unwrap_or(f64::INFINITY),
        };
        match () {
            // between two times that the clock was set back little may show
            () if samples == 1 || self.backwards > 0 && measured_hz.is_infinite() => {}
            () if measured_hz.is_infinite() => self.refuse(Refusal::NoTimePasses { samples }),
            () if measured_hz > FASTEST_HZ => self.refuse(Refusal::TooFast { measured_hz, fastest_hz: FASTEST_HZ }),
            () if stretch.steps.is_some() => self.refuse(Refusal::Pairs { measured_hz }),
            () => self.refuse(Refusal::Uneven { measured_hz }),
        }
        self.events.push(GapEvent::Samples(samples));
    }

    fn decide(&mut self) {
        while let Some(decision) = self.tracker.as_mut().and_then(|tracker| tracker.decide()) {
            self.take(decision);
        }
    }

    fn take(&mut self, decision: Decision) {
        match decision {
            Decision::Gap(event) => self.events.push(event),
            Decision::OtherRate(hz) => self.take_other_rate(hz),
        }
    }

    /// The pending samples arrive evenly at another rate, or faster than samples can.
    fn take_other_rate(&mut self, hz: f64) {
        let (Some(tracker), Some(nominal)) = (&self.tracker, self.nominal) else { return };
        let is_listed = self.rates.nearest(hz, 0.0).is_some();
        let is_new = tracker.settled < RUN as u64;
        match () {
            () if is_listed && is_new && self.is_reported => {
                self.is_reported = false;
                self.start(NominalRate::Snapped(hz));
            }
            () if is_listed && !is_new => {
                let until = Box::new(self.summary());
                let pending_s = self.tracker.as_mut().map(|tracker| tracker.take_pending()).unwrap_or_default();
                self.events.push(GapEvent::RateChanged { from_hz: nominal.hz(), to_hz: hz, until });
                self.nominal = Some(NominalRate::Snapped(hz));
                self.track(hz, pending_s);
            }
            () => self.refuse_rate(hz, Refusal::OtherRate { known_hz: nominal.hz(), measured_hz: hz }),
        }
    }

    /// Refuses arrival times at this rate, for a reason that holds if a sensor could be so fast.
    fn refuse_rate(&mut self, measured_hz: f64, reason: Refusal) {
        let (samples, fastest_hz) = (self.samples, self.rates.fastest());
        self.refuse(match () {
            () if measured_hz.is_infinite() => Refusal::NoTimePasses { samples },
            () if measured_hz > TOO_FAST * fastest_hz => Refusal::TooFast { measured_hz, fastest_hz },
            () => reason,
        });
    }

    /// Refuses arrival times: the pending samples, and all later ones, have no gap before them.
    fn refuse(&mut self, refusal: Refusal) {
        if self.refusal.is_some() {
            return;
        }
        let tracked = self.tracker.take().map_or(0, |mut tracker| tracker.take_pending().len() as u64);
        let waiting = match std::mem::take(&mut self.waiting) {
            Waiting::ForRate(search) => search.samples(),
            Waiting::ForStep(steps) => steps.pending_s.len() as u64,
            Waiting::None => 0,
        };
        self.refusal = Some(refusal);
        self.events.push(GapEvent::Refused(refusal));
        self.events.push(GapEvent::Samples(tracked + waiting));
    }
}

/// Rounds to twelve digits: further digits are errors of sums of doubles.
fn rounded(hz: f64) -> f64 {
    let unit = 10_f64.powf(11.0 - hz.log10().floor());
    (hz * unit).round() / unit
}
