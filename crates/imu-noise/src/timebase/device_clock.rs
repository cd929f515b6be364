//! Missing samples by the time at which the sensor says that it measured each.

use std::{collections::VecDeque, time::Duration};

use super::envelope::Envelope;
use super::gap_event::{GapEvent, NominalRate, TimebaseSummary};
use super::interval_statistics::IntervalStatistics;
use super::rate_estimates::RUN;
use super::sample_counter::CounterSummary;

/// The sensor measures 800 times a second, and sends every so many of these measurements (VN-100
/// User Manual, register 75).
const TICK_NS: f64 = 1_250_000.0;

/// Part of an interval by which it may differ from whole periods. Chosen: the clocks of real
/// sensors differ by a fortieth at 800 Hz.
const TOLERANCE: f64 = 0.25;

/// Part of a tick by which an interval may differ from whole ticks, and relative error of the mean
/// tick. Chosen: four times that of 31 times with the jitter of a real sensor, a fortieth of a
/// tick.
const TICK_TOLERANCE: f64 = 0.1;
const MEAN_TICK_TOLERANCE: f64 = 0.005;

/// Above, an interval is no gap but another clock: at 800 Hz such a gap takes two months.
const MAX_PERIODS: f64 = 4_294_967_296.0;

/// Below, arrival times say nothing of the offset of two clocks.
const MIN_COMPARED: Duration = Duration::from_secs(60);

/// So far the time that passes over an outage may differ by the clocks of sensor and host: samples
/// may wait that long in the host, and the clocks may differ by that part.
const LATEST_ARRIVAL: Duration = Duration::from_millis(500);
const CLOCK_DIFFERENCE: f64 = 1e-3;

/// Judges the device times of a stream's samples; streaming, in bounded memory.
///
/// The period is a whole number of ticks of 1.25 ms where the mean of the shortest of the first 31
/// intervals shows one, else that mean: it is right as long as two samples follow each other
/// anywhere among them. An interval of n periods is n - 1 missing samples. A time that goes back is
/// a restart of the sensor, [`GapEvent::Restart`], one before which the sample would have had to
/// arrive earlier than it was sent a step of its clock, [`GapEvent::TimeStep`], and any other
/// interval another clock, [`GapEvent::UnknownGap`]. As many equal intervals of another length are
/// another rate.
///
/// A sample after any other interval than one period is in doubt until the next one: if that
/// follows the sample before by two periods, the time in between was false,
/// [`GapEvent::FalseTime`]; if its interval is the same, both are in doubt.
#[derive(Clone, Debug)]
pub(super) struct DeviceClock {
    first_ns: u64,
    last_ns: u64,
    last_at: Option<Duration>,
    /// The first samples; empty once the period is known.
    held: Vec<Stamped>,
    period_ns: Option<f64>,
    /// The last samples, if their intervals are equal and not one period; fewer than show a rate.
    in_doubt: Vec<Stamped>,
    /// Whether the next sample is the first one after an outage: its arrival shows no interval.
    after_outage: bool,
    /// Of the last sample, in periods since the sensor started to send.
    index: u64,
    /// The least time in nanoseconds from a device time to its arrival, in the origins of both; it
    /// rises as clocks may drift.
    least_lag_ns: Option<f64>,
    envelope: Option<Envelope>,
    intervals: IntervalStatistics,
    /// Where the offset of the clocks begins to count.
    compared_from: Option<Duration>,
    samples: u64,
    backwards: u64,
    missing: u64,
    gaps: u64,
    pub(super) events: VecDeque<GapEvent>,
}

/// What the first sample after an outage shows of the sensor's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockAfterOutage {
    /// It ran on: its next interval shows how many samples are missing.
    RunsOn,
    /// It began anew.
    Restarted,
    /// Nothing: there is no device time, or no arrival time to confirm it, or these differ.
    Unknown,
}

