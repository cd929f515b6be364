//! The shape of a record: its windows, its deviation, its octaves.

use schemars::JsonSchema;
use serde::Serialize;

/// Which windows of m samples are in the sums: those that start at absolute indices that are
/// multiples of the stride s. Of N samples without a gap these are n windows (d = 2 for Allan, 3
/// for Hadamard).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// 16 windows per averaging time, s = max(1, m/16), n = floor((N - d m)/s) + 1. Bounded memory.
    /// All overlaps for m <= 16, and at least 99.5 % of the degrees of freedom of all overlaps
    /// above, for white, flicker and random-walk noise of a rate.
    #[default]
    Strided,
    /// The textbook non-overlapping estimator, s = m, n = floor(N/m) - d + 1. Bounded memory.
    Plain,
    /// All overlaps, s = 1, n = N - d m + 1: the overlapping Allan deviation. 8 bytes per sample.
    Full,
}

/// Which difference of cluster sums is squared, and so which slow changes drop out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Deviation {
    /// B2 - B1 of adjacent sums of m samples. Removes a constant. Allan (1966).
    #[default]
    Allan,
    /// B3 - 2 B2 + B1. Removes a linear drift as well. Baugh (1971).
    Hadamard,
}

impl Deviation {
    pub(crate) const fn order(self) -> usize {
        match self {
            Self::Allan => 2,
            Self::Hadamard => 3,
        }
    }

    /// Weights of successive cluster sums in the difference; 0 for a missing third one.
    pub(crate) const fn weights(self) -> [i64; 3] {
        match self {
            Self::Allan => [-1, 1, 0],
            Self::Hadamard => [1, -2, 1],
        }
    }

    /// Factor c of variance = sum / (c m² n), the sum of the squared weights (Riley, NIST SP 1065, 2008,
    /// eq. 10, 11 and 16).
    pub(crate) const fn divisor(self) -> f64 {
        let [a, b, c] = self.weights();
        (a * a + b * b + c * c) as f64
    }
}

/// One octave of a record, for any channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octave {
    /// Averaging factor: samples per cluster, a power of two.
    pub m: u64,
    /// Number of windows: squared differences in the variance.
    pub terms: u64,
    /// Mean over the windows of the fraction of present samples (the harmonic mean of the clusters), 1
    /// if none is missing. White noise does not depend on it; noise with the variance V without gaps
    /// shows share · V + (1 - share) · S²/m, with the expected sample variance S² within m samples:
    /// exactly if each sample of a cluster is equally likely to be missing. If samples are missing in
    /// runs as long as a cluster, a random walk shows up to 3 % more or less (30 % missing).
    pub share_present: f64,
}

impl Octave {
    /// An octave without missing samples.
    pub const fn whole(m: u64, terms: u64) -> Self {
        Self { m, terms, share_present: 1.0 }
    }

    /// The expected variance of noise that would show the variance `whole` without missing samples: the
    /// Allan variances at half of m, a quarter, ... sum to twice the variance within m samples.
    pub(crate) fn expected(&self, whole: f64, allan_variance: impl Fn(u64) -> f64) -> f64 {
        if self.share_present == 1.0 {
            return whole;
        }
        let shorter = (0..self.m.ilog2()).map(|k| allan_variance(1 << k));
        // S²/m: m samples have m - 1 degrees of freedom
        let within = shorter.sum::<f64>() / 2.0 / (self.m - 1) as f64;
        self.share_present * whole + (1.0 - self.share_present) * within
    }
}

/// Length, interval and windows of a record: the common properties of the octaves of all channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordShape {
    /// Number of samples from the first to the last, including missing ones.
    pub samples: u64,
    /// Time between samples, in seconds, above 0.
    pub interval_s: f64,
    /// The windows that are in the sums.
    pub estimator: Estimator,
    /// The kind of difference that was squared.
    pub deviation: Deviation,
}

impl RecordShape {
    /// Samples between the starts of successive windows at averaging factor `m`.
    pub const fn stride(&self, m: u64) -> u64 {
        match self.estimator {
            Estimator::Strided if m >= 16 => m / 16,
            Estimator::Strided | Estimator::Full => 1,
            Estimator::Plain => m,
        }
    }

    /// Number of windows of averaging factor `m` if no sample is missing; 0 if none fits.
    pub const fn windows(&self, m: u64) -> u64 {
        let span = m.saturating_mul(self.deviation.order() as u64);
        if m == 0 || self.samples < span { 0 } else { (self.samples - span) / self.stride(m) + 1 }
    }

    /// Every octave with a window, at m = 1, 2, 4 …, if no sample is missing; empty if none fits.
    pub fn octaves(&self) -> Vec<Octave> {
        (0..u64::BITS)
            .map(|power| 1_u64 << power)
            .map(|m| Octave::whole(m, self.windows(m)))
            .take_while(|octave| octave.terms > 0)
            .collect()
    }

    /// The number of windows, relative to the number if no sample were missing.
    pub(crate) fn share_of_windows(&self, octave: &Octave) -> f64 {
        (octave.terms as f64 / self.windows(octave.m).max(1) as f64).min(1.0)
    }
}
