//! Statistics of the blocks of a record: mean, deviation and extremes, in bounded memory.

use ethnum::I256;

use super::counts;

/// Most blocks of a record; once filled, half as many of twice the length hold it.
pub const MAX_BLOCKS: usize = 96;

/// Samples of the shortest block, and of the windows in which disturbances are sought.
pub(crate) const WINDOW: usize = 32;

/// Exact statistics of at most [`MAX_BLOCKS`] blocks of equal length, the smallest power of two,
/// from 32 samples up, with which the record fits. They lie on a grid of absolute sample indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    length_log2: u32,
    /// The blocks from absolute index 0 on; those without a sample are empty.
    sums: Vec<Sums>,
}

/// One block of a record and its statistics in counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Absolute index of the first sample the block has room for, a multiple of its length.
    pub first_sample: u64,
    /// Samples the block has room for, a power of two.
    pub length: u64,
    /// Samples present, at least 1.
    pub count: u64,
    /// Arithmetic mean.
    pub mean_counts: f64,
    /// Sample standard deviation (divisor n - 1), 0 for a constant; `None` for one sample.
    pub std_counts: Option<f64>,
    /// Smallest sample.
    pub min_counts: i32,
    /// Largest sample.
    pub max_counts: i32,
}

/// Exact for up to 2^32 samples of 32 bits: 435 years at 40 Hz in [`MAX_BLOCKS`] blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sums {
    squares: u128,
    pub(crate) sum: i64,
    count: u64,
    min: i32,
    max: i32,
}

impl Blocks {
    pub(crate) fn new() -> Self {
        Self { length_log2: WINDOW.ilog2(), sums: Vec::with_capacity(MAX_BLOCKS) }
    }

    /// Adds samples of one window, that is of one block of the shortest length.
    pub(crate) fn add(&mut self, sample: u64, sums: &Sums) {
        while sample >> self.length_log2 >= MAX_BLOCKS as u64 {
            self.merge_pairs();
        }
        let block = (sample >> self.length_log2) as usize;
        if self.sums.len() <= block {
            self.sums.resize(block + 1, Sums::EMPTY);
        }
        self.sums[block].add(sums);
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Block> {
        let length = 1_u64 << self.length_log2;
        let present = self.sums.iter().zip(0_u64..).filter(|(sums, _)| sums.count > 0);
        present.map(move |(sums, block)| sums.block(block * length, length))
    }

    fn merge_pairs(&mut self) {
        for pair in 0..self.sums.len().div_ceil(2) {
            let mut merged = self.sums[2 * pair];
            if let Some(second) = self.sums.get(2 * pair + 1) {
                merged.add(second);
            }
            self.sums[pair] = merged;
        }
        self.sums.truncate(self.sums.len().div_ceil(2));
        self.length_log2 += 1;
    }
}

impl Sums {
    const EMPTY: Self = Self { squares: 0, sum: 0, count: 0, min: i32::MAX, max: i32::MIN };

    /// The sums of at most [`WINDOW`] samples, and n Σd² - (Σd)² = n (n - 1) variance.
    #[inline]
    pub(crate) fn of(window: &[i32]) -> (Self, f64) {
        let Some(&pivot) = window.first() else { return (Self::EMPTY, 0.0) };
        let deviation = |count: i32| f64::from(count) - f64::from(pivot);
        let first = counts::lane_sum([window], |[count]| deviation(count));
        let second = counts::lane_sum([window], |[count]| deviation(count) * deviation(count));
        // No more than 32 times 2^32: exact.
        let first_exact = first as i64;
        let second_exact =
            if second < counts::EXACT_BELOW { i128::from(second as i64) } else { squares_about(window, pivot) };
        let (p, n) = (i64::from(pivot), window.len() as i64);
        let sums = Self {
            // Not negative: a sum of squares.
            squares: (second_exact + i128::from(p) * i128::from(2 * first_exact + n * p)) as u128,
            sum: first_exact + n * p,
            count: window.len() as u64,
            min: window.iter().fold(pivot, |min, &count| min.min(count)),
            max: window.iter().fold(pivot, |max, &count| max.max(count)),
        };
        (sums, second * window.len() as f64 - first * first)
    }

    fn block(&self, first_sample: u64, length: u64) -> Block {
        let Self { squares, sum, count, min, max } = *self;
        let n = count as f64;
        let numerator = I256::from(squares) * I256::from(count) - I256::from(sum) * I256::from(sum);
        let std_counts = (count > 1).then(|| (numerator.as_f64() / (n * (n - 1.0))).sqrt());
        Block { first_sample, length, count, mean_counts: sum as f64 / n, std_counts, min_counts: min, max_counts: max }
    }

    fn add(&mut self, other: &Self) {
        self.squares += other.squares;
        self.sum += other.sum;
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }
}

#[cold]
#[inline(never)]
fn squares_about(window: &[i32], pivot: i32) -> i128 {
    let deviations = window.iter().map(|&count| i128::from(count) - i128::from(pivot));
    deviations.map(|d| d * d).sum()
}
