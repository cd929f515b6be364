//! The likelihood of one structure of the noise, and the parameters that make it largest.
//!
//! Every statistic is a power with the expectation Σ x θ and some degrees of freedom, which follows
//! χ² (Whittle, 1953). Fisher's scoring finds the largest likelihood by least squares with
//! non-negative components, each step shortened until the likelihood rises. The information of the
//! parameters, which is most of the work, is computed again only if the steps converge slowly.

use core::ops::Range;

use multiversion::multiversion;

use super::cholesky::Cholesky;
use super::crossing::crossing;
use super::density::{FLICKER, WALK, WHITE};
use crate::accumulate::counts::dot;
use crate::infer::power_law::{flicker_variance, walk_variance};

/// Most steps of the scoring, and most halvings of each.
const STEPS: usize = 40;
const HALVINGS: usize = 10;

/// The log-likelihood rises by less in the last step.
const TOLERANCE: f64 = 2e-4;

/// Of the rise of the step before: with less, the information is good enough for another step.
const FAST: f64 = 0.1;

/// Statistics of one channel, and what each component with parameter 1 adds to them.
#[derive(Clone, Debug, Default)]
pub(in crate::infer) struct Rows {
    /// By column and row.
    pub(in crate::infer) columns: Vec<Vec<f64>>,
    pub(in crate::infer) power: Vec<f64>,
    /// Half of the degrees of freedom: what the row says beside its neighbours.
    pub(in crate::infer) weight: Vec<f64>,
    /// The same of the row alone.
    pub(in crate::infer) alone: Vec<f64>,
    /// The coefficients of the level, whose squares are the powers of the rows from `first_level`
    /// on, and the shapes that the level may have; see [`Structure::shapes`].
    pub(in crate::infer) level: Vec<f64>,
    pub(in crate::infer) first_level: usize,
    /// Mean density over the band, which no autocovariance exceeds.
    pub(in crate::infer) mean_density: f64,
}

/// Which components are in, and which shapes of the level.
#[derive(Clone, Debug, Default)]
pub(in crate::infer) struct Structure<'a> {
    /// Columns with an amplitude that is not negative.
    pub(in crate::infer) components: Vec<usize>,
    /// Columns with one of either sign.
    pub(in crate::infer) cosines: Range<usize>,
    /// Variance of each of these before the record is known, about zero.
    pub(in crate::infer) cosine_variances: Vec<f64>,
    /// By shape its coefficients.
    pub(in crate::infer) shapes: Vec<&'a [f64]>,
    /// A component, if it is held at a value.
    pub(in crate::infer) held: Option<(usize, f64)>,
    /// The multiple of the first shape, if it is held.
    pub(in crate::infer) held_shape: Option<f64>,
    /// The first shape is a ramp whose multiple is free: the likelihood is that of what it leaves
    /// (restricted, Patterson and Thompson, 1971), so that it takes nothing from a walk.
    pub(in crate::infer) is_restricted: bool,
}

/// The likeliest parameters.
#[derive(Debug, Default)]
pub(in crate::infer) struct Scored {
    pub(in crate::infer) log_likelihood: f64,
    /// By column; 0 for those that are not in.
    pub(in crate::infer) parameters: Vec<f64>,
    /// By shape.
    pub(in crate::infer) multiples: Vec<f64>,
    /// Expected power by row.
    pub(in crate::infer) expected: Vec<f64>,
    /// Power by row, the level without its shapes.
    pub(in crate::infer) powers: Vec<f64>,
    /// The same with what the ramp took of it.
    targets: Vec<f64>,
    /// What the restriction takes off the log-likelihood.
    pub(super) restriction: f64,
    /// Near the likeliest parameters.
    information: Information,
}

/// Information of the free parameters of a structure, the components first, then the cosines.
#[derive(Debug, Default)]
struct Information {
    columns: Vec<usize>,
    matrix: Vec<f64>,
}

