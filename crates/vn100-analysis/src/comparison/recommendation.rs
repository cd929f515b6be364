//! Which of several records of one sensor to use.

use serde::Serialize;

use super::{ComparedRecord, Ranking, RecordDisturbance, SameSamples, caveat::are_of_several_sensors};
use crate::SharedRows;

/// Relative difference up to which the lengths of two records are the same.
const SAME_LENGTH: f64 = 0.01;

/// The record to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Recommendation {
    /// The number of the record; `None` if none is recommended.
    pub record: Option<usize>,
    /// Why that one, or why none.
    pub why: WhyUse,
}

/// Why a record is the one to use, or why none is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WhyUse {
    /// No other record is undisturbed.
    OnlyUndisturbed,
    /// The record is undisturbed, and significantly quieter than every other undisturbed one.
    Quietest,
    /// The record is undisturbed, and no other undisturbed one is longer or known to be quieter.
    LongestOfQuiet,
    /// As [`LongestOfQuiet`](Self::LongestOfQuiet), if several are as long; N of this record is the
    /// smallest.
    SmallestOfQuiet,
    /// None: the records are of several sensors.
    SeveralSensors,
    /// None: all records are disturbed, or hold no samples.
    AllDisturbed,
    /// None: no undisturbed record has N estimated on every axis of every sensor.
    NotRanked,
}

/// Of the undisturbed records with N on every axis of their sensors those that no other has a
/// significantly smaller N than, in any sensor; of these the longest; of several as long the one with
/// the smallest N.
pub(super) fn recommendation(
    records: &[ComparedRecord<'_>],
    rankings: &[Ranking],
    disturbances: &[RecordDisturbance],
    same: &[SameSamples],
) -> Recommendation {
    let none = |why| Recommendation { record: None, why };
    if are_of_several_sensors(records) {
        return none(WhyUse::SeveralSensors);
    }
    let is_undisturbed = |record: &usize| {
        let ComparedRecord { snapshot, assessment } = &records[*record];
        let is_at_rest = snapshot.timing.samples > 0 && assessment.motion.is_none();
        is_at_rest && disturbances.iter().all(|disturbance| disturbance.record != *record)
    };
    let undisturbed: Vec<usize> = (0..records.len()).filter(is_undisturbed).collect();
    if undisturbed.is_empty() {
        return none(WhyUse::AllDisturbed);
    }
    let is_part_of_other = |record: &usize| undisturbed.iter().any(|other| is_part(same, *record, *other));
    let candidates: Vec<usize> = undisturbed
        .iter()
        .copied()
        .filter(|record| is_ranked(rankings, *record) && !is_part_of_other(record))
        .collect();
    let is_quiet = |record: &usize| !is_undercut(rankings, *record, &candidates);
    let mut quiet: Vec<usize> = candidates.iter().copied().filter(is_quiet).collect();
    if quiet.is_empty() {
        // if each record is noisier than another in some sensor, all of them remain
        quiet.clone_from(&candidates);
    }
    let length = |record: &usize| records[*record].snapshot.timing.duration_s();
    let longest = quiet.iter().map(length).fold(0.0, f64::max);
    let long: Vec<usize> =
        quiet.iter().copied().filter(|record| length(record) >= (1.0 - SAME_LENGTH) * longest).collect();
    let size = |record: &usize| size(rankings, *record, &long);
    let Some(record) = long.iter().copied().min_by(|a, b| size(a).total_cmp(&size(b))) else {
        return none(WhyUse::NotRanked);
    };
    let is_tested = rankings.iter().flat_map(|ranking| &ranking.tests).any(|test| test.records.contains(&record));
    let why = match (undisturbed.len(), quiet.len(), long.len()) {
        (1, ..) => WhyUse::OnlyUndisturbed,
        (_, 1, _) if candidates.len() > 1 => WhyUse::Quietest,
        (.., 1) => WhyUse::LongestOfQuiet,
        _ if is_tested => WhyUse::SmallestOfQuiet,
        _ => WhyUse::LongestOfQuiet,
    };
    Recommendation { record: Some(record), why }
}

/// Whether N is estimated on every axis of every sensor of the record; a message may lack a sensor.
fn is_ranked(rankings: &[Ranking], record: usize) -> bool {
    rankings.iter().any(|ranking| ranking.own(record).is_some())
        && !rankings.iter().any(|ranking| ranking.not_ranked.contains(&record))
}

/// Whether another candidate has a significantly smaller N of some sensor.
fn is_undercut(rankings: &[Ranking], record: usize, candidates: &[usize]) -> bool {
    rankings.iter().any(|ranking| {
        let mut tests = ranking.tests.iter().filter(|test| test.chance.differs && test.records.contains(&record));
        tests.any(|test| {
            let other = test.records.into_iter().find(|other| *other != record && candidates.contains(other));
            other.is_some_and(|other| ranking.own(other) < ranking.own(record))
        })
    })
}

/// N of all sensors that each of `records` has, together, on a logarithmic scale.
fn size(rankings: &[Ranking], record: usize, records: &[usize]) -> f64 {
    let shared = rankings.iter().filter(|ranking| records.iter().all(|record| ranking.own(*record).is_some()));
    shared.filter_map(|ranking| ranking.own(record)).map(f64::ln).sum()
}

/// Whether all samples of `record` are also in `other`; of two equal records, the later one is a
/// part of the other.
fn is_part(same: &[SameSamples], record: usize, other: usize) -> bool {
    let found = same.iter().find(|same| same.records.contains(&record) && same.records.contains(&other));
    found.filter(|_| record != other).is_some_and(|same| {
        let SharedRows { of_first, of_second } = same.shared;
        let (own, others) = if same.records[0] == record { (of_first, of_second) } else { (of_second, of_first) };
        let whole = |share: f64| share >= SameSamples::WHOLE;
        whole(own) && (!whole(others) || record > other)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_whole_in_the_other_and_of_two_alike_the_later_one_is_it() {
        let parts = |of_first, of_second| {
            let same = [SameSamples { records: [1, 4], shared: SharedRows { of_first, of_second } }];
            [[1, 4], [4, 1], [1, 1], [2, 4]].map(|[record, other]| is_part(&same, record, other))
        };
        assert_eq!(parts(1.0, 0.5), [true, false, false, false]);
        assert_eq!(parts(0.5, 0.98), [false, true, false, false]);
        assert_eq!(parts(1.0, 1.0), [false, true, false, false]);
        assert_eq!(parts(0.5, 0.97), [false; 4]);
    }
}
