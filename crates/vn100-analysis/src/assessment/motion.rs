//! Whether the sensor was moved: then nothing in the record is its noise.

use std::fmt;

use imu_noise::Sensor;
use vn100_protocol::Channel;

use crate::{
    remedy::{Remedy, Text},
    sensor::sensor_of,
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Warning, WarningKind},
};

/// Standard deviations that no sensor at rest reaches.
///
/// Resting VN-100s at 40 Hz read 0.0006 to 0.0011 rad/s and 0.012 to 0.026 m/s², quiet or on a
/// shaking table. Of six records of cars, walks and hands the slowest has 0.10 rad/s and 0.68 m/s².
/// A bumped table lasts too short to come near.
const GYRO_LIMIT_RAD_S: f64 = 0.05;
const ACCEL_LIMIT_M_S2: f64 = 0.5;

/// A sensor that was moved, by the axis that shows it most; its text says so.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// The axis.
    pub channel: String,
    /// Its standard deviation over the record, in `unit`.
    pub std: f64,
    /// The least that counts as motion.
    pub limit: f64,
    /// rad/s or m/s².
    pub unit: String,
    /// All axes beyond their limits.
    pub axes: Vec<String>,
}

impl Motion {
    /// What the figures of a record in motion are worth, as a sentence.
    pub const MEANING: &str = "The sensor was moved: these figures describe the motion, not its noise.";

    /// By gyroscope and accelerometer; `None` at rest, and for less than four samples.
    pub(super) fn of(snapshot: &Snapshot) -> Option<Self> {
        let beyond: Vec<(&Channel, f64, f64)> = (snapshot.measured())
            .filter_map(|(channel, results)| {
                let limit = limit(channel)?;
                (inner_std(channel, results)? > limit).then_some((channel, std(channel, results)?, limit))
            })
            .collect();
        let (channel, std, limit) = *beyond.iter().max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
        let axes = beyond.iter().map(|(channel, ..)| channel.name.to_string()).collect();
        Some(Self { channel: channel.name.to_string(), std, limit, unit: channel.unit.to_string(), axes })
    }

    pub(super) fn warning(&self) -> Warning {
        let text = Text::from(format!(
            "{self}. All figures describe the motion, none of them the noise: nothing is compared with a data sheet, and neither vibration \
             lines nor disturbances, warm-up, gravity, magnetic field or heading are judged. Let the sensor lie still and record that, or \
             cut the record to where it does ("
        ));
        let text = text.remedy(Remedy::Skip(None)).then(", ").remedy(Remedy::EndEarlier).then(")");
        Warning::new(WarningKind::NotStationary, self.axes.clone(), text)
    }
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { channel, std, limit, unit, .. } = self;
        write!(
            f,
            "the sensor was moved: {channel} has a standard deviation of {std:.3} {unit}, at rest less than {limit}"
        )
    }
}

fn limit(channel: &Channel) -> Option<f64> {
    match sensor_of(channel.quantity)? {
        Sensor::Gyroscope => Some(GYRO_LIMIT_RAD_S),
        Sensor::Accelerometer => Some(ACCEL_LIMIT_M_S2),
        Sensor::Magnetometer => None,
    }
}

fn std(channel: &Channel, results: &ChannelSnapshot) -> Option<f64> {
    Some(channel.in_unit(results.moments.std_counts()?).abs())
}

/// Without the least and the greatest values, one in two hundred of each: damaged lines that pass
/// the checksum are rarer, and a single value may be as far out as the axis goes.
fn inner_std(channel: &Channel, results: &ChannelSnapshot) -> Option<f64> {
    let (histogram, total) = (&results.histogram, results.moments.count());
    let excluded = total.div_ceil(200);
    let (from, to) = (excluded, total.saturating_sub(excluded));
    let (mut before, mut sum, mut squares) = (0, 0.0, 0.0);
    let mean = results.moments.mean_counts()?;
    for (lowest, frequency) in histogram.bins() {
        let kept = (before + frequency).min(to).saturating_sub(before.max(from)) as f64;
        let off = lowest as f64 + 0.5 * (histogram.bin_width_counts() - 1) as f64 - mean;
        before += frequency;
        sum += kept * off;
        squares += kept * off * off;
    }
    let kept = to.checked_sub(from).filter(|kept| *kept > 1)? as f64;
    let variance = ((squares - sum * sum / kept) / (kept - 1.0)).max(0.0);
    Some(channel.in_unit(variance.sqrt()).abs())
}
