//! The means of each channel and their spread: the turn-on to turn-on bias of power cycles.

use imu_noise::{Spread, VarianceEstimate};
use vn100_protocol::{Channel, Quantity, Register};

use super::{Chance, ComparedRecord, chances};
use crate::sensor::sensor_of;

/// Of the longest averaging time that says how well a mean is known.
const LEAST_EDF: f64 = 3.0;

/// One channel of a sensor over all records.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMeans {
    /// Its name.
    pub channel: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Its unit.
    pub unit: String,
    /// One per record that has it and samples, and where the sensor was not moved.
    pub means: Vec<RecordMean>,
    /// `None` with fewer than two standard errors, and where the records are of several sensors.
    pub spread: Option<Spread>,
    /// That the noise within the records alone spreads them so; corrected for all channels.
    pub chance: Option<Chance>,
    /// A filter takes the bias out of one of the records at least: the spread is not that of the
    /// bias.
    pub bias_removed: bool,
}

/// The mean of a channel in one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordMean {
    /// Number of the record.
    pub record: usize,
    /// In the unit of the channel.
    pub mean: f64,
    /// Error by noise alone; `None` for a record that is too short.
    pub error: Option<MeanError>,
}

/// What is known of the error of a mean: the deviation at the longest averaging time that is known.
///
/// σ(τ)/√2 of neighbouring means of length τ is what they differ by, so that σ(τ) is the standard
/// error of each. As the record is longer than τ, white noise is overrated, by √(T/τ), and flicker
/// noise is not; σ/√n would underrate the latter without limit. What changes more slowly than a
/// record lasts counts as a difference between records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanError {
    /// Standard error, in the unit of the channel.
    pub standard_error: f64,
    /// Its equivalent degrees of freedom.
    pub edf: f64,
    /// The averaging time in seconds.
    pub tau_s: f64,
}

pub(super) fn means(records: &[ComparedRecord<'_>], confidence: f64) -> Vec<ChannelMeans> {
    let mut found: Vec<ChannelMeans> = Vec::new();
    // what moves has no bias that its mean shows
    let at_rest = records.iter().enumerate().filter(|(_, record)| record.assessment.motion.is_none());
    for (number, record) in at_rest {
        let Some(layout) = &record.snapshot.layout else { continue };
        for (index, channel) in layout.channels.iter().enumerate() {
            // an angle has no bias, and what surrounds the sensor is not the sensor's
            if sensor_of(channel.quantity).is_none() {
                continue;
            }
            let Some(mean) = mean(record, number, index, channel) else { continue };
            let bias_removed = layout.compensated && channel.quantity == Quantity::AngularRate;
            match found.iter_mut().find(|means| means.channel == channel.name && means.unit == channel.unit) {
                Some(means) => {
                    means.means.push(mean);
                    means.bias_removed |= bias_removed;
                }
                None => found.push(ChannelMeans {
                    channel: channel.name.to_string(),
                    quantity: channel.quantity,
                    unit: channel.unit.to_string(),
                    means: vec![mean],
                    spread: None,
                    chance: None,
                    bias_removed,
                }),
            }
        }
    }
    if !are_of_several_sensors(records) {
        for channel in &mut found {
            let known = channel.means.iter().filter_map(|mean| {
                let error = mean.error?;
                Some((mean.mean, VarianceEstimate { variance: error.standard_error.powi(2), edf: error.edf }))
            });
            channel.spread = Spread::of(&known.collect::<Vec<_>>(), confidence);
        }
        let probabilities: Vec<f64> =
            found.iter().filter_map(|channel| channel.spread.map(|spread| spread.p)).collect();
        let with_spread = found.iter_mut().filter(|channel| channel.spread.is_some());
        for (channel, chance) in with_spread.zip(chances(&probabilities)) {
            channel.chance = Some(chance);
        }
    }
    found
}

fn mean(record: &ComparedRecord<'_>, number: usize, index: usize, channel: &Channel) -> Option<RecordMean> {
    let value = |counts| channel.in_unit(counts);
    let results = record.snapshot.channels.get(index)?;
    let mean = value(results.moments.mean_counts()? - results.branch_counts as f64);
    let octaves = record.assessment.channels.get(index).map_or(&[][..], |assessed| &assessed.octaves);
    let known = results.octaves.iter().zip(octaves).rev().find_map(|(octave, assessed)| {
        let edf = assessed.relative?.edf;
        let standard_error = value(octave.deviation_counts()?);
        let tau_s = octave.m as f64 / record.snapshot.timing.rate_hz;
        (edf >= LEAST_EDF && standard_error > 0.0).then_some(MeanError { standard_error, edf, tau_s })
    });
    Some(RecordMean { record: number, mean, error: known })
}

/// Whether two of the records say serial numbers, and different ones.
pub(super) fn are_of_several_sensors(records: &[ComparedRecord<'_>]) -> bool {
    let mut serials = records.iter().filter_map(|record| record.snapshot.registers.get(&Register::SERIAL_NUMBER.0));
    let first = serials.next();
    serials.any(|serial| Some(serial) != first)
}
