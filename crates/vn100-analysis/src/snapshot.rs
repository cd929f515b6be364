//! The state of the statistics at one moment.

use std::{collections::BTreeMap, fmt, sync::Arc, time::Duration};

use imu_noise::{
    ChannelSignal, Deviation, Estimator, Histogram, Moments, OctaveSum, PowerLaw, RecordShape, Refusal,
    TemperatureRemoval, TimebaseSummary,
};
use vn100_protocol::stream::{LinkEvent, LinkEventKind, StreamCounts};
use vn100_protocol::{Channel, Layout, Quantity, Register, RegisterContents, RegisterFields, Sample, VNIMU};

use crate::{
    accumulate::{
        fingerprint::Fingerprint, magnitude::Magnitude, recent::Recent, saturation::Saturation,
        temperature_record::TemperatureRecord,
    },
    averaging_times::MissingTime,
    detrend::Detrend,
    warning::Warning,
};

/// Everything known of a measurement at one moment. Taking one does not disturb the measurement.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// The message measured; `None` while no sample has come.
    pub layout: Option<Arc<Layout>>,
    /// The time base.
    pub timing: Timing,
    /// What the arrival stamps say, until a change of rate; `None` for a stream without stamps.
    pub arrivals: Option<TimebaseSummary>,
    /// Why the stamps of an earlier connection were no time base.
    pub refused_before: Option<Refusal>,
    /// The change of rate after which samples are excluded.
    pub rate_change: Option<RateChange>,
    /// A rate by arrival times that the sensor contradicted, and whose samples are excluded.
    pub false_rate: Option<FalseRate>,
    /// A rate that the sensor reports, and arrival times show to be false.
    pub false_report: Option<FalseReport>,
    /// Samples excluded because they came at another rate for a while, as delayed bytes do.
    pub other_rate_samples: u64,
    /// The sensor's registers by number, as it last printed them within the stream.
    pub registers: BTreeMap<u8, String>,
    /// What the stream carried, samples or not.
    pub link: StreamCounts,
    /// When the link was down.
    pub outages: Outages,
    /// Places that the user marked, in time order; the first thousand.
    pub marks: Vec<PlaceMark>,
    /// Another program that had the port open meanwhile, and so received a part of the bytes.
    pub port_shared_with: Option<String>,
    /// Samples with an axis at the end of its range, as the sensor says.
    pub saturation: Saturation,
    /// How often the sensor restarted within the stream, by its own time; 0 where rows carry none.
    pub restarts: u64,
    /// How often the time of the sensor stepped ahead of what passed by the host's clock.
    pub time_steps: u64,
    /// Packets excluded as their time fits neither neighbour: damage that the CRC did not show.
    pub false_times: u64,
    /// How the deviations are estimated.
    pub estimator: Estimator,
    /// Data time excluded at the beginning.
    pub skipped: Duration,
    /// Which deviation it is.
    pub deviation: Deviation,
    /// What was removed from each channel that has it, before its deviation.
    pub detrended: Option<Detrend>,
    /// What relates the axes to the temperature of the sensor; `None` where the record does not
    /// have it.
    pub temperature: Option<TemperatureRecord>,
    /// Quantisation noise is fitted too.
    pub quantization: bool,
    /// The averaging window of register 85 as the user says, see
    /// [`Settings::window`](crate::Settings::window).
    pub given_window: Option<u32>,
    /// Averaging times that were asked for, and that a final result does not have.
    pub missing_times: Vec<MissingTime>,
    /// One per channel, in the order of `layout`; empty without a layout.
    pub channels: Vec<ChannelSnapshot>,
    /// The length of each measured vector.
    pub magnitudes: Vec<Magnitude>,
    /// What was read from register 54 between the lines.
    pub register_channels: Vec<RegisterChannel>,
    /// Which rows were measured.
    pub fingerprint: Fingerprint,
    /// Limits of the result, the gravest first.
    pub warnings: Vec<Warning>,
    /// The last minutes, where they were asked for.
    pub recent: Option<Recent>,
}

