//! The likelihood of one structure of the noise, and the parameters that make it largest.
//!
//! Every statistic is a power with the expectation Σ x θ and some degrees of freedom, which follows
//! χ² (Whittle, 1953). Fisher's scoring finds the largest likelihood by least squares with
//! non-negative components, each step shortened until the likelihood rises.

use core::ops::Range;

/// Most steps of the scoring, and most halvings of each.
const STEPS: usize = 40;
const HALVINGS: usize = 10;

/// The log-likelihood rises by less in the last step.
const TOLERANCE: f64 = 2e-4;

/// Statistics of one channel, and what each component with parameter 1 adds to them.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) columns: usize,
    /// By row.
    pub(super) x: Vec<f64>,
    pub(super) power: Vec<f64>,
    /// Half of the degrees of freedom: what the row says beside its neighbours, which may be less
    /// than it says alone.
    pub(super) weight: Vec<f64>,
    /// The same of the row alone.
    pub(super) alone: Vec<f64>,
    /// The coefficients of the level, whose squares are the powers of the rows from `first_level`
    /// on, and the shapes that the level may have; see [`Structure::shapes`].
    pub(super) level: Vec<f64>,
    pub(super) first_level: usize,
    /// Mean density over the band, which no autocovariance exceeds.
    pub(super) mean_density: f64,
}

/// Which components are in, and which shapes of the level.
#[derive(Clone, Debug, Default)]
pub(super) struct Structure<'a> {
    /// Columns with an amplitude that is not negative.
    pub(super) components: Vec<usize>,
    /// Columns with one of either sign.
    pub(super) cosines: Range<usize>,
    /// Variance of each of these before the record is known, about zero.
    pub(super) cosine_variances: Vec<f64>,
    /// By shape its coefficients.
    pub(super) shapes: Vec<&'a [f64]>,
    /// A component, if it is held at a value.
    pub(super) held: Option<(usize, f64)>,
    /// The multiple of the first shape, if it is held.
    pub(super) held_shape: Option<f64>,
    /// The first shape is a ramp whose multiple is free: the likelihood is that of what it leaves
    /// (restricted, Patterson and Thompson, 1971), so that it takes nothing from a walk.
    pub(super) is_restricted: bool,
}

/// The likeliest parameters.
#[derive(Clone, Debug, Default)]
pub(super) struct Scored {
    pub(super) log_likelihood: f64,
    /// By column; 0 for those that are not in.
    pub(super) parameters: Vec<f64>,
    /// By shape.
    pub(super) multiples: Vec<f64>,
    /// Expected power by row.
    pub(super) expected: Vec<f64>,
    /// Power by row, the level without its shapes.
    pub(super) powers: Vec<f64>,
    /// The same with what the ramp took of it.
    targets: Vec<f64>,
    /// What the restriction takes off the log-likelihood.
    restriction: f64,
}

impl Rows {
    pub(super) fn push(&mut self, power: f64, weight: f64, alone: f64, x: impl Iterator<Item = f64>) {
        self.x.extend(x);
        self.power.push(power);
        self.weight.push(weight);
        self.alone.push(alone);
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.x[row * self.columns..][..self.columns]
    }

    /// `None` where no parameters explain the rows.
    pub(super) fn fit(&self, structure: &Structure<'_>, near: Option<&[f64]>) -> Option<Scored> {
        let active = Active::new(self, structure);
        let mut now = match near {
            Some(near) => self.at(structure, structure.in_structure(near)),
            None => self.at(structure, self.start(structure, &active)),
        };
        if !now.log_likelihood.is_finite() {
            now = self.at(structure, self.start(structure, &active));
        }
        if !now.log_likelihood.is_finite() {
            return None;
        }
        for _ in 0..STEPS {
            let aim = active.aim(self, structure, &now)?;
            let mut part = 1.0;
            let better = (0..HALVINGS).find_map(|_| {
                let towards = |(now, aim): (&f64, &f64)| now + part * (aim - now);
                let next = self.at(structure, now.parameters.iter().zip(&aim).map(towards).collect());
                part *= 0.5;
                (next.log_likelihood > now.log_likelihood).then_some(next)
            });
            let Some(next) = better else { break };
            let rise = next.log_likelihood - now.log_likelihood;
            now = next;
            if rise < TOLERANCE {
                break;
            }
        }
        Some(now)
    }

