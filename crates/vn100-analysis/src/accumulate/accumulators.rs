//! The sums of all channels, and the rows that come again.

use std::sync::Arc;

use imu_noise::{OctaveSum, RecordShape, SpectrumPlan};
use vn100_protocol::{Layout, PrintFormat};

use super::{
    channel_state::ChannelState, magnitude::Magnitude, quaternion::QuaternionSign, recent::Recent, repeats::Repeats,
};
use crate::{settings::Settings, snapshot::ChannelSnapshot, warning::advice::StreamFindings};

/// Rows of so many channels never repeat while a sensor works; a few coarse ones do by chance.
const MIN_CHANNELS_OF_REPEATS: usize = 9;

#[derive(Debug, Default)]
pub(crate) struct Accumulators {
    pub(super) layout: Option<Arc<Layout>>,
    channels: Vec<ChannelState>,
    pub(super) magnitudes: Vec<Magnitude>,
    /// Only if the message has a quaternion.
    quaternion: Option<QuaternionSign>,
    /// Only if asked for.
    pub(super) recent: Option<Recent>,
    /// Samples of one channel, for reuse.
    column: Vec<i32>,
    repeats: Repeats,
    printed: Option<PrintFormat>,
    coarsest: PrintFormat,
    print_changes: u64,
}

impl Accumulators {
    /// Begins the channels of this message anew.
    pub(crate) fn begin(&mut self, layout: Arc<Layout>, settings: &Settings) {
        let plan = SpectrumPlan::new();
        self.channels = layout.channels.iter().map(|channel| ChannelState::new(channel, settings, &plan)).collect();
        self.magnitudes = Magnitude::all(&layout);
        self.quaternion = QuaternionSign::of(&layout);
        self.repeats = Repeats::default();
        self.layout = Some(layout);
    }

    /// Counts per row; 0 without a layout, and then there are no rows.
    pub(crate) fn width(&self) -> usize {
        self.channels.len()
    }

    /// Frame-major rows without a gap between them, the first with this absolute index.
    pub(crate) fn push(&mut self, counts: &[i32], first_index: u64, rate_hz: f64, keep_recent: bool) {
        let width = self.width();
        let counts = match &mut self.quaternion {
            Some(quaternion) => quaternion.continued(counts, width),
            None => counts,
        };
        if keep_recent && self.recent.as_ref().is_none_or(|recent| recent.rate_hz != rate_hz) {
            self.recent = Some(Recent::new(width, rate_hz));
        }
        if width >= MIN_CHANNELS_OF_REPEATS {
            counts.chunks_exact(width).for_each(|row| self.repeats.push(row));
        }
        for (index, channel) in self.channels.iter_mut().enumerate() {
            self.column.clear();
            self.column.extend(counts.chunks_exact(width).map(|row| row[index]));
            channel.push(&mut self.column);
            if let Some(recent) = &mut self.recent {
                recent.push(index, first_index, &self.column);
            }
        }
        for magnitude in &mut self.magnitudes {
            magnitude.push(counts, width, &mut self.column);
        }
    }

