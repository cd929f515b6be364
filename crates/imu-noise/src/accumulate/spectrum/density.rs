//! The spectrum as a power spectral density.

use super::{LONG, MIN_LONG_SEGMENTS, SHORT, Spectrum};
use crate::accumulate::counts::counts_to_unit;

/// Which frequencies a density counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sides {
    /// Positive ones only, as spectrum analysers show it: √2 times the two-sided amplitude, twice
    /// its power. White noise has the power density 2 N².
    One,
    /// Negative ones too, as IEEE Std 952 has it: the amplitude density is N itself, the power
    /// density N².
    Two,
}

/// A power spectral density at evenly spaced frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// Which frequencies it is spread over.
    pub sides: Sides,
    /// Samples of a segment.
    pub segment_samples: usize,
    /// Segments transformed.
    pub segments: u64,
    /// Independent segments that average as well. Each point has about twice as many degrees of
    /// freedom (the last point, at half the sampling rate, as many).
    pub averages: f64,
    /// From the first frequency above zero, 1/(segment_samples·interval), to half the sampling
    /// rate. Windowing spreads a line over four points; the first point is low, since each segment
    /// lost its mean.
    pub points: Vec<DensityPoint>,
}

/// One point of a [`Density`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityPoint {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Density in unit²/Hz.
    pub density_unit2_hz: f64,
}

/// The spectrum of the segments that are read out, in counts².
#[derive(Clone, Debug)]
pub(crate) struct Powers {
    pub(crate) segment_samples: usize,
    pub(crate) segments: u64,
    pub(crate) averages: f64,
    /// Means of |X_k|²/n for k = 0..=n/2.
    pub(crate) powers: Vec<f64>,
}

impl Spectrum {
    /// The density of a channel sampled every `interval_s` seconds with `decimals` digits. `None`
    /// before the first segment is full, and where `interval_s` is not positive.
    #[must_use]
    pub fn density(&self, sides: Sides, interval_s: f64, decimals: u8) -> Option<Density> {
        let Powers { segment_samples, segments, averages, powers } = self.powers()?;
        if interval_s.is_nan() || interval_s <= 0.0 {
            return None;
        }
        let step_hz = 1.0 / (segment_samples as f64 * interval_s);
        let points = powers.iter().enumerate().skip(1).map(|(k, power)| {
            // Half the sampling rate is its own negative.
            let both = sides == Sides::One && 2 * k != segment_samples;
            let counts2_hz = power * interval_s * if both { 2.0 } else { 1.0 };
            let density_unit2_hz = counts_to_unit(counts_to_unit(counts2_hz, decimals), decimals);
            DensityPoint { frequency_hz: k as f64 * step_hz, density_unit2_hz }
        });
        Some(Density { sides, segment_samples, segments, averages, points: points.collect() })
    }

    /// Autocovariances within segments, by the theorem of Wiener and Khinchin, in counts², from lag
    /// 0 to a quarter of a segment: so far the window takes at most 35 % of them. `None` before
    /// four segments are full.
    pub(crate) fn autocovariances_counts2(&self) -> Option<Vec<f64>> {
        let Powers { segment_samples, powers, .. } = self.powers().filter(|powers| powers.segments >= 4)?;
        let step = std::f64::consts::TAU / segment_samples as f64;
        let cosines: Vec<_> = (0..segment_samples).map(|i| (step * i as f64).cos()).collect();
        let covariance = |lag: usize| {
            let both_sides = powers.iter().enumerate().skip(1).map(|(k, power)| {
                let sides = if 2 * k == segment_samples { 1.0 } else { 2.0 };
                sides * power * cosines[lag * k % segment_samples]
            });
            both_sides.sum::<f64>() / segment_samples as f64
        };
        Some((0..=segment_samples / 4).map(covariance).collect())
    }

    /// The long segments where there are enough of them, else the short ones.
    pub(crate) fn powers(&self) -> Option<Powers> {
        if self.long.segments() >= MIN_LONG_SEGMENTS {
            Some(Powers {
                segment_samples: LONG,
                segments: self.long.segments(),
                averages: self.long.averages(),
                powers: self.long.powers().collect(),
            })
        } else if self.short.segments() > 0 {
            Some(Powers {
                segment_samples: SHORT,
                segments: self.short.segments(),
                averages: self.short.averages(),
                powers: self.short.powers().collect(),
            })
        } else {
            None
        }
    }
}