/// Information of the components alone, the cosines being whatever suits them best (Schur's complement).
struct Reduced {
    matrix: Vec<f64>,
    /// Of the cosines, with what is known of them before.
    cosines: Cholesky,
    /// By component the cosines that make up for it.
    made_up: Vec<Vec<f64>>,
}

impl Rows {
    /// Of a level alone, by its cosine coefficients, in white noise, flicker noise and a random walk.
    pub(in crate::infer) fn of_level(level: Vec<f64>) -> Self {
        let blocks = level.len() + 1;
        let mut rows = Self { columns: vec![Vec::new(); 3], ..Self::default() };
        for (k, coefficient) in (1..).zip(&level) {
            let noises = [1.0, flicker_variance(k, blocks), walk_variance(k, blocks)];
            rows.push(coefficient * coefficient, 0.5, 0.5, noises.into_iter());
        }
        Self { level, ..rows }
    }

    pub(in crate::infer) fn push(&mut self, power: f64, weight: f64, alone: f64, x: impl Iterator<Item = f64>) {
        self.columns.iter_mut().zip(x).for_each(|(column, x)| column.push(x));
        self.power.push(power);
        self.weight.push(weight);
        self.alone.push(alone);
    }

    /// `None` where no parameters explain the rows.
    pub(in crate::infer) fn fit(&self, structure: &Structure<'_>, near: Option<&Scored>) -> Option<Scored> {
        let columns = structure.free_columns();
        let from_near = near.map(|near| self.at(structure, structure.in_structure(&near.parameters)));
        let mut now = match from_near.filter(|now| now.log_likelihood.is_finite()) {
            Some(now) => now,
            None => self.at(structure, self.start(structure, &columns)),
        };
        if !now.log_likelihood.is_finite() {
            return None;
        }
        let mut known = near.and_then(|near| near.information.of(&columns));
        let mut rise = f64::INFINITY;
        let mut reduced = None;
        for _ in 0..STEPS {
            let is_old = known.is_some();
            let information = known.unwrap_or_else(|| self.information(columns.clone(), &now.expected));
            let of_components = match reduced {
                Some(reduced) if is_old => reduced,
                _ => information.reduced(structure)?,
            };
            let off: Vec<f64> = now.targets.iter().zip(&now.expected).map(|(target, of)| target - of).collect();
            let weights = self.weights(&now.expected);
            let aim = self.solved(&information, &of_components, &weights, &off, &now.parameters);
            let next = aim.and_then(|aim| self.step(structure, &now, &aim));
            let before = rise;
            rise = next.as_ref().map_or(0.0, |next| next.log_likelihood - now.log_likelihood);
            now = next.unwrap_or(now);
            let is_fast = rise < FAST * before && rise > 0.0;
            if rise < TOLERANCE && (is_fast || !is_old) {
                now.information = information;
                break;
            }
            known = is_fast.then_some(information);
            reduced = Some(of_components);
        }
        Some(now)
    }

    /// Towards `aim`, as far as the likelihood rises.
    fn step(&self, structure: &Structure<'_>, now: &Scored, aim: &[f64]) -> Option<Scored> {
        let mut part = 1.0;
        (0..HALVINGS).find_map(|_| {
            let towards = |(now, aim): (&f64, &f64)| now + part * (aim - now);
            let next = self.at(structure, now.parameters.iter().zip(aim).map(towards).collect());
            part *= 0.5;
            (next.log_likelihood > now.log_likelihood).then_some(next)
        })
    }

