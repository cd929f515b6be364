//! Small dense least squares: Cholesky factors, and non-negative solutions.

/// Columns that are whitened at once: their sums do not wait for each other.
pub(super) const AT_ONCE: usize = 8;

/// Lower triangular factor L of a symmetric positive definite matrix.
#[derive(Default)]
pub(super) struct Cholesky {
    size: usize,
    /// Column by column.
    factor: Vec<f64>,
    /// 1 over each element of the diagonal.
    inverse: Vec<f64>,
}

impl Cholesky {
    /// Of the matrix with `entry(i, j)` at row i and column j <= i; `None` unless it is positive
    /// definite.
    pub(super) fn factor(&mut self, size: usize, entry: impl Fn(usize, usize) -> f64) -> Option<()> {
        self.size = size;
        self.inverse.clear();
        self.factor.clear();
        self.factor.resize(size * size, 0.0);
        for j in 0..size {
            let (column, behind) = self.factor[j * size..].split_at_mut(size);
            // until here, the sums of products of the columns before
            let rest = entry(j, j) - column[j];
            if rest.is_nan() || rest <= 0.0 {
                return None;
            }
            let diagonal = rest.sqrt();
            let inverse = 1.0 / diagonal;
            column[j] = diagonal;
            self.inverse.push(inverse);
            for (i, value) in column.iter_mut().enumerate().skip(j + 1) {
                *value = (entry(i, j) - *value) * inverse;
            }
            for (k, sums) in (j + 1..).zip(behind.chunks_exact_mut(size)) {
                let factor = column[k];
                sums[k..].iter_mut().zip(&column[k..]).for_each(|(sum, value)| *sum += value * factor);
            }
        }
        Some(())
    }

    /// Solves L X = `rows` in place, with X and `rows` row by row.
    pub(super) fn whiten(&self, rows: &mut [[f64; AT_ONCE]]) {
        for (i, inverse) in self.inverse.iter().enumerate() {
            let (known, rest) = rows.split_at_mut(i);
            let mut sums = [0.0; AT_ONCE];
            for (known, factor) in known.iter().zip(self.factor[i..].iter().step_by(self.size)) {
                sums.iter_mut().zip(known).for_each(|(sum, value)| *sum += factor * value);
            }
            rest[0].iter_mut().zip(sums).for_each(|(value, sum)| *value = (*value - sum) * inverse);
        }
    }
}

/// Solves non-negative least squares, and keeps the memory for the next one.
#[derive(Default)]
pub(crate) struct NonNegative {
    norms: Vec<f64>,
    /// Columns of length one: their amplitudes may differ by many powers of ten.
    unit: Vec<f64>,
    x: Vec<f64>,
    passive: Vec<usize>,
    residual: Vec<f64>,
    reflected: Reflected,
}

