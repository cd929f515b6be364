//! The temperature coefficient of the bias, and the share of the temperature in the deviations.

mod contribution;
mod series;

use core::fmt;

use super::chi_squared;
use super::level_series::CosineTransform;
use super::noise_model::{Rows, Scored, Structure, crossing};
use crate::accumulate::temperature_blocks::TemperatureBlocks;
pub use contribution::TemperatureContribution;
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
    /// search for the lag allowed for.
    pub p: f64,
}

/// The search for the temperature coefficients of the axes of one record: holds what they have in
/// common.
///
/// The regression of block means on the temperature, passed through a first-order lag, in white noise,
/// flicker noise and a random walk of any proportion, by the likelihood of their cosine
/// coefficients. The value is the likeliest one; its limits are where the likelihood, noise and lag
/// fitted anew, has fallen by what the level allows. Before the record the sensor is taken to have
/// had the temperature that it begins with.
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
        let evidence = (2.0 * (most(&fitted) - without.log_likelihood)).max(0.0).sqrt();
        let p = (2.0 * chi_squared::normal_above(evidence) * bank.len() as f64).min(1.0);
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
        let limit = |sign: f64| {
            let each = bank[first..=last].iter().zip(&fitted[first..=last]);
            each.filter_map(|(lagged, of)| limit_of(&rows, lagged, of, sign, drop - (most - of.log_likelihood)))
                .fold(f64::NEG_INFINITY, |farthest, limit| farthest.max(sign * limit))
        };
        let likeliest =
            (first..=last).max_by(|a, b| fitted[*a].log_likelihood.total_cmp(&fitted[*b].log_likelihood))?;
        let [value, lower, upper] =
            [*fitted[likeliest].multiples.first()?, -limit(-1.0), limit(1.0)].map(|value| value * unit_per_count);
        let lag_range_s = (bank[first.saturating_sub(1)].lag_s, bank[(last + 1).min(bank.len() - 1)].lag_s);
        let is_lag_open = self.bank.last().is_some_and(|longest| lag_range_s.1 > 0.999 * longest.lag_s);
        let (lower, upper) = (lower.min(upper), lower.max(upper));
        let lag_s = bank[likeliest].lag_s;
        Some(TemperatureCoefficient { value, lower, upper, lag_s, lag_range_s, is_lag_open, p })
    }

    /// The temperature with lags from `from` to `to`, see [`log_lag`].
    fn lagged(&self, from: f64, to: f64) -> Vec<LaggedTemperature> {
        let lag_s = |place: usize| SHORT_LAG_S * (from + (to - from) * place as f64 / (LAGS - 1) as f64).exp_m1();
        let of =
            |lag_s: f64| LaggedTemperature { lag_s, coefficients: self.transform.of(&self.series.lagged_c(lag_s)) };
        (0..LAGS).map(|place| of(lag_s(place).max(0.0))).collect()
    }

    /// What the temperature contributes with this coefficient to the axis with this number.
    #[must_use]
    pub fn contribution(&self, axis: usize, counts_per_degree: f64, lag_s: f64) -> Option<TemperatureContribution> {
        TemperatureContribution::new(&self.series, axis, counts_per_degree, lag_s)
    }
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

/// Where the likelihood with this lag has fallen by `drop`, above or below.
fn limit_of(rows: &Rows, lagged: &LaggedTemperature, best: &Scored, sign: f64, drop: f64) -> Option<f64> {
    let value = *best.multiples.first()?;
    let each = lagged.coefficients.iter().zip(&best.expected);
    let information: f64 = each.map(|(x, expected)| x * x / expected).sum();
    let fall = |distance: f64| {
        let held = Structure { held_shape: Some(value + sign * distance), ..structure(&[&lagged.coefficients]) };
        rows.fit(&held, Some(best)).map_or(f64::INFINITY, |held| best.log_likelihood - held.log_likelihood)
    };
    (drop > 0.0).then(|| value + sign * crossing(drop, 1.0 / information.sqrt(), fall))
}

#[cfg(test)]
mod tests;
