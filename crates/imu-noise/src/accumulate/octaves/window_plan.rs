//! The windows that end in a stretch of a record, and their missing samples: the same for all
//! channels whose samples have the same places.

use std::{
    mem,
    ops::{Add, Range},
    sync::Arc,
};

use super::{
    gapped::GappedWindows,
    remembered::{MAX_LAG, Scratch, from_end, pairs},
};
use crate::accumulate::{places::room_for, record::Deviation, stretch::Stretch};

/// Longest averaging factor, 2^30.
pub(super) const MAX_LEVEL: u32 = 30;

/// This many new sums of a long gap represent all: up to one lag of them reaches back before the
/// gap, as many fill the memory of a level, and the rest are equal.
const OF_A_GAP: u64 = 4 * MAX_LAG as u64;

/// The place of a record that a cascade has reached, and the missing samples of the block sums that
/// each level remembers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WindowGrid {
    pub(super) deviation: Deviation,
    windows_per_tau: usize,
    /// Absolute index of the next place.
    end: u64,
    levels: Vec<GridLevel>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct GridLevel {
    sums: Lacks,
    /// The missing samples of the sums one cluster before these, only for third differences.
    earlier: Lacks,
}

/// The number of missing samples of each of the last block sums of the present run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Lacks {
    /// The last `len` of these numbers at the end, after zeros.
    missing: [u32; MAX_LAG],
    len: usize,
}

/// The windows that end in a stretch, for each level that the stretch reaches.
#[derive(Debug, Default)]
pub(super) struct WindowPlan {
    pub(super) levels: Vec<LevelPlan>,
    /// For each window of the levels that lack samples: all bits are set if the window lacks none.
    masks: Vec<i64>,
    pub(super) gapped: GappedWindows,
}

/// The new sums and windows of a stretch at one level.
#[derive(Debug)]
pub(super) struct LevelPlan {
    /// The number of new block sums; sums beyond those from the level below lack all samples.
    pub(super) new: usize,
    /// Distance of two sums that are joined.
    pub(super) lag: usize,
    /// The number of earlier sums that are remembered, and of those one cluster before.
    pub(super) remembered: usize,
    pub(super) earlier: usize,
    /// The first of the joined sums that continues to the next level, and the step: all of them
    /// after it, or every second.
    first: usize,
    every: usize,
    /// `None` if no window lacks a sample.
    pub(super) lossy: Option<LossyWindows>,
}

/// The windows of a level that lacks samples.
#[derive(Debug)]
pub(super) struct LossyWindows {
    first_mask: usize,
    /// The number of windows that lack no sample.
    pub(super) whole: u64,
    /// The windows that lack some samples and are used, and the sum of their c.
    pub(super) gapped: Range<usize>,
    pub(super) shares: u128,
}

/// The windows that end in one stretch, computed for the first channel and shared by all channels
/// whose samples have had the same places since the start of the record.
#[derive(Debug, Default)]
pub struct WindowPlans {
    planned: Vec<Planned>,
}

#[derive(Clone, Debug)]
pub(super) struct Planned {
    stretch: Stretch,
    before: Arc<WindowGrid>,
    pub(super) plan: Arc<WindowPlan>,
    pub(super) after: Arc<WindowGrid>,
}

/// The number of missing samples of each new block sum of a level.
struct NewLacks {
    /// Not valid if no sum lacks a sample.
    missing: Scratch<u32>,
    len: usize,
    is_whole: bool,
}

impl WindowPlans {
    /// No plans.
    #[must_use]
    pub const fn new() -> Self {
        Self { planned: Vec::new() }
    }

    pub(super) fn of(&mut self, grid: &Arc<WindowGrid>, stretch: &Stretch) -> Planned {
        let is_same = |planned: &&Planned| {
            planned.stretch == *stretch && (Arc::ptr_eq(&planned.before, grid) || planned.before == *grid)
        };
        if let Some(planned) = self.planned.iter().find(is_same) {
            return planned.clone();
        }
        let mut after = WindowGrid::clone(grid);
        let plan = after.advance(stretch);
        let (before, plan, after) = (Arc::clone(grid), Arc::new(plan), Arc::new(after));
        let planned = Planned { stretch: *stretch, before, plan, after };
        self.planned.push(planned.clone());
        planned
    }
}

