//! Warnings about the rate, the times of the samples, and their number.

use imu_noise::timebase::{Arrivals, NominalRate, Refusal, TimebaseSummary, Unevenness};
use vn100_protocol::{BinaryOutput, MEASUREMENTS_PER_S, Register, RegisterContents, RegisterFields, RegisterValue};

use super::{Advice, counted, link::refused, samples};
use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Text},
    sensor::sensor_of,
    snapshot::{FalseRate, FalseReport, MissingFrom, RateChange, RateFrom, Snapshot, Timing},
    warning::{Severity, WarningKind},
};

/// The least number of samples. Three terms need four octaves, and with this many samples the last
/// octave has ten degrees of freedom in white noise, enough for intervals with their stated
/// coverage.
const LEAST_SAMPLES: u64 = 66;

impl Advice {
    pub(super) fn on_time(&mut self, snapshot: &Snapshot) {
        let timing = &snapshot.timing;
        if let Some(RateChange { after_samples, from_hz, to_hz }) = snapshot.rate_change {
            let headline = format!("sample rate changed from {from_hz} to {to_hz} Hz after {}", samples(after_samples));
            let details = Text::from(format!("What followed is excluded, {} in all; ", samples(timing.excluded)))
                .remedy(Remedy::Skip(None))
                .then(" excludes the first part instead.");
            self.warn(WarningKind::RateChanged, headline, details);
        }
        if let Some(RateChange { after_samples, from_hz, to_hz }) = snapshot.parted {
            let headline =
                format!("sample rate changed from {from_hz:.3} to {to_hz:.3} Hz after {}", samples(after_samples));
            let details = format!(
                "The longest stretch at one rate is measured; the others are excluded, {} in all.",
                samples(timing.excluded)
            );
            self.warn(WarningKind::RateChanged, headline, details);
        }
        if snapshot.repeated_rows > 0 {
            let headline =
                format!("{} left out: they repeat an earlier one, stamp and values", rows(snapshot.repeated_rows));
            self.warn(WarningKind::RepeatedLines, headline, "Each is measured once.");
            self.set_severity(Severity::Caution);
        }
        if snapshot.moved_rows > 0 {
            let headline = format!("{} out of order, put at the place of their stamps", rows(snapshot.moved_rows));
            self.warn(WarningKind::StampsBackwards, headline, "They are measured in the order of time.");
        }
        if let Some(FalseRate { samples: excluded, arrival_hz, device_hz }) = snapshot.false_rate {
            let headline = format!(
                "first {} excluded: taken for {arrival_hz} Hz before the sensor reported {device_hz} Hz",
                samples(excluded)
            );
            self.warn(WarningKind::RateChanged, headline, "Their arrival times suggested the wrong rate.");
        }
        if let Some(FalseReport { reported_hz, arrival_hz }) = snapshot.false_report {
            let headline = format!("the sensor reports {reported_hz} Hz, but its lines arrive at {arrival_hz} Hz");
            let details = "Averaging times are those of the arrivals. Its register 7 may be that of another port, or a device between \
                           repeats or selects lines: make sure which before the deviations are used.";
            self.warn(WarningKind::RateOffNominal, headline, details);
        }
        if snapshot.other_rate_samples > 0 {
            let headline = format!("{} at another rate excluded", samples(snapshot.other_rate_samples));
            let details = "They arrived in a burst, as delayed bytes do. No averaging window spans that place.";
            self.warn(WarningKind::RateChanged, headline, details);
        }
        let refusal = snapshot.arrivals.and_then(|arrivals| arrivals.refusal);
        let is_over = refusal.is_none();
        if let Some(refusal) = refusal.or(snapshot.refused_before) {
            self.warn(WarningKind::StampsRefused, refusal.to_string(), refused(refusal, is_over, snapshot));
            // averaging times by a rate that the stamps contradict are wrong
            if matches!(refusal, Refusal::OtherRate { .. }) && timing.rate_from == RateFrom::Option {
                self.set_severity(Severity::Problem);
            }
        }
        if let Some(arrivals) = &snapshot.arrivals {
            self.on_arrivals(arrivals, rates_hz(snapshot.layout.as_deref()), timing);
        }
        if snapshot.restarts > 0 {
            let headline = format!("the sensor restarted {}", counted(snapshot.restarts, "time"));
            let details = "Its own time stepped backwards. No averaging window spans that place; how many samples were dropped there is \
                           unknown.";
            self.warn(WarningKind::StampsBackwards, headline, details);
        }
        if snapshot.time_steps > 0 {
            let headline = format!("the sensor's own time stepped ahead {}", counted(snapshot.time_steps, "time"));
            let details = "Its packets arrived before that time can have passed. No averaging window spans that place; how many samples \
                           were dropped there is unknown.";
            self.warn(WarningKind::Gaps, headline, details);
        }
        self.on_packet_rate(snapshot);
        self.on_absent_values(snapshot);
        if timing.missing > 0 {
            let headline = format!(
                "{} dropped in {} ({:.2} % of the record)",
                samples(timing.missing),
                counted(timing.gaps, "gap"),
                100.0 * timing.missing as f64 / (timing.missing + timing.samples) as f64
            );
            let details = "Clusters average the samples that are there; those that lack more than half are excluded.";
            self.warn(WarningKind::Gaps, headline, details);
        }
        if snapshot.layout.is_some() {
            match timing.samples {
                // it becomes longer by itself, or the result says that all is excluded
                0 if snapshot.is_in_warm_up() => {}
                0..2 => {
                    let headline = format!("{}: a deviation needs at least 2", samples(timing.samples));
                    self.warn(WarningKind::TooShort, headline, "Record longer.");
                }
                // no noise model is fitted to a series without a sensor
                2..LEAST_SAMPLES if !has_sensor(snapshot) => {}
                2..LEAST_SAMPLES => {
                    let headline = format!("{} are too few to fit N, B and K", samples(timing.samples));
                    let details = format!(
                        "The fit needs four octaves, and the fourth has ten degrees of freedom from {LEAST_SAMPLES} samples on; below \
                         that its interval spans more than a factor of two. Record longer."
                    );
                    self.warn(WarningKind::TooShort, headline, details);
                }
                LEAST_SAMPLES.. => {}
            }
        }
        if timing.rate_from == RateFrom::Assumed && timing.samples > 0 {
            let headline = format!("sample rate unknown: {} Hz assumed, the factory default", timing.rate_hz);
            let details = Text::from("Set ")
                .remedy(Remedy::GiveRate(None))
                .then(" if it was different: all averaging times scale with it.");
            self.warn(WarningKind::RateAssumed, headline, details);
        }
    }

