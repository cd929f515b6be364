//! The sample rate: who told it, when it is given up, and when it changes.

use imu_noise::{NominalRate, Refusal, Timebase, TimebaseSummary};

use super::Analysis;
use crate::{
    accumulate::{rates::rates_hz, waiting::Waiting},
    snapshot::{FalseRate, RateChange, RateFrom, Timing},
};

impl Analysis {
    /// A time base for the stamps that come now. Where a rate is known they must agree with it: a
    /// deviation knows one sample interval.
    pub(super) fn timebase(&self) -> Timebase {
        let rates_hz = rates_hz(self.layout.as_deref());
        if self.is_rate_open() {
            Timebase::new(rates_hz)
        } else {
            Timebase::with_known_rate(rates_hz, self.timing.rate_hz)
        }
    }

    /// Whether arrival times may still tell the rate.
    pub(super) const fn is_rate_open(&self) -> bool {
        match self.timing.rate_from {
            RateFrom::Assumed => true,
            RateFrom::Arrival => self.rate_by_few.is_some(),
            RateFrom::Option | RateFrom::Device => false,
        }
    }

    /// Takes the rate by which lines are placed from here on.
    pub(super) fn take_rate(&mut self, nominal: NominalRate) {
        match nominal {
            NominalRate::Known(hz) => self.timing.rate_hz = hz,
            NominalRate::Snapped(hz) | NominalRate::Measured(hz) => {
                self.begin_rate(hz, RateFrom::Arrival);
                self.compare_with_device();
            }
        }
    }

    /// A stretch of the link was over after so few `lines` that their rate was not sure: it holds
    /// until a later one tells it, and more lines tell it better. `before` and `by_few_before` were
    /// in force until then.
    pub(super) fn weigh_rate(&mut self, lines: u64, before: Timing, by_few_before: Option<u64>) {
        if by_few_before.is_some_and(|more| more > lines) {
            self.begin_rate(before.rate_hz, before.rate_from);
            self.rate_by_few = by_few_before;
        } else if self.timing.rate_from == RateFrom::Arrival {
            self.rate_by_few = Some(lines);
        }
    }

    /// A deviation knows one sample interval. Before the first sample that counts the new rate is
    /// the rate, unless it was asked for; after it, what comes at another rate is left out; `until`
    /// is what the stamps said before.
    pub(super) fn change_rate(&mut self, from_hz: f64, to_hz: f64, until: Option<TimebaseSummary>) {
        if self.timing.samples == 0 && self.timing.rate_from != RateFrom::Option {
            self.index = (self.index as f64 / from_hz * to_hz).round() as u64;
            self.timing.rate_hz = to_hz;
        } else if self.rate_change.is_some() && to_hz == self.timing.rate_hz {
            // bytes held back came as fast as the line carries them, or the sensor was set back: how much data time that was is not known
            (self.rate_change, self.arrivals_until) = (None, None);
            self.other_rate_lines += self.timing.left_out - self.left_out_before;
            self.take_unknown_gap();
        } else if self.rate_change.is_none() {
            self.left_out_before = self.timing.left_out;
            self.rate_change = Some(RateChange { after_samples: self.timing.samples, from_hz, to_hz });
            self.arrivals_until = until;
            if let Some((registers, samples)) = &self.before_break
                && *samples == self.timing.samples
            {
                self.registers.clone_from(registers);
            }
        }
    }

    /// Lines of another rate behind a break, where those before it bore out the one known, and
    /// nobody insists on it: it has changed, though the sensor does not say so.
    pub(super) fn take_refusal(&mut self, refusal: Refusal) {
        // no clock is that far off
        const SAME_RATE: f64 = 0.01;
        let known = self.borne_out.filter(|before| self.is_of_the_rate(before));
        if let (Refusal::OtherRate { known_hz, measured_hz }, Some(before)) = (refusal, known)
            && self.timing.rate_from != RateFrom::Option
        {
            let mut listed_hz = rates_hz(self.layout.as_deref()).iter().copied();
            let to_hz = listed_hz.find(|hz| (measured_hz / hz - 1.0).abs() < SAME_RATE).unwrap_or(measured_hz);
            self.change_rate(known_hz, to_hz, Some(before));
        }
    }