impl WindowGrid {
    /// `windows_per_tau` is R, a power of two up to 16.
    pub(super) fn new(windows_per_tau: usize, deviation: Deviation) -> Self {
        debug_assert!(windows_per_tau.is_power_of_two() && windows_per_tau <= MAX_LAG);
        Self { deviation, windows_per_tau, end: 0, levels: Vec::new() }
    }

    fn advance(&mut self, stretch: &Stretch) -> WindowPlan {
        let mut new = NewLacks::new();
        new.len = stretch.places();
        new.is_whole = stretch.samples() == new.len;
        for (missing, has_sample) in new.missing[MAX_LAG..].iter_mut().zip(stretch.has_sample()) {
            *missing = u32::from(!has_sample);
        }
        self.continue_by(stretch.places() as u64, new)
    }

    /// The plan of a gap; `None` for one without places, which no window spans.
    pub(super) fn gap(&mut self, missing: u64) -> Option<WindowPlan> {
        let missing = room_for(self.end, missing);
        (missing > 0).then(|| self.continue_by(missing, NewLacks::new()))
    }

    /// No window spans this place.
    pub(super) fn part(&mut self) {
        self.levels.fill(GridLevel::default());
    }

    /// Continues by this many places, the first ones as in `new`, the others without samples.
    fn continue_by(&mut self, mut places: u64, mut new: NewLacks) -> WindowPlan {
        self.end += places;
        let mut plan = WindowPlan::default();
        let mut joined = NewLacks::new();
        for k in 0..=MAX_LEVEL {
            if places == 0 {
                break;
            }
            if (new.len as u64) < places {
                new.fill_up(places.min(OF_A_GAP) as usize, 1 << k);
            }
            if k as usize == self.levels.len() {
                self.levels.push(GridLevel::default());
            }
            let step = self.level_plan(k, places, new.len);
            let pairs = (step.remembered as u64 + places).saturating_sub(step.lag as u64);
            // the last of all new sums ends at this multiple of the stride
            let last = self.end / self.stride(k);
            places = if step.every == 1 { pairs } else { (pairs + 1 - first_even(last, pairs)) / 2 };
            let lossy =
                self.levels[k as usize].advance(self.deviation, 1 << k, &step, [&mut new, &mut joined], &mut plan);
            plan.levels.push(LevelPlan { lossy, ..step });
            mem::swap(&mut new, &mut joined);
        }
        plan
    }

    /// The step of level `k` over this many places; `new` of them have a sum of their own.
    fn level_plan(&self, k: u32, places: u64, new: usize) -> LevelPlan {
        let level = &self.levels[k as usize];
        let (remembered, earlier) = (level.sums.len, level.earlier.len);
        let lag = (1 << k).min(self.windows_per_tau);
        let pairs = (remembered + new).saturating_sub(lag) as u64;
        let last = self.end / self.stride(k) - (places - new as u64);
        // if the stride doubles, even multiples of the stride are on the next grid
        let (first, every) = if lag < self.windows_per_tau { (0, 1) } else { (first_even(last, pairs) as usize, 2) };
        LevelPlan { new, lag, remembered, earlier, first, every, lossy: None }
    }

    fn stride(&self, k: u32) -> u64 {
        ((1_usize << k) / self.windows_per_tau).max(1) as u64
    }
}

/// The place of the first even number among this many sums in a row, which end with the number `last`.
const fn first_even(last: u64, sums: u64) -> u64 {
    (last + sums + 1) & 1
}

