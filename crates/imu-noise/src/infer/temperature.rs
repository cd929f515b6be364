//! The temperature coefficient of the bias.

mod series;

use core::fmt;

use super::chi_squared;
use super::level_series::CosineTransform;
use super::noise_model::{Rows, Scored, Structure, crossing};
use crate::accumulate::temperature_blocks::TemperatureBlocks;
use series::BlockSeries;

/// Least range of the temperature for a coefficient, in °C.
pub const LEAST_EXCURSION_C: f64 = 1.0;

/// Least correlation of the temperature with time that counts as one direction only.
const ONE_DIRECTION: f64 = 0.9;

/// Fewest blocks: they must show the noise, too.
const LEAST_BLOCKS: usize = 32;

/// Lags that are searched at a time, without lag included.
const LAGS: usize = 8;

/// No sensor follows its own thermometer later than this, in seconds.
const LONGEST_LAG_S: f64 = 1000.0;

/// Share of the record in the longest lag: what was before the record is forgotten in a few of
/// them.
const LAG_OF_RECORD: f64 = 0.1;

/// Lags below lie evenly, above in even ratios; in seconds.
const SHORT_LAG_S: f64 = 2.0;

/// Lags that are not excluded when they lie close enough, and most refinements until they do.
const CLOSE: usize = 4;
const MOST_REFINEMENTS: usize = 6;

/// Degrees of freedom of what the noise is known from, and halvings of a range.
const DOF: [f64; 2] = [2.0, 10_000.0];
const BISECTIONS: usize = 30;

/// Why a record shows no temperature coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoCoefficient {
    /// Too few blocks in one stretch with samples and temperature.
    TooShort {
        /// Blocks in the longest stretch.
        blocks: usize,
    },
    /// The temperature kept within less than [`LEAST_EXCURSION_C`].
    Excursion {
        /// From the lowest to the highest block mean, in °C.
        excursion_c: f64,
    },
    /// The temperature only rose, or only fell: a drift of any other cause would look the same.
    OneDirection {
        /// Of temperature and time.
        correlation: f64,
    },
}

impl fmt::Display for NoCoefficient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { blocks } => {
                write!(f, "{blocks} consecutive blocks with samples and a temperature, {LEAST_BLOCKS} needed")
            }
            Self::Excursion { excursion_c } => {
                write!(f, "the temperature changed by {excursion_c:.1} °C, {LEAST_EXCURSION_C:.0} °C needed")
            }
            Self::OneDirection { correlation } => {
                let seen = if *correlation > 0.0 { "rose" } else { "fell" };
                write!(
                    f,
                    "the temperature only {seen} (correlation with time {correlation:+.2}), both directions are needed"
                )
            }
        }
    }
}

/// By how much the bias of one axis changes per degree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureCoefficient {
    /// In the unit of the channel per °C.
    pub value: f64,
    /// Lower end of the interval.
    pub lower: f64,
    /// Upper end of the interval.
    pub upper: f64,
    /// The first-order lag, in seconds, with which the axis most likely follows the temperature.
    pub lag_s: f64,
    /// The lags that the record does not exclude at the same level, in seconds.
    pub lag_range_s: (f64, f64),
    /// The longest lag that is searched is not excluded: the range may be wider.
    pub is_lag_open: bool,
    /// Probability that noise without any influence of the temperature would show as much, the
    /// number of lags that are searched allowed for.
    pub p: f64,
    /// Share of the temperature in the power of the level, 0 to 1: the largest of all octaves of
    /// frequency, with the noise as it is fitted.
    pub largest_share: f64,
}

/// The search for the temperature coefficients of the axes of one record: holds what they have in
/// common.
///
/// The regression of block means on the temperature, passed through a first-order lag, in white noise,
/// flicker noise and a random walk of any proportion, by the likelihood of their cosine
/// coefficients. The value is the likeliest one; its limits are quantiles of the likelihood, noise
/// fitted anew, over all lags that the record does not exclude, each as likely as any other. Before the
/// record the sensor is taken to have had the temperature that it begins with.
#[derive(Clone, Debug)]
pub struct TemperatureSearch {
    series: BlockSeries,
    transform: CosineTransform,
    bank: Vec<LaggedTemperature>,
    excursion_c: f64,
    correlation: f64,
}

/// The temperature behind a lag, by its cosine coefficients.
#[derive(Clone, Debug)]
struct LaggedTemperature {
    lag_s: f64,
    coefficients: Vec<f64>,
}

