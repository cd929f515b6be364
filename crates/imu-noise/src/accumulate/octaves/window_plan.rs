//! The windows that end in a stretch of a record, and their missing samples: the same for all
//! channels whose samples have the same places.

use std::{mem, ops::Add, sync::Arc};

use super::{
    gapped::GappedWindow,
    remembered::{MAX_LAG, MEMORY, Scratch, continued},
};
use crate::accumulate::{places::room_for, record::Deviation, stretch::Stretch};

/// Longest averaging factor, 2^30.
pub(super) const MAX_LEVEL: u32 = 30;

/// This many new sums of a long gap represent all: up to two lags of them reach back before the
/// gap, as many fill the memory of a level, and the rest are equal.
const OF_A_GAP: u64 = 2 * MEMORY as u64;

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

/// The number of missing samples of each of the last block sums of the present run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct GridLevel {
    /// The last `len` of these numbers.
    missing: [u32; MEMORY],
    len: usize,
}

/// The new sums and windows of a stretch at one level.
#[derive(Debug)]
pub(super) struct LevelPlan {
    /// The number of new block sums; sums beyond those from the level below lack all samples.
    pub(super) new: usize,
    /// The number of earlier sums that are remembered.
    pub(super) remembered: usize,
    /// Distance of two sums that are joined, and of the clusters of a window.
    pub(super) lag: usize,
    /// The place of the first sum that is joined with a new one and continues to the next level, and the
    /// step to the next: all of them after it, or every second.
    first: usize,
    every: usize,
    /// `None` if no window lacks a sample.
    pub(super) lossy: Option<LossyWindows>,
}

/// The windows of a level that lacks samples.
#[derive(Debug, Default)]
pub(super) struct LossyWindows {
    /// For each window: all bits are set if it lacks no sample.
    pub(super) masks: Vec<i64>,
    /// The number of windows that lack no sample.
    pub(super) whole: u64,
    /// The windows that lack some samples and are used.
    pub(super) gapped: Vec<GappedWindow>,
}

/// The windows that end in one stretch, computed for the first channel and shared by all channels
/// whose samples have had the same places since the start of the record.
#[derive(Debug, Default)]
pub struct WindowPlans {
    planned: Vec<Planned>,
}

/// The windows of a stretch that continues a grid, by level, and the grid after it.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    stretch: Stretch,
    before: Arc<WindowGrid>,
    pub(super) plan: Arc<[LevelPlan]>,
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
        let plan = after.advance(stretch).into();
        let planned = Planned { stretch: *stretch, before: Arc::clone(grid), plan, after: Arc::new(after) };
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

    fn advance(&mut self, stretch: &Stretch) -> Vec<LevelPlan> {
        let mut new = NewLacks::new();
        new.len = stretch.places();
        new.is_whole = stretch.samples() == new.len;
        for (missing, has_sample) in new.missing[MEMORY..].iter_mut().zip(stretch.has_sample()) {
            *missing = u32::from(!has_sample);
        }
        self.continue_by(stretch.places() as u64, new)
    }

    /// The plan of a gap; `None` for one without places, which no window spans.
    pub(super) fn gap(&mut self, missing: u64) -> Option<Vec<LevelPlan>> {
        let missing = room_for(self.end, missing);
        (missing > 0).then(|| self.continue_by(missing, NewLacks::new()))
    }

    /// No window spans this place.
    pub(super) fn part(&mut self) {
        self.levels.fill(GridLevel::default());
    }

    /// Continues by this many places, the first ones as in `new`, the others without samples.
    fn continue_by(&mut self, mut places: u64, mut new: NewLacks) -> Vec<LevelPlan> {
        self.end += places;
        let mut plan = Vec::new();
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
            let lag = (1 << k).min(self.windows_per_tau);
            let remembered = self.levels[k as usize].len;
            let from = remembered.saturating_sub(lag);
            let pairs = |new: u64| ((remembered - from) as u64 + new).saturating_sub(lag as u64);
            // if the stride doubles, even multiples of the stride are on the next grid
            let every = if lag < self.windows_per_tau { 1 } else { 2 };
            let first = |last: u64, pairs: u64| if every == 1 { 0 } else { first_even(last, pairs) };
            let stride = (1 << k) / lag as u64;
            // the last of all new sums ends at this multiple of the stride
            let last = self.end / stride;
            let with_sums = new.len as u64;
            let first_joined = from + first(last - (places - with_sums), pairs(with_sums)) as usize;
            let mut step = LevelPlan { new: new.len, remembered, lag, first: first_joined, every, lossy: None };
            let pairs = pairs(places);
            places = pairs.saturating_sub(first(last, pairs)).div_ceil(every as u64);
            step.lossy = self.levels[k as usize].advance(self.deviation, 1 << k, &step, &mut new, &mut joined);
            plan.push(step);
            mem::swap(&mut new, &mut joined);
        }
        plan
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
        new: &mut NewLacks,
        joined: &mut NewLacks,
    ) -> Option<LossyWindows> {
        let is_zero = |missing: &[u32]| missing.iter().all(|missing| *missing == 0);
        let values = self.len + new.len;
        joined.is_whole = new.is_whole && is_zero(&self.missing[MEMORY - self.len..]);
        let lossy = if joined.is_whole {
            joined.len = step.joined(values);
            None
        } else {
            let len = new.len;
            let missing = continued(&mut self.missing, self.len, new.missing(), len);
            joined.len = step.join(missing, &mut joined.missing);
            joined.is_whole = is_zero(&joined.missing[MEMORY..][..joined.len]);
            Some(LossyWindows::of(deviation, m, step.lag, missing))
        };
        self.len = values.min((deviation.order() - 1) * step.lag);
        lossy
    }
}

