//! The means of each channel, and how far they lie apart.

use imu_noise::Interval;
use serde::Serialize;
use vn100_protocol::Quantity;

use super::caveat::are_of_several_sensors;
use crate::{SourceResult, sensor::sensor_of};

/// The means of one channel of a sensor over all records.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelMeans {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel.
    pub unit: String,
    /// One for each record that has samples of the channel and in which the sensor was not moved.
    pub means: Vec<RecordMean>,
    /// The spread of the means; `None` for fewer than two means, and if the records are of several
    /// sensors.
    pub spread: Option<Spread>,
    /// Whether a filter removes the bias in at least one of the records: the spread is then not
    /// that of the bias.
    pub bias_removed: bool,
}

/// The mean of a channel in one record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RecordMean {
    /// Number of the record.
    pub record: usize,
    /// The mean, in the unit of the channel.
    pub mean: f64,
}

/// How far the means of several records lie apart: the turn-on to turn-on bias if each record is a
/// power cycle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Standard deviation of the means, with n - 1.
    pub deviation: f64,
    /// Lower end of its interval (χ²); `None` for two means, which span a factor of seventy at 95 %.
    pub lower: Option<f64>,
    /// Upper end of its interval; likewise.
    pub upper: Option<f64>,
    /// Degrees of freedom: n - 1.
    pub dof: usize,
}

impl Spread {
    /// Of `means`; `None` for fewer than two.
    fn of(means: &[RecordMean], confidence: f64) -> Option<Self> {
        let dof = means.len().checked_sub(1).filter(|dof| *dof > 0)?;
        let mean = means.iter().map(|mean| mean.mean).sum::<f64>() / means.len() as f64;
        let variance = means.iter().map(|value| (value.mean - mean).powi(2)).sum::<f64>() / dof as f64;
        let interval = Interval::new(variance, dof as f64, confidence).filter(|_| dof >= 2);
        let (lower, upper) = (interval.map(|interval| interval.lower), interval.map(|interval| interval.upper));
        Some(Self { deviation: variance.sqrt(), lower, upper, dof })
    }
}

/// Of channels that have a bias, in records in which the sensor was not moved: a mean of temperature or
/// pressure is that of the surroundings.
pub(super) fn means(records: &[SourceResult], confidence: f64) -> Vec<ChannelMeans> {
    let mut found: Vec<ChannelMeans> = Vec::new();
    for (record, result) in records.iter().enumerate().filter(|(_, record)| record.motion.is_none()) {
        for channel in result.streamed().filter(|channel| sensor_of(channel.quantity).is_some()) {
            let Some(mean) = channel.statistics.mean else { continue };
            let mean = RecordMean { record, mean };
            let bias_removed = result.source.compensated == Some(true) && channel.quantity == Quantity::AngularRate;
            match found.iter_mut().find(|found| found.name == channel.name && found.unit == channel.unit) {
                Some(found) => {
                    found.means.push(mean);
                    found.bias_removed |= bias_removed;
                }
                None => found.push(ChannelMeans {
                    name: channel.name.clone(),
                    unit: channel.unit.clone(),
                    means: vec![mean],
                    spread: None,
                    bias_removed,
                }),
            }
        }
    }
    let is_one_sensor = !are_of_several_sensors(records);
    for channel in found.iter_mut().filter(|_| is_one_sensor) {
        channel.spread = Spread::of(&channel.means, confidence);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From SciPy 1.17.1: `chi2.ppf([.975, .025], 2)`.
    #[test]
    fn a_spread_has_the_interval_of_the_reference() {
        let spread = |means: &[f64]| {
            let mean = |(record, mean): (usize, &f64)| RecordMean { record, mean: *mean };
            Spread::of(&means.iter().enumerate().map(mean).collect::<Vec<_>>(), 0.95)
        };
        let found = spread(&[1.0, 2.0, 4.0]).unwrap();
        let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-7, "{found}");
        near(found.deviation.powi(2), 7.0 / 3.0);
        near(found.lower.unwrap(), 0.795_318_64);
        near(found.upper.unwrap(), 9.600_090_82);
        assert_eq!(spread(&[1.0]), None);
        assert_eq!(spread(&[1.0, 1.0]), Some(Spread { deviation: 0.0, lower: None, upper: None, dof: 1 }));
    }
}
