//! Statistics of the blocks of a record: mean, deviation and extremes, in bounded memory.

use ethnum::I256;
use multiversion::multiversion;

use super::counts;

/// The most blocks of a record; when they are full, half as many of twice the length replace them.
pub const MAX_BLOCKS: usize = 96;

/// Samples of the shortest block, and of the windows in which disturbances are searched.
pub(crate) const WINDOW: usize = 32;

/// The spread of a window over that without its farthest sample, if that is 15 standard deviations out.
const OUTLYING: f64 = 8.0;

/// Exact statistics of at most [`MAX_BLOCKS`] blocks of equal length, the smallest power of two,
/// from 32 samples up, for which the record fits. They lie on a grid of absolute sample indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    length_log2: u32,
    /// The blocks from absolute index 0 on; blocks without a sample are empty.
    sums: Vec<BlockSums>,
}

/// One block of a record, with its statistics in counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Absolute index of the first place of the block, a multiple of its length.
    pub first_sample: u64,
    /// Number of places of the block, a power of two.
    pub length: u64,
    /// Number of samples in the block, at least 1; less than `length` if samples are missing.
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

/// The sums of one block, exact for up to 2^32 samples of 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockSums {
    squares: u128,
    pub(crate) sum: i64,
    count: u64,
    min: i32,
    max: i32,
    pub(crate) spreads: Spreads,
}

/// The spreads within the full windows of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Spreads {
    /// Windows whose samples differ.
    pub(crate) windows: u64,
    /// Windows of one value.
    pub(crate) constant: u64,
    /// Sum of the logarithms of the spreads that are not 0; see [`log2_spread`].
    logs: u64,
    log_squares: u64,
}

impl Blocks {
    pub(crate) fn new() -> Self {
        Self { length_log2: WINDOW.ilog2(), sums: Vec::with_capacity(MAX_BLOCKS) }
    }

