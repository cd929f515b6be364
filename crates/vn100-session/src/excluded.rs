//! The data time excluded from a measurement by command. Pure.

use std::time::Duration;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Excluded {
    /// Data time up to the last restart of the measurement.
    before: Duration,
    /// Data time after that, excluded as warm-up.
    warm_up: Duration,
}

impl Excluded {
    pub(crate) fn end_warm_up(&mut self, so_far: Duration) {
        self.warm_up = so_far;
    }

    /// Excludes everything so far.
    pub(crate) fn start_over(&mut self, so_far: Duration) {
        self.before = self.before.saturating_add(so_far);
        self.warm_up = Duration::ZERO;
    }

    /// Excluded data time from the beginning of the record: a measurement with this skip gives the
    /// same result.
    pub(crate) fn total(self) -> Duration {
        self.before.saturating_add(self.warm_up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn the_total_counts_from_the_beginning_of_the_record() {
        let mut excluded = Excluded::default();
        assert_eq!(excluded.total(), Duration::ZERO);
        excluded.end_warm_up(10 * S);
        assert_eq!(excluded.total(), 10 * S);
        excluded.end_warm_up(15 * S);
        assert_eq!(excluded.total(), 15 * S, "a later end replaces the earlier one");
        excluded.start_over(20 * S);
        assert_eq!(excluded.total(), 20 * S);
        excluded.end_warm_up(3 * S);
        excluded.start_over(5 * S);
        assert_eq!(excluded.total(), 25 * S);
    }
}
