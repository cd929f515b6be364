//! Which source decides the sample rate, and what a change of the rate does.

use imu_noise::timebase::{GapDetector, NominalRate, Refusal, TimebaseSummary};
use vn100_protocol::{BINARY, Layout};

use super::{measured_span::MeasuredSpan, sensor_rates::rates_hz};
use crate::{rate_change::RateChange, settings::DEFAULT_RATE_HZ, snapshot::RateFrom, warning::Finding};

/// Clock offset above which a measured rate does not confirm the nominal one: no quartz is off by
/// that much.
const CLOCK_PPM: f64 = 1000.0;

/// The source of the sample rate of a record, when it was wrong, and when it changed. The sources
/// by rank: device times, the user, the sensor's setting, arrival times, the default. An exception:
/// seconds of arrivals at exactly another rate show that the setting is not that of the stream.
///
/// A deviation has one sample interval: samples at another rate are excluded.
#[derive(Debug, Clone, Default)]
pub(crate) struct RateAuthority {
    rates_hz: &'static [f64],
    pub(super) rate: Rate,
    change: Option<DatedChange>,
    /// Summary of the most telling connection that has ended and whose rate was found.
    confirmed: Option<TimebaseSummary>,
    /// The rate that the sensor reported last, in hertz.
    reported_hz: Option<f64>,
    /// The first refusal of arrival stamps in a connection that has ended.
    pub(super) refused_before: Option<Refusal>,
    pub(super) false_rate: Option<Finding>,
    pub(super) false_report: Option<Finding>,
    /// Summary of the stretch that is the result, if it is not the last one.
    pub(super) measured: Option<TimebaseSummary>,
    /// Samples excluded at another rate before the stream returned to the rate of the record.
    pub(super) other_rate_samples: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rate {
    pub(crate) hz: f64,
    pub(crate) from: RateFrom,
    /// Whether the arrival times that decided the rate were too few to be certain.
    pub(crate) is_by_few: bool,
}

impl Default for Rate {
    fn default() -> Self {
        Self { hz: DEFAULT_RATE_HZ, from: RateFrom::Assumed, is_by_few: false }
    }
}

#[derive(Debug, Clone, Copy)]
struct DatedChange {
    change: RateChange,
    /// Summary of the samples before the change.
    until: Option<TimebaseSummary>,
    excluded: u64,
}

/// What a decision on the rate means for the record.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub(crate) enum RateEffect {
    /// No effect.
    None,
    /// The rate of the sensor is used; arrival times must confirm it.
    Known(f64),
    /// Samples are excluded from here on.
    Exclude,
    /// Samples count again, after a gap of unknown length.
    Resume,
    /// The samples so far were placed by a false rate: the record starts over at this one.
    Replace(f64),
    /// The samples so far, if there are any, were placed by a rate that is not theirs: the record
    /// starts over at the other one. Data time so far was counted by the first one.
    Discard { from_hz: f64, to_hz: f64 },
}

impl RateAuthority {
    /// An authority with the rate that the user gave, in hertz; `None` for the default.
    pub(crate) fn new(given_hz: Option<f64>) -> Self {
        let given = given_hz.map(|hz| Rate { hz, from: RateFrom::Option, is_by_few: false });
        Self { rate: given.unwrap_or_default(), ..Self::default() }
    }

    pub(crate) fn set_layout(&mut self, layout: &Layout) {
        self.rates_hz = rates_hz(Some(layout));
        // the register applies to sentences only
        if layout.message == BINARY && self.rate.from == RateFrom::Device {
            self.rate = Rate::default();
        }
    }

    pub(crate) const fn hz(&self) -> f64 {
        self.rate.hz
    }

    pub(crate) const fn is_open(&self) -> bool {
        match self.rate.from {
            RateFrom::Assumed => true,
            RateFrom::Arrival => self.rate.is_by_few,
            RateFrom::Option | RateFrom::DeviceTime | RateFrom::Device => false,
        }
    }

    /// Whether the rows are those of a table, which may be of any sensor.
    pub(crate) const fn is_table(&self) -> bool {
        self.rates_hz.is_empty()
    }

    /// Whether nothing but arrival times tells the rate, and any rate is possible.
    pub(crate) const fn is_of_any_sensor(&self) -> bool {
        self.rates_hz.is_empty() && matches!(self.rate.from, RateFrom::Arrival | RateFrom::Assumed)
    }

