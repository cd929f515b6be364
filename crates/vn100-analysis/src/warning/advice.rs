//! The warnings a snapshot deserves: what was seen, why it matters, what to try.

mod link;
#[cfg(test)]
mod tests;

use imu_noise::{NominalRate, TimebaseSummary};
use vn100_protocol::stream::RejectedRowCounts;
use vn100_protocol::{Channel, Quantity, Tally};

use self::link::{no_valid_lines, refused, unsolicited};
use crate::{
    accumulate::rate_authority::rates_hz,
    remedy::{Remedy, Text},
    sensor::sensor_of,
    snapshot::{ChannelSnapshot, FalseRate, MissingFrom, RateChange, RateFrom, Snapshot},
    warning::{Warning, WarningKind},
};

/// Three terms need four octaves. In white noise the last has ten degrees of freedom, from which on
/// intervals hold as they say, with so many samples.
const LEAST_SAMPLES: u64 = 66;

/// What only the analysis knows, beyond the numbers of its snapshot.
#[derive(Debug, Default)]
pub(crate) struct StreamFindings {
    pub(crate) repeated_lines: u64,
    pub(crate) print_changes: u64,
    /// Names of the angles whose count had to start anew.
    pub(crate) restarted: Vec<String>,
}

/// The warnings for `snapshot`, the gravest first.
pub(crate) fn warnings(snapshot: &Snapshot, findings: StreamFindings) -> Vec<Warning> {
    let mut advice = Advice::default();
    advice.on_lines(snapshot, &findings);
    advice.warnings.extend(unsolicited(&snapshot.link.unsolicited_errors));
    advice.on_time(snapshot);
    advice.on_values(snapshot, findings);
    advice.on_message(snapshot);
    advice.warnings
}

#[derive(Default)]
struct Advice {
    warnings: Vec<Warning>,
}

impl Advice {
    fn warn(&mut self, kind: WarningKind, text: impl Into<Text>) {
        self.warn_of(kind, Vec::new(), text);
    }

    fn warn_of(&mut self, kind: WarningKind, channels: Vec<String>, text: impl Into<Text>) {
        self.warnings.push(Warning::new(kind, channels, text));
    }

    fn on_lines(&mut self, snapshot: &Snapshot, findings: &StreamFindings) {
        let (link, tally) = (&snapshot.link, &snapshot.link.tally);
        if let Some(text) = no_valid_lines(snapshot) {
            self.warn(WarningKind::NoValidLines, text);
        }
        if let (1.., Some(name), Some(layout)) = (link.samples(), link.other_message, &snapshot.layout) {
            let text = format!(
                "{} of another message, first of {name}, are left out: the stream began with {}",
                lines(link.other_messages()),
                layout.message
            );
            self.warn(WarningKind::OtherMessages, text);
        }
        if findings.repeated_lines > 0 {
            let text = format!(
                "{} of {} repeat an earlier one digit for digit, which no living sensor does: a recording played in a loop, or lines \
                     stored twice. The deviations of such a record say little about a sensor",
                findings.repeated_lines,
                lines(snapshot.timing.samples)
            );
            self.warn(WarningKind::RepeatedLines, text);
        }
        let evidence = match snapshot.timing.missing_from {
            MissingFrom::Arrival => "arrival times tell what is missing for it",
            MissingFrom::Counter => "the counters tell what is missing for it",
            MissingFrom::RejectedRows => "each between good ones counts as one missing sample",
        };
        let rejected = link.rejected_rows.unwrap_or_default();
        if rejected.total() > 0 {
            let text = format!(
                "{} no row like the others and left out ({}); {evidence}. The list of odd rows shows the first of each reason",
                of_all_lines(rejected.total(), tally),
                reasons(&rejected)
            );
            self.warn(WarningKind::RejectedLines, text);
        }
        let damaged = tally.rejected.total() - tally.rejected.unchecked - rejected.total();
        if damaged > 0 {
            let advice = match link.rejected_rows {
                Some(_) => "The file stores them so: they were damaged before, on the wire or by the script",
                None if link.connects > 0 => "Look at the cable, the connector and the baud rate",
                None => {
                    "They were damaged before they were stored, on the wire or by the program that wrote them: a log that cuts or joins \
                     lines, or drops bytes"
                }
            };
            let text = format!("{} damaged and left out; {evidence}. {advice}", of_all_lines(damaged, tally));
            self.warn(WarningKind::RejectedLines, text);
        }
        if tally.rejected.unchecked > 0 {
            let text = Text::from(format!(
                "{} without a checksum and left out; ",
                of_all_lines(tally.rejected.unchecked, tally)
            ))
            .remedy(Remedy::AcceptUnchecked)
            .then(" takes such lines, and then nothing but the form of a number protects it");
            self.warn(WarningKind::UncheckedLines, text);
        }
        // numbers of any sensor never had a checksum
        let has_checksums = !rates_hz(snapshot.layout.as_deref()).is_empty();
        if tally.unchecked_sentences > 0 && has_checksums {
            let text = format!(
                "{} taken without a checksum: a damaged digit in them cannot be told from a good one",
                of_all_lines(tally.unchecked_sentences, tally)
            );
            self.warn(WarningKind::UncheckedLines, text);
        }
    }

