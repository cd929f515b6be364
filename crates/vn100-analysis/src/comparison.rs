//! Records side by side: what differs significantly.

mod caveat;
mod means;
mod octaves;
mod population;
mod ranking;

use serde::Serialize;
use vn100_protocol::Quantity;

pub use caveat::{Caveat, CaveatKind};
pub use means::{ChannelMeans, RecordMean, Spread};
pub use octaves::{ComparedChannel, OctaveTest};
pub use population::{NoPrediction, Population, UnitValue};
pub use ranking::{AxisWhite, RankedRecord, Ranking, WhiteTest};

use crate::hypothesis_tests::holm;
use crate::result::Basis;
use crate::{ChannelResult, SourceResult, Warning, WarningKind};

/// Warnings about events within a record, not about how it was made.
const DISTURBANCES: [WarningKind; 3] = [WarningKind::NotStationary, WarningKind::VibrationLine, WarningKind::WarmUp];

/// A comparison of several records in SI units, magnetic field in gauss. A record is referred to by
/// its place among those given, from 0. Of fewer than two records all lists of differences are empty.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Two-sided level of every interval; a difference is significant if its corrected probability is
    /// below 1 - confidence.
    pub confidence: f64,
    /// F-tests of the octaves that two records share, corrected for all of them together.
    pub channels: Vec<ComparedChannel>,
    /// By sensor, the records in ascending order of their white noise.
    #[serde(rename = "sensors")]
    pub rankings: Vec<Ranking>,
    /// Pairs of records that hold the same samples, which are not tested against each other.
    pub same_samples: Vec<SameSamples>,
    /// By channel of a sensor: the mean in each record, and their spread.
    pub means: Vec<ChannelMeans>,
    /// N, B and K over three recordings or more, copies counted once.
    pub populations: Vec<Population>,
    /// Events that disturbed a record, each with the number of the record.
    #[serde(skip)]
    pub disturbances: Vec<(usize, Warning)>,
    /// What could not be compared, or only in part.
    #[serde(skip)]
    pub caveats: Vec<Caveat>,
}

/// Two records with the same samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SameSamples {
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// Share of the rows of the first record that are also in the second, 0 to 1, known to a few
    /// percent.
    pub of_first: f64,
    /// Share of the rows of the second record that are also in the first, in the same way.
    pub of_second: f64,
}

impl SameSamples {
    /// From this share on, all of a record counts as part of the other: a few rows may be dropped.
    pub const WHOLE: f64 = 0.98;
}

/// The two probabilities of one test among many.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Chance {
    /// Probability of a difference at least as large by chance alone, for this test alone; 0 to 1.
    pub p: f64,
    /// The same probability with Holm's correction for all tests made together.
    pub corrected: f64,
    /// Whether the difference is statistically significant.
    pub differs: bool,
}

impl Chance {
    /// A test by itself; [`correct`] makes it one of many.
    const fn new(p: f64) -> Self {
        Self { p, corrected: p, differs: false }
    }
}

impl Comparison {
    /// Compares records assessed at the level `confidence`, 0 < p < 1; outside that range no
    /// difference is significant and nothing is ranked. `units` names the sensor of each record.
    pub fn of(records: &[SourceResult], units: &[String], confidence: f64) -> Self {
        let same_samples = same_samples(records);
        let rankings = ranking::rankings(records, &same_samples, confidence);
        Self {
            confidence,
            channels: octaves::tests(records, &same_samples, confidence),
            rankings,
            means: means::means(records, confidence),
            populations: population::populations(records, units, &same_samples, confidence),
            disturbances: disturbances(records),
            caveats: caveat::caveats(records, &same_samples),
            same_samples,
        }
    }
}

/// Corrects the probabilities of tests that are made together.
fn correct<'a>(tests: impl Iterator<Item = &'a mut Chance>, confidence: f64) {
    let tests: Vec<_> = tests.collect();
    let corrected = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    for (test, corrected) in tests.into_iter().zip(corrected) {
        *test = Chance { p: test.p, corrected, differs: corrected < 1.0 - confidence };
    }
}

fn disturbances(records: &[SourceResult]) -> Vec<(usize, Warning)> {
    let all = records.iter().enumerate().flat_map(|(record, result)| {
        let Basis { snapshot, assessment } = &*result.basis;
        let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
        warnings.map(move |warning| (record, warning.clone()))
    });
    all.filter(|(_, warning)| DISTURBANCES.contains(&warning.kind)).collect()
}

fn same_samples(records: &[SourceResult]) -> Vec<SameSamples> {
    let shared = |pair: [usize; 2]| {
        let [a, b] = pair.map(|record| &records[record]);
        let shared = a.basis.snapshot.fingerprint.shared_with(&b.basis.snapshot.fingerprint);
        let [of_first, of_second] = shared.or_else(|| are_of_one_record(a, b).then_some([1.0; 2]))?;
        Some(SameSamples { records: pair, of_first, of_second })
    };
    pairs(records.len()).filter_map(shared).collect()
}

/// Whether as many samples have means and standard deviations as near to each other as the rounding of one
/// record in two units leaves them, on three axes at least. Other records of that noise are so near on an
/// axis twice in a thousand times at most.
fn are_of_one_record(a: &SourceResult, b: &SourceResult) -> bool {
    let is_near = |axis: &ChannelResult| {
        let is_other = |other: &&ChannelResult| (&other.name, &other.unit) == (&axis.name, &axis.unit);
        let (a, b) = (&axis.statistics, &b.streamed().find(is_other)?.statistics);
        let (std, steps) = (a.std?, a.resolution + b.resolution);
        // four standard deviations of a mean of rounding errors; of a coarse one other records have as much
        let most = 4.0 * steps / (12.0 * a.count as f64).sqrt() + 1e-9 * std;
        let is_near = (std - b.std?).abs() < most && (a.mean? - b.mean?).abs() < most;
        (steps < 0.05 * std).then_some(is_near && a.count == b.count)
    };
    let axes: Vec<bool> = a.streamed().filter_map(is_near).collect();
    axes.len() >= 3 && axes.iter().all(|is_near| *is_near)
}

/// Every pair out of `count` records, the earlier record first.
fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| [a, b]))
}

/// Whether the white noise of `quantity` aliases in the same way in both records. If averaging and
/// decimation are not known, that is assumed for equal rates.
fn fold_alike(quantity: Quantity, a: &SourceResult, b: &SourceResult) -> bool {
    let onboard = |record: &SourceResult| record.streamed().find(|channel| channel.quantity == quantity)?.onboard;
    match (onboard(a), onboard(b)) {
        (Some(a), Some(b)) => (a.window.white_factor() / b.window.white_factor() - 1.0).abs() < 0.01,
        _ => have_same_rate(a, b),
    }
}

fn have_same_rate(a: &SourceResult, b: &SourceResult) -> bool {
    (rate_hz(a) / rate_hz(b) - 1.0).abs() < 1e-3
}

/// Every record with samples has a rate.
fn rate_hz(record: &SourceResult) -> f64 {
    record.timing.rate_hz.unwrap_or(f64::NAN)
}
