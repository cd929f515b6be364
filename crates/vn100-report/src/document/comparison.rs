//! The JSON document of several captures side by side, schema `vn100.comparison/1`: a contract with
//! scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `record` is a place in
//! `records`, from 0. A probability `p` is that of one test alone, `corrected` the same with Holm's
//! correction; `differs` is `corrected` < 1 - `confidence`.

use serde::Serialize;
use serde_json::{Value, json};
use vn100_analysis::{ChannelMeans, Comparison, Ranking, RemedyWords};

use crate::{
    measured::Measured,
    units::{TestsOfChannel, sensor_group, tests_by_channel},
};

/// The JSON document of several records side by side.
#[derive(Debug, Serialize)]
pub struct ComparisonDocument(Value);

impl ComparisonDocument {
    /// The results in the order in which they were compared.
    #[must_use]
    pub fn new(all: &[Measured], comparison: &Comparison, words: RemedyWords) -> Self {
        Self(json!({
            "schema": "vn100.comparison/1",
            // two-sided level of every interval
            "confidence": comparison.confidence,
            // in the order given, those that could not be read too
            "records": all.iter().map(record).collect::<Value>(),
            // F-tests of the octaves that two records share; corrected for all of them together
            "channels": tests_by_channel(&comparison.octaves).iter().map(|tests| channel(tests, comparison)).collect::<Value>(),
            // white noise by sensor
            "sensors": comparison.rankings.iter().map(|ranking| sensor(ranking, comparison)).collect::<Value>(),
            // means of the channels of sensors, and how far they lie apart
            "means": comparison.means.iter().map(|channel| means(channel, comparison)).collect::<Value>(),
            "disturbances": comparison.disturbances.iter().map(|disturbance| json!({
                "record": disturbance.record,
                "kind": disturbance.warning.kind.name(),
                "channels": disturbance.warning.channels,
                "text": disturbance.warning.text.in_words(words),
            })).collect::<Value>(),
            // what could not be compared, or only in part
            "caveats": comparison.caveats.iter().map(|caveat| json!({
                "kind": caveat.kind.name(),
                "records": caveat.records,
                "text": caveat.text.in_words(words),
            })).collect::<Value>(),
        }))
    }
}

fn record(measured: &Measured) -> Value {
    let Measured { facts, snapshot, assessment, .. } = measured;
    let layout = snapshot.layout.as_ref();
    let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
    json!({
        "name": facts.name,
        "kind": facts.kind,
        "error": facts.error,
        "message": layout.map(|layout| layout.message.to_string()),
        "compensated": layout.map(|layout| layout.compensated),
        "rate_hz": snapshot.timing.rate_hz,
        "duration_s": snapshot.timing.duration_s(),
        "samples": snapshot.timing.samples,
        // of its own analysis
        "warnings": warnings.map(|warning| warning.kind.name()).collect::<Value>(),
    })
}

fn channel(channel: &TestsOfChannel<'_>, comparison: &Comparison) -> Value {
    json!({
        "name": channel.name,
        "unit": channel.unit,
        "octaves": channel.tests.iter().map(|test| json!({
            "tau_s": test.tau_s,
            "records": test.records,
            "deviations": test.deviations,
            "edf": test.edf,
            "p": test.chance.p,
            "corrected": test.chance.corrected,
            "differs": comparison.is_significant(test.chance),
        })).collect::<Value>(),
    })
}

fn sensor(ranking: &Ranking, comparison: &Comparison) -> Value {
    let leads = ranking.lead().is_some_and(|lead| comparison.is_significant(lead));
    json!({
        // `gyro`, `accel` or `mag`
        "sensor": sensor_group(ranking.quantity),
        // of the white noise
        "unit": ranking.unit,
        // the quietest first, by N over its factor
        "ranked": ranking.records.iter().map(|ranked| json!({
            "record": ranked.record,
            // N: root of the mean square over the axes
            "white": ranked.white,
            "lower": ranked.lower,
            "upper": ranked.upper,
            "axes": ranked.axes.iter().map(|(name, white)| json!({ "name": name, "white": white })).collect::<Value>(),
            // what averaging and decimation on board make of the white noise; `null` where not known
            "white_factor": ranked.white_factor,
        })).collect::<Value>(),
        // white noise folds alike in all of them; otherwise none is the quietest
        "folds_alike": ranking.folds_alike,
        // of those where it folds alike, corrected for all pairs of all sensors
        "tests": ranking.tests.iter().map(|test| json!({
            "records": test.records,
            "p": test.chance.p,
            "corrected": test.chance.corrected,
            "differs": comparison.is_significant(test.chance),
        })).collect::<Value>(),
        // where it is quieter than every other one beyond chance
        "quietest": ranking.records.first().filter(|_| leads).map(|first| first.record),
        // records where N is not estimated on every axis
        "not_ranked": ranking.not_ranked,
    })
}

fn means(means: &ChannelMeans, comparison: &Comparison) -> Value {
    json!({
        "name": means.channel,
        "unit": means.unit,
        "means": means.means.iter().map(|mean| json!({
            "record": mean.record,
            "mean": mean.mean,
            // the deviation at `tau_s`, the longest known
            "standard_error": mean.error.map(|error| error.standard_error),
            "edf": mean.error.map(|error| error.edf),
            "tau_s": mean.error.map(|error| error.tau_s),
        })).collect::<Value>(),
        // standard deviation of the means: turn-on to turn-on bias, if each record is a power cycle of one sensor at
        // one attitude; its probability with Holm's correction for all channels with a spread
        "spread": means.spread.zip(means.chance).map(|(spread, chance)| json!({
            "deviation": spread.deviation,
            "lower": spread.interval.lower,
            "upper": spread.interval.upper,
            "dof": spread.interval.edf,
            // what noise within the records alone would spread them by
            "from_noise": spread.from_noise,
            "p": chance.p,
            "corrected": chance.corrected,
            "beyond_noise": comparison.is_significant(chance),
        })),
        // the sensor takes the bias out of one record at least
        "bias_removed": means.bias_removed,
    })
}