    fn on_time(&mut self, snapshot: &Snapshot) {
        let timing = &snapshot.timing;
        if let Some(RateChange { after_samples, from_hz, to_hz }) = snapshot.rate_change {
            let text = Text::from(format!(
                "after {} the rate changed from {from_hz} to {to_hz} Hz, and what came then is left out, {} in all; ",
                samples(after_samples),
                samples(timing.excluded)
            ))
            .remedy(Remedy::Skip(None))
            .then(" leaves the first part out instead");
            self.warn(WarningKind::RateChanged, text);
        }
        if let Some(FalseRate { samples: excluded, arrival_hz, device_hz }) = snapshot.false_rate {
            let text = format!(
                "the first {} came at {arrival_hz} Hz by their arrival, until the sensor said that its rate is {device_hz} Hz: they were \
                     placed wrongly and are left out",
                samples(excluded)
            );
            self.warn(WarningKind::RateChanged, text);
        }
        if snapshot.other_rate_samples > 0 {
            let text = format!(
                "{} came at another rate for a while, as bytes do that were held back, and are left out; no window spans that",
                samples(snapshot.other_rate_samples)
            );
            self.warn(WarningKind::RateChanged, text);
        }
        let refusal = snapshot.arrivals.and_then(|arrivals| arrivals.refusal);
        let over = refusal.is_none();
        if let Some(refusal) = refusal.or(snapshot.refused_before) {
            self.warn(WarningKind::StampsRefused, refused(refusal, over, snapshot));
        }
        if let Some(arrivals) = &snapshot.arrivals {
            self.on_arrivals(arrivals, rates_hz(snapshot.layout.as_deref()));
        }
        self.on_absent_values(snapshot);
        if timing.missing > 0 {
            let text = format!(
                "{} missing in {} ({:.2} % of the record): averages are over the samples that are there; those that lack \
                 more than half are left out",
                samples(timing.missing),
                counted(timing.gaps, "place"),
                100.0 * timing.missing as f64 / (timing.missing + timing.samples) as f64
            );
            self.warn(WarningKind::Gaps, text);
        }
        if snapshot.layout.is_some() {
            match timing.samples {
                0..2 => self
                    .warn(WarningKind::TooShort, format!("{}: a deviation needs 2 at least", samples(timing.samples))),
                // of a series without a sensor no noise model is fitted
                2..LEAST_SAMPLES if !has_sensor(snapshot) => {}
                2..LEAST_SAMPLES => self.warn(
                    WarningKind::TooShort,
                    format!(
                        "{} say little: the fit of N, B and K asks for four octaves, and the fourth has ten degrees of freedom from \
                         {LEAST_SAMPLES} samples on. Below that its interval spans more than a factor of two. Record longer",
                        samples(timing.samples)
                    ),
                ),
                LEAST_SAMPLES.. => {}
            }
        }
        if timing.rate_from == RateFrom::Assumed && timing.samples > 0 {
            let text = Text::from(format!(
                    "nothing in the recording tells its sample rate; {} Hz is the sensor's default. If it was set otherwise give ",
                    timing.rate_hz
                ))
                .remedy(Remedy::GiveRate(None))
                .then(": every tau scales with it");
            self.warn(WarningKind::RateAssumed, text);
        }
    }

