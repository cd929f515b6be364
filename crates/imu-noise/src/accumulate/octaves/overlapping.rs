//! Every overlapping window: 8 bytes per sample of the longest gap-free run, or of all runs.

use std::mem;

use multiversion::multiversion;

use super::{squares::SquareSum, window_plan::MAX_LEVEL};
use crate::accumulate::record::Deviation;

/// Samples of a block, which every octave reads at two more places of the record: long enough for
/// sequential memory access.
pub(super) const BLOCK: usize = 1024;

#[derive(Clone, Debug)]
pub(super) struct Overlapping {
    pub(super) deviation: Deviation,
    /// Prefix sums of the present run, from 0 on. They may wrap, but their differences do not.
    pub(super) prefix: Vec<i64>,
    /// The prefix sums of the earlier runs, if they are kept.
    pub(super) earlier: Vec<Vec<i64>>,
    pub(super) keeps_runs: bool,
    squares: Vec<SquareSum>,
}

impl Overlapping {
    pub(super) fn new(deviation: Deviation) -> Self {
        let (prefix, earlier) = (Vec::new(), Vec::new());
        Self { deviation, prefix, earlier, keeps_runs: false, squares: Vec::new() }
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.push_block(block);
        }
    }

    pub(super) fn gap(&mut self) {
        let run = mem::take(&mut self.prefix);
        if self.keeps_runs && run.len() > self.deviation.order() {
            self.earlier.push(run);
        }
    }

    /// Like [`Cascade::octave`](super::cascade::Cascade::octave); no window reaches across a gap.
    pub(super) fn octave(&self, k: usize) -> Option<SquareSum> {
        self.squares.get(k).copied()
    }

    fn push_block(&mut self, block: &[i32]) {
        if self.prefix.is_empty() {
            self.prefix.push(0);
        }
        let known = self.prefix.len();
        let mut sum = self.prefix[known - 1];
        self.prefix.extend(block.iter().map(|&count| {
            sum = sum.wrapping_add(count.into());
            sum
        }));
        let order = self.deviation.order();
        for k in 0..=MAX_LEVEL {
            let first_end = known.max(order << k);
            if first_end >= self.prefix.len() {
                break;
            }
            self.add_windows(k as usize, first_end, self.prefix.len());
        }
    }

    /// Adds the windows that end at these prefix sums, up to `end`.
    fn add_windows(&mut self, k: usize, first_end: usize, end: usize) {
        if first_end >= end {
            return;
        }
        if self.squares.len() <= k {
            self.squares.resize(k + 1, SquareSum::EMPTY);
        }
        add_windows(self.deviation, &self.prefix[..end], first_end, 1 << k, &mut self.squares[k]);
    }
}

/// Adds the windows at averaging factor `m` that end at `first_end` or later in a run of `prefix`
/// sums.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn add_windows(deviation: Deviation, prefix: &[i64], first_end: usize, m: usize, squares: &mut SquareSum) {
    let len = prefix.len() - first_end;
    let points = |lag: usize| &prefix[first_end - lag * m..][..len];
    match deviation {
        Deviation::Allan => {
            squares.add(len as u64, [points(0), points(1), points(2)], |[p0, p1, p2]| second_difference(p0, p1, p2));
        }
        Deviation::Hadamard => {
            squares.add(len as u64, [points(0), points(1), points(2), points(3)], |[p0, p1, p2, p3]| {
                second_difference(p0, p1, p2).wrapping_sub(second_difference(p1, p2, p3))
            });
        }
    }
}

#[inline]
fn second_difference(p0: i64, p1: i64, p2: i64) -> i64 {
    p0.wrapping_sub(p1).wrapping_sub(p1.wrapping_sub(p2))
}
