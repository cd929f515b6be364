//! The temperature coefficient of the bias.

mod series;

use thiserror::Error;

use super::chi_squared;
use super::level_series::CosineTransform;
use super::noise_model::{Rows, Scored, Structure};
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

/// Lags that are not excluded if they lie close enough, and how near the range of lags ends at the latest.
const CLOSE: usize = 4;
const FINEST: f64 = 1e-3;

/// No sensor follows its own thermometer later than this, in seconds.
const LONGEST_LAG_S: f64 = 1000.0;

/// Share of the record in the longest lag: what was before is forgotten in a few of them.
const LAG_OF_RECORD: f64 = 0.1;

/// Lags below lie evenly, above in even ratios; in seconds.
const SHORT_LAG_S: f64 = 2.0;

/// More than a normal distribution has, at the limits: the noise is known from few coefficients.
const UNKNOWN_NOISE: f64 = 1.1;

/// Why an axis has no temperature coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoCoefficient {
    /// The sensor was moved.
    #[error("the sensor was moved")]
    Moved,
    /// The stream does not carry the bias of the axis.
    #[error("the bias is not in the stream")]
    BiasNotInStream,
    /// The values do not vary.
    #[error("the values do not vary")]
    Constant,
    /// Too few blocks in one stretch with samples and temperature.
    #[error("{blocks} consecutive blocks with samples and a temperature, {LEAST_BLOCKS} needed")]
    TooShort {
        /// Blocks in the longest stretch.
        blocks: usize,
    },
    /// The temperature kept within less than [`LEAST_EXCURSION_C`].
    #[error("the temperature changed by {excursion_c:.1} °C, {LEAST_EXCURSION_C:.0} °C needed")]
    Excursion {
        /// From the lowest to the highest block mean, in °C.
        excursion_c: f64,
    },
    /// The temperature only rose, or only fell: a drift of any other cause would look the same.
    #[error(
        "the temperature only {} (correlation with time {correlation:+.2}), both directions are needed",
        if *.correlation > 0.0 { "rose" } else { "fell" }
    )]
    OneDirection {
        /// Of temperature and time.
        correlation: f64,
    },
}

impl NoCoefficient {
    /// The code of the reason in results.
    pub const fn code(self) -> &'static str {
        match self {
            Self::Moved => "moved",
            Self::BiasNotInStream => "bias-not-in-stream",
            Self::Constant => "constant",
            Self::TooShort { .. } => "too-short",
            Self::Excursion { .. } => "excursion",
            Self::OneDirection { .. } => "one-direction",
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
    /// Probability that noise alone would show as much at any of the lags that are searched.
    pub p: f64,
    /// Share of the temperature in the power of the level, 0 to 1: the largest of all octaves.
    pub largest_share: f64,
}

/// The search for the temperature coefficients of the axes of one record.
///
/// The regression of block means on the temperature, passed through a first-order lag, in white noise,
/// flicker noise and a random walk of any proportion, by the likelihood of their cosine coefficients.
/// Limits are where the likelihood has fallen by what the level allows, noise and lag fitted anew.
/// Before the record the sensor is taken to have had the temperature that it begins with.
#[derive(Clone, Debug)]
pub struct TemperatureSearch {
    series: BlockSeries,
    transform: CosineTransform,
    bank: Vec<LaggedTemperature>,
    /// From the lowest to the highest block mean of the temperature, in °C.
    pub excursion_c: f64,
    /// Of the temperature and time, -1 to 1.
    pub correlation_with_time: f64,
}

/// The temperature behind a lag, by its cosine coefficients.
#[derive(Clone, Debug)]
struct LaggedTemperature {
    lag_s: f64,
    coefficients: Vec<f64>,
}

impl LaggedTemperature {
    fn structure(&self) -> Structure<'_> {
        Structure::of_level(&[&self.coefficients])
    }
}

