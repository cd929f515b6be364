//! The sample rate of a record: who gave it, when it was wrong, and when it changed.

use imu_noise::{GapDetector, NominalRate, Refusal, TimebaseSummary};
use vn100_protocol::{Layout, MESSAGES, OUTPUT_RATES_HZ};

use crate::{
    settings::DEFAULT_RATE_HZ,
    snapshot::{FalseRate, RateChange, RateFrom},
};

/// Relative error of a measured rate that is still one of the sensor's: no clock is that far off.
const SAME_RATE: f64 = 0.01;

/// Clock offset above which a measured rate does not confirm the nominal one: no quartz is off by
/// so much.
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

/// The rates in hertz of the sensor that sends this message; none for columns that may come from
/// any sensor.
pub(crate) fn rates_hz(layout: Option<&Layout>) -> &'static [f64] {
    let is_output = layout.is_some_and(|layout| MESSAGES.iter().any(|output| output.message == layout.message));
    if is_output { &OUTPUT_RATES } else { &[] }
}

/// Owns the sample rate. The user outranks the sensor, the sensor arrival times, and these the
/// default. A deviation has one sample interval: samples at another rate are left out.
#[derive(Debug, Clone)]
pub(crate) struct RateAuthority {
    rates_hz: &'static [f64],
    rate: Rate,
    change: Option<Change>,
    /// Summary of the last connection that is over and had a rate.
    confirmed: Option<TimebaseSummary>,
    /// The first refusal of stamps in a connection that is over.
    refused_before: Option<Refusal>,
    false_rate: Option<FalseRate>,
    /// Samples left out at another rate, until it was the rate of the record again.
    other_rate_samples: u64,
}

/// A rate and its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rate {
    pub(crate) hz: f64,
    pub(crate) from: RateFrom,
    /// By how many samples arrival times decided, where too few came to be sure.
    pub(crate) by_few: Option<u64>,
}

/// Samples come at another rate than that of the record.
#[derive(Debug, Clone, Copy)]
struct Change {
    change: RateChange,
    /// Summary of the samples before.
    until: Option<TimebaseSummary>,
    /// Samples left out before.
    left_out: u64,
}

/// How many samples count, and how many were left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counted {
    pub(crate) samples: u64,
    pub(crate) left_out: u64,
}

