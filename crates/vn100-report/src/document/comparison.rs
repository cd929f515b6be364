//! The JSON document of several captures side by side, schema `vn100.comparison/1`: a contract with
//! scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `record` is a place in
//! `records`, from 0. A probability `p` is that of one test alone, `corrected` is `p` with Holm's
//! correction; `differs` is `corrected` < 1 - `confidence`.

use serde::Serialize;
use vn100_analysis::{
    Chance, ChannelMeans, Comparison, MeanDifference, OctaveTest, Population, Ranking, RemedyWords, SourceResult,
    UnitValue, Untested, axes_name, sensor_of,
};

use crate::{
    codes::term_name,
    names::{no_prediction, recommendation},
    units::si_unit,
    warnings::{caveat_in_words, in_words},
};

/// The name of a record among several, by its place from 0: `run 1` for the first.
#[must_use]
pub fn run_name(number: usize) -> String {
    format!("run {}", number + 1)
}

/// The prefix of the figures of a record, by its place from 0: `run1-` for the first.
#[must_use]
pub fn run_prefix(number: usize) -> String {
    format!("run{}-", number + 1)
}

/// The tests grouped by channel, in the order in which the channels first occur.
#[must_use]
pub fn tests_by_channel(tests: &[OctaveTest]) -> Vec<Vec<&OctaveTest>> {
    let mut channels: Vec<Vec<&OctaveTest>> = Vec::new();
    for test in tests {
        let same = |others: &&mut Vec<&OctaveTest>| {
            others.first().is_some_and(|other| (&other.channel, &other.unit) == (&test.channel, &test.unit))
        };
        match channels.iter_mut().find(same) {
            Some(others) => others.push(test),
            None => channels.push(vec![test]),
        }
    }
    channels
}

/// The JSON document of several records side by side.
#[derive(Debug, Serialize)]
pub struct ComparisonDocument {
    schema: &'static str,
    confidence: f64,
    /// In the order given, those that could not be read too.
    records: Vec<RecordDocument>,
    /// F-tests of the octaves that two records share; corrected for all of them together.
    channels: Vec<ComparedChannelDocument>,
    sensors: Vec<SensorDocument>,
    recommended: RecommendationDocument,
    /// Records that hold the same samples; these are not tested against each other.
    same_samples: Vec<SameSamplesDocument>,
    /// Means of the channels of sensors, and how far they lie apart.
    means: Vec<MeansDocument>,
    /// N, B and K over three recordings or more, copies counted once.
    populations: Vec<PopulationDocument>,
    disturbances: Vec<ComparedDisturbanceDocument>,
    /// What could not be compared, or only in part.
    caveats: Vec<CaveatDocument>,
}

#[derive(Debug, Serialize)]
struct PopulationDocument {
    channel: String,
    parameter: &'static str,
    unit: &'static str,
    median: f64,
    lowest: f64,
    highest: f64,
    /// Standard deviation of the logarithm between recordings.
    spread: Option<f64>,
    /// The prediction interval of the next sensor, or of the next recording if all are of one.
    next_lower: Option<f64>,
    next_upper: Option<f64>,
    no_interval: Option<&'static str>,
    sensors: Vec<UnitDocument>,
}

#[derive(Debug, Serialize)]
struct UnitDocument {
    name: String,
    records: Vec<usize>,
    /// Mean over its recordings.
    value: f64,
    bound: bool,
}

impl PopulationDocument {
    fn new(population: &Population) -> Self {
        let next = population.prediction.ok();
        let sensor = |unit: &UnitValue| UnitDocument {
            name: unit.name.clone(),
            records: unit.records.clone(),
            value: unit.value,
            bound: unit.is_bound,
        };
        Self {
            channel: population.channel.clone(),
            parameter: term_name(population.term),
            unit: si_unit(population.sensor, population.term),
            median: population.median,
            lowest: population.range[0],
            highest: population.range[1],
            spread: population.spread,
            next_lower: next.map(|next| next[0]),
            next_upper: next.map(|next| next[1]),
            no_interval: population.prediction.err().map(no_prediction),
            sensors: population.units.iter().map(sensor).collect(),
        }
    }
}

