//! The slope of a record, from the sums of its blocks.

use ethnum::I256;

use super::aligned_sums::{AlignedBlock, BLOCK};

/// Least-squares line through the means of blocks, each at the mean place of its samples and with their
/// number as its weight: because blocks are short compared to the record, this equals the regression
/// over the samples within its noise. For a block that misses samples, each sum is rounded once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trend {
    /// Number of present samples, and the sums over them of the place of their block, in half
    /// samples, and of its square.
    samples: i128,
    places: i128,
    squares: I256,
    /// Sums of the sums of the blocks, and of these times the places of their blocks.
    sums: i128,
    products: i128,
    blocks: u64,
    grids: Grids,
}

/// Whether the places of the blocks equal those of the samples, except for a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grids {
    One,
    /// A gap of unknown length precedes the first block.
    LastOf,
    /// Such gaps stand between blocks.
    Several,
}

impl Trend {
    pub(crate) const fn new() -> Self {
        Self { samples: 0, places: 0, squares: I256::ZERO, sums: 0, products: 0, blocks: 0, grids: Grids::One }
    }

    /// One block of [`BLOCK`] samples, at least one of them present.
    #[inline]
    pub(crate) fn push(&mut self, block: AlignedBlock) {
        let middle = i128::from(2 * BLOCK * block.number);
        let [sum, present, distances] = [block.sum, block.present as i64, block.distances].map(i128::from);
        self.blocks += 1;
        self.samples += present;
        self.sums += sum;
        self.places += present * middle + distances;
        let (mut square, mut product) = ((present * middle + 2 * distances) * middle, sum * middle);
        if distances != 0 {
            square += rounded_quotient(distances * distances, present);
            product += rounded_quotient(sum * distances, present);
        }
        self.squares += I256::from(square);
        self.products += product;
    }

    pub(crate) fn restart(&mut self) {
        let has_blocks = self.blocks > 0;
        self.grids = if has_blocks { Grids::Several } else { Grids::LastOf };
    }

    /// Change per sample, in counts; `None` below three blocks and across a gap of unknown length.
    pub(crate) fn slope_counts(&self) -> Option<f64> {
        if self.blocks < 3 || self.grids == Grids::Several {
            return None;
        }
        let [n, x, y] = [self.samples, self.places, self.sums].map(I256::from);
        let numerator = n * I256::from(self.products) - x * y;
        let denominator = n * self.squares - x * x;
        (denominator > I256::ZERO).then(|| 2.0 * numerator.as_f64() / denominator.as_f64())
    }
}

/// The quotient rounded half up, for a divisor above 0: adding an integer to the exact quotient
/// adds it to the result.
fn rounded_quotient(value: i128, divisor: i128) -> i128 {
    (2 * value + divisor).div_euclid(2 * divisor)
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::aligned_sums::AlignedSums;

    fn push(block: AlignedBlock, trend: &mut Trend) {
        if 2 * block.present >= BLOCK {
            trend.push(block);
        }
    }

    fn slope(runs: &[(Option<u64>, Vec<i32>)]) -> Option<f64> {
        let mut aligned = AlignedSums::new(BLOCK);
        let mut trend = Trend::new();
        for (missing, counts) in runs {
            aligned.gap(*missing, |block| push(block, &mut trend));
            if missing.is_none() {
                trend.restart();
            }
            aligned.push(counts, |block| push(block, &mut trend));
        }
        trend.slope_counts()
    }

    #[test]
    fn a_line_has_its_slope_with_and_without_gaps() {
        let line = |range: std::ops::Range<i32>| range.map(|i| 3 * i - 70_000).collect::<Vec<_>>();
        assert_eq!(slope(&[(Some(0), line(0..1000))]), Some(3.0));
        for runs in [
            [(Some(0), line(0..1000)), (Some(500), line(1500..1830))],
            [(Some(100), line(100..1000)), (Some(1), line(1001..5000))],
        ] {
            assert!(slope(&runs).is_some_and(|slope| (slope - 3.0).abs() < 1e-6), "{:?}", slope(&runs));
        }
        assert_eq!(slope(&[(None, line(0..1000)), (None, line(0..1000))]), None);
        assert_eq!(slope(&[(Some(0), line(0..191))]), None);
        assert_eq!(slope(&[(Some(0), vec![5; 1000])]), Some(0.0));
    }
}