    /// Whether packets arrive at the rate of a VN-100, and at the one that its registers set.
    fn on_packet_rate(&mut self, snapshot: &Snapshot) {
        const SAME_RATE: f64 = 1e-6;
        let timing = &snapshot.timing;
        if timing.rate_from != RateFrom::DeviceTime || timing.samples == 0 {
            return;
        }
        let (rate_hz, divisor) = (timing.rate_hz, f64::from(MEASUREMENTS_PER_S) / timing.rate_hz);
        if divisor < 1.0 - SAME_RATE || (divisor / divisor.round() - 1.0).abs() > SAME_RATE {
            let headline =
                format!("{rate_hz:.2} Hz by the packets' own time: a VN-100 sends at 800 Hz over a whole number");
            let details = "Averaging times and dropped samples follow that time, and are as wrong as it is.";
            self.warn(WarningKind::RateOffNominal, headline, details);
            return;
        }
        let output = |register: &Register| {
            let fields = RegisterFields::new(snapshot.registers.get(&register.0)?.as_str()).ok()?;
            let output: BinaryOutput = RegisterContents { register: *register, fields }.value().ok()?;
            Some((register.0, output.rate_hz())).filter(|(_, hz)| *hz > 0.0)
        };
        let set: Vec<(u8, f64)> = BinaryOutput::REGISTERS.iter().filter_map(output).collect();
        if let [(register, set_hz), ..] = set[..]
            && set.iter().all(|(_, hz)| (hz / rate_hz - 1.0).abs() > SAME_RATE)
        {
            let headline = format!(
                "register {register} sets packets of {set_hz} Hz, but they come at {rate_hz} Hz by their own time"
            );
            let details =
                "Averaging times are those of the packets. The register may be that of another sensor or port.";
            self.warn(WarningKind::RateOffNominal, headline, details);
        }
    }

    pub(super) fn on_arrivals(&mut self, summary: &TimebaseSummary, rates_hz: &[f64], timing: &Timing) {
        // a latency timer delivers nearly every other sentence together with the one before it
        const BUNCHED_SHARE: f64 = 0.2;
        let has_stamps = timing.missing_from != MissingFrom::DeviceTime;
        if has_stamps && summary.refusal.is_none() && summary.backwards > 0 {
            let headline = format!("time stamps step backwards {}", counted(summary.backwards, "time"));
            let details = "The clock was set, or lines are out of order. Time continues from there on; dropped samples at that place are \
                           not detected.";
            self.warn(WarningKind::StampsBackwards, headline, details);
        }
        self.on_rate(summary, rates_hz, timing.rate_from);
        self.on_unevenness(summary);
        // with device times no gap depends on when its packets arrive
        let is_bunched = |arrivals: &Arrivals| has_stamps && arrivals.share_together > BUNCHED_SHARE;
        if let Some(arrivals) = summary.arrivals.filter(is_bunched) {
            let headline = format!(
                "{:.0} % of the lines arrive together with the one before, {:.1} at a time",
                100.0 * arrivals.share_together,
                arrivals.samples_together
            );
            let details = Text::from(
                "The latency timer of a USB serial adapter delays them, by 16 ms unless it is set to 1 ms; ",
            )
            .remedy(Remedy::MeasureLive)
            .then(
                " sets it where permitted, and otherwise explains how. Deviations are not affected because arrival times never \
                 enter them; the place of a gap is less certain.",
            );
            self.warn(WarningKind::BunchedArrival, headline, details);
        }
    }

