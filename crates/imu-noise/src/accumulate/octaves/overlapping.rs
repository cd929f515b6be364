//! Every overlapping window: 8 bytes per sample of the record.

use multiversion::multiversion;

use super::{squares::SquareSum, window_plan::MAX_LEVEL};
use crate::accumulate::record::Deviation;

/// Samples of a block, long enough for sequential memory access by every octave.
const BLOCK: usize = 1024;

#[derive(Clone, Debug)]
pub(super) struct Overlapping {
    deviation: Deviation,
    /// Prefix sums of each run, the present one last. They may wrap: their differences do not.
    runs: Vec<Vec<i64>>,
    squares: Vec<SquareSum>,
}

impl Overlapping {
    pub(super) fn new(deviation: Deviation) -> Self {
        Self { deviation, runs: vec![vec![0]], squares: Vec::new() }
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        let Some(run) = self.runs.last_mut() else { return };
        for block in counts.chunks(BLOCK) {
            let known = run.len();
            let mut sum = run[known - 1];
            run.extend(block.iter().map(|&count| {
                sum = sum.wrapping_add(count.into());
                sum
            }));
            for k in 0..=MAX_LEVEL {
                let first_end = known.max(self.deviation.order() << k);
                if first_end >= run.len() {
                    break;
                }
                if self.squares.len() <= k as usize {
                    self.squares.push(SquareSum::EMPTY);
                }
                add_windows(self.deviation, run, first_end, 1 << k, &mut self.squares[k as usize]);
            }
        }
    }

    /// No window reaches across this place.
    pub(super) fn gap(&mut self) {
        match self.runs.last_mut() {
            // too short for a window
            Some(run) if run.len() <= self.deviation.order() => run.truncate(1),
            _ => self.runs.push(vec![0]),
        }
    }

    /// Like [`Cascade::octave`](super::cascade::Cascade::octave).
    pub(super) fn octave(&self, k: usize) -> Option<SquareSum> {
        self.squares.get(k).copied()
    }

    /// The same for any averaging factor; `None` without a window, and beyond 2^30.
    pub(super) fn at(&self, m: u64) -> Option<SquareSum> {
        let m = usize::try_from(m).ok().filter(|m| (1..=1 << MAX_LEVEL).contains(m))?;
        let mut squares = SquareSum::EMPTY;
        let first_end = self.deviation.order() * m;
        for run in &self.runs {
            // by blocks: the sum of a few squares may fit when that of all does not
            for begin in (first_end..run.len()).step_by(BLOCK) {
                let run = &run[..run.len().min(begin + BLOCK)];
                add_windows(self.deviation, run, begin, m, &mut squares);
            }
        }
        (squares.terms > 0).then_some(squares)
    }
}

/// Adds the windows at averaging factor `m` that end at `first_end` or later in a run.
#[multiversion(targets("x86_64+avx2"))]
fn add_windows(deviation: Deviation, prefix: &[i64], first_end: usize, m: usize, squares: &mut SquareSum) {
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
