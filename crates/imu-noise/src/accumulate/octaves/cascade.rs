//! Windows at a stride, in bounded memory: a cascade of block sums, one level per octave.
//!
//! Level k holds sums of m = 2^k samples that end at absolute multiples of its stride s = max(1,
//! m/R). Two sums m samples apart are `lag` = min(m, R) places apart; their difference is the Allan
//! term of the level, their sum is a block sum of the next level. If the stride doubles, every
//! second sum continues, so all levels together cost log2 R + 2 updates per sample.
//!
//! A missing sample has its place like any other, with the value 0. The number of missing samples
//! of each window follows from the places alone, so channels share this plan.

use std::{mem, sync::Arc};

use multiversion::multiversion;

use super::{
    gapped::Gapped,
    remembered::{MEMORY, Scratch, continued},
    squares::SquareSum,
    window_plan::{LevelPlan, WindowGrid, WindowPlans},
};
use crate::accumulate::{record::Deviation, stretch::Stretch};

#[derive(Clone, Debug)]
pub(super) struct Cascade {
    grid: Arc<WindowGrid>,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    /// The last block sums of the present run.
    sums: [i64; MEMORY],
    squares: SquareSum,
    gapped: Gapped,
}

impl Cascade {
    /// `windows_per_tau` is R, a power of two up to 16.
    pub(super) fn new(windows_per_tau: usize, deviation: Deviation) -> Self {
        Self { grid: Arc::new(WindowGrid::new(windows_per_tau, deviation)), levels: Vec::new() }
    }

    /// Adds the samples of a stretch.
    pub(super) fn push(&mut self, counts: &[i32], stretch: &Stretch, plans: &mut WindowPlans) {
        let planned = plans.of(&self.grid, stretch);
        let mut new: Scratch<i64> = [0; _];
        let mut place = MEMORY;
        for (missing, run) in stretch.runs_of(counts) {
            place += missing;
            for (sum, count) in new[place..].iter_mut().zip(run) {
                *sum = i64::from(*count);
            }
            place += run.len();
        }
        add(&mut self.levels, self.grid.deviation, &planned.plan, &mut new);
        self.grid = planned.after;
    }

    pub(super) fn gap(&mut self, missing: Option<u64>) {
        let grid = Arc::make_mut(&mut self.grid);
        match missing.and_then(|missing| grid.gap(missing)) {
            Some(plan) => add(&mut self.levels, grid.deviation, &plan, &mut [0; _]),
            None => grid.part(),
        }
    }

    /// The octave m = 2^k, if any sample reached it: squares of whole windows, and of the others.
    pub(super) fn octave(&self, k: usize) -> Option<(SquareSum, Gapped)> {
        self.levels.get(k).map(|level| (level.squares, level.gapped))
    }
}

/// Adds the windows of a plan, for the `new` values of its places.
#[multiversion(targets("x86_64+avx2"))]
fn add(levels: &mut Vec<Level>, deviation: Deviation, plan: &[LevelPlan], new: &mut Scratch<i64>) {
    let mut len = plan.first().map_or(0, |first| first.new);
    let mut joined: Scratch<i64> = [0; _];
    let (mut new, mut joined) = (new, &mut joined);
    for (k, step) in plan.iter().enumerate() {
        if k == levels.len() {
            levels.push(Level { sums: [0; MEMORY], squares: SquareSum::EMPTY, gapped: Gapped::EMPTY });
        }
        let level = &mut levels[k];
        if len < step.new {
            new[MEMORY + len..MEMORY + step.new].fill(0);
        }
        let sums = continued(&mut level.sums, step.remembered, new, step.new);
        let (squares, gapped) = (&mut level.squares, &mut level.gapped);
        match deviation {
            Deviation::Allan => add_windows(squares, gapped, deviation, step, clusters(sums, step.lag), difference),
            Deviation::Hadamard => {
                add_windows(squares, gapped, deviation, step, clusters(sums, step.lag), second_difference);
            }
        }
        len = step.join(sums, joined);
        mem::swap(&mut new, &mut joined);
    }
}

/// The sums of each cluster of all windows: those `lag` places after each other.
#[inline(always)]
fn clusters<const P: usize>(sums: &[i64], lag: usize) -> [&[i64]; P] {
    let windows = sums.len().saturating_sub((P - 1) * lag);
    std::array::from_fn(|cluster| sums.get(cluster * lag..).map_or(&[][..], |sums| &sums[..windows]))
}

/// Adds one window for each place of the clusters, if enough of its samples are present.
#[inline(always)]
fn add_windows<const P: usize>(
    squares: &mut SquareSum,
    gapped: &mut Gapped,
    deviation: Deviation,
    step: &LevelPlan,
    clusters: [&[i64]; P],
    z: impl Fn([i64; P]) -> i64,
) {
    let windows = clusters[0].len();
    let Some(lossy) = &step.lossy else { return squares.add(windows as u64, clusters, z) };
    if lossy.whole > 0 {
        let mut of_whole: Scratch<i64> = [0; _];
        let of_whole = &mut of_whole[..windows];
        let clusters = clusters.map(|sums| &sums[..windows]);
        for (place, (of_whole, mask)) in of_whole.iter_mut().zip(&lossy.masks).enumerate() {
            *of_whole = z(clusters.map(|sums| sums[place])) & mask;
        }
        squares.add(lossy.whole, [of_whole], |[z]| z);
    }
    if !lossy.gapped.is_empty() {
        gapped.add(&lossy.gapped, deviation.weights(), clusters);
    }
}

#[inline]
fn difference([older, newer]: [i64; 2]) -> i64 {
    newer.wrapping_sub(older)
}

#[inline]
fn second_difference([oldest, middle, newest]: [i64; 3]) -> i64 {
    difference([middle, newest]).wrapping_sub(difference([oldest, middle]))
}