    /// Samples are missing here; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        self.channels.iter_mut().for_each(|channel| channel.gap(missing));
    }

    /// Whether that is a change: values of another resolution are not comparable in the last digit.
    pub(crate) fn set_print_format(&mut self, format: PrintFormat) -> bool {
        if format != PrintFormat::Current {
            self.coarsest = format;
        }
        let has_changed = self.printed.replace(format).is_some();
        self.print_changes += u64::from(has_changed);
        has_changed
    }

    pub(crate) fn snapshot(&self, shape: &RecordShape) -> Vec<ChannelSnapshot> {
        self.states().map(|(state, channel)| state.snapshot(self.coarsest.decimals(channel), shape)).collect()
    }

    /// The sums of each channel at these averaging factors.
    pub(crate) fn points(&self, factors: &[u64]) -> Vec<Vec<OctaveSum>> {
        self.channels.iter().map(|channel| channel.points(factors)).collect()
    }

    /// `None` if they are at another rate.
    pub(crate) fn recent(&self, rate_hz: f64) -> Option<Recent> {
        self.recent.as_ref().filter(|recent| recent.rate_hz == rate_hz).cloned()
    }

    pub(crate) fn findings(&self) -> StreamFindings {
        let restarted = self.states().filter(|(state, _)| state.restarted);
        StreamFindings {
            repeated_lines: self.repeats.repeated(),
            print_changes: self.print_changes,
            restarted: restarted.map(|(_, channel)| channel.name.to_string()).collect(),
        }
    }

    fn states(&self) -> impl Iterator<Item = (&ChannelState, &vn100_protocol::Channel)> {
        self.channels.iter().zip(self.layout.iter().flat_map(|layout| layout.channels.iter()))
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::{Deviation, Estimator};
    use vn100_protocol::VNYMR;

    use super::*;

    /// Channels of as many of the message's columns.
    fn of(channels: usize) -> Accumulators {
        let mut accumulators = Accumulators::default();
        let layout = Layout { channels: VNYMR.channels[..channels].to_vec().into(), ..VNYMR.clone() };
        accumulators.begin(Arc::new(layout), &Settings::default());
        accumulators
    }

    fn shape() -> RecordShape {
        RecordShape { samples: 8, interval_s: 0.025, estimator: Estimator::Strided, deviation: Deviation::Allan }
    }

    fn octaves(accumulators: &Accumulators) -> Vec<u64> {
        accumulators.snapshot(&shape()).iter().map(|channel| channel.octaves[0].terms).collect()
    }

    #[test]
    fn columns_become_channels() {
        assert_eq!(Accumulators::default().width(), 0);
        let mut accumulators = of(3);
        accumulators.push(&[1, 20, 300, 3, 40, 500], 0, 40.0, false);
        assert_eq!(accumulators.width(), 3);
        let channels = accumulators.snapshot(&shape());
        let means: Vec<_> = channels.iter().map(|channel| channel.moments.mean_counts()).collect();
        assert_eq!(means, [Some(2.0), Some(30.0), Some(400.0)]);
        assert!(accumulators.recent(40.0).is_none(), "not asked for");
    }

    #[test]
    fn no_window_spans_a_gap() {
        let mut accumulators = of(2);
        accumulators.push(&[1; 8], 0, 40.0, false);
        assert_eq!(octaves(&accumulators), [3, 3]);
        accumulators.gap(Some(5));
        accumulators.push(&[1; 8], 9, 40.0, false);
        assert_eq!(octaves(&accumulators), [6, 6]);
        accumulators.gap(None);
        accumulators.push(&[1; 8], 13, 40.0, false);
        assert_eq!(octaves(&accumulators), [9, 9]);
    }

    #[test]
    fn repeated_rows_count_from_nine_channels_on() {
        for (channels, expected) in [(8, 0), (9, 1), (12, 1)] {
            let mut accumulators = of(channels);
            accumulators.push(&vec![7; 2 * channels], 0, 40.0, false);
            assert_eq!(accumulators.findings().repeated_lines, expected, "{channels}");
        }
    }

    #[test]
    fn the_last_minutes_are_those_at_the_present_rate() {
        let mut accumulators = of(2);
        accumulators.push(&[1; 8], 0, 40.0, true);
        accumulators.push(&[1; 8], 4, 40.0, true);
        let count = |accumulators: &Accumulators, rate_hz| {
            let slots = accumulators.recent(rate_hz)?.slots(1).flatten().map(|slot| slot.count).sum::<u32>();
            Some(slots)
        };
        assert_eq!((count(&accumulators, 40.0), count(&accumulators, 20.0)), (Some(8), None));
        accumulators.push(&[1; 4], 8, 20.0, true);
        assert_eq!((count(&accumulators, 40.0), count(&accumulators, 20.0)), (None, Some(2)));
        accumulators.recent = None;
        assert_eq!(count(&accumulators, 20.0), None);
    }

    #[test]
    fn the_coarsest_print_format_is_that_of_the_channels() {
        let mut accumulators = of(12);
        let formats = [PrintFormat::Current, PrintFormat::Old, PrintFormat::Current];
        assert_eq!(formats.map(|format| accumulators.set_print_format(format)), [false, true, true]);
        assert_eq!(accumulators.findings().print_changes, 2);
        assert_eq!(accumulators.snapshot(&shape())[0].printed_decimals, 2);
    }

    #[test]
    fn a_channel_that_started_anew_is_named() {
        let mut accumulators = of(4);
        let turning = (0..18_000).flat_map(|row| [[0, 120_000, -120_000][row % 3], 0, 0, 0]);
        accumulators.push(&turning.collect::<Vec<_>>(), 0, 40.0, false);
        assert_eq!(accumulators.findings().restarted, ["yaw"]);
        let layout = accumulators.layout.clone().into_iter();
        layout.for_each(|layout| accumulators.begin(layout, &Settings::default()));
        assert_eq!((accumulators.findings().restarted.len(), accumulators.findings().repeated_lines), (0, 0));
    }
}