    /// From weights by the powers around each row, which favour no row that is low by chance.
    fn start(&self, structure: &Structure<'_>, columns: &[usize]) -> Vec<f64> {
        const AROUND: usize = 4;
        let around = |row: usize| {
            let rows = if row < self.first_level { 0..self.first_level } else { self.first_level..self.power.len() };
            let rows = row.saturating_sub(AROUND).max(rows.start)..(row + AROUND + 1).min(rows.end);
            let (sum, weight) = rows.fold((0.0, 0.0), |(sum, weight), row| {
                (sum + self.weight[row] * self.power[row], weight + self.weight[row])
            });
            sum / weight
        };
        let smooth: Vec<f64> = (0..self.power.len()).map(around).collect();
        let parameters = structure.in_structure(&vec![0.0; self.columns.len()]);
        let information = self.information(columns.to_vec(), &smooth);
        // weights of the smoothed powers, and no part of the powers explained but what is held
        let mut expected = vec![0.0; smooth.len()];
        if let Some((column, value)) = structure.held {
            add_multiple(&mut expected, &self.columns[column], value);
        }
        let weights = self.weights(&smooth);
        let off: Vec<f64> = self.power.iter().zip(&expected).map(|(power, expected)| power - expected).collect();
        let reduced = information.reduced(structure);
        let found = reduced.and_then(|reduced| self.solved(&information, &reduced, &weights, &off, &parameters));
        found.unwrap_or(parameters)
    }

    /// What `parameters` expect, with the likeliest multiples of the shapes.
    fn at(&self, structure: &Structure<'_>, parameters: Vec<f64>) -> Scored {
        let mut expected = vec![0.0; self.power.len()];
        for (column, parameter) in self.columns.iter().zip(&parameters).filter(|(_, parameter)| **parameter != 0.0) {
            add_multiple(&mut expected, column, *parameter);
        }
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
        let of_row = |(row, weight): (usize, &f64)| {
            let ratio = powers[row] / expected[row];
            // of the density over that of a level of its own in each row
            weight * if row < self.first_level { 1.0 + ratio.ln() - ratio } else { -ratio - expected[row].ln() }
        };
        let is_possible = expected.iter().all(|expected| *expected > 0.0);
        let cosines = parameters[structure.cosines.clone()].iter().zip(&structure.cosine_variances);
        let unlikely = cosines.map(|(cosine, variance)| 0.5 * cosine * cosine / variance).sum::<f64>();
        let likely = self.weight.iter().enumerate().map(of_row).sum::<f64>() - restriction - unlikely;
        let log_likelihood = if is_possible && !likely.is_nan() { likely } else { f64::NEG_INFINITY };
        Scored { log_likelihood, parameters, multiples, expected, powers, targets, restriction, ..Scored::default() }
    }

    fn weights(&self, expected: &[f64]) -> Vec<f64> {
        self.weight.iter().zip(expected).map(|(weight, expected)| weight / (expected * expected)).collect()
    }

    fn information(&self, columns: Vec<usize>, expected: &[f64]) -> Information {
        let x: Vec<&[f64]> = columns.iter().map(|column| self.columns[*column].as_slice()).collect();
        let matrix = products(&x, &self.weights(expected));
        Information { columns, matrix }
    }

    /// The parameters that explain best what is `off` with these.
    fn solved(
        &self,
        information: &Information,
        reduced: &Reduced,
        weights: &[f64],
        off: &[f64],
        parameters: &[f64],
    ) -> Option<Vec<f64>> {
        let columns = &information.columns;
        let size = columns.len();
        let now: Vec<f64> = columns.iter().map(|column| parameters[*column]).collect();
        let weighted: Vec<f64> = weights.iter().zip(off).map(|(weight, off)| weight * off).collect();
        let right = |(i, column): (usize, &usize)| {
            dot(&self.columns[*column], &weighted) + dot(&information.matrix[i * size..][..size], &now)
        };
        let right: Vec<f64> = columns.iter().enumerate().map(right).collect();
        let (of_components, of_cosines) = right.split_at(reduced.made_up.len());
        let left = of_components.iter().zip(&reduced.made_up).map(|(right, made_up)| right - dot(made_up, of_cosines));
        let components = now[..of_components.len()].to_vec();
        let mut found = non_negative(&reduced.matrix, &left.collect::<Vec<_>>(), components)?;
        let mut cosines = reduced.cosines.solve(of_cosines.to_vec());
        found.iter().zip(&reduced.made_up).for_each(|(value, made_up)| add_multiple(&mut cosines, made_up, -value));
        found.extend(cosines);
        let mut parameters = parameters.to_vec();
        columns.iter().zip(found).for_each(|(column, value)| parameters[*column] = value);
        Some(parameters)
    }

