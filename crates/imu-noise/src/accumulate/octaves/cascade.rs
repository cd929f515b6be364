//! Windows at a stride, in bounded memory: a cascade of block sums, one level per octave.
//!
//! Level k holds sums of m = 2^k samples that end at absolute multiples of its stride s = max(1,
//! m/R). Two sums m samples apart are `lag` = min(m, R) places apart; their difference is the Allan
//! term of the level, their sum is a block sum of the next. Where the stride doubles, every second
//! sum continues, so all levels together cost log2 R + 2 updates per sample.
//!
//! A missing sample has its place like any other, and cluster sums carry the number of samples they
//! lack; where none is missing, that number costs nothing.

use core::{mem, ops::Add};

use multiversion::multiversion;

use super::{gapped::Gapped, squares::SquareSum};
use crate::accumulate::{places::room_for, record::Deviation};

/// Longest averaging factor, 2^30.
pub(super) const MAX_LEVEL: u32 = 30;

/// Long enough for vector instructions, short enough for the first-level cache.
const BLOCK: usize = 256;
/// Most windows per averaging time.
const MAX_LAG: usize = 16;
/// So many new sums of a long gap stand for all: a lag of them may reach back before the gap, as
/// many fill what a level remembers, and the rest are alike.
const OF_A_GAP: u64 = 4 * MAX_LAG as u64;

/// Room for what a level remembers, followed from [`MAX_LAG`] on by what is new.
type Scratch<T> = [T; MAX_LAG + BLOCK];

#[derive(Clone, Debug)]
pub(super) struct Cascade {
    deviation: Deviation,
    windows_per_tau: usize,
    /// Absolute index of the next place.
    end: u64,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    sums: Remembered,
    /// The sums one cluster before those, for third differences only.
    earlier: Remembered,
    squares: SquareSum,
    gapped: Gapped,
}

/// The last block sums of the present run.
#[derive(Clone, Debug)]
struct Remembered {
    sums: Memory<i64>,
    /// How many samples each lacks.
    missing: Memory<u32>,
    /// None lacks any.
    whole: bool,
}

/// The last `len` values of the present run, at the end of `values`; at most the lag of the level.
#[derive(Clone, Debug)]
struct Memory<T> {
    values: [T; MAX_LAG],
    len: usize,
}

/// New block sums of one level, and how many samples each lacks; `None` where none lacks any.
struct LevelBlocks {
    sums: Scratch<i64>,
    missing: Option<Scratch<u32>>,
    len: usize,
}

/// How the new sums of a level continue.
struct Onward {
    /// Number of the last new sum, in strides from index 0.
    last: u64,
    /// Every sum continues, or every second.
    every: usize,
}

impl Cascade {
    /// `windows_per_tau` is R, a power of two up to 16.
    pub(super) fn new(windows_per_tau: usize, deviation: Deviation) -> Self {
        debug_assert!(windows_per_tau.is_power_of_two() && windows_per_tau <= MAX_LAG);
        Self { deviation, windows_per_tau, end: 0, levels: Vec::new() }
    }

    pub(super) fn start_at(&mut self, index: u64) {
        self.end = index;
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            let mut new = LevelBlocks::new();
            for (sum, &count) in new.sums[MAX_LAG..].iter_mut().zip(block) {
                *sum = count.into();
            }
            new.len = block.len();
            advance(self, &mut new, block.len() as u64);
        }
    }

    pub(super) fn gap(&mut self, missing: Option<u64>) {
        match missing.map(|missing| room_for(self.end, missing)) {
            Some(missing) if missing > 0 => advance(self, &mut LevelBlocks::new(), missing),
            _ => self.levels.iter_mut().for_each(Level::forget),
        }
    }

    /// The octave m = 2^k, if any sample reached it: squares of whole windows, and those of
    /// the others.
    pub(super) fn octave(&self, k: usize) -> Option<(SquareSum, Gapped)> {
        self.levels.get(k).map(|level| (level.squares, level.gapped))
    }

    fn lag(&self, k: u32) -> usize {
        (1_usize << k).min(self.windows_per_tau)
    }

    fn stride(&self, k: u32) -> u64 {
        ((1_usize << k) / self.windows_per_tau).max(1) as u64
    }

    /// Adds the windows that end with the new sums of level `k`; `joined` are then those of the
    /// next level. `last` is the number of the last new sum in strides from index 0.
    #[inline(always)]
    fn take(&mut self, k: u32, last: u64, new: &mut LevelBlocks, joined: &mut LevelBlocks) {
        if k as usize == self.levels.len() {
            self.levels.push(Level::EMPTY);
        }
        let lag = self.lag(k);
        let level = &mut self.levels[k as usize];
        let onward = Onward { last, every: if lag < self.windows_per_tau { 1 } else { 2 } };
        if new.missing.is_none() && level.sums.whole && level.earlier.whole {
            let (older, newer) = level.sums.pairs_of_whole(&mut new.sums, new.len, lag);
            match self.deviation {
                Deviation::Allan => level.squares.add([older, newer], difference),
                Deviation::Hadamard => {
                    let mut sums: Scratch<i64> = [0; MAX_LAG + BLOCK];
                    sums[MAX_LAG..][..older.len()].copy_from_slice(older);
                    let (oldest, middle) = level.earlier.pairs_of_whole(&mut sums, older.len(), lag);
                    level.squares.add([oldest, middle, from_end(newer, middle.len())], second_difference);
                }
            }
            joined.len = onward.join(older, newer, &mut joined.sums);
            joined.missing = None;
        } else {
            level.take_gapped(self.deviation, k, lag, &onward, new, joined);
        }
    }
}