impl TemperatureSearch {
    /// In the longest stretch without a gap. `degrees_per_count` is of the temperature.
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
        let mut search = Self { series, transform, bank: Vec::new(), excursion_c, correlation_with_time: correlation };
        search.bank = search.lagged(0.0, longest_s);
        Ok(search)
    }

    /// The temperature with lags from one to another, evenly spaced in ln(1 + lag/2 s).
    fn lagged(&self, from_s: f64, to_s: f64) -> Vec<LaggedTemperature> {
        let [from, to] = [from_s, to_s].map(|lag_s| (lag_s / SHORT_LAG_S).ln_1p());
        let of = |place: usize| {
            let part = place as f64 / (LAGS - 1) as f64;
            let lag_s = (SHORT_LAG_S * (from + (to - from) * part).exp_m1()).max(0.0);
            LaggedTemperature { lag_s, coefficients: self.transform.of(&self.series.lagged_c(lag_s)) }
        };
        (0..LAGS).map(of).collect()
    }

    /// Of the axis with this number, `unit_per_count`: at the level `confidence`, 0 < p < 1. `None`
    /// for an axis that does not vary, and where there is no such axis.
    pub fn coefficient(&self, axis: usize, unit_per_count: f64, confidence: f64) -> Option<TemperatureCoefficient> {
        let z = chi_squared::normal_two_sided(confidence)?;
        let rows = Rows::of_level(self.transform.of(self.series.axes.get(axis)?));
        let without = rows.fit(&Structure::of_level(&[]), None)?;
        let drop = 0.5 * z * z * UNKNOWN_NOISE;
        let mut bank = self.bank.clone();
        // between the lags that the record does not exclude, as long as it distinguishes those of the bank
        let (fitted, likeliest, first, last) = loop {
            let fit = |lagged: &LaggedTemperature| rows.fit(&lagged.structure(), Some(&without));
            let fitted = bank.iter().map(fit).collect::<Option<Vec<Scored>>>()?;
            let of = |place: usize| fitted[place].log_likelihood;
            let likeliest = (0..LAGS).max_by(|a, b| of(*a).total_cmp(&of(*b)))?;
            let is_left = |place: &usize| of(*place) > of(likeliest) - drop;
            let (first, last) = ((0..LAGS).find(is_left)?, (0..LAGS).rfind(is_left)?);
            let [from_s, to_s] = [first.saturating_sub(1), (last + 1).min(LAGS - 1)].map(|place| bank[place].lag_s);
            if last - first + 1 >= CLOSE || to_s < (1.0 + FINEST) * from_s {
                break (fitted, likeliest, first, last);
            }
            bank = self.lagged(from_s, to_s);
        };
        let most = fitted[likeliest].log_likelihood;
        let limit = |sign: f64| {
            let of = |place: usize| {
                let best = &fitted[place];
                let left = (drop - (most - best.log_likelihood)).max(0.0);
                Some(sign * rows.limit_of_multiple(&bank[place].structure(), best, sign, left)?)
            };
            Some(sign * (first..=last).filter_map(of).reduce(f64::max)?)
        };
        let rise = (most - without.log_likelihood).max(0.0);
        let p = (2.0 * chi_squared::normal_above((2.0 * rise).sqrt()) * LAGS as f64).min(1.0);
        let value = *fitted[likeliest].multiples.first()?;
        let [value, a, b] = [value, limit(-1.0)?, limit(1.0)?].map(|value| value * unit_per_count);
        let (lower, upper) = (a.min(b), a.max(b));
        let lag_range_s = (bank[first.saturating_sub(1)].lag_s, bank[(last + 1).min(LAGS - 1)].lag_s);
        let is_lag_open = self.bank.last().is_some_and(|longest| lag_range_s.1 > 0.999 * longest.lag_s);
        let lag_s = bank[likeliest].lag_s;
        let largest_share = largest_share(&bank[likeliest], &fitted[likeliest]);
        Some(TemperatureCoefficient { value, lower, upper, lag_s, lag_range_s, is_lag_open, p, largest_share })
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

#[cfg(test)]
mod tests;