    /// Channels that rows lack, those that most rows lack by themselves.
    fn on_absent_values(&mut self, snapshot: &Snapshot) {
        let rows = snapshot.timing.samples;
        let lacking = |(channel, results): (&Channel, &ChannelSnapshot)| {
            let absent = rows.saturating_sub(results.moments.count());
            (absent > 0).then(|| (absent, channel.name.to_string()))
        };
        let lacking: Vec<_> = snapshot.measured().filter_map(lacking).collect();
        for (is_most, advice) in [
            (
                true,
                "so few values do not show their noise from row to row. If they have a rate of their own, put them into \
                    a file of their own, without the rows that lack them",
            ),
            (false, "each is a sample missing of its own channel, and costs the others nothing"),
        ] {
            let of: Vec<_> = lacking.iter().filter(|(absent, _)| (2 * absent > rows) == is_most).collect();
            if !of.is_empty() {
                let counts: Vec<_> = of.iter().map(|(absent, channel)| format!("{channel} {absent}")).collect();
                let text = format!("of {} some have no value: {}; {advice}", counted(rows, "row"), counts.join(", "));
                self.warn_of(
                    WarningKind::AbsentValues,
                    of.into_iter().map(|(_, channel)| channel.clone()).collect(),
                    text,
                );
            }
        }
    }

    fn on_arrivals(&mut self, summary: &TimebaseSummary, rates_hz: &[f64]) {
        // a latency timer brings nearly every other line with the one before it
        const BUNCHED_SHARE: f64 = 0.2;
        if summary.refusal.is_none() && summary.backwards > 0 {
            let text = format!(
                "the stamps go back {}: the clock was set, or lines stand out of order. They are followed from there on, and a loss just \
                     there cannot be seen",
                counted(summary.backwards, "time")
            );
            self.warn(WarningKind::StampsBackwards, text);
        }
        self.on_rate(summary, rates_hz);
        if let Some(arrivals) = summary.arrivals.filter(|arrivals| arrivals.share_together > BUNCHED_SHARE) {
            let text = Text::from(format!(
                    "{:.0} % of the lines arrive together with the one before, {:.1} at a time: the latency timer of a USB serial adapter, \
                     16 ms unless it is set to 1, holds them back; ",
                    100.0 * arrivals.share_together,
                    arrivals.samples_together
                ))
                .remedy(Remedy::MeasureLive)
                .then(
                    " sets it where it may, and else says how. It spoils no deviation, for arrival times never enter one; losses are \
                     placed less finely",
                );
            self.warn(WarningKind::BunchedArrival, text);
        }
    }

    fn on_rate(&mut self, summary: &TimebaseSummary, rates_hz: &[f64]) {
        // no quartz is off by so much
        const CLOCK_PPM: f64 = 1000.0;
        // what bunching does to a short record
        const BUNCHING_S: f64 = 0.1;
        let Some(nominal) = summary.nominal else { return };
        if let (NominalRate::Measured(hz), false) = (nominal, rates_hz.is_empty()) {
            let text = Text::from(format!(
                "lines arrive at {hz} Hz, which is none of the sensor's rates: every tau is by this rate; give "
            ))
            .remedy(Remedy::GiveRate(None))
            .then(" if it is wrong");
            self.warn(WarningKind::RateOffNominal, text);
        } else if let (Some(hz), Some(ppm)) = (summary.measured_hz, summary.offset_ppm) {
            let drift_s = ppm.abs() * 1e-6 * summary.samples as f64 / nominal.hz();
            if ppm.abs() > CLOCK_PPM && drift_s > BUNCHING_S {
                let text = Text::from(format!(
                    "lines arrive at {hz:.4} Hz, {ppm:+.0} ppm off the {} Hz by which every tau is given; give ",
                    nominal.hz()
                ))
                .remedy(Remedy::GiveRate(Some(hz)))
                .then(" if the stamps are right");
                self.warn(WarningKind::RateOffNominal, text);
            }
        }
    }

