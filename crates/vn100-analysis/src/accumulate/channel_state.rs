//! One channel of a stream: unwrapped where it is an angle, and accumulated.

use imu_noise::{
    ChannelAccumulator, ChannelSignal, OctaveSum, Octaves, RecordShape, SpectrumPlan, TemperatureRemoval, Unwrap,
};
use vn100_protocol::{Channel, Quantity};

use crate::{
    averaging_times::AveragingTimes,
    detrend::Detrend,
    settings::Settings,
    snapshot::{ChannelSnapshot, RemovedTemperature},
};

#[derive(Debug, Clone)]
pub(crate) struct ChannelState {
    accumulator: ChannelAccumulator,
    /// The octaves of the deviation that the settings do not select; `None` where they are not
    /// kept.
    other: Option<Octaves>,
    /// Whether the regression line is removed.
    detrend: bool,
    /// Rows per sample of the channel.
    stride: u64,
    /// Absolute index of the next row.
    place: u64,
    signal: ChannelSignal,
    /// `None` for channels that are no angle.
    unwrap: Option<Unwrap>,
    /// Whether the angle turned too far for its counts, so that they started anew.
    pub(super) restarted: bool,
}

impl ChannelState {
    /// A channel without samples; `plan` is shared by all channels.
    pub(crate) fn new(channel: &Channel, settings: &Settings, plan: &SpectrumPlan) -> Self {
        let accumulator = ChannelAccumulator::new(settings.estimator, settings.deviation);
        let detrend = settings.detrend == Some(Detrend::Line);
        let accumulator = if detrend { accumulator.keeping_slope() } else { accumulator };
        let octaves_alone = settings.averaging_times == AveragingTimes::Octave;
        Self {
            other: settings.other_deviation.then(|| Octaves::new(settings.estimator, settings.deviation.other())),
            accumulator: if octaves_alone { accumulator } else { accumulator.keeping_runs() },
            detrend,
            stride: 1,
            place: 0,
            signal: ChannelSignal::new(plan),
            unwrap: turn_counts(channel).map(Unwrap::new),
            restarted: false,
        }
    }

    /// Takes one sample of this channel from every `stride` rows: the rows whose index is a
    /// multiple of the stride. To be called before the first row.
    pub(crate) fn set_stride(&mut self, stride: u64) {
        if stride == 1 {
            return;
        }
        self.stride = stride;
        let first = self.place.div_ceil(stride);
        self.accumulator = self.accumulator.clone().starting_at(first);
        self.other = self.other.take().map(|other| other.starting_at(first));
        self.signal = self.signal.clone().counting_missing().starting_at(first);
    }

    /// Rows are missing at this place; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        let rows = missing.unwrap_or(0);
        let samples_until = |place: u64| place.div_ceil(self.stride);
        let samples = samples_until(self.place + rows) - samples_until(self.place);
        self.place += rows;
        // missing rows among which there is no sample of the channel make no gap
        if rows == 0 || samples > 0 {
            self.accumulator.gap(missing.map(|_| samples));
            self.signal.gap(missing.map(|_| samples));
            self.gap_of_other(missing.map(|_| samples));
        }
    }

    fn gap_of_other(&mut self, missing: Option<u64>) {
        if let Some(other) = &mut self.other {
            other.gap(missing);
        }
    }

    /// Adds the counts of rows in time order; unwraps angles in place.
    pub(crate) fn push(&mut self, counts: &mut [i32]) {
        let first = self.place.next_multiple_of(self.stride) - self.place;
        self.place += counts.len() as u64;
        match usize::try_from(self.stride) {
            Ok(1) => self.push_samples(counts),
            Ok(stride) if first < counts.len() as u64 => {
                let mut samples: Vec<i32> = counts[first as usize..].iter().copied().step_by(stride).collect();
                self.push_samples(&mut samples);
            }
            _ => {}
        }
    }

    fn push_samples(&mut self, mut counts: &mut [i32]) {
        let Self { accumulator, other, signal, unwrap, restarted, .. } = self;
        loop {
            let together = unwrap.as_mut().map_or(counts.len(), |unwrap| unwrap.unwrap(counts));
            let (continuous, rest) = counts.split_at_mut(together);
            accumulator.push(continuous);
            signal.push(continuous);
            if let Some(other) = other {
                other.push(continuous);
            }
            if rest.is_empty() {
                return;
            }
            *restarted = true;
            accumulator.gap(Some(0));
            signal.gap(Some(0));
            if let Some(other) = other {
                other.gap(Some(0));
            }
            counts = rest;
        }
    }

    /// The results, without the contribution of the temperature where that is to be removed.
    pub(crate) fn snapshot(
        &self,
        printed_step_counts: f64,
        shape: &RecordShape,
        removal: Option<TemperatureRemoval>,
    ) -> ChannelSnapshot {
        let moments = self.accumulator.moments().clone();
        let slope_of_temperature = removal.as_ref().map_or(0.0, TemperatureRemoval::slope_counts);
        let slope_counts = self.accumulator.slope_counts().map(|slope| slope - slope_of_temperature);
        let measured: Vec<_> = self.accumulator.octaves().sums().map(|sum| self.detrended(sum)).collect();
        let removed_temperature = removal.map(|removal| RemovedTemperature::new(removal, &measured));
        let sums = removed_temperature.as_ref().map_or_else(|| measured.clone(), |removed| removed.without(&measured));
        let octaves: Vec<_> = sums.iter().map(OctaveSum::octave).collect();
        // an octave without windows has no variance, and no slope depends on it
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
            other_octaves: self.other.as_ref().map_or_else(Vec::new, |other| other.sums().collect()),
            points: Vec::new(),
            stride: self.stride,
            printed_step_counts,
            removed_temperature,
        }
    }

    /// The sums at these averaging factors, of those that have a window.
    pub(crate) fn points(&self, factors: &[u64]) -> Vec<OctaveSum> {
        let own = factors.iter().filter(|m| m.is_multiple_of(self.stride)).map(|m| m / self.stride);
        let sums = own.filter_map(|m| self.accumulator.octaves().sum_at(m));
        sums.map(|sum| self.detrended(sum)).collect()
    }

    fn detrended(&self, sum: OctaveSum) -> OctaveSum {
        match self.accumulator.slope_counts().filter(|_| self.detrend) {
            Some(slope_counts) => sum.without_slope(slope_counts),
            None => sum,
        }
    }
}

