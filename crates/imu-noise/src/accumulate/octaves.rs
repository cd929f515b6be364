//! Streaming sums of the Allan and Hadamard variance at octave averaging factors.

mod any_factor;
mod cascade;
mod overlapping;
mod squares;

use super::record::{Deviation, Estimator, Octave};
use cascade::Cascade;
use overlapping::Overlapping;

/// Streaming octave sums of one channel of rate data (angular rate, ...), in counts: the same, bit
/// by bit, for any division of the samples over calls of [`push`](Self::push).
#[derive(Clone, Debug)]
pub struct Octaves {
    deviation: Deviation,
    windows: Windows,
}

#[derive(Clone, Debug)]
enum Windows {
    Strided(Cascade),
    Full(Overlapping),
}

/// The exact sum of one octave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctaveSum {
    /// What was squared.
    pub deviation: Deviation,
    /// Averaging factor: samples per block, from 1 to 2^30; of an octave a power of two.
    pub m: u64,
    /// Number of windows n, at least 1.
    pub terms: u64,
    /// Sum of the n squared differences of block sums, in counts². `None` once it needed more than
    /// 128 bits. Strided windows over counts that span 27 bits (±67 rad/s with six decimals) need
    /// 2^40 samples for that at m = 2^30: 870 years at 40 Hz.
    pub sum_squares: Option<u128>,
    /// Sum of the differences in counts; `None` unless asked for by [`Octaves::keeping_slope`].
    pub sum: Option<i128>,
}

impl Octaves {
    /// Sums without any sample.
    #[must_use]
    pub fn new(estimator: Estimator, deviation: Deviation) -> Self {
        let windows = match estimator {
            Estimator::Strided => Windows::Strided(Cascade::new(16, deviation)),
            Estimator::Plain => Windows::Strided(Cascade::new(1, deviation)),
            Estimator::Full => Windows::Full(Overlapping::new(deviation)),
        };
        Self { deviation, windows }
    }

    /// The same, with what [`OctaveSum::without_slope`] needs; costs somewhat more.
    #[must_use]
    pub fn keeping_slope(mut self) -> Self {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.keep_terms(),
            Windows::Full(overlapping) => overlapping.keep_terms(),
        }
        self
    }

    /// The same, with what [`sum_at`](Self::sum_at) needs: with all overlaps, 8 bytes per sample of
    /// the record. The other estimators keep nothing of the kind, and stay as they are.
    #[must_use]
    pub fn keeping_runs(mut self) -> Self {
        if let Windows::Full(overlapping) = &mut self.windows {
            overlapping.keep_runs();
        }
        self
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.push(counts),
            Windows::Full(overlapping) => overlapping.push(counts),
        }
    }

    /// Samples are missing here: no window reaches across. `Some(missing)`: the absolute index of
    /// the next sample is higher by `missing` (0: a break without loss). `None`, an unknown number:
    /// the grid of windows starts anew with the next sample.
    pub fn gap(&mut self, missing: Option<u64>) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.gap(missing),
            Windows::Full(overlapping) => overlapping.gap(),
        }
    }

    /// The octaves that have a window, from m = 1 up; none below two samples (Hadamard: three).
    pub fn sums(&self) -> impl Iterator<Item = OctaveSum> {
        let octave = |k: u32| match &self.windows {
            Windows::Strided(cascade) => cascade.octave(k as usize),
            Windows::Full(overlapping) => overlapping.octave(k as usize),
        };
        let octaves = (0..).map_while(move |k| Some((k, octave(k).filter(|(squares, _)| squares.terms > 0)?)));
        octaves.map(|(k, found)| self.of(1 << k, found))
    }

    /// The sum at any averaging factor, over every window of all overlaps: visits each sample, some
    /// nanoseconds for each. `None` without a window, beyond m = 2^30, and unless
    /// [`keeping_runs`](Self::keeping_runs).
    #[must_use]
    pub fn sum_at(&self, m: u64) -> Option<OctaveSum> {
        match &self.windows {
            Windows::Full(overlapping) => overlapping.at(m).map(|found| self.of(m, found)),
            Windows::Strided(_) => None,
        }
    }

    const fn of(&self, m: u64, (squares, sum): (squares::SquareSum, Option<i128>)) -> OctaveSum {
        OctaveSum { deviation: self.deviation, m, terms: squares.terms, sum_squares: squares.sum, sum }
    }
}

impl OctaveSum {
    /// Averaging factor and windows, what confidence and fit need to know besides the variance.
    #[must_use]
    pub const fn octave(&self) -> Octave {
        Octave { m: self.m, terms: self.terms }
    }

    /// The octave of the same samples without a line of `slope_counts` counts per sample: each
    /// difference of block sums less slope · m², the sum of squares rounded to a whole count².
    /// Unchanged for the Hadamard deviation; with an unknown sum where the differences were not
    /// kept.
    #[must_use]
    pub fn without_slope(self, slope_counts: f64) -> Self {
        if self.deviation == Deviation::Hadamard {
            return self;
        }
        let m = self.m as f64;
        let drift = slope_counts * m * m;
        let less = self.sum.map(|sum| drift * (self.terms as f64 * drift - 2.0 * sum as f64));
        let sum_squares = self.sum_squares.zip(less).map(|(squares, less)| (squares as f64 + less).round() as u128);
        Self { sum_squares, ..self }
    }

    /// Variance in counts²: sum / (c m² n), c = 2 (Allan) or 6 (Hadamard); `None` for an unknown
    /// sum.
    #[must_use]
    pub fn variance_counts2(&self) -> Option<f64> {
        let m = self.m as f64;
        let divisor = self.deviation.divisor() * m * m * self.terms as f64;
        self.sum_squares.map(|sum| sum as f64 / divisor)
    }

    /// Root of the variance. Relative error below 1e-15; `None` for an unknown sum.
    #[must_use]
    pub fn deviation_counts(&self) -> Option<f64> {
        self.variance_counts2().map(f64::sqrt)
    }
}
