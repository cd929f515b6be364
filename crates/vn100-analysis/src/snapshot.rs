//! The results of a measurement at one moment.

use schemars::JsonSchema;
use serde::Serialize;
use std::{collections::BTreeMap, fmt, sync::Arc, time::Duration};

use imu_noise::timebase::{Refusal, TimebaseSummary};
use imu_noise::{ChannelSignal, Histogram, Moments, OctaveSum, RecordShape};
use vn100_protocol::stream::{LinkEvent, LinkEventKind, StreamCounts};
use vn100_protocol::{
    Channel, Layout, Quantity, Register, RegisterContents, RegisterFields, RegisterValue, Sample, VNIMU,
};

use crate::{
    accumulate::{
        fingerprint::Fingerprint, magnitude::Magnitude, recent::Recent, saturation::Saturation,
        temperature_record::TemperatureRecord,
    },
    rate_change::RateChange,
    settings::Settings,
    warning::{Finding, Warning},
};

/// All results of a measurement at one moment; without a sample no layout and no channels.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// The message that is measured; `None` before the first sample.
    pub layout: Option<Arc<Layout>>,
    /// Rate, counts and gaps of the samples.
    pub timing: Timing,
    /// Summary of the arrival stamps, up to a change of rate; `None` for a stream without stamps.
    pub arrivals: Option<TimebaseSummary>,
    /// Why the stamps of an earlier connection were refused as a time base; `None` where none were.
    pub refused_before: Option<Refusal>,
    /// The change of rate after which samples are excluded.
    pub rate_change: Option<RateChange>,
    /// The first change of the rate of a record whose rate nothing but its stamps tells: the longest
    /// stretch at one rate is measured.
    pub parted: Option<RateChange>,
    /// Rows of a table that were left out because they repeat an earlier one, stamp and values.
    pub repeated_rows: u64,
    /// Rows of a table that stood out of order or had a false time, and were put in order.
    pub moved_rows: u64,
    /// Rows that are pending until it is decided whether samples are missing before them.
    pub pending_rows: u64,
    /// A rate by arrival times that the sensor contradicted, and whose samples are excluded.
    pub false_rate: Option<Finding>,
    /// A rate that the sensor reports and that arrival times show to be false.
    pub false_report: Option<Finding>,
    /// Samples excluded because they arrived at another rate for a while, as delayed bytes do.
    pub other_rate_samples: u64,
    /// The registers of the sensor by number, with their fields as it last printed them.
    pub registers: BTreeMap<u8, String>,
    /// Counts of everything that the stream carried, samples or not.
    pub link: StreamCounts,
    /// The outages of the link.
    pub outages: Outages,
    /// Places that the user marked, in time order; at most the first thousand.
    pub marks: Vec<PlaceMark>,
    /// Another program that had the port open, and so received a part of the bytes.
    pub port_shared_with: Option<String>,
    /// Samples with an axis at the end of its range, as the sensor reports.
    pub saturation: Saturation,
    /// How often the sensor restarted, by its device time; 0 without device times.
    pub restarts: u64,
    /// How often the device time stepped ahead of the clock of the host.
    pub time_steps: u64,
    /// Packets excluded because their time fits neither neighbour, by damage the CRC missed.
    pub false_times: u64,
    /// The settings of the measurement.
    pub settings: Settings,
    /// Data time excluded at the beginning.
    pub skipped: Duration,
    /// Sums of the axes against the temperature; `None` if the record contains none.
    pub temperature: Option<TemperatureRecord>,
    /// Averaging times that were asked for and that a final result does not have, in words.
    pub missing_times: Vec<String>,
    /// One per channel, in the order of `layout`; empty without a layout.
    pub channels: Vec<ChannelSnapshot>,
    /// The magnitude of each measured vector.
    pub magnitudes: Vec<Magnitude>,
    /// The channels of register 54, which was read between the sentences, under names of their own
    /// and without a deviation.
    pub register_channels: Vec<(Channel, ChannelSnapshot)>,
    /// A sample of the measured rows, by which two records of the same rows are recognised.
    pub fingerprint: Fingerprint,
    /// Limits of the result, the gravest first.
    pub warnings: Vec<Warning>,
    /// The latest samples; `None` where they are not kept.
    pub recent: Option<Recent>,
}