impl NonNegative {
    /// The x >= 0 that minimises |A x - y|², by the active-set method of Lawson and Hanson (Solving
    /// Least Squares Problems, 1974, chapter 23); the columns of A stand behind one another. It
    /// begins with the columns that are positive in `near`, such as the solution of a similar
    /// problem; empty for none.
    pub(crate) fn solve(&mut self, columns: &[f64], y: &[f64], near: &[f64]) -> &[f64] {
        let Self { norms, unit, x, passive, residual, reflected } = self;
        let rows = y.len().max(1);
        norms.clear();
        norms.extend(columns.chunks_exact(rows).map(|column| dot(column, column).sqrt()));
        unit.clear();
        for (column, &norm) in columns.chunks_exact(rows).zip(&*norms) {
            unit.extend(column.iter().map(|value| if norm > 0.0 { value / norm } else { 0.0 }));
        }
        let tolerance = 1e-13 * dot(y, y).sqrt();
        x.clear();
        x.resize(norms.len(), 0.0);
        passive.clear();
        passive.extend((0..near.len()).filter(|j| near[*j] > 0.0 && norms[*j] > 0.0));
        let solution = reflected.solve(unit, passive, y);
        if solution.iter().all(|value| *value > 0.0) {
            passive.iter().zip(solution).for_each(|(&j, &value)| x[j] = value);
        } else {
            passive.clear();
        }
        // Each set of columns is visited at most once, in exact arithmetic; rounding may revisit one.
        for _ in 0..3 * norms.len() {
            residual.clear();
            residual.extend_from_slice(y);
            for (column, x) in unit.chunks_exact(rows).zip(&*x) {
                residual.iter_mut().zip(column).for_each(|(rest, value)| *rest -= value * x);
            }
            let steepest = (0..x.len())
                .filter(|j| !passive.contains(j))
                .map(|j| (j, dot(&unit[j * rows..][..rows], residual)))
                .max_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((entering, _)) = steepest.filter(|(_, slope)| *slope > tolerance) else { break };
            passive.push(entering);
            loop {
                let solution = reflected.solve(unit, passive, y);
                if solution.iter().all(|value| *value > 0.0) {
                    x.fill(0.0);
                    passive.iter().zip(solution).for_each(|(&j, &value)| x[j] = value);
                    break;
                }
                // To the first bound on the way to the solution.
                let step = passive
                    .iter()
                    .zip(solution)
                    .filter(|(_, value)| **value <= 0.0)
                    .map(|(&j, value)| x[j] / (x[j] - value))
                    .fold(1.0, f64::min);
                let step = if step.is_nan() { 0.0 } else { step };
                for (&j, value) in passive.iter().zip(solution) {
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
        x.iter_mut().zip(norms).for_each(|(value, norm)| *value = if *norm > 0.0 { *value / *norm } else { 0.0 });
        x
    }
}

/// Least squares on some columns alone, by Householder reflections.
#[derive(Default)]
struct Reflected {
    columns: Vec<f64>,
    y: Vec<f64>,
    normal: Vec<f64>,
    x: Vec<f64>,
}

impl Reflected {
    /// On those of `columns` that are `passive`.
    fn solve(&mut self, columns: &[f64], passive: &[usize], y: &[f64]) -> &[f64] {
        let rows = y.len();
        self.columns.clear();
        passive.iter().for_each(|&j| self.columns.extend_from_slice(&columns[j * rows..][..rows]));
        self.y.clear();
        self.y.extend_from_slice(y);
        let size = passive.len().min(rows);
        for k in 0..size {
            self.normal.clear();
            self.normal.extend_from_slice(&self.columns[k * rows..][k..rows]);
            let norm = dot(&self.normal, &self.normal).sqrt();
            self.normal[0] += norm.copysign(self.normal[0]);
            let square = dot(&self.normal, &self.normal);
            if square == 0.0 {
                continue;
            }
            for values in self.columns[k * rows..].chunks_exact_mut(rows).chain([&mut self.y[..]]) {
                let scale = 2.0 * dot(&self.normal, &values[k..]) / square;
                values[k..].iter_mut().zip(&self.normal).for_each(|(value, n)| *value -= scale * n);
            }
        }
        self.x.clear();
        self.x.resize(passive.len(), 0.0);
        for k in (0..size).rev() {
            let known: f64 = (k + 1..size).map(|j| self.columns[j * rows + k] * self.x[j]).sum();
            let diagonal = self.columns[k * rows + k];
            self.x[k] = if diagonal == 0.0 { 0.0 } else { (self.y[k] - known) / diagonal };
        }
        &self.x
    }
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
        let mut solver = NonNegative::default();
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
            let column = |name| points.iter().map(move |point| weight(point) * basis(name, number(&point["tau"])));
            let columns: Vec<f64> = names.iter().flat_map(|&name| column(name)).collect();
            let y: Vec<f64> = points.iter().map(|point| weight(point) * number(&point["avar"])).collect();
            let found = solver.solve(&columns, &y, &[]);
            for (name, found) in names.iter().zip(found) {
                let expected = number(&case["squared"][name.to_string()]);
                let right = if expected == 0.0 { *found == 0.0 } else { (found / expected - 1.0).abs() < 1e-8 };
                assert!(right, "{} {name}: {found}, not {expected}", case["case"]);
            }
            let columns = || found.iter().zip(columns.chunks(y.len()));
            let rest = |i: usize| y[i] - columns().map(|(x, column)| x * column[i]).sum::<f64>();
            let rest: Vec<f64> = (0..y.len()).map(rest).collect();
            let chi2 = number(&case["chi2"]);
            assert!((dot(&rest, &rest) / chi2 - 1.0).abs() < 1e-8, "{}", case["case"]);
        }
        assert_eq!(cases.len(), 18);
    }

    #[test]
    fn degenerate_problems_have_an_answer() {
        let mut solver = NonNegative::default();
        assert_eq!(solver.solve(&[0.0, 0.0], &[1.0, 1.0], &[]), [0.0]);
        assert_eq!(solver.solve(&[1.0, 1.0], &[0.0, 0.0], &[]), [0.0]);
        assert_eq!(solver.solve(&[1.0, 0.0], &[-1.0, 0.0], &[]), [0.0]);
        let twice = solver.solve(&[1.0, 1.0, 1.0, 1.0], &[2.0, 2.0], &[]);
        assert!((twice[0] + twice[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_solver_that_was_used_says_the_same_as_a_new_one() {
        let problems: [(&[f64], &[f64], &[f64]); 4] = [
            (&[1.0, 2.0, 3.0, 3.0, 1.0, 1.0], &[4.0, 3.0, 4.0], &[1.0, 1.0]),
            (&[1.0, 0.0], &[-1.0, 0.0], &[1.0]),
            (&[1.0, 1.0, 0.0, 1.0, 0.5, 1.0], &[1.0, 3.0], &[]),
            (&[], &[], &[]),
        ];
        let mut used = NonNegative::default();
        for (columns, y, near) in problems.into_iter().chain(problems) {
            assert_eq!(used.solve(columns, y, near), NonNegative::default().solve(columns, y, near));
        }
    }

    #[test]
    fn whitened_columns_of_the_matrix_have_its_products() {
        let matrix = [[4.0, 2.0, 0.4], [2.0, 5.0, 1.0], [0.4, 1.0, 3.0]];
        let mut cholesky = Cholesky::default();
        // a larger one before leaves nothing behind
        cholesky.factor(5, |i, j| f64::from(u8::from(i == j))).unwrap();
        cholesky.factor(3, |i, j| matrix[i][j]).unwrap();
        let mut rows = matrix.map(|row| std::array::from_fn(|j| row.get(j).copied().unwrap_or(0.0)));
        cholesky.whiten(&mut rows);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = rows.iter().map(|row: &[f64; AT_ONCE]| row[i] * row[j]).sum();
                assert!((product - matrix[i][j]).abs() < 1e-12);
            }
        }
        assert!(cholesky.factor(2, |i, j| if i == j { 1.0 } else { 2.0 }).is_none());
        assert!(cholesky.factor(1, |_, _| f64::NAN).is_none());
    }
}
