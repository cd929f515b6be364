//! Tables whose rows differ: columns of different rates are streams, and rows of several sensors are
//! refused.

use super::{
    HeadRows, Unusable,
    channels::{quantity_word, rank},
    columns::Column,
    header::Header,
    holds_number, shown,
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

/// Words in the name of a column that names the sensor of each row.
const SENSORS: [&str; 11] =
    ["sensor", "device", "imu", "id", "name", "serial", "source", "node", "mac", "topic", "frame"];

/// The most sensors of one table: a column with more values is a count.
const MOST_SENSORS: usize = 16;

/// The smallest fraction of the rows that belongs to a sensor, and that are followed by a row of
/// another one.
const OF_SENSOR: f64 = 0.05;

/// The names of the streams of a table by its first rows; none if all columns are one stream.
pub(super) fn streams(columns: &[Column], rows: &HeadRows) -> Vec<String> {
    let mut quantities: Vec<(&str, Vec<bool>)> = Vec::new();
    for column in columns {
        let word = quantity_word(column.name());
        let present = rows.iter().map(|row| holds_number(row, column.place));
        match quantities.iter_mut().find(|(other, _)| *other == word) {
            Some((_, all)) => all.iter_mut().zip(present).for_each(|(any, present)| *any |= present),
            None => quantities.push((word, present.collect())),
        }
    }
    let values = |present: &[bool]| present.iter().filter(|present| **present).count();
    quantities.retain(|(_, present)| values(present) >= FEWEST_VALUES);
    quantities.sort_by_key(|(word, present)| (std::cmp::Reverse(values(present)), rank(word)));
    let mut groups: Vec<(Vec<&str>, Vec<bool>)> = Vec::new();
    for (word, present) in quantities {
        match groups.iter_mut().find(|(_, most)| are_of_one_rate(most, &present)) {
            Some((words, _)) => words.push(word),
            None => groups.push((vec![word], present)),
        }
    }
    let name = |(mut words, _): (Vec<&str>, _)| {
        words.sort_by_key(|word| rank(word));
        words.join(" ")
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

/// Checks that all rows are of one sensor, by a column that is not `taken`.
///
/// # Errors
/// [`Unusable`] with the sensors in the order of their first rows, and the command that keeps one.
pub(super) fn check_one_sensor(
    header: &Header,
    rows: &HeadRows,
    taken: impl Fn(usize) -> bool,
) -> Result<(), Unusable> {
    let is_named = |name: &str| {
        let name = name.to_lowercase();
        let mut words = name.split(|c: char| !c.is_alphabetic());
        words.any(|word| SENSORS.contains(&word) || SENSORS.contains(&word.strip_suffix("id").unwrap_or(word)))
    };
    let mut named = (0..header.names.len()).filter(|&place| !taken(place) && is_named(&header.names[place]));
    let Some((place, sensors)) = named.find_map(|place| Some((place, sensors(rows, place)?))) else { return Ok(()) };
    let (column, number, first) = (&header.names[place], place + 1, &sensors[0]);
    Err(Unusable::certain(format!(
        "the rows are of several sensors, by column {column:?}: {}; keep those of one, as awk -F, 'NR==1 || ${number}==\"{first}\"' does",
        sensors.join(", ")
    )))
}

/// The values of a column, if there are several, each in many rows, that alternate.
fn sensors(rows: &HeadRows, place: usize) -> Option<Vec<String>> {
    let cells: Vec<&[u8]> = rows.iter().filter_map(|row| row.get(place)).map(Vec::as_slice).collect();
    let mut sensors: Vec<&[u8]> = Vec::new();
    for cell in &cells {
        if !sensors.contains(cell) {
            sensors.push(cell);
        }
        if sensors.len() > MOST_SENSORS || cell.is_empty() {
            return None;
        }
    }
    let are_enough = |count: usize| count as f64 >= OF_SENSOR * cells.len() as f64;
    let changes = cells.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let is_one = |sensor: &&[u8]| are_enough(cells.iter().filter(|cell| *cell == sensor).count());
    let are_several = sensors.len() > 1 && sensors.iter().all(is_one) && are_enough(changes);
    are_several.then(|| sensors.into_iter().map(shown).collect())
}
