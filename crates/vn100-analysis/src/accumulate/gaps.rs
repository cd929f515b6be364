//! The gaps of a record, and the evidence by which missing samples were counted.

use std::cmp::Ordering;

use crate::snapshot::MissingFrom;

/// A rejected row between valid rows counts as one missing sample, unless a gap detector sees the
/// missing rows as well: that sample would be counted twice.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gaps {
    pub(super) missing: u64,
    pub(super) gaps: u64,
    /// How often the sensor restarted, by its own clock.
    pub(super) restarts: u64,
    /// How often the clock of the sensor stepped ahead of the host's clock.
    pub(super) time_steps: u64,
    /// Samples with a false time, by the clock of the sensor.
    pub(super) false_times: u64,
    /// The missing samples that were counted by rejected rows.
    by_rejected: u64,
    /// Rejected rows since the last valid row: they count once a valid row follows.
    pending_rejected: u64,
    /// The evidence by which missing samples are counted now, or were counted last.
    from: MissingFrom,
    /// Whether a gap detector counts missing samples.
    detector_decides: bool,
}

impl Gaps {
    pub(crate) fn push_rejected_row(&mut self) {
        self.pending_rejected += u64::from(!self.detector_decides);
    }

    pub(crate) fn take_rejected(&mut self) -> u64 {
        std::mem::take(&mut self.pending_rejected)
    }

    /// Forgets pending rejected rows: a gap of unknown length precedes the next row.
    pub(crate) fn forget_rejected(&mut self) {
        self.pending_rejected = 0;
    }

    pub(crate) fn count(&mut self, missing: u64, by_rejected: bool) {
        self.missing += missing;
        self.gaps += u64::from(missing > 0);
        self.by_rejected += if by_rejected { missing } else { 0 };
    }

    /// Sets the evidence, unless exact evidence has decided and this is not exact.
    pub(crate) fn use_evidence(&mut self, from: MissingFrom) {
        if from.is_exact() || !self.from.is_exact() {
            self.from = from;
        }
        self.detector_decides = true;
    }

    /// Notes that arrival times were refused; among `excluded` rows they are no evidence.
    pub(crate) fn refuse_arrivals(&mut self, excluded: bool) {
        self.detector_decides = self.from.is_exact();
        if !self.detector_decides && !excluded {
            self.from = MissingFrom::RejectedRows;
        }
    }

    pub(crate) fn end_detection(&mut self) {
        self.detector_decides = false;
    }

    pub(crate) fn discard(&mut self) {
        (self.missing, self.gaps, self.by_rejected) = (0, 0, 0);
    }

    /// The evidence that counted most of the missing samples; of equal ones the present one.
    pub(crate) fn missing_from(&self) -> MissingFrom {
        let by_detector = self.missing - self.by_rejected;
        match (self.from, by_detector.cmp(&self.by_rejected)) {
            (exact, _) if exact.is_exact() => exact,
            (_, Ordering::Greater) => MissingFrom::Arrival,
            (_, Ordering::Less) => MissingFrom::RejectedRows,
            (now, Ordering::Equal) => now,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_of_the_missing_name_the_evidence() {
        let mut gaps = Gaps::default();
        assert_eq!(gaps.missing_from(), MissingFrom::RejectedRows);
        gaps.use_evidence(MissingFrom::Arrival);
        assert_eq!(gaps.missing_from(), MissingFrom::Arrival);
        gaps.count(3, true);
        assert_eq!(gaps.missing_from(), MissingFrom::RejectedRows);
        gaps.count(0, false);
        gaps.count(3, false);
        assert_eq!((gaps.missing_from(), gaps.missing, gaps.gaps), (MissingFrom::Arrival, 6, 2));
        gaps.refuse_arrivals(false);
        assert_eq!(gaps.missing_from(), MissingFrom::RejectedRows, "as many by each");
        gaps.count(1, false);
        assert_eq!(gaps.missing_from(), MissingFrom::Arrival);
        gaps.use_evidence(MissingFrom::Counter);
        gaps.count(9, true);
        assert_eq!(gaps.missing_from(), MissingFrom::Counter);
        gaps.discard();
        assert_eq!((gaps.missing, gaps.gaps, gaps.by_rejected), (0, 0, 0));
    }

    #[test]
    fn refused_stamps_leave_counters_or_rejected_rows() {
        let mut gaps = Gaps::default();
        gaps.use_evidence(MissingFrom::Counter);
        gaps.use_evidence(MissingFrom::Arrival);
        gaps.refuse_arrivals(false);
        assert_eq!((gaps.from, gaps.detector_decides), (MissingFrom::Counter, true));
        let mut gaps = Gaps::default();
        gaps.use_evidence(MissingFrom::Arrival);
        gaps.refuse_arrivals(true);
        assert_eq!(
            (gaps.from, gaps.detector_decides),
            (MissingFrom::Arrival, false),
            "what is excluded is no evidence"
        );
        gaps.refuse_arrivals(false);
        assert_eq!(gaps.from, MissingFrom::RejectedRows);
    }
}