/// A sample, by both clocks.
#[derive(Clone, Copy, Debug)]
struct Stamped {
    device_ns: u64,
    at: Option<Duration>,
}

impl DeviceClock {
    pub(super) fn new() -> Self {
        Self {
            first_ns: 0,
            last_ns: 0,
            last_at: None,
            held: Vec::new(),
            period_ns: None,
            in_doubt: Vec::new(),
            after_outage: false,
            index: 0,
            least_lag_ns: None,
            envelope: None,
            intervals: IntervalStatistics::new(),
            compared_from: None,
            samples: 0,
            backwards: 0,
            missing: 0,
            gaps: 0,
            events: VecDeque::new(),
        }
    }

    /// `at` is the arrival, where it is known.
    pub(super) fn push(&mut self, device_ns: u64, at: Option<Duration>) {
        if self.samples == 0 {
            self.first_ns = device_ns;
        }
        self.samples += 1;
        let stamped = Stamped { device_ns, at };
        match self.period_ns {
            Some(period_ns) => self.take(stamped, period_ns),
            None => {
                self.held.push(stamped);
                if self.held.len() == RUN {
                    self.learn_period();
                }
            }
        }
    }

    pub(super) fn restart_intervals(&mut self) {
        self.intervals.restart();
    }

    /// No sample follows: decides on those held.
    pub(super) fn finish(&mut self) {
        self.learn_period();
        self.decide();
    }

    /// Whether the clock runs on over an outage, after which this sample is the first. To be asked
    /// of a clock that has finished.
    pub(super) fn after_outage(&mut self, device_ns: u64, at: Duration) -> ClockAfterOutage {
        let Some(interval_ns) = device_ns.checked_sub(self.last_ns) else { return ClockAfterOutage::Restarted };
        let known = self.period_ns.filter(|_| self.samples >= RUN as u64);
        let (Some(period_ns), Some(last)) = (known, self.last_at) else {
            return ClockAfterOutage::Unknown;
        };
        let (interval, passed) = (Duration::from_nanos(interval_ns), at.saturating_sub(last));
        let difference = passed.abs_diff(interval);
        self.after_outage = whole_periods(interval_ns, period_ns).is_some()
            && difference <= LATEST_ARRIVAL + interval.mul_f64(CLOCK_DIFFERENCE);
        if self.after_outage { ClockAfterOutage::RunsOn } else { ClockAfterOutage::Unknown }
    }

    pub(super) fn counter(&self) -> Option<CounterSummary> {
        let (first, last) = (self.first_ns, self.last_ns);
        (self.samples > 0).then_some(CounterSummary { first, last, step: self.period_ns, is_device_time: true })
    }

    /// What the arrival times show of the sensor's clock; `None` without any.
    pub(super) fn summary(&self) -> Option<TimebaseSummary> {
        self.last_at.map(|_| self.so_far())
    }

    fn so_far(&self) -> TimebaseSummary {
        let nominal = self.period_ns.map(|period_ns| NominalRate::Known(1e9 / period_ns));
        let compared = self.last_at.zip(self.compared_from).map(|(last, from)| last.saturating_sub(from));
        let fitted_s = self.envelope.as_ref().and_then(|envelope| envelope.fitted_period_s);
        let measured_hz = fitted_s.filter(|_| compared >= Some(MIN_COMPARED)).map(f64::recip);
        TimebaseSummary {
            samples: self.samples,
            backwards: self.backwards,
            nominal,
            measured_hz,
            offset_ppm: nominal.zip(measured_hz).map(|(nominal, hz)| (hz / nominal.hz() - 1.0) * 1e6),
            refusal: None,
            missing: self.missing,
            gaps: self.gaps,
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
        }
    }

