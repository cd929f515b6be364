//! Rows with stamps or counters, held until it is decided whether samples are missing before them.

use std::{collections::VecDeque, iter::Peekable, time::Duration};

use imu_noise::timebase::{ClockAfterOutage, GapDetector, GapEvent, StallDetector};
use vn100_protocol::stream::{AbsentCell, Batch, Mark, MarkKind};

use super::{
    row_order::{RowOrder, WaitingRows},
    row_slice::RowSlice,
};

/// The first stamp is placed this long after zero, because later stamps may lie before it.
const FIRST: Duration = Duration::from_nanos(u64::MAX / 2);

#[derive(Debug, Default)]
pub(crate) struct PendingRows {
    pub(super) detector: GapDetector,
    pub(super) order: Option<RowOrder>,
    width: usize,
    /// Rows, frame-major; the first `resolved` of them have been taken.
    counts: Vec<i32>,
    /// Cells of these rows without a value.
    absent: Vec<AbsentCell>,
    resolved: usize,
    /// Number of rows that are decided, without a gap before them, and not taken yet.
    certain: u64,
    /// Marks by the row that they precede, counted from the first row of the stream.
    marks: VecDeque<(u64, MarkKind)>,
    /// Number of rows that were taken since the first row of the stream.
    resolved_in_all: u64,
    first_ns: Option<i64>,
    last: Duration,
    before_last: Duration,
    stalls: StallDetector,
}

#[derive(Debug, PartialEq)]
pub(crate) enum Resolved<'a> {
    /// Rows without a gap before or between them, frame-major.
    Rows(RowSlice<'a>),
    /// A mark between the rows.
    Mark(MarkKind),
    /// An event of the gap detector at this place; never [`GapEvent::Samples`].
    Event(GapEvent),
}

impl PendingRows {
    /// Rows of `width` channels. Those of a table may be repeated, and out of `order`.
    pub(crate) fn new(width: usize, detector: GapDetector, order: Option<RowOrder>) -> Self {
        Self { detector, order, width, ..Self::default() }
    }

    /// Adds a batch. A row without a stamp arrived together with the row before it.
    pub(crate) fn push(&mut self, batch: &Batch) {
        self.counts.drain(..self.resolved * self.width);
        let resolved = std::mem::take(&mut self.resolved);
        self.absent.retain_mut(|cell| {
            let held = cell.row >= resolved;
            cell.row = cell.row.saturating_sub(resolved);
            held
        });
        let mut arrivals = batch.arrivals.iter().peekable();
        let mut counters = batch.counters.iter().peekable();
        let mut marks = batch.marks.iter().peekable();
        let mut absent = batch.absent.iter().peekable();
        let is_stamped = self.first_ns.is_some() || !batch.arrivals.is_empty();
        for (row, counts) in batch.rows().enumerate() {
            self.push_marks(&mut marks, row);
            let held = self.held();
            self.counts.extend_from_slice(counts);
            while let Some(cell) = absent.next_if(|cell| cell.row == row) {
                self.absent.push(AbsentCell { row: held, ..*cell });
            }
            if let Some(arrival) = arrivals.next_if(|arrival| arrival.from_row == row) {
                let at = self.since_origin(arrival.at_ns);
                self.stalls.push(at);
                self.before_last = std::mem::replace(&mut self.last, at);
            }
            let count = counters.next_if(|counter| counter.row == row).map(|counter| counter.count);
            match (batch.device_ns.get(row), &mut self.order) {
                (Some(device_ns), _) => {
                    self.detector.push_device_time(*device_ns, is_stamped.then_some(self.last));
                }
                (None, Some(order)) if count.is_none() => {
                    let take = |at| self.detector.push(at, None);
                    let rows = WaitingRows { counts: &mut self.counts, absent: &mut self.absent, width: self.width };
                    order.place(self.last, rows, take);
                }
                (None, _) => self.detector.push(self.last, count),
            }
        }
        self.push_marks(&mut marks, usize::MAX);
    }

