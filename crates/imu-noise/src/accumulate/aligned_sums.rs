//! Sums over blocks of samples on a grid of absolute indices, and what is accumulated of them: the
//! lag-1 autocorrelation at each block length, and the slope of the record.

use ethnum::I256;

/// Samples per block. Shorter blocks would cost more than the octaves do.
pub(crate) const BLOCK: u64 = 64;

/// Cuts a channel into blocks of `block` samples that start at multiples of `block`.
#[derive(Clone, Debug)]
pub(crate) struct AlignedSums {
    block: u64,
    next: u64,
    sum: i64,
    whole: bool,
}

impl AlignedSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, next: 0, sum: 0, whole: true }
    }

    /// `complete` gets the number and the sum of each block that is complete with these samples.
    #[inline]
    pub(crate) fn push(&mut self, mut counts: &[i32], mut complete: impl FnMut(u64, i64)) {
        while !counts.is_empty() {
            let missing = self.block - self.next % self.block;
            let (part, rest) = counts.split_at(counts.len().min(missing as usize));
            counts = rest;
            self.sum += part.iter().map(|&count| i64::from(count)).sum::<i64>();
            self.next += part.len() as u64;
            if part.len() as u64 == missing {
                if self.whole {
                    complete(self.next / self.block - 1, self.sum);
                }
                self.sum = 0;
                self.whole = true;
            }
        }
    }

    /// `None` for an unknown number of missing samples, which starts a new grid.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        self.next = missing.map_or(0, |missing| self.next.wrapping_add(missing));
        self.sum = 0;
        self.whole = self.next.is_multiple_of(self.block);
    }
}

/// Times that block sums are differenced at most, as suits the Allan deviation.
pub(crate) const MAX_DIFFERENCES: usize = 2;

/// Longest blocks, 2^26 samples: then sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004). Shorter blocks would cost as much as all the octaves; there the
/// slope shows the noise type. Neighbours across a gap are no neighbours.
#[derive(Clone, Debug)]
pub(crate) struct LagOneSums {
    block: u64,
    levels: Vec<Level>,
}

#[derive(Clone, Debug, Default)]
struct Level {
    /// By number of differences taken.
    series: [LagOneSeries; MAX_DIFFERENCES + 1],
    /// The first half of a block of the next level.
    half: Option<i64>,
}

impl LagOneSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, levels: Vec::new() }
    }

    #[inline]
    pub(crate) fn push(&mut self, mut number: u64, mut sum: i64) {
        let mut k = 0;
        loop {
            if k == self.levels.len() {
                if self.block << k > LONGEST {
                    return;
                }
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[k];
            let mut value = Some(sum);
            for series in &mut level.series {
                value = value.and_then(|value| series.push(value));
            }
            if number & 1 == 0 {
                level.half = Some(sum);
                return;
            }
            let Some(half) = level.half.take() else { return };
            sum += half;
            number /= 2;
            k += 1;
        }
    }

    pub(crate) fn gap(&mut self) {
        for level in &mut self.levels {
            level.half = None;
            level.series.iter_mut().for_each(LagOneSeries::gap);
        }
    }

    /// By the number of differences taken; `None` for lengths that are not kept.
    pub(crate) fn series(&self, m: u64) -> Option<&[LagOneSeries; MAX_DIFFERENCES + 1]> {
        let level = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        Some(&level.series)
    }
}

/// Sums over the values of a series; products join neighbours within runs without gap.
#[derive(Clone, Debug, Default)]
pub(crate) struct LagOneSeries {
    pub(crate) count: u64,
    pairs: u64,
    sum: i128,
    squares: i128,
    products: i128,
    /// Sum of the first value of every run and of the last one of every run that has ended.
    ends: i128,
    last: Option<i64>,
}

impl LagOneSeries {
    /// The difference to the value before.
    #[inline]
    fn push(&mut self, value: i64) -> Option<i64> {
        let wide = i128::from(value);
        self.count += 1;
        self.sum += wide;
        self.squares += wide * wide;
        let Some(last) = self.last.replace(value) else {
            self.ends += wide;
            return None;
        };
        self.pairs += 1;
        self.products += i128::from(last) * wide;
        Some(value - last)
    }

    fn gap(&mut self) {
        self.ends += self.last.take().map_or(0, i128::from);
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

/// Least-squares line through sums of blocks at their places: as blocks are short against the
/// record, the regression over the samples within its noise.
#[derive(Clone, Debug)]
pub(crate) struct Trend {
    /// Blocks, and sums of their numbers and of the squares of these.
    blocks: i128,
    numbers: i128,
    squares: i128,
    /// Sums of the sums, and of these times their numbers.
    sums: i128,
    products: i128,
    /// Whether all blocks are on one grid.
    one_grid: bool,
}

impl Trend {
    pub(crate) const fn new() -> Self {
        Self { blocks: 0, numbers: 0, squares: 0, sums: 0, products: 0, one_grid: true }
    }

    #[inline]
    pub(crate) fn push(&mut self, number: u64, sum: i64) {
        let (number, sum) = (i128::from(number), i128::from(sum));
        self.blocks += 1;
        self.numbers += number;
        self.squares += number * number;
        self.sums += sum;
        self.products += number * sum;
    }

    pub(crate) fn restart(&mut self) {
        self.one_grid &= self.blocks == 0;
    }

    /// Change per sample, in counts; `None` below three blocks and where the grid was lost.
    pub(crate) fn slope_counts(&self) -> Option<f64> {
        if self.blocks < 3 || !self.one_grid {
            return None;
        }
        let [n, x, y] = [self.blocks, self.numbers, self.sums].map(I256::from);
        let numerator = n * I256::from(self.products) - x * y;
        let denominator = n * I256::from(self.squares) - x * x;
        let block = BLOCK as f64;
        Some(numerator.as_f64() / denominator.as_f64() / (block * block))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope(runs: &[(Option<u64>, Vec<i32>)]) -> Option<f64> {
        let mut aligned = AlignedSums::new(BLOCK);
        let mut trend = Trend::new();
        for (missing, counts) in runs {
            aligned.gap(*missing);
            if missing.is_none() {
                trend.restart();
            }
            aligned.push(counts, |number, sum| trend.push(number, sum));
        }
        trend.slope_counts()
    }

    #[test]
    fn a_line_has_its_slope_with_and_without_gaps() {
        let line = |range: std::ops::Range<i32>| range.map(|i| 3 * i - 70_000).collect::<Vec<_>>();
        assert_eq!(slope(&[(Some(0), line(0..1000))]), Some(3.0));
        assert_eq!(slope(&[(Some(0), line(0..1000)), (Some(500), line(1500..1830))]), Some(3.0));
        assert_eq!(slope(&[(Some(100), line(100..1000)), (Some(1), line(1001..5000))]), Some(3.0));
        assert_eq!(slope(&[(None, line(0..1000)), (None, line(0..1000))]), None);
        assert_eq!(slope(&[(Some(0), line(0..191))]), None);
        assert_eq!(slope(&[(Some(0), vec![5; 1000])]), Some(0.0));
    }
}
