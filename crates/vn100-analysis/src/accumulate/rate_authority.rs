//! Which source decides the sample rate, and what a change of it does.

use imu_noise::{BadEncoding, Decoder, Encoded, GapDetector, NominalRate, Refusal, TimebaseSummary};
use vn100_protocol::{BINARY, Layout, MESSAGES, OUTPUT_RATES_HZ};

use super::measured_span::MeasuredSpan;
use crate::{
    settings::DEFAULT_RATE_HZ,
    snapshot::{FalseRate, FalseReport, RateChange, RateFrom},
};

/// Relative error of a measured rate that is still one of the sensor's: no clock is that far off.
const SAME_RATE: f64 = 0.01;

/// Above, a measured rate does not confirm the nominal one: no quartz is off by so much.
const CLOCK_PPM: f64 = 1000.0;

/// The sensor's output rates in hertz.
static OUTPUT_RATES: [f64; OUTPUT_RATES_HZ.len()] = {
    let mut rates = [0.0; OUTPUT_RATES_HZ.len()];
    let mut index = 0;
    while index < rates.len() {
        rates[index] = OUTPUT_RATES_HZ[index] as f64;
        index += 1;
    }
    rates
};

/// Those of its binary outputs with a whole number of packets a second.
static PACKET_RATES: [f64; 18] =
    [800.0, 400.0, 200.0, 160.0, 100.0, 80.0, 50.0, 40.0, 32.0, 25.0, 20.0, 16.0, 10.0, 8.0, 5.0, 4.0, 2.0, 1.0];

/// Of the sensor that sends this message, in hertz; none for columns that may be of any sensor.
pub(crate) fn rates_hz(layout: Option<&Layout>) -> &'static [f64] {
    let is_sentence = layout.is_some_and(|layout| MESSAGES.iter().any(|output| output.message == layout.message));
    match layout {
        Some(layout) if layout.message == BINARY => &PACKET_RATES,
        _ if is_sentence => &OUTPUT_RATES,
        _ => &[],
    }
}

/// The source of the sample rate of a record, when it was wrong, and when it changed. Device times
/// outrank the user, who outranks the sensor's setting, that arrival times, and these the default;
/// but seconds of arrivals at exactly another rate show that the setting is not that of the stream.
/// A deviation has one sample interval: samples at another rate are excluded.
#[derive(Debug, Clone)]
pub(crate) struct RateAuthority {
    rates_hz: &'static [f64],
    pub(super) rate: Rate,
    change: Option<DatedChange>,
    /// Summary of the last connection that is over and had a rate.
    confirmed: Option<TimebaseSummary>,
    /// What the sensor reported last, in hertz.
    reported_hz: Option<f64>,
    /// The first refusal of stamps in a connection that is over.
    pub(super) refused_before: Option<Refusal>,
    pub(super) false_rate: Option<FalseRate>,
    pub(super) false_report: Option<FalseReport>,
    /// Samples excluded at another rate, until it was the rate of the record again.
    pub(super) other_rate_samples: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rate {
    pub(crate) hz: f64,
    pub(crate) from: RateFrom,
    /// How many samples arrival times decided by, where these are too few to be sure.
    pub(crate) by_few: Option<u64>,
}

#[derive(Debug, Clone, Copy)]
struct DatedChange {
    change: RateChange,
    /// Summary of the samples before.
    until: Option<TimebaseSummary>,
    excluded: u64,
}

/// What a decision on the rate means for the record.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub(crate) enum RateEffect {
    /// Nothing.
    None,
    /// The sensor's rate is taken; arrival times must confirm it.
    Known(f64),
    /// No sample counts yet: the record takes the new rate; data time so far was by the old one.
    Rescale { from_hz: f64, to_hz: f64 },
    /// Samples are excluded from here on.
    Exclude,
    /// Samples count again, after a gap of unknown length.
    Resume,
    /// The samples so far were placed by a false rate: the record begins anew at this one.
    Replace(f64),
    /// They were placed by a rate that the sensor reported falsely: the same.
    Discard { from_hz: f64, to_hz: f64 },
}