    fn push_marks<'a>(&mut self, marks: &mut Peekable<impl Iterator<Item = &'a Mark>>, to_row: usize) {
        let row = self.resolved_in_all + self.pending();
        while let Some(mark) = marks.next_if(|mark| mark.before_row <= to_row) {
            self.marks.push_back((row, mark.kind));
        }
    }

    /// Number of rows in memory.
    fn held(&self) -> usize {
        self.counts.len() / self.width
    }

    /// Number of rows that have not been taken.
    pub(crate) fn pending(&self) -> u64 {
        (self.held() - self.resolved) as u64
    }

    /// No row follows: all are decided.
    pub(crate) fn finish(&mut self) {
        if let Some(order) = &mut self.order {
            let rows = WaitingRows { counts: &mut self.counts, absent: &mut self.absent, width: self.width };
            order.finish(rows, |at| self.detector.push(at, None));
        }
        self.detector.finish();
    }

    /// The next rows, mark or event; of rows at most this many.
    pub(crate) fn next(&mut self, most: u64) -> Option<Resolved<'_>> {
        if self.certain == 0 {
            match self.detector.poll()? {
                GapEvent::Samples(rows) => self.certain = rows,
                GapEvent::FalseTime => {
                    // marks before a row are taken before the row
                    self.resolved_in_all += 1;
                    self.resolved += 1;
                    return Some(Resolved::Event(GapEvent::FalseTime));
                }
                event => return Some(Resolved::Event(event)),
            }
        }
        let to_mark = match self.marks.front() {
            Some(&(row, mark)) if row <= self.resolved_in_all => {
                self.marks.pop_front();
                return Some(Resolved::Mark(mark));
            }
            Some((row, _)) => row - self.resolved_in_all,
            None => u64::MAX,
        };
        let rows = self.certain.min(to_mark).min(most);
        let from = self.resolved;
        self.certain -= rows;
        self.resolved_in_all += rows;
        // decided rows are held in memory, so that their number fits
        self.resolved += rows as usize;
        Some(Resolved::Rows(RowSlice::new(&self.counts, self.width, &self.absent).at(from..self.resolved)))
    }

    /// Takes the marks that no row follows.
    pub(crate) fn take_marks(&mut self) -> Vec<MarkKind> {
        self.marks.drain(..).map(|(_, mark)| mark).collect()
    }

    /// What the first row after an outage shows of the clock of the sensor.
    pub(crate) fn after_outage(&mut self, device_ns: Option<u64>, at_ns: i64) -> ClockAfterOutage {
        let at = self.since_origin(at_ns);
        self.detector.after_outage(device_ns, at)
    }

    /// The time that the stamps of the pending rows span, if no row has been taken; else zero. The
    /// last stamp adds at most half of it, because a single stamp may be wrong.
    pub(crate) fn pending_duration(&self) -> Duration {
        if self.resolved_in_all > 0 {
            return Duration::ZERO;
        }
        let [before_last, last] = [self.before_last, self.last].map(|at| at.saturating_sub(FIRST));
        last.min(before_last.saturating_mul(2))
    }

    /// The same, but without a stall that has ended just now, whose rows may still arrive.
    pub(crate) fn certain_duration(&self) -> Duration {
        let before = self.stalls.recent().map_or(Duration::MAX, |from| from.saturating_sub(FIRST));
        self.pending_duration().min(before)
    }

    /// The time since an origin long before the first stamp; it may go back.
    fn since_origin(&mut self, at_ns: i64) -> Duration {
        let first_ns = *self.first_ns.get_or_insert(at_ns);
        let since_first = i128::from(at_ns) - i128::from(first_ns);
        Duration::from_nanos((since_first + FIRST.as_nanos() as i128).clamp(0, u64::MAX.into()) as u64)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{
        VNYMR,
        stream::{Arrival, Mark},
    };

    use super::*;

    const WIDTH: usize = 12;

    /// Rows with these stamps in ms, the number of each row in all of its counts.
    fn batch(first: i32, at_ms: &[i64]) -> Batch {
        Batch {
            layout: Some(Arc::new(VNYMR.clone())),
            counts: (first..).take(at_ms.len()).flat_map(|row| [row; WIDTH]).collect(),
            arrivals: (at_ms.iter().enumerate())
                .map(|(from_row, at_ms)| Arrival { from_row, at_ns: at_ms * 1_000_000 })
                .collect(),
            ..Batch::default()
        }
    }

    fn pending(known_hz: Option<f64>) -> PendingRows {
        PendingRows::new(WIDTH, GapDetector::new(&[40.0], known_hz), None)
    }

    fn held(pending: &PendingRows) -> Option<u64> {
        pending.detector.summary()?.samples_pending()
    }

    /// What comes out: rows as numbers, marks as -1, gaps as -10 less their samples; other events
    /// are not shown.
    fn resolved(pending: &mut PendingRows) -> Vec<i32> {
        let mut all = Vec::new();
        while let Some(resolved) = pending.next(u64::MAX) {
            match resolved {
                Resolved::Rows(rows) => all.extend(rows.counts.iter().step_by(WIDTH)),
                Resolved::Mark(_) => all.push(-1),
                Resolved::Event(GapEvent::Missing(missing)) => all.push(-10 - missing as i32),
                Resolved::Event(_) => {}
            }
        }
        all
    }

    #[test]
    fn rows_are_held_until_their_rate_is_known() {
        let mut pending = pending(None);
        pending.push(&batch(0, &(0..40).map(|row| 25 * row).collect::<Vec<_>>()));
        assert_eq!((resolved(&mut pending), held(&pending)), (vec![], Some(40)));
        pending.push(&batch(40, &[1000, 1025, 1050, 1150, 1175]));
        assert_eq!(resolved(&mut pending), (0..43).collect::<Vec<_>>(), "those behind the gap are in doubt");
        assert_eq!(held(&pending), None);
        pending.finish();
        assert_eq!(resolved(&mut pending), [-13, 43, 44]);
    }

    #[test]
    fn marks_come_before_their_row() {
        let mut pending = PendingRows::new(WIDTH, GapDetector::without_stamps(), None);
        let mark = |before_row| Mark { before_row, kind: MarkKind::Rejected };
        for first in [0, 3] {
            let mut batch = batch(first, &[0; 3]);
            batch.marks = vec![mark(0), mark(1), mark(1), mark(3)];
            pending.push(&batch);
            // the last one waits for a following row
            let before = if first == 0 { vec![-1] } else { vec![-1, -1] };
            let expected = [before, vec![first, -1, -1, first + 1, first + 2]].concat();
            assert_eq!(resolved(&mut pending), expected);
        }
    }

    #[test]
    fn pending_rows_have_the_time_of_their_stamps() {
        let mut pending = pending(None);
        assert_eq!(pending.pending_duration(), Duration::ZERO);
        pending.push(&batch(0, &[1000, 1400]));
        assert_eq!(pending.pending_duration(), Duration::ZERO, "one interval may be wrong");
        pending.push(&batch(2, &[1800]));
        assert_eq!(pending.pending_duration(), Duration::from_millis(800));
        pending.push(&batch(3, &[9000]));
        assert_eq!(pending.pending_duration(), Duration::from_millis(1600));
        assert_eq!(pending.certain_duration(), Duration::from_millis(800), "a stall, whose rows may come yet");
        pending.push(&batch(4, &[9500]));
        assert_eq!([pending.pending_duration(), pending.certain_duration()], [Duration::from_millis(8500); 2]);
        pending.finish();
        assert!(!resolved(&mut pending).is_empty());
        assert_eq!(pending.pending_duration(), Duration::ZERO);
    }

    #[test]
    fn stamps_far_before_the_first_are_times() {
        let mut pending = pending(None);
        pending.push(&batch(0, &[0, -5_000, i64::MIN / 1_000_000, i64::MAX / 1_000_000]));
        pending.finish();
        assert_eq!(resolved(&mut pending).iter().filter(|row| **row >= 0).count(), 4);
    }
}