impl TemperatureSearch {
    /// In the longest stretch without a gap. `degrees_per_count` is of the temperature.
    ///
    /// Costs about a millisecond if there is a coefficient to be found, next to nothing
    /// elsewhere.
    ///
    /// # Errors
    /// Why there is none to be found.
    pub fn new(blocks: &TemperatureBlocks, interval_s: f64, degrees_per_count: f64) -> Result<Self, NoCoefficient> {
        let series = BlockSeries::longest(blocks, interval_s, degrees_per_count);
        let (excursion_c, correlation) = (series.excursion_c(), series.correlation_with_time());
        if series.temperatures_c.len() < LEAST_BLOCKS {
            return Err(NoCoefficient::TooShort { blocks: series.temperatures_c.len() });
        }
        if excursion_c.is_nan() || excursion_c < LEAST_EXCURSION_C {
            return Err(NoCoefficient::Excursion { excursion_c });
        }
        if correlation.is_nan() || correlation.abs() >= ONE_DIRECTION {
            return Err(NoCoefficient::OneDirection { correlation });
        }
        let longest_s = LONGEST_LAG_S.min(LAG_OF_RECORD * series.duration_s());
        let transform = CosineTransform::new(series.temperatures_c.len());
        let mut search = Self { series, transform, bank: Vec::new(), excursion_c, correlation };
        search.bank = search.lagged(0.0, log_lag(longest_s));
        Ok(search)
    }

    /// From the lowest to the highest block mean of the temperature, in °C.
    #[must_use]
    pub const fn excursion_c(&self) -> f64 {
        self.excursion_c
    }

    /// Of the temperature and time, -1 to 1.
    #[must_use]
    pub const fn correlation_with_time(&self) -> f64 {
        self.correlation
    }

    /// Of the axis with this number, `unit_per_count`: at the level `confidence`, 0 < p < 1. `None`
    /// for an axis that does not vary, and where there is no such axis.
    #[must_use]
    pub fn coefficient(&self, axis: usize, unit_per_count: f64, confidence: f64) -> Option<TemperatureCoefficient> {
        let z = chi_squared::normal_two_sided(confidence)?;
        let rows = Rows::of_level(self.transform.of(self.series.axes.get(axis)?));
        let without = rows.fit(&structure(&[]), None)?;
        let fit = |lagged: &LaggedTemperature| rows.fit(&structure(&[&lagged.coefficients]), Some(&without));
        let fits = |bank: &[LaggedTemperature]| bank.iter().map(fit).collect::<Option<Vec<Scored>>>();
        let (mut bank, mut fitted) = (self.bank.clone(), fits(&self.bank)?);
        let most = |fitted: &[Scored]| fitted.iter().map(|of| of.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        let drop = 0.5 * z * z;
        // of those that the record does not exclude, the first and the last
        let left = |fitted: &[Scored]| {
            let is_left = |of: &Scored| of.log_likelihood > most(fitted) - drop;
            Some((fitted.iter().position(is_left)?, fitted.iter().rposition(is_left)?))
        };
        // between the lags of the bank, as long as the record distinguishes them
        for _ in 0..MOST_REFINEMENTS {
            let (first, last) = left(&fitted)?;
            if last - first + 1 >= CLOSE || bank.len() < 2 {
                break;
            }
            let [from, to] =
                [first.saturating_sub(1), (last + 1).min(bank.len() - 1)].map(|place| log_lag(bank[place].lag_s));
            bank = self.lagged(from, to);
            fitted = fits(&bank)?;
        }
        let (first, last) = left(&fitted)?;
        let most = most(&fitted);
        let each = bank[first..=last].iter().zip(&fitted[first..=last]);
        let parts: Vec<Part> = each.filter_map(|(lagged, of)| Part::new(&rows, lagged, of, most, z)).collect();
        let likeliest =
            (first..=last).max_by(|a, b| fitted[*a].log_likelihood.total_cmp(&fitted[*b].log_likelihood))?;
        let value = *fitted[likeliest].multiples.first()?;
        let p = (2.0 * beyond(&parts, 0.0, -value.signum()) * bank.len() as f64).min(1.0);
        let [lower, upper] = [-1.0, 1.0].map(|sign| end(&parts, sign, confidence));
        let [value, lower, upper] = [value, lower?, upper?].map(|value| value * unit_per_count);
        let lag_range_s = (bank[first.saturating_sub(1)].lag_s, bank[(last + 1).min(bank.len() - 1)].lag_s);
        let is_lag_open = self.bank.last().is_some_and(|longest| lag_range_s.1 > 0.999 * longest.lag_s);
        let (lower, upper) = (lower.min(upper), lower.max(upper));
        let lag_s = bank[likeliest].lag_s;
        let largest_share = largest_share(&bank[likeliest], &fitted[likeliest]);
        Some(TemperatureCoefficient { value, lower, upper, lag_s, lag_range_s, is_lag_open, p, largest_share })
    }

    /// The temperature with lags from `from` to `to`, see [`log_lag`].
    fn lagged(&self, from: f64, to: f64) -> Vec<LaggedTemperature> {
        let lag_s = |place: usize| SHORT_LAG_S * (from + (to - from) * place as f64 / (LAGS - 1) as f64).exp_m1();
        let of =
            |lag_s: f64| LaggedTemperature { lag_s, coefficients: self.transform.of(&self.series.lagged_c(lag_s)) };
        (0..LAGS).map(|place| of(lag_s(place).max(0.0))).collect()
    }
}

/// Of the temperature in the power of any octave of frequency.
fn largest_share(lagged: &LaggedTemperature, fitted: &Scored) -> f64 {
    let multiple = fitted.multiples.first().copied().unwrap_or_default();
    let each: Vec<(f64, f64)> =
        lagged.coefficients.iter().zip(&fitted.expected).map(|(x, noise)| ((multiple * x).powi(2), *noise)).collect();
    let octaves = core::iter::successors(Some(1), |first| Some(2 * first)).take_while(|first| *first <= each.len());
    let share = |first: usize| {
        let octave = &each[first - 1..(2 * first - 1).min(each.len())];
        let (made, noise) = octave.iter().fold((0.0, 0.0), |(made, noise), (a, b)| (made + a, noise + b));
        made / (made + noise)
    };
    octaves.map(share).fold(0.0, f64::max)
}

/// Evenly spaced from lag to lag.
fn log_lag(lag_s: f64) -> f64 {
    (lag_s / SHORT_LAG_S).ln_1p()
}

/// The noise of the level, with a shape.
fn structure<'a>(shape: &[&'a Vec<f64>]) -> Structure<'a> {
    let shapes = shape.iter().map(|shape| shape.as_slice()).collect();
    Structure { components: vec![0, 1, 2], shapes, ..Structure::default() }
}

