//! Windows with missing samples: each cluster is the mean of its present samples.

use crate::accumulate::counts::EXACT_BELOW;

/// Bits of the fraction of sums of squares.
const FRACTION_BITS: u32 = 16;

/// Bits of the fraction of a share of present samples.
const SHARE_BITS: u32 = 32;

/// Sums over the windows of an octave that miss samples and have at least half of each cluster.
///
/// With n_i of m samples present in cluster i, and w_i = -1, 1 (Allan) or 1, -2, 1 (Hadamard), white
/// noise makes the difference z = m Σ w_i S_i/n_i larger by 1/c than in a whole window, with
/// c = Σ w_i² / (m Σ w_i²/n_i). So c z² is summed, each rounded once to a multiple of 2^-16 counts²
/// (its c to one of 2^-32): integers, the same in any order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gapped {
    pub(super) windows: u64,
    shares: u128,
    /// `None` if 128 bits were not enough.
    squares: Option<u128>,
}

/// The part of such a window that does not depend on the values of samples.
#[derive(Clone, Debug)]
pub(super) struct GappedWindow {
    /// Its place among the windows of its octave.
    place: usize,
    /// The number n_i of present samples of each cluster; 1 for the third cluster of Allan windows.
    present: [u32; 3],
    /// w_i times the other two of these numbers.
    factors: [f64; 3],
    /// The product of all three numbers.
    denominator: f64,
    /// c m² 2^16.
    scale: f64,
    /// c, in multiples of 2^-32.
    share: u64,
}

impl GappedWindow {
    /// A window of clusters of `m`, by its place and the number of present samples in each cluster,
    /// which is at least one.
    pub(super) fn new(m: u32, weights: [i64; 3], place: usize, present: [u32; 3]) -> Self {
        let square = |weight: i64| (weight * weight) as f64;
        let all = weights.into_iter().map(square).sum::<f64>();
        let over_present =
            weights.iter().zip(present).map(|(weight, present)| square(*weight) / f64::from(present)).sum::<f64>();
        let share = all / (f64::from(m) * over_present);
        let [a, b, c] = present.map(f64::from);
        let [first, second, third] = weights.map(|weight| weight as f64);
        Self {
            place,
            present,
            factors: [first * (b * c), second * (a * c), third * (a * b)],
            denominator: a * b * c,
            scale: share * f64::from(m).powi(2) * f64::from(1 << FRACTION_BITS),
            share: (share * (1_u64 << SHARE_BITS) as f64).round() as u64,
        }
    }

    /// c z² for this numerator of z/m.
    #[inline(always)]
    fn square(&self, numerator: f64) -> f64 {
        let quotient = numerator / self.denominator;
        (self.scale * quotient * quotient).round()
    }
}

impl Gapped {
    pub(super) const EMPTY: Self = Self { windows: 0, shares: 0, squares: Some(0) };

    /// Adds windows: `clusters` are the sums of the present samples in the first cluster of each
    /// window, in the second, and for Hadamard windows in the third.
    #[inline(always)]
    pub(super) fn add<const P: usize>(&mut self, windows: &[GappedWindow], weights: [i64; 3], clusters: [&[i64]; P]) {
        let (mut shares, mut squares, mut magnitudes) = (0_u64, 0.0_f64, 0.0_f64);
        for window in windows {
            let mut numerator = 0.0;
            for (cluster, factor) in clusters.iter().zip(window.factors) {
                let term = cluster[window.place] as f64 * factor;
                numerator += term;
                magnitudes += term.abs();
            }
            squares += window.square(numerator);
            shares += window.share;
        }
        // integers below 2^53 are exact in every step
        let is_exact = magnitudes < EXACT_BELOW && squares < EXACT_BELOW;
        let squares = if is_exact { Some(squares as u128) } else { in_128_bits(windows, weights, clusters) };
        self.windows += windows.len() as u64;
        self.shares += u128::from(shares);
        self.squares = self.squares.zip(squares).and_then(|(sum, squares)| sum.checked_add(squares));
    }