    /// Where the log-likelihood of `best`, restricted by no ramp, has fallen by `drop` along the multiple of
    /// the first shape, above or below it by `sign`.
    pub(in crate::infer) fn limit_of_multiple(
        &self,
        structure: &Structure<'_>,
        best: &Scored,
        sign: f64,
        drop: f64,
    ) -> Option<f64> {
        let (shape, value) = (structure.shapes.first()?, best.multiples.first()?);
        let each = shape.iter().zip(&best.expected[self.first_level..]);
        let deviation = 1.0 / each.map(|(shape, expected)| shape * shape / expected).sum::<f64>().sqrt();
        let fall = |distance: f64| {
            let held_shape = Some(value + sign * distance);
            let held = self.fit(&Structure { held_shape, is_restricted: false, ..structure.clone() }, Some(best));
            held.map_or(f64::INFINITY, |held| best.unrestricted() - held.log_likelihood)
        };
        Some(value + sign * crossing(drop, deviation, fall))
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

    /// Variances of the parameters by column, 0 for those that are not in or at zero, infinite where some
    /// are alike. Keeps the information for fits near to this one.
    pub(super) fn variances(&self, structure: &Structure<'_>, scored: &mut Scored) -> Vec<f64> {
        scored.information = self.information(structure.free_columns(), &scored.expected);
        let Information { columns, matrix } = &scored.information;
        let size = columns.len();
        let is_in =
            |place: &usize| structure.cosines.contains(&columns[*place]) || scored.parameters[columns[*place]] > 0.0;
        let places: Vec<usize> = (0..size).filter(is_in).collect();
        let prior = |place: usize| {
            let cosine = columns[place].checked_sub(structure.cosines.start);
            cosine.and_then(|cosine| structure.cosine_variances.get(cosine)).map_or(0.0, |variance| 1.0 / variance)
        };
        let entry = |i: usize, j: usize| {
            let (i, j) = (places[i], places[j]);
            matrix[i * size + j] + if i == j { prior(i) } else { 0.0 }
        };
        let Some(factor) = Cholesky::new(places.len(), entry) else { return vec![f64::INFINITY; self.columns.len()] };
        let mut variances = vec![0.0; self.columns.len()];
        places.iter().zip(factor.inverse_diagonal()).for_each(|(place, of)| variances[columns[*place]] = of);
        variances
    }
}

impl Information {
    /// `None` where cosines are alike.
    fn reduced(&self, structure: &Structure<'_>) -> Option<Reduced> {
        let (size, cosines) = (self.columns.len(), structure.cosine_variances.len());
        let components = size - cosines;
        let coupling = |i: usize| &self.matrix[i * size + components..][..cosines];
        let entry = |i: usize, j: usize| {
            let prior = if i == j { 1.0 / structure.cosine_variances[i] } else { 0.0 };
            coupling(components + i)[j] + prior
        };
        let factor = Cholesky::new(cosines, entry)?;
        let made_up: Vec<Vec<f64>> = (0..components).map(|i| factor.solve(coupling(i).to_vec())).collect();
        let row = |i: usize| {
            let left = (0..components).zip(&made_up);
            left.map(move |(j, made_up)| self.matrix[i * size + j] - dot(coupling(i), made_up))
        };
        let matrix = (0..components).flat_map(row).collect();
        Some(Reduced { matrix, cosines: factor, made_up })
    }

