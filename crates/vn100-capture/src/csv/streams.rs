//! Streams of different rates in one table: its channels, grouped by the rows that hold them.

use std::io::Read;

use vn100_protocol::Channel;

use super::{CsvPlan, Kind, lines::Lines, name::quantity_word, resolution::HEAD_ROWS, row_parser::RowParser};

/// The smallest fraction of the rows with either of two channels that have both, for channels of
/// one rate.
const SAME_RATE: f64 = 0.75;

/// A channel in less than this fraction of the rows of another one has a rate of its own.
const LOSSY: f64 = 0.25;

/// The fraction of the rows of a channel with dropped samples that also have the other channels of
/// its rate.
const SHARED: f64 = 0.9;

/// A channel with fewer values forms no stream of its own.
const FEWEST_VALUES: u64 = 10;

/// The quantities that are named first.
const FIRST: [&str; 3] = ["gyro", "accel", "mag"];

/// The names of the streams of a table; none if all columns are one stream. A table is one stream
/// if its first thousand rows lack no value, if it has no times and so no known rate, or if it has
/// the fields of a message of the sensor.
pub(crate) fn streams(plan: CsvPlan, reader: impl Read) -> Vec<String> {
    let channels = match &plan.kind {
        Kind::Values(layout) if layout.message == "CSV" && plan.times.is_some() => layout.channels.clone(),
        Kind::Values(_) | Kind::Sentences => return Vec::new(),
    };
    let mut lines = Lines::new(reader, plan.line_end);
    let mut parser = RowParser::new(plan);
    let mut presence = Presence::new(channels.len());
    let mut whole_rows = 0;
    while lines.fill().unwrap_or(false) {
        while let Some(line) = lines.next_buffered() {
            if !matches!(parser.push(&line), Some(Ok(()))) {
                continue;
            }
            let numbers = &parser.cells.numbers;
            // counted up to the first row that lacks a value
            whole_rows += usize::from(presence.rows == whole_rows && numbers.iter().all(Option::is_some));
            presence.add(numbers.iter().map(Option::is_some));
            if whole_rows == HEAD_ROWS {
                return Vec::new();
            }
        }
    }
    let groups = presence.groups();
    if groups.len() < 2 {
        return Vec::new();
    }
    let mut names: Vec<_> = groups.iter().map(|group| name(group, &channels)).collect();
    names.sort_by_key(|name| rank(name));
    names
}

/// The quantities of these channels, the angular rate first; individual channels if a quantity is
/// incomplete.
fn name(group: &[usize], channels: &[Channel]) -> String {
    let mut group: Vec<_> = group.iter().map(|&slot| &*channels[slot].name).collect();
    group.sort_by_key(|name| rank(name));
    let is_whole = |word: &str| {
        let mut all = channels.iter().filter(|channel| quantity_word(&channel.name) == word);
        all.all(|channel| group.contains(&&*channel.name))
    };
    let mut words: Vec<_> =
        group.iter().map(|name| if is_whole(quantity_word(name)) { quantity_word(name) } else { name }).collect();
    words.dedup();
    words.join(" ")
}

/// The place of a stream of this name among others.
pub(super) fn rank(name: &str) -> usize {
    FIRST.iter().position(|first| name.starts_with(first)).unwrap_or(FIRST.len())
}

/// The rows in which the channels have a value, for every pair of channels.
struct Presence {
    rows: usize,
    /// The row with a value of each channel, and the last such row before it.
    present: Vec<bool>,
    last: Vec<Vec<bool>>,
    /// Rows with both channels.
    both: Vec<Vec<u64>>,
    /// Number of these rows that follow such a row, among the rows with the first channel.
    runs: Vec<Vec<u64>>,
}

impl Presence {
    fn new(channels: usize) -> Self {
        let counts = vec![vec![0; channels]; channels];
        let last = vec![vec![false; channels]; channels];
        Self { rows: 0, present: Vec::new(), last, both: counts.clone(), runs: counts }
    }

    fn add(&mut self, present: impl Iterator<Item = bool>) {
        self.rows += 1;
        self.present.clear();
        self.present.extend(present);
        for (first, _) in self.present.iter().enumerate().filter(|(_, is_present)| **is_present) {
            for (second, is_present) in self.present.iter().enumerate() {
                self.both[first][second] += u64::from(*is_present);
                self.runs[first][second] += u64::from(*is_present && self.last[first][second]);
            }
            self.last[first].copy_from_slice(&self.present);
        }
    }

    /// The channels of each rate: first those that occur together with the channel with the most
    /// values.
    fn groups(&self) -> Vec<Vec<usize>> {
        let values = |slot: usize| self.both[slot][slot];
        let mut slots: Vec<usize> = (0..self.both.len()).filter(|&slot| values(slot) >= FEWEST_VALUES).collect();
        slots.sort_by_key(|&slot| std::cmp::Reverse(values(slot)));
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for slot in slots {
            match groups.iter_mut().find(|group| self.are_of_one_rate(group[0], slot)) {
                Some(group) => group.push(slot),
                None => groups.push(vec![slot]),
            }
        }
        groups
    }

    /// Whether a channel with at most as many values as `most` has the same rate, with some values
    /// dropped.
    fn are_of_one_rate(&self, most: usize, fewer: usize) -> bool {
        let [all, values, shared] = [(most, most), (fewer, fewer), (most, fewer)].map(|(a, b)| self.both[a][b] as f64);
        if values >= SAME_RATE * (all + values - shared) {
            return true;
        }
        // if values are lost at random, a value follows another as often as a value exists; at an even rate, as
        // rarely as possible
        let share = values / all;
        let at_random = share;
        let evenly = (2.0 - share.recip()).max(0.0);
        let follow = self.runs[most][fewer] as f64 / values;
        share >= LOSSY && shared >= SHARED * values && follow >= 0.5 * (at_random + evenly)
    }
}
