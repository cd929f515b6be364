//! The temperature coefficient of the bias, and the share of the temperature in the deviations.

mod contribution;
mod noise_mixture;
mod series;

use core::fmt;

use crate::accumulate::temperature_blocks::TemperatureBlocks;
pub use contribution::TemperatureContribution;
use noise_mixture::{Candidate, NoiseMixture, Regressor};
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

/// A lag with a smaller share of the weight of the likeliest one is excluded.
const EXCLUDED: f64 = 1e-3;

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
/// The regression of block means on the temperature, passed through a first-order lag, by
/// generalised least squares: block means of white noise, flicker noise and a random walk with a
/// free level have nearly independent cosine coefficients with known variances in the proportion of
/// the three. That proportion, and the lag, are weighed by their restricted likelihood, and the
/// interval is that of the mixture: it holds what the record leaves open of N, B, K and the lag.
/// The value is a median of it. Before the record the sensor is taken to have had the temperature
/// that it begins with.
#[derive(Clone, Debug)]
pub struct TemperatureSearch {
    series: BlockSeries,
    mixture: NoiseMixture,
    /// Cosine coefficients of the temperature in use.
    reach: usize,
    bank: Vec<Regressor>,
    excursion_c: f64,
    correlation: f64,
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
        let mixture = NoiseMixture::new(series.temperatures_c.len());
        let longest_s = LONGEST_LAG_S.min(LAG_OF_RECORD * series.duration_s());
        let reach = mixture.reach(&series.temperatures_c);
        let mut search = Self { series, mixture, reach, bank: Vec::new(), excursion_c, correlation };
        search.bank = search.regressors(0.0, log_lag(longest_s));
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
        let values = self.series.axes.get(axis)?;
        let axis = self.mixture.axis(values)?;
        let first = axis.candidates(&self.bank);
        let p = self.bank.iter().map(|regressor| noise_mixture::two_sided(&first, regressor.lag_s));
        let p = (p.fold(1.0, f64::min) * self.bank.len() as f64).min(1.0);
        // between the lags of the bank, as long as the record distinguishes them
        let (mut regressors_now, mut candidates) = (self.bank.clone(), first);
        for _ in 0..MOST_REFINEMENTS {
            let weights = noise_mixture::weights_of_lags(&candidates, &regressors_now);
            let highest = weights.iter().fold(0.0, |a: f64, b| a.max(*b));
            let is_left = |place: &usize| weights[*place] > EXCLUDED * highest;
            let left: Vec<usize> = (0..weights.len()).filter(is_left).collect();
            let (Some(first), Some(last)) = (left.first(), left.last()) else { return None };
            if left.len() >= CLOSE || regressors_now.len() < 2 {
                break;
            }
            let (from, to) = (first.saturating_sub(1), (last + 1).min(weights.len() - 1));
            let [from, to] = [from, to].map(|place| log_lag(regressors_now[place].lag_s));
            regressors_now = self.regressors(from, to);
            candidates = axis.candidates(&regressors_now);
        }
        let risk = (1.0 - confidence) / 2.0;
        let [value, lower, upper] = [0.5, risk, 1.0 - risk]
            .map(|p| noise_mixture::quantile(&candidates, p).map(|value| value * unit_per_count));
        let (value, lower, upper) = (value?, lower?, upper?);
        let (lag_s, lag_range_s) = lags(&candidates, &regressors_now, risk)?;
        let (lower, upper) = (lower.min(upper), lower.max(upper));
        let is_lag_open = self.bank.last().is_some_and(|longest| lag_range_s.1 > 0.999 * longest.lag_s);
        Some(TemperatureCoefficient { value, lower, upper, lag_s, lag_range_s, is_lag_open, p })
    }

    /// The temperature with lags from `from` to `to`, see [`log_lag`].
    fn regressors(&self, from: f64, to: f64) -> Vec<Regressor> {
        let lag_s = |place: usize| SHORT_LAG_S * (from + (to - from) * place as f64 / (LAGS - 1) as f64).exp_m1();
        let lags_s = (0..LAGS).map(|place| lag_s(place).max(0.0));
        lags_s.map(|lag_s| self.mixture.regressor(&self.series.lagged_c(lag_s), lag_s, self.reach)).collect()
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

/// The likeliest lag, and those that hold all but twice the `risk`, to the next one examined.
fn lags(candidates: &[Candidate], regressors: &[Regressor], risk: f64) -> Option<(f64, (f64, f64))> {
    let weights = noise_mixture::weights_of_lags(candidates, regressors);
    let total: f64 = weights.iter().sum();
    let likeliest = (0..weights.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
    let reaches = |share: f64| {
        let mut sum = 0.0;
        let reached = weights.iter().position(|weight| {
            sum += weight;
            sum >= share * total
        });
        reached.unwrap_or(weights.len() - 1)
    };
    let (lower, upper) = (reaches(risk).saturating_sub(1), (reaches(1.0 - risk) + 1).min(weights.len() - 1));
    Some((regressors[likeliest].lag_s, (regressors[lower].lag_s, regressors[upper].lag_s)))
}

#[cfg(test)]
mod tests;