impl RateAuthority {
    /// The rate that the user gave in hertz, else the default.
    pub(crate) const fn new(given_hz: Option<f64>) -> Self {
        let (hz, from) = match given_hz {
            Some(hz) => (hz, RateFrom::Option),
            None => (DEFAULT_RATE_HZ, RateFrom::Assumed),
        };
        Self {
            rates_hz: &[],
            rate: Rate { hz, from, by_few: None },
            change: None,
            confirmed: None,
            reported_hz: None,
            refused_before: None,
            false_rate: None,
            false_report: None,
            other_rate_samples: 0,
        }
    }

    pub(crate) fn set_layout(&mut self, layout: &Layout) {
        self.rates_hz = rates_hz(Some(layout));
        // the register is that of sentences
        if layout.message == BINARY && self.rate.from == RateFrom::Device {
            self.set(DEFAULT_RATE_HZ, RateFrom::Assumed);
        }
    }

    pub(crate) const fn hz(&self) -> f64 {
        self.rate.hz
    }

    pub(crate) const fn is_open(&self) -> bool {
        match self.rate.from {
            RateFrom::Assumed => true,
            RateFrom::Arrival => self.rate.by_few.is_some(),
            RateFrom::Option | RateFrom::DeviceTime | RateFrom::Device => false,
        }
    }

    pub(crate) const fn is_excluding(&self) -> bool {
        self.change.is_some()
    }

    /// A detector for the stamps that come now. They must confirm a rate that is known.
    pub(crate) fn detector(&self) -> GapDetector {
        let is_reported = self.rate.from == RateFrom::Device;
        let known_hz = (!self.is_open() && !is_reported).then_some(self.rate.hz);
        let mut detector = GapDetector::new(self.rates_hz, known_hz);
        if is_reported {
            detector.set_reported_rate(self.rate.hz);
        }
        detector
    }

