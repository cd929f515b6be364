//! Rows with arrival stamps or counters wait here until it is sure whether any are missing before
//! them.

use std::{collections::VecDeque, time::Duration};

use imu_noise::{Timebase, TimebaseSummary};
use vn100_protocol::stream::{Batch, MarkKind};

use crate::accumulate::evidence::{Evidence, Verdict};

/// The first stamp: long after zero, as later ones may lie before it.
const FIRST: Duration = Duration::from_nanos(u64::MAX / 2);

/// The rows of a stream that are not placed yet, and the marks between them.
#[derive(Debug)]
pub(crate) struct Waiting {
    evidence: Evidence,
    /// Counts per row.
    width: usize,
    /// The rows that wait, frame-major, behind those already given out.
    counts: Vec<i32>,
    /// Rows at the head of `counts` that were given out.
    given: usize,
    /// Rows that may be given out.
    placed: u64,
    /// Marks by the row they stand before, counted from the beginning of the stream.
    marks: VecDeque<(u64, MarkKind)>,
    /// Rows given out since the beginning.
    given_in_all: u64,
    first_ns: Option<i64>,
    last: Duration,
    before_last: Duration,
}

/// What comes next of the stream.
#[derive(Debug)]
pub(crate) enum Ready<'a> {
    /// Rows with nothing missing before or between them, frame-major.
    Rows(&'a [i32]),
    /// What stood between the lines here.
    Mark(MarkKind),
    /// What the evidence says of this place; never [`Verdict::Lines`].
    Verdict(Verdict),
}

impl Waiting {
    /// For rows of `width` counts, whose stamps `arrivals` judges if they have any.
    pub(crate) fn new(width: usize, arrivals: Option<Timebase>) -> Self {
        Self {
            evidence: Evidence::new(arrivals),
            width,
            counts: Vec::new(),
            given: 0,
            placed: 0,
            marks: VecDeque::new(),
            given_in_all: 0,
            first_ns: None,
            last: Duration::ZERO,
            before_last: Duration::ZERO,
        }
    }

    /// Takes the rows and marks of a batch. Rows without a stamp of their own came no earlier than
    /// the row before them.
    pub(crate) fn take_in(&mut self, batch: &Batch) {
        self.counts.drain(..self.given * self.width);
        self.given = 0;
        let before = self.given_in_all + (self.counts.len() / self.width) as u64;
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
            self.evidence.push(self.last, count);
        }
    }

    /// The sensor says its rate.
    pub(crate) fn know_rate(&mut self, rate_hz: f64) {
        self.evidence.know_rate(rate_hz);
    }

    /// The stream is over: nothing that waits need wait any longer.
    pub(crate) fn finish(&mut self) {
        self.evidence.finish();
    }

    /// The next thing that may be used.
    pub(crate) fn next(&mut self) -> Option<Ready<'_>> {
        if self.placed == 0 {
            match self.evidence.next()? {
                Verdict::Lines(lines) => self.placed = lines,
                verdict => return Some(Ready::Verdict(verdict)),
            }
        }
        let to_mark = match self.marks.front() {
            Some(&(row, mark)) if row <= self.given_in_all => {
                self.marks.pop_front();
                return Some(Ready::Mark(mark));
            }
            Some((row, _)) => row - self.given_in_all,
            None => u64::MAX,
        };
        let rows = self.placed.min(to_mark);
        let from = self.given;
        self.placed -= rows;
        self.given_in_all += rows;
        // what is placed is held, so that it fits
        self.given += rows as usize;
        Some(Ready::Rows(&self.counts[from * self.width..self.given * self.width]))
    }

    /// What the stamps say; `None` without stamps.
    pub(crate) fn summary(&self) -> Option<TimebaseSummary> {
        self.evidence.summary()
    }

    /// How many lines there are of a stream whose rate is not sure yet.
    pub(crate) fn lines_of_unsure_rate(&self) -> Option<u64> {
        let summary = self.summary()?;
        (summary.nominal.is_none() && summary.refusal.is_none()).then_some(summary.lines)
    }

    /// How long the lines have come that are all held, as their rate is not sure: by their stamps,
    /// zero once one was given out. The last stamp counts for half of it at most: it alone may be
    /// wrong.
    pub(crate) fn all_held_for(&self) -> Duration {
        if self.given_in_all > 0 {
            return Duration::ZERO;
        }
        let [before_last, last] = [self.before_last, self.last].map(|at| at.saturating_sub(FIRST));
        last.min(before_last.saturating_mul(2))
    }

    /// A stamp as a time since long before the first one: stamps that go backwards are for the time
    /// base to judge.
    fn since_origin(&mut self, at_ns: i64) -> Duration {
        let first_ns = *self.first_ns.get_or_insert(at_ns);
        let since_first = i128::from(at_ns) - i128::from(first_ns);
        Duration::from_nanos((since_first + FIRST.as_nanos() as i128).clamp(0, u64::MAX.into()) as u64)
    }
}
