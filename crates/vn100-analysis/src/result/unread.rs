//! Warnings of numbers of a file that were not read.

use vn100_protocol::stream::AbsentValues;

use crate::{
    remedy::Remedy,
    source_facts::SourceFacts,
    warning::{Finding, Severity, Warning, WarningKind},
};

/// What was taken for absent by the first messages of a bag, and is not; and the numbers of a table
/// that the counts of its first rows do not hold, if they are more than single glitches.
pub(super) fn warnings(facts: &SourceFacts) -> Vec<Warning> {
    let beyond = facts.csv.iter().flat_map(|csv| {
        let is_often = |absent: &&AbsentValues| 1000 * absent.out_of_range > csv.rows;
        csv.absent.iter().filter(is_often).map(|absent| {
            let found = Warning::new(WarningKind::Gaps, Finding::OutOfRange(absent.out_of_range, csv.rows));
            found.of([absent.channel.clone()]).as_severe_as(Severity::Problem)
        })
    });
    let unread = facts.bag.iter().flat_map(|bag| &bag.unread).filter(|unread| unread.nonzero_messages > 0);
    let unread = unread.map(|unread| {
        let found = Warning::new(WarningKind::Gaps, Finding::Unread(unread.clone()));
        found.as_severe_as(Severity::Problem).cured_by(Remedy::MapColumns(None))
    });
    unread.chain(beyond).collect()
}

#[cfg(test)]
mod tests {
    use vn100_protocol::stream::{BagReport, StampSource, UnreadNumbers};

    use super::*;

    #[test]
    fn numbers_taken_for_absent_that_are_not_are_warned_of() {
        for (nonzero_messages, count) in [(0, 0), (50, 1)] {
            let unread =
                vec![UnreadNumbers { path: "linear_acceleration".into(), zero_messages: 100, nonzero_messages }];
            let bag = BagReport { unread, ..BagReport::of("/imu", "sensor_msgs/Imu", StampSource::Recorded) };
            let facts = SourceFacts { bag: Some(bag), ..SourceFacts::default() };
            assert_eq!(warnings(&facts).len(), count);
        }
    }
}