impl GridLevel {
    /// The windows that end with the new sums of a level with clusters of `m`, if samples are
    /// missing; `joined` are then the new sums of the next level.
    fn advance(
        &mut self,
        deviation: Deviation,
        m: u32,
        step: &LevelPlan,
        [new, joined]: [&mut NewLacks; 2],
        plan: &mut WindowPlan,
    ) -> Option<LossyWindows> {
        joined.is_whole = new.is_whole && self.sums.are_zero() && self.earlier.are_zero();
        if joined.is_whole {
            let pairs = self.sums.skip(new.len, step.lag);
            self.earlier.skip(if deviation == Deviation::Hadamard { pairs } else { 0 }, step.lag);
            joined.len = step.joined(pairs);
            return None;
        }
        let len = new.len;
        let (older, newer) = self.sums.pairs(new.missing(), len, step.lag);
        let lossy = match deviation {
            Deviation::Allan => plan.add_windows(m, deviation.weights(), [older, newer]),
            Deviation::Hadamard => {
                let mut missing: Scratch<u32> = [0; _];
                missing[MAX_LAG..][..older.len()].copy_from_slice(older);
                let (oldest, middle) = self.earlier.pairs(&mut missing, older.len(), step.lag);
                plan.add_windows(m, deviation.weights(), [oldest, middle, from_end(newer, middle.len())])
            }
        };
        joined.len = step.join(older, newer, &mut joined.missing);
        joined.is_whole = joined.missing[MAX_LAG..][..joined.len].iter().all(|missing| *missing == 0);
        Some(lossy)
    }
}

impl Lacks {
    fn are_zero(&self) -> bool {
        self.missing == [0; MAX_LAG]
    }

    /// Like [`pairs`], if all values are 0; returns the number of pairs.
    fn skip(&mut self, new: usize, lag: usize) -> usize {
        let values = self.len + new;
        self.len = values.min(lag);
        values - self.len
    }

    fn pairs<'a>(&mut self, scratch: &'a mut Scratch<u32>, new: usize, lag: usize) -> (&'a [u32], &'a [u32]) {
        let remembered = self.len;
        self.skip(new, lag);
        pairs(&mut self.missing, remembered, scratch, new, lag)
    }
}

impl NewLacks {
    const fn new() -> Self {
        Self { missing: [0; MAX_LAG + Stretch::MOST], len: 0, is_whole: true }
    }

    fn missing(&mut self) -> &mut Scratch<u32> {
        if mem::take(&mut self.is_whole) {
            self.missing.fill(0);
        }
        &mut self.missing
    }

    /// Extends the sums to this length with sums that lack all of `m` samples.
    #[cold]
    fn fill_up(&mut self, len: usize, m: u32) {
        let known = self.len;
        if known < len {
            self.missing()[MAX_LAG + known..MAX_LAG + len].fill(m);
            self.len = len;
        }
    }
}

impl WindowPlan {
    #[inline]
    pub(super) fn masks(&self, lossy: &LossyWindows) -> &[i64] {
        &self.masks[lossy.first_mask..]
    }

    /// Adds one window for each place of the slices, from the number of `m` samples that each of
    /// its clusters lacks: it is used if half of each cluster is present.
    fn add_windows<const P: usize>(&mut self, m: u32, weights: [i64; 3], missing: [&[u32]; P]) -> LossyWindows {
        let first = self.gapped.len();
        let mut lossy = LossyWindows { first_mask: self.masks.len(), whole: 0, gapped: first..first, shares: 0 };
        for place in 0..missing[0].len() {
            let missing = missing.map(|missing| missing[place]);
            let is_whole = missing == [0; P];
            lossy.whole += u64::from(is_whole);
            self.masks.push(-i64::from(is_whole));
            if !is_whole && missing.iter().all(|missing| 2 * u64::from(*missing) <= m.into()) {
                let mut present = [1; 3];
                present.iter_mut().zip(missing).for_each(|(present, missing)| *present = m - missing);
                lossy.shares += self.gapped.push(m, weights, place, present);
            }
        }
        lossy.gapped.end = self.gapped.len();
        lossy
    }
}

impl LevelPlan {
    /// Block sums of the next level, written to the places of new values; returns their number.
    #[inline(always)]
    pub(super) fn join<T: Copy + Add<Output = T>>(&self, older: &[T], newer: &[T], next: &mut Scratch<T>) -> usize {
        let len = self.joined(older.len());
        let next = &mut next[MAX_LAG..][..len];
        if self.every == 1 {
            for (sum, (older, newer)) in next.iter_mut().zip(older.iter().zip(newer)) {
                *sum = *older + *newer;
            }
        } else {
            for (i, sum) in next.iter_mut().enumerate() {
                *sum = older[self.first + 2 * i] + newer[self.first + 2 * i];
            }
        }
        len
    }

    /// The number of these joined sums that continue.
    const fn joined(&self, pairs: usize) -> usize {
        if self.every == 1 { pairs } else { (pairs + 1).saturating_sub(self.first) / 2 }
    }
}
