//! Octave by octave: an F-test of two variances at the same averaging time.

use serde::Serialize;
use vn100_protocol::Quantity;

use super::{Chance, SameSamples, correct, pairs};
use crate::assessment::{BEFORE_FILTER_S, LEAST_EDF, is_rounded_away};
use crate::hypothesis_tests::f_test;
use crate::{ChannelResult, SourceResult};

/// Relative difference up to which averaging times are the same.
const SAME_TAU: f64 = 1e-3;

/// The tests of one channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedChannel {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel.
    pub unit: String,
    /// By pair of records, in rising averaging time.
    pub octaves: Vec<OctaveTest>,
}

/// The deviations of two records at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OctaveTest {
    /// Averaging time in seconds.
    pub tau_s: f64,
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// The deviations of the two records, in the unit of the channel.
    pub deviations: [f64; 2],
    /// Equivalent degrees of freedom of the two variances.
    pub edf: [f64; 2],
    /// Probability of the F-test, corrected for all octaves of all channels of all pairs. Octaves
    /// share samples, so that the correction is conservative.
    #[serde(flatten)]
    pub chance: Chance,
}

impl ComparedChannel {
    /// The tests of each pair of records.
    pub fn pairs(&self) -> impl Iterator<Item = &[OctaveTest]> {
        self.octaves.chunk_by(|a, b| a.records == b.records)
    }
}

pub(super) fn tests(records: &[SourceResult], same: &[SameSamples], confidence: f64) -> Vec<ComparedChannel> {
    let mut channels: Vec<ComparedChannel> = Vec::new();
    for pair in pairs(records.len()).filter(|pair| same.iter().all(|same| same.records != *pair)) {
        let [a, b] = pair.map(|record| &records[record]);
        for channel in a.streamed().filter(|channel| is_noise(channel)) {
            let is_same = |other: &&ChannelResult| {
                (&other.name, other.quantity, &other.unit) == (&channel.name, channel.quantity, &channel.unit)
            };
            let Some(other) = b.streamed().find(is_same) else { continue };
            let one_is_tracked =
                channel.quantity == Quantity::AngularRate && a.source.compensated != b.source.compensated;
            let until_s = if one_is_tracked { BEFORE_FILTER_S } else { f64::INFINITY };
            let tests = pair_tests(pair, [channel, other], until_s);
            match channels.iter_mut().find(|found| found.name == channel.name && found.unit == channel.unit) {
                Some(found) => found.octaves.extend(tests),
                None if tests.is_empty() => {}
                None => channels.push(ComparedChannel {
                    name: channel.name.clone(),
                    unit: channel.unit.clone(),
                    octaves: tests,
                }),
            }
        }
    }
    let tests = channels.iter_mut().flat_map(|channel| &mut channel.octaves);
    correct(tests.map(|test| &mut test.chance), confidence);
    channels
}

/// The octaves up to an averaging time that two records of a channel share.
fn pair_tests(records: [usize; 2], channels: [&ChannelResult; 2], until_s: f64) -> Vec<OctaveTest> {
    let [points_a, points_b] = channels.map(points);
    let test = |(tau_s, deviation, edf): (f64, f64, f64)| {
        let (_, other, other_edf) = points_b.iter().find(|(other, ..)| (other / tau_s - 1.0).abs() < SAME_TAU)?;
        let p = f_test((deviation.powi(2), edf), (other.powi(2), *other_edf))?;
        let (deviations, edf) = ([deviation, *other], [edf, *other_edf]);
        Some(OctaveTest { tau_s, records, deviations, edf, chance: Chance::new(p) })
    };
    points_a.into_iter().filter(|(tau_s, ..)| *tau_s <= until_s).filter_map(test).collect()
}

/// Changes of temperature and pressure are those of the weather, not the noise of the sensor.
fn is_noise(channel: &ChannelResult) -> bool {
    !matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure)
}

/// Averaging time, deviation and degrees of freedom; none if the last digit hides the noise.
fn points(channel: &ChannelResult) -> Vec<(f64, f64, f64)> {
    let octaves = channel.octaves();
    let shortest = octaves.first().and_then(|point| point.deviation);
    if shortest.is_some_and(|deviation| is_rounded_away(deviation, channel.statistics.resolution)) {
        return Vec::new();
    }
    let known = octaves.iter().filter_map(|point| Some((point.tau_s, point.deviation?, point.edf?)));
    known.filter(|(_, deviation, edf)| *deviation > 0.0 && *edf >= LEAST_EDF).collect()
}