/// A place in the record that the user marked.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct PlaceMark {
    /// Data time from the beginning of the record, in seconds.
    pub at_s: f64,
    /// The text of the mark, as it was recorded.
    pub text: String,
}

impl Snapshot {
    /// The channels of the layout; empty without a layout.
    pub fn layout_channels(&self) -> &[Channel] {
        self.layout.as_ref().map_or(&[], |layout| &layout.channels)
    }

    /// The channels of the layout, each with its results.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Channel, &ChannelSnapshot)> + Clone {
        self.layout_channels().iter().zip(&self.channels)
    }

    /// The magnitude of the vector of the means of the first three channels that measure `quantity`, in
    /// their unit; `None` with fewer than three such channels, or without a sample.
    pub(crate) fn mean_magnitude(&self, quantity: Quantity) -> Option<f64> {
        let axes = self.measured().filter(|(channel, _)| channel.quantity == quantity).take(3);
        let means = axes.filter_map(|(channel, results)| Some(channel.in_unit(results.moments.mean_counts()?)));
        let [x, y, z] = means.collect::<Vec<f64>>().try_into().ok()?;
        Some(f64::hypot(x, y).hypot(z))
    }

    /// The latest polled temperature (register 54), in °C; `None` without a reading.
    pub fn polled_temperature_c(&self) -> Option<f64> {
        let sample = Sample::from_contents(&self.contents(Register::IMU)?, &VNIMU).ok()?;
        let mut values = sample.layout.channels.iter().zip(sample.values());
        values.find_map(|(channel, value)| (channel.quantity == Quantity::Temperature).then_some(value))
    }

    /// The value of a register; `None` where the stream does not contain it, or another form of it.
    pub(crate) fn register<T: RegisterValue>(&self, register: Register) -> Option<T> {
        self.contents(register)?.value().ok()
    }

    fn contents(&self, register: Register) -> Option<RegisterContents> {
        let fields = RegisterFields::new(self.registers.get(&register.0)?)?;
        Some(RegisterContents { register, fields })
    }

    /// Length, interval and kind of the octaves of a channel.
    pub fn shape_of(&self, results: &ChannelSnapshot) -> RecordShape {
        let rows = self.shape();
        RecordShape {
            samples: rows.samples.div_ceil(results.stride),
            interval_s: rows.interval_s * results.stride as f64,
            ..rows
        }
    }

    /// The sample rate of a channel, in hertz: that of the rows over the stride of the channel.
    pub fn rate_of(&self, results: &ChannelSnapshot) -> f64 {
        self.timing.rate_hz / results.stride as f64
    }

    /// Length, interval and kind of the octaves of a channel with a sample in every row.
    pub fn shape(&self) -> RecordShape {
        RecordShape {
            samples: self.timing.samples + self.timing.missing,
            interval_s: 1.0 / self.timing.rate_hz,
            estimator: self.settings.estimator,
            deviation: self.settings.deviation,
        }
    }
}

/// The times in which a link that had received samples was down.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Outages {
    /// How often the link was lost.
    pub times: u64,
    /// Sum of the times of all outages that have ended, in nanoseconds, each from the last row before the
    /// loss to the reconnect; `None` where the times of the events contradict each other.
    pub down_ns: Option<i64>,
    /// The start of the present outage by the arrival times; `None` while the link is up.
    pub since_ns: Option<i64>,
    /// When the link was closed for good during an outage; `None` where it was not.
    pub closed_ns: Option<i64>,
}

