//! Whether the values of a channel are normally distributed.

use thiserror::Error;

use crate::accumulate::moments::Moments;
use crate::accumulate::signal::ChannelSignal;
use crate::infer::chi_squared::normal_above;

/// Fewest effective samples: below, the standard errors, which hold for many, do not.
const MIN_EFFECTIVE: f64 = 1000.0;

/// Smallest one that rounding can be corrected for: the error of Sheppard's corrections is of the
/// order of exp(-2π²σ²), 6e-5 here.
const MIN_STD_COUNTS: f64 = 0.7;

/// Largest share of the variance in changes slower than a segment of the spectrum.
const MAX_SLOW_SHARE: f64 = 0.1;

/// Share of normal records that are taken not to be.
const LEAST_P: f64 = 0.01;

/// Skewness and excess kurtosis with standard errors that hold for correlated normal samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normality {
    /// Skewness of the values before rounding; 0 for normal ones.
    pub skewness: f64,
    /// Standard error of the skewness if the values are normal.
    pub skewness_error: f64,
    /// Excess kurtosis of the values before rounding; 0 for normal ones.
    pub excess_kurtosis: f64,
    /// Standard error of the excess kurtosis if the values are normal.
    pub excess_kurtosis_error: f64,
    /// Independent samples whose skewness has the same error, but for that of undoing the rounding.
    pub effective_samples: f64,
}

/// Why normality cannot be judged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NotJudged {
    /// Too few independent samples.
    #[error("at most {effective_samples:.0} independent samples, {needed:.0} needed")]
    TooShort {
        /// As many as there are; all samples before the spectrum has four segments.
        effective_samples: f64,
        /// As many as are needed.
        needed: f64,
    },
    /// The noise is too small against the last digit.
    #[error("standard deviation is {std_counts:.2} LSB, {needed:.1} LSB needed")]
    Quantised {
        /// Standard deviation in counts.
        std_counts: f64,
        /// As large as it must be.
        needed: f64,
    },
    /// The level drifts: the distribution is that of the drift, not of the noise.
    #[error("{:.0} % of the variance is slow drift, limit {:.0} %", 100.0 * .slow_share, 100.0 * .allowed)]
    Wandering {
        /// Share of the variance in changes slower than a segment of the spectrum.
        slow_share: f64,
        /// As large as it may be.
        allowed: f64,
    },
}

impl ChannelSignal {
    /// Whether the values are normally distributed, by the `moments` and the spectrum of the same
    /// samples.
    ///
    /// Standard errors: sqrt(6 Σρ³/n) and sqrt(24 Σρ⁴/n) over all lags of the autocorrelation ρ
    /// (Lomnicki, 1961). Rounding, which adds 1/12 to the variance and takes 1/120 from the fourth
    /// cumulant in counts (Sheppard, 1898), is undone, and the errors grow accordingly.
    ///
    /// # Errors
    /// Why it cannot be judged.
    pub fn normality(&self, moments: &Moments) -> Result<Normality, NotJudged> {
        let too_short = |effective_samples| NotJudged::TooShort { effective_samples, needed: MIN_EFFECTIVE };
        let n = moments.count() as f64;
        let shape = moments.variance_counts2().zip(moments.skewness()).zip(moments.excess_kurtosis());
        let Some(((sample_variance, skewness), excess_kurtosis)) = shape else {
            return Err(match moments.variance_counts2() {
                Some(_) => NotJudged::Quantised { std_counts: 0.0, needed: MIN_STD_COUNTS },
                None => too_short(0.0),
            });
        };
        if sample_variance < MIN_STD_COUNTS * MIN_STD_COUNTS {
            return Err(NotJudged::Quantised { std_counts: sample_variance.sqrt(), needed: MIN_STD_COUNTS });
        }
        let Some(autocovariances) = self.spectrum().autocovariances_counts2() else { return Err(too_short(n)) };
        let variance = sample_variance * (n - 1.0) / n;
        let within = autocovariances.first().copied().unwrap_or(0.0);
        let slow_share = 1.0 - within / variance;
        if slow_share > MAX_SLOW_SHARE {
            return Err(NotJudged::Wandering { slow_share, allowed: MAX_SLOW_SHARE });
        }
        // sums of the third and the fourth powers over all lags
        let (thirds, fourths) = autocovariances.iter().skip(1).fold((1.0, 1.0), |(thirds, fourths), covariance| {
            let autocorrelation = covariance / within;
            let third = autocorrelation * autocorrelation * autocorrelation;
            (thirds + 2.0 * third, fourths + 2.0 * third * autocorrelation)
        });
        let effective_samples = n / f64::max(thirds, 1.0);
        if effective_samples < MIN_EFFECTIVE {
            return Err(too_short(effective_samples));
        }
        let before_rounding = variance - 1.0 / 12.0;
        // What undoes the rounding of an estimate magnifies its error too.
        let magnified = variance / before_rounding;
        let fourth_cumulant = excess_kurtosis * variance * variance + 1.0 / 120.0;
        Ok(Normality {
            skewness: skewness * magnified.powf(1.5),
            skewness_error: (6.0 / effective_samples).sqrt() * magnified.powf(1.5),
            excess_kurtosis: fourth_cumulant / (before_rounding * before_rounding),
            excess_kurtosis_error: (24.0 * f64::max(fourths, 1.0) / n).sqrt() * magnified.powi(2),
            effective_samples,
        })
    }
}

impl Normality {
    /// Whether the values may be normal: true for 99 % of normal records.
    pub fn is_consistent(&self) -> bool {
        self.p() >= LEAST_P
    }

    /// The probability that normal values would show as much skewness or excess kurtosis.
    pub fn p(&self) -> f64 {
        let beyond =
            (self.skewness.abs() / self.skewness_error).max(self.excess_kurtosis.abs() / self.excess_kurtosis_error);
        // two-sided, of two figures
        (4.0 * normal_above(beyond)).min(1.0)
    }
}
