//! Rows of a batch, or some of them, with those of their cells that have no value.

use std::ops::Range;

use vn100_protocol::stream::AbsentCell;

/// Frame-major rows without a gap between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowSlice<'a> {
    pub(crate) counts: &'a [i32],
    /// Counts per row.
    width: usize,
    absent: &'a [AbsentCell],
    /// The row number of the first of these rows in the absent cells.
    first_row: usize,
}

impl<'a> RowSlice<'a> {
    /// All rows of a batch.
    pub(crate) const fn new(counts: &'a [i32], width: usize, absent: &'a [AbsentCell]) -> Self {
        Self { counts, width, absent, first_row: 0 }
    }

    /// The rows at these places.
    pub(crate) fn at(&self, rows: Range<usize>) -> Self {
        let cell = |row: usize| self.absent.partition_point(|cell| cell.row < self.first_row + row);
        Self {
            counts: &self.counts[rows.start * self.width..rows.end * self.width],
            absent: if self.absent.is_empty() { self.absent } else { &self.absent[cell(rows.start)..cell(rows.end)] },
            first_row: self.first_row + rows.start,
            ..*self
        }
    }

    pub(crate) const fn len(&self) -> usize {
        self.counts.len() / self.width
    }

    /// The absent cells, with rows counted from the first of these.
    pub(crate) fn absent(&self) -> Vec<AbsentCell> {
        self.absent.iter().map(|cell| AbsentCell { row: cell.row - self.first_row, ..*cell }).collect()
    }

    /// The places of the rows that lack this channel, in order.
    pub(crate) fn lacking(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.absent.iter().filter(move |cell| cell.channel == channel).map(|cell| cell.row - self.first_row)
    }

    /// The rows that lack none of these channels, in runs of neighbours.
    pub(crate) fn with(&self, channels: Range<usize>) -> impl Iterator<Item = &'a [i32]> {
        let mut lacking: Vec<_> = self
            .absent
            .iter()
            .filter(|cell| channels.contains(&cell.channel))
            .map(|cell| cell.row - self.first_row)
            .collect();
        lacking.dedup();
        let (counts, width, rows) = (self.counts, self.width, self.len());
        let mut from = 0;
        lacking.into_iter().chain([rows]).map(move |row| {
            let run = &counts[from * width..row * width];
            from = row + 1;
            run
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_cells_go_with_their_rows() {
        let counts: Vec<i32> = (0..12).collect();
        let absent = [(0, 1), (2, 0), (2, 1), (5, 0)].map(|(row, channel)| AbsentCell { row, channel });
        let rows = RowSlice::new(&counts, 2, &absent);
        let lacking = |rows: RowSlice<'_>, channel| rows.lacking(channel).collect::<Vec<_>>();
        assert_eq!((lacking(rows, 0), lacking(rows, 1), rows.len()), (vec![2, 5], vec![0, 2], 6));
        let some = rows.at(1..5).at(1..4);
        assert_eq!((some.counts, lacking(some, 0), lacking(some, 1)), (&counts[4..10], vec![0], vec![0]));
        assert_eq!(rows.with(0..2).collect::<Vec<_>>(), [&counts[..0], &counts[2..4], &counts[6..10], &counts[..0]]);
    }
}
