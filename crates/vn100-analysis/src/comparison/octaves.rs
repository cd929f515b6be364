//! Octave by octave: an F-test of two variances at the same averaging time.

use serde::Serialize;
use vn100_protocol::{Channel, Quantity};

use super::{Chance, ComparedRecord, SameSamples, correct, pairs};
use crate::assessment::{BEFORE_FILTER_S, LEAST_EDF, is_rounded_away};
use crate::hypothesis_tests::f_test;

/// Relative difference up to which averaging times are the same.
const SAME_TAU: f64 = 1e-3;

/// The tests of one channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedChannel {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel.
    pub unit: String,
    /// Quantity of the channel.
    #[serde(skip)]
    pub quantity: Quantity,
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

pub(super) fn tests(records: &[ComparedRecord<'_>], same: &[SameSamples], confidence: f64) -> Vec<ComparedChannel> {
    let mut channels: Vec<ComparedChannel> = Vec::new();
    for pair in pairs(records.len()).filter(|pair| same.iter().all(|same| same.records != *pair)) {
        let [a, b] = pair.map(|record| &records[record]);
        for (place, channel) in a.snapshot.layout_channels().iter().enumerate().filter(|(_, channel)| is_noise(channel))
        {
            let is_same = |other: &Channel| {
                (&other.name, other.quantity, &other.unit) == (&channel.name, channel.quantity, &channel.unit)
            };
            let Some(other) = b.snapshot.layout_channels().iter().position(is_same) else { continue };
            let tests = pair_tests(pair, (a, place), (b, other), channel.quantity);
            match channels.iter_mut().find(|found| found.name == channel.name && found.unit == channel.unit) {
                Some(found) => found.octaves.extend(tests),
                None if tests.is_empty() => {}
                None => channels.push(ComparedChannel {
                    name: channel.name.to_string(),
                    unit: channel.unit.to_string(),
                    quantity: channel.quantity,
                    octaves: tests,
                }),
            }
        }
    }
    let tests = channels.iter_mut().flat_map(|channel| &mut channel.octaves);
    correct(tests.map(|test| &mut test.chance), confidence);
    channels
}

/// The octaves that two records share, of the channel at a place of each.
fn pair_tests(
    records: [usize; 2],
    (a, place_a): (&ComparedRecord<'_>, usize),
    (b, place_b): (&ComparedRecord<'_>, usize),
    quantity: Quantity,
) -> Vec<OctaveTest> {
    let compensated = |record: &ComparedRecord<'_>| record.snapshot.layout.as_ref()?.compensated;
    let one_is_tracked = quantity == Quantity::AngularRate && compensated(a) != compensated(b);
    let points_b = points(b, place_b);
    let points_a = points(a, place_a).into_iter().filter(|a| !one_is_tracked || a.tau_s <= BEFORE_FILTER_S);
    let test = |point: OctavePoint| {
        let other = points_b.iter().find(|other| (other.tau_s / point.tau_s - 1.0).abs() < SAME_TAU)?;
        let p = f_test((point.deviation.powi(2), point.edf), (other.deviation.powi(2), other.edf))?;
        Some(OctaveTest {
            tau_s: point.tau_s,
            records,
            deviations: [point.deviation, other.deviation],
            edf: [point.edf, other.edf],
            chance: Chance::new(p),
        })
    };
    points_a.filter_map(test).collect()
}

/// Changes of temperature and pressure are those of the weather, not the noise of the sensor.
fn is_noise(channel: &Channel) -> bool {
    !matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure)
}

struct OctavePoint {
    tau_s: f64,
    deviation: f64,
    edf: f64,
}

/// The octaves with enough degrees of freedom; none if the last printed digit hides the noise.
fn points(record: &ComparedRecord<'_>, place: usize) -> Vec<OctavePoint> {
    let ComparedRecord { snapshot, assessment } = record;
    let Some((channel, results, assessed)) = snapshot.assessed(&assessment.channels).nth(place) else {
        return Vec::new();
    };
    let point = |(octave, assessed): (&imu_noise::OctaveSum, &crate::OctaveAssessment)| {
        let deviation = channel.in_unit(octave.deviation_counts()?);
        let edf = assessed.relative?.edf;
        let tau_s = octave.m as f64 / snapshot.rate_of(results);
        (deviation > 0.0 && edf >= LEAST_EDF).then_some(OctavePoint { tau_s, deviation, edf })
    };
    let octaves = results.octaves.iter().zip(&assessed.octaves).filter(|_| !is_rounded_away(channel, results));
    octaves.filter_map(point).collect()
}
