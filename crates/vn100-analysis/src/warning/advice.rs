//! The warnings about a snapshot: what was found, why it matters, what to do.

mod link;
#[cfg(test)]
mod tests;

use imu_noise::{Arrivals, NominalRate, TimebaseSummary};
use vn100_protocol::stream::RejectedRowCounts;
use vn100_protocol::{
    BINARY, BinaryOutput, Channel, Layout, MEASUREMENTS_PER_S, Quantity, ReferenceFrameRotation, Register,
    RegisterContents, RegisterFields, RegisterValue, Tally,
};

use self::link::{no_valid_lines, refused, shared_port, unsolicited};
use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting, Text},
    sensor::{sensor_of, uncompensated_message},
    snapshot::{ChannelSnapshot, FalseRate, FalseReport, MissingFrom, RateChange, RateFrom, Snapshot},
    warning::{Warning, WarningKind},
};

/// The least number of samples. Three terms need four octaves, and with this many samples the last
/// octave has ten degrees of freedom in white noise, enough for intervals with their stated
/// coverage.
const LEAST_SAMPLES: u64 = 66;

/// What the analysis knows beyond the numbers of its snapshot.
#[derive(Debug, Default)]
pub(crate) struct StreamFindings {
    pub(crate) repeated_lines: u64,
    pub(crate) print_changes: u64,
    /// Names of the angles whose count of turns started anew.
    pub(crate) restarted: Vec<String>,
}

