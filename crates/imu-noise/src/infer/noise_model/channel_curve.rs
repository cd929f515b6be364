//! What the fit takes of one channel.

use crate::accumulate::signal::ChannelSignal;
use crate::infer::narrow_bands::NarrowBand;

/// The statistics of one channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChannelCurve<'a> {
    /// In the order of the octaves, in the unit of the channel squared. If one is missing, zero
    /// or no number, nothing is observable.
    pub variances: &'a [f64],
    /// The mean may have a ramp; not across a gap of unknown length. It is observable only with the
    /// blocks of `signal`.
    pub has_ramp: bool,
    /// Spectrum and blocks of the same record, and one count in the unit of the channel. Without
    /// them the octaves alone decide, which do not tell a short filter from white noise.
    pub signal: Option<(&'a ChannelSignal, f64)>,
    /// Lines of its spectrum, in the unit of the channel.
    pub bands: &'a [NarrowBand],
    /// The averaging on board is known, and nothing else is known to filter.
    pub is_averaging_known: bool,
    /// Fourth cumulant of the samples, in the unit to the fourth: excess kurtosis times variance squared;
    /// 0 for a normal distribution. Heavy tails make every octave less certain.
    pub fourth_cumulant: f64,
}

impl<'a> ChannelCurve<'a> {
    /// A channel without lines, of which the octaves alone are known.
    pub const fn new(variances: &'a [f64], has_ramp: bool) -> Self {
        Self { variances, has_ramp, signal: None, bands: &[], is_averaging_known: false, fourth_cumulant: 0.0 }
    }
}
