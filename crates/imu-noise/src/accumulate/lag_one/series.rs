//! Exact sums for the lag-1 autocorrelation of a series that may have gaps.

/// Sums over the values of a series; products join neighbours within runs without gap.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    count: u64,
    pairs: u64,
    sum: i128,
    squares: i128,
    products: i128,
    /// Sum of the first value of every run and of the last one of every run that has ended.
    ends: i128,
    last: Option<i64>,
}

impl Series {
    /// Adds a value; returns the difference to the one before.
    #[inline]
    pub(crate) fn push(&mut self, value: i64) -> Option<i64> {
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

    /// The next value is no neighbour of the last one.
    pub(crate) fn gap(&mut self) {
        self.ends += self.last.take().map_or(0, i128::from);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
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
