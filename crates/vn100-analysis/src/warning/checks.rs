//! The warnings about a snapshot.

mod message;
mod no_sample;
#[cfg(test)]
mod tests;
mod time;
mod values;

use vn100_protocol::{BINARY, DeviceError, Tally};

use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting},
    snapshot::Snapshot,
    warning::{Finding, Rejected, Severity, Warning},
};

/// What the analysis knows beyond the numbers of its snapshot.
#[derive(Debug, Default)]
pub(crate) struct StreamFindings {
    pub(crate) repeated_lines: u64,
    pub(crate) print_changes: u64,
    /// Names of the angles whose count of turns started anew.
    pub(crate) restarted: Vec<String>,
}

pub(crate) fn warnings(snapshot: &Snapshot, findings: &StreamFindings) -> Vec<Warning> {
    let mut warnings = Vec::new();
    warnings.extend(no_sample::warning(snapshot));
    warnings.extend(others(snapshot));
    warnings.extend(lines(snapshot, findings));
    warnings.extend(link(snapshot));
    warnings.extend(time::warnings(snapshot));
    warnings.extend(values::warnings(snapshot, findings));
    warnings.extend(message::warnings(snapshot));
    warnings
}

/// Sentences and packets beside those that are measured.
fn others(snapshot: &Snapshot) -> impl Iterator<Item = Warning> {
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let layout = snapshot.layout.as_ref().filter(|_| link.samples() > 0);
    let message = layout.map(|layout| layout.message.to_string());
    let sentences = (message.clone().zip(link.other_message))
        .map(|(message, first)| Warning::new(Finding::OtherSentences(link.other_messages(), first, message)));
    let measured = tally.measured_packets;
    let unmeasured = tally.packets.saturating_sub(measured.samples + measured.rejected + measured.repeated);
    let packets = message.filter(|_| unmeasured > 0).map(|message| {
        let is_beside_sentences = message != BINARY;
        let found = Warning::new(Finding::OtherPackets(unmeasured, link.other_packet, message));
        if is_beside_sentences { found.cured_by(Remedy::MeasurePackets) } else { found }
    });
    let split = (tally.split_packets > 0).then(|| {
        Warning::new(Finding::SplitPackets(tally.split_packets)).cured_by(Remedy::Configure(Setting::Message(BINARY)))
    });
    [sentences, packets, split].into_iter().flatten()
}

/// What was rejected, and what stands there twice.
fn lines(snapshot: &Snapshot, findings: &StreamFindings) -> impl Iterator<Item = Warning> {
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let packets = tally.measured_packets;
    let repeated = [
        (findings.repeated_lines, snapshot.timing.samples, Severity::Problem),
        (snapshot.repeated_rows, snapshot.timing.samples + snapshot.repeated_rows, Severity::Caution),
        (packets.repeated, tally.packets, Severity::Problem),
    ];
    let repeated = repeated
        .into_iter()
        .filter(|(count, ..)| *count > 0)
        .map(|(count, of, severity)| Warning::new(Finding::Repeated(count, of)).as_severe_as(severity));
    let rows = link.rejected_rows.unwrap_or_default();
    let of_rows = rows.total();
    // an end between two bytes of a sentence damages nothing
    let undamaged = tally.rejected.unchecked + of_rows + link.cut_sentences;
    let damaged = tally.rejected.total().saturating_sub(undamaged);
    // values of a sensor other than a VN-100 never had a checksum
    let has_checksums = !rates_hz(snapshot.layout.as_deref()).is_empty();
    let accepted = if has_checksums { tally.unchecked_sentences } else { 0 };
    let all = all_lines(tally);
    let rejected = [
        (Rejected::Rows(rows), of_rows, all),
        (Rejected::Packets, tally.damaged_packets, tally.packets + tally.damaged_packets),
        (Rejected::Sentences, damaged, all),
        (Rejected::PacketNumbers, packets.rejected, tally.packets),
        (Rejected::PacketTimes, snapshot.false_times, tally.packets),
        (Rejected::NoChecksum, tally.rejected.unchecked, all),
        (Rejected::AcceptedUnchecked, accepted, all),
    ];
    let rejected = rejected.into_iter().filter(|(_, count, _)| *count > 0).map(|(what, count, of)| {
        let found = Warning::new(Finding::Rejected(what, count, of));
        if what == Rejected::NoChecksum { found.cured_by(Remedy::AcceptUnchecked) } else { found }
    });
    repeated.chain(rejected)
}

/// Sentences of every kind, and those that were rejected.
fn all_lines(tally: &Tally) -> u64 {
    tally.valid_sentences() + tally.rejected.total()
}

/// Errors that the sensor reports, and another program on its port.
fn link(snapshot: &Snapshot) -> impl Iterator<Item = Warning> {
    let errors = snapshot.link.unsolicited_errors.iter().map(|(error, count)| {
        let severity = match error {
            // it drops what its buffer cannot hold
            DeviceError::OutputBufferOverflow => Severity::Problem,
            _ => Severity::Caution,
        };
        Warning::new(Finding::DeviceError(error, count)).as_severe_as(severity)
    });
    let shared = snapshot.port_shared_with.clone();
    errors.chain(shared.map(|program| Warning::new(Finding::PortShared(program))))
}
