//! Rows of a table that stand twice, or in another order than that of their stamps.

use std::{collections::VecDeque, time::Duration};

use vn100_protocol::stream::AbsentCell;

/// The number of rows among which the order is restored.
const WINDOW: usize = 32;

/// A row that was moved leaves a hole of this many usual steps, into which it fits. The rows after
/// a clock that was set back find none.
const HOLE_STEPS: f64 = 1.5;

/// The stamps of the latest rows, which may have to wait for an earlier one.
#[derive(Debug, Default)]
pub(crate) struct RowOrder {
    latest: VecDeque<Duration>,
    /// Rows that were left out because an earlier one has the same stamp and the same values.
    pub(crate) repeated: u64,
    /// Rows that were moved to their place.
    pub(crate) moved: u64,
}

impl RowOrder {
    /// Puts the last row of `counts` at its place, or removes it. Gives the stamps of the rows whose
    /// place is final to `take`.
    pub(crate) fn place(
        &mut self,
        at: Duration,
        counts: &mut Vec<i32>,
        absent: &mut Vec<AbsentCell>,
        width: usize,
        take: impl FnMut(Duration),
    ) {
        if self.latest.back().is_some_and(|latest| *latest >= at) {
            return self.place_earlier(at, counts, absent, width, take);
        }
        self.latest.push_back(at);
        self.give_oldest(take);
    }

    /// The same for a row that is no later than one before it.
    #[cold]
    fn place_earlier(
        &mut self,
        at: Duration,
        counts: &mut Vec<i32>,
        absent: &mut Vec<AbsentCell>,
        width: usize,
        take: impl FnMut(Duration),
    ) {
        let last = counts.len() / width - 1;
        let first = last - self.latest.len();
        let row = |row: usize| &counts[row * width..(row + 1) * width];
        let lacks = |row: usize| absent.iter().filter(move |cell| cell.row == row).map(|cell| cell.channel);
        let same = self.latest.iter().enumerate().filter(|(_, stamp)| **stamp == at).map(|(place, _)| first + place);
        if same.into_iter().any(|other| row(other) == row(last) && lacks(other).eq(lacks(last))) {
            self.repeated += 1;
            counts.truncate(last * width);
            absent.retain(|cell| cell.row != last);
            return;
        }
        let place = self.latest.iter().rposition(|stamp| *stamp <= at).map_or(0, |before| before + 1);
        if place < self.latest.len() && !self.is_hole(place) {
            self.latest.drain(..).for_each(take);
            self.latest.push_back(at);
            return;
        }
        if place < self.latest.len() {
            let to = first + place;
            counts[to * width..].rotate_right(width);
            for cell in absent.iter_mut().filter(|cell| cell.row >= to) {
                cell.row = if cell.row == last { to } else { cell.row + 1 };
            }
            absent.sort_unstable_by_key(|cell| (cell.row, cell.channel));
            self.moved += 1;
        }
        self.latest.insert(place, at);
        self.give_oldest(take);
    }

    fn give_oldest(&mut self, take: impl FnMut(Duration)) {
        let oldest = if self.latest.len() > WINDOW { self.latest.pop_front() } else { None };
        oldest.into_iter().for_each(take);
    }

    /// No row follows those so far: the stamps of the rest.
    pub(crate) fn finish(&mut self) -> impl Iterator<Item = Duration> {
        self.latest.drain(..)
    }

    /// Whether a row is missing before this place among the latest ones.
    fn is_hole(&self, place: usize) -> bool {
        let steps = || {
            self.latest.iter().zip(self.latest.iter().skip(1)).map(|(earlier, later)| later.saturating_sub(*earlier))
        };
        let mut all: Vec<Duration> = steps().collect();
        let middle = all.len() / 2;
        let Some(hole) = place.checked_sub(1).and_then(|place| steps().nth(place)) else { return false };
        let (_, usual, _) = all.select_nth_unstable(middle);
        hole.as_secs_f64() >= HOLE_STEPS * usual.as_secs_f64()
    }
}