impl Outages {
    /// Takes a link event. The link is down since the last row: silence is reported late.
    pub(crate) fn take(&mut self, event: &LinkEvent, last_row_ns: Option<i64>) {
        match event.kind {
            LinkEventKind::Down { .. } if self.since_ns.is_none() => {
                if self.times == 0 {
                    self.down_ns = Some(0);
                }
                self.times += 1;
                // a clock may have been set back meanwhile
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

    /// The sum including the present outage up to `at_ns`, if there is one.
    fn down_until(&self, at_ns: i64) -> Option<i64> {
        let Some(since_ns) = self.since_ns else { return self.down_ns };
        // the stamps of a recording may go back
        let last_ns = at_ns.checked_sub(since_ns).filter(|ns| *ns >= 0)?;
        self.down_ns?.checked_add(last_ns)
    }

    /// Time without the link in seconds, to a millisecond; `None` if it is not known.
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

/// Rate, counts and gaps of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Nominal sample rate in hertz; an averaging time is m / rate.
    pub rate_hz: f64,
    /// Where the rate comes from.
    pub rate_from: RateFrom,
    /// Samples in the statistics.
    pub samples: u64,
    /// Valid samples excluded: by the user's choice of data time, or after a change of rate.
    pub excluded: u64,
    /// Samples known to be missing among those in the statistics.
    pub missing: u64,
    /// The evidence by which most missing samples were counted; of equal ones the latest.
    pub missing_from: MissingFrom,
    /// Places where samples are missing.
    pub gaps: u64,
    /// Stretches of samples without a gap or a change of the printed scale.
    pub segments: u64,
}

impl Timing {
    /// Data time of the samples in the statistics, in seconds: (samples + missing) / rate.
    pub fn duration_s(&self) -> f64 {
        (self.samples + self.missing) as f64 / self.rate_hz
    }
}

/// The evidence for missing samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MissingFrom {
    /// Each packet carries the time at which the sensor measured it, so that dropped ones are
    /// counted exactly.
    DeviceTime,
    /// The sensor counts its samples, so that dropped ones are counted exactly.
    Counter,
    /// Gaps in the arrival times.
    Arrival,
    /// Each rejected line counts as one dropped sample; entirely missing lines are not detected.
    #[default]
    #[serde(rename = "bad-lines")]
    RejectedRows,
}

impl MissingFrom {
    /// Whether missing samples are counted exactly.
    pub(crate) const fn is_exact(self) -> bool {
        matches!(self, Self::DeviceTime | Self::Counter)
    }
}

/// Where a sample rate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RateFrom {
    /// Given by the user.
    Option,
    /// Each packet carries the time at which the sensor measured it.
    DeviceTime,
    /// The sensor reported its output rate (register 07).
    Device,
    /// The nominal rate of the sensor that the arrival times match.
    Arrival,
    /// Unknown: the factory default of 40 Hz.
    Assumed,
}

/// The results of one channel. Values are in counts of the channel, see
/// [`Channel::scale`](crate::protocol::Channel::scale).
#[derive(Debug, Clone)]
pub struct ChannelSnapshot {
    /// Mean, standard deviation, higher moments and extremes.
    pub moments: Moments,
    /// How often each value occurred.
    pub histogram: Histogram,
    /// The deviation's exact sums, one per octave that has a window.
    pub octaves: Vec<OctaveSum>,
    /// The sums at the averaging times of the settings; empty for octaves, and until the end.
    pub points: Vec<OctaveSum>,
    /// Spectrum, blocks and distribution; `None` for a channel of register 54.
    pub signal: Option<ChannelSignal>,
    /// To be subtracted from mean, minimum and maximum, in counts: whole turns of an angle beyond -180
    /// (excluded) to 180 degrees, or the negative of the channel's `zero_counts`.
    pub branch_counts: i64,
    /// Rows per sample of the channel: more than 1 where the sensor measures less often.
    pub stride: u64,
    /// The step of the last digit that the sensor printed at any time, in counts, of an increment
    /// divided by the sample interval; 1 where all digits of the layout were printed.
    pub printed_step_counts: f64,
}

impl ChannelSnapshot {
    /// The actual step between neighbouring values in the unit of `channel`, or a printed digit.
    pub fn step(&self, channel: &Channel) -> f64 {
        channel.in_unit(self.histogram.step_counts().unwrap_or(0.0).max(self.printed_step_counts))
    }
}