/// Continues by so many places; of `new`, what is behind its length is missing.
#[multiversion(targets("x86_64+avx2"))]
fn advance(cascade: &mut Cascade, new: &mut LevelBlocks, mut places: u64) {
    cascade.end += places;
    let (mut new, mut joined) = (&mut *new, &mut LevelBlocks::new());
    for k in 0..=MAX_LEVEL {
        if places == 0 {
            break;
        }
        if (new.len as u64) < places {
            new.fill_up(places.min(OF_A_GAP) as usize, 1 << k);
        }
        let remembered = cascade.levels.get(k as usize).map_or(0, |level| level.sums.sums.len);
        // the last of all that are new ends at this multiple of the stride
        let last = cascade.end / cascade.stride(k);
        cascade.take(k, last - (places - new.len as u64), new, joined);
        let lag = cascade.lag(k);
        let pairs = (remembered as u64 + places).saturating_sub(lag as u64);
        places = if lag < cascade.windows_per_tau { pairs } else { (pairs + 1 - ((last + pairs + 1) & 1)) / 2 };
        mem::swap(&mut new, &mut joined);
    }
}

impl Level {
    const EMPTY: Self =
        Self { sums: Remembered::EMPTY, earlier: Remembered::EMPTY, squares: SquareSum::EMPTY, gapped: Gapped::EMPTY };

    fn forget(&mut self) {
        (self.sums, self.earlier) = (Remembered::EMPTY, Remembered::EMPTY);
    }

    /// As [`Cascade::take`], where samples are missing.
    #[cold]
    #[inline(never)]
    fn take_gapped(
        &mut self,
        deviation: Deviation,
        k: u32,
        lag: usize,
        onward: &Onward,
        new: &mut LevelBlocks,
        joined: &mut LevelBlocks,
    ) {
        let missing = new.missing.get_or_insert([0; MAX_LAG + BLOCK]);
        let (older, newer) = self.sums.sums.pairs(&mut new.sums, new.len, lag);
        let (older_lack, newer_lack) = self.sums.missing.pairs(missing, new.len, lag);
        self.sums.whole = self.sums.missing.are_zero();
        match deviation {
            Deviation::Allan => self.add_windows(k, [-1, 1], [older, newer], [older_lack, newer_lack]),
            Deviation::Hadamard => {
                let (mut sums, mut missing): (Scratch<i64>, Scratch<u32>) =
                    ([0; MAX_LAG + BLOCK], [0; MAX_LAG + BLOCK]);
                sums[MAX_LAG..][..older.len()].copy_from_slice(older);
                missing[MAX_LAG..][..older.len()].copy_from_slice(older_lack);
                let (oldest, middle) = self.earlier.sums.pairs(&mut sums, older.len(), lag);
                let (oldest_lack, middle_lack) = self.earlier.missing.pairs(&mut missing, older.len(), lag);
                self.earlier.whole = self.earlier.missing.are_zero();
                let windows = middle.len();
                let sums = [oldest, middle, from_end(newer, windows)];
                let lacks = [oldest_lack, middle_lack, from_end(newer_lack, windows)];
                self.add_windows(k, [1, -2, 1], sums, lacks);
            }
        }
        joined.len = onward.join(older, newer, &mut joined.sums);
        let lack = joined.missing.insert([0; MAX_LAG + BLOCK]);
        onward.join(older_lack, newer_lack, lack);
        if lack[MAX_LAG..][..joined.len].iter().all(|missing| *missing == 0) {
            joined.missing = None;
        }
    }

