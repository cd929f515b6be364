//! Warnings of numbers of a file that were not read.

use vn100_protocol::stream::AbsentValues;

use crate::{
    source_facts::SourceFacts,
    warning::{Finding, Severity, Warning},
};

/// The numbers of a table that the counts of its first rows do not hold, beyond glitches.
pub(super) fn warnings(facts: &SourceFacts) -> Vec<Warning> {
    let beyond = facts.csv.iter().flat_map(|csv| {
        let is_often = |absent: &&AbsentValues| 1000 * absent.out_of_range > csv.rows;
        csv.absent.iter().filter(is_often).map(|absent| {
            let found = Warning::new(Finding::OutOfRange(absent.out_of_range, csv.rows));
            found.of([absent.channel.clone()]).as_severe_as(Severity::Problem)
        })
    });
    beyond.collect()
}