    /// From weights by the powers around each row, which favour no row that is low by chance.
    fn start(&self, structure: &Structure<'_>, active: &Active) -> Vec<f64> {
        const AROUND: usize = 4;
        let around = |row: usize| {
            let rows = if row < self.first_level { 0..self.first_level } else { self.first_level..self.power.len() };
            let rows = row.saturating_sub(AROUND).max(rows.start)..(row + AROUND + 1).min(rows.end);
            let (sum, weight) = rows.fold((0.0, 0.0), |(sum, weight), row| {
                (sum + self.weight[row] * self.power[row], weight + self.weight[row])
            });
            sum / weight
        };
        let expected = (0..self.power.len()).map(around).collect();
        let parameters = structure.in_structure(&vec![0.0; self.columns]);
        let begin = Scored { expected, targets: self.power.clone(), parameters, ..Scored::default() };
        active.aim(self, structure, &begin).unwrap_or(begin.parameters)
    }

    /// What `parameters` expect, with the likeliest multiples of the shapes.
    fn at(&self, structure: &Structure<'_>, parameters: Vec<f64>) -> Scored {
        let expected =
            |row: usize| self.row(row).iter().zip(&parameters).map(|(x, parameter)| x * parameter).sum::<f64>();
        let expected: Vec<f64> = (0..self.power.len()).map(expected).collect();
        let mut powers = self.power.clone();
        let mut multiples = Vec::new();
        if !structure.shapes.is_empty() {
            let weights: Vec<f64> = expected[self.first_level..].iter().map(|expected| 1.0 / expected).collect();
            multiples = multiples_of(&self.level, &structure.shapes, &weights, structure.held_shape);
            for (place, (power, level)) in powers[self.first_level..].iter_mut().zip(&self.level).enumerate() {
                let shapes = structure.shapes.iter().zip(&multiples).map(|(shape, multiple)| shape[place] * multiple);
                *power = (level - shapes.sum::<f64>()).powi(2);
            }
        }
        let mut targets = powers.clone();
        let mut restriction = 0.0;
        if let (true, Some(ramp)) = (structure.is_restricted, structure.shapes.first()) {
            let (targets, expected) = (&mut targets[self.first_level..], &expected[self.first_level..]);
            let information: f64 = ramp.iter().zip(expected).map(|(ramp, expected)| ramp * ramp / expected).sum();
            let square: f64 = ramp.iter().map(|ramp| ramp * ramp).sum();
            targets.iter_mut().zip(*ramp).for_each(|(target, ramp)| *target += ramp * ramp / information);
            restriction = 0.5 * (information / square).ln();
        }
        let log_likelihood = |(row, weight): (usize, &f64)| match expected[row] {
            expected if expected > 0.0 => {
                // of the density over that of a level of its own in each row
                let own = if row < self.first_level { powers[row].ln() + 1.0 } else { 0.0 };
                -weight * (expected.ln() + powers[row] / expected - own)
            }
            _ => f64::NEG_INFINITY,
        };
        let cosines = parameters[structure.cosines.clone()].iter().zip(&structure.cosine_variances);
        let unlikely = cosines.map(|(cosine, variance)| 0.5 * cosine * cosine / variance).sum::<f64>();
        let log_likelihood = self.weight.iter().enumerate().map(log_likelihood).sum::<f64>() - restriction - unlikely;
        let log_likelihood = if log_likelihood.is_nan() { f64::NEG_INFINITY } else { log_likelihood };
        Scored { log_likelihood, parameters, multiples, expected, powers, targets, restriction }
    }

    /// Effective number of the cosines: each counts by the part of it that the record decides, and
    /// not what is known before (the trace of the smoother, Hastie and Tibshirani, 1990).
    pub(super) fn effective_cosines(&self, structure: &Structure<'_>, scored: &Scored) -> f64 {
        let covariance = self.covariance(structure, scored);
        let decided = |(column, variance): (usize, &f64)| 1.0 - (covariance(column, column) / variance).min(1.0);
        structure.cosines.clone().zip(&structure.cosine_variances).map(decided).sum()
    }

    /// The squares of the multiples of the shapes from `first` on over their variances.
    pub(super) fn significances(&self, structure: &Structure<'_>, scored: &Scored, first: usize) -> Vec<f64> {
        let shapes = structure.shapes.iter().zip(&scored.multiples).skip(first);
        let of = |(shape, multiple): (&&[f64], &f64)| {
            let each = shape.iter().zip(&scored.expected[self.first_level..]);
            multiple * multiple * each.map(|(shape, expected)| shape * shape / expected).sum::<f64>()
        };
        shapes.map(of).collect()
    }

