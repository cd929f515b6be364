//! Streaming sums of the Allan and Hadamard variance at octave averaging factors.

mod any_factor;
mod cascade;
mod gapped;
mod overlapping;
mod squares;

use super::encoding::{BadEncoding, ByteReader, Encoded};
use super::piece::{Piece, PieceNotAppended};
use super::record::{Deviation, Estimator, Octave};
use cascade::Cascade;
use gapped::Gapped;
use overlapping::Overlapping;
use squares::SquareSum;

/// Of the strided estimator, from there on where the stride grows with the averaging time.
pub(crate) const WINDOWS_PER_TAU: usize = 16;

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

/// The sum of one octave: exact over the windows that miss no sample.
///
/// A window of which some samples are missing, and in each cluster half are present at least, takes
/// part with the means of those present. Its squared difference is multiplied, for n₁ and n₂ of m
/// samples present, by c = (2/m) / (1/n₁ + 1/n₂), Hadamard (6/m) / (1/n₁ + 4/n₂ + 1/n₃), and
/// rounded once, to a multiple of 2^-16 counts². So white noise is not biased, whatever is missing.
/// Of other noise such a window shows less: see [`Octave::share_present`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctaveSum {
    /// What was squared.
    pub deviation: Deviation,
    /// Averaging factor: samples per block, from 1 to 2^30; of an octave a power of two.
    pub m: u64,
    /// Number of windows n, at least 1, those that miss samples included.
    pub terms: u64,
    /// Sum of the squared differences of block sums of the windows that miss none, in counts².
    /// `None` once it needed more than 128 bits. Strided windows over counts that span 27 bits
    /// (±67 rad/s with six decimals) need 2^40 samples for that at m = 2^30: 870 years at 40 Hz.
    pub sum_squares: Option<u128>,
    /// Sum of these differences in counts; `None` unless asked for by [`Octaves::keeping_slope`],
    /// and of the Hadamard deviation.
    pub sum: Option<i128>,
    gapped: Gapped,
}

impl Octaves {
    /// Sums without any sample.
    #[must_use]
    pub fn new(estimator: Estimator, deviation: Deviation) -> Self {
        let windows = match estimator {
            Estimator::Strided => Windows::Strided(Cascade::new(WINDOWS_PER_TAU, deviation)),
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

    /// A piece of a record that begins with the sample at this absolute index. Before any sample.
    #[must_use]
    pub fn starting_at(mut self, index: u64) -> Self {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.start_at(index),
            Windows::Full(overlapping) => overlapping.start_at(index),
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

    /// Samples are missing here. `Some(missing)`: the absolute index of the next sample is higher
    /// by `missing`, and windows reach across where half of each cluster is present (0: a break
    /// without loss, across which none reaches). `None`, an unknown number: no window reaches
    /// across, and in the index it counts as none.
    pub fn gap(&mut self, missing: Option<u64>) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.gap(missing),
            Windows::Full(overlapping) => overlapping.gap(missing),
        }
    }

    /// Appends the piece of the record that follows this one: the same, bit by bit, as one record
    /// of all samples, in any order of appending neighbours. Samples between them are missing.
    ///
    /// # Errors
    /// Where `next` begins before this one ends, or was made with another estimator.
    pub fn append(&mut self, next: &Self) -> Result<(), PieceNotAppended> {
        self.piece().check_follows(next.piece())?;
        match (&mut self.windows, &next.windows) {
            (Windows::Strided(cascade), Windows::Strided(next)) if cascade.is_kind_of(next) => cascade.append(next),
            (Windows::Full(overlapping), Windows::Full(next)) if overlapping.is_kind_of(next) => {
                overlapping.append(next);
            }
            _ => return Err(PieceNotAppended::OtherKind),
        }
        Ok(())
    }

    /// As if each sample were so many counts larger.
    pub(crate) fn shift(&mut self, by: i64) {
        match &mut self.windows {
            Windows::Strided(cascade) => cascade.shift(by),
            Windows::Full(overlapping) => overlapping.shift(by),
        }
    }

    pub(crate) const fn piece(&self) -> &Piece {
        match &self.windows {
            Windows::Strided(cascade) => cascade.piece(),
            Windows::Full(overlapping) => overlapping.piece(),
        }
    }

    /// The octaves that have a window, from m = 1 up; none below two samples (Hadamard: three).
    pub fn sums(&self) -> impl Iterator<Item = OctaveSum> {
        let octave = |k: u32| match &self.windows {
            Windows::Strided(cascade) => cascade.octave(k as usize),
            Windows::Full(overlapping) => {
                overlapping.octave(k as usize).map(|(squares, terms)| (squares, Gapped::EMPTY, terms))
            }
        };
        let octaves = (0..).map_while(move |k| Some(self.of(1 << k, octave(k)?)));
        octaves.filter(|sum| sum.terms > 0)
    }

    /// The sum at any averaging factor, over every window of all overlaps: visits each sample, some
    /// nanoseconds for each. `None` without a window, beyond m = 2^30, and unless
    /// [`keeping_runs`](Self::keeping_runs).
    #[must_use]
    pub fn sum_at(&self, m: u64) -> Option<OctaveSum> {
        match &self.windows {
            Windows::Full(overlapping) => {
                overlapping.at(m).map(|(squares, sum)| self.of(m, (squares, Gapped::EMPTY, sum)))
            }
            Windows::Strided(_) => None,
        }
    }

    const fn of(&self, m: u64, (squares, gapped, sum): (SquareSum, Gapped, Option<i128>)) -> OctaveSum {
        let terms = squares.terms + gapped.windows;
        OctaveSum { deviation: self.deviation, m, terms, sum_squares: squares.sum, sum, gapped }
    }
}

impl OctaveSum {
    /// Averaging factor and windows, what confidence and fit need to know besides the variance.
    #[must_use]
    pub fn octave(&self) -> Octave {
        let whole = self.whole_terms();
        let share_present = (whole as f64 + self.gapped.share_sum()) / self.terms as f64;
        Octave { m: self.m, terms: self.terms, share_present }
    }

