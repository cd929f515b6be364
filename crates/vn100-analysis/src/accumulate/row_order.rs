//! Rows of a table that stand twice, or in another order than that of their stamps.

use std::{collections::VecDeque, time::Duration};

use vn100_protocol::stream::AbsentCell;

/// The number of rows among which the order is restored.
const WINDOW: usize = 32;

/// A row that was moved leaves a hole of this many usual steps, into which it fits. The rows after
/// a clock that was set back find none.
const HOLE_STEPS: f64 = 1.5;

/// A clock whose ticks are so long that two rows had one stamp, this many rows ago at most, may
/// give one to equal rows as well.
const COARSE_FOR: u64 = 1000;

/// The stamps of the latest rows, which may have to wait for an earlier one.
#[derive(Debug, Default)]
pub(crate) struct RowOrder {
    latest: VecDeque<Duration>,
    rows: u64,
    /// The number of rows that came after the last one of the latest, and stand right before it.
    behind: usize,
    /// The last stamp whose place is final.
    taken: Option<Duration>,
    /// The number of rows when two had one stamp and other values.
    shared_at: Option<u64>,
    /// Rows that were left out because an earlier one has the same stamp and the same values.
    pub(crate) repeated: u64,
    /// Rows that were moved to the place of their stamps, or stayed although theirs is later.
    pub(crate) moved: u64,
}

/// The rows of a table that wait, the latest one last.
pub(crate) struct WaitingRows<'a> {
    /// The values of all rows, `width` of each.
    pub(crate) counts: &'a mut Vec<i32>,
    /// The values that are missing.
    pub(crate) absent: &'a mut Vec<AbsentCell>,
    /// The number of channels.
    pub(crate) width: usize,
}

impl WaitingRows<'_> {
    /// Moves the last row before this many others.
    fn move_last(&mut self, others: usize) {
        let Self { counts, absent, width } = self;
        let last = counts.len() / *width - 1;
        let to = last - others;
        counts[to * *width..].rotate_right(*width);
        for cell in absent.iter_mut().filter(|cell| cell.row >= to) {
            cell.row = if cell.row == last { to } else { cell.row + 1 };
        }
        absent.sort_unstable_by_key(|cell| (cell.row, cell.channel));
    }
}

impl RowOrder {
    /// Puts the last one of `rows` at its place, or removes it. Gives the stamps of the rows whose
    /// place is final to `take`.
    pub(crate) fn place(&mut self, at: Duration, mut rows: WaitingRows<'_>, mut take: impl FnMut(Duration)) {
        self.rows += 1;
        if self.latest.back().is_some_and(|latest| *latest >= at) {
            self.place_earlier(at, &mut rows, &mut take);
            if self.behind >= WINDOW - 1 {
                self.distrust_last(rows);
            }
            return;
        }
        self.latest.push_back(at);
        self.behind = 0;
        self.give_oldest(take);
    }

    /// The rows after the last one are all earlier, and before it is a hole: its stamp is false.
    fn distrust_last(&mut self, mut rows: WaitingRows<'_>) {
        let last = self.latest.len() - 1;
        // of more rows behind it than are held, the first ones are given already
        let place = last.saturating_sub(self.behind);
        let before = place.checked_sub(1).map_or(self.taken, |before| Some(self.latest[before]));
        if let Some(before) = before.filter(|_| self.is_hole(last)) {
            self.latest.pop_back();
            self.latest.insert(place, before + self.latest[place].saturating_sub(before) / 2);
            rows.move_last(last - place);
            self.moved = self.moved + 1 - self.behind as u64;
            self.behind = 0;
        }
    }

    /// The same for a row that is no later than one before it.
    #[cold]
    fn place_earlier(&mut self, at: Duration, rows: &mut WaitingRows<'_>, mut take: impl FnMut(Duration)) {
        let WaitingRows { counts, absent, width } = rows;
        let last = counts.len() / *width - 1;
        let first = last - self.latest.len();
        let row = |row: usize| &counts[row * *width..(row + 1) * *width];
        let lacks = |row: usize| absent.iter().filter(move |cell| cell.row == row).map(|cell| cell.channel);
        let same = self.latest.iter().enumerate().filter(|(_, stamp)| **stamp == at).map(|(place, _)| first + place);
        let are_equal: Vec<bool> = same.map(|other| row(other) == row(last) && lacks(other).eq(lacks(last))).collect();
        if are_equal.contains(&false) {
            self.shared_at = Some(self.rows);
        }
        let is_coarse = self.shared_at.is_some_and(|at| self.rows - at < COARSE_FOR);
        if are_equal.contains(&true) && !is_coarse {
            self.repeated += 1;
            counts.truncate(last * *width);
            absent.retain(|cell| cell.row != last);
            return;
        }
        let place = self.latest.iter().rposition(|stamp| *stamp <= at).map_or(0, |before| before + 1);
        if place < self.latest.len() && !self.is_hole(place) {
            self.taken = self.latest.back().copied();
            self.latest.drain(..).for_each(&mut take);
            self.latest.push_back(at);
            self.behind = 0;
            return;
        }
        if place < self.latest.len() {
            rows.move_last(self.latest.len() - place);
            self.moved += 1;
            self.behind += usize::from(place + 1 == self.latest.len());
        }
        self.latest.insert(place, at);
        self.give_oldest(take);
    }

