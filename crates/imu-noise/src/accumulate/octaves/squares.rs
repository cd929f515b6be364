//! Exact sums of squares: floating-point lanes where provably exact, else 128 bits.

use crate::accumulate::counts::{EXACT_BELOW, ROUND, lane_sum};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SquareSum {
    pub(super) terms: u64,
    /// `None` if 128 bits were not enough.
    pub(super) sum: Option<u128>,
}

impl SquareSum {
    pub(super) const EMPTY: Self = Self { terms: 0, sum: Some(0) };

    /// Adds the squares of `z` at each place of the slices of `points`, which are equally long.
    #[inline(always)]
    pub(super) fn add<const P: usize>(&mut self, windows: u64, points: [&[i64]; P], z: impl Fn([i64; P]) -> i64) {
        self.terms += windows;
        let squares = match in_lanes(points, &z) {
            Some(sum) => Some(sum.into()),
            None => in_128_bits(points, &z),
        };
        self.sum = self.sum.zip(squares).and_then(|(sum, squares)| sum.checked_add(squares));
    }
}

/// The sum if it is below 2^53, else `None`; [`to_f64`] turns integers beyond 2^51 into numbers at
/// least that large, or into NaN, which gives `None` as well.
#[inline(always)]
fn in_lanes<const P: usize>(points: [&[i64]; P], z: &impl Fn([i64; P]) -> i64) -> Option<u64> {
    let sum = lane_sum(points, |points| {
        let value = to_f64(z(points));
        value * value
    });
    (sum < EXACT_BELOW).then_some(sum as u64)
}

/// `z` as `f64`, exact for |z| < 2^51 and monotonic (or NaN) beyond. The default x86-64 target has
/// no vector instruction for this conversion, but one for additions.
#[inline(always)]
fn to_f64(z: i64) -> f64 {
    // adding a small integer to the bits adds it to the value
    f64::from_bits(ROUND.to_bits().wrapping_add(z as u64)) - ROUND
}

#[cold]
#[inline(never)]
fn in_128_bits<const P: usize>(points: [&[i64]; P], z: &impl Fn([i64; P]) -> i64) -> Option<u128> {
    (0..points[0].len()).try_fold(0_u128, |sum, i| {
        let magnitude = u128::from(z(points.map(|point| point[i])).unsigned_abs());
        sum.checked_add(magnitude * magnitude)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn integers_beyond_the_lanes_are_not_confused_with_small_ones() {
        for exponent in 51..64 {
            for offset in -3_i64..=3 {
                for sign in [1_i64, -1] {
                    let z = (1_i64 << (exponent % 63)).wrapping_mul(sign).wrapping_add(offset);
                    if z.unsigned_abs() >= 1 << 27 {
                        assert_eq!(in_lanes([&[z]], &|[z]| z), None, "{z}");
                    }
                }
            }
        }
        assert_eq!(in_lanes([&[i64::MIN]], &|[z]| z), None);
        assert_eq!(in_lanes([&[i64::MAX]], &|[z]| z), None);
    }

    #[test]
    fn a_sum_beyond_128_bits_is_unknown() {
        let mut sum = SquareSum::EMPTY;
        sum.add(3, [&[i64::MIN; 3]], |[z]| z);
        assert_eq!(sum, SquareSum { terms: 3, sum: Some(3 << 126) });
        sum.add(1, [&[i64::MIN]], |[z]| z);
        assert_eq!(sum, SquareSum { terms: 4, sum: None });
    }

    proptest! {
        #[test]
        fn lanes_and_128_bits_agree(
            bits in 1_u32..64,
            values in proptest::collection::vec(any::<i64>(), 0..40),
        ) {
            let z = |[value]: [i64; 1]| value >> (63 - bits);
            let wide = in_128_bits([&values], &z);
            if let Some(sum) = in_lanes([&values], &z) {
                prop_assert_eq!(Some(u128::from(sum)), wide);
            } else {
                prop_assert!(wide.is_none_or(|sum| sum >= 1 << 53));
            }
        }
    }
}
