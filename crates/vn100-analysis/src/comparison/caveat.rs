//! Why records can be compared only in part.

use serde::Serialize;
use vn100_protocol::Quantity;

use super::{SameSamples, fold_alike, have_same_rate, pairs, rate_hz};
use crate::SourceResult;

/// The kinds of caveat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaveatKind {
    /// Two records hold the same samples.
    SameSamples,
    /// A record holds no samples.
    NoSamples,
    /// The rate of some records is unknown, and their averaging times may be wrong.
    RateAssumed,
    /// The sensor was moved during a record, whose mean is then not the bias.
    Moved,
    /// One record has channels that another does not have.
    Channels,
    /// The records have no averaging time in common, because of their rates.
    NoCommonTau,
    /// The sensor averaged or decimated differently, so that its white noise aliases differently.
    Sampling,
    /// The bias was removed from the gyroscope in some records.
    Compensation,
    /// The records are of several sensors.
    SeveralSensors,
}

/// What could not be compared, or only in part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Caveat {
    /// The kind of caveat.
    pub kind: CaveatKind,
    /// The numbers of the records concerned.
    pub records: Vec<usize>,
}

pub(super) fn caveats(records: &[SourceResult], same: &[SameSamples]) -> Vec<Caveat> {
    let caveat = |kind, records: &[usize]| Caveat { kind, records: records.to_vec() };
    let has_samples = |number: &usize| records[*number].timing.samples > 0;
    let (measured, empty): (Vec<usize>, Vec<usize>) = (0..records.len()).partition(has_samples);
    let mut found: Vec<Caveat> = same.iter().map(|same| caveat(CaveatKind::SameSamples, &same.records)).collect();
    found.extend(empty.iter().map(|number| caveat(CaveatKind::NoSamples, &[*number])));
    let is_assumed = |number: &usize| records[*number].timing.is_rate_assumed();
    let assumed: Vec<usize> = measured.iter().copied().filter(is_assumed).collect();
    found.extend((!assumed.is_empty()).then(|| caveat(CaveatKind::RateAssumed, &assumed)));
    let moved = measured.iter().filter(|number| records[**number].motion.is_some());
    found.extend(moved.map(|number| caveat(CaveatKind::Moved, &[*number])));
    for pair in pairs(records.len()).filter(|pair| pair.iter().all(has_samples)) {
        let [a, b] = pair.map(|number| &records[number]);
        let kinds = [
            (has_other_channels(a, b), CaveatKind::Channels),
            (!have_common_tau(a, b), CaveatKind::NoCommonTau),
            (!have_same_rate(a, b) || !fold_alike(Quantity::AngularRate, a, b), CaveatKind::Sampling),
            (a.source.compensated != b.source.compensated, CaveatKind::Compensation),
        ];
        found.extend(kinds.iter().filter(|(applies, _)| *applies).map(|(_, kind)| caveat(*kind, &pair)));
    }
    if are_of_several_sensors(records) {
        found.push(caveat(CaveatKind::SeveralSensors, &(0..records.len()).collect::<Vec<_>>()));
    }
    found
}

/// Whether one of the records has a channel, by name and unit, that the other lacks.
fn has_other_channels(a: &SourceResult, b: &SourceResult) -> bool {
    let [a, b] = [a, b].map(|record| {
        record.streamed().map(|channel| (&channel.name, &channel.unit)).collect::<std::collections::BTreeSet<_>>()
    });
    a != b
}

/// Whether the rates, as they are printed, are octaves apart.
fn have_common_tau(a: &SourceResult, b: &SourceResult) -> bool {
    let [a, b] = [a, b].map(|record| (rate_hz(record) * 1e4).round() / 1e4);
    let octaves_apart = (a / b).log2();
    (octaves_apart - octaves_apart.round()).abs() <= 1e-3
}

/// Whether two of the records name different serial numbers.
pub(super) fn are_of_several_sensors(records: &[SourceResult]) -> bool {
    let mut serials = records.iter().filter_map(|record| record.source.device.as_ref()?.serial_number.as_ref());
    let first = serials.next();
    serials.any(|serial| Some(serial) != first)
}