/// Counts of a full turn of an angle. `None` for other channels, and where a turn exceeds the range
/// of a count, so that no angle can wrap.
fn turn_counts(channel: &Channel) -> Option<i32> {
    let counts = (360.0 / channel.scale * 10_f64.powi(channel.decimals.into())).round();
    (channel.quantity == Quantity::Angle && counts < f64::from(i32::MAX)).then_some(counts as i32)
}

impl ChannelState {}

#[cfg(test)]
mod tests {
    use imu_noise::{Deviation, Estimator};
    use vn100_protocol::VNYMR;

    use super::*;

    fn state(channel: &Channel, settings: &Settings) -> ChannelState {
        ChannelState::new(channel, settings, &SpectrumPlan::new())
    }

    fn shape(samples: u64) -> RecordShape {
        RecordShape { samples, interval_s: 0.025, estimator: Estimator::Strided, deviation: Deviation::Allan }
    }

    #[test]
    fn a_turn_of_an_angle_has_its_counts() {
        let angle = |scale: f64, decimals: u8| turn_counts(&Channel { scale, decimals, ..VNYMR.channels[0].clone() });
        assert_eq!((angle(1.0, 3), angle(1.0, 2), angle(180.0, 3)), (Some(360_000), Some(36_000), Some(2000)));
        assert_eq!((angle(1.0, 6), angle(1.0, 7)), (Some(360_000_000), None));
        assert_eq!(turn_counts(&VNYMR.channels[9]), None);
    }

    #[test]
    fn an_angle_is_unwrapped() {
        let mut yaw = state(&VNYMR.channels[0], &Settings::default());
        yaw.push(&mut [179_990, -179_990, -179_970]);
        let snapshot = yaw.snapshot(1.0, &shape(3), None);
        assert_eq!((snapshot.moments.max_counts(), snapshot.branch_counts), (Some(180_030), 360_000));
        assert!(!yaw.restarted);
    }

    #[test]
    fn a_slope_is_removed_where_asked_for() {
        let ramp: Vec<i32> = (0..640).collect();
        for detrend in [false, true] {
            let settings = Settings { detrend: detrend.then_some(Detrend::Line), ..Settings::default() };
            let mut channel = state(&VNYMR.channels[9], &settings);
            channel.push(&mut ramp.clone());
            let snapshot = channel.snapshot(1.0, &shape(640), None);
            assert_eq!(snapshot.slope_counts, Some(1.0));
            let variance = snapshot.octaves.last().and_then(OctaveSum::variance_counts2);
            assert_eq!(variance.is_some_and(|variance| variance < 1e-6), detrend, "{variance:?}");
        }
    }

    #[test]
    fn a_gap_parts_windows_of_deviation_and_spectrum() {
        let mut channel = state(&VNYMR.channels[9], &Settings::default());
        channel.push(&mut [1, 2]);
        channel.gap(Some(32));
        channel.push(&mut [3, 4]);
        let snapshot = channel.snapshot(1.0, &shape(36), None);
        assert_eq!((snapshot.octaves[0].terms, snapshot.octaves.len()), (2, 1));
        let blocks = snapshot.signal.map(|signal| signal.blocks().iter().map(|block| block.count).collect::<Vec<_>>());
        assert_eq!(blocks, Some(vec![2, 2]));
        assert_eq!(snapshot.printed_step_counts, 1.0);
    }
}
