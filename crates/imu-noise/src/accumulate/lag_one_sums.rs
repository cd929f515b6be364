//! The lag-1 autocorrelation of block sums at each block length, which shows the kind of noise.

/// The most times that block sums are differenced, as needed for the Allan deviation.
pub(crate) const MAX_DIFFERENCES: usize = 2;

/// Longest blocks, 2^26 samples: with these, sums cannot overflow in years of full-scale data.
const LONGEST: u64 = 1 << 26;

/// Streaming lag-1 autocorrelation of adjacent block sums, at block lengths of 64, 128, ... samples
/// (Riley and Greenhall, 2004). Shorter blocks would cost as much as all octaves; at those lengths
/// the slope shows the noise type. Blocks with missing samples are not used.
#[derive(Clone, Debug)]
pub(crate) struct LagOneSums {
    pub(crate) block: u64,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    /// The series, by number of differences taken.
    series: [LagOneSeries; MAX_DIFFERENCES + 1],
    /// Number of the last block of the present run.
    last: Option<u64>,
}

impl LagOneSums {
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, levels: Vec::new() }
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

    /// Neighbours across a break do not count as neighbours.
    pub(crate) fn part(&mut self) {
        self.levels.iter_mut().for_each(Level::part);
    }

    /// The level `k`; `None` for blocks longer than the longest.
    fn level(&mut self, k: usize) -> Option<&mut Level> {
        if k >= self.levels.len() {
            if self.block << k > LONGEST {
                return None;
            }
            self.levels.push(Level::new());
        }
        self.levels.get_mut(k)
    }

    /// The series, by the number of differences taken; `None` for lengths that are not kept.
    pub(crate) fn series(&self, m: u64) -> Option<&[LagOneSeries; MAX_DIFFERENCES + 1]> {
        let level = self.levels.get((m / self.block).checked_ilog2()? as usize).filter(|_| m.is_power_of_two())?;
        Some(&level.series)
    }
}

impl Level {
    fn new() -> Self {
        Self { series: Default::default(), last: None }
    }

    /// Returns the sum of the block before, if it is a neighbour.
    #[inline]
    fn push(&mut self, number: u64, sum: i64) -> Option<i64> {
        if self.last.is_some_and(|last| last + 1 != number) {
            self.part();
        }
        self.last = Some(number);
        let before = self.series[0].last;
        let mut value = Some(sum);
        for series in &mut self.series {
            value = value.and_then(|value| series.push(value));
        }
        before
    }

    fn part(&mut self) {
        self.series.iter_mut().for_each(LagOneSeries::end_run);
        self.last = None;
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
    /// Adds a value; returns its difference to the value before.
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

    fn end_run(&mut self) {
        self.ends += self.last.take().map_or(0, i128::from);
    }

    /// Σ (z_i - z̄)(z_(i+1) - z̄) / Σ (z_i - z̄)²; `None` without values that differ.
    pub(crate) fn lag_one_autocorrelation(&self) -> Option<f64> {
        let n = self.count as f64;
        // Sums about the integer nearest the mean are small enough for floats.
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
