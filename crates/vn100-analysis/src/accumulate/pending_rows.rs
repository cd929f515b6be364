//! Rows with arrival stamps or counters, held until it is certain whether any are missing before
//! them.

use std::{collections::VecDeque, time::Duration};

use imu_noise::{GapDetector, GapEvent, TimebaseSummary};
use vn100_protocol::stream::{Batch, MarkKind};

/// The first stamp: long after zero, as later ones may lie before it.
const FIRST: Duration = Duration::from_nanos(u64::MAX / 2);

/// The rows that are not resolved yet, and the marks between them.
#[derive(Debug)]
pub(crate) struct PendingRows {
    detector: GapDetector,
    /// Counts per row.
    width: usize,
    /// Rows, frame-major; the first `resolved` of them came out.
    counts: Vec<i32>,
    resolved: usize,
    /// Rows without a gap before them that have not come out.
    certain: u64,
    /// Marks by the row they stand before, counted from the first of the stream.
    marks: VecDeque<(u64, MarkKind)>,
    /// Rows that came out since the first of the stream.
    resolved_in_all: u64,
    first_ns: Option<i64>,
    last: Duration,
    before_last: Duration,
}

/// What comes next of the stream.
#[derive(Debug, PartialEq)]
pub(crate) enum Resolved<'a> {
    /// Rows without a gap before or between them, frame-major.
    Rows(&'a [i32]),
    /// A mark between the rows.
    Mark(MarkKind),
    /// What the detector reports of this place; never [`GapEvent::Samples`].
    Event(GapEvent),
}

impl PendingRows {
    /// For rows of `width` counts, judged by this detector.
    pub(crate) fn new(width: usize, detector: GapDetector) -> Self {
        Self {
            detector,
            width,
            counts: Vec::new(),
            resolved: 0,
            certain: 0,
            marks: VecDeque::new(),
            resolved_in_all: 0,
            first_ns: None,
            last: Duration::ZERO,
            before_last: Duration::ZERO,
        }
    }

    /// Adds the rows and marks of a batch. Rows without a stamp of their own came with the row
    /// before them.
    pub(crate) fn push(&mut self, batch: &Batch) {
        self.counts.drain(..self.resolved * self.width);
        self.resolved = 0;
        let before = self.resolved_in_all + (self.counts.len() / self.width) as u64;
        self.marks.extend(batch.marks.iter().map(|mark| (before + mark.before_row as u64, mark.kind)));
        self.counts.extend_from_slice(&batch.counts);
        let mut arrivals = batch.arrivals.iter().peekable();
        let mut counters = batch.counters.iter().peekable();
        for row in 0..batch.rows().len() {
            if let Some(arrival) = arrivals.next_if(|arrival| arrival.from_row == row) {
                let at = self.since_origin(arrival.at_ns);
                self.before_last = std::mem::replace(&mut self.last, at);
            }
            let count = counters.next_if(|counter| counter.row == row).map(|counter| counter.count);
            self.detector.push(self.last, count);
        }
    }

    /// The sensor reported its rate.
    pub(crate) fn set_known_rate(&mut self, rate_hz: f64) {
        self.detector.set_known_rate(rate_hz);
    }

    /// No row follows: decides on those still held.
    pub(crate) fn finish(&mut self) {
        self.detector.finish();
    }

    /// The next rows, marks or events that are certain.
    pub(crate) fn next(&mut self) -> Option<Resolved<'_>> {
        if self.certain == 0 {
            match self.detector.poll()? {
                GapEvent::Samples(rows) => self.certain = rows,
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
        let rows = self.certain.min(to_mark);
        let from = self.resolved;
        self.certain -= rows;
        self.resolved_in_all += rows;
        // rows that are certain are held, so that the number fits
        self.resolved += rows as usize;
        Some(Resolved::Rows(&self.counts[from * self.width..self.resolved * self.width]))
    }

    /// What the arrival times show; `None` without stamps.
    pub(crate) fn summary(&self) -> Option<TimebaseSummary> {
        self.detector.summary()
    }

    /// How many rows came, if their rate is not known yet.
    pub(crate) fn rows_without_rate(&self) -> Option<u64> {
        let summary = self.summary()?;
        (summary.nominal.is_none() && summary.refusal.is_none()).then_some(summary.samples)
    }

    /// By their stamps, how long rows have come if all of them are pending; zero once one came out.
    /// The last stamp counts for half of it at most: it alone may be wrong.
    pub(crate) fn pending_duration(&self) -> Duration {
        if self.resolved_in_all > 0 {
            return Duration::ZERO;
        }
        let [before_last, last] = [self.before_last, self.last].map(|at| at.saturating_sub(FIRST));
        last.min(before_last.saturating_mul(2))
    }

    /// A stamp as a time since long before the first one: whether stamps may go back is for the
    /// detector to judge.
    fn since_origin(&mut self, at_ns: i64) -> Duration {
        let first_ns = *self.first_ns.get_or_insert(at_ns);
        let since_first = i128::from(at_ns) - i128::from(first_ns);
        Duration::from_nanos((since_first + FIRST.as_nanos() as i128).clamp(0, u64::MAX.into()) as u64)
    }
}
