//! The covariance of the statistics of a record.

use super::joint::MOST_COMPONENTS;

/// Of all statistics, the lower triangle of a symmetric matrix, row by row.
#[derive(Default)]
pub(super) struct Covariance {
    values: Vec<f64>,
    /// Memory to work in.
    roots: Vec<Roots>,
}

/// By component of the noise: the root of what it adds to the variance of an octave.
pub(super) type Roots = [f64; MOST_COMPONENTS];

impl Covariance {
    /// For so many statistics; what it held is forgotten.
    pub(super) fn resize(&mut self, statistics: usize) {
        self.values.clear();
        self.values.resize(statistics * (statistics + 1) / 2, 0.0);
    }

    /// Zeros to work with for so many octaves, and all rows of these, one behind the other.
    pub(super) fn octaves(&mut self, octaves: usize) -> (&mut [Roots], &mut [f64]) {
        self.roots.clear();
        self.roots.resize(octaves, Roots::default());
        (&mut self.roots, &mut self.values)
    }

    /// Up to the diagonal.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * (i + 1) / 2..][..=i]
    }

    /// Up to the diagonal.
    pub(super) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * (i + 1) / 2..][..=i]
    }

    pub(super) fn variance(&self, i: usize) -> f64 {
        self.row(i)[i]
    }
}
