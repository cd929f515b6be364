//! The sums of all channels, and the detection of repeated rows.

use std::{borrow::Cow, mem, sync::Arc};

use imu_noise::{Estimator, OctaveSum, RecordShape, SpectrumPlan, Stretch, WindowPlans};
use vn100_protocol::{Channel, Layout, stream::AbsentCell};

use super::{
    channel_state::ChannelState,
    fingerprint::Fingerprint,
    magnitude::Magnitude,
    printed::Printed,
    quaternion::QuaternionSign,
    recent::Recent,
    repeats::{self, Repeats},
    row_slice::RowSlice,
    temperature_record::TemperatureRecord,
};
use crate::{settings::Settings, snapshot::ChannelSnapshot, warning::checks::StreamFindings};

#[derive(Debug, Clone, Default)]
pub(crate) struct Accumulators {
    pub(super) layout: Option<Arc<Layout>>,
    channels: Vec<ChannelState>,
    pub(super) magnitudes: Vec<Magnitude>,
    /// `None` for a message without a quaternion.
    quaternion: Option<QuaternionSign>,
    /// `None` while no temperature is known: until its first reading.
    pub(super) temperature: Option<TemperatureRecord>,
    /// Absolute index after the last row; 0 before the first row.
    end: u64,
    /// The recent samples; `None` where the settings do not ask for them.
    pub(super) recent: Option<Recent>,
    keeps_recent: bool,
    repeats: Repeats,
    pub(super) fingerprint: Fingerprint,
    pub(super) printed: Printed,
    /// Every result is read from [`settled`](Self::settled) sums.
    waiting: WaitingRows,
    /// Whether rows wait; not where the whole record is kept, which each reading would copy.
    holds_rows: bool,
    /// Whether any row is in the sums.
    has_sums: bool,
}

/// Rows that are not in the sums yet: adding one row or one gap alone costs as much as adding many.
#[derive(Debug, Clone, Default)]
struct WaitingRows {
    counts: Vec<i32>,
    absent: Vec<AbsentCell>,
    /// The places of the rows, and of missing rows between them.
    stretch: Stretch,
    /// Absolute index of the first place.
    first_index: u64,
    rate_hz: f64,
}

/// A longer gap is added alone.
const LONGEST_WAITING_GAP: u64 = Stretch::MOST as u64;

impl WaitingRows {
    /// The number of rows that have room.
    const fn room(&self) -> usize {
        Stretch::MOST - self.stretch.places()
    }

    /// Absolute index after the last place.
    const fn end(&self) -> u64 {
        self.first_index + self.stretch.places() as u64
    }

    /// Adds rows that have room.
    fn push(&mut self, rows: RowSlice<'_>) {
        let before = self.stretch.samples();
        self.absent.extend(rows.absent().into_iter().map(|cell| AbsentCell { row: before + cell.row, ..cell }));
        self.counts.extend_from_slice(rows.counts);
        self.stretch.push(rows.len(), true);
    }

    /// Removes the rows.
    fn clear(&mut self) {
        self.first_index = self.end();
        self.stretch = Stretch::EMPTY;
        self.counts.clear();
        self.absent.clear();
    }
}

impl Accumulators {
    /// Starts the channels of this message anew.
    pub(crate) fn begin(&mut self, layout: Arc<Layout>, settings: &Settings) {
        let plan = SpectrumPlan::new();
        let new = |channel| ChannelState::new(channel, settings, &plan);
        *self = Self {
            channels: layout.channels.iter().map(new).collect(),
            magnitudes: Magnitude::all(&layout),
            temperature: TemperatureRecord::of_stream(&layout),
            repeats: Repeats::new(layout.channels.len()),
            quaternion: QuaternionSign::of(&layout),
            keeps_recent: settings.recent,
            holds_rows: settings.estimator != Estimator::Full,
            layout: Some(layout),
            // what is shown and printed goes on, whatever is measured
            recent: self.recent.take(),
            printed: mem::take(&mut self.printed),
            end: self.end,
            ..Self::default()
        };
    }

    /// Counts per row; 0 without a layout, in which case there are no rows.
    pub(crate) fn width(&self) -> usize {
        self.channels.len()
    }

    /// Adds rows without a gap between them; the first has this absolute index.
    pub(crate) fn push(&mut self, rows: RowSlice<'_>, first_index: u64, rate_hz: f64) {
        self.end = first_index + rows.len() as u64;
        if (self.waiting.end(), self.waiting.rate_hz) != (first_index, rate_hz) {
            self.settle();
            (self.waiting.first_index, self.waiting.rate_hz) = (first_index, rate_hz);
        }
        let mut from = 0;
        while from < rows.len() {
            let to = rows.len().min(from + self.waiting.room());
            self.waiting.push(rows.at(from..to));
            self.settle_if(self.waiting.room() == 0);
            from = to;
        }
        self.settle_if(!self.holds_rows);
    }