    fn learn_period(&mut self) {
        let held = std::mem::take(&mut self.held);
        let Some(first) = held.first() else { return };
        let intervals = || held.windows(2).filter_map(|pair| pair[1].device_ns.checked_sub(pair[0].device_ns));
        if let Some(period_ns) = period_ns(intervals().filter(|ns| *ns > 0)) {
            self.period_ns = Some(period_ns);
            self.envelope = Some(Envelope::new(period_ns * 1e-9));
            self.events.push_back(GapEvent::DeviceTimeInUse { rate_hz: 1e9 / period_ns });
        }
        self.add_sample(*first);
        for stamped in &held[1..] {
            match self.period_ns {
                Some(period_ns) => self.take(*stamped, period_ns),
                // no interval is one
                None => {
                    self.events.push_back(GapEvent::UnknownGap);
                    self.add_sample(*stamped);
                }
            }
        }
    }

    fn take(&mut self, stamped: Stamped, period_ns: f64) {
        let periods_after = |earlier_ns: u64, periods: f64| {
            let interval_ns = stamped.device_ns.wrapping_sub(earlier_ns).cast_signed() as f64;
            (interval_ns - periods * period_ns).abs() <= TOLERANCE * period_ns
        };
        // nearly every sample
        if self.in_doubt.is_empty() && periods_after(self.last_ns, 1.0) {
            self.index += 1;
            return self.add_sample(stamped);
        }
        let Some(doubtful) = self.in_doubt.last() else {
            self.in_doubt.push(stamped);
            return;
        };
        if self.in_doubt.len() == 1 && periods_after(self.last_ns, 2.0) && !periods_after(doubtful.device_ns, 1.0) {
            self.in_doubt.clear();
            self.events.push_back(GapEvent::FalseTime);
            self.add_missing(1);
            self.index += 1;
            return self.add_sample(stamped);
        }
        if self.continues_run(stamped) {
            self.in_doubt.push(stamped);
            if self.in_doubt.len() == RUN {
                self.change_rate(period_ns);
            }
            return;
        }
        self.decide();
        self.take(stamped, self.period_ns.unwrap_or(period_ns));
    }

    /// Whether the sample follows those in doubt by as many ticks as they follow each other.
    fn continues_run(&self, stamped: Stamped) -> bool {
        let before = match self.in_doubt[..] {
            [] => return false,
            [only] => [self.last_ns, only.device_ns],
            [.., before, last] => [before.device_ns, last.device_ns],
        };
        let ticks = |from_ns: u64, to_ns: u64| {
            let ticks = to_ns.checked_sub(from_ns)? as f64 / TICK_NS;
            let whole = ticks.round();
            ((ticks - whole).abs() <= TICK_TOLERANCE && whole >= 1.0).then_some(whole as u64)
        };
        let expected = ticks(before[0], before[1]);
        expected.is_some() && ticks(before[1], stamped.device_ns) == expected
    }

    /// The samples in doubt come at another rate.
    fn change_rate(&mut self, period_ns: f64) {
        let run = std::mem::take(&mut self.in_doubt);
        let ([first, .., last], from_hz) = (&run[..], 1e9 / period_ns) else { return };
        let mean_ns = (last.device_ns - first.device_ns) as f64 / (run.len() - 1) as f64;
        let to_period_ns = (mean_ns / TICK_NS).round() * TICK_NS;
        let to_hz = 1e9 / to_period_ns;
        self.events.push_back(GapEvent::RateChanged { from_hz, to_hz, until: Box::new(self.so_far()) });
        self.period_ns = Some(to_period_ns);
        self.envelope = Some(Envelope::new(to_period_ns * 1e-9));
        self.begin_anew(*first, GapEvent::UnknownGap);
        for stamped in &run[1..] {
            self.index += 1;
            self.add_sample(*stamped);
        }
    }

    /// Decides on the samples in doubt.
    fn decide(&mut self) {
        for doubtful in std::mem::take(&mut self.in_doubt) {
            if let Some(period_ns) = self.period_ns {
                self.judge(doubtful, period_ns);
            }
        }
    }

