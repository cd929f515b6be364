//! One channel of a stream: unwrapped where it is an angle, and accumulated.

use imu_noise::{ChannelAccumulator, ChannelSignal, OctaveSum, RecordShape, SpectrumPlan, Unwrap};
use vn100_protocol::{Channel, Quantity};

use crate::{settings::Settings, snapshot::ChannelSnapshot};

/// What is kept of one channel.
#[derive(Debug)]
pub(crate) struct ChannelState {
    accumulator: ChannelAccumulator,
    detrend: bool,
    signal: ChannelSignal,
    /// Angles only.
    unwrap: Option<Unwrap>,
    /// The angle turned too far for its counts, and they started anew.
    restarted: bool,
}

impl ChannelState {
    /// `plan` is shared by all channels.
    pub(crate) fn new(channel: &Channel, settings: &Settings, plan: &SpectrumPlan) -> Self {
        let accumulator = ChannelAccumulator::new(settings.estimator, settings.deviation);
        Self {
            accumulator: if settings.detrend { accumulator.keeping_slope() } else { accumulator },
            detrend: settings.detrend,
            signal: ChannelSignal::new(plan),
            unwrap: turn_counts(channel).map(Unwrap::new),
            restarted: false,
        }
    }

    /// Samples are missing here; `None` where nobody knows how many.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        self.accumulator.gap(missing);
        self.signal.gap(missing);
    }

    /// Whether the angle turned too far for its counts, and they started anew.
    pub(crate) fn has_restarted(&self) -> bool {
        self.restarted
    }

    /// Takes samples in time order; unwraps them in place.
    pub(crate) fn push(&mut self, mut counts: &mut [i32]) {
        let Self { accumulator, signal, unwrap, restarted, .. } = self;
        loop {
            let together = unwrap.as_mut().map_or(counts.len(), |unwrap| unwrap.unwrap(counts));
            let (continuous, rest) = counts.split_at_mut(together);
            accumulator.push(continuous);
            signal.push(continuous);
            if rest.is_empty() {
                return;
            }
            *restarted = true;
            accumulator.gap(Some(0));
            signal.gap(Some(0));
            counts = rest;
        }
    }

    pub(crate) fn snapshot(&self, printed_decimals: u8, shape: &RecordShape) -> ChannelSnapshot {
        let moments = self.accumulator.moments().clone();
        let slope_counts = self.accumulator.slope_counts();
        let sums = self.accumulator.octaves().sums();
        let sums: Vec<_> = match slope_counts.filter(|_| self.detrend) {
            Some(slope_counts) => sums.map(|sum| sum.without_slope(slope_counts)).collect(),
            None => sums.collect(),
        };
        let octaves: Vec<_> = sums.iter().map(OctaveSum::octave).collect();
        // an octave that could not be read would be zero windows; the slope to it is then no number, and left out
        let variances: Vec<_> = sums.iter().map(|sum| sum.variance_counts2().unwrap_or(f64::NAN)).collect();
        let mean = moments.mean_counts().unwrap_or(0.0);
        ChannelSnapshot {
            branch_counts: self.unwrap.as_ref().map_or(0, |unwrap| unwrap.turn_offset_counts(mean)),
            moments,
            histogram: self.accumulator.histogram().clone(),
            noise_types: self.accumulator.noise_types(&octaves, &variances, shape),
            slope_counts,
            signal: Some(self.signal.clone()),
            octaves: sums,
            printed_decimals,
        }
    }
}

/// The counts of a full turn, for an angle; `None` too where they are more than a count can hold,
/// and no angle can wrap.
fn turn_counts(channel: &Channel) -> Option<i32> {
    let counts = (360.0 / channel.scale * 10_f64.powi(channel.decimals.into())).round();
    (channel.quantity == Quantity::Angle && counts < f64::from(i32::MAX)).then_some(counts as i32)
}