/// What a decision on the rate means for the record.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub(crate) enum RateEffect {
    /// Nothing.
    None,
    /// The sensor's rate is taken; arrival times must confirm it.
    Known(f64),
    /// No sample counts yet, and the new rate is that of the record: data time so far was by the old
    /// one.
    Rescale { from_hz: f64, to_hz: f64 },
    /// Samples are left out from here on.
    LeaveOut,
    /// Samples count again, after a gap of unknown length.
    Resume,
    /// The samples so far were judged by a rate that the sensor does not have: they are left out,
    /// and the record begins anew at this rate, see [`RateAuthority::replace`].
    Replace(f64),
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
            refused_before: None,
            false_rate: None,
            other_rate_samples: 0,
        }
    }

    /// The samples are of this message.
    pub(crate) fn set_layout(&mut self, layout: &Layout) {
        self.rates_hz = rates_hz(Some(layout));
    }

    pub(crate) const fn hz(&self) -> f64 {
        self.rate.hz
    }

    pub(crate) const fn rate(&self) -> Rate {
        self.rate
    }

    /// Whether arrival times may still decide.
    pub(crate) const fn is_open(&self) -> bool {
        match self.rate.from {
            RateFrom::Assumed => true,
            RateFrom::Arrival => self.rate.by_few.is_some(),
            RateFrom::Option | RateFrom::Device => false,
        }
    }

    /// Whether samples are left out, as they come at another rate.
    pub(crate) const fn leaves_out(&self) -> bool {
        self.change.is_some()
    }

    /// A detector for the stamps that come now. They must confirm a rate that is known.
    pub(crate) fn detector(&self) -> GapDetector {
        GapDetector::new(self.rates_hz, (!self.is_open()).then_some(self.rate.hz))
    }

    /// The detector has this nominal rate; the sensor reported that one.
    pub(crate) fn take_nominal(&mut self, nominal: NominalRate, device_hz: Option<f64>) {
        match nominal {
            NominalRate::Known(hz) => self.rate.hz = hz,
            NominalRate::Snapped(hz) | NominalRate::Measured(hz) => {
                self.set(hz, RateFrom::Arrival);
                self.attribute_to(device_hz);
            }
        }
    }

    /// A connection is over after so few `samples` that their rate is not sure: it holds until a
    /// later one decides, and more samples are better evidence than fewer. `before` held until then.
    pub(crate) fn prefer_longer_evidence(&mut self, samples: u64, before: Rate) {
        if before.by_few.is_some_and(|more| more > samples) {
            self.rate = before;
        } else if self.rate.from == RateFrom::Arrival {
            self.rate.by_few = Some(samples);
        }
    }

    /// The samples have changed their rate; `until` summarises those before. Before the first sample
    /// that counts the new rate is that of the record, unless the user gave one.
    pub(crate) fn take_change(
        &mut self,
        from_hz: f64,
        to_hz: f64,
        until: Option<TimebaseSummary>,
        counted: Counted,
    ) -> RateEffect {
        if counted.samples == 0 && self.rate.from != RateFrom::Option {
            self.rate.hz = to_hz;
            return RateEffect::Rescale { from_hz, to_hz };
        }
        match self.change {
            // bytes held back came as fast as the link carries them, or the sensor was set back
            Some(change) if to_hz == self.rate.hz => {
                self.change = None;
                self.other_rate_samples += counted.left_out - change.left_out;
                RateEffect::Resume
            }
            Some(_) => RateEffect::None,
            None => {
                let change = RateChange { after_samples: counted.samples, from_hz, to_hz };
                self.change = Some(Change { change, until, left_out: counted.left_out });
                RateEffect::LeaveOut
            }
        }
    }

    /// The stamps are refused. If they show another rate after a reconnect, though those before
    /// confirmed the known one, it has changed; a rate that the user gave is kept.
    pub(crate) fn take_refusal(&mut self, refusal: Refusal, counted: Counted) -> RateEffect {
        match (refusal, self.confirmed.filter(|before| self.is_at_the_rate(before))) {
            (Refusal::OtherRate { known_hz, measured_hz }, Some(before)) if self.rate.from != RateFrom::Option => {
                let mut listed_hz = self.rates_hz.iter().copied();
                let to_hz = listed_hz.find(|hz| (measured_hz / hz - 1.0).abs() < SAME_RATE).unwrap_or(measured_hz);
                self.take_change(known_hz, to_hz, Some(before), counted)
            }
            _ => RateEffect::None,
        }
    }

    /// The sensor reports this rate in hertz; `now` summarises the present connection.
    pub(crate) fn take_device_rate(
        &mut self,
        device_hz: f64,
        now: impl Fn() -> Option<TimebaseSummary>,
        counted: Counted,
    ) -> RateEffect {
        if self.is_open() {
            self.set(device_hz, RateFrom::Device);
            return RateEffect::Known(device_hz);
        }
        let differs = device_hz != self.rate.hz;
        match self.rate.from {
            // it came back with other settings, or was set anew
            RateFrom::Device if differs => self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), counted),
            RateFrom::Arrival if differs && self.change.is_none() => {
                if now().is_some_and(|now| is_confirmed_by(&now)) {
                    self.take_change(self.rate.hz, device_hz, self.at_the_rate(now()), counted)
                } else {
                    RateEffect::Replace(device_hz)
                }
            }
            _ => {
                self.attribute_to(Some(device_hz));
                RateEffect::None
            }
        }
    }

    /// The record begins anew at the sensor's rate; `samples` were judged by a false one.
    pub(crate) fn replace(&mut self, device_hz: f64, samples: u64) {
        self.refused_before = None;
        self.false_rate = (samples > 0).then_some(FalseRate { samples, told_hz: self.rate.hz, device_hz });
        self.set(device_hz, RateFrom::Device);
    }

    /// A connection is over; what its arrival times showed. Samples that are left out say nothing of
    /// the record.
    pub(crate) fn end_connection(&mut self, ended: Option<TimebaseSummary>) {
        if !self.leaves_out() {
            self.refused_before = self.refused_before.or_else(|| ended?.refusal);
            self.confirmed = ended.filter(|ended| ended.nominal.is_some()).or(self.confirmed);
        }
    }

    /// Samples count again, whatever their rate; the record begins anew.
    pub(crate) fn start_over(&mut self) {
        (self.change, self.false_rate) = (None, None);
    }

    /// The change of rate after which samples are left out.
    pub(crate) fn change(&self) -> Option<RateChange> {
        self.change.map(|change| change.change)
    }

    /// What arrival times show of the samples that count; `now` of the present connection.
    pub(crate) fn arrivals(&self, now: impl FnOnce() -> Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        self.change.map_or_else(now, |change| change.until)
    }

    pub(crate) const fn refused_before(&self) -> Option<Refusal> {
        self.refused_before
    }

    pub(crate) const fn false_rate(&self) -> Option<FalseRate> {
        self.false_rate
    }

    pub(crate) const fn other_rate_samples(&self) -> u64 {
        self.other_rate_samples
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

    /// The latest summary of samples that came at the rate of the record.
    fn at_the_rate(&self, now: Option<TimebaseSummary>) -> Option<TimebaseSummary> {
        [now, self.confirmed].into_iter().flatten().find(|summary| self.is_at_the_rate(summary))
    }

    fn is_at_the_rate(&self, summary: &TimebaseSummary) -> bool {
        summary.nominal.is_some_and(|nominal| nominal.hz() == self.rate.hz)
    }
}

/// Whether the samples have kept to one of the sensor's rates: then a sensor that reports another
/// one was set anew.
fn is_confirmed_by(now: &TimebaseSummary) -> bool {
    matches!(now.nominal, Some(NominalRate::Snapped(_))) && now.offset_ppm.is_some_and(|ppm| ppm.abs() < CLOCK_PPM)
}