    /// The sum of c over the windows.
    pub(super) fn share_sum(&self) -> f64 {
        self.shares as f64 / (1_u64 << SHARE_BITS) as f64
    }

    /// The sum of c z², in counts²; `None` if it is not known.
    pub(super) fn square_sum(&self) -> Option<f64> {
        self.squares.map(|squares| squares as f64 / f64::from(1 << FRACTION_BITS))
    }
}

/// The sum of squares, each with an exact numerator of 121 bits.
#[cold]
#[inline(never)]
fn in_128_bits<const P: usize>(windows: &[GappedWindow], weights: [i64; 3], clusters: [&[i64]; P]) -> Option<u128> {
    windows.iter().try_fold(0_u128, |sum, window| {
        let all = window.present.iter().map(|present| i128::from(*present)).product::<i128>();
        let terms = clusters.iter().zip(weights).zip(window.present).map(|((cluster, weight), present)| {
            i128::from(weight) * i128::from(cluster[window.place]) * (all / i128::from(present))
        });
        let square = window.square(terms.sum::<i128>() as f64);
        // a window beyond 127 bits is no window of counts
        (square < i128::MAX as f64).then_some(square as u128).and_then(|square| sum.checked_add(square))
    })
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;
    use crate::accumulate::record::Deviation;

    /// c and c z² of one window, by their definition.
    fn defined(m: u64, weights: &[i64], sums: &[i64], present: &[u64]) -> (u128, Option<u128>) {
        let others = |i: usize| {
            let others = present.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, present)| i128::from(*present)).product::<i128>()
        };
        let numerator: i128 =
            (0..weights.len()).map(|i| i128::from(weights[i]) * i128::from(sums[i]) * others(i)).sum();
        let denominator: f64 = present.iter().map(|present| *present as f64).product();
        let square = |weight: i64| (weight * weight) as f64;
        let all = weights.iter().map(|weight| square(*weight)).sum::<f64>();
        let over_present: f64 = weights.iter().zip(present).map(|(w, present)| square(*w) / *present as f64).sum();
        let share = all / (m as f64 * over_present);
        let z = m as f64 * (numerator as f64 / denominator);
        let fixed = |value: f64, bits: u32| (value * (1_u64 << bits) as f64).round();
        let square = fixed(share * z * z, FRACTION_BITS);
        (fixed(share, SHARE_BITS) as u128, (square < i128::MAX as f64).then_some(square as u128))
    }

    proptest! {
        #[test]
        fn windows_added_together_are_those_of_the_definition(
            deviation in prop_oneof![Just(Deviation::Allan), Just(Deviation::Hadamard)],
            k in 1_u32..=30,
            bits in 1_u32..62,
            windows in vec((any::<[i64; 3]>(), any::<[u32; 3]>()), 0..200),
        ) {
            let (m, order, weights) = (1_u32 << k, deviation.order(), deviation.weights());
            let (mut shared, mut clusters) = (Vec::new(), [vec![], vec![], vec![]]);
            let mut expected = Gapped::EMPTY;
            for (place, (sums, missing)) in windows.iter().enumerate() {
                let sums = sums.map(|sum| sum >> (63 - bits));
                let mut present = missing.map(|missing| m - missing % (m / 2 + 1));
                let (share, square) =
                    defined(m.into(), &weights[..order], &sums[..order], &present.map(u64::from)[..order]);
                expected.windows += 1;
                expected.shares += share;
                expected.squares = expected.squares.zip(square).and_then(|(sum, square)| sum.checked_add(square));
                present[order..].fill(1);
                shared.push(GappedWindow::new(m, weights, place, present));
                clusters.iter_mut().zip(sums).for_each(|(cluster, sum)| cluster.push(sum));
            }
            let [a, b, c] = &clusters;
            let mut found = Gapped::EMPTY;
            match deviation {
                Deviation::Allan => found.add(&shared, weights, [a, b]),
                Deviation::Hadamard => found.add(&shared, weights, [a, b, c]),
            }
            prop_assert_eq!(found, expected);
        }
    }
}