impl NewLacks {
    const fn new() -> Self {
        Self { missing: [0; MEMORY + Stretch::MOST], len: 0, is_whole: true }
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
            self.missing()[MEMORY + known..MEMORY + len].fill(m);
            self.len = len;
        }
    }
}

impl LossyWindows {
    /// One window for each place from which its clusters of `m` samples follow, `lag` places apart;
    /// it is used if half of each cluster is present.
    fn of(deviation: Deviation, m: u32, lag: usize, missing: &[u32]) -> Self {
        let mut windows = Self::default();
        let order = deviation.order();
        for place in 0..missing.len().saturating_sub((order - 1) * lag) {
            let clusters = missing[place..].iter().step_by(lag).take(order);
            let is_whole = clusters.clone().all(|missing| *missing == 0);
            windows.masks.push(-i64::from(is_whole));
            windows.whole += u64::from(is_whole);
            if !is_whole && clusters.clone().all(|missing| 2 * u64::from(*missing) <= m.into()) {
                let mut present = [1; 3];
                present.iter_mut().zip(clusters).for_each(|(present, missing)| *present = m - missing);
                windows.gapped.push(GappedWindow::new(m, deviation.weights(), place, present));
            }
        }
        windows
    }
}

impl LevelPlan {
    /// Block sums of the next level from these of this level, written to the places of new values;
    /// returns their number.
    #[inline(always)]
    pub(super) fn join<T: Copy + Add<Output = T>>(&self, sums: &[T], next: &mut Scratch<T>) -> usize {
        let len = self.joined(sums.len());
        let next = &mut next[MEMORY..][..len];
        let older = sums.get(self.first..).unwrap_or_default();
        let newer = older.get(self.lag..).unwrap_or_default();
        if self.every == 1 {
            for (sum, (older, newer)) in next.iter_mut().zip(older.iter().zip(newer)) {
                *sum = *older + *newer;
            }
        } else {
            for (i, sum) in next.iter_mut().enumerate() {
                *sum = older[2 * i] + newer[2 * i];
            }
        }
        len
    }

    /// The number of these sums that are joined and continue.
    const fn joined(&self, sums: usize) -> usize {
        sums.saturating_sub(self.lag + self.first).div_ceil(self.every)
    }
}
