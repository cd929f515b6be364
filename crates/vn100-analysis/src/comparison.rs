//! Records side by side: what differs significantly.

mod caveat;
mod means;
mod octaves;
mod population;
mod ranking;
mod recommendation;
mod two_sample;

use vn100_protocol::Quantity;

pub use caveat::{Caveat, CaveatKind};
pub use means::{ChannelMeans, MeanDifference, MeanError, MeanTest, RecordMean, Untested};
pub use octaves::OctaveTest;
pub use population::{NoPrediction, Population, UnitValue};
pub use ranking::{RankedRecord, Ranking, WhiteTest};
pub use recommendation::{Recommendation, WhyNone, WhyUse};

use crate::hypothesis_tests::holm;
use crate::{Assessment, Onboard, SharedRows, Snapshot, Warning, WarningKind};

/// Warnings about events within a record, not about how it was made.
const DISTURBANCES: [WarningKind; 3] = [WarningKind::NotStationary, WarningKind::VibrationLine, WarningKind::WarmUp];

/// One record to be compared.
#[derive(Debug, Clone, Copy)]
pub struct ComparedRecord<'a> {
    /// The name of the record in texts.
    pub name: &'a str,
    /// The numbers of the record.
    pub snapshot: &'a Snapshot,
    /// The assessment of the snapshot.
    pub assessment: &'a Assessment,
    /// When the source of the record began, before any skip, in nanoseconds since 1970-01-01 UTC;
    /// 0 or `None` where that is not known.
    pub started_ns: Option<i64>,
}

impl ComparedRecord<'_> {
    /// When the source began, where that is known: a recording that bears no date begins at 0.
    fn start_ns(&self) -> Option<i64> {
        self.started_ns.filter(|started_ns| *started_ns > 0)
    }
}

/// A comparison of several records. A record is referred to by its place among those given, from 0.
/// Of fewer than two records all lists of differences are empty.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Two-sided level of every interval; a difference is significant where its corrected
    /// probability is below 1 - confidence.
    pub confidence: f64,
    /// The octaves that two records share at the same averaging time; corrected for all of them
    /// together.
    pub octaves: Vec<OctaveTest>,
    /// By sensor, the records in ascending order of their white noise.
    pub rankings: Vec<Ranking>,
    /// By channel of a sensor: the mean in each record, and the differences of the means.
    pub means: Vec<ChannelMeans>,
    /// Events that disturbed a record.
    pub disturbances: Vec<RecordDisturbance>,
    /// Pairs of records that hold the same samples, which are not tested against each other.
    pub same_samples: Vec<SameSamples>,
    /// The record to use where one is enough, or why there is none.
    pub recommended: Result<Recommendation, WhyNone>,
    /// What could not be compared, or only in part.
    pub caveats: Vec<Caveat>,
}

/// An event that disturbed a record.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordDisturbance {
    /// The number of the record.
    pub record: usize,
    /// The kind of event, its time, and the channels.
    pub warning: Warning,
}

/// Two records with the same samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SameSamples {
    /// The numbers of the two records.
    pub records: [usize; 2],
    /// The shares of each record that are in the other.
    pub shared: SharedRows,
}

impl SameSamples {
    /// From this share on, all of a record counts as part of the other: a few rows may have been
    /// dropped.
    pub const WHOLE: f64 = 0.98;
}

/// The two probabilities of one test among many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chance {
    /// Probability of a difference at least as large by chance alone, for this test alone; 0 to 1.
    pub p: f64,
    /// The same probability with Holm's correction for all tests made together.
    pub corrected: f64,
}

impl Comparison {
    /// Compares records assessed at the level `confidence`, 0 < p < 1; outside that range no
    /// difference is significant and nothing is ranked. `stayed_on`: the sensor was not switched
    /// off between the records, so that noise alone may have changed their means; the records
    /// themselves do not show that.
    #[must_use]
    pub fn of(records: &[ComparedRecord<'_>], stayed_on: bool, confidence: f64) -> Self {
        let same_samples = same_samples(records);
        let mut comparison = Self {
            confidence,
            octaves: octaves::tests(records, &same_samples),
            rankings: ranking::rankings(records, &same_samples, confidence),
            means: means::means(records, &same_samples, stayed_on, confidence),
            disturbances: disturbances(records),
            caveats: caveat::caveats(records, &same_samples, stayed_on),
            same_samples,
            recommended: Err(WhyNone::NotRanked),
        };
        comparison.recommended = recommendation::recommendation(&comparison, records);
        comparison
    }

    /// N, B and K of each axis over these records, if three or more say something of them. `units`
    /// names the sensor of each record; of records with the same samples the first counts alone.
    #[must_use]
    pub fn populations(&self, records: &[ComparedRecord<'_>], units: &[String]) -> Vec<Population> {
        population::populations(records, units, &self.same_samples, self.confidence)
    }

    /// Whether a difference with this probability is statistically significant.
    #[must_use]
    pub fn is_significant(&self, chance: Chance) -> bool {
        chance.corrected < 1.0 - self.confidence
    }
}

fn disturbances(records: &[ComparedRecord<'_>]) -> Vec<RecordDisturbance> {
    let all = records.iter().enumerate().flat_map(|(record, ComparedRecord { snapshot, assessment, .. })| {
        let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
        warnings.map(move |warning| RecordDisturbance { record, warning: warning.clone() })
    });
    all.filter(|disturbance| DISTURBANCES.contains(&disturbance.warning.kind)).collect()
}

fn same_samples(records: &[ComparedRecord<'_>]) -> Vec<SameSamples> {
    let shared = |pair: [usize; 2]| {
        let [a, b] = pair.map(|record| &records[record].snapshot.fingerprint);
        Some(SameSamples { records: pair, shared: a.shared_with(b)? })
    };
    pairs(records.len()).filter_map(shared).collect()
}

fn chances(probabilities: &[f64]) -> Vec<Chance> {
    let corrected = holm(probabilities);
    probabilities.iter().zip(corrected).map(|(&p, corrected)| Chance { p, corrected }).collect()
}

/// Every pair out of `count` records, the earlier record first.
fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| [a, b]))
}

/// What the sensor does on board to the channels of `quantity`; `None` where that is not known.
fn onboard(quantity: Quantity, record: &ComparedRecord<'_>) -> Option<Onboard> {
    let layout = record.snapshot.layout.as_ref()?;
    let channel = layout.channels.iter().position(|channel| channel.quantity == quantity)?;
    record.assessment.channels.get(channel)?.onboard
}

/// Whether the white noise of `quantity` aliases in the same way in both records. Where averaging
/// and decimation are not known, that is assumed for equal rates.
fn fold_alike(quantity: Quantity, a: &ComparedRecord<'_>, b: &ComparedRecord<'_>) -> bool {
    match (onboard(quantity, a), onboard(quantity, b)) {
        (Some(a), Some(b)) => (a.window.white_factor() / b.window.white_factor() - 1.0).abs() < 0.01,
        _ => (a.snapshot.timing.rate_hz / b.snapshot.timing.rate_hz - 1.0).abs() < 1e-3,
    }
}