    /// Adds samples of one window, which is one block of the shortest length.
    pub(crate) fn add(&mut self, sample: u64, sums: &BlockSums) {
        while sample >> self.length_log2 >= MAX_BLOCKS as u64 {
            self.merge_pairs();
        }
        let block = (sample >> self.length_log2) as usize;
        if self.sums.len() <= block {
            self.sums.resize(block + 1, BlockSums::EMPTY);
        }
        self.sums[block].add(sums);
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Block> {
        let length = 1_u64 << self.length_log2;
        let present = self.sums.iter().zip(0_u64..).filter(|(sums, _)| sums.count > 0);
        present.map(move |(sums, block)| sums.block(block * length, length))
    }

    /// First sample, length in samples and spreads of the blocks with full windows, in time order.
    pub(crate) fn spreads(&self) -> impl Iterator<Item = (u64, u64, &Spreads)> {
        let length = 1_u64 << self.length_log2;
        let all = self.sums.iter().zip(0_u64..).map(move |(sums, block)| (block * length, length, &sums.spreads));
        all.filter(|(.., spreads)| spreads.windows + spreads.constant > 0)
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

impl BlockSums {
    const EMPTY: Self = Self {
        squares: 0,
        sum: 0,
        count: 0,
        min: i32::MAX,
        max: i32::MIN,
        spreads: Spreads { windows: 0, constant: 0, logs: 0, log_squares: 0 },
    };

    /// The sums of at most [`WINDOW`] samples, and n Σd² - (Σd)² = n (n - 1) variance.
    #[inline]
    pub(crate) fn of(window: &[i32]) -> (Self, f64) {
        let Some(&pivot) = window.first() else { return (Self::EMPTY, 0.0) };
        let Deviations { sum: first, squares: second, min, max } = deviations(window, pivot);
        let (p, n) = (i64::from(pivot), window.len() as i64);
        let (first_f64, n_f64) = (first as f64, window.len() as f64);
        // fits except for counts of full scale, and is converted faster
        let second_f64 = i64::try_from(second).map_or(second as f64, |second| second as f64);
        let spread = second_f64 * n_f64 - first_f64 * first_f64;
        let mut sums = Self {
            // Not negative, because it is a sum of squares.
            squares: (second + i128::from(p) * i128::from(2 * first + n * p)) as u128,
            sum: first + n * p,
            count: window.len() as u64,
            min,
            max,
            spreads: Spreads::default(),
        };
        if window.len() == WINDOW {
            // one sample that is most of the spread is an outlier, and no change of the noise
            let without = sums.spread_without_farthest(spread);
            sums.spreads = Spreads::of(if OUTLYING * without < spread { without.max(1.0).min(spread) } else { spread });
        }
        (sums, spread)
    }

    /// The spread of a window without the sample farthest from its mean; 0 for fewer than two.
    pub(crate) fn spread_without_farthest(&self, spread: f64) -> f64 {
        let n = self.count as f64;
        if n < 2.0 {
            return 0.0;
        }
        let mean = self.sum as f64 / n;
        let farthest = (f64::from(self.max) - mean).max(mean - f64::from(self.min));
        (spread - n * n / (n - 1.0) * farthest * farthest).max(0.0)
    }

    /// No number without samples.
    pub(crate) fn mean(&self) -> f64 {
        self.sum as f64 / self.count as f64
    }

    /// How far the farthest sample lies from the mean of the window, its own part in it allowed for, or
    /// from the nearer of the means before and behind if it is on that level, as at a step.
    pub(crate) fn farthest(&self, around: [f64; 2]) -> f64 {
        let (n, mean) = (self.count as f64, self.mean());
        let beyond = |side: f64, extreme: i32| {
            let from = |mean: f64| side * (f64::from(extreme) - mean);
            let own = from(mean) * (n / (n - 1.0).max(1.0)).sqrt();
            let nearest = around.map(from).into_iter().fold(own, f64::min);
            if nearest < own / 2.0 { nearest } else { own }
        };
        beyond(1.0, self.max).max(beyond(-1.0, self.min)).max(0.0)
    }

    fn block(&self, first_sample: u64, length: u64) -> Block {
        let Self { squares, sum, count, min, max, .. } = *self;
        let n = count as f64;
        let numerator = I256::from(squares) * I256::from(count) - I256::from(sum) * I256::from(sum);
        let std_counts = (count > 1).then(|| (numerator.as_f64() / (n * (n - 1.0))).sqrt());
        Block { first_sample, length, count, mean_counts: self.mean(), std_counts, min_counts: min, max_counts: max }
    }

    fn add(&mut self, other: &Self) {
        self.squares += other.squares;
        self.sum += other.sum;
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.spreads.add(&other.spreads);
    }
}

impl Spreads {
    /// Units of [`log2_spread`] in an octave.
    const OCTAVE: f64 = 4096.0;

    fn of(spread: f64) -> Self {
        if spread < 1.0 {
            return Self { constant: 1, ..Self::default() };
        }
        let log = log2_spread(spread);
        Self { windows: 1, constant: 0, logs: log, log_squares: log * log }
    }

    fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.constant += other.constant;
        self.logs += other.logs;
        self.log_squares += other.log_squares;
    }

    /// Mean binary logarithm of the spreads that are not 0; `None` without any.
    pub(crate) fn mean_log2(&self) -> Option<f64> {
        (self.windows > 0).then(|| self.logs as f64 / self.windows as f64 / Self::OCTAVE)
    }

    /// Sum of the squared deviations of the binary logarithms from their mean.
    pub(crate) fn log2_squares(&self) -> f64 {
        let (windows, logs) = (self.windows as f64, self.logs as f64);
        let squares = self.log_squares as f64 - if windows > 0.0 { logs * logs / windows } else { 0.0 };
        squares.max(0.0) / Self::OCTAVE.powi(2)
    }
}

/// Binary logarithm of a spread from 1 to 2^75 in units of 1/4096, rounded down, within 0.01: exponent
/// and fraction of the float, and a parabola for the excess of the logarithm.
fn log2_spread(spread: f64) -> u64 {
    const BIAS: u64 = 1023 << 12;
    let bits = (spread.to_bits() >> 40) - BIAS;
    let fraction = bits & 0xFFF;
    bits + ((fraction * (4096 - fraction) * 1409) >> 24)
}

/// Sums of the deviations of a window from its first sample, and its extremes.
struct Deviations {
    sum: i64,
    squares: i128,
    min: i32,
    max: i32,
}

#[multiversion(targets("x86_64+avx2"))]
fn deviations(window: &[i32], pivot: i32) -> Deviations {
    let deviation = |count: i32| f64::from(count) - f64::from(pivot);
    let squares = counts::lane_sum([window], |[count]| deviation(count) * deviation(count));
    let is_exact = squares < counts::EXACT_BELOW;
    Deviations {
        // no more than 32 times 2^32, so exact
        sum: counts::lane_sum([window], |[count]| deviation(count)) as i64,
        squares: if is_exact { i128::from(squares as i64) } else { squares_about(window, pivot) },
        min: window.iter().fold(pivot, |min, &count| min.min(count)),
        max: window.iter().fold(pivot, |max, &count| max.max(count)),
    }
}

#[cold]
#[inline(never)]
fn squares_about(window: &[i32], pivot: i32) -> i128 {
    let deviations = window.iter().map(|&count| i128::from(count) - i128::from(pivot));
    deviations.map(|d| d * d).sum()
}
#[cfg(test)]
mod tests {
    use proptest::{array::uniform32, prelude::*};

    use super::*;

    #[test]
    fn logarithms_of_spreads_are_within_a_hundredth_and_rise() {
        let mut before = 0;
        for i in 0..20_000 {
            let spread = (f64::from(i) * 74.0 / 20_000.0).exp2();
            let log = log2_spread(spread);
            assert!((log as f64 / Spreads::OCTAVE - spread.log2()).abs() < 0.01, "{spread}");
            assert!(log >= before);
            before = log;
        }
    }

    #[test]
    fn spreads_count_full_windows_and_those_of_one_value() {
        let noisy: Vec<i32> = (0..32).map(|i| i * 7919 % 13).collect();
        let mut blocks = Blocks::new();
        for (window, samples) in [&noisy[..], &[5; 32], &noisy[..31]].into_iter().enumerate() {
            blocks.add(32 * window as u64, &BlockSums::of(samples).0);
        }
        let of: Vec<_> =
            blocks.spreads().map(|(first, _, spreads)| (first, spreads.windows, spreads.constant)).collect();
        assert_eq!(of, [(0, 1, 0), (32, 0, 1)]);
    }

    proptest! {
        #[test]
        fn deviations_are_exact(
            pivot: i32,
            offsets in uniform32(prop_oneof![-9000..9000_i32, any::<i32>()]),
            reach in prop_oneof![1..9000_i32, Just(i32::MAX)],
        ) {
            let mut window = offsets.map(|offset| pivot.wrapping_add(offset % reach));
            window[0] = pivot;
            let exact = window.map(|count| i128::from(count) - i128::from(pivot));
            let Deviations { sum, squares, min, max } = deviations(&window, pivot);
            prop_assert_eq!((i128::from(sum), squares), (exact.iter().sum(), exact.iter().map(|d| d * d).sum()));
            prop_assert_eq!((Some(&min), Some(&max)), (window.iter().min(), window.iter().max()));
        }
    }

    #[test]
    fn the_farthest_sample_is_excluded_from_the_spread() {
        let mut window: Vec<i32> = (0..32).map(|i| i * 7919 % 13).collect();
        window[9] = 1000;
        let (sums, spread) = BlockSums::of(&window);
        window.remove(9);
        let (_, rest) = BlockSums::of(&window);
        let without = sums.spread_without_farthest(spread);
        // one has n samples, the other n - 1
        assert!((without - rest * 32.0 / 31.0).abs() < 1e-6 * spread, "{without} {rest}");
    }
}
