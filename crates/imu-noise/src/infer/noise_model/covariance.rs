//! The covariance of the statistics of a record.

/// Of all statistics, the lower triangle of a symmetric matrix, row by row.
pub(super) struct Covariance {
    values: Vec<f64>,
}

impl Covariance {
    pub(super) fn new(statistics: usize) -> Self {
        Self { values: vec![0.0; statistics * (statistics + 1) / 2] }
    }

    /// Up to the diagonal.
    pub(super) fn row(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * (i + 1) / 2..][..=i]
    }

    pub(super) fn variance(&self, i: usize) -> f64 {
        self.between(i, i)
    }

    /// Of statistic `i` and one up to it.
    pub(super) fn between(&self, i: usize, j: usize) -> f64 {
        self.values[i * (i + 1) / 2 + j]
    }
}
