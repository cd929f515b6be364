//! Rows that wait until it is known what is missing before them, and what their stamps and counters
//! say of it.

use std::{cmp::Ordering, time::Duration};

use vn100_protocol::stream::{Batch, MarkKind};

use super::Analysis;
use crate::{
    accumulate::{
        evidence::Verdict,
        waiting::{Ready, Waiting},
    },
    snapshot::MissingFrom,
};

/// Lines of less time do not tell their rate where they come bunched.
const LEAST_HELD: Duration = Duration::from_secs(1);

impl Analysis {
    /// The stream is over: rows whose place was in doubt take the likeliest.
    pub fn finish(&mut self) {
        if let Some(mut waiting) = self.waiting.take() {
            let few = waiting.lines_of_unsure_rate().filter(|_| self.is_rate_open());
            let (before, by_few_before) = (self.timing, self.rate_by_few);
            waiting.finish();
            self.take_ready(&mut waiting);
            self.waiting = Some(waiting);
            if let Some(lines) = few {
                self.weigh_rate(lines, before, by_few_before);
            }
        }
    }

    /// Takes the rows of a batch with stamps or counters, and those before them that wait.
    pub(super) fn take_waiting(&mut self, batch: &Batch, width: usize) {
        let mut waiting = self.waiting.take().unwrap_or_else(|| {
            let arrivals = (!batch.arrivals.is_empty()).then(|| self.timebase());
            Waiting::new(width, arrivals)
        });
        waiting.take_in(batch);
        self.take_ready(&mut waiting);
        self.waiting = Some(waiting);
    }

    /// What told most of the missing; where nothing told more, what tells now.
    pub(super) fn missing_from(&self) -> MissingFrom {
        let by_evidence = self.timing.missing - self.missing_by_bad_lines;
        match (self.timing.missing_from, by_evidence.cmp(&self.missing_by_bad_lines)) {
            (MissingFrom::Counter, _) => MissingFrom::Counter,
            (_, Ordering::Greater) => MissingFrom::Arrival,
            (_, Ordering::Less) => MissingFrom::BadLines,
            (now, Ordering::Equal) => now,
        }
    }

    /// Whether lines of which none has its place have come for as long as was asked for.
    pub(super) fn is_complete_by_lines_held(&self) -> bool {
        let held = self.waiting.as_ref().map_or(Duration::ZERO, Waiting::all_held_for);
        let is_asked_for = |duration| self.data_time().saturating_add(held) >= duration;
        held >= LEAST_HELD && self.settings.duration.is_some_and(is_asked_for)
    }
}

impl Analysis {
    fn take_ready(&mut self, waiting: &mut Waiting) {
        while let Some(ready) = waiting.next() {
            match ready {
                Ready::Rows(counts) => self.take_rows(counts),
                // the evidence knows of lines lost whole, too, and would count this one twice
                Ready::Mark(MarkKind::BadLine) if self.missing_by_evidence => {}
                Ready::Mark(mark) => self.take_mark(mark),
                Ready::Verdict(verdict) => self.take_verdict(verdict),
            }
        }
    }

    fn take_verdict(&mut self, verdict: Verdict) {
        match verdict {
            // rows, not a verdict, tell of these
            Verdict::Lines(_) => {}
            Verdict::Missing(missing) => _ = self.take_gap(missing),
            Verdict::Unknown => self.take_unknown_gap(),
            Verdict::Counting => {
                self.timing.missing_from = MissingFrom::Counter;
                self.missing_by_evidence = true;
            }
            Verdict::Rate(nominal) => {
                self.take_rate(nominal);
                if self.timing.missing_from != MissingFrom::Counter {
                    self.timing.missing_from = MissingFrom::Arrival;
                }
                self.missing_by_evidence = true;
            }
            Verdict::Refused(refusal) => {
                self.take_refusal(refusal);
                self.missing_by_evidence = self.timing.missing_from == MissingFrom::Counter;
                // what is left out says nothing of the record
                if !self.missing_by_evidence && self.rate_change.is_none() {
                    self.timing.missing_from = MissingFrom::BadLines;
                }
            }
            Verdict::RateChanged { from_hz, to_hz, until } => self.change_rate(from_hz, to_hz, Some(until)),
        }
    }
}