    fn judge(&mut self, stamped: Stamped, period_ns: f64) {
        let Some(interval_ns) = stamped.device_ns.checked_sub(self.last_ns) else {
            self.backwards += 1;
            return self.begin_anew(stamped, GapEvent::Restart);
        };
        if self.is_too_early(stamped, interval_ns) {
            return self.begin_anew(stamped, GapEvent::TimeStep);
        }
        let Some(periods) = whole_periods(interval_ns, period_ns) else {
            return self.begin_anew(stamped, GapEvent::UnknownGap);
        };
        self.add_missing(periods - 1);
        self.index += 1;
        self.add_sample(stamped);
    }

    /// Whether the sample arrived before its device time can have passed: a host may read late, and
    /// not early.
    fn is_too_early(&self, stamped: Stamped, interval_ns: u64) -> bool {
        let Some((least_ns, at)) = self.least_lag_ns.zip(stamped.at) else { return false };
        let earlier_ns = least_ns - (at.as_nanos() as f64 - stamped.device_ns as f64);
        earlier_ns > LATEST_ARRIVAL.as_nanos() as f64 + CLOCK_DIFFERENCE * interval_ns as f64
    }

    fn add_missing(&mut self, missing: u64) {
        if missing > 0 {
            self.index += missing;
            self.missing += missing;
            self.gaps += 1;
            self.events.push_back(GapEvent::Missing(missing));
        }
    }

    /// The sample follows the one before by an unknown time, for this reason.
    fn begin_anew(&mut self, stamped: Stamped, reason: GapEvent) {
        self.index = 0;
        (self.last_at, self.compared_from, self.least_lag_ns) = (None, None, None);
        if let Some(envelope) = &mut self.envelope {
            envelope.restart();
        }
        self.events.push_back(reason);
        self.add_sample(stamped);
    }

    fn add_sample(&mut self, stamped: Stamped) {
        let passed_ns = stamped.device_ns.saturating_sub(self.last_ns) as f64;
        self.last_ns = stamped.device_ns;
        if let Some(at) = stamped.at {
            let lag_ns = at.as_nanos() as f64 - stamped.device_ns as f64;
            let least_ns =
                self.least_lag_ns.map_or(lag_ns, |least_ns| lag_ns.min(least_ns + CLOCK_DIFFERENCE * passed_ns));
            self.least_lag_ns = Some(least_ns);
            if let Some(envelope) = &mut self.envelope {
                envelope.push(self.index, at.as_secs_f64());
            }
            let last_at = self.last_at.filter(|_| !std::mem::take(&mut self.after_outage));
            let since_last = last_at.map(|last| at.saturating_sub(last).as_micros() as u64);
            self.intervals.push(since_last);
            self.intervals.resolve(1);
            self.last_at = Some(at);
            self.compared_from.get_or_insert(at);
        }
        match self.events.back_mut() {
            Some(GapEvent::Samples(samples)) => *samples += 1,
            _ => self.events.push_back(GapEvent::Samples(1)),
        }
    }
}

/// How many periods the interval has, at least one; `None` if it is no whole number.
fn whole_periods(interval_ns: u64, period_ns: f64) -> Option<u64> {
    let quotient = interval_ns as f64 / period_ns;
    let periods = quotient.round();
    let is_whole = (quotient - periods).abs() <= TOLERANCE && (1.0..=MAX_PERIODS).contains(&periods);
    is_whole.then_some(periods as u64)
}

