//! One channel of a stream: unwrapped where it is an angle, and accumulated.

use imu_noise::{ChannelAccumulator, ChannelSignal, OctaveSum, SpectrumPlan, Stretch, Unwrap, WindowPlans};
use vn100_protocol::{Channel, Quantity};

use crate::{averaging_times::AveragingTimes, settings::Settings, snapshot::ChannelSnapshot};

#[derive(Debug, Clone)]
pub(crate) struct ChannelState {
    accumulator: ChannelAccumulator,
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
        let octaves_alone = settings.averaging_times == AveragingTimes::Octave;
        Self {
            accumulator: if octaves_alone { accumulator } else { accumulator.keeping_runs() },
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
        self.stride = stride;
        if stride > 1 {
            self.signal = self.signal.clone().counting_missing();
        }
    }

    /// Rows are missing at this place; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        let rows = missing.unwrap_or(0);
        let samples = self.pass(rows);
        // missing rows among which there is no sample of the channel make no gap
        if rows == 0 || samples > 0 {
            self.accumulator.gap(missing.map(|_| samples));
            self.signal.gap(missing.map(|_| samples));
        }
    }

    /// Adds the counts of the rows of a stretch; unwraps angles in place. `plans` are for all
    /// channels of the rows.
    pub(crate) fn push(&mut self, counts: &mut [i32], rows: &Stretch, plans: &mut WindowPlans) {
        if self.stride == 1 {
            self.place += rows.places() as u64;
            return self.push_samples(counts, *rows, plans);
        }
        let (mut samples, mut stretch) = (Vec::new(), Stretch::EMPTY);
        for (missing, run) in rows.runs_of(counts) {
            stretch.push(self.pass(missing as u64) as usize, false);
            let is_sample = |place: &u64| place.is_multiple_of(self.stride);
            samples.extend((self.place..).zip(run).filter(|(place, _)| is_sample(place)).map(|(_, count)| *count));
            stretch.push(self.pass(run.len() as u64) as usize, true);
        }
        self.push_samples(&mut samples, stretch, plans);
    }

    /// Passes so many rows. Returns the number of samples of the channel among them.
    fn pass(&mut self, rows: u64) -> u64 {
        let samples_until = |place: u64| place.div_ceil(self.stride);
        let before = samples_until(self.place);
        self.place += rows;
        samples_until(self.place) - before
    }

    fn push_samples(&mut self, mut counts: &mut [i32], mut stretch: Stretch, plans: &mut WindowPlans) {
        let Self { accumulator, signal, unwrap, restarted, .. } = self;
        loop {
            let together = unwrap.as_mut().map_or(counts.len(), |unwrap| unwrap.unwrap(counts));
            let (continuous, rest) = counts.split_at_mut(together);
            let [before, after] =
                if rest.is_empty() { [stretch, Stretch::EMPTY] } else { stretch.split_before_sample(together) };
            accumulator.push_stretch(continuous, &before, plans);
            signal.push_stretch(continuous, &before);
            if rest.is_empty() {
                return;
            }
            *restarted = true;
            accumulator.gap(Some(0));
            signal.gap(Some(0));
            (counts, stretch) = (rest, after);
        }
    }

    /// The results.
    pub(crate) fn snapshot(&self, printed_step_counts: f64) -> ChannelSnapshot {
        let moments = self.accumulator.moments().clone();
        let mean = moments.mean_counts().unwrap_or(0.0);
        ChannelSnapshot {
            branch_counts: self.unwrap.as_ref().map_or(0, |unwrap| unwrap.turn_offset_counts(mean)),
            moments,
            histogram: self.accumulator.histogram().clone(),
            signal: Some(self.signal.clone()),
            octaves: self.accumulator.octaves().sums().collect(),
            points: Vec::new(),
            stride: self.stride,
            printed_step_counts,
        }
    }

    /// The sums at these averaging factors, of those that have a window.
    pub(crate) fn points(&self, factors: &[u64]) -> Vec<OctaveSum> {
        let own = factors.iter().filter(|m| m.is_multiple_of(self.stride)).map(|m| m / self.stride);
        own.filter_map(|m| self.accumulator.octaves().sum_at(m)).collect()
    }
}

/// Counts of a full turn of an angle. `None` for other channels, and where a turn exceeds the range
/// of a count, so that no angle can wrap.
fn turn_counts(channel: &Channel) -> Option<i32> {
    let counts = (360.0 / channel.scale * 10_f64.powi(channel.decimals.into())).round();
    (channel.quantity == Quantity::Angle && counts < f64::from(i32::MAX)).then_some(counts as i32)
}

#[cfg(test)]
mod tests {
    use vn100_protocol::VNYMR;

    use super::*;

    fn state(channel: &Channel, settings: &Settings) -> ChannelState {
        ChannelState::new(channel, settings, &SpectrumPlan::new())
    }

    fn push(channel: &mut ChannelState, counts: &mut [i32]) {
        channel.push(counts, &Stretch::full(counts.len()), &mut WindowPlans::new());
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
        push(&mut yaw, &mut [179_990, -179_990, -179_970]);
        let snapshot = yaw.snapshot(1.0);
        assert_eq!((snapshot.moments.max_counts(), snapshot.branch_counts), (Some(180_030), 360_000));
        assert!(!yaw.restarted);
    }

    #[test]
    fn a_gap_parts_windows_of_deviation_and_spectrum() {
        let mut channel = state(&VNYMR.channels[9], &Settings::default());
        push(&mut channel, &mut [1, 2]);
        channel.gap(Some(32));
        push(&mut channel, &mut [3, 4]);
        let snapshot = channel.snapshot(1.0);
        assert_eq!((snapshot.octaves[0].terms, snapshot.octaves.len()), (2, 1));
        let blocks = snapshot.signal.map(|signal| signal.blocks().iter().map(|block| block.count).collect::<Vec<_>>());
        assert_eq!(blocks, Some(vec![2, 2]));
        assert_eq!(snapshot.printed_step_counts, 1.0);
    }
}
