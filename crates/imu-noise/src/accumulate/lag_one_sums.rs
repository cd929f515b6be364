//! The lag-1 autocorrelation of block sums at each block length: what kind of noise they show.

use ethnum::I256;

/// Times that block sums are differenced at most, as suits the Allan deviation.
pub(crate) const MAX_DIFFERENCES: usize = 2;

/// Longest blocks, 2^26 samples: then sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004). Shorter blocks would cost as much as all the octaves; there the
/// slope shows the noise type. Blocks that miss samples have no part in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LagOneSums {
    pub(crate) block: u64,
    levels: Vec<Level>,
    parted: bool,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Level {
    /// By number of differences taken.
    series: [LagOneSeries; MAX_DIFFERENCES + 1],
    /// Numbers of the first block of the piece, unless a break came before, and of the last one of
    /// the present run.
    first: Option<u64>,
    last: Option<u64>,
    /// All blocks so far are neighbours of each other.
    in_first_row: bool,
}

impl LagOneSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, levels: Vec::new(), parted: false }
    }

    #[inline]
    pub(crate) fn push(&mut self, mut number: u64, mut sum: i64) {
        for k in 0.. {
            let Some(level) = self.level(k) else { return };
            let before = level.push(number, sum);
            let Some(first_half) = before.filter(|_| number & 1 == 1) else { return };
            sum += first_half;
            number /= 2;
        }
    }

    /// Neighbours across a break are no neighbours.
    pub(crate) fn part(&mut self) {
        self.parted = true;
        self.levels.iter_mut().for_each(Level::part);
    }

    /// Continues with the next piece; the block that the two share, if they do, is the last one
    /// here.
    pub(crate) fn append(&mut self, next: &Self) {
        let mut shared = None;
        for k in 0..=(LONGEST / self.block).ilog2() as usize {
            if shared.is_none() && k >= self.levels.len().max(next.levels.len()) {
                break;
            }
            let none = Level::new(true);
            let theirs = next.levels.get(k).unwrap_or(&none);
            let Some(level) = self.level(k) else { break };
            let mut joined = None;
            if let Some((number, sum)) = shared {
                let first_half = level.push(number, sum).filter(|_| number & 1 == 1);
                joined = first_half.map(|half| (number / 2, half + sum));
            }
            if let Some(last) = level.last.filter(|last| last & 1 == 0 && theirs.first == Some(last + 1)) {
                let halves = level.series[0].last.zip(theirs.series[0].first);
                joined = halves.map(|(first, second)| (last / 2, first + second));
            }
            level.append(theirs, next.parted);
            shared = joined;
        }
        self.parted |= next.parted;
    }

    /// As if each sample were so many counts larger: differences of blocks stay as they are.
    pub(crate) fn shift(&mut self, by: i64) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            level.series[0].shift(by * (self.block << k) as i64);
        }
    }

    /// `None` for blocks longer than the longest.
    fn level(&mut self, k: usize) -> Option<&mut Level> {
        if k >= self.levels.len() {
            if self.block << k > LONGEST {
                return None;
            }
            self.levels.push(Level::new(!self.parted));
        }
        self.levels.get_mut(k)
    }

    /// By the number of differences taken; `None` for lengths that are not kept.
    pub(crate) fn series(&self, m: u64) -> Option<&[LagOneSeries; MAX_DIFFERENCES + 1]> {
        let level = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        Some(&level.series)
    }
}

impl Level {
    fn new(in_first_row: bool) -> Self {
        Self { series: Default::default(), first: None, last: None, in_first_row }
    }

    /// Returns the sum of the block before, if it is a neighbour.
    #[inline]
    fn push(&mut self, number: u64, sum: i64) -> Option<i64> {
        if self.last.is_some_and(|last| last + 1 != number) {
            self.part();
        }
        if self.in_first_row && self.first.is_none() {
            self.first = Some(number);
        }
        self.last = Some(number);
        let before = self.series[0].last;
        let mut value = Some(sum);
        for series in &mut self.series {
            value = value.and_then(|value| series.push(value, self.in_first_row));
        }
        before
    }

    fn part(&mut self) {
        self.series.iter_mut().for_each(LagOneSeries::end_run);
        (self.last, self.in_first_row) = (None, false);
    }

    fn append(&mut self, next: &Self, next_is_parted: bool) {
        if next.series[0].count == 0 {
            if next_is_parted {
                self.part();
            }
            return;
        }
        let meets = self.last.is_some_and(|last| next.first == Some(last + 1));
        let (is_empty, in_first_row) = (self.series[0].count == 0, self.in_first_row);
        if !meets {
            self.part();
        }
        self.in_first_row = in_first_row && (meets || is_empty) && next.in_first_row;
        if in_first_row && is_empty {
            self.first = next.first;
        }
        self.last = next.last;
        // the differences between the two sides, of which the next series are made
        let mut over_seam = Vec::new();
        for (ours, theirs) in self.series.iter_mut().zip(&next.series) {
            let mut differences: Vec<i64> =
                over_seam.into_iter().filter_map(|value| ours.push(value, in_first_row)).collect();
            if meets {
                differences.extend(ours.last.zip(theirs.first).map(|(last, first)| first - last));
            }
            ours.append(theirs, meets, next.in_first_row);
            if in_first_row && (meets || is_empty) {
                ours.first = ours.first.or(theirs.first);
            }
            over_seam = differences;
        }
    }
}