    /// Of these columns alone; `None` where one of them is not in.
    fn of(&self, columns: &[usize]) -> Option<Self> {
        let place = |column: &usize| self.columns.iter().position(|known| known == column);
        let places = columns.iter().map(place).collect::<Option<Vec<usize>>>()?;
        let size = self.columns.len();
        let row = |i: &usize| places.iter().map(|j| self.matrix[i * size + j]).collect::<Vec<f64>>();
        Some(Self { columns: columns.to_vec(), matrix: places.iter().flat_map(row).collect() })
    }
}

impl Scored {
    /// Of the level with its shapes, not of what a ramp leaves.
    pub(super) const fn unrestricted(&self) -> f64 {
        self.log_likelihood + self.restriction
    }
}

impl<'a> Structure<'a> {
    /// White noise, flicker noise and a walk of a level, with these shapes.
    pub(in crate::infer) fn of_level(shapes: &[&'a [f64]]) -> Self {
        Self { components: vec![WHITE, FLICKER, WALK], shapes: shapes.to_vec(), ..Self::default() }
    }

    /// The components that are not held, then the cosines.
    fn free_columns(&self) -> Vec<usize> {
        let is_free = |column: &usize| self.held.is_none_or(|(held, _)| held != *column);
        self.components.iter().copied().filter(is_free).chain(self.cosines.clone()).collect()
    }

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

fn add_multiple(sum: &mut [f64], values: &[f64], multiple: f64) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += multiple * value);
}

/// The weighted products of all pairs of columns.
#[multiversion(targets("x86_64+avx2"))]
fn products(columns: &[&[f64]], weights: &[f64]) -> Vec<f64> {
    let size = columns.len();
    let mut matrix = vec![0.0; size * size];
    let mut weighted = vec![0.0; weights.len()];
    for (i, column) in columns.iter().enumerate() {
        for ((weighted, x), weight) in weighted.iter_mut().zip(*column).zip(weights) {
            *weighted = x * weight;
        }
        for (j, other) in columns[..=i].iter().enumerate() {
            let entry = dot(&weighted, other);
            (matrix[i * size + j], matrix[j * size + i]) = (entry, entry);
        }
    }
    matrix
}

/// The smallest x' matrix x / 2 - right' x without negative values, from `x` on: the active-set method of
/// Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23).
fn non_negative(matrix: &[f64], right: &[f64], mut x: Vec<f64>) -> Option<Vec<f64>> {
    let size = right.len();
    let entry = |i: usize, j: usize| matrix[i * size + j];
    let mut passive: Vec<usize> = (0..size).filter(|i| x[*i] > 0.0 && entry(*i, *i) > 0.0).collect();
    (0..size).filter(|i| !passive.contains(i)).for_each(|i| x[i] = 0.0);
    for _ in 0..3 * size + 3 {
        loop {
            let factor = Cholesky::new(passive.len(), |i, j| entry(passive[i], passive[j]));
            let Some(solution) = factor.map(|factor| factor.solve(passive.iter().map(|i| right[*i]).collect())) else {
                // columns that are alike: one of them is enough
                x[passive.pop()?] = 0.0;
                continue;
            };
            let mut step = 1.0_f64;
            for (i, value) in passive.iter().zip(&solution).filter(|(_, value)| **value <= 0.0) {
                step = step.min(x[*i] / (x[*i] - value).max(f64::MIN_POSITIVE));
            }
            for (i, value) in passive.iter().zip(&solution) {
                x[*i] += step * (value - x[*i]);
            }
            if step >= 1.0 {
                break;
            }
            passive.retain(|i| x[*i] > 1e-14 * right[*i].abs() / entry(*i, *i));
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
    let factor = Cholesky::new(free.len(), |i, j| product(free[i], free[j]));
    let found = factor.map_or_else(|| vec![0.0; free.len()], |factor| factor.solve(right.collect()));
    held.into_iter().chain(found).collect()
}
