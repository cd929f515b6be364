//! What the fit takes of one channel.

use crate::infer::level_series::LevelSeries;
use crate::infer::narrow_bands::NarrowBand;
use crate::infer::roll_off::RollOff;
use crate::infer::slow_cycle::SlowCycle;

/// The statistics of one channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChannelCurve<'a> {
    /// In the order of the octaves, in the unit of the channel squared. If one is missing, zero
    /// or no number, nothing is observable.
    pub variances: &'a [f64],
    /// Slope of the regression line, in the unit of the channel per second; without it, a ramp is
    /// not observable and is not in the model.
    pub slope_unit_s: Option<f64>,
    /// Lines of its spectrum, in the unit of the channel.
    pub bands: &'a [NarrowBand],
    /// A cycle of its level, of few periods or many.
    pub cycle: Option<SlowCycle>,
    /// A filter slower than the output, where the spectrum shows one or may show one, and its
    /// transfer is unknown.
    pub roll_off: Option<RollOff>,
    /// The level over the same record, in the unit of the channel: it decides whether there is a
    /// random walk.
    pub level: Option<&'a LevelSeries>,
    /// Fourth cumulant of the samples, in the unit to the fourth: excess kurtosis times variance
    /// squared; 0 for a normal distribution. Independent samples with heavy tails make every
    /// octave less certain.
    pub fourth_cumulant: f64,
}

impl<'a> ChannelCurve<'a> {
    /// A channel without lines, cycle and filter, whose level is not known.
    #[must_use]
    pub const fn new(variances: &'a [f64], slope_unit_s: Option<f64>) -> Self {
        Self { variances, slope_unit_s, bands: &[], cycle: None, roll_off: None, level: None, fourth_cumulant: 0.0 }
    }
}
