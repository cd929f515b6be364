//! Which of several records of one sensor to use.

use super::{ComparedRecord, Comparison, Ranking, SameSamples};
use crate::SharedRows;

/// Relative difference up to which the lengths of two records are the same.
const SAME_LENGTH: f64 = 0.01;

/// The record to use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recommendation {
    /// The number of the record.
    pub record: usize,
    /// The reason.
    pub why: WhyUse,
    /// The other undisturbed records whose N could not be tested against that of the record; not
    /// those whose samples are all in another.
    pub untested: Vec<usize>,
    /// The disturbed records that are longer.
    pub longer_disturbed: Vec<usize>,
}

/// Why a record is the one to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WhyUse {
    /// No other record is undisturbed.
    OnlyUndisturbed,
    /// The record is undisturbed, and significantly quieter than every other undisturbed one.
    Quietest,
    /// The record is undisturbed, no other undisturbed one is significantly quieter, and it is the
    /// longest of those.
    LongestOfQuiet,
    /// As [`LongestOfQuiet`](Self::LongestOfQuiet), where several are as long; N of this record is
    /// the smallest.
    SmallestOfQuiet,
}

/// Why no record is the one to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WhyNone {
    /// The records are of several sensors.
    SeveralSensors,
    /// All records are disturbed, or hold no samples.
    AllDisturbed,
    /// No undisturbed record has N estimated on every axis of every sensor.
    NotRanked,
}

impl WhyUse {
    /// Its name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OnlyUndisturbed => "only-undisturbed",
            Self::Quietest => "quietest",
            Self::LongestOfQuiet => "longest-of-quiet",
            Self::SmallestOfQuiet => "smallest-of-quiet",
        }
    }
}

impl WhyNone {
    /// Its name in results: lower case, words joined by hyphens.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SeveralSensors => "several-sensors",
            Self::AllDisturbed => "all-disturbed",
            Self::NotRanked => "not-ranked",
        }
    }
}

/// The recommendation: of the undisturbed records with N on every axis of their sensors those that
/// no other has a significantly smaller N than, in any sensor; of these the longest; of several as
/// long the one with the smallest N.
pub(super) fn recommendation(
    comparison: &Comparison,
    records: &[ComparedRecord<'_>],
) -> Result<Recommendation, WhyNone> {
    if super::means::are_of_several_sensors(records) {
        return Err(WhyNone::SeveralSensors);
    }
    let is_disturbed = |record: usize| {
        records[record].assessment.motion.is_some()
            || comparison.disturbances.iter().any(|disturbance| disturbance.record == record)
    };
    let has_samples = |record: &usize| records[*record].snapshot.timing.samples > 0;
    let undisturbed: Vec<usize> =
        (0..records.len()).filter(has_samples).filter(|record| !is_disturbed(*record)).collect();
    if undisturbed.is_empty() {
        return Err(WhyNone::AllDisturbed);
    }
    let is_ranked = |record: &usize| {
        let is_among = |ranking: &Ranking| ranking.records.iter().any(|ranked| ranked.record == *record);
        // another message may lack a sensor
        let is_unknown = |ranking: &Ranking| ranking.not_ranked.contains(record);
        comparison.rankings.iter().any(is_among) && !comparison.rankings.iter().any(is_unknown)
    };
    let is_new = |record: &usize| !undisturbed.iter().any(|other| is_part(&comparison.same_samples, *record, *other));
    let candidates: Vec<usize> = undisturbed.iter().copied().filter(is_ranked).filter(is_new).collect();
    let is_undercut = |record: &usize| {
        let tests =
            comparison.rankings.iter().flat_map(|ranking| ranking.tests.iter().map(move |test| (ranking, test)));
        tests.filter(|(_, test)| comparison.is_significant(test.chance)).any(|(ranking, test)| {
            let own =
                |of: usize| ranking.records.iter().find(|ranked| ranked.record == of).map(super::RankedRecord::own);
            let other = test.records.into_iter().find(|other| other != record && candidates.contains(other));
            test.records.contains(record) && other.is_some_and(|other| own(other) < own(*record))
        })
    };
    let mut quiet: Vec<usize> = candidates.iter().copied().filter(|record| !is_undercut(record)).collect();
    if quiet.is_empty() {
        // where each record is noisier than another in some sensor, all of them remain
        quiet.clone_from(&candidates);
    }
    let length = |record: usize| records[record].snapshot.timing.duration_s();
    let longest = quiet.iter().map(|record| length(*record)).fold(0.0, f64::max);
    let long = quiet.iter().copied().filter(|record| length(*record) >= (1.0 - SAME_LENGTH) * longest);
    let long: Vec<usize> = long.collect();
    let size = |record: &usize| size(comparison, *record, &long);
    let record = long.iter().copied().min_by(|a, b| size(a).total_cmp(&size(b)));
    let record = record.ok_or(WhyNone::NotRanked)?;
    let why = match (undisturbed.len(), quiet.len(), long.len()) {
        (1, ..) => WhyUse::OnlyUndisturbed,
        (_, 1, _) if candidates.len() > 1 => WhyUse::Quietest,
        (.., 1) => WhyUse::LongestOfQuiet,
        _ => WhyUse::SmallestOfQuiet,
    };
    let is_tested = |other: &usize| {
        let mut tests = comparison.rankings.iter().flat_map(|ranking| &ranking.tests);
        tests.any(|test| test.records.contains(&record) && test.records.contains(other))
    };
    let is_longer = |other: &usize| is_disturbed(*other) && length(*other) > (1.0 + SAME_LENGTH) * length(record);
    let others = undisturbed.iter().copied().filter(|other| *other != record).filter(is_new);
    Ok(Recommendation {
        record,
        why,
        untested: others.filter(|other| !is_tested(other)).collect(),
        longer_disturbed: (0..records.len()).filter(is_longer).collect(),
    })
}

/// N of all sensors that each of `records` has, together, on a logarithmic scale.
fn size(comparison: &Comparison, record: usize, records: &[usize]) -> f64 {
    let has = |ranking: &Ranking, record: usize| ranking.records.iter().any(|ranked| ranked.record == record);
    let shared = comparison.rankings.iter().filter(|ranking| records.iter().all(|record| has(ranking, *record)));
    let ranked = shared.flat_map(|ranking| &ranking.records);
    ranked.filter(|ranked| ranked.record == record).map(|ranked| ranked.own().ln()).sum()
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
