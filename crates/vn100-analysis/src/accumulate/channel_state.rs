//! One channel of a stream: unwrapped where it is an angle, and accumulated.

use imu_noise::{ChannelSignal, Histogram, Moments, OctaveSum, Octaves, SpectrumPlan, Stretch, Unwrap, WindowPlans};
use vn100_protocol::{Channel, Quantity};

use crate::{settings::Settings, snapshot::ChannelSnapshot};

#[derive(Debug, Clone)]
pub(crate) struct ChannelState {
    moments: Moments,
    histogram: Histogram,
    octaves: Octaves,
    signal: ChannelSignal,
    /// Rows per sample of the channel.
    stride: u64,
    /// Absolute index of the next row.
    place: u64,
    /// `None` for channels that are no angle.
    unwrap: Option<Unwrap>,
    /// Whether the angle turned too far for its counts, so that they started anew.
    pub(super) restarted: bool,
}

impl ChannelState {
    /// A channel without samples; `plan` is shared by all channels.
    pub(crate) fn new(channel: &Channel, settings: &Settings, plan: &SpectrumPlan) -> Self {
        Self {
            moments: Moments::new(),
            histogram: Histogram::new(),
            octaves: Octaves::new(settings.estimator, settings.deviation),
            signal: ChannelSignal::new(plan),
            stride: 1,
            place: 0,
            unwrap: turn_counts(channel).map(Unwrap::new),
            restarted: false,
        }
    }

    /// Takes the sample of rows whose index is a multiple of `stride` alone; before the first row.
    pub(crate) fn set_stride(&mut self, stride: u64) {
        self.stride = stride;
        if stride > 1 {
            self.signal.count_missing();
        }
    }

    /// Rows are missing at this place; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        let samples = missing.map(|rows| self.pass(rows));
        // missing rows among which there is no sample of the channel make no gap
        if missing == Some(0) || samples != Some(0) {
            self.octaves.gap(samples);
            self.signal.gap(samples);
        }
    }

    /// Adds the counts of a stretch; unwraps angles in place. `plans` are for all channels.
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
        loop {
            let together = self.unwrap.as_mut().map_or(counts.len(), |unwrap| unwrap.unwrap(counts));
            let (continuous, rest) = counts.split_at_mut(together);
            let [before, after] =
                if rest.is_empty() { [stretch, Stretch::EMPTY] } else { stretch.split_before_sample(together) };
            self.moments.push(continuous);
            self.histogram.push(continuous);
            self.octaves.push_stretch(continuous, &before, plans);
            self.signal.push_stretch(continuous, &before);
            if rest.is_empty() {
                return;
            }
            self.restarted = true;
            self.octaves.gap(Some(0));
            self.signal.gap(Some(0));
            (counts, stretch) = (rest, after);
        }
    }

    /// The results of a channel whose count 0 is of `zero_counts`.
    pub(crate) fn snapshot(&self, zero_counts: i64, printed_step_counts: f64) -> ChannelSnapshot {
        let mean = self.moments.mean_counts().unwrap_or(0.0);
        ChannelSnapshot {
            branch_counts: self.unwrap.as_ref().map_or(-zero_counts, |unwrap| unwrap.turn_offset_counts(mean)),
            moments: self.moments.clone(),
            histogram: self.histogram.clone(),
            signal: Some(self.signal.clone()),
            octaves: self.octaves.sums().collect(),
            points: Vec::new(),
            stride: self.stride,
            printed_step_counts,
        }
    }

    /// The sums at these averaging factors, of those that have a window.
    pub(crate) fn points(&self, factors: &[u64]) -> Vec<OctaveSum> {
        let own = factors.iter().filter(|m| m.is_multiple_of(self.stride)).map(|m| m / self.stride);
        own.filter_map(|m| self.octaves.sum_at(m)).collect()
    }
}

/// Counts of a full turn of an angle; `None` for other channels, and if no count holds a turn.
fn turn_counts(channel: &Channel) -> Option<i32> {
    let counts = (360.0 / channel.scale * 10_f64.powi(channel.decimals.into())).round();
    (channel.quantity == Quantity::Angle && counts < f64::from(i32::MAX)).then_some(counts as i32)
}

#[cfg(test)]
mod tests {
    use vn100_protocol::VNYMR;

    use super::*;

    #[test]
    fn a_turn_of_an_angle_has_its_counts() {
        let angle = |scale: f64, decimals: u8| turn_counts(&Channel { scale, decimals, ..VNYMR.channels[0].clone() });
        assert_eq!((angle(1.0, 3), angle(1.0, 2), angle(180.0, 3)), (Some(360_000), Some(36_000), Some(2000)));
        assert_eq!((angle(1.0, 6), angle(1.0, 7)), (Some(360_000_000), None));
        assert_eq!(turn_counts(&VNYMR.channels[9]), None);
    }
}
