//! Warnings of numbers of a file that were not read.

use vn100_protocol::stream::AbsentValues;

use crate::{
    remedy::{Remedy, Text},
    source_facts::SourceFacts,
    warning::{Warning, WarningKind},
};

/// What was taken for absent by the first messages of a bag, and is not; and the numbers of a table
/// that the counts of its first rows do not hold, if they are more than single glitches.
pub(super) fn warnings(facts: &SourceFacts) -> Vec<Warning> {
    let beyond = facts.csv.iter().flat_map(|csv| {
        let is_often = |absent: &&AbsentValues| 1000 * absent.out_of_range > csv.rows;
        csv.absent.iter().filter(is_often).map(|absent| {
            let headline = format!(
                "{} of {} values of {} are far beyond those of the first rows, and missing",
                absent.out_of_range, csv.rows, absent.channel
            );
            let details = "The first 1000 rows decide how large a number can be: 64 times their deviation. Cut off the rows that \
                           differ from the others.";
            Warning::new(WarningKind::UnreadValues, vec![absent.channel.clone()], headline, details)
        })
    });
    let unread = facts.bag.iter().flat_map(|bag| &bag.unread).filter(|unread| unread.nonzero_messages > 0);
    let unread = unread.map(|unread| {
        let details = Text::from("Exclude the messages before, or name all numbers with ");
        let details = details.remedy(Remedy::MapColumns(None)).then(".");
        Warning::new(WarningKind::UnreadValues, Vec::new(), unread.to_string(), details)
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
