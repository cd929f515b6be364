//! Mean, variance, skewness, kurtosis and extremes, from exact power sums.

use ethnum::I256;
use multiversion::multiversion;

use super::counts;

const BLOCK: usize = 256;

/// Exact moments of a channel in counts, by sums of the first four powers that cannot overflow: for any
/// division of the samples, with a relative error below 1e-12.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moments {
    sums: PowerSums,
    min: i32,
    max: i32,
}

/// Count and sums of c, c², c³, c⁴. With n < 2^63 samples of 32 bits they have 94, 125, 156 and 187 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PowerSums {
    count: u64,
    first: i128,
    second: i128,
    third: I256,
    fourth: I256,
}

impl Moments {
    /// Moments of no sample.
    pub const fn new() -> Self {
        Self { sums: PowerSums::EMPTY, min: i32::MAX, max: i32::MIN }
    }

    /// Adds samples.
    pub fn push(&mut self, counts: &[i32]) {
        for block in counts.chunks(BLOCK) {
            let (sums, min, max) = of_block(block);
            self.sums.add(&sums.unwrap_or_else(|| in_integers(block)));
            (self.min, self.max) = (self.min.min(min), self.max.max(max));
        }
    }

    /// Number of samples n.
    pub const fn count(&self) -> u64 {
        self.sums.count
    }

    /// Smallest sample; `None` without a sample.
    pub fn min_counts(&self) -> Option<i32> {
        (self.count() > 0).then_some(self.min)
    }

    /// Largest sample; `None` without a sample.
    pub fn max_counts(&self) -> Option<i32> {
        (self.count() > 0).then_some(self.max)
    }

    /// Arithmetic mean; `None` without a sample.
    pub fn mean_counts(&self) -> Option<f64> {
        let (centre, centred) = self.centred()?;
        Some(centre as f64 + centred.first as f64 / centred.count as f64)
    }

    /// Sample variance in counts², with the divisor n - 1; `None` below two samples.
    pub fn variance_counts2(&self) -> Option<f64> {
        let (_, centred) = self.centred()?;
        let n = centred.count;
        if n < 2 {
            return None;
        }
        Some(centred.squares_about_mean() / (n - 1) as f64)
    }

    /// Sample standard deviation in counts, exactly 0 for a constant; `None` below two samples.
    pub fn std_counts(&self) -> Option<f64> {
        self.variance_counts2().map(f64::sqrt)
    }

    /// Skewness g1 = m3 / m2^1.5; `None` below two samples and for a constant.
    pub fn skewness(&self) -> Option<f64> {
        let [second, third, _] = self.central_moments()?;
        Some(third / (second * second.sqrt()))
    }

    /// Excess kurtosis g2 = m4 / m2² - 3; `None` below two samples and for a constant.
    pub fn excess_kurtosis(&self) -> Option<f64> {
        let [second, _, fourth] = self.central_moments()?;
        Some(fourth / (second * second) - 3.0)
    }

    /// The integer nearest the mean, and the exact sums about it, which are small enough for floats.
    fn centred(&self) -> Option<(i64, PowerSums)> {
        if self.count() == 0 {
            return None;
        }
        let n = i128::from(self.sums.count);
        // The mean of 32-bit counts has 32 bits.
        let centre = (2 * self.sums.first + n).div_euclid(2 * n) as i64;
        Some((centre, self.sums.about(centre)))
    }

    /// Second to fourth population moment about the mean; `None` for a constant.
    fn central_moments(&self) -> Option<[f64; 3]> {
        let (_, centred) = self.centred()?;
        let n = centred.count as f64;
        let mean = centred.first as f64 / n;
        let second = centred.squares_about_mean() / n;
        if second == 0.0 {
            return None;
        }
        let raw_second = centred.second as f64 / n;
        let raw_third = centred.third.as_f64() / n;
        let raw_fourth = centred.fourth.as_f64() / n;
        let third = raw_third - mean * (3.0 * raw_second - 2.0 * mean * mean);
        let fourth = raw_fourth - mean * (4.0 * raw_third - mean * (6.0 * raw_second - 3.0 * mean * mean));
        Some([second, third, fourth])
    }
}

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}

impl PowerSums {
    const EMPTY: Self = Self { count: 0, first: 0, second: 0, third: I256::ZERO, fourth: I256::ZERO };

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.first += other.first;
        self.second += other.second;
        self.third += other.third;
        self.fourth += other.fourth;
    }

    /// The sums of powers of c - centre: the binomial theorem, term by term.
    fn about(&self, centre: i64) -> Self {
        let shift = -i128::from(centre);
        let wide = I256::from(shift);
        let n = i128::from(self.count);
        let (s1, s2) = (I256::from(self.first), I256::from(self.second));
        let square = wide * wide;
        Self {
            count: self.count,
            first: self.first + n * shift,
            second: (s2 + wide * s1 * 2 + square * n).as_i128(),
            third: self.third + wide * s2 * 3 + square * s1 * 3 + square * wide * n,
            fourth: self.fourth
                + wide * self.third * 4
                + square * s2 * 6
                + square * wide * s1 * 4
                + square * square * n,
        }
    }

    /// Sum of (c - mean)², rounded once: (n s2 - s1²) / n with an exact numerator.
    fn squares_about_mean(&self) -> f64 {
        let first = I256::from(self.first);
        let numerator = I256::from(self.second) * I256::from(self.count) - first * first;
        numerator.as_f64() / self.count as f64
    }
}

