//! Why records can be compared only in part.

use vn100_protocol::Quantity;

use super::{ComparedRecord, SameSamples, fold_alike, means::are_of_several_sensors, onboard, pairs};
use crate::{Onboard, RateFrom, Remedy, assessment::BEFORE_FILTER_S};

/// The kinds of caveat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CaveatKind {
    /// A record holds no samples.
    NoSamples,
    /// The rate of some records is unknown, and their averaging times may be wrong.
    RateAssumed,
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
    /// The sensor was moved during a record, whose mean is then not the bias.
    Moved,
    /// Two records hold the same samples.
    SameSamples,
    /// The start of some records is not known: differences of means are given without a
    /// probability.
    StartUnknown,
    /// The sensor may have been switched off between the records: differences of means are given
    /// without a probability.
    MayHaveBeenOff,
}

impl CaveatKind {
    /// Its name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSamples => "no-samples",
            Self::RateAssumed => "rate-assumed",
            Self::Channels => "channels",
            Self::NoCommonTau => "no-common-tau",
            Self::Sampling => "sampling",
            Self::Compensation => "compensation",
            Self::SeveralSensors => "several-sensors",
            Self::Moved => "moved",
            Self::SameSamples => "same-samples",
            Self::StartUnknown => "start-unknown",
            Self::MayHaveBeenOff => "may-have-been-off",
        }
    }
}

/// What could not be compared, or only in part.
#[derive(Debug, Clone, PartialEq)]
pub struct Caveat {
    /// The kind of caveat.
    pub kind: CaveatKind,
    /// The numbers of the records concerned.
    pub records: Vec<usize>,
    /// What was found, and its consequence.
    pub text: String,
    /// What can be done about it; `None` if nothing but what the text says.
    pub remedy: Option<Remedy>,
}

