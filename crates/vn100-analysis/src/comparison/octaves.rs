//! Octave by octave: an F-test of two variances at the same averaging time.

use crate::hypothesis_tests::f_test;
use vn100_protocol::{Channel, Quantity};

use super::{Chance, ComparedRecord, SameSamples, chances, pairs};
use crate::assessment::{BEFORE_FILTER_S, is_rounded_away};

/// With fewer degrees of freedom the distribution of a variance is not known well enough.
const LEAST_EDF: f64 = 2.0;

/// Relative difference up to which averaging times are the same.
const SAME_TAU: f64 = 1e-3;

/// The deviations of two records at one averaging time of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct OctaveTest {
    /// Name of the channel.
    pub channel: String,
    /// Quantity of the channel.
    pub quantity: Quantity,
    /// Unit of the channel.
    pub unit: String,
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
    pub chance: Chance,
}

#[derive(Debug, Clone, Copy)]
struct OctavePoint {
    tau_s: f64,
    deviation: f64,
    edf: f64,
}

pub(super) fn tests(records: &[ComparedRecord<'_>], same: &[SameSamples]) -> Vec<OctaveTest> {
    let mut tests = Vec::new();
    let mut probabilities = Vec::new();
    for pair in pairs(records.len()).filter(|pair| same.iter().all(|same| same.records != *pair)) {
        let [a, b] = pair.map(|record| &records[record]);
        let Some((layout_a, layout_b)) = a.snapshot.layout.as_ref().zip(b.snapshot.layout.as_ref()) else { continue };
        for (index_a, channel) in layout_a.channels.iter().enumerate().filter(|(_, channel)| is_noise(channel)) {
            let same = |other: &Channel| {
                (&other.name, other.quantity, &other.unit) == (&channel.name, channel.quantity, &channel.unit)
            };
            let Some(index_b) = layout_b.channels.iter().position(same) else { continue };
            let one_is_tracked =
                channel.quantity == Quantity::AngularRate && layout_a.compensated != layout_b.compensated;
            let points_b = points(b, index_b);
            for point in points(a, index_a).into_iter().filter(|a| !one_is_tracked || a.tau_s <= BEFORE_FILTER_S) {
                let found = points_b.iter().find(|other| (other.tau_s / point.tau_s - 1.0).abs() < SAME_TAU);
                let Some(other) = found else { continue };
                let square = |point: &OctavePoint| (point.deviation.powi(2), point.edf);
                let Some(p) = f_test(square(&point), square(other)) else { continue };
                probabilities.push(p);
                tests.push(OctaveTest {
                    channel: channel.name.to_string(),
                    quantity: channel.quantity,
                    unit: channel.unit.to_string(),
                    tau_s: point.tau_s,
                    records: pair,
                    deviations: [point.deviation, other.deviation],
                    edf: [point.edf, other.edf],
                    chance: Chance { p, corrected: p },
                });
            }
        }
    }
    for (test, chance) in tests.iter_mut().zip(chances(&probabilities)) {
        test.chance = chance;
    }
    tests
}

/// Changes of temperature and pressure are those of the weather, not the noise of the sensor.
fn is_noise(channel: &Channel) -> bool {
    !matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure)
}

/// The octaves with enough degrees of freedom; none where the last printed digit hides the noise.
fn points(record: &ComparedRecord<'_>, index: usize) -> Vec<OctavePoint> {
    let ComparedRecord { snapshot, assessment, .. } = record;
    let channel = snapshot.layout.as_ref().and_then(|layout| layout.channels.get(index));
    let (Some(channel), Some(results), Some(assessed)) =
        (channel, snapshot.channels.get(index), assessment.channels.get(index))
    else {
        return Vec::new();
    };
    if is_rounded_away(channel, results) {
        return Vec::new();
    }
    (results.octaves.iter().zip(&assessed.octaves))
        .filter_map(|(octave, assessed)| {
            let deviation = channel.in_unit(octave.deviation_counts()?);
            let edf = assessed.relative?.edf;
            let tau_s = octave.m as f64 / snapshot.rate_of(results);
            (deviation > 0.0 && edf >= LEAST_EDF).then_some(OctavePoint { tau_s, deviation, edf })
        })
        .collect()
}