/// Of intervals in nanoseconds that are not zero; `None` without any. Whole ticks where the
/// intervals together are.
fn period_ns(intervals: impl Iterator<Item = u64> + Clone) -> Option<f64> {
    let least = intervals.clone().min()? as f64;
    let single: Vec<f64> = intervals.clone().map(|ns| ns as f64).filter(|ns| *ns <= 1.5 * least).collect();
    let mean_ns = single.iter().sum::<f64>() / single.len() as f64;
    let ticks_of = |ns: f64| (ns / TICK_NS).round();
    let (all_ns, all_ticks) =
        intervals.fold((0.0, 0.0), |(all_ns, ticks), ns| (all_ns + ns as f64, ticks + ticks_of(ns as f64)));
    let ticks = ticks_of(mean_ns);
    let is_whole = ticks >= 1.0
        && (mean_ns / TICK_NS - ticks).abs() <= TICK_TOLERANCE
        && (all_ns / (all_ticks * TICK_NS) - 1.0).abs() <= MEAN_TICK_TOLERANCE;
    Some(if is_whole { ticks * TICK_NS } else { mean_ns })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::gap_event::GapEvent::{
        DeviceTimeInUse, FalseTime, Missing, Restart, Samples, TimeStep, UnknownGap,
    };
    use super::*;

    const TICK: u64 = 1_250_000;

    fn events(device_ns: impl IntoIterator<Item = u64>) -> Vec<GapEvent> {
        let mut clock = DeviceClock::new();
        device_ns.into_iter().for_each(|ns| clock.push(ns, None));
        clock.finish();
        let mut events: Vec<GapEvent> = Vec::new();
        while let Some(event) = clock.events.pop_front() {
            match (events.last_mut(), &event) {
                (Some(Samples(before)), Samples(samples)) => *before += samples,
                _ => events.push(event),
            }
        }
        events
    }

    #[test]
    fn the_exact_vectors_miss_one_sample() {
        let expected = [DeviceTimeInUse { rate_hz: 800.0 }, Samples(2), Missing(1), Samples(1)];
        assert_eq!(events([TICK, 2 * TICK, 4 * TICK]), expected);
    }

    #[test]
    fn few_samples_show_what_they_can() {
        assert_eq!(events([]), []);
        assert_eq!(events([5]), [Samples(1)]);
        assert_eq!(events([9, 5]), [Samples(1), UnknownGap, Samples(1)]);
        assert_eq!(events([0, 5_000_000]), [DeviceTimeInUse { rate_hz: 200.0 }, Samples(2)]);
    }

    #[test]
    fn a_restart_is_no_gap() {
        let running = (100..140).map(|tick| tick * TICK);
        let restarted = (1..50).map(|tick| tick * TICK);
        let used = DeviceTimeInUse { rate_hz: 800.0 };
        assert_eq!(events(running.clone().chain(restarted)), [used.clone(), Samples(40), Restart, Samples(49)]);
        let later = (100_140..100_150).map(|tick| tick * TICK);
        assert_eq!(events(running.clone().chain(later)), [used.clone(), Samples(40), Missing(100_000), Samples(10)]);
        let off = (0..9).map(|tick| 140 * TICK + TICK / 2 + tick * TICK);
        assert_eq!(events(running.chain(off)), [used, Samples(40), UnknownGap, Samples(9)]);
    }

    #[test]
    fn a_time_that_neither_neighbour_confirms_is_false() {
        let used = DeviceTimeInUse { rate_hz: 800.0 };
        for false_ns in [0, 97 * TICK, 99 * TICK + TICK / 2, 102 * TICK, u64::MAX] {
            let times = (0..200).map(|tick| if tick == 100 { false_ns } else { tick * TICK });
            let expected = [used.clone(), Samples(100), FalseTime, Missing(1), Samples(99)];
            assert_eq!(events(times), expected, "{false_ns}");
        }
        // the last sample has no neighbour behind it
        let expected = [used.clone(), Samples(100), Missing(400), Samples(1)];
        assert_eq!(events((0..100).chain([500]).map(|tick| tick * TICK)), expected);
        let two = (0..200).map(|tick| if (100..102).contains(&tick) { 5 } else { tick * TICK });
        let found = events(two);
        let samples: u64 = found.iter().map(|event| if let Samples(samples) = event { *samples } else { 0 }).sum();
        assert_eq!(samples, 200, "{found:?}");
    }

    #[test]
    fn a_clock_runs_on_over_an_outage_if_the_host_agrees() {
        let clock = |samples: u64| {
            let mut clock = DeviceClock::new();
            for tick in 0..samples {
                clock.push(tick * TICK, Some(Duration::from_nanos(tick * TICK)));
            }
            clock.finish();
            clock.events.clear();
            clock
        };
        for (after_s, passed_s, expected) in [
            (10, 10.4, ClockAfterOutage::RunsOn),
            (10, 11.0, ClockAfterOutage::Unknown),
            (10, 9.0, ClockAfterOutage::Unknown),
            (86_400, 86_440.0, ClockAfterOutage::RunsOn),
        ] {
            let next_ns = 99 * TICK + after_s * 1_000_000_000;
            let at = Duration::from_nanos(99 * TICK) + Duration::from_secs_f64(passed_s);
            let mut clock = clock(100);
            assert_eq!(clock.after_outage(next_ns, at), expected, "{after_s} s, {passed_s} s");
            if expected == ClockAfterOutage::RunsOn {
                clock.push(next_ns, Some(at));
                clock.push(next_ns + TICK, Some(at));
                assert_eq!(clock.events, [Missing(after_s * 800 - 1), Samples(2)]);
                assert_eq!(clock.summary().unwrap().arrivals.unwrap().max_us, 1250, "an outage is no interval");
            }
        }
        let second = Duration::from_secs(1);
        assert_eq!(clock(100).after_outage(7 * TICK, second), ClockAfterOutage::Restarted);
        assert_eq!(clock(100).after_outage(1_124_100_000, second), ClockAfterOutage::Unknown, "no whole period");
        assert_eq!(clock(9).after_outage(800 * TICK, second), ClockAfterOutage::Unknown, "too few for a period");
    }

    #[test]
    fn a_clock_without_such_ticks_has_its_mean_interval() {
        let every_ms = (0..100).map(|ms| ms * 1_000_000);
        assert_eq!(events(every_ms), [DeviceTimeInUse { rate_hz: 1000.0 }, Samples(100)]);
    }

    #[test]
    fn as_many_equal_intervals_as_show_a_rate_are_another_rate() {
        let fast = (0..100).map(|tick| tick * TICK);
        let slow = (0..100).map(|sample| 99 * TICK + (sample + 1) * 4 * TICK);
        let found = events(fast.chain(slow));
        let changed = |event: &GapEvent| matches!(event, GapEvent::RateChanged { from_hz: 800.0, to_hz: 200.0, .. });
        assert_eq!(found.iter().filter(|event| changed(event)).count(), 1);
        assert_eq!(found[1..2], [Samples(100)], "{found:?}");
        assert_eq!(found[3..], [UnknownGap, Samples(100)], "{found:?}");
        let (fast, slow) =
            ((0..100).map(|sample| sample * 4 * TICK), (0..100).map(|tick| 396 * TICK + (tick + 1) * TICK));
        let found = events(fast.chain(slow));
        let changed = |event: &GapEvent| matches!(event, GapEvent::RateChanged { from_hz: 200.0, to_hz: 800.0, .. });
        assert_eq!(found.iter().filter(|event| changed(event)).count(), 1, "{found:?}");
        assert_eq!((&found[1], &found[3..]), (&Samples(100), &[UnknownGap, Samples(100)][..]));
        // too few for a rate: every second one was dropped
        let halved = (0..100).chain((101..141).step_by(2)).chain(142..160).map(|tick| tick * TICK);
        let missing = events(halved).iter().filter(|event| **event == Missing(1)).count();
        assert_eq!(missing, 20, "and two before the last part");
    }

    #[test]
    fn a_time_that_steps_ahead_of_its_arrival_is_no_gap() {
        let stepped = |ahead_ns: u64, late: &dyn Fn(u64) -> u64| {
            let mut clock = DeviceClock::new();
            for tick in 0..4000_u64 {
                let ahead_ns = if tick < 2000 { 0 } else { ahead_ns };
                clock.push(tick * TICK + ahead_ns, Some(Duration::from_nanos(tick * TICK + late(tick))));
            }
            clock.finish();
            let is_gap = |event: &GapEvent| matches!(event, Missing(_) | UnknownGap | TimeStep | Restart);
            clock.events.into_iter().filter(is_gap).collect::<Vec<_>>()
        };
        let prompt = |_| 0;
        assert_eq!(stepped(7_200_000_000_000, &prompt), [TimeStep]);
        assert_eq!(stepped(500_000_000 + 2 * TICK, &prompt), [TimeStep]);
        // half a second may be the delay of a first read
        assert_eq!(stepped(400_000_000, &prompt), [Missing(320)]);
        // the host read nothing for two seconds, in which a buffer lost one of them
        let stalled = |tick: u64| if (1900..2200).contains(&tick) { 2_000_000_000 } else { 1_000_000_000 };
        assert_eq!(stepped(800 * TICK, &|tick| if tick < 1900 { 0 } else { stalled(tick) }), [Missing(800)]);
    }

    #[test]
    fn a_mean_tick_that_is_off_is_no_tick() {
        let rate = |period_ns: u64| match events((0..60).map(|sample| sample * period_ns))[0] {
            DeviceTimeInUse { rate_hz } => rate_hz,
            ref other => panic!("{other:?}"),
        };
        assert_eq!((rate(1_250_300), rate(5_001_000)), (800.0, 200.0), "a clock off by 240 ppm");
        assert!((rate(1_275_000) - 784.3).abs() < 0.1, "2 % slow");
    }

    #[test]
    fn the_offset_of_the_clocks_shows_after_a_minute() {
        // the sensor's clock is 20 ppm fast, and reads come up to 4 ms late
        let mut clock = DeviceClock::new();
        for tick in 0..200_000_u64 {
            let late_ns = tick.wrapping_mul(2_654_435_761) % 4_000_000;
            let at = Duration::from_nanos(9_000_000_000 + (tick as f64 * 1_250_000.0 / (1.0 + 20e-6)) as u64 + late_ns);
            clock.push(7_000_000 + tick * TICK, Some(at));
            if tick == 40_000 {
                assert_eq!(clock.summary().and_then(|summary| summary.offset_ppm), None);
            }
        }
        let summary = clock.summary().unwrap();
        let ppm = summary.offset_ppm.unwrap();
        assert!((ppm - 20.0).abs() < 1.0, "{ppm}");
        assert_eq!((summary.nominal, summary.missing), (Some(NominalRate::Known(800.0)), 0));
    }

    proptest! {
        #[test]
        fn gaps_are_counted_at_any_rate_and_jitter(
            divisor in 1_u64..800,
            dropped in proptest::collection::btree_set(40_u64..400, 0..40),
            seed: u64,
        ) {
            // as much as real sensors have at 800 Hz, in microseconds
            let jitter = |sample: u64| (sample.wrapping_mul(seed | 1) >> 33) % 55;
            let kept: Vec<u64> = (0..400).filter(|sample| !dropped.contains(sample)).collect();
            let found = events(kept.iter().map(|sample| 1_000_000_000 + sample * divisor * TICK + jitter(*sample) * 1000));
            let rate_hz = 800.0 / divisor as f64;
            prop_assert_eq!(&found[0], &DeviceTimeInUse { rate_hz });
            let missing: u64 = found.iter().map(|event| if let Missing(missing) = event { *missing } else { 0 }).sum();
            let last = kept[kept.len() - 1];
            prop_assert_eq!(missing, last + 1 - kept.len() as u64);
            prop_assert!(!found.contains(&UnknownGap));
        }
    }
}