    /// Adds the windows of another record in the same octave, counts of the same size.
    pub fn append(&mut self, other: &Self) {
        let add = |(ours, theirs): (u128, u128)| ours.checked_add(theirs);
        self.terms += other.terms;
        self.sum_squares = self.sum_squares.zip(other.sum_squares).and_then(add);
        self.sum = self.sum.zip(other.sum).map(|(ours, theirs)| ours + theirs);
        self.gapped.append(&other.gapped);
    }

    /// Number of the windows that miss no sample, those of [`sum_squares`](Self::sum_squares).
    #[must_use]
    pub const fn whole_terms(&self) -> u64 {
        self.terms - self.gapped.windows
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
        let whole = self.whole_terms() as f64;
        let less = self.sum.map(|sum| drift * (whole * drift - 2.0 * sum as f64));
        let sum_squares = self.sum_squares.zip(less).map(|(squares, less)| (squares as f64 + less).round() as u128);
        Self { sum_squares, gapped: self.gapped.without_drift(drift), ..self }
    }

    /// The octave with another variance, as without what the temperature made of it: the sum of
    /// squares rounded to a whole count².
    #[must_use]
    pub fn with_variance_counts2(self, variance: f64) -> Self {
        let factor = self.variance_counts2().map_or(1.0, |own| if own > 0.0 { variance / own } else { 1.0 });
        let sum_squares = self.sum_squares.map(|squares| (squares as f64 * factor).round() as u128);
        Self { sum_squares, gapped: self.gapped.scaled(factor), ..self }
    }

    /// Variance in counts²: the sum over all windows / (2 m² n), for Hadamard / (6 m² n); `None`
    /// for an unknown sum.
    #[must_use]
    pub fn variance_counts2(&self) -> Option<f64> {
        let m = self.m as f64;
        let divisor = self.deviation.divisor() * m * m * self.terms as f64;
        self.sum_squares.zip(self.gapped.square_sum()).map(|(whole, gapped)| (whole as f64 + gapped) / divisor)
    }

    /// Root of the variance. Relative error below 1e-15; `None` for an unknown sum.
    #[must_use]
    pub fn deviation_counts(&self) -> Option<f64> {
        self.variance_counts2().map(f64::sqrt)
    }
}

impl Encoded for Octaves {
    fn encode(&self, out: &mut Vec<u8>) {
        match &self.windows {
            Windows::Strided(cascade) => {
                out.push(0);
                cascade.encode(out);
            }
            Windows::Full(overlapping) => {
                out.push(1);
                overlapping.encode(out);
            }
        }
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        match bool::decode(input)? {
            false => {
                let cascade = Cascade::decode(input)?;
                Ok(Self { deviation: cascade.deviation(), windows: Windows::Strided(cascade) })
            }
            true => {
                let overlapping = Overlapping::decode(input)?;
                Ok(Self { deviation: overlapping.deviation, windows: Windows::Full(overlapping) })
            }
        }
    }
}