/// A place in the record that its user marked.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceMark {
    /// Data time from the beginning of the record, in seconds.
    pub at_s: f64,
    /// In the user's words, as they were recorded.
    pub text: String,
}

impl Snapshot {
    /// The channels of the layout; none without one.
    #[must_use]
    pub fn layout_channels(&self) -> &[Channel] {
        self.layout.as_ref().map_or(&[], |layout| &layout.channels)
    }

    /// The same with their results.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Channel, &ChannelSnapshot)> + Clone {
        self.layout_channels().iter().zip(&self.channels)
    }

    /// Of the first three channels that measure `quantity`, in their unit.
    #[must_use]
    pub fn mean_vector(&self, quantity: Quantity) -> Option<[f64; 3]> {
        let means: Vec<f64> = (self.measured().filter(|(channel, _)| channel.quantity == quantity).take(3))
            .filter_map(|(channel, results)| Some(channel.in_unit(results.moments.mean_counts()?)))
            .collect();
        means.try_into().ok()
    }

    /// The latest temperature that was asked for beside the samples (register 54), in °C; `None`
    /// where there is no answer.
    #[must_use]
    pub fn polled_temperature_c(&self) -> Option<f64> {
        let fields = RegisterFields::new(self.registers.get(&Register::IMU.0)?.as_str()).ok()?;
        let contents = RegisterContents { register: Register::IMU, fields };
        let sample = Sample::from_contents(&contents, &VNIMU).ok()?;
        let mut values = sample.layout.channels.iter().zip(sample.values());
        values.find_map(|(channel, value)| (channel.quantity == Quantity::Temperature).then_some(value))
    }

    /// Rows that are pending until their arrival times show or confirm the rate; `None` for none.
    #[must_use]
    pub fn rows_pending(&self) -> Option<u64> {
        self.arrivals.as_ref()?.samples_pending()
    }

    /// How the octaves of a channel were computed.
    #[must_use]
    pub fn shape_of(&self, results: &ChannelSnapshot) -> RecordShape {
        let rows = self.shape();
        RecordShape {
            samples: rows.samples.div_ceil(results.stride),
            interval_s: rows.interval_s * results.stride as f64,
            ..rows
        }
    }

    /// The sample rate of a channel, in hertz.
    #[must_use]
    pub fn rate_of(&self, results: &ChannelSnapshot) -> f64 {
        self.timing.rate_hz / results.stride as f64
    }

    /// How the octaves of channels with the rate of the rows were computed.
    #[must_use]
    pub fn shape(&self) -> RecordShape {
        RecordShape {
            samples: self.timing.samples + self.timing.missing,
            interval_s: 1.0 / self.timing.rate_hz,
            estimator: self.estimator,
            deviation: self.deviation,
        }
    }
}

/// The times in which a link that had received samples was down.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Outages {
    /// How often the link was lost.
    pub times: u64,
    /// In nanoseconds, from the last row before each loss to the reconnect; `None` where the times
    /// of the events contradict each other.
    pub down_ns: Option<i64>,
    /// Since when it is down, in nanoseconds as the events have it; `None` while it is up.
    pub since_ns: Option<i64>,
    /// When it was closed for good while it was down; `None` as long as it is not.
    pub closed_ns: Option<i64>,
}

impl Outages {
    /// A silence is reported some seconds late: the link is down since the last row of the stream.
    pub(crate) fn take(&mut self, event: &LinkEvent, last_row_ns: Option<i64>) {
        match event.kind {
            LinkEventKind::Down { .. } if self.since_ns.is_none() => {
                if self.times == 0 {
                    self.down_ns = Some(0);
                }
                self.times += 1;
                // a clock may have been set back
                self.since_ns = last_row_ns.filter(|ns| *ns <= event.at_ns).or(Some(event.at_ns));
            }
            LinkEventKind::Up { .. } => {
                self.down_ns = self.down_until(event.at_ns);
                (self.since_ns, self.closed_ns) = (None, None);
            }
            LinkEventKind::Closed => self.closed_ns = Some(event.at_ns),
            _ => {}
        }
    }

