//! Streams of different rates in one table: its quantities, grouped by the rows that hold them.

use super::{
    HeadRows,
    channels::{known, quantity_word, rank},
    columns::ChannelColumn,
    holds_number,
};

/// The smallest fraction of the rows with either of two quantities that have both, for quantities of
/// one rate.
const SAME_RATE: f64 = 0.75;

/// A quantity in less than this fraction of the rows of another one has a rate of its own.
const LOSSY: f64 = 0.25;

/// The fraction of the rows of a quantity with dropped samples that also have the others of its rate.
const SHARED: f64 = 0.9;

/// A quantity with fewer values forms no stream of its own.
const FEWEST_VALUES: usize = 10;

/// The names of the streams of a table by its first rows; none if all columns are one stream.
pub(super) fn streams(channels: &[ChannelColumn], rows: &HeadRows) -> Vec<String> {
    let mut quantities: Vec<(&str, Vec<bool>)> = Vec::new();
    for column in channels {
        let word = quantity_word(&known(column.channel).name);
        let present = rows.iter().map(|row| holds_number(row, column.place));
        match quantities.iter_mut().find(|(other, _)| *other == word) {
            Some((_, all)) => all.iter_mut().zip(present).for_each(|(any, present)| *any |= present),
            None => quantities.push((word, present.collect())),
        }
    }
    let values = |present: &[bool]| present.iter().filter(|present| **present).count();
    quantities.retain(|(_, present)| values(present) >= FEWEST_VALUES);
    quantities.sort_by_key(|(word, present)| (std::cmp::Reverse(values(present)), rank(word)));
    let mut groups: Vec<Vec<(&str, Vec<bool>)>> = Vec::new();
    for quantity in quantities {
        match groups.iter_mut().find(|group| are_of_one_rate(&group[0].1, &quantity.1)) {
            Some(group) => group.push(quantity),
            None => groups.push(vec![quantity]),
        }
    }
    let name = |mut group: Vec<(&str, Vec<bool>)>| {
        group.sort_by_key(|(word, _)| rank(word));
        group.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(" ")
    };
    let mut names: Vec<String> = groups.into_iter().map(name).collect();
    names.sort_by_key(|name| rank(name));
    if names.len() < 2 { Vec::new() } else { names }
}

/// Whether a quantity with at most as many values as `most` has the same rate, with some values
/// dropped.
fn are_of_one_rate(most: &[bool], fewer: &[bool]) -> bool {
    let both: Vec<bool> = most.iter().zip(fewer).filter(|(most, _)| **most).map(|(_, fewer)| *fewer).collect();
    let count = |present: &[bool]| present.iter().filter(|present| **present).count() as f64;
    let (all, values, shared) = (both.len() as f64, count(fewer), count(&both));
    if values >= SAME_RATE * (all + values - shared) {
        return true;
    }
    // if values are lost at random, a value follows another as often as a value exists; at an even rate, as
    // rarely as possible
    let share = values / all;
    let evenly = (2.0 - share.recip()).max(0.0);
    let follow = both.windows(2).filter(|pair| pair[0] && pair[1]).count() as f64 / values;
    share >= LOSSY && shared >= SHARED * values && follow >= 0.5 * (share + evenly)
}