/// What one lag says of the coefficient: Student's distribution on either side of the likeliest value,
/// which the likelihood follows if the noise is known from as many coefficients as that has degrees
/// of freedom.
struct Part {
    weight: f64,
    value: f64,
    /// Below and above.
    sides: [Side; 2],
}

struct Side {
    scale: f64,
    dof: f64,
}

impl Part {
    fn new(rows: &Rows, lagged: &LaggedTemperature, best: &Scored, most: f64, z: f64) -> Option<Self> {
        let value = *best.multiples.first()?;
        let each = lagged.coefficients.iter().zip(&best.expected);
        let deviation = 1.0 / each.map(|(x, expected)| x * x / expected).sum::<f64>().sqrt();
        let sides = [-1.0, 1.0].map(|sign| {
            let fall = |distance: f64| {
                let held =
                    Structure { held_shape: Some(value + sign * distance), ..structure(&[&lagged.coefficients]) };
                rows.fit(&held, Some(best)).map_or(f64::INFINITY, |held| best.log_likelihood - held.log_likelihood)
            };
            Side::new(deviation, crossing(0.5 * z * z, deviation, fall), z)
        });
        let width: f64 = sides.iter().map(|side| side.scale).sum();
        let weight = (best.log_likelihood - most).exp() * width;
        weight.is_finite().then_some(Self { weight, value, sides })
    }

    const fn side(&self, sign: f64) -> &Side {
        &self.sides[if sign < 0.0 { 0 } else { 1 }]
    }
}

impl Side {
    /// The logarithm falls as that of a normal distribution about the middle, and by z²/2 at `distance`.
    fn new(deviation: f64, distance: f64, z: f64) -> Self {
        let square = (distance / deviation).powi(2);
        let [mut low, mut high] = DOF;
        for _ in 0..BISECTIONS {
            let dof = (low * high).sqrt();
            let falls = (dof + 1.0) * (square / (dof + 1.0)).ln_1p();
            if falls > z * z { high = dof } else { low = dof }
        }
        let dof = low;
        Self { scale: distance / (dof * (z * z / (dof + 1.0)).exp_m1()).sqrt(), dof }
    }
}

/// The probability of coefficients beyond `at`, above or below it, over all lags.
fn beyond(parts: &[Part], at: f64, sign: f64) -> f64 {
    let of = |part: &Part| {
        let off = sign * (at - part.value);
        let side = part.side(sign * off);
        let tail = 0.5 * chi_squared::student_two_sided_above(off.abs() / side.scale, side.dof).unwrap_or(1.0);
        part.weight * if off < 0.0 { 1.0 - tail } else { tail }
    };
    parts.iter().map(of).sum::<f64>() / parts.iter().map(|part| part.weight).sum::<f64>()
}

/// The end of the interval: between those of all lags alone.
fn end(parts: &[Part], sign: f64, confidence: f64) -> Option<f64> {
    let of = |part: &Part| {
        let side = part.side(sign);
        Some(part.value + sign * side.scale * chi_squared::student_two_sided(confidence, side.dof)?)
    };
    let ends = parts.iter().map(of).collect::<Option<Vec<f64>>>()?;
    let (mut low, mut high) =
        ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| (low.min(*end), high.max(*end)));
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let is_outside = beyond(parts, middle, sign) < 0.5 * (1.0 - confidence);
        if is_outside == (sign > 0.0) { high = middle } else { low = middle }
    }
    (low <= high).then_some(0.5 * (low + high))
}

#[cfg(test)]
mod tests;