    /// The sum with the outage that ends then, if there is one.
    fn down_until(&self, at_ns: i64) -> Option<i64> {
        let Some(since_ns) = self.since_ns else { return self.down_ns };
        // the stamps of a recording may go back
        let last_ns = at_ns.checked_sub(since_ns).filter(|ns| *ns >= 0)?;
        self.down_ns?.checked_add(last_ns)
    }

    /// The time in seconds without it, to a millisecond; `None` where that is not known, as while
    /// it is down.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        let down_ns = match (self.since_ns, self.closed_ns) {
            (Some(_), Some(closed_ns)) => self.down_until(closed_ns),
            (Some(_), None) => None,
            (None, _) => self.down_ns,
        };
        down_ns.map(|ns| (ns as f64 * 1e-6).round() / 1e3)
    }
}

impl fmt::Display for Outages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "lost {} {}, ", self.times, if self.times == 1 { "time" } else { "times" })?;
        match self.seconds() {
            Some(seconds) => write!(f, "{seconds:.1} s without it"),
            None => write!(f, "how long is not known"),
        }
    }
}

/// The samples in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Nominal sample rate in hertz; tau = m / rate.
    pub rate_hz: f64,
    /// Where the rate comes from.
    pub rate_from: RateFrom,
    /// Samples in the statistics.
    pub samples: u64,
    /// Valid samples excluded: by the user's choice of data time, or after a change of rate.
    pub excluded: u64,
    /// Samples known to be missing among those in the statistics.
    pub missing: u64,
    /// Which evidence most of them were counted by; where as many by each, the evidence at the end.
    pub missing_from: MissingFrom,
    /// Places where samples are missing.
    pub gaps: u64,
    /// Runs of samples without a gap or a change of scale between them.
    pub segments: u64,
}

impl Timing {
    /// Time the samples in the statistics span, in seconds: (samples + missing) / rate.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        (self.samples + self.missing) as f64 / self.rate_hz
    }
}

/// The evidence for missing samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MissingFrom {
    /// The sensor's own time in every packet: exact.
    DeviceTime,
    /// A counter in every line: exact.
    Counter,
    /// Arrival times: entirely missing lines are counted too.
    Arrival,
    /// A rejected row between valid ones: dropped lines are not detected.
    #[default]
    RejectedRows,
}

impl MissingFrom {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::DeviceTime, Self::Counter, Self::Arrival, Self::RejectedRows];

    /// Whether it leaves nothing to guess.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        matches!(self, Self::DeviceTime | Self::Counter)
    }
}

/// Where the sensor's rate changed in mid-stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateChange {
    /// Samples in the statistics, all before it.
    pub after_samples: u64,
    /// Rate before, in hertz.
    pub from_hz: f64,
    /// Rate after, in hertz.
    pub to_hz: f64,
}

/// A rate by arrival times that the sensor contradicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseRate {
    /// Samples that were placed by it and excluded.
    pub samples: u64,
    /// The rate by arrival times, in hertz.
    pub arrival_hz: f64,
    /// The sensor's rate, in hertz.
    pub device_hz: f64,
}

/// A rate reported by the sensor that arrival times contradicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseReport {
    /// The rate that the sensor reports in register 7, in hertz.
    pub reported_hz: f64,
    /// The rate by arrival times, that of the record, in hertz.
    pub arrival_hz: f64,
}

/// Where a sample rate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateFrom {
    /// Given by the user.
    Option,
    /// The sensor's own time in every packet.
    DeviceTime,
    /// Reported by the sensor, in register 7.
    Device,
    /// From the arrival times.
    Arrival,
    /// Unknown: the sensor's default of 40 Hz.
    Assumed,
}

impl RateFrom {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Option, Self::DeviceTime, Self::Device, Self::Arrival, Self::Assumed];
}