    /// Adds one window for each place of the slices, where half of each cluster is present.
    fn add_windows<const P: usize>(&mut self, k: u32, weights: [i64; P], sums: [&[i64]; P], missing: [&[u32]; P]) {
        let mut whole = [0_i64; MAX_LAG + BLOCK];
        let mut count = 0;
        for i in 0..sums[0].len() {
            let (sums, missing) = (sums.map(|sums| sums[i]), missing.map(|missing| missing[i]));
            if missing == [0; P] {
                whole[count] = weights.iter().zip(sums).fold(0, |z: i64, (weight, sum)| z.wrapping_add(weight * sum));
                count += 1;
            } else if missing.iter().all(|missing| 2 * u64::from(*missing) <= 1 << k) {
                let present = missing.map(|missing| (1_u64 << k) - u64::from(missing));
                self.gapped.add(1 << k, weights, sums, present);
            }
        }
        self.squares.add([&whole[..count]], |[z]| z);
    }
}

impl Remembered {
    const EMPTY: Self = Self { sums: Memory::of(0), missing: Memory::of(0), whole: true };

    #[inline(always)]
    fn pairs_of_whole<'a>(&mut self, new: &'a mut Scratch<i64>, len: usize, lag: usize) -> (&'a [i64], &'a [i64]) {
        let pairs = self.sums.pairs(new, len, lag);
        self.missing.len = self.sums.len;
        pairs
    }
}

impl<T: Copy> Memory<T> {
    const fn of(value: T) -> Self {
        Self { values: [value; MAX_LAG], len: 0 }
    }

    /// Values `lag` places apart among those remembered and the `new` ones of `scratch`, older and
    /// newer, as slices of equal length.
    #[inline(always)]
    fn pairs<'a>(&mut self, scratch: &'a mut Scratch<T>, new: usize, lag: usize) -> (&'a [T], &'a [T]) {
        // Always all places: a copy of constant length is a few moves.
        scratch[..MAX_LAG].copy_from_slice(&self.values);
        self.values.copy_from_slice(&scratch[new..new + MAX_LAG]);
        let values = &scratch[MAX_LAG - self.len..MAX_LAG + new];
        self.len = values.len().min(lag);
        let pairs = values.len() - self.len;
        (&values[..pairs], &values[self.len..])
    }
}

impl Memory<u32> {
    fn are_zero(&self) -> bool {
        from_end(&self.values, self.len).iter().all(|value| *value == 0)
    }
}

impl LevelBlocks {
    #[inline]
    const fn new() -> Self {
        Self { sums: [0; MAX_LAG + BLOCK], missing: None, len: 0 }
    }

    /// With blocks of `m` missing samples, to this length.
    #[cold]
    fn fill_up(&mut self, len: usize, m: u32) {
        if let Some(more) = len.checked_sub(self.len) {
            let places = MAX_LAG + self.len..MAX_LAG + self.len + more;
            self.sums[places.clone()].fill(0);
            self.missing.get_or_insert([0; MAX_LAG + BLOCK])[places].fill(m);
            self.len = len;
        }
    }
}

impl Onward {
    /// Block sums of the next level, written where new values go; returns how many there are.
    #[inline(always)]
    fn join<T: Copy + Add<Output = T>>(&self, older: &[T], newer: &[T], next: &mut Scratch<T>) -> usize {
        let pairs = older.len();
        let pairs_of = older.iter().zip(newer);
        if self.every == 1 {
            for (sum, (older, newer)) in next[MAX_LAG..].iter_mut().zip(pairs_of) {
                *sum = *older + *newer;
            }
            return pairs;
        }
        // Even multiples of the stride are on the next grid.
        let first = ((self.last + pairs as u64 + 1) & 1) as usize;
        let len = (pairs + 1).saturating_sub(first) / 2;
        for (i, sum) in next[MAX_LAG..MAX_LAG + len].iter_mut().enumerate() {
            *sum = older[first + 2 * i] + newer[first + 2 * i];
        }
        len
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

fn from_end<T>(values: &[T], len: usize) -> &[T] {
    &values[values.len() - len..]
}
#[cfg(test)]
mod tests;