    /// The detector has this nominal rate; the sensor reported that one.
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
            NominalRate::Snapped(hz) | NominalRate::Measured(hz) => {
                self.set(hz, RateFrom::Arrival);
                self.attribute_to(device_hz);
            }
        }
        RateEffect::None
    }

    /// Arrivals show another rate than the sensor reports. If those of an earlier connection
    /// confirmed that, it has changed since.
    fn contradict_report(&mut self, arrival_hz: f64, span: &MeasuredSpan) -> RateEffect {
        let from_hz = self.rate.hz;
        if let Some(before) = self.at_the_rate(None) {
            return self.take_change(from_hz, arrival_hz, Some(before), span);
        }
        self.set(arrival_hz, RateFrom::Arrival);
        self.false_rate = None;
        self.false_report = Some(FalseReport { reported_hz: from_hz, arrival_hz });
        match span.samples {
            0 => RateEffect::Rescale { from_hz, to_hz: arrival_hz },
            _ => RateEffect::Discard { from_hz, to_hz: arrival_hz },
        }
    }

    /// The device times of the samples show this rate.
    pub(crate) fn take_device_time(&mut self, device_hz: f64, span: &MeasuredSpan) -> RateEffect {
        let hz = self.rate.hz;
        let is_same = device_hz == hz;
        if span.samples > 0 && (!is_same || self.is_excluding()) {
            return self.take_change(hz, device_hz, None, span);
        }
        self.set(device_hz, RateFrom::DeviceTime);
        if is_same { RateEffect::None } else { RateEffect::Rescale { from_hz: hz, to_hz: device_hz } }
    }

    /// A connection is over after so few `samples` that their rate is not sure: it holds until a
    /// later one decides, and more samples are better evidence than fewer.
    pub(crate) fn prefer_longer_evidence(&mut self, samples: u64, before: Rate) {
        if before.by_few.is_some_and(|more| more > samples) {
            self.rate = before;
        } else if self.rate.from == RateFrom::Arrival {
            self.rate.by_few = Some(samples);
        }
    }

    /// The stream is over: where no list of rates says which one was meant, the rate of all samples
    /// is that of the record, and not that of the first ones.
    pub(crate) fn take_whole_record(&mut self, summary: &TimebaseSummary) {
        if let (Some(NominalRate::Measured(first_hz)), Some(hz)) = (summary.nominal, summary.measured_hz)
            && self.rate.from == RateFrom::Arrival
            && self.rate.hz == first_hz
            && self.change.is_none()
            && (hz / first_hz - 1.0).abs() < SAME_RATE
        {
            self.rate.hz = hz;
        }
    }

    /// `until` summarises the samples before. Before the first sample that counts the new rate is
    /// that of the record, unless the user gave one.
    pub(crate) fn take_change(
        &mut self,
        from_hz: f64,
        to_hz: f64,
        until: Option<TimebaseSummary>,
        span: &MeasuredSpan,
    ) -> RateEffect {
        if span.samples == 0 && self.rate.from != RateFrom::Option {
            self.rate.hz = to_hz;
            return RateEffect::Rescale { from_hz, to_hz };
        }
        match self.change {
            // delayed bytes came as fast as the link carries them, or the sensor was set back
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

    /// If refused stamps show another rate after a reconnect, though those before confirmed the
    /// known one, it has changed; a rate that the user gave is kept.
    pub(crate) fn take_refusal(&mut self, refusal: Refusal, span: &MeasuredSpan) -> RateEffect {
        match (refusal, self.confirmed.filter(|before| self.is_at_the_rate(before))) {
            (Refusal::OtherRate { known_hz, measured_hz }, Some(before)) if self.rate.from != RateFrom::Option => {
                let mut listed_hz = self.rates_hz.iter().copied();
                let to_hz = listed_hz.find(|hz| (measured_hz / hz - 1.0).abs() < SAME_RATE).unwrap_or(measured_hz);
                self.take_change(known_hz, to_hz, Some(before), span)
            }
            _ => RateEffect::None,
        }
    }

    /// The sensor reports this rate in hertz; `now` summarises the present connection. A report
    /// that differs from the one before is a change of its setting; a first one that arrivals
    /// contradict is false.
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
            // it restarted with other settings, or was configured anew
            RateFrom::Device if differs => self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), span),
            RateFrom::Arrival if differs && self.change.is_none() => {
                let is_confirmed = now().is_some_and(|now| is_confirmed_by(&now));
                if was_set && is_confirmed {
                    return self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), span);
                }
                if !is_confirmed && self.false_report.is_none() {
                    return RateEffect::Replace(device_hz);
                }
                self.false_report = Some(FalseReport { reported_hz: device_hz, arrival_hz: self.rate.hz });
                RateEffect::None
            }
            _ => {
                self.attribute_to(Some(device_hz));
                RateEffect::None
            }
        }
    }

    /// `samples` were judged by a false rate.
    pub(crate) fn replace(&mut self, device_hz: f64, samples: u64) {
        self.refused_before = None;
        self.false_rate = (samples > 0).then_some(FalseRate { samples, arrival_hz: self.rate.hz, device_hz });
        self.set(device_hz, RateFrom::Device);
    }

    /// Excluded samples are no evidence.
    pub(crate) fn end_connection(&mut self, ended: Option<TimebaseSummary>) {
        if !self.is_excluding() {
            self.refused_before = self.refused_before.or_else(|| ended?.refusal);
            self.confirmed = ended.filter(|ended| ended.nominal.is_some()).or(self.confirmed);
        }
    }

    pub(crate) fn start_over(&mut self) {
        (self.change, self.false_rate) = (None, None);
    }

    /// No sample is excluded for its rate, and none was.
    pub(crate) const fn is_steady(&self) -> bool {
        self.change.is_none() && self.false_rate.is_none() && self.other_rate_samples == 0
    }

    /// Continues with a piece that has the same rate.
    pub(crate) fn append(&mut self, next: &Self) {
        if self.rate.from == RateFrom::Assumed {
            self.rate = next.rate;
        }
    }

    /// The change of rate after which samples are excluded.
    pub(crate) fn change(&self) -> Option<RateChange> {
        self.change.map(|change| change.change)
    }

    /// What arrival times show of the samples that count; `now` of the present connection.
    pub(crate) fn arrivals(&self, now: impl FnOnce() -> Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        self.change.map_or_else(now, |change| change.until)
    }

    fn set(&mut self, hz: f64, from: RateFrom) {
        self.rate = Rate { hz, from, by_few: None };
    }

    /// Where arrival times and the sensor agree, the sensor is the authority.
    fn attribute_to(&mut self, device_hz: Option<f64>) {
        if self.rate.from == RateFrom::Arrival && device_hz == Some(self.rate.hz) {
            self.rate.from = RateFrom::Device;
        }
    }

    fn at_the_rate(&self, now: Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        [now, self.confirmed].into_iter().flatten().find(|summary| self.is_at_the_rate(summary))
    }

    fn is_at_the_rate(&self, summary: &TimebaseSummary) -> bool {
        summary.nominal.is_some_and(|nominal| nominal.hz() == self.rate.hz)
    }
}

