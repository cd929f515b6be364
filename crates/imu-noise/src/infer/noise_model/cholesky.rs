//! Cholesky's factor of a symmetric positive matrix, scaled so that its diagonal is 1.

use crate::accumulate::counts::dot;

#[derive(Debug)]
pub(super) struct Cholesky {
    size: usize,
    /// By row, lower left.
    factor: Vec<f64>,
    scale: Vec<f64>,
}

impl Cholesky {
    /// `None` where the matrix is as good as singular.
    pub(super) fn new(size: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let scale: Vec<f64> = (0..size).map(|i| 1.0 / entry(i, i).sqrt()).collect();
        let mut factor = vec![0.0; size * size];
        for i in 0..size {
            let (above, row) = factor.split_at_mut(i * size);
            for j in 0..i {
                let rest = entry(i, j) * scale[i] * scale[j] - dot(&row[..j], &above[j * size..][..j]);
                row[j] = rest / above[j * size + j];
            }
            let rest = entry(i, i) * scale[i] * scale[i] - dot(&row[..i], &row[..i]);
            if rest.is_nan() || rest < 1e-11 {
                return None;
            }
            row[i] = rest.sqrt();
        }
        Some(Self { size, factor, scale })
    }

    /// What the matrix makes `right` of.
    pub(super) fn solve(&self, mut right: Vec<f64>) -> Vec<f64> {
        let Self { size, factor, scale } = self;
        for i in 0..*size {
            let row = &factor[i * size..][..=i];
            right[i] = (right[i] * scale[i] - dot(&row[..i], &right[..i])) / row[i];
        }
        for i in (0..*size).rev() {
            let value = right[i] / factor[i * size + i];
            right[i] = value;
            let row = &factor[i * size..][..i];
            right[..i].iter_mut().zip(row).for_each(|(right, factor)| *right -= value * factor);
        }
        right.iter_mut().zip(scale).for_each(|(value, scale)| *value *= scale);
        right
    }

    /// The diagonal of the inverse of the matrix, by the inverse of the factor.
    pub(super) fn inverse_diagonal(mut self) -> Vec<f64> {
        let size = self.size;
        for i in 0..size {
            let (above, row) = self.factor.split_at_mut(i * size);
            let diagonal = 1.0 / row[i];
            let mut inverse = vec![0.0; i];
            for (j, factor) in row[..i].iter().enumerate() {
                let of_row = above[j * size..][..=j].iter();
                inverse[..=j].iter_mut().zip(of_row).for_each(|(sum, value)| *sum -= diagonal * factor * value);
            }
            row[..i].copy_from_slice(&inverse);
            row[i] = diagonal;
        }
        let squares = |i: usize| (i..size).map(|row| self.factor[row * size + i].powi(2)).sum::<f64>();
        (0..size).map(|i| squares(i) * self.scale[i].powi(2)).collect()
    }
}