/// Sums over the values of a series; products join neighbours within runs without gap.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LagOneSeries {
    pub(crate) count: u64,
    pairs: u64,
    sum: i128,
    squares: i128,
    products: i128,
    /// Sum of the first value of every run and of the last one of every run that has ended.
    ends: i128,
    /// In the first row of blocks.
    first: Option<i64>,
    last: Option<i64>,
}

impl LagOneSeries {
    /// The difference to the value before.
    #[inline]
    fn push(&mut self, value: i64, in_first_row: bool) -> Option<i64> {
        let wide = i128::from(value);
        self.count += 1;
        self.sum += wide;
        self.squares += wide * wide;
        if in_first_row && self.first.is_none() {
            self.first = Some(value);
        }
        let Some(last) = self.last.replace(value) else {
            self.ends += wide;
            return None;
        };
        self.pairs += 1;
        self.products += i128::from(last) * wide;
        Some(value - last)
    }

    /// As if each value were so much larger.
    fn shift(&mut self, by: i64) {
        let (wide, count, pairs) = (i128::from(by), i128::from(self.count), i128::from(self.pairs));
        let inner = 2 * self.sum - self.ends - self.last.map_or(0, i128::from);
        self.products += wide * (inner + pairs * wide);
        self.squares += wide * (2 * self.sum + count * wide);
        // each run has a value more than pairs, and two ends but for the present one
        self.ends += wide * (2 * (count - pairs) - i128::from(self.last.is_some()));
        self.sum += wide * count;
        (self.first, self.last) = (self.first.map(|first| first + by), self.last.map(|last| last + by));
    }

    fn end_run(&mut self) {
        self.ends += self.last.take().map_or(0, i128::from);
    }

    /// `meets`: its first value, if it has one, follows the last one here; `in_first_row`: so does
    /// all of it.
    fn append(&mut self, next: &Self, meets: bool, in_first_row: bool) {
        match (self.last.filter(|_| meets), next.first) {
            (Some(last), Some(first)) => {
                self.pairs += 1;
                self.products += i128::from(last) * i128::from(first);
                self.ends -= i128::from(first);
                self.last = None;
            }
            _ if in_first_row => {}
            _ => self.end_run(),
        }
        self.count += next.count;
        self.pairs += next.pairs;
        self.sum += next.sum;
        self.squares += next.squares;
        self.products += next.products;
        self.ends += next.ends;
        self.last = next.last.or(self.last);
    }

    /// Σ (z_i - z̄)(z_(i+1) - z̄) / Σ (z_i - z̄)²; `None` without values that differ.
    pub(crate) fn lag_one_autocorrelation(&self) -> Option<f64> {
        let n = self.count as f64;
        // About the integer nearest the mean: what remains is small enough for floats.
        let centre = if self.count == 0 { return None } else { self.sum.div_euclid(i128::from(self.count)) };
        let count = i128::from(self.count);
        let sum = (self.sum - count * centre) as f64;
        let squares = (self.squares - centre * (2 * self.sum - count * centre)) as f64;
        let inner = 2 * self.sum - self.ends - self.last.map_or(0, i128::from);
        let pairs = i128::from(self.pairs);
        let products = (self.products - centre * (inner - pairs * centre)) as f64;
        let inner = (inner - 2 * pairs * centre) as f64;
        let mean = sum / n;
        let denominator = squares - sum * mean;
        let numerator = products - mean * inner + self.pairs as f64 * mean * mean;
        (denominator > 0.0).then(|| numerator / denominator)
    }
}

state_bytes::encoded!(LagOneSeries { count, pairs, sum, squares, products, ends, first, last } if |series| {
    // as of any numbers (Cauchy, Schwarz), so that no reading overflows
    let most = I256::from(series.count) * I256::from(series.squares);
    let within = |sum: i128, times: i128| I256::from(sum) * I256::from(sum) <= most * times;
    series.squares >= 0 && series.pairs <= series.count && within(series.sum, 1) && within(series.ends, 4)
        && series.products.abs() <= series.squares
});
state_bytes::encoded!(Level { series, first, last, in_first_row });
state_bytes::encoded!(LagOneSums { block, levels, parted } if |sums| {
    sums.block.is_power_of_two() && sums.block <= LONGEST && sums.levels.len() <= LONGEST.ilog2() as usize + 1
});