    fn give_oldest(&mut self, take: impl FnMut(Duration)) {
        if self.latest.len() > WINDOW {
            self.taken = self.latest.pop_front();
            self.taken.into_iter().for_each(take);
        }
    }

    /// No row follows those so far: gives the stamps of the rest to `take`.
    pub(crate) fn finish(&mut self, rows: WaitingRows<'_>, take: impl FnMut(Duration)) {
        if self.behind > 1 {
            self.distrust_last(rows);
        }
        self.latest.drain(..).for_each(take);
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The stamps in ms and the counts that come out of rows of a stamp in ms and a count.
    fn placed(rows: &[(u64, i32)]) -> (Vec<u64>, Vec<i32>, RowOrder) {
        let (mut order, mut counts, mut stamps_ms) = (RowOrder::default(), Vec::new(), Vec::new());
        let mut take = |at: Duration| stamps_ms.push(at.as_millis() as u64);
        for &(at_ms, count) in rows {
            counts.push(count);
            let rows = WaitingRows { counts: &mut counts, absent: &mut Vec::new(), width: 1 };
            order.place(Duration::from_millis(at_ms), rows, &mut take);
        }
        let rows = WaitingRows { counts: &mut counts, absent: &mut Vec::new(), width: 1 };
        order.finish(rows, take);
        (stamps_ms, counts, order)
    }

    #[test]
    fn a_row_that_is_written_twice_is_one() {
        let rows: Vec<(u64, i32)> = (0..200).map(|row| (10 * row, row as i32)).collect();
        let twice: Vec<(u64, i32)> =
            rows.iter().flat_map(|row| vec![*row; if row.1 % 7 == 0 { 2 } else { 1 }]).collect();
        let (stamps_ms, counts, order) = placed(&twice);
        assert_eq!((stamps_ms.len(), counts, order.repeated), (200, (0..200).collect(), 29));
    }

    #[test]
    fn equal_rows_of_a_coarse_clock_are_two() {
        let rows: Vec<(u64, i32)> =
            (0..200).map(|row| (row / 4 * 10, if row % 4 == 1 { 7 } else { row as i32 / 2 })).collect();
        let (stamps_ms, _, order) = placed(&rows);
        assert!(stamps_ms.len() >= 199 && order.repeated <= 1, "{} rows", stamps_ms.len());
    }

    #[test]
    fn rows_out_of_order_find_their_holes_and_a_clock_set_back_none() {
        let (stamps_ms, counts, order) = placed(&[(0, 0), (10, 1), (30, 3), (40, 4), (20, 2), (50, 5)]);
        assert_eq!((stamps_ms, counts, order.moved), (vec![0, 10, 20, 30, 40, 50], vec![0, 1, 2, 3, 4, 5], 1));
        let (stamps_ms, _, order) = placed(&[(1000, 0), (1010, 1), (1020, 2), (5, 3), (15, 4)]);
        assert_eq!((stamps_ms, order.moved), (vec![1000, 1010, 1020, 5, 15], 0));
    }
    #[test]
    fn a_row_with_a_stamp_far_ahead_stays_where_it_is() {
        for (at, rows) in [(100, 200), (150, 200), (195, 200), (31, 64), (20, 40)] {
            let stamp = |row: u64| if row == at { 1_000_000 } else { 10 * row };
            let far: Vec<(u64, i32)> = (0..rows).map(|row| (stamp(row), row as i32)).collect();
            let (stamps_ms, counts, order) = placed(&far);
            let even: Vec<u64> = (0..rows).map(|row| 10 * row).collect();
            assert_eq!((stamps_ms, counts, order.moved), (even, (0..rows as i32).collect(), 1), "{at} of {rows}");
        }
    }

    #[test]
    fn a_row_that_came_early_finds_its_place_at_the_end_too() {
        let rows: Vec<(u64, i32)> = (0..20).chain([24, 20, 21, 22, 23]).map(|row| (10 * row, row as i32)).collect();
        let (stamps_ms, counts, order) = placed(&rows);
        assert_eq!((stamps_ms, counts, order.moved), ((0..25).map(|row| 10 * row).collect(), (0..25).collect(), 4));
    }

    proptest! {
        #[test]
        fn no_row_is_lost_whatever_its_stamp(steps in proptest::collection::vec((0..40_u64, 0..2000_u64), 0..300)) {
            let mut now = 0;
            let rows: Vec<(u64, i32)> = (0..).zip(steps).map(|(row, (step, ahead))| {
                now += step;
                (now + if ahead < 30 { 40 * ahead } else { 0 }, row)
            }).collect();
            let (stamps_ms, mut counts, order) = placed(&rows);
            counts.sort_unstable();
            prop_assert_eq!(stamps_ms.len(), counts.len());
            prop_assert_eq!(counts.len() as u64 + order.repeated, rows.len() as u64);
        }
    }
}