#[derive(Debug, Serialize)]
struct RecordDocument {
    name: String,
    kind: Option<&'static str>,
    error: Option<String>,
    message: Option<String>,
    compensated: Option<bool>,
    rate_hz: Option<f64>,
    duration_s: f64,
    samples: u64,
    /// Kinds of all warnings of its own analysis.
    warnings: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct ComparedChannelDocument {
    name: String,
    unit: String,
    octaves: Vec<OctaveDocument>,
}

#[derive(Debug, Serialize)]
struct OctaveDocument {
    tau_s: f64,
    records: [usize; 2],
    deviations: [f64; 2],
    edf: [f64; 2],
    #[serde(flatten)]
    verdict: Verdict,
}

#[derive(Debug, Serialize)]
struct Verdict {
    p: f64,
    corrected: f64,
    differs: bool,
}

#[derive(Debug, Serialize)]
struct SensorDocument {
    /// `gyro`, `accel` or `mag`.
    sensor: &'static str,
    unit: &'static str,
    /// The quietest first, by N over its factor.
    ranked: Vec<RankedDocument>,
    /// White noise folds alike in all of them; otherwise none is the quietest.
    folds_alike: bool,
    /// Of those where it folds alike, corrected for all pairs of all sensors.
    tests: Vec<TestDocument>,
    /// The quietest record, where it is significantly quieter than every other one.
    quietest: Option<usize>,
    /// Records where N is not estimated on every axis.
    not_ranked: Vec<usize>,
}

#[derive(Debug, Serialize)]
struct RankedDocument {
    record: usize,
    /// N: root of the mean square over the axes.
    white: f64,
    lower: f64,
    upper: f64,
    axes: Vec<AxisDocument>,
    /// What averaging and decimation on board make of white noise; `null` where unknown.
    white_factor: Option<f64>,
}

#[derive(Debug, Serialize)]
struct AxisDocument {
    name: String,
    white: f64,
}

#[derive(Debug, Serialize)]
struct TestDocument {
    records: [usize; 2],
    #[serde(flatten)]
    verdict: Verdict,
}

/// The record to use where one will do.
#[derive(Debug, Serialize)]
struct RecommendationDocument {
    record: Option<usize>,
    /// Why that one, or why none.
    why: &'static str,
    text: String,
}

#[derive(Debug, Serialize)]
struct SameSamplesDocument {
    records: [usize; 2],
    /// Part of the samples of the first that the second has too, 0 to 1.
    of_first: f64,
    of_second: f64,
}

#[derive(Debug, Serialize)]
struct MeansDocument {
    name: String,
    unit: String,
    means: Vec<MeanDocument>,
    /// Standard deviation of the means: turn-on to turn-on bias, if each record is a power cycle.
    spread: Option<SpreadDocument>,
    /// Of every two means.
    differences: Vec<DifferenceDocument>,
    /// The sensor takes the bias out of one record at least.
    bias_removed: bool,
}

#[derive(Debug, Serialize)]
struct MeanDocument {
    record: usize,
    mean: f64,
    /// Under N, B and K of the record: what repeating it at once would show.
    standard_error: Option<f64>,
    edf: Option<f64>,
    /// The length of the record.
    tau_s: Option<f64>,
}

#[derive(Debug, Serialize)]
struct SpreadDocument {
    deviation: f64,
    /// `null` for two means.
    lower: Option<f64>,
    upper: Option<f64>,
    dof: usize,
}

#[derive(Debug, Serialize)]
struct DifferenceDocument {
    records: [usize; 2],
    /// The second mean less the first.
    difference: f64,
    /// Under N, B and K of both records and the time between them.
    standard_error: Option<f64>,
    edf: Option<f64>,
    /// Probability that noise alone makes the means differ as much.
    p: Option<f64>,
    /// Holm's correction for all channels and pairs.
    corrected: Option<f64>,
    differs: Option<bool>,
    /// Why there is no p.
    untested: Option<&'static str>,
}

#[derive(Debug, Serialize)]
struct ComparedDisturbanceDocument {
    record: usize,
    kind: &'static str,
    channels: Vec<String>,
    text: String,
}

#[derive(Debug, Serialize)]
struct CaveatDocument {
    kind: &'static str,
    records: Vec<usize>,
    text: String,
}

impl ComparisonDocument {
    /// The document of a comparison of `all`, in the order in which they were compared; remedies
    /// are put into `words`.
    #[must_use]
    pub fn new(all: &[SourceResult], comparison: &Comparison, populations: &[Population], words: RemedyWords) -> Self {
        let verdict = |chance: Chance| Verdict {
            p: chance.p,
            corrected: chance.corrected,
            differs: comparison.is_significant(chance),
        };
        let octave = |test: &OctaveTest| OctaveDocument {
            tau_s: test.tau_s,
            records: test.records,
            deviations: test.deviations,
            edf: test.edf,
            verdict: verdict(test.chance),
        };
        let channels = tests_by_channel(&comparison.octaves).into_iter().filter_map(|tests| {
            let OctaveTest { channel, unit, .. } = tests.first()?;
            let octaves = tests.iter().map(|test| octave(test)).collect();
            Some(ComparedChannelDocument { name: channel.clone(), unit: unit.clone(), octaves })
        });
        let disturbances = comparison.disturbances.iter().map(|disturbance| ComparedDisturbanceDocument {
            record: disturbance.record,
            kind: disturbance.warning.kind.name(),
            channels: disturbance.warning.channels.clone(),
            text: in_words(&disturbance.warning, words),
        });
        let caveats = comparison.caveats.iter().map(|caveat| CaveatDocument {
            kind: caveat.kind.name(),
            records: caveat.records.clone(),
            text: caveat_in_words(caveat, words),
        });
        let same = comparison.same_samples.iter().map(|same| SameSamplesDocument {
            records: same.records,
            of_first: same.shared.of_first,
            of_second: same.shared.of_second,
        });
        Self {
            schema: "vn100.comparison/1",
            confidence: comparison.confidence,
            records: all.iter().map(record).collect(),
            channels: channels.collect(),
            sensors: comparison.rankings.iter().map(|ranking| sensor(ranking, comparison, verdict)).collect(),
            recommended: recommended(comparison),
            populations: populations.iter().map(PopulationDocument::new).collect(),
            same_samples: same.collect(),
            means: comparison.means.iter().map(|means| means_of(means, comparison)).collect(),
            disturbances: disturbances.collect(),
            caveats: caveats.collect(),
        }
    }
}

fn record(result: &SourceResult) -> RecordDocument {
    let SourceResult { source, timing, .. } = result;
    RecordDocument {
        name: source.name.clone(),
        kind: source.kind,
        error: source.error.clone(),
        message: source.message.clone(),
        compensated: source.compensated,
        rate_hz: timing.rate_hz,
        duration_s: timing.duration_s,
        samples: timing.samples,
        warnings: result.warnings.iter().map(|warning| warning.kind.name()).collect(),
    }
}

fn sensor(ranking: &Ranking, comparison: &Comparison, verdict: impl Fn(Chance) -> Verdict) -> SensorDocument {
    let ranked = ranking.records.iter().map(|ranked| RankedDocument {
        record: ranked.record,
        white: ranked.white,
        lower: ranked.lower,
        upper: ranked.upper,
        axes: ranked.axes.iter().map(|(name, white)| AxisDocument { name: name.clone(), white: *white }).collect(),
        white_factor: ranked.white_factor,
    });
    let leads = ranking.lead().is_some_and(|lead| comparison.is_significant(lead));
    SensorDocument {
        sensor: sensor_of(ranking.quantity).map_or("", axes_name),
        unit: ranking.unit,
        ranked: ranked.collect(),
        folds_alike: ranking.folds_alike,
        tests: (ranking.tests.iter())
            .map(|test| TestDocument { records: test.records, verdict: verdict(test.chance) })
            .collect(),
        quietest: ranking.records.first().filter(|_| leads).map(|first| first.record),
        not_ranked: ranking.not_ranked.clone(),
    }
}

fn recommended(comparison: &Comparison) -> RecommendationDocument {
    let (record, why) = match &comparison.recommended {
        Ok(recommended) => (Some(recommended.record), recommended.why.name()),
        Err(why) => (None, why.name()),
    };
    RecommendationDocument { record, why, text: recommendation(comparison, run_name) }
}

fn of_difference(difference: &MeanDifference, comparison: &Comparison) -> DifferenceDocument {
    let test = difference.test.ok();
    DifferenceDocument {
        records: difference.records,
        difference: difference.difference,
        standard_error: test.map(|test| test.standard_error),
        edf: test.map(|test| test.edf),
        p: test.map(|test| test.chance.p),
        corrected: test.map(|test| test.chance.corrected),
        differs: test.map(|test| comparison.is_significant(test.chance)),
        untested: difference.test.err().map(Untested::name),
    }
}

fn means_of(means: &ChannelMeans, comparison: &Comparison) -> MeansDocument {
    MeansDocument {
        name: means.channel.clone(),
        unit: means.unit.clone(),
        means: (means.means.iter())
            .map(|mean| MeanDocument {
                record: mean.record,
                mean: mean.mean,
                standard_error: mean.error.map(|error| error.standard_error),
                edf: mean.error.map(|error| error.edf),
                tau_s: mean.error.map(|error| error.tau_s),
            })
            .collect(),
        spread: means.spread.map(|spread| SpreadDocument {
            deviation: spread.deviation,
            lower: spread.interval.map(|interval| interval.lower),
            upper: spread.interval.map(|interval| interval.upper),
            dof: means.means.len() - 1,
        }),
        differences: means.differences.iter().map(|difference| of_difference(difference, comparison)).collect(),
        bias_removed: means.bias_removed,
    }
}
