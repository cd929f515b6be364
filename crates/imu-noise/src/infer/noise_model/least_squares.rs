//! Small dense least squares: Cholesky factors, and non-negative solutions.

/// Lower triangular factor of a symmetric positive definite matrix, row by row.
pub(super) struct Cholesky {
    size: usize,
    factor: Vec<f64>,
}

impl Cholesky {
    /// `entry(i, j)` is that at row i and column j <= i; `None` unless positive definite.
    pub(super) fn new(size: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut factor = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let (row_i, row_j) = (&factor[i * size..][..j], &factor[j * size..][..j]);
                let rest = entry(i, j) - dot(row_i, row_j);
                factor[i * size + j] = if i > j {
                    rest / factor[j * size + j]
                } else if rest > 0.0 {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Self { size, factor })
    }

    /// Solves L x = `values` in place.
    pub(super) fn whiten(&self, values: &mut [f64]) {
        for i in 0..self.size {
            let row = &self.factor[i * self.size..][..i];
            values[i] = (values[i] - dot(row, &values[..i])) / self.factor[i * self.size + i];
        }
    }
}

/// The x >= 0 that minimises |A x - y|², by the active-set method of Lawson and Hanson (Solving
/// Least Squares Problems, 1974, chapter 23). It begins with the columns that are positive in
/// `near`, such as the solution of a similar problem; empty for none.
pub(crate) fn non_negative(columns: &[Vec<f64>], y: &[f64], near: &[f64]) -> Vec<f64> {
    // Columns of length one: their amplitudes may differ by many powers of ten.
    let norms: Vec<_> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    let unit: Vec<Vec<f64>> = columns
        .iter()
        .zip(&norms)
        .map(|(column, &norm)| column.iter().map(|value| if norm > 0.0 { value / norm } else { 0.0 }).collect())
        .collect();
    let tolerance = 1e-13 * dot(y, y).sqrt();
    let mut x = vec![0.0; columns.len()];
    let mut passive: Vec<usize> = (0..near.len()).filter(|j| near[*j] > 0.0 && norms[*j] > 0.0).collect();
    let solution = unconstrained(&unit, &passive, y);
    if solution.iter().all(|value| *value > 0.0) {
        passive.iter().zip(solution).for_each(|(&j, value)| x[j] = value);
    } else {
        passive.clear();
    }
    // Each set of columns is visited at most once, in exact arithmetic; rounding may revisit one.
    for _ in 0..3 * columns.len() {
        let residual = residual(&unit, y, &x);
        let steepest = (0..columns.len())
            .filter(|j| !passive.contains(j))
            .map(|j| (j, dot(&unit[j], &residual)))
            .max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((entering, _)) = steepest.filter(|(_, slope)| *slope > tolerance) else { break };
        passive.push(entering);
        loop {
            let solution = unconstrained(&unit, &passive, y);
            if solution.iter().all(|value| *value > 0.0) {
                x.fill(0.0);
                passive.iter().zip(solution).for_each(|(&j, value)| x[j] = value);
                break;
            }
            // To the first bound on the way to the solution.
            let step = passive
                .iter()
                .zip(&solution)
                .filter(|(_, value)| **value <= 0.0)
                .map(|(&j, value)| x[j] / (x[j] - value))
                .fold(1.0, f64::min);
            let step = if step.is_nan() { 0.0 } else { step };
            for (&j, value) in passive.iter().zip(&solution) {
                x[j] += step * (value - x[j]);
            }
            let before = passive.len();
            passive.retain(|&j| x[j] > 1e-15 * (1.0 + tolerance));
            (0..x.len()).filter(|j| !passive.contains(j)).for_each(|j| x[j] = 0.0);
            if passive.is_empty() || passive.len() == before {
                break;
            }
        }
    }
    x.iter().zip(norms).map(|(value, norm)| if norm > 0.0 { value / norm } else { 0.0 }).collect()
}

