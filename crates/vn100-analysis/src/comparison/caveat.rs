//! Why records can be compared with reserve only.

use vn100_protocol::Quantity;

use super::{ComparedRecord, fold_alike, means::are_of_several_sensors, onboard, pairs};
use crate::{Onboard, RateFrom, Remedy, Text, assessment::BEFORE_FILTER_S};

/// The kinds of caveat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CaveatKind {
    /// A record holds no samples.
    NoSamples,
    /// The rate of some records is unknown, and their averaging times may be wrong.
    RateAssumed,
    /// Channels that one record has and another has not.
    Channels,
    /// Rates without an averaging time in common.
    NoCommonTau,
    /// The sensor averaged or decimated differently, so that its white noise folds differently.
    Sampling,
    /// The bias was taken out of the gyroscope in one of them.
    Compensation,
    /// The records are of several sensors.
    SeveralSensors,
    /// The sensor was moved: a mean of that record is no bias.
    Moved,
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
        }
    }
}

/// What could not be compared, or only in part.
#[derive(Debug, Clone, PartialEq)]
pub struct Caveat {
    /// What kind it is.
    pub kind: CaveatKind,
    /// The records it concerns.
    pub records: Vec<usize>,
    /// What was found, and what follows.
    pub text: Text,
}

pub(super) fn caveats(records: &[ComparedRecord<'_>]) -> Vec<Caveat> {
    let mut caveats = Vec::new();
    for (number, record) in records.iter().enumerate().filter(|(_, record)| record.snapshot.timing.samples == 0) {
        let text = format!("{} holds no samples and is not compared", record.name);
        caveats.push(Caveat { kind: CaveatKind::NoSamples, records: vec![number], text: text.into() });
    }
    caveats.extend(rate_assumed(records));
    for (number, record) in records.iter().enumerate() {
        if let Some(motion) = &record.assessment.motion {
            let text = format!("{}: {motion}. Its means are no bias and are left out", record.name);
            caveats.push(Caveat { kind: CaveatKind::Moved, records: vec![number], text: text.into() });
        }
    }
    for pair in pairs(records.len()) {
        let [a, b] = pair.map(|number| &records[number]);
        if a.snapshot.timing.samples == 0 || b.snapshot.timing.samples == 0 {
            continue;
        }
        let found = [channels(a, b), rates(a, b), sampling(a, b), compensation(a, b)].into_iter().flatten();
        caveats.extend(found.map(|(kind, text)| Caveat { kind, records: pair.to_vec(), text: text.into() }));
    }
    if are_of_several_sensors(records) {
        let text = "the records tell of more than one serial number: their means are not repetitions of one sensor, and no turn-on to turn-on \
                    bias is given";
        let records = (0..records.len()).collect();
        caveats.push(Caveat { kind: CaveatKind::SeveralSensors, records, text: text.into() });
    }
    caveats
}

fn rate_assumed(records: &[ComparedRecord<'_>]) -> Option<Caveat> {
    let is_assumed = |record: &ComparedRecord<'_>| {
        record.snapshot.timing.samples > 0 && record.snapshot.timing.rate_from == RateFrom::Assumed
    };
    let assumed: Vec<usize> = (0..records.len()).filter(|number| is_assumed(&records[*number])).collect();
    let names: Vec<&str> = assumed.iter().map(|number| records[*number].name).collect();
    let first = &records[*assumed.first()?].snapshot.timing;
    let text = Text::from(format!(
        "nothing tells the rate of {}; {} Hz are assumed, and every tau and N rests on that: give ",
        names.join(", "),
        first.rate_hz
    ));
    let text = text
        .remedy(Remedy::GiveRate(None))
        .then(", and compare captures of different rates as recordings, which keep theirs");
    Some(Caveat { kind: CaveatKind::RateAssumed, records: assumed, text })
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

/// Names and units.
fn names(record: &ComparedRecord<'_>) -> Vec<(String, String)> {
    record
        .snapshot
        .layout_channels()
        .iter()
        .map(|channel| (channel.name.to_string(), channel.unit.to_string()))
        .collect()
}

fn rates(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let [rate_a, rate_b] = [a, b].map(|record| record.snapshot.timing.rate_hz);
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
            "the sensor averages and decimates differently in {} and {}: its white noise folds differently{by}, and a difference of short octaves \
             or of N need not be one of the sensors",
            a.name, b.name
        );
        (CaveatKind::Sampling, text)
    })
}

fn compensation(a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> Option<(CaveatKind, String)> {
    let compensated =
        |record: &ComparedRecord<'_>| record.snapshot.layout.as_ref().is_some_and(|layout| layout.compensated);
    (compensated(a) != compensated(b)).then(|| {
        let (tracked, own) = if compensated(a) { (a, b) } else { (b, a) };
        let text = format!(
            "the gyroscope's bias is taken out in {} and not in {}: its octaves are compared up to {BEFORE_FILTER_S} s",
            tracked.name, own.name
        );
        (CaveatKind::Compensation, text)
    })
}
