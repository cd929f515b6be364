//! Streaming sums of the Allan and Hadamard variance at octave averaging factors.

mod cascade;
mod gapped;
mod overlapping;
mod remembered;
mod squares;
pub(crate) mod window_plan;

use super::record::{Deviation, Estimator, Octave};
use super::stretch::Stretch;
use cascade::Cascade;
use gapped::Gapped;
use overlapping::Overlapping;
use squares::SquareSum;
use window_plan::WindowPlans;

/// Windows per averaging time of the strided estimator, for averaging times whose stride grows with them.
pub(crate) const WINDOWS_PER_TAU: usize = 16;

/// Streaming octave sums of one channel of rate data (angular rate, ...), in counts. The result is
/// the same, bit by bit, for any division of the samples over calls of [`push`](Self::push).
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

/// The sum of one octave, which is exact over the windows without missing samples.
///
/// A window with missing samples is used if at least half of the samples of each cluster are
/// present: each cluster is then the mean of the present ones. The squared difference is
/// multiplied, for n₁ and n₂ of m samples present, by c = (2/m) / (1/n₁ + 1/n₂), for Hadamard by
/// (6/m) / (1/n₁ + 4/n₂ + 1/n₃), and rounded once, to a multiple of 2^-16 counts². So the variance
/// of white noise is unbiased for any missing samples. Other noise is underestimated by such a
/// window: see [`Octave::share_present`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctaveSum {
    /// The deviation: the kind of difference that was squared.
    pub deviation: Deviation,
    /// Averaging factor: samples per cluster, from 1 to 2^30; a power of two for an octave.
    pub m: u64,
    /// Number of windows n, at least 1, including those with missing samples.
    pub terms: u64,
    /// Sum of the squared differences of cluster sums over the windows without missing samples, in
    /// counts². `None` beyond 128 bits: after centuries of samples that span 27 bits.
    pub sum_squares: Option<u128>,
    gapped: Gapped,
}

impl Octaves {
    /// Sums without any sample.
    pub fn new(estimator: Estimator, deviation: Deviation) -> Self {
        let windows = match estimator {
            Estimator::Strided => Windows::Strided(Cascade::new(WINDOWS_PER_TAU, deviation)),
            Estimator::Plain => Windows::Strided(Cascade::new(1, deviation)),
            Estimator::Full => Windows::Full(Overlapping::new(deviation)),
        };
        Self { deviation, windows }
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, counts: &[i32]) {
        for counts in counts.chunks(Stretch::MOST) {
            self.push_stretch(counts, &Stretch::full(counts.len()), &mut WindowPlans::new());
        }
    }

    /// Adds the samples of a stretch, in time order: like [`push`](Self::push) of its runs and
    /// [`gap`](Self::gap) between them. `plans` are for all channels of the stretch.
    pub fn push_stretch(&mut self, counts: &[i32], stretch: &Stretch, plans: &mut WindowPlans) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.push(counts, stretch, plans),
            Windows::Full(overlapping) => {
                for (missing, run) in stretch.runs_of(counts) {
                    if missing > 0 {
                        overlapping.gap();
                    }
                    overlapping.push(run);
                }
            }
        }
    }

    /// Adds a gap. `Some(missing)`: the absolute index of the next sample is higher by `missing`, and
    /// windows span the gap if half of each cluster is present; none spans 0, a break without loss.
    /// `None`, an unknown number: no window spans the gap, and the index does not change.
    pub fn gap(&mut self, missing: Option<u64>) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.gap(missing),
            Windows::Full(overlapping) => overlapping.gap(),
        }
    }

    /// The octaves that have a window, from m = 1 upwards.
    pub fn sums(&self) -> impl Iterator<Item = OctaveSum> {
        let octave = |k: u32| match &self.windows {
            Windows::Strided(cascade) => cascade.octave(k as usize),
            Windows::Full(overlapping) => overlapping.octave(k as usize).map(|squares| (squares, Gapped::EMPTY)),
        };
        let octaves = (0..).map_while(move |k| Some(self.of(1 << k, octave(k)?)));
        octaves.filter(|sum| sum.terms > 0)
    }

    /// The sum at any averaging factor, over all overlapping windows. `None` without a window, beyond
    /// m = 2^30, and with other estimators than [`Estimator::Full`].
    pub fn sum_at(&self, m: u64) -> Option<OctaveSum> {
        match &self.windows {
            Windows::Full(overlapping) => overlapping.at(m).map(|squares| self.of(m, (squares, Gapped::EMPTY))),
            Windows::Strided(_) => None,
        }
    }

    const fn of(&self, m: u64, (squares, gapped): (SquareSum, Gapped)) -> OctaveSum {
        let terms = squares.terms + gapped.windows;
        OctaveSum { deviation: self.deviation, m, terms, sum_squares: squares.sum, gapped }
    }
}

impl OctaveSum {
    /// Averaging factor and number of windows.
    pub fn octave(&self) -> Octave {
        let whole = self.whole_terms();
        let share_present = (whole as f64 + self.gapped.share_sum()) / self.terms as f64;
        Octave { m: self.m, terms: self.terms, share_present }
    }

    /// Number of windows without missing samples, which are in [`sum_squares`](Self::sum_squares).
    pub const fn whole_terms(&self) -> u64 {
        self.terms - self.gapped.windows
    }

    /// Allan variance in counts², the sum over all windows / (2 m² n); Hadamard variance, / (6 m²
    /// n). `None` if the sum is unknown.
    pub fn variance_counts2(&self) -> Option<f64> {
        let m = self.m as f64;
        let divisor = self.deviation.divisor() * m * m * self.terms as f64;
        self.sum_squares.zip(self.gapped.square_sum()).map(|(whole, gapped)| (whole as f64 + gapped) / divisor)
    }

    /// Root of the variance, in counts, to 1e-15; `None` if the sum is unknown.
    pub fn deviation_counts(&self) -> Option<f64> {
        self.variance_counts2().map(f64::sqrt)
    }
}
