//! The slope of a channel over its record, by linear regression on exact sums.

use ethnum::I256;

/// Least-squares line through sums of blocks at their places.
///
/// Because blocks are short against the record, this is the regression over the samples within its
/// noise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trend {
    block: u64,
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
    /// For blocks of `block` samples.
    pub(crate) const fn new(block: u64) -> Self {
        Self { block, blocks: 0, numbers: 0, squares: 0, sums: 0, products: 0, one_grid: true }
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

    /// A new grid starts after an unknown number of missing samples.
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
        let block = self.block as f64;
        Some(numerator.as_f64() / denominator.as_f64() / (block * block))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::aligned::{AlignedSums, BLOCK};

    fn slope(runs: &[(Option<u64>, Vec<i32>)]) -> Option<f64> {
        let mut aligned = AlignedSums::new(BLOCK);
        let mut trend = Trend::new(BLOCK);
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
