//! Windows with missing samples: each cluster is the mean of the samples that are present.

/// Bits of the fraction of sums of squares and terms.
const FRACTION_BITS: u32 = 16;

/// Bits of the fraction of a share of samples present.
const SHARE_BITS: u32 = 32;

/// Sums over the windows of an octave that miss samples and have half of each cluster at least.
///
/// With n_i of m samples present in cluster i, and w_i = -1, 1 (Allan) or 1, -2, 1 (Hadamard), the
/// difference of block sums is z = m Σ w_i S_i/n_i, and white noise makes it larger than in a whole
/// window: by 1/c, c = Σ w_i² / (m Σ w_i²/n_i), for Allan the harmonic mean of the shares present.
/// So c z² is summed, which white noise leaves unbiased whatever is missing.
///
/// Each window is rounded once, to a multiple of 2^-16 counts² (its c to one of 2^-32): the sums
/// are integers, the same in any order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gapped {
    pub(super) windows: u64,
    shares: u128,
    /// `None` once 128 bits were not enough.
    squares: Option<u128>,
    /// Of c z.
    terms: i128,
}

impl Gapped {
    pub(super) const EMPTY: Self = Self { windows: 0, shares: 0, squares: Some(0), terms: 0 };

    /// One window: sum and number of the samples present in each of its clusters of `m`, which is
    /// at least one.
    pub(super) fn add<const P: usize>(&mut self, m: u64, weights: [i64; P], sums: [i64; P], present: [u64; P]) {
        // over the common denominator, exact: 61 bits of a sum, twice 30 of the other numbers at most
        let others =
            |i: usize| (0..P).filter(|other| *other != i).map(|other| i128::from(present[other])).product::<i128>();
        let numerator: i128 = (0..P).map(|i| i128::from(weights[i]) * i128::from(sums[i]) * others(i)).sum();
        let denominator: f64 = present.iter().map(|present| *present as f64).product();
        let square = |weight: i64| (weight * weight) as f64;
        let [all, over_present] = [
            weights.iter().map(|weight| square(*weight)).sum::<f64>(),
            weights.iter().zip(present).map(|(weight, present)| square(*weight) / present as f64).sum(),
        ];
        let share = all / (m as f64 * over_present);
        let z = m as f64 * (numerator as f64 / denominator);
        self.windows += 1;
        self.shares += fixed(share, SHARE_BITS) as u128;
        let square = fixed(share * z * z, FRACTION_BITS);
        // beyond 127 bits a window is no window of counts
        let square = (square < i128::MAX as f64).then_some(square as u128);
        self.squares = self.squares.zip(square).and_then(|(sum, square)| sum.checked_add(square));
        self.terms = self.terms.saturating_add(fixed(share * z, FRACTION_BITS) as i128);
    }

    /// Of c over the windows.
    pub(super) fn share_sum(&self) -> f64 {
        self.shares as f64 / (1_u64 << SHARE_BITS) as f64
    }

    /// Of c z², in counts²; `None` where that is not known.
    pub(super) fn square_sum(&self) -> Option<f64> {
        self.squares.map(|squares| squares as f64 / f64::from(1 << FRACTION_BITS))
    }

    /// With squares so many times as large, rounded once.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { squares: self.squares.map(|squares| (squares as f64 * factor).round() as u128), ..self }
    }
}

fn fixed(value: f64, bits: u32) -> f64 {
    (value * (1_u64 << bits) as f64).round()
}