/// The warnings for `snapshot`, the gravest first.
pub(crate) fn warnings(snapshot: &Snapshot, findings: StreamFindings) -> Vec<Warning> {
    let mut advice = Advice::default();
    advice.on_lines(snapshot, &findings);
    advice.warnings.extend(unsolicited(&snapshot.link.unsolicited_errors));
    advice.warnings.extend(snapshot.port_shared_with.as_deref().map(shared_port));
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
    fn warn(&mut self, kind: WarningKind, headline: impl Into<String>, details: impl Into<Text>) {
        self.warn_of(kind, Vec::new(), headline, details);
    }

    fn warn_of(
        &mut self,
        kind: WarningKind,
        channels: Vec<String>,
        headline: impl Into<String>,
        details: impl Into<Text>,
    ) {
        self.warnings.push(Warning::new(kind, channels, headline, details));
    }

    fn on_lines(&mut self, snapshot: &Snapshot, findings: &StreamFindings) {
        let (link, tally) = (&snapshot.link, &snapshot.link.tally);
        if let Some((headline, details)) = no_valid_lines(snapshot) {
            self.warn(WarningKind::NoValidLines, headline, details);
        }
        if let (1.., Some(name), Some(layout)) = (link.samples(), link.other_message, &snapshot.layout) {
            let headline = format!("{} of another message excluded, first {name}", lines(link.other_messages()));
            let details = format!("The stream began with {}; no other message is measured.", layout.message);
            self.warn(WarningKind::OtherMessages, headline, details);
        }
        let measured = tally.measured_packets;
        let unmeasured = tally.packets.saturating_sub(measured.samples + measured.rejected + measured.repeated);
        if let (1.., 1.., Some(layout)) = (link.samples(), unmeasured, &snapshot.layout) {
            let is_beside_sentences = layout.message != BINARY;
            let of = if is_beside_sentences { "" } else { " of another form" };
            let fields = link.other_packet.map_or_else(String::new, |header| format!(" ({header})"));
            let packets = counted(unmeasured, "binary packet");
            let headline = format!("{packets}{of}{fields} excluded, {} measured", layout.message);
            let details = match is_beside_sentences {
                true => Text::default().remedy(Remedy::MeasurePackets).then(" measures the packets, if they have angular rates or accelerations."),
                false => "The first packets with angular rates and accelerations decide; no packet with other fields is measured.".into(),
            };
            self.warn(WarningKind::OtherMessages, headline, details);
        }
        if tally.split_packets > 0 {
            let headline = format!("{} of split packets skipped", counted(tally.split_packets, "part"));
            let details = Text::from("Firmware 3 splits packets that are too long, and they are not read. Packets of fewer fields come with `")
                .remedy(Remedy::Configure(Setting::Message("BINARY")))
                .then("`.");
            self.warn(WarningKind::OtherMessages, headline, details);
        }
        if findings.repeated_lines > 0 {
            let headline = format!(
                "{} of {} repeat an earlier one exactly",
                findings.repeated_lines,
                lines(snapshot.timing.samples)
            );
            let details = "A live sensor does not do that: the capture was looped, or its lines were stored twice. The deviations \
                           of such a record say little about a sensor.";
            self.warn(WarningKind::RepeatedLines, headline, details);
        }
        let evidence = match snapshot.timing.missing_from {
            MissingFrom::Arrival => "Arrival times show which samples were dropped.",
            MissingFrom::DeviceTime => "The times of the sensor show which samples were dropped.",
            MissingFrom::Counter => "The counters show which samples were dropped.",
            MissingFrom::RejectedRows => "Each one between valid ones counts as one dropped sample.",
        };
        let rejected = link.rejected_rows.unwrap_or_default();
        if rejected.total() > 0 {
            let headline = format!("{} rejected ({})", of_all_lines(rejected.total(), tally), reasons(&rejected));
            let details = format!("{evidence} The list of rejected rows has the first of each reason.");
            self.warn(WarningKind::RejectedLines, headline, details);
        }
        let damaged =
            (tally.rejected.total()).saturating_sub(tally.rejected.unchecked).saturating_sub(rejected.total());
        if damaged > 0 {
            let headline = format!("{} rejected: checksum mismatch or malformed", of_all_lines(damaged, tally));
            let advice = match link.rejected_rows {
                Some(_) => {
                    "They were damaged before they were stored, on the link or by the program that wrote the file."
                }
                None if link.connects > 0 => "Check the cable, the connector and the baud rate.",
                None => {
                    "They were damaged before they were stored, on the link or by the program that wrote them, such as a log that cuts \
                     or joins lines, or drops bytes."
                }
            };
            self.warn(WarningKind::RejectedLines, headline, format!("{evidence} {advice}"));
        }
        let packets = tally.measured_packets;
        if packets.rejected > 0 {
            let headline =
                format!("{} of {} rejected: impossible numbers", packets.rejected, counted(tally.packets, "packet"));
            let details = format!(
                "{evidence} They have a right CRC: what sent or stored them wrote a number that no sensor measures, or the bytes are no \
                 packets."
            );
            self.warn(WarningKind::RejectedLines, headline, details);
        }
        if snapshot.false_times > 0 {
            let headline =
                format!("{} of {} rejected: false time", snapshot.false_times, counted(tally.packets, "packet"));
            let details = format!(
                "{evidence} They have a right CRC, which one in 65 536 damaged packets has, but a time that fits neither neighbour."
            );
            self.warn(WarningKind::RejectedLines, headline, details);
        }
        if packets.repeated > 0 {
            let headline =
                format!("{} of {} repeat the one before", packets.repeated, counted(tally.packets, "packet"));
            let details = "They have the same time of the sensor, and count once: two outputs send the same, or the capture was stored \
                           twice.";
            self.warn(WarningKind::RepeatedLines, headline, details);
        }
        if tally.rejected.unchecked > 0 {
            let headline = format!("{} rejected: no checksum", of_all_lines(tally.rejected.unchecked, tally));
            let details = Text::default()
                .remedy(Remedy::AcceptUnchecked)
                .then(" accepts such lines; a damaged digit in them is then not detected.");
            self.warn(WarningKind::UncheckedLines, headline, details);
        }
        // values of a sensor other than a VN-100 never had a checksum
        let has_checksums = !rates_hz(snapshot.layout.as_deref()).is_empty();
        if tally.unchecked_sentences > 0 && has_checksums {
            let headline = format!("{} accepted without a checksum", of_all_lines(tally.unchecked_sentences, tally));
            self.warn(WarningKind::UncheckedLines, headline, "A damaged digit in them is not detected.");
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

    fn on_time(&mut self, snapshot: &Snapshot) {
        let timing = &snapshot.timing;
        if let Some(RateChange { after_samples, from_hz, to_hz }) = snapshot.rate_change {
            let headline = format!("sample rate changed from {from_hz} to {to_hz} Hz after {}", samples(after_samples));
            let details = Text::from(format!("What followed is excluded, {} in all; ", samples(timing.excluded)))
                .remedy(Remedy::Skip(None))
                .then(" excludes the first part instead.");
            self.warn(WarningKind::RateChanged, headline, details);
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
        }
        if let Some(arrivals) = &snapshot.arrivals {
            self.on_arrivals(arrivals, rates_hz(snapshot.layout.as_deref()), timing.missing_from);
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

    /// Channels that rows lack; those that most rows lack are named separately.
    fn on_absent_values(&mut self, snapshot: &Snapshot) {
        let rows = snapshot.timing.samples;
        let lacking = |(channel, results): (&Channel, &ChannelSnapshot)| {
            // a channel with a rate of its own is not absent from the rows that repeat its value
            let absent = if results.stride == 1 { rows.saturating_sub(results.moments.count()) } else { 0 };
            (absent > 0).then(|| (absent, channel.name.to_string()))
        };
        let lacking: Vec<_> = snapshot.measured().filter_map(lacking).collect();
        for (is_most, details) in [
            (
                true,
                "So few values do not show the noise from row to row. If these channels have a rate of their own, put them into a \
                 file of their own, without the rows that lack them.",
            ),
            (false, "Each is a dropped sample of its own channel alone."),
        ] {
            let of: Vec<_> = lacking.iter().filter(|(absent, _)| (2 * absent > rows) == is_most).collect();
            if !of.is_empty() {
                let counts: Vec<_> = of.iter().map(|(absent, channel)| format!("{channel} {absent}")).collect();
                let headline = format!("values absent in {}: {}", counted(rows, "row"), counts.join(", "));
                let channels = of.into_iter().map(|(_, channel)| channel.clone()).collect();
                self.warn_of(WarningKind::AbsentValues, channels, headline, details);
            }
        }
    }

    fn on_arrivals(&mut self, summary: &TimebaseSummary, rates_hz: &[f64], missing_from: MissingFrom) {
        // a latency timer delivers nearly every other sentence together with the one before it
        const BUNCHED_SHARE: f64 = 0.2;
        let has_stamps = missing_from != MissingFrom::DeviceTime;
        if has_stamps && summary.refusal.is_none() && summary.backwards > 0 {
            let headline = format!("time stamps step backwards {}", counted(summary.backwards, "time"));
            let details = "The clock was set, or lines are out of order. Time continues from there on; dropped samples at that place are \
                           not detected.";
            self.warn(WarningKind::StampsBackwards, headline, details);
        }
        self.on_rate(summary, rates_hz);
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

    fn on_rate(&mut self, summary: &TimebaseSummary, rates_hz: &[f64]) {
        // no quartz is off by that much
        const CLOCK_PPM: f64 = 1000.0;
        // the error that bursts make in a short record
        const BUNCHING_S: f64 = 0.1;
        // with this share of dropped samples another rate, with more or fewer of them, fits the
        // same times
        const UNSURE_SHARE: f64 = 0.1;
        let Some(nominal) = summary.nominal else { return };
        let missing = summary.missing as f64 / (summary.samples + summary.missing).max(1) as f64;
        if let (NominalRate::Measured(_), true, None, Some(hz)) =
            (nominal, missing > UNSURE_SHARE, summary.offset_ppm, summary.measured_hz)
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
            }
        }
    }

    fn on_values(&mut self, snapshot: &Snapshot, findings: StreamFindings) {
        if findings.print_changes > 0 {
            let headline = format!("number of printed decimals changed {}", counted(findings.print_changes, "time"));
            let details = "No averaging window spans a change; the resolution given is the coarser one.";
            self.warn(WarningKind::PrintFormat, headline, details);
        }
        if !findings.restarted.is_empty() {
            let headline = format!("{} restarted after several thousand turns", findings.restarted.join(" "));
            let details = "Mean, minimum and maximum mix the branches.";
            self.warn_of(WarningKind::AngleRestarted, findings.restarted, headline, details);
        }
        let stuck = channels_where(snapshot, |channel, results| is_stuck(channel, results, snapshot.rate_of(results)));
        if !stuck.is_empty() {
            let headline = format!("no more than two values on {}", stuck.join(" "));
            let details = "The noise lies below the last printed digit, or the channel is dead; its deviations are those of the \
                           rounding.";
            self.warn_of(WarningKind::StuckDigits, stuck, headline, details);
        }
        if let Some((headline, details)) = saturated(snapshot) {
            let axes = snapshot.saturation.axes().map(|(axis, _)| axis.to_owned());
            self.warn_of(WarningKind::FullRange, axes.collect(), headline, details);
        }
        let at_limit = channels_where(snapshot, reaches_limit);
        if !at_limit.is_empty() {
            let headline = format!("end of the sensor's range reached on {}", at_limit.join(" "));
            let details = "The range is 2.5 gauss, 16 g, 2000 deg/s as quoted. Values beyond it are clipped, and statistics of \
                           clipped values are wrong.";
            self.warn_of(WarningKind::FullRange, at_limit, headline, details);
        }
    }

    fn on_message(&mut self, snapshot: &Snapshot) {
        let Some(layout) = &snapshot.layout else { return };
        if is_of_sensor(layout) && is_rotated(snapshot) {
            let details = "Register 26 holds a rotation: x, y and z are axes of the vehicle, each a mixture of axes of the sensor. A \
                           disturbance or a high noise of one axis of the sensor shows on all that it mixes into.";
            self.warn(WarningKind::RotatedAxes, "axes rotated by the sensor (register 26)", details);
        }
        let rates = layout.channels.iter().filter(|channel| channel.quantity == Quantity::AngularRate);
        let rates: Vec<_> = rates.map(|channel| channel.name.to_string()).collect();
        if rates.is_empty() {
            return;
        }
        if layout.compensated.is_none() {
            let headline = "unknown whether a filter has removed the gyroscope bias";
            let details = Text::from("If one has, B, K and R are those of the filter, not of the sensor. Set ")
                .remedy(Remedy::SayCompensated)
                .then(" yes or no.");
            self.warn_of(WarningKind::CompensationUnknown, rates, headline, details);
        } else if layout.compensated == Some(true) {
            let headline = format!("{} is bias-compensated: gyro B and K not measurable", layout.message);
            let details = Text::from(
                "The attitude filter removes its bias estimate from the angular rates: at long averaging times the deviation shows that \
                 filter, not the sensor. ",
            );
            let details = match is_of_sensor(layout) {
                true => {
                    let message = Setting::Message(uncompensated_message(&layout.message));
                    details
                        .then("`")
                        .remedy(Remedy::MeasureWith(message))
                        .then("` records uncompensated rates, which show bias instability and rate random walk.")
                }
                false => {
                    details.then("Record the uncompensated output to measure bias instability and rate random walk.")
                }
            };
            self.warn_of(WarningKind::CompensatedStream, rates, headline, details);
        }
    }
}

/// Whether the sensor turns its axes, by register 26, where the stream contains it.
fn is_rotated(snapshot: &Snapshot) -> bool {
    let register = Register::ROTATION;
    let fields = snapshot.registers.get(&register.0).and_then(|fields| RegisterFields::new(fields).ok());
    let rotation =
        fields.and_then(|fields| RegisterContents { register, fields }.value::<ReferenceFrameRotation>().ok());
    rotation.is_some_and(|rotation| rotation.matrix != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// The axes that the sensor itself reports at the end of their range, with the time.
fn saturated(snapshot: &Snapshot) -> Option<(String, String)> {
    let saturation = &snapshot.saturation;
    let (first, last) = saturation.first_at.zip(saturation.last_at)?;
    let axes: Vec<_> = saturation.axes().map(|(axis, count)| format!("{axis} {count}")).collect();
    let headline = format!("the sensor reports saturation in {}: {}", samples(saturation.samples), axes.join(", "));
    let when = match first == last {
        true => format!("At {:.3} s of the record.", first.as_secs_f64()),
        false => format!("From {:.3} to {:.3} s of the record.", first.as_secs_f64(), last.as_secs_f64()),
    };
    Some((
        headline,
        format!("{when} Values at the end of a range are clipped, and statistics of clipped values are wrong."),
    ))
}

/// Whether the message is one of the VN-100's own.
fn is_of_sensor(layout: &Layout) -> bool {
    !rates_hz(Some(layout)).is_empty()
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

/// Whether a channel has no more than two values for longer than its quantity may be constant.
fn is_stuck(channel: &Channel, results: &ChannelSnapshot, rate_hz: f64) -> bool {
    let least_s = match channel.quantity {
        // temperature and pressure of a room do not change in seconds; their noise may be finer
        // than the printed digits
        Quantity::Temperature | Quantity::Pressure => 300.0,
        // an element near ±1 changes with the square of the angle
        Quantity::Quaternion => return false,
        // a series of no sensor may well be nearly constant
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
    // ranges in the unit of the channel, from quotations of the maker's data sheet; the last digits
    // below them are already doubtful
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

/// The reasons in the form `number 2, stamp 1`.
fn reasons(rejected: &RejectedRowCounts) -> String {
    let counted: Vec<_> = rejected.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    counted.join(", ")
}

fn of_all_lines(count: u64, tally: &Tally) -> String {
    format!("{count} of {}", lines(tally.valid_sentences() + tally.rejected.total()))
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