    /// Stamps of any sensor that are not even, although its samples may be.
    fn on_unevenness(&mut self, summary: &TimebaseSummary) {
        if summary.flushed > 0 {
            let headline = format!("the first {} had waited, and were stamped together", rows(summary.flushed));
            self.warn(WarningKind::BunchedArrival, headline, "The rate is that of the rows after them.");
        }
        let (headline, details) = match summary.unevenness {
            None => return,
            Some(Unevenness::Bursts | Unevenness::Pairs) => (
                "rows come several at a time, as read from a buffer",
                "The rate is that of all rows; deviations take them as equally spaced.",
            ),
            Some(Unevenness::CoarseClock) => (
                "stamps are those of a coarse clock, whose ticks are about as long as the steps between rows",
                "The rate is that of all rows; single dropped rows cannot be detected.",
            ),
            Some(Unevenness::Irregular) => (
                "stamps are not equally spaced",
                "Deviations take the rows as equally spaced, at the mean rate. That is right if the stamps alone are uneven, and wrong if \
                 the sampling is.",
            ),
        };
        self.warn(WarningKind::BunchedArrival, headline, details);
        if summary.unevenness == Some(Unevenness::Irregular) {
            self.set_severity(Severity::Caution);
        }
    }

    fn on_rate(&mut self, summary: &TimebaseSummary, rates_hz: &[f64], from: RateFrom) {
        // a rate of the user that is off by more makes every averaging time wrong
        const WRONG_PPM: f64 = 10_000.0;
        // no quartz is off by that much
        const CLOCK_PPM: f64 = 1000.0;
        // the error that bursts make in a short record
        const BUNCHING_S: f64 = 0.1;
        // with this share of dropped samples in many gaps another rate, with more or fewer of them,
        // fits the same times
        const UNSURE_SHARE: f64 = 0.1;
        const MANY_GAPS: u64 = 10;
        let Some(nominal) = summary.nominal else { return };
        let missing = summary.missing as f64 / (summary.samples + summary.missing).max(1) as f64;
        if let (NominalRate::Measured(_), true, None, Some(hz)) =
            (nominal, missing > UNSURE_SHARE && summary.gaps >= MANY_GAPS, summary.offset_ppm, summary.measured_hz)
        {
            let headline =
                format!("rate of {hz:.2} Hz unsure: by its times {:.0} % of the samples are missing", 100.0 * missing);
            let details = Text::from("All averaging times and the number of dropped samples depend on it. Set ")
                .remedy(Remedy::GiveRate(None))
                .then(" to the rate that the sensor was set to.");
            self.warn(WarningKind::RateOffNominal, headline, details);
        } else if let (NominalRate::Measured(hz), false) = (nominal, rates_hz.is_empty()) {
            let headline = format!("lines arrive at {hz} Hz, which is not one of the sensor's rates");
            let details = Text::from("All averaging times use this rate. Set ")
                .remedy(Remedy::GiveRate(None))
                .then(" if it is wrong.");
            self.warn(WarningKind::RateOffNominal, headline, details);
        } else if let (Some(hz), Some(ppm)) = (summary.measured_hz, summary.offset_ppm) {
            let drift_s = ppm.abs() * 1e-6 * summary.samples as f64 / nominal.hz();
            if ppm.abs() > CLOCK_PPM && drift_s > BUNCHING_S {
                let headline = format!("measured rate {hz:.4} Hz, {ppm:+.0} ppm from the nominal {} Hz", nominal.hz());
                let details = Text::from("All averaging times use the nominal rate. Set ")
                    .remedy(Remedy::GiveRate(Some(hz)))
                    .then(" if the time stamps are right.");
                self.warn(WarningKind::RateOffNominal, headline, details);
                if ppm.abs() > WRONG_PPM && from == RateFrom::Option {
                    self.set_severity(Severity::Problem);
                }
            }
        }
    }
}

fn has_sensor(snapshot: &Snapshot) -> bool {
    snapshot.layout_channels().iter().any(|channel| sensor_of(channel.quantity).is_some())
}

fn rows(count: u64) -> String {
    counted(count, "row")
}