/// Then a sensor that reports another rate was set anew.
fn is_confirmed_by(now: &TimebaseSummary) -> bool {
    matches!(now.nominal, Some(NominalRate::Snapped(_))) && now.offset_ppm.is_some_and(|ppm| ppm.abs() < CLOCK_PPM)
}

imu_noise::encoded!(Rate { hz, from, by_few } if |rate| rate.hz > 0.0);
imu_noise::encoded!(DatedChange { change, until, excluded });

impl RateAuthority {
    /// Without the rates of the sensor, which its message says.
    pub(crate) fn encode(&self, out: &mut Vec<u8>) {
        let Self {
            rates_hz: _,
            rate,
            change,
            confirmed,
            refused_before,
            false_rate,
            other_rate_samples,
            reported_hz,
            false_report,
        } = self;
        rate.encode(out);
        change.encode(out);
        confirmed.encode(out);
        refused_before.encode(out);
        false_rate.encode(out);
        other_rate_samples.encode(out);
        reported_hz.encode(out);
        false_report.encode(out);
    }

    pub(crate) fn decode(layout: Option<&Layout>, input: &mut Decoder<'_>) -> Result<Self, BadEncoding> {
        Ok(Self {
            rates_hz: layout.map_or(&[], |layout| rates_hz(Some(layout))),
            rate: Encoded::decode(input)?,
            change: Encoded::decode(input)?,
            confirmed: Encoded::decode(input)?,
            refused_before: Encoded::decode(input)?,
            false_rate: Encoded::decode(input)?,
            other_rate_samples: Encoded::decode(input)?,
            reported_hz: Encoded::decode(input)?,
            false_report: Encoded::decode(input)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vn100_protocol::{VNIMU, VNYMR};

    use super::*;

    fn span(samples: usize, excluded: usize) -> MeasuredSpan {
        let mut span = MeasuredSpan::new(Duration::ZERO, None);
        span.push(excluded, 40.0, true);
        span.push(samples, 40.0, false);
        span
    }

    fn summary(nominal: Option<NominalRate>, offset_ppm: Option<f64>) -> TimebaseSummary {
        TimebaseSummary {
            samples: 500,
            backwards: 0,
            nominal,
            measured_hz: None,
            offset_ppm,
            refusal: None,
            missing: 0,
            gaps: 0,
            arrivals: None,
        }
    }

    fn snapped(hz: f64) -> TimebaseSummary {
        summary(Some(NominalRate::Snapped(hz)), Some(1.0))
    }

    #[test]
    fn device_times_at_the_rate_of_the_record_end_an_exclusion() {
        let mut rate = RateAuthority::new(None);
        assert!(matches!(rate.take_device_time(800.0, &span(0, 0)), RateEffect::Rescale { .. }));
        assert_eq!(rate.take_device_time(800.0, &span(9, 0)), RateEffect::None);
        assert_eq!(rate.take_device_time(200.0, &span(9, 0)), RateEffect::Exclude);
        assert!(rate.is_excluding() && rate.hz() == 800.0);
        assert_eq!(rate.take_device_time(800.0, &span(9, 5)), RateEffect::Resume);
        assert!(!rate.is_excluding() && rate.other_rate_samples == 5);
    }

    fn by_arrival(hz: f64) -> RateAuthority {
        let mut rate = RateAuthority::new(None);
        rate.set_layout(&VNYMR);
        assert_eq!(rate.take_nominal(NominalRate::Snapped(hz), None, &span(0, 0)), RateEffect::None);
        rate
    }

    fn by_device(hz: f64) -> RateAuthority {
        let mut rate = RateAuthority::new(None);
        rate.set_layout(&VNYMR);
        assert_eq!(rate.take_device_rate(hz, || None, &span(0, 0)), RateEffect::Known(hz));
        rate
    }

    fn by_user(hz: f64) -> RateAuthority {
        let mut rate = RateAuthority::new(Some(hz));
        rate.set_layout(&VNYMR);
        rate
    }

    #[test]
    fn the_rates_are_those_of_the_messages_of_the_sensor() {
        assert_eq!(rates_hz(Some(&VNYMR)), [1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 25.0, 40.0, 50.0, 100.0, 200.0]);
        assert_eq!(rates_hz(Some(&VNIMU)), rates_hz(Some(&VNYMR)));
        assert!(rates_hz(Some(&Layout { message: "CSV".into(), ..VNYMR.clone() })).is_empty());
        assert!(rates_hz(None).is_empty());
    }

    #[test]
    fn arrival_times_decide_until_the_user_or_the_sensor_does() {
        let assumed = RateAuthority::new(None);
        assert_eq!((assumed.hz(), assumed.rate.from, assumed.is_open()), (40.0, RateFrom::Assumed, true));
        for (rate, from) in [
            (by_user(25.0), RateFrom::Option),
            (by_device(25.0), RateFrom::Device),
            (by_arrival(25.0), RateFrom::Arrival),
        ] {
            assert_eq!((rate.hz(), rate.rate.from, rate.is_open()), (25.0, from, false));
        }
    }

    #[test]
    fn where_arrival_times_and_the_sensor_agree_the_sensor_is_the_authority() {
        let mut rate = RateAuthority::new(None);
        assert_eq!(rate.take_nominal(NominalRate::Measured(33.0), Some(33.0), &span(0, 0)), RateEffect::None);
        assert_eq!((rate.hz(), rate.rate.from), (33.0, RateFrom::Device));
        assert_eq!(rate.take_nominal(NominalRate::Measured(34.0), Some(33.0), &span(0, 0)), RateEffect::None);
        assert_eq!((rate.hz(), rate.rate.from), (34.0, RateFrom::Arrival));
        assert_eq!(rate.take_device_rate(34.0, || None, &span(9, 0)), RateEffect::None);
        assert_eq!(rate.rate.from, RateFrom::Device);
        let mut given = by_user(25.0);
        assert_eq!(given.take_nominal(NominalRate::Known(25.0), Some(25.0), &span(0, 0)), RateEffect::None);
        assert_eq!((given.hz(), given.rate.from), (25.0, RateFrom::Option));
        assert_eq!(given.take_device_rate(50.0, || Some(snapped(25.0)), &span(9, 0)), RateEffect::None);
        assert_eq!((given.hz(), given.rate.from), (25.0, RateFrom::Option));
    }

    #[test]
    fn more_samples_are_better_evidence_than_fewer() {
        let few = |samples: u64, hz: f64| Rate { hz, from: RateFrom::Arrival, by_few: Some(samples) };
        for (before, samples, expected) in [
            (few(20, 200.0), 5, few(20, 200.0)),
            (few(20, 200.0), 20, few(20, 50.0)),
            (few(5, 200.0), 20, few(20, 50.0)),
            (Rate { hz: 40.0, from: RateFrom::Assumed, by_few: None }, 20, few(20, 50.0)),
        ] {
            let mut rate = by_arrival(50.0);
            rate.prefer_longer_evidence(samples, before);
            assert_eq!(rate.rate, expected);
            assert!(rate.is_open());
        }
        let mut assumed = RateAuthority::new(None);
        assumed.prefer_longer_evidence(1, assumed.rate);
        assert_eq!(assumed.rate.by_few, None, "one sample has no rate");
    }

    #[test]
    fn a_change_before_the_first_sample_is_the_rate_of_the_record() {
        let mut rate = by_device(40.0);
        let effect = rate.take_change(40.0, 20.0, None, &span(0, 100));
        assert_eq!(effect, RateEffect::Rescale { from_hz: 40.0, to_hz: 20.0 });
        assert_eq!((rate.hz(), rate.rate.from, rate.is_excluding()), (20.0, RateFrom::Device, false));
        assert_eq!(by_user(40.0).take_change(40.0, 20.0, None, &span(0, 100)), RateEffect::Exclude);
    }

    #[test]
    fn samples_at_another_rate_are_excluded_until_it_is_that_of_the_record() {
        let mut rate = by_arrival(40.0);
        assert_eq!(rate.take_change(40.0, 200.0, Some(snapped(40.0)), &span(600, 7)), RateEffect::Exclude);
        assert_eq!(rate.change(), Some(RateChange { after_samples: 600, from_hz: 40.0, to_hz: 200.0 }));
        assert_eq!((rate.hz(), rate.is_excluding()), (40.0, true));
        assert_eq!(rate.arrivals(|| None), Some(snapped(40.0)), "of the samples that count");
        assert_eq!(rate.take_change(200.0, 100.0, None, &span(600, 50)), RateEffect::None);
        assert_eq!(rate.take_change(100.0, 40.0, None, &span(600, 107)), RateEffect::Resume);
        assert_eq!((rate.change(), rate.is_excluding(), rate.other_rate_samples), (None, false, 100));
        assert_eq!(rate.arrivals(|| Some(snapped(10.0))), Some(snapped(10.0)));
    }

    #[test]
    fn another_rate_after_a_reconnect_is_a_change_if_the_one_before_was_confirmed() {
        let refusal = |measured_hz: f64| Refusal::OtherRate { known_hz: 40.0, measured_hz };
        let after = |mut rate: RateAuthority, before: Option<TimebaseSummary>, refusal: Refusal| {
            rate.end_connection(before);
            let effect = rate.take_refusal(refusal, &span(600, 0));
            (effect, rate.change().map(|change| change.to_hz))
        };
        let excluded = |to_hz| (RateEffect::Exclude, Some(to_hz));
        let known = Some(summary(Some(NominalRate::Known(40.0)), None));
        assert_eq!(after(by_device(40.0), known, refusal(19.85)), excluded(20.0));
        assert_eq!(after(by_device(40.0), known, refusal(20.15)), excluded(20.0));
        assert_eq!(after(by_device(40.0), known, refusal(19.8)), excluded(19.8), "1 % is too much");
        assert_eq!(after(by_arrival(40.0), known, refusal(33.0)), excluded(33.0));
        let kept = (RateEffect::None, None);
        assert_eq!(after(by_user(40.0), known, refusal(20.0)), kept);
        assert_eq!(after(by_device(40.0), None, refusal(20.0)), kept);
        assert_eq!(after(by_device(40.0), Some(snapped(50.0)), refusal(20.0)), kept);
        assert_eq!(after(by_device(40.0), known, Refusal::NoTimePasses { samples: 9 }), kept);
    }

    #[test]
    fn a_sensor_that_reports_another_rate_was_set_anew_if_the_stamps_confirmed_the_old_one() {
        let mut device = by_device(40.0);
        assert_eq!(device.take_device_rate(40.0, || None, &span(600, 0)), RateEffect::None);
        assert_eq!(device.take_device_rate(20.0, || Some(snapped(50.0)), &span(600, 0)), RateEffect::Exclude);
        assert_eq!(device.arrivals(|| Some(snapped(20.0))), None, "none was at the rate of the record");
        let mut device = by_device(40.0);
        device.end_connection(Some(snapped(40.0)));
        assert_eq!(device.take_device_rate(20.0, || Some(snapped(20.0)), &span(600, 0)), RateEffect::Exclude);
        assert_eq!(device.arrivals(|| None), Some(snapped(40.0)));

        let effect = |now: Option<TimebaseSummary>| {
            let mut rate = by_arrival(40.0);
            assert_eq!(rate.take_device_rate(40.0, || None, &span(600, 0)), RateEffect::None);
            rate.rate.from = RateFrom::Arrival;
            rate.take_device_rate(20.0, || now, &span(600, 0))
        };
        assert_eq!(effect(Some(snapped(40.0))), RateEffect::Exclude);
        let off = |ppm| Some(summary(Some(NominalRate::Snapped(40.0)), Some(ppm)));
        assert_eq!((effect(off(999.0)), effect(off(-999.0))), (RateEffect::Exclude, RateEffect::Exclude));
        assert_eq!((effect(off(1000.0)), effect(off(-1001.0))), (RateEffect::Replace(20.0), RateEffect::Replace(20.0)));
        assert_eq!(effect(Some(summary(Some(NominalRate::Measured(40.0)), Some(0.0)))), RateEffect::Replace(20.0));
        assert_eq!(effect(None), RateEffect::Replace(20.0));
        let mut changed = by_arrival(40.0);
        assert_eq!(changed.take_change(40.0, 50.0, None, &span(600, 0)), RateEffect::Exclude);
        assert_eq!(changed.take_device_rate(20.0, || None, &span(600, 9)), RateEffect::None);
    }

    #[test]
    fn arrivals_outweigh_a_report_that_they_contradict() {
        let report = |reported_hz| Some(FalseReport { reported_hz, arrival_hz: 100.0 });
        let arrivals = NominalRate::Snapped(100.0);
        for (samples, expected) in [
            (0, RateEffect::Rescale { from_hz: 40.0, to_hz: 100.0 }),
            (600, RateEffect::Discard { from_hz: 40.0, to_hz: 100.0 }),
        ] {
            let mut rate = by_device(40.0);
            assert_eq!(rate.take_nominal(arrivals, Some(40.0), &span(samples, 0)), expected);
            assert_eq!((rate.hz(), rate.rate.from, rate.false_report), (100.0, RateFrom::Arrival, report(40.0)));
            let now = || Some(snapped(100.0));
            assert_eq!(rate.take_device_rate(40.0, now, &span(700, 0)), RateEffect::None, "the same again");
            rate.end_connection(now());
            assert_eq!(rate.take_device_rate(40.0, || None, &span(700, 0)), RateEffect::None, "behind a reconnect");
            assert_eq!(rate.take_device_rate(50.0, now, &span(700, 0)), RateEffect::Exclude, "it was set");
            assert_eq!(rate.false_report, None);
        }
        let mut changed = by_device(40.0);
        changed.end_connection(Some(snapped(40.0)));
        assert_eq!(changed.take_nominal(arrivals, Some(40.0), &span(600, 0)), RateEffect::Exclude);
        assert_eq!(changed.false_report, None, "those before confirmed it");

        let mut late = by_arrival(100.0);
        assert_eq!(late.take_device_rate(40.0, || Some(snapped(100.0)), &span(600, 0)), RateEffect::None);
        assert_eq!((late.hz(), late.false_report), (100.0, report(40.0)));
        assert_eq!(late.take_change(100.0, 40.0, None, &span(900, 0)), RateEffect::Exclude);
        assert_eq!(late.false_report, None, "the arrivals followed it");
    }

    #[test]
    fn a_false_rate_is_replaced_and_named_where_samples_were_judged_by_it() {
        for (samples, expected) in [(0, None), (7, Some(FalseRate { samples: 7, arrival_hz: 37.0, device_hz: 40.0 }))] {
            let mut rate = by_arrival(37.0);
            rate.end_connection(Some(TimebaseSummary {
                refusal: Some(Refusal::NoTimePasses { samples: 2 }),
                ..snapped(1.0)
            }));
            rate.replace(40.0, samples);
            assert_eq!((rate.false_rate, rate.refused_before), (expected, None));
            assert_eq!((rate.hz(), rate.rate.from), (40.0, RateFrom::Device));
            rate.start_over();
            assert_eq!(rate.false_rate, None);
        }
    }

    #[test]
    fn the_first_refusal_of_a_connection_that_is_over_is_kept() {
        let refused = |samples: u64| {
            Some(TimebaseSummary { refusal: Some(Refusal::NoTimePasses { samples }), ..summary(None, None) })
        };
        let mut rate = by_arrival(40.0);
        rate.end_connection(None);
        assert_eq!(rate.refused_before, None);
        rate.end_connection(refused(3));
        rate.end_connection(refused(4));
        assert_eq!(rate.refused_before, Some(Refusal::NoTimePasses { samples: 3 }));
        let mut excluded = by_arrival(40.0);
        assert_eq!(excluded.take_change(40.0, 20.0, None, &span(1, 0)), RateEffect::Exclude);
        excluded.end_connection(refused(3));
        assert_eq!(excluded.refused_before, None);
        excluded.start_over();
        assert!(!excluded.is_excluding());
    }
}