    /// Takes what the sensor says of its rate, if it does.
    pub(super) fn take_device_rate(&mut self) {
        match (self.timing.rate_from, self.device_rate_hz()) {
            (_, Some(rate_hz)) if self.is_rate_open() => {
                self.begin_rate(rate_hz, RateFrom::Device);
                if let Some(waiting) = &mut self.waiting {
                    waiting.know_rate(rate_hz);
                }
            }
            // it came back with other settings, or was set anew
            (RateFrom::Device, Some(rate_hz)) if rate_hz != self.timing.rate_hz => {
                self.change_rate(self.timing.rate_hz, rate_hz, self.said_at_the_rate());
            }
            (RateFrom::Arrival, Some(rate_hz)) if rate_hz != self.timing.rate_hz && self.rate_change.is_none() => {
                if self.is_rate_borne_out() {
                    self.change_rate(self.timing.rate_hz, rate_hz, self.said_at_the_rate());
                } else {
                    self.replace_rate(rate_hz);
                }
            }
            _ => self.compare_with_device(),
        }
    }
}

impl Analysis {
    /// This is the rate, of the samples so far, too.
    fn begin_rate(&mut self, rate_hz: f64, rate_from: RateFrom) {
        if rate_hz != self.timing.rate_hz {
            // its slots are of so many samples
            self.recent = None;
        }
        (self.timing.rate_hz, self.timing.rate_from) = (rate_hz, rate_from);
        self.rate_by_few = None;
    }

    /// What the stamps said last of lines that came at the rate of the record.
    fn said_at_the_rate(&self) -> Option<TimebaseSummary> {
        let now = self.waiting.as_ref().and_then(Waiting::summary).filter(|summary| self.is_of_the_rate(summary));
        now.or_else(|| self.borne_out.filter(|summary| self.is_of_the_rate(summary)))
    }

    fn is_of_the_rate(&self, summary: &TimebaseSummary) -> bool {
        summary.nominal.is_some_and(|nominal| nominal.hz() == self.timing.rate_hz)
    }

    /// Whether the lines have kept to one of the sensor's rates since they told it: then a sensor
    /// that names another was set anew.
    fn is_rate_borne_out(&self) -> bool {
        // no quartz is off by so much
        const CLOCK_PPM: f64 = 1000.0;
        let Some(summary) = self.waiting.as_ref().and_then(Waiting::summary) else { return false };
        matches!(summary.nominal, Some(NominalRate::Snapped(_)))
            && summary.offset_ppm.is_some_and(|ppm| ppm.abs() < CLOCK_PPM)
    }

    /// Arrival times told a rate that the sensor does not have. Lines placed by it hide gaps and
    /// show others: they are left out, and placing begins anew.
    fn replace_rate(&mut self, rate_hz: f64) {
        self.finish();
        (self.waiting, self.missing_by_evidence) = (None, false);
        let told_hz = self.timing.rate_hz;
        let samples = self.timing.samples;
        self.index = (self.index as f64 / told_hz * rate_hz).round() as u64;
        self.bad_lines_pending = 0;
        self.refused_before = None;
        self.forget();
        self.begin_rate(rate_hz, RateFrom::Device);
        self.false_rate = (samples > 0).then_some(FalseRate { samples, told_hz, device_hz: rate_hz });
    }

    /// Where arrival times and the sensor say the same, the sensor said so.
    fn compare_with_device(&mut self) {
        if self.timing.rate_from == RateFrom::Arrival && self.device_rate_hz() == Some(self.timing.rate_hz) {
            self.timing.rate_from = RateFrom::Device;
        }
    }

    /// The rate that register 7 holds; 0 there is no rate.
    fn device_rate_hz(&self) -> Option<f64> {
        const ASYNC_RATE: u8 = 7;
        let fields = self.registers.get(&ASYNC_RATE)?;
        let rate_hz: u32 = fields.split(',').next()?.parse().ok()?;
        (rate_hz > 0).then_some(rate_hz.into())
    }
}