    /// Forgets the rate if nothing but the refused arrival times tells it.
    pub(crate) fn refuse_arrivals(&mut self) {
        if self.is_of_any_sensor() {
            self.rate = Rate::default();
        }
    }

    /// Uses a rate by arrival times.
    pub(crate) fn set_measured(&mut self, hz: f64) {
        self.set(hz, RateFrom::Arrival);
    }

    pub(crate) const fn is_excluding(&self) -> bool {
        self.change.is_some()
    }

    /// A gap detector for the stamps of a new connection. A known rate is used from the first sample
    /// on; one that the user did not give gives way to even arrivals at another rate.
    pub(crate) fn detector(&self) -> GapDetector {
        let is_given = self.rate.from == RateFrom::Option;
        let mut detector = GapDetector::new(self.rates_hz, is_given.then_some(self.rate.hz));
        if !is_given && !self.is_open() && !self.is_excluding() {
            detector.set_reported_rate(self.rate.hz);
        }
        detector
    }

    /// Takes the nominal rate of the detector; `device_hz` is that reported by the sensor.
    pub(crate) fn take_nominal(
        &mut self,
        nominal: NominalRate,
        device_hz: Option<f64>,
        span: &MeasuredSpan,
    ) -> RateEffect {
        match nominal {
            NominalRate::Known(hz) => self.rate.hz = hz,
            NominalRate::Snapped(hz) if self.rate.from == RateFrom::Device && hz != self.rate.hz => {
                return self.contradict_report(hz, span);
            }
            NominalRate::Snapped(hz) if !self.is_open() && hz != self.rate.hz && span.samples > 0 => {
                return self.take_change(self.rate.hz, hz, self.at_the_rate(None), span);
            }
            NominalRate::Snapped(hz) | NominalRate::Measured(hz) => {
                self.set(hz, RateFrom::Arrival);
                self.attribute_to(device_hz);
            }
        }
        RateEffect::None
    }

    /// Arrival times show another rate than the sensor reports. Where those of an earlier
    /// connection confirmed the reported rate, the rate has changed since then.
    fn contradict_report(&mut self, arrival_hz: f64, span: &MeasuredSpan) -> RateEffect {
        let from_hz = self.rate.hz;
        if let Some(before) = self.at_the_rate(None) {
            return self.take_change(from_hz, arrival_hz, Some(before), span);
        }
        self.set(arrival_hz, RateFrom::Arrival);
        self.false_rate = None;
        self.false_report = Some(Finding::FalseReport { reported_hz: from_hz, arrival_hz });
        RateEffect::Discard { from_hz, to_hz: arrival_hz }
    }

    /// Takes the rate that the device times of the samples show.
    pub(crate) fn take_device_time(&mut self, device_hz: f64, span: &MeasuredSpan) -> RateEffect {
        let hz = self.rate.hz;
        let is_same = device_hz == hz;
        if span.samples > 0 && (!is_same || self.is_excluding()) {
            return self.take_change(hz, device_hz, None, span);
        }
        self.set(device_hz, RateFrom::DeviceTime);
        if is_same { RateEffect::None } else { RateEffect::Discard { from_hz: hz, to_hz: device_hz } }
    }

    /// A connection has ended after so few samples that a later one decides on their rate.
    pub(crate) fn doubt(&mut self) {
        self.rate.is_by_few = self.rate.from == RateFrom::Arrival;
    }

    /// Takes a change of the rate; `until` summarises the samples before it. Before the first
    /// sample that counts the new rate becomes that of the record, unless the user gave one.
    pub(crate) fn take_change(
        &mut self,
        from_hz: f64,
        to_hz: f64,
        until: Option<TimebaseSummary>,
        span: &MeasuredSpan,
    ) -> RateEffect {
        if span.samples == 0 && self.rate.from != RateFrom::Option {
            self.rate.hz = to_hz;
            return RateEffect::Discard { from_hz, to_hz };
        }
        match self.change {
            // delayed bytes arrived as fast as the link carries them, or the rate was restored
            Some(change) if to_hz == self.rate.hz => {
                self.change = None;
                self.other_rate_samples += span.excluded - change.excluded;
                RateEffect::Resume
            }
            Some(_) => RateEffect::None,
            None => {
                self.false_report = None;
                let change = RateChange { after_samples: span.samples, from_hz, to_hz };
                self.change = Some(DatedChange { change, until, excluded: span.excluded });
                RateEffect::Exclude
            }
        }
    }