/// One channel of a [`Snapshot`]. Everything is in counts of the channel's last decimal.
#[derive(Debug, Clone)]
pub struct ChannelSnapshot {
    /// Mean, spread and extremes.
    pub moments: Moments,
    /// How often each value occurred.
    pub histogram: Histogram,
    /// The deviation's exact sums, one per octave that has a window.
    pub octaves: Vec<OctaveSum>,
    /// The same of the deviation that was not asked for, with nothing removed; empty where it is
    /// [not kept](crate::Settings::other_deviation).
    pub other_octaves: Vec<OctaveSum>,
    /// The same at the averaging times asked for; none where these are the octaves, and in a
    /// measurement under way.
    pub points: Vec<OctaveSum>,
    /// What kind of noise each of the octaves shows.
    pub noise_types: Vec<Option<PowerLaw>>,
    /// In counts per sample; `None` for short records and behind gaps of unknown length.
    pub slope_counts: Option<f64>,
    /// `None` for what was asked for between the lines.
    pub signal: Option<ChannelSignal>,
    /// To be subtracted from mean, minimum and maximum: whole turns, for an angle whose continuous
    /// series has left the branch from -180 (not included) to 180 degrees; else 0.
    pub branch_counts: i64,
    /// Rows for one of its samples: 1, or more where the sensor measures it more slowly than it
    /// sends it.
    pub stride: u64,
    /// Counts of one in the last digit that the sensor printed at any time, of an increment over
    /// the sample interval; 1 where the layout has no more digits.
    pub printed_step_counts: f64,
    /// The contribution of the temperature to the channel, where it was removed.
    pub removed_temperature: Option<RemovedTemperature>,
}

/// The contribution of the temperature to a channel, and the deviation before its removal.
#[derive(Debug, Clone)]
pub struct RemovedTemperature {
    /// What was removed.
    pub removal: TemperatureRemoval,
    /// The octaves as measured.
    pub octaves: Vec<OctaveSum>,
}

impl RemovedTemperature {
    pub(crate) fn new(removal: TemperatureRemoval, measured: &[OctaveSum]) -> Self {
        Self { removal, octaves: measured.to_vec() }
    }

    /// These sums of the same channel without what the temperature made.
    pub(crate) fn without(&self, sums: &[OctaveSum]) -> Vec<OctaveSum> {
        let of_block = self.octaves.iter().find(|sum| sum.m == self.removal.block_length());
        let of_block = of_block.and_then(OctaveSum::variance_counts2).unwrap_or(0.0);
        let without = |sum: &OctaveSum| {
            let variance = sum
                .variance_counts2()
                .map(|variance| self.removal.variance_without(sum.deviation, sum.m, variance, of_block));
            variance.map_or(*sum, |variance| sum.with_variance_counts2(variance))
        };
        sums.iter().map(without).collect()
    }
}

impl ChannelSnapshot {
    /// The step from value to value, in the unit of `channel`: the real one where the values show
    /// it, else one of the last printed digit.
    #[must_use]
    pub fn step(&self, channel: &Channel) -> f64 {
        channel.in_unit(self.histogram.step_counts().unwrap_or(0.0).max(self.printed_step_counts))
    }
}

/// A channel that was asked for between the lines.
#[derive(Debug, Clone)]
pub struct RegisterChannel {
    /// What it is, by a name of its own.
    pub channel: Channel,
    /// Its statistics; it has no deviation.
    pub results: ChannelSnapshot,
}

imu_noise::encoded!(PlaceMark { at_s, text });
imu_noise::encoded!(Outages { times, down_ns, since_ns, closed_ns });
imu_noise::encoded!(RateChange { after_samples, from_hz, to_hz });
imu_noise::encoded!(FalseReport { reported_hz, arrival_hz });
imu_noise::encoded!(FalseRate { samples, arrival_hz, device_hz });
imu_noise::encoded!(
    MissingFrom = MissingFrom::DeviceTime,
    MissingFrom::Counter,
    MissingFrom::Arrival,
    MissingFrom::RejectedRows
);
imu_noise::encoded!(
    RateFrom = RateFrom::Option,
    RateFrom::DeviceTime,
    RateFrom::Device,
    RateFrom::Arrival,
    RateFrom::Assumed
);