    fn on_values(&mut self, snapshot: &Snapshot, findings: StreamFindings) {
        if findings.print_changes > 0 {
            let text = format!(
                "the number of printed decimals changed {}: no window spans a change, and the resolution given is the coarser one",
                counted(findings.print_changes, "time")
            );
            self.warn(WarningKind::PrintFormat, text);
        }
        if !findings.restarted.is_empty() {
            let text = "the angle turned several thousand times one way and its count started anew: mean, minimum and maximum mix the branches";
            self.warn_of(WarningKind::AngleRestarted, findings.restarted, text);
        }
        let stuck = channels_where(snapshot, |channel, results| is_stuck(channel, results, snapshot.timing.rate_hz));
        if !stuck.is_empty() {
            let text = "the channel shows no more than two values: its noise lies below the last printed digit, or it is not alive; its deviations \
                 are those of the rounding";
            self.warn_of(WarningKind::StuckDigits, stuck, text);
        }
        let at_limit = channels_where(snapshot, reaches_limit);
        if !at_limit.is_empty() {
            let text = "the channel reaches the end of the sensor's range (2.5 gauss, 16 g, 2000 deg/s as quoted): beyond it values are cut, and \
                 statistics of cut values are wrong";
            self.warn_of(WarningKind::FullRange, at_limit, text);
        }
    }

    fn on_message(&mut self, snapshot: &Snapshot) {
        let Some(layout) = &snapshot.layout else { return };
        let rates = layout.channels.iter().filter(|channel| channel.quantity == Quantity::AngularRate);
        let rates: Vec<_> = rates.map(|channel| channel.name.to_string()).collect();
        if rates.is_empty() {
            return;
        }
        if layout.compensated.is_none() {
            let text = Text::from(
                "nothing says whether a filter has taken the bias out of these rates. If one has, bias instability, random walk and ramp are \
                 those of that filter, not of the sensor; ",
            )
            .remedy(Remedy::SayCompensated)
            .then(" yes or no says it");
            self.warn_of(WarningKind::CompensationUnknown, rates, text);
        } else if layout.compensated == Some(true) {
            let text = format!(
                "the angular rates of {} have the attitude filter's bias estimate removed: at long tau their deviation shows that \
                     filter, not the sensor. Bias instability and rate random walk of the sensor need the uncompensated message VNIMU",
                layout.message
            );
            self.warn_of(WarningKind::CompensatedStream, rates, text);
        }
    }
}

fn has_sensor(snapshot: &Snapshot) -> bool {
    snapshot.layout_channels().iter().any(|channel| sensor_of(channel.quantity).is_some())
}

/// Names of the channels for which `holds`.
fn channels_where(snapshot: &Snapshot, holds: impl Fn(&Channel, &ChannelSnapshot) -> bool) -> Vec<String> {
    (snapshot.measured())
        .filter(|(channel, results)| holds(channel, results))
        .map(|(channel, _)| channel.name.to_string())
        .collect()
}

/// No more than two values for as long as the quantity may be constant.
fn is_stuck(channel: &Channel, results: &ChannelSnapshot, rate_hz: f64) -> bool {
    let least_s = match channel.quantity {
        // no room changes in seconds, nor does the weather; their own noise may be finer than the digits printed
        Quantity::Temperature | Quantity::Pressure => 300.0,
        // an element near ±1 changes with the square of the angle
        Quantity::Quaternion => return false,
        // a series may well be nearly constant
        Quantity::Value => return false,
        Quantity::AngularRate | Quantity::Acceleration | Quantity::MagneticField | Quantity::Angle => 0.0,
    };
    let (histogram, count) = (&results.histogram, results.moments.count());
    count >= 100
        && count as f64 >= least_s * rate_hz
        && histogram.bin_width_counts() == 1
        && histogram.bins().take(3).count() <= 2
}

fn reaches_limit(channel: &Channel, results: &ChannelSnapshot) -> bool {
    // ranges in the channel's unit, from quotations of the maker's sheet; the last digits before them are already doubtful
    let range = match channel.quantity {
        Quantity::MagneticField => 2.5,
        Quantity::Acceleration => 16.0 * 9.80665,
        Quantity::AngularRate => 2000.0_f64.to_radians(),
        Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure | Quantity::Value => {
            return false;
        }
    };
    let extremes = [results.moments.min_counts(), results.moments.max_counts()];
    extremes.into_iter().flatten().any(|counts| channel.value(counts).abs() >= 0.99 * range)
}

/// `number 2, stamp 1`.
fn reasons(rejected: &RejectedRowCounts) -> String {
    let counted: Vec<_> = rejected.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    counted.join(", ")
}

fn of_all_lines(count: u64, tally: &Tally) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("{count} of {} {verb}", lines(tally.valid_sentences() + tally.rejected.total()))
}

fn lines(count: u64) -> String {
    counted(count, "line")
}

fn samples(count: u64) -> String {
    counted(count, "sample")
}

fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