    /// Takes a rate that the sensor reports; `now` summarises the present connection. Another one than
    /// before is a change of the setting; a first one that the arrival times contradict is false.
    pub(crate) fn take_device_rate(
        &mut self,
        device_hz: f64,
        now: impl Fn() -> Option<TimebaseSummary>,
        span: &MeasuredSpan,
    ) -> RateEffect {
        let was_set = self.reported_hz.replace(device_hz).is_some_and(|before_hz| before_hz != device_hz);
        if self.is_open() {
            self.set(device_hz, RateFrom::Device);
            return RateEffect::Known(device_hz);
        }
        let differs = device_hz != self.rate.hz;
        match self.rate.from {
            // the sensor restarted with other settings, or was configured again
            RateFrom::Device if differs => self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), span),
            RateFrom::Arrival if differs && self.change.is_none() => {
                let is_confirmed = now().is_some_and(|now| is_confirmed_by(&now));
                if was_set && is_confirmed {
                    return self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), span);
                }
                if !is_confirmed && self.false_report.is_none() {
                    return RateEffect::Replace(device_hz);
                }
                self.false_report = Some(Finding::FalseReport { reported_hz: device_hz, arrival_hz: self.rate.hz });
                RateEffect::None
            }
            _ => {
                self.attribute_to(Some(device_hz));
                RateEffect::None
            }
        }
    }

    /// Replaces a false rate, by which this many `samples` were placed.
    pub(crate) fn replace(&mut self, device_hz: f64, samples: u64) {
        self.refused_before = None;
        self.false_rate = (samples > 0).then_some(Finding::FalseRate { samples, arrival_hz: self.rate.hz, device_hz });
        self.set(device_hz, RateFrom::Device);
    }

    /// Ends a connection. What it shows of the rate is kept, unless its samples were excluded.
    pub(crate) fn end_connection(&mut self, ended: Option<TimebaseSummary>) {
        if !self.is_excluding() {
            self.refused_before = self.refused_before.or_else(|| ended?.refusal);
            let found = ended.filter(|ended| ended.nominal.is_some());
            self.confirmed = telling(found, self.confirmed);
        }
    }

    pub(crate) fn start_over(&mut self) {
        (self.change, self.false_rate) = (None, None);
    }

    /// The change of rate after which samples are excluded; `None` where there was none.
    pub(crate) fn change(&self) -> Option<RateChange> {
        self.change.map(|change| change.change)
    }

    /// What arrival times show of the samples that count; `now`: of the present connection.
    pub(crate) fn arrivals(&self, now: impl FnOnce() -> Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        let of_connections = || telling(now(), self.confirmed);
        self.measured.or_else(|| self.change.map_or_else(of_connections, |change| change.until))
    }

    fn set(&mut self, hz: f64, from: RateFrom) {
        self.rate = Rate { hz, from, is_by_few: false };
    }

    /// Makes the sensor the authority where its reported rate agrees with the arrival times.
    fn attribute_to(&mut self, device_hz: Option<f64>) {
        if self.rate.from == RateFrom::Arrival && device_hz == Some(self.rate.hz) {
            self.rate.from = RateFrom::Device;
        }
    }

    fn at_the_rate(&self, now: Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        let has_rate = |summary: &TimebaseSummary| summary.nominal.is_some_and(|nominal| nominal.hz() == self.rate.hz);
        [now, self.confirmed].into_iter().flatten().find(has_rate)
    }
}

/// The latest connection that shows something of the rate. A shorter one that shows nothing else than
/// the one before, neither another rate nor stamps that were refused, does not take its place.
fn telling(latest: Option<TimebaseSummary>, before: Option<TimebaseSummary>) -> Option<TimebaseSummary> {
    let (Some(now), Some(then)) = (latest, before) else { return latest.or(before) };
    let is_other = now.refusal.is_some() || now.nominal.is_some() && now.nominal != then.nominal;
    if is_other || now.samples >= then.samples { latest } else { before }
}

/// Whether arrival times confirm the rate: a sensor that then reports another rate was configured
/// again.
fn is_confirmed_by(now: &TimebaseSummary) -> bool {
    matches!(now.nominal, Some(NominalRate::Snapped(_))) && now.offset_ppm.is_some_and(|ppm| ppm.abs() < CLOCK_PPM)
}
#[cfg(test)]
mod tests;