    fn settle_if(&mut self, is_time: bool) {
        if is_time {
            self.settle();
        }
    }

    /// Adds the waiting rows to the sums.
    pub(crate) fn settle(&mut self) {
        let mut waiting = mem::take(&mut self.waiting);
        if waiting.stretch != Stretch::EMPTY {
            self.add(&waiting);
            waiting.clear();
        }
        self.waiting = waiting;
    }

    /// The sums, with the waiting rows added.
    pub(crate) fn settled(&self) -> Cow<'_, Self> {
        let mut settled = Cow::Borrowed(self);
        if self.waiting.stretch != Stretch::EMPTY {
            settled.to_mut().settle();
        }
        settled
    }

    fn add(&mut self, waiting: &WaitingRows) {
        let WaitingRows { counts, absent, stretch, first_index, rate_hz } = waiting;
        let width = self.width();
        if !mem::replace(&mut self.has_sums, true) {
            self.set_strides(*rate_hz);
        }
        for row in counts.chunks_exact(width) {
            let hash = repeats::hash(row);
            self.fingerprint.push(hash);
            self.repeats.push(hash);
        }
        if self.keeps_recent && self.recent.as_ref().is_none_or(|recent| !recent.is_at(*rate_hz)) {
            self.recent = Some(Recent::new(width, *rate_hz));
        }
        let Self { channels, magnitudes, quaternion, temperature, recent, .. } = self;
        let (mut absent, mut counts) = (Cow::Borrowed(absent.as_slice()), counts.as_slice());
        if let Some(quaternion) = quaternion {
            quaternion.complete_absent(&mut absent);
            counts = quaternion.continued(counts, width, &absent);
        }
        let rows = RowSlice::new(counts, width, &absent);
        let (mut plans, mut column) = (WindowPlans::new(), Vec::with_capacity(rows.len()));
        for (index, channel) in channels.iter_mut().enumerate() {
            column.clear();
            column.extend(counts.get(index..).unwrap_or_default().iter().step_by(width));
            let lacking: Vec<usize> = rows.lacking(index).collect();
            let own = stretch.without(&lacking);
            if !lacking.is_empty() {
                let mut row = 0;
                column.retain(|_| {
                    row += 1;
                    lacking.binary_search(&(row - 1)).is_err()
                });
            }
            channel.push(&mut column, &own, &mut plans);
            for (first, run) in own.indexed_runs(*first_index, &column) {
                temperature.iter_mut().for_each(|temperature| temperature.push(index, first, run));
                recent.iter_mut().for_each(|recent| recent.push(index, first, run));
            }
        }
        for magnitude in magnitudes {
            rows.with(magnitude.axes()).for_each(|run| magnitude.push(run, width));
        }
    }

    /// Gives the channels that the sensor measures less often a rate of their own.
    fn set_strides(&mut self, rate_hz: f64) {
        let channels = self.layout.iter().flat_map(|layout| layout.channels.iter());
        for (state, channel) in self.channels.iter_mut().zip(channels) {
            state.set_stride(channel.stride(rate_hz));
        }
    }

    /// Samples are missing at this place; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        match missing {
            Some(missing @ 1..=LONGEST_WAITING_GAP) if self.holds_rows => {
                let mut missing = missing as usize;
                while missing > 0 {
                    missing -= self.waiting.stretch.push(missing, false);
                    self.settle_if(self.waiting.room() == 0);
                }
            }
            _ => {
                self.settle();
                self.channels.iter_mut().for_each(|channel| channel.gap(missing));
            }
        }
        if let Some(temperature) = self.temperature.as_mut().filter(|_| missing.is_none()) {
            temperature.part();
        }
    }

    /// The temperature that the sensor reported after the last row, in counts; ignored before the
    /// first row, and where the stream itself carries the temperature.
    pub(crate) fn push_reading(&mut self, counts: i32) {
        let (Some(layout), Some(last)) = (self.layout.clone(), self.end.checked_sub(1)) else { return };
        self.settle();
        self.temperature = self.temperature.take().or_else(|| TemperatureRecord::polled(&layout));
        if let Some(temperature) = &mut self.temperature {
            temperature.push_reading(last, counts);
        }
    }

    /// The results.
    pub(crate) fn snapshot(&self, shape: &RecordShape) -> Vec<ChannelSnapshot> {
        let coarsest = self.printed.coarsest;
        self.states()
            .map(|(state, channel)| {
                let digits = i32::from(channel.decimals) - i32::from(coarsest.decimals(channel));
                let of_increment = channel.increment_step.unwrap_or(0.0) / shape.interval_s / channel.scale;
                state.snapshot(channel.zero_counts, 10_f64.powi(digits).max(of_increment))
            })
            .collect()
    }

    /// The sums of each channel at these averaging factors.
    pub(crate) fn points(&self, factors: &[u64]) -> Vec<Vec<OctaveSum>> {
        self.channels.iter().map(|channel| channel.points(factors)).collect()
    }

    /// The recent samples; `None` where these are at another rate.
    pub(crate) fn recent(&self, rate_hz: f64) -> Option<Recent> {
        self.recent.as_ref().filter(|recent| recent.is_at(rate_hz)).cloned()
    }

    pub(crate) fn findings(&self) -> StreamFindings {
        let restarted = self.states().filter(|(state, _)| state.restarted);
        StreamFindings {
            repeated_lines: self.repeats.repeated(),
            print_changes: self.printed.changes,
            restarted: restarted.map(|(_, channel)| channel.name.to_string()).collect(),
        }
    }

    fn states(&self) -> impl Iterator<Item = (&ChannelState, &Channel)> {
        self.channels.iter().zip(self.layout.iter().flat_map(|layout| layout.channels.iter()))
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::{Deviation, Estimator};
    use proptest::{collection::vec, prelude::*};
    use vn100_protocol::{Channel, VNIMU, VNYMR};

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

    #[test]
    fn repeated_rows_count_from_nine_channels_on() {
        for (channels, expected) in [(8, 0), (9, 1), (12, 1)] {
            let mut accumulators = of(channels);
            accumulators.push(RowSlice::new(&vec![7; 2 * channels], accumulators.width(), &[]), 0, 40.0);
            assert_eq!(accumulators.settled().findings().repeated_lines, expected, "{channels}");
        }
    }

    #[test]
    fn the_last_minutes_are_those_at_the_present_rate() {
        let mut accumulators = of(2);
        accumulators.keeps_recent = true;
        accumulators.push(RowSlice::new(&[1; 8], accumulators.width(), &[]), 0, 40.0);
        accumulators.push(RowSlice::new(&[1; 8], accumulators.width(), &[]), 4, 40.0);
        let count = |accumulators: &Accumulators, rate_hz| {
            let slots = accumulators.settled().recent(rate_hz)?.slots(1).flatten().map(|slot| slot.count).sum::<u32>();
            Some(slots)
        };
        assert_eq!((count(&accumulators, 40.0), count(&accumulators, 20.0)), (Some(8), None));
        accumulators.push(RowSlice::new(&[1; 4], accumulators.width(), &[]), 8, 20.0);
        assert_eq!((count(&accumulators, 40.0), count(&accumulators, 20.0)), (None, Some(2)));
        accumulators.settle();
        accumulators.recent = None;
        assert_eq!(count(&accumulators, 20.0), None);
    }

    /// What comes: rows with their absent cells, or a gap.
    #[derive(Debug, Clone)]
    enum Step {
        Rows(Vec<(i32, Option<usize>)>),
        Gap(Option<u64>),
    }

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        let row = |absent| (any::<i32>(), prop::option::weighted(absent, 0..VNIMU.channels.len()));
        let rows = |absent, most| vec(row(absent), 1..most).prop_map(Step::Rows);
        let missing = prop_oneof![6 => (1_u64..4).prop_map(Some), 1 => (1_u64..700).prop_map(Some), 1 => Just(Some(0)), 1 => Just(None)];
        let step = prop_oneof![2 => rows(0.001, 30), 1 => rows(0.1, 30), 1 => rows(0.001, 700), 4 => missing.prop_map(Step::Gap)];
        vec(step, 1..60)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn rows_and_gaps_that_wait_are_as_those_added_at_once(steps in steps(), turns in any::<bool>()) {
            let width = VNIMU.channels.len();
            let mut channels = VNIMU.channels.to_vec();
            channels[..3].iter_mut().for_each(|mag| mag.refresh_hz = Some(250));
            if turns {
                // an angle that leaves the range of its counts after some turns
                channels[0] = Channel { decimals: 6, ..VNYMR.channels[0].clone() };
            }
            let layout = Arc::new(Layout { channels: channels.into(), ..VNIMU.clone() });
            let [mut waiting, mut at_once] = [true, false].map(|holds_rows| {
                let mut accumulators = Accumulators::default();
                accumulators.begin(Arc::clone(&layout), &Settings { recent: true, ..Settings::default() });
                accumulators.holds_rows = holds_rows;
                accumulators
            });
            let mut index = 0;
            for step in &steps {
                match step {
                    Step::Rows(rows) => {
                        let of_row = |&(value, _): &(i32, _)| {
                            let scaled = move |i: i32| (value >> 13).wrapping_mul(2 * i + 1);
                            let first = if turns { value % 180_000_000 } else { scaled(0) };
                            [first].into_iter().chain((1..width as i32).map(scaled))
                        };
                        let counts: Vec<i32> = rows.iter().flat_map(of_row).collect();
                        let cell = |(row, (_, absent)): (usize, &(i32, Option<usize>))| {
                            absent.map(|channel| AbsentCell { row, channel })
                        };
                        let absent: Vec<_> = rows.iter().enumerate().filter_map(cell).collect();
                        for accumulators in [&mut waiting, &mut at_once] {
                            accumulators.push(RowSlice::new(&counts, width, &absent), index, 800.0);
                        }
                        index += rows.len() as u64;
                    }
                    Step::Gap(missing) if index > 0 => {
                        [&mut waiting, &mut at_once].into_iter().for_each(|accumulators| accumulators.gap(*missing));
                        index += missing.unwrap_or(0);
                    }
                    Step::Gap(_) => {}
                }
            }
            let of = |accumulators: &Accumulators| {
                let settled = accumulators.settled();
                let channels = settled.snapshot(&shape()).into_iter().map(|channel| {
                    let signal = channel.signal.unwrap();
                    let sums = (channel.octaves, channel.moments, channel.histogram);
                    (sums, signal.blocks(), signal.spectrum().density(imu_noise::Sides::Two, 1.0, 0))
                });
                let magnitudes = settled.magnitudes.clone();
                let rest = (settled.recent.clone(), format!("{:?}", settled.temperature), settled.fingerprint.clone());
                (channels.collect::<Vec<_>>(), magnitudes, rest)
            };
            prop_assert_eq!(of(&waiting), of(&at_once));
        }
    }

    /// Magnetic field and angular rate, as packets have them.
    fn of_packets() -> Accumulators {
        let mut accumulators = Accumulators::default();
        let mag = Channel { refresh_hz: Some(250), ..VNYMR.channels[3].clone() };
        let layout = Layout { channels: vec![mag, VNYMR.channels[9].clone()].into(), ..VNYMR.clone() };
        accumulators.begin(Arc::new(layout), &Settings::default());
        accumulators
    }

    /// Values of a magnetometer that is read anew every fourth row.
    fn packet_rows(rows: i32) -> Vec<i32> {
        (0..rows).flat_map(|row| [(row / 4).wrapping_mul(7919) % 1000, row.wrapping_mul(104_729) % 1000]).collect()
    }

    #[test]
    fn what_packets_repeat_has_a_rate_of_its_own() {
        let counts = packet_rows(401);
        let mut accumulators = of_packets();
        for (rows, index) in counts.chunks(2 * 37).zip((0..).step_by(37)) {
            accumulators.push(RowSlice::new(rows, 2, &[]), index, 800.0);
        }
        let channels = accumulators.settled().snapshot(&shape());
        let counted: Vec<_> = channels.iter().map(|channel| (channel.stride, channel.moments.count())).collect();
        assert_eq!(counted, [(4, 101), (1, 401)]);
        let mut alone = of(1);
        let every_fourth: Vec<i32> = counts.iter().copied().step_by(8).collect();
        alone.push(RowSlice::new(&every_fourth, 1, &[]), 0, 200.0);
        let expected = &alone.settled().snapshot(&shape())[0];
        assert_eq!(channels[0].octaves, expected.octaves, "the numbers of a record at a quarter of the rate");
    }

    #[test]
    fn a_gap_takes_from_a_slower_channel_only_the_samples_in_it() {
        let mut accumulators = of_packets();
        accumulators.push(RowSlice::new(&packet_rows(10), 2, &[]), 0, 800.0);
        // rows 10 and 11 hold no sample of every fourth, rows 12 to 20 three
        accumulators.gap(Some(2));
        accumulators.push(RowSlice::new(&packet_rows(1), 2, &[]), 12, 800.0);
        let terms = |accumulators: &Accumulators| {
            let channels = accumulators.settled().snapshot(&shape());
            channels.iter().map(|channel| channel.octaves[0].terms).collect::<Vec<_>>()
        };
        assert_eq!(terms(&accumulators), [3, 9]);
        accumulators.gap(Some(8));
        accumulators.push(RowSlice::new(&packet_rows(9), 2, &[]), 21, 800.0);
        assert_eq!(terms(&accumulators), [4, 17]);
        accumulators.gap(None);
        accumulators.push(RowSlice::new(&packet_rows(8), 2, &[]), 30, 800.0);
        assert_eq!(terms(&accumulators), [5, 24]);
    }
}