    /// Covariance of the parameters that are in, 0 for those at zero.
    pub(super) fn covariance(
        &self,
        structure: &Structure<'_>,
        scored: &Scored,
    ) -> impl Fn(usize, usize) -> f64 + use<> {
        let active = Active::new(self, structure);
        let is_in = |column: &usize| structure.cosines.contains(column) || scored.parameters[*column] > 0.0;
        let columns: Vec<usize> = active.columns.iter().copied().filter(is_in).collect();
        let (matrix, _) = active.normal(self, structure, scored);
        let size = columns.len();
        let place = |column: usize| active.columns.iter().position(|other| *other == column).unwrap_or_default();
        let entry = |i: usize, j: usize| matrix[place(columns[i]) * active.columns.len() + place(columns[j])];
        let inverse: Vec<Vec<f64>> = (0..size)
            .map(|column| {
                let unit = (0..size).map(|i| f64::from(u8::from(i == column))).collect();
                solved(size, entry, unit).unwrap_or_else(|| vec![f64::INFINITY; size])
            })
            .collect();
        move |a, b| {
            let place = |column| columns.iter().position(|other| *other == column);
            place(a).zip(place(b)).map_or(0.0, |(a, b)| inverse[a][b])
        }
    }
}

impl Scored {
    /// Of the level with its shapes, not of what a ramp leaves.
    pub(super) const fn unrestricted(&self) -> f64 {
        self.log_likelihood + self.restriction
    }
}

impl Structure<'_> {
    /// These parameters, those that are not in at zero.
    fn in_structure(&self, near: &[f64]) -> Vec<f64> {
        let value = |(column, value): (usize, &f64)| match self.held {
            Some((held, value)) if held == column => value,
            _ if self.components.contains(&column) => value.max(0.0),
            _ if self.cosines.contains(&column) => *value,
            _ => 0.0,
        };
        near.iter().enumerate().map(value).collect()
    }
}

/// The columns whose parameters are free.
struct Active {
    columns: Vec<usize>,
    /// How many of these, the first ones, are not negative.
    components: usize,
}

impl Active {
    fn new(rows: &Rows, structure: &Structure<'_>) -> Self {
        let is_free = |column: &usize| structure.held.is_none_or(|(held, _)| held != *column);
        let mut columns: Vec<usize> = structure.components.iter().copied().filter(is_free).collect();
        let components = columns.len();
        columns.extend(structure.cosines.clone().filter(|column| *column < rows.columns));
        Self { columns, components }
    }

    /// Information of the parameters, and its product with those that explain the powers best.
    fn normal(&self, rows: &Rows, structure: &Structure<'_>, now: &Scored) -> (Vec<f64>, Vec<f64>) {
        let size = self.columns.len();
        let (mut matrix, mut right) = (vec![0.0; size * size], vec![0.0; size]);
        let mut values = vec![0.0; size];
        for row in 0..rows.power.len() {
            let x = rows.row(row);
            values.iter_mut().zip(&self.columns).for_each(|(value, column)| *value = x[*column]);
            let known = structure.held.map_or(0.0, |(column, value)| x[column] * value);
            let weight = rows.weight[row] / now.expected[row].powi(2);
            let target = weight * (now.targets[row] - known);
            for (i, value) in values.iter().enumerate() {
                right[i] += target * value;
                let scaled = weight * value;
                for (entry, other) in matrix[i * size..][..=i].iter_mut().zip(&values) {
                    *entry += scaled * other;
                }
            }
        }
        for (i, variance) in (self.components..size).zip(&structure.cosine_variances) {
            matrix[i * size + i] += 1.0 / variance;
        }
        for i in 0..size {
            for j in 0..i {
                matrix[j * size + i] = matrix[i * size + j];
            }
        }
        (matrix, right)
    }

    /// The parameters that explain the powers best with the weights of `now`.
    fn aim(&self, rows: &Rows, structure: &Structure<'_>, now: &Scored) -> Option<Vec<f64>> {
        let (matrix, right) = self.normal(rows, structure, now);
        let found = self.non_negative(&matrix, &right, now)?;
        let mut parameters = structure.in_structure(&now.parameters);
        self.columns.iter().zip(found).for_each(|(column, value)| parameters[*column] = value);
        Some(parameters)
    }