/// On the columns `passive` alone, by Householder reflections.
fn unconstrained(columns: &[Vec<f64>], passive: &[usize], y: &[f64]) -> Vec<f64> {
    let mut a: Vec<Vec<f64>> = passive.iter().map(|&j| columns[j].clone()).collect();
    let mut y = y.to_vec();
    let size = a.len().min(y.len());
    for k in 0..size {
        let mut normal = a[k][k..].to_vec();
        let norm = dot(&normal, &normal).sqrt();
        normal[0] += norm.copysign(normal[0]);
        let square = dot(&normal, &normal);
        if square == 0.0 {
            continue;
        }
        for values in a[k..].iter_mut().chain([&mut y]) {
            let scale = 2.0 * dot(&normal, &values[k..]) / square;
            values[k..].iter_mut().zip(&normal).for_each(|(value, n)| *value -= scale * n);
        }
    }
    let mut x = vec![0.0; a.len()];
    for k in (0..size).rev() {
        let known: f64 = (k + 1..size).map(|j| a[j][k] * x[j]).sum();
        x[k] = if a[k][k] == 0.0 { 0.0 } else { (y[k] - known) / a[k][k] };
    }
    x
}

fn residual(columns: &[Vec<f64>], y: &[f64], x: &[f64]) -> Vec<f64> {
    let mut residual = y.to_vec();
    for (column, x) in columns.iter().zip(x) {
        residual.iter_mut().zip(column).for_each(|(rest, value)| *rest -= value * x);
    }
    residual
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle;
    use std::f64::consts::{LN_2, PI};

    fn number(value: &serde_json::Value) -> f64 {
        value.as_str().unwrap().parse().unwrap()
    }

    #[test]
    fn non_negative_solutions_are_those_of_exact_arithmetic() {
        let cases = oracle::json("fit_nnls.json");
        let cases = cases["cases"].as_array().unwrap();
        for case in cases {
            let points = case["points"].as_array().unwrap();
            let names: Vec<_> = case["names"].as_str().unwrap().chars().collect();
            let weight = |point: &serde_json::Value| (number(&point["edf"]) / 2.0).sqrt() / number(&point["avar"]);
            let basis = |name, tau: f64| match name {
                'Q' => 3.0 / (tau * tau),
                'N' => 1.0 / tau,
                'B' => 2.0 * LN_2 / PI,
                'K' => tau / 3.0,
                _ => tau * tau / 2.0,
            };
            let columns: Vec<Vec<f64>> = names
                .iter()
                .map(|&name| points.iter().map(|point| weight(point) * basis(name, number(&point["tau"]))).collect())
                .collect();
            let y: Vec<_> = points.iter().map(|point| weight(point) * number(&point["avar"])).collect();
            let found = non_negative(&columns, &y, &[]);
            for (name, found) in names.iter().zip(&found) {
                let expected = number(&case["squared"][name.to_string()]);
                let right = if expected == 0.0 { *found == 0.0 } else { (found / expected - 1.0).abs() < 1e-8 };
                assert!(right, "{} {name}: {found}, not {expected}", case["case"]);
            }
            let rest = residual(&columns, &y, &found);
            let chi2 = number(&case["chi2"]);
            assert!((dot(&rest, &rest) / chi2 - 1.0).abs() < 1e-8, "{}", case["case"]);
        }
        assert_eq!(cases.len(), 18);
    }

    #[test]
    fn degenerate_problems_have_an_answer() {
        assert_eq!(non_negative(&[vec![0.0, 0.0]], &[1.0, 1.0], &[]), [0.0]);
        assert_eq!(non_negative(&[vec![1.0, 1.0]], &[0.0, 0.0], &[]), [0.0]);
        assert_eq!(non_negative(&[vec![1.0, 0.0]], &[-1.0, 0.0], &[]), [0.0]);
        let twice = non_negative(&[vec![1.0, 1.0], vec![1.0, 1.0]], &[2.0, 2.0], &[]);
        assert!((twice[0] + twice[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn whitened_columns_of_the_matrix_have_its_products() {
        let matrix = [[4.0, 2.0, 0.4], [2.0, 5.0, 1.0], [0.4, 1.0, 3.0]];
        let cholesky = Cholesky::new(3, |i, j| matrix[i][j]).unwrap();
        let whitened = matrix.map(|mut column| {
            cholesky.whiten(&mut column);
            column
        });
        for i in 0..3 {
            for j in 0..3 {
                assert!((dot(&whitened[i], &whitened[j]) - matrix[i][j]).abs() < 1e-12);
            }
        }
        assert!(Cholesky::new(2, |i, j| if i == j { 1.0 } else { 2.0 }).is_none());
    }
}
