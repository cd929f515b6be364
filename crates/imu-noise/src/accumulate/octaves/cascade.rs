//! Windows at a stride, in bounded memory: a cascade of block sums, one level per octave.
//!
//! Level k holds sums of m = 2^k samples that end at absolute multiples of its stride s = max(1,
//! m/R). Two sums m samples apart are `lag` = min(m, R) places apart; their difference is the Allan
//! term of the level, their sum is a block sum of the next. Where the stride doubles, every second
//! sum continues, so all levels together cost log2 R + 2 updates per sample.

use super::squares::SquareSum;
use crate::accumulate::record::Deviation;

/// Longest averaging factor, 2^30.
pub(super) const MAX_LEVEL: u32 = 30;

/// Long enough for vector instructions, short enough for the first-level cache.
const BLOCK: usize = 256;
/// Most windows per averaging time.
const MAX_LAG: usize = 16;

/// Room for what a level remembers, followed from [`MAX_LAG`] on by what is new.
type Scratch = [i64; MAX_LAG + BLOCK];

#[derive(Clone, Debug)]
pub(super) struct Cascade {
    deviation: Deviation,
    windows_per_tau: usize,
    keeps_terms: bool,
    /// Absolute index behind the last sample; only its divisibility by powers of two matters: it
    /// may wrap.
    end: u64,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    sums: Memory,
    /// Differences of block sums, for third differences only.
    differences: Memory,
    squares: SquareSum,
    /// Sum of the terms themselves, where it is kept.
    terms: i128,
}

/// The last `len` values of the present run, at the end of `values`; at most the lag of the level.
#[derive(Clone, Debug)]
struct Memory {
    values: [i64; MAX_LAG],
    len: usize,
}

impl Cascade {
    /// `windows_per_tau` is R, a power of two up to 16.
    pub(super) fn new(windows_per_tau: usize, deviation: Deviation) -> Self {
        debug_assert!(windows_per_tau.is_power_of_two() && windows_per_tau <= MAX_LAG);
        Self { deviation, windows_per_tau, keeps_terms: false, end: 0, levels: Vec::new() }
    }

    pub(super) fn keep_terms(&mut self) {
        self.keeps_terms = true;
    }

    pub(super) fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            self.push_block(block);
        }
    }

    pub(super) fn gap(&mut self, missing: Option<u64>) {
        self.end = missing.map_or(0, |missing| self.end.wrapping_add(missing));
        for level in &mut self.levels {
            level.sums.len = 0;
            level.differences.len = 0;
        }
    }

    /// The octave m = 2^k, if any sample reached it: squares, and the sum of the terms before they
    /// are squared, of Allan differences, where they are kept.
    pub(super) fn octave(&self, k: usize) -> Option<(SquareSum, Option<i128>)> {
        self.levels.get(k).map(|level| (level.squares, self.keeps_terms.then_some(level.terms)))
    }

    fn push_block(&mut self, block: &[i32]) {
        self.end = self.end.wrapping_add(block.len() as u64);
        let (mut sums, mut next): (&mut Scratch, &mut Scratch) = (&mut [0; MAX_LAG + BLOCK], &mut [0; MAX_LAG + BLOCK]);
        for (sum, &count) in sums[MAX_LAG..].iter_mut().zip(block) {
            *sum = count.into();
        }
        let mut new = block.len();
        for k in 0..=MAX_LEVEL {
            if new == 0 {
                break;
            }
            if k as usize == self.levels.len() {
                self.levels.push(Level::EMPTY);
            }
            let level = &mut self.levels[k as usize];
            let m = 1_usize << k;
            let lag = m.min(self.windows_per_tau);
            let (older, newer) = level.sums.pairs(sums, new, lag);
            level.add_terms(self.deviation, older, newer, lag);
            if self.keeps_terms {
                level.terms +=
                    older.iter().zip(newer).map(|(older, newer)| i128::from(newer.wrapping_sub(*older))).sum::<i128>();
            }
            let stride = (m / self.windows_per_tau).max(1) as u64;
            new = if m < self.windows_per_tau {
                join(older, newer, next);
                older.len()
            } else {
                // The newest sum ends at the multiple end / stride of the stride; even multiples are on the next grid.
                let first = (self.end / stride + older.len() as u64 + 1) & 1;
                join_every_second(older, newer, first as usize, next)
            };
            core::mem::swap(&mut sums, &mut next);
        }
    }
}

impl Level {
    const EMPTY: Self = Self { sums: Memory::EMPTY, differences: Memory::EMPTY, squares: SquareSum::EMPTY, terms: 0 };

    #[inline]
    fn add_terms(&mut self, deviation: Deviation, older: &[i64], newer: &[i64], lag: usize) {
        match deviation {
            Deviation::Allan => self.squares.add([older, newer], difference),
            Deviation::Hadamard => {
                let mut differences: Scratch = [0; MAX_LAG + BLOCK];
                for ((place, &older), &newer) in differences[MAX_LAG..].iter_mut().zip(older).zip(newer) {
                    *place = difference([older, newer]);
                }
                let (older, newer) = self.differences.pairs(&mut differences, older.len(), lag);
                self.squares.add([older, newer], difference);
            }
        }
    }
}

impl Memory {
    const EMPTY: Self = Self { values: [0; MAX_LAG], len: 0 };

    /// Values `lag` places apart among those remembered and the `new` ones of `scratch`, older and
    /// newer, as slices of equal length.
    #[inline]
    fn pairs<'a>(&mut self, scratch: &'a mut Scratch, new: usize, lag: usize) -> (&'a [i64], &'a [i64]) {
        // Always all places: a copy of constant length is a few moves.
        scratch[..MAX_LAG].copy_from_slice(&self.values);
        self.values.copy_from_slice(&scratch[new..new + MAX_LAG]);
        let values = &scratch[MAX_LAG - self.len..MAX_LAG + new];
        self.len = values.len().min(lag);
        let pairs = values.len() - self.len;
        (&values[..pairs], &values[self.len..])
    }
}

#[inline]
fn difference([older, newer]: [i64; 2]) -> i64 {
    newer.wrapping_sub(older)
}

/// Block sums of the next level, written where new values go.
#[inline]
fn join(older: &[i64], newer: &[i64], next: &mut Scratch) {
    for ((sum, older), newer) in next[MAX_LAG..].iter_mut().zip(older).zip(newer) {
        *sum = older + newer;
    }
}

/// The same for every second pair from `first` on; returns how many these are.
#[inline]
fn join_every_second(older: &[i64], newer: &[i64], first: usize, next: &mut Scratch) -> usize {
    let len = (older.len() + 1).saturating_sub(first) / 2;
    for (i, sum) in next[MAX_LAG..MAX_LAG + len].iter_mut().enumerate() {
        *sum = older[first + 2 * i] + newer[first + 2 * i];
    }
    len
}

#[cfg(test)]
mod tests;
