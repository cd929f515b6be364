//! The warnings about a snapshot: what was found, why it matters, what to do.

mod link;
mod message;
#[cfg(test)]
mod tests;
mod time;
mod values;

use vn100_protocol::stream::RejectedRowCounts;
use vn100_protocol::{BINARY, Tally};

use self::link::{no_valid_lines, shared_port, unsolicited};
use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting, Text},
    snapshot::{MissingFrom, Snapshot},
    warning::{Severity, Warning, WarningKind},
};

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

    /// Sets the severity of the latest warning.
    fn set_severity(&mut self, severity: Severity) {
        if let Some(warning) = self.warnings.last_mut() {
            warning.severity = severity;
        }
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
        let advice = match link.rejected_rows {
            Some(_) => "They were damaged before they were stored, on the link or by the program that wrote the file.",
            None if link.connects > 0 => "Check the cable, the connector and the baud rate.",
            None => {
                "They were damaged before they were stored, on the link or by the program that wrote them, such as a log that cuts or \
                 joins lines, or drops or converts bytes."
            }
        };
        if tally.damaged_packets > 0 {
            let all = counted(tally.packets + tally.damaged_packets, "packet");
            let headline = format!("{} of {all} rejected: checksum mismatch", tally.damaged_packets);
            let of_samples = if tally.measured_packets.samples > 0 { evidence } else { "They are not measured here." };
            self.warn(WarningKind::RejectedLines, headline, format!("{of_samples} {advice}"));
        }
        if damaged > 0 {
            let headline = format!("{} rejected: checksum mismatch or malformed", of_all_lines(damaged, tally));
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
