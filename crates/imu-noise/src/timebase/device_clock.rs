//! Missing samples from the device time of each sample.

mod doubtful_run;
mod ticks;

use std::time::Duration;

use super::envelope::Envelope;
use super::gap_event::{GapEvent, GapEvents, NominalRate, TimebaseSummary};
use super::interval_statistics::IntervalStatistics;
use super::sensor_rates::RUN;
use super::whole_steps::{TOLERANCE, whole_steps};
use doubtful_run::{Stamped, is_continued_by, period_of_run_ns};
use ticks::period_ns;

/// A record shorter than this shows no offset between the clocks of sensor and host.
const MIN_COMPARED: Duration = Duration::from_secs(60);

/// The largest difference of the duration of an outage between the clocks of sensor and host:
/// samples may wait that long in the host, and the rates of the clocks may differ by that fraction.
const LATEST_ARRIVAL: Duration = Duration::from_millis(500);
const CLOCK_DIFFERENCE: f64 = 1e-3;

/// Judges the device times of the samples of a stream, in bounded memory.
///
/// The period is a whole number of ticks of 1.25 ms if the mean of the shortest of the first 31
/// intervals is one, else that mean; it is correct if there are two consecutive samples among them.
/// An interval of n periods, n an integer, means n - 1 missing samples. Other intervals break the
/// record:
///
/// - a time that decreases is a restart of the sensor, [`GapEvent::Restart`];
/// - a time for which the sample would have arrived before it was sent is a step of the sensor's
///   clock, [`GapEvent::TimeStep`];
/// - any other interval belongs to another clock, [`GapEvent::UnknownGap`];
/// - 31 equal intervals of another length are another rate.
///
/// A sample that does not follow by one period is in doubt until the next one arrives. If the next
/// one follows the sample before the doubtful one by two periods, the doubtful time is false,
/// [`GapEvent::FalseTime`]. If its interval is equal to the doubtful one, both samples are in
/// doubt.
#[derive(Clone, Debug, Default)]
pub(super) struct DeviceClock {
    last_ns: u64,
    last_at: Option<Duration>,
    /// The first samples, pending until the period is known; empty after that.
    held: Vec<Stamped>,
    period_ns: Option<f64>,
    /// The latest samples, if their intervals are equal and not one period: a false time, the samples
    /// after a gap, or the first ones at another rate.
    in_doubt: Vec<Stamped>,
    /// Whether the next sample is the first one after an outage.
    after_outage: bool,
    /// Index of the last sample, in periods since the start of the time base.
    index: u64,
    /// The least time in nanoseconds from a device time to its arrival, each with its own origin;
    /// the value grows with time, because the clocks may drift.
    least_lag_ns: Option<f64>,
    envelope: Option<Envelope>,
    intervals: IntervalStatistics,
    /// The arrival time from which the offset of the clocks is measured.
    compared_from: Option<Duration>,
    samples: u64,
    backwards: u64,
    pub(super) events: GapEvents,
}

/// The state of the sensor's clock according to the first sample after an outage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockAfterOutage {
    /// The clock kept running: the next interval shows the number of missing samples.
    RunsOn,
    /// The clock restarted.
    Restarted,
    /// Not known: there is no device time, or no arrival time to confirm it, or the two differ.
    Unknown,
}

