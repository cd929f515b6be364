//! Sums at averaging factors that are no octave, from the prefix sums of all runs.

use super::{
    overlapping::{BLOCK, Overlapping, add_windows},
    squares::SquareSum,
    window_plan::MAX_LEVEL,
};

impl Overlapping {
    /// Keeps the prefix sums of every run from here on.
    pub(super) fn keep_runs(&mut self) {
        self.keeps_runs = true;
    }

    /// Like [`octave`](Self::octave), for any averaging factor; `None` without a window, beyond
    /// 2^30, and if the runs are not kept.
    pub(super) fn at(&self, m: u64) -> Option<SquareSum> {
        let m = usize::try_from(m).ok().filter(|m| self.keeps_runs && (1..=1 << MAX_LEVEL).contains(m))?;
        let mut squares = SquareSum::EMPTY;
        let first_end = self.deviation.order() * m;
        for run in self.earlier.iter().chain([&self.prefix]) {
            // by blocks: the sum of a few squares may fit when that of all does not
            for begin in (first_end..run.len()).step_by(BLOCK) {
                let run = &run[..run.len().min(begin + BLOCK)];
                add_windows(self.deviation, run, begin, m, &mut squares);
            }
        }
        (squares.terms > 0).then_some(squares)
    }
}