    /// By the active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter
    /// 23), from the columns on that are positive now.
    fn non_negative(&self, matrix: &[f64], right: &[f64], now: &Scored) -> Option<Vec<f64>> {
        let size = self.columns.len();
        let entry = |i: usize, j: usize| matrix[i * size + j];
        let is_free = |i: usize| i >= self.components;
        let mut passive: Vec<usize> =
            (0..size).filter(|i| is_free(*i) || now.parameters[self.columns[*i]] > 0.0).collect();
        passive.retain(|i| entry(*i, *i) > 0.0);
        let solve = |passive: &[usize]| {
            solved(passive.len(), |i, j| entry(passive[i], passive[j]), passive.iter().map(|i| right[*i]).collect())
        };
        let mut x = vec![0.0; size];
        passive.iter().for_each(|i| x[*i] = now.parameters[self.columns[*i]]);
        for _ in 0..3 * size + 3 {
            loop {
                let Some(solution) = solve(&passive) else {
                    // columns that are alike: one of them is enough
                    passive.pop()?;
                    continue;
                };
                let mut step = 1.0_f64;
                for (i, value) in passive.iter().zip(&solution).filter(|(i, value)| !is_free(**i) && **value <= 0.0) {
                    step = step.min(x[*i] / (x[*i] - value).max(f64::MIN_POSITIVE));
                }
                for (i, value) in passive.iter().zip(&solution) {
                    x[*i] += step * (value - x[*i]);
                }
                if step >= 1.0 {
                    break;
                }
                passive.retain(|i| is_free(*i) || x[*i] > 1e-14 * right[*i].abs() / entry(*i, *i));
                (0..size).filter(|i| !passive.contains(i)).for_each(|i| x[i] = 0.0);
            }
            let slope = |i: usize| {
                let fall: f64 = passive.iter().map(|j| entry(i, *j) * x[*j]).sum();
                (right[i] - fall) / entry(i, i).sqrt()
            };
            let outside = (0..size).filter(|i| !passive.contains(i) && entry(*i, *i) > 0.0);
            let steepest = outside.map(|i| (i, slope(i))).max_by(|(_, a), (_, b)| a.total_cmp(b));
            match steepest.filter(|(_, slope)| *slope > 1e-9) {
                Some((entering, _)) => passive.push(entering),
                None => break,
            }
        }
        x.iter().all(|value| value.is_finite()).then_some(x)
    }
}

/// The multiples of `shapes` that explain `level` best.
fn multiples_of(level: &[f64], shapes: &[&[f64]], weights: &[f64], held: Option<f64>) -> Vec<f64> {
    let product =
        |a: &[f64], b: &[f64]| a.iter().zip(b).zip(weights).map(|((a, b), weight)| a * b * weight).sum::<f64>();
    let (first, free) = match held {
        Some(_) => shapes.split_at(1),
        None => (&[][..], shapes),
    };
    let known = held.unwrap_or_default();
    let right = free
        .iter()
        .map(|shape| product(shape, level) - first.iter().map(|first| known * product(shape, first)).sum::<f64>());
    let found = solved(free.len(), |i, j| product(free[i], free[j]), right.collect());
    held.into_iter().chain(found.unwrap_or_else(|| vec![0.0; free.len()])).collect()
}

/// Cholesky's factor of a symmetric positive matrix, with what scales its diagonal to 1; `None` where
/// it is as good as singular.
fn factored(size: usize, entry: impl Fn(usize, usize) -> f64) -> Option<(Vec<f64>, Vec<f64>)> {
    let scale: Vec<f64> = (0..size).map(|i| 1.0 / entry(i, i).sqrt()).collect();
    let mut factor = vec![0.0; size * size];
    for i in 0..size {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| factor[i * size + k] * factor[j * size + k]).sum();
            let rest = entry(i, j) * scale[i] * scale[j] - sum;
            factor[i * size + j] = if i == j {
                if rest.is_nan() || rest < 1e-11 {
                    return None;
                }
                rest.sqrt()
            } else {
                rest / factor[j * size + j]
            };
        }
    }
    Some((factor, scale))
}

/// Solves a symmetric positive system by Cholesky's factors; `None` where it is as good as singular.
pub(super) fn solved(size: usize, entry: impl Fn(usize, usize) -> f64, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let (factor, scale) = factored(size, entry)?;
    for i in 0..size {
        let sum: f64 = (0..i).map(|k| factor[i * size + k] * right[k]).sum();
        right[i] = (right[i] * scale[i] - sum) / factor[i * size + i];
    }
    for i in (0..size).rev() {
        let sum: f64 = (i + 1..size).map(|k| factor[k * size + i] * right[k]).sum();
        right[i] = (right[i] - sum) / factor[i * size + i];
    }
    right.iter_mut().zip(scale).for_each(|(value, scale)| *value *= scale);
    Some(right)
}