impl DeviceClock {
    /// Takes the next sample; `at` is the arrival time, if it is known.
    pub(super) fn push(&mut self, device_ns: u64, at: Option<Duration>) {
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

    /// Ends the stream: decides on the pending samples.
    pub(super) fn finish(&mut self) {
        self.learn_period();
        self.decide();
    }

    /// Whether the clock of the sensor kept running over an outage, if this sample is the first one
    /// after it. Call [`finish`](Self::finish) before.
    pub(super) fn after_outage(&mut self, device_ns: u64, at: Duration) -> ClockAfterOutage {
        let Some(interval_ns) = device_ns.checked_sub(self.last_ns) else { return ClockAfterOutage::Restarted };
        let known = self.period_ns.filter(|_| self.samples >= RUN as u64);
        let (Some(period_ns), Some(last)) = (known, self.last_at) else {
            return ClockAfterOutage::Unknown;
        };
        let (interval, passed) = (Duration::from_nanos(interval_ns), at.saturating_sub(last));
        let difference = passed.abs_diff(interval);
        self.after_outage = whole_steps(interval_ns, period_ns).is_some()
            && difference <= LATEST_ARRIVAL + interval.mul_f64(CLOCK_DIFFERENCE);
        if self.after_outage { ClockAfterOutage::RunsOn } else { ClockAfterOutage::Unknown }
    }

    /// The offset of the sensor's clock according to the arrival times; `None` without arrival times.
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
            missing: self.events.missing,
            gaps: self.events.gaps,
            arrivals: nominal.and_then(|nominal| self.intervals.summary(nominal.hz().recip())),
            ..TimebaseSummary::default()
        }
    }

    fn learn_period(&mut self) {
        let held = std::mem::take(&mut self.held);
        let Some(first) = held.first() else { return };
        let intervals = || held.windows(2).filter_map(|pair| pair[1].device_ns.checked_sub(pair[0].device_ns));
        if let Some(period_ns) = period_ns(intervals().filter(|ns| *ns > 0)) {
            self.period_ns = Some(period_ns);
            self.envelope = Some(Envelope::new(period_ns * 1e-9));
            self.events.push(GapEvent::DeviceTimeInUse { rate_hz: 1e9 / period_ns });
        }
        self.add_sample(*first);
        for stamped in &held[1..] {
            match self.period_ns {
                Some(period_ns) => self.take(*stamped, period_ns),
                // without an interval there is no period
                None => {
                    self.events.push(GapEvent::UnknownGap);
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
        // the case of nearly every sample
        if self.in_doubt.is_empty() && periods_after(self.last_ns, 1.0) {
            self.index += 1;
            return self.add_sample(stamped);
        }
        if let [doubtful] = self.in_doubt[..]
            && periods_after(self.last_ns, 2.0)
            && !periods_after(doubtful.device_ns, 1.0)
        {
            self.in_doubt.clear();
            self.events.push(GapEvent::FalseTime);
            self.add_missing(1);
            self.index += 1;
            return self.add_sample(stamped);
        }
        if !is_continued_by(&self.in_doubt, stamped, self.last_ns) {
            self.decide();
            return self.take(stamped, self.period_ns.unwrap_or(period_ns));
        }
        self.in_doubt.push(stamped);
        if let Some(to_period_ns) = period_of_run_ns(&self.in_doubt) {
            self.change_rate(period_ns, to_period_ns);
        }
    }

    /// The samples in doubt arrive at another rate.
    fn change_rate(&mut self, period_ns: f64, to_period_ns: f64) {
        let (from_hz, to_hz) = (1e9 / period_ns, 1e9 / to_period_ns);
        self.events.push(GapEvent::RateChanged { from_hz, to_hz, until: Box::new(self.so_far()) });
        self.period_ns = Some(to_period_ns);
        self.envelope = Some(Envelope::new(to_period_ns * 1e-9));
        let mut run = std::mem::take(&mut self.in_doubt).into_iter();
        if let Some(first) = run.next() {
            self.begin_anew(first, GapEvent::UnknownGap);
        }
        for stamped in run {
            self.index += 1;
            self.add_sample(stamped);
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
        let Some(periods) = whole_steps(interval_ns, period_ns) else {
            return self.begin_anew(stamped, GapEvent::UnknownGap);
        };
        self.add_missing(periods - 1);
        self.index += 1;
        self.add_sample(stamped);
    }

    /// Whether the sample arrived before its device time: a host may read late, but not early.
    fn is_too_early(&self, stamped: Stamped, interval_ns: u64) -> bool {
        let Some((least_ns, at)) = self.least_lag_ns.zip(stamped.at) else { return false };
        let earlier_ns = least_ns - (at.as_nanos() as f64 - stamped.device_ns as f64);
        earlier_ns > LATEST_ARRIVAL.as_nanos() as f64 + CLOCK_DIFFERENCE * interval_ns as f64
    }

    fn add_missing(&mut self, missing: u64) {
        self.index += missing;
        self.events.push(GapEvent::Missing(missing));
    }

    /// Starts the time base again at this sample, which comes an unknown time after the one before,
    /// for this reason.
    fn begin_anew(&mut self, stamped: Stamped, reason: GapEvent) {
        self.index = 0;
        (self.last_at, self.compared_from, self.least_lag_ns) = (None, None, None);
        if let Some(envelope) = &mut self.envelope {
            envelope.restart();
        }
        self.events.push(reason);
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
            if let Some(last) = last_at {
                self.intervals.push(at.saturating_sub(last).as_micros() as u64);
            }
            self.last_at = Some(at);
            self.compared_from.get_or_insert(at);
        }
        self.events.push(GapEvent::Samples(1));
    }
}

#[cfg(test)]
mod tests;