pub(super) fn caveats(records: &[ComparedRecord<'_>], same: &[SameSamples], stayed_on: bool) -> Vec<Caveat> {
    let mut caveats: Vec<Caveat> = same.iter().map(|same| same_samples(records, same)).collect();
    for (number, record) in records.iter().enumerate().filter(|(_, record)| record.snapshot.timing.samples == 0) {
        let text = format!("{} holds no samples and is not compared", record.name);
        caveats.push(Caveat { kind: CaveatKind::NoSamples, records: vec![number], text, remedy: None });
    }
    caveats.extend(rate_assumed(records));
    for (number, record) in records.iter().enumerate() {
        if record.assessment.motion.is_some() {
            let text = format!("{}: sensor moved. Its means are no bias and are excluded", record.name);
            caveats.push(Caveat { kind: CaveatKind::Moved, records: vec![number], text, remedy: None });
        }
    }
    for pair in pairs(records.len()) {
        let [a, b] = pair.map(|number| &records[number]);
        if a.snapshot.timing.samples == 0 || b.snapshot.timing.samples == 0 {
            continue;
        }
        let found = [channels(a, b), rates(a, b), sampling(a, b), compensation(a, b)].into_iter().flatten();
        caveats.extend(found.map(|(kind, text)| Caveat { kind, records: pair.to_vec(), text, remedy: None }));
    }
    if are_of_several_sensors(records) {
        let text = "the records have more than one serial number: their means are not repetitions of one sensor, and no turn-on to turn-on \
                    bias is given";
        let records = (0..records.len()).collect();
        caveats.push(Caveat { kind: CaveatKind::SeveralSensors, records, text: text.into(), remedy: None });
    } else {
        caveats.extend(without_chance(records, stayed_on));
    }
    caveats
}

fn same_samples(records: &[ComparedRecord<'_>], same: &SameSamples) -> Caveat {
    let [a, b] = same.records.map(|record| records[record].name);
    let (of_a, of_b) = (same.shared.of_first, same.shared.of_second);
    let text = match (of_a >= SameSamples::WHOLE, of_b >= SameSamples::WHOLE) {
        (true, true) => format!("{a} and {b} hold the same samples: it is the same recording"),
        (true, false) => format!("{a} is a part of {b}: all its samples are in it"),
        (false, true) => format!("{b} is a part of {a}: all its samples are in it"),
        (false, false) => format!(
            "{a} and {b} overlap: about {:.0} % of the samples of the first are in the second, which are {:.0} % of that",
            100.0 * of_a,
            100.0 * of_b
        ),
    };
    let text = format!("{text}. They are not tested against each other");
    Caveat { kind: CaveatKind::SameSamples, records: same.records.to_vec(), text, remedy: None }
}

/// Why differences of means have no probability; `None` where they have one, and where fewer than
/// two records have means.
fn without_chance(records: &[ComparedRecord<'_>], stayed_on: bool) -> Option<Caveat> {
    let has_means =
        |record: &ComparedRecord<'_>| record.snapshot.timing.samples > 0 && record.assessment.motion.is_none();
    let measured: Vec<usize> = (0..records.len()).filter(|number| has_means(&records[*number])).collect();
    if measured.len() < 2 {
        return None;
    }
    let unknown: Vec<usize> = measured.iter().copied().filter(|number| records[*number].start_ns().is_none()).collect();
    if !unknown.is_empty() {
        let names: Vec<&str> = unknown.iter().map(|number| records[*number].name).collect();
        let text = format!(
            "the start of {} is unknown, and slow noise moves a mean further over a longer time: differences of means are given without a \
             significance. A recording contains its start",
            names.join(", ")
        );
        return Some(Caveat { kind: CaveatKind::StartUnknown, records: unknown, text, remedy: None });
    }
    (!stayed_on).then(|| {
        let text = "each record is a connection of its own, and a sensor that was switched off between them starts with another bias: \
                    differences of means are given without a significance";
        let remedy = Some(Remedy::SayStayedOn);
        Caveat { kind: CaveatKind::MayHaveBeenOff, records: measured, text: text.into(), remedy }
    })
}

fn rate_assumed(records: &[ComparedRecord<'_>]) -> Option<Caveat> {
    let is_assumed = |record: &ComparedRecord<'_>| {
        record.snapshot.timing.samples > 0 && record.snapshot.timing.rate_from == RateFrom::Assumed
    };
    let assumed: Vec<usize> = (0..records.len()).filter(|number| is_assumed(&records[*number])).collect();
    let names: Vec<&str> = assumed.iter().map(|number| records[*number].name).collect();
    let first = &records[*assumed.first()?].snapshot.timing;
    let text = format!(
        "sample rate of {} unknown; {} Hz assumed, and all averaging times and N scale with it. Recordings of this program keep their rate",
        names.join(", "),
        first.rate_hz
    );
    Some(Caveat { kind: CaveatKind::RateAssumed, records: assumed, text, remedy: Some(Remedy::GiveRate(None)) })
}

fn channels(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let (of_a, of_b) = (names(a), names(b));
    let only = |of: &[(String, String)], other: &[(String, String)]| -> Vec<String> {
        of.iter().filter(|name| !other.contains(name)).map(|(name, _)| name.clone()).collect()
    };
    let lone: Vec<String> = [(a, only(&of_a, &of_b)), (b, only(&of_b, &of_a))]
        .into_iter()
        .filter(|(_, names)| !names.is_empty())
        .map(|(record, names)| format!("{} alone has {}", record.name, names.join(", ")))
        .collect();
    (!lone.is_empty()).then(|| (CaveatKind::Channels, format!("{}: not compared", lone.join("; "))))
}

/// Names and units of the channels.
fn names(record: &ComparedRecord<'_>) -> Vec<(String, String)> {
    record
        .snapshot
        .layout_channels()
        .iter()
        .map(|channel| (channel.name.to_string(), channel.unit.to_string()))
        .collect()
}

fn rates(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let [rate_a, rate_b] = [a, b].map(|record| (record.snapshot.timing.rate_hz * 1e4).round() / 1e4); // as printed
    let octaves_apart = (rate_a / rate_b).log2();
    ((octaves_apart - octaves_apart.round()).abs() > 1e-3).then(|| {
        let text = format!(
            "{} at {rate_a} Hz and {} at {rate_b} Hz have no averaging time in common: their octaves are not compared",
            a.name, b.name
        );
        (CaveatKind::NoCommonTau, text)
    })
}

fn sampling(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let of = |record| onboard(Quantity::AngularRate, record);
    let factors = of(a).zip(of(b)).map(|(a, b)| (a.window.white_factor(), b.window.white_factor()));
    let same_rate = (a.snapshot.timing.rate_hz / b.snapshot.timing.rate_hz - 1.0).abs() < 1e-3;
    let same_folding = factors.is_none() || fold_alike(Quantity::AngularRate, a, b);
    (!same_rate || !same_folding).then(|| {
        let by = factors.map_or_else(String::new, |(of_a, of_b)| {
            format!(" (by {of_a:.2} in {} and {of_b:.2} in {}, ±{:.0} %)", a.name, b.name, 100.0 * Onboard::UNCERTAINTY)
        });
        let text = format!(
            "the sensor averages and decimates differently in {} and {}: aliasing raises its white noise differently{by}, so that differences of short \
             octaves or of N need not be differences of the sensors",
            a.name, b.name
        );
        (CaveatKind::Sampling, text)
    })
}

fn compensation(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let compensated = |record: &ComparedRecord<'_>| record.snapshot.layout.as_ref()?.compensated;
    let whether = match (compensated(a), compensated(b)) {
        (a, b) if a == b => return None,
        (None, _) => format!("may be removed in {}, which does not state it", a.name),
        (_, None) => format!("may be removed in {}, which does not state it", b.name),
        (Some(true), _) => format!("is removed in {} but not in {}", a.name, b.name),
        (Some(false), _) => format!("is removed in {} but not in {}", b.name, a.name),
    };
    let text = format!("the gyroscope's bias {whether}: its octaves are compared up to {BEFORE_FILTER_S} s");
    Some((CaveatKind::Compensation, text))
}