/// The sums of [`in_lanes`], and the extremes.
#[multiversion(targets("x86_64+avx2"))]
fn of_block(block: &[i32]) -> (Option<PowerSums>, i32, i32) {
    let min = block.iter().fold(i32::MAX, |min, count| min.min(*count));
    let max = block.iter().fold(i32::MIN, |max, count| max.max(*count));
    (in_lanes(block), min, max)
}

/// The sums about zero of a block whose values lie within 2^21 of the first one, else `None`: exact
/// floats if the fourth stays below [`counts::EXACT_BELOW`], as |d|^k <= d^4 for integers.
#[inline(always)]
fn in_lanes(block: &[i32]) -> Option<PowerSums> {
    let &pivot = block.first()?;
    let mut from_pivot = [0.0_f64; BLOCK];
    let from_pivot = &mut from_pivot[..block.len()];
    for (d, &count) in from_pivot.iter_mut().zip(block) {
        *d = f64::from(count) - f64::from(pivot);
    }
    let d: [&[f64]; 1] = [from_pivot];
    let fourth = counts::lane_sum(d, |[d]| d * d * (d * d));
    let (third, fourth) = if fourth < counts::EXACT_BELOW {
        (exact_sum(d, |[d]| d * d * d), i128::from(fourth as i64))
    } else {
        of_far_values(from_pivot)?
    };
    let sums = [exact_sum(d, |[d]| d), exact_sum(d, |[d]| d * d), third, fourth];
    Some(about_zero(block.len() as u64, pivot, sums))
}

/// The sums of third and fourth powers if all values are below 2^21, else `None`: d² = h 2^20 + l,
/// and the sums of products with h and l are exact.
#[inline(always)]
fn of_far_values(d: &[f64]) -> Option<(i128, i128)> {
    const FARTHEST: f64 = (1 << 21) as f64;
    const SPLIT: f64 = (1 << 20) as f64;
    let (mut high, mut low) = ([0.0_f64; BLOCK], [0.0_f64; BLOCK]);
    let (high, low) = (&mut high[..d.len()], &mut low[..d.len()]);
    let mut all_near = true;
    for ((d, high), low) in d.iter().zip(&mut *high).zip(&mut *low) {
        let square = d * d;
        all_near &= square < FARTHEST * FARTHEST;
        // to the nearest: |l| is at most half of the split, and h 2^22
        *high = (square / SPLIT + counts::ROUND) - counts::ROUND;
        *low = square - *high * SPLIT;
    }
    let (high, low): (&[f64], &[f64]) = (high, low);
    let product = |[a, b]: [f64; 2]| a * b;
    all_near.then(|| {
        let third = (exact_sum([d, high], product) << 20) + exact_sum([d, low], product);
        let of_both = exact_sum([high, low], product);
        (third, (exact_sum([high, high], product) << 40) + (of_both << 21) + exact_sum([low, low], product))
    })
}

/// The sum of terms that are integers, and so few that their sum is below 2^53.
#[inline(always)]
fn exact_sum<const S: usize>(values: [&[f64]; S], term: impl Fn([f64; S]) -> f64) -> i128 {
    i128::from(counts::lane_sum(values, term) as i64)
}

/// The sums about zero, from `sums` of powers of c - pivot.
fn about_zero(count: u64, pivot: i32, sums: [i128; 4]) -> PowerSums {
    let [s1, s2, s3, s4] = sums;
    let p = i128::from(pivot);
    let n = i128::from(count);
    let first = s1 + n * p;
    let second = s2 + p * (2 * s1 + n * p);
    let third = s3 + p * (3 * s2 + p * (3 * s1 + n * p));
    let fourth_by_pivot = 4 * s3 + p * (6 * s2 + p * (4 * s1 + n * p));
    // 103 bits times 32 bits
    let fourth = I256::from(s4) + I256::from(fourth_by_pivot) * I256::from(p);
    PowerSums { count, first, second, third: I256::from(third), fourth }
}

#[cold]
#[inline(never)]
fn in_integers(block: &[i32]) -> PowerSums {
    let mut sums = PowerSums { count: block.len() as u64, ..PowerSums::EMPTY };
    // Seven fourth powers of 31 bits fit in 127 bits.
    for part in block.chunks(7) {
        let mut fourth = 0_i128;
        let mut third = 0_i128;
        for &count in part {
            let square = i64::from(count) * i64::from(count);
            sums.first += i128::from(count);
            sums.second += i128::from(square);
            third += i128::from(square) * i128::from(count);
            fourth += i128::from(square) * i128::from(square);
        }
        sums.third += I256::from(third);
        sums.fourth += I256::from(fourth);
    }
    sums
}
#[cfg(test)]
mod tests;
