//! The JSON document of several captures side by side, schema `vn100.comparison/1`: a contract with
//! scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `record` is a place in
//! `records`, from 0. A probability `p` is that of one test alone, `corrected` the same with Holm's
//! correction; `differs` is `corrected` < 1 - `confidence`.

use serde::Serialize;
use serde_json::{Value, json};
use vn100_analysis::{ChannelMeans, Comparison, OctaveTest, Ranking, RemedyWords, axes_name, sensor_of};

use crate::{measured::Measured, units::tests_by_channel};

/// The JSON document of several records side by side.
#[derive(Debug, Serialize)]
pub struct ComparisonDocument(Value);

impl ComparisonDocument {
    /// The results in the order in which they were compared, those that could not be read too.
    #[must_use]
    pub fn new(all: &[Measured], comparison: &Comparison, words: RemedyWords) -> Self {
        let channels = tests_by_channel(&comparison.octaves);
        let disturbances = comparison.disturbances.iter().map(|disturbance| {
            json!({
                "record": disturbance.record,
                "kind": disturbance.warning.kind.name(),
                "channels": disturbance.warning.channels,
                "text": disturbance.warning.text.in_words(words),
            })
        });
        let caveats = comparison.caveats.iter().map(|caveat| {
            json!({ "kind": caveat.kind.name(), "records": caveat.records, "text": caveat.text.in_words(words) })
        });
        Self(json!({
            "schema": "vn100.comparison/1",
            "confidence": comparison.confidence,
            "records": all.iter().map(record).collect::<Vec<_>>(),
            // F-tests of the octaves that two records share; corrected for all of them together
            "channels": channels.iter().filter_map(|tests| channel(tests, comparison)).collect::<Vec<_>>(),
            "sensors": comparison.rankings.iter().map(|ranking| sensor(ranking, comparison)).collect::<Vec<_>>(),
            // means of the channels of sensors, and how far they lie apart
            "means": comparison.means.iter().map(|means| means_of(means, comparison)).collect::<Vec<_>>(),
            "disturbances": disturbances.collect::<Vec<_>>(),
            // what could not be compared, or only in part
            "caveats": caveats.collect::<Vec<_>>(),
        }))
    }
}

fn record(measured: &Measured) -> Value {
    let Measured { facts, snapshot, assessment, .. } = measured;
    let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
    json!({
        "name": facts.name,
        "kind": facts.kind,
        "error": facts.error,
        "message": snapshot.layout.as_ref().map(|layout| layout.message.to_string()),
        "compensated": snapshot.layout.as_ref().map(|layout| layout.compensated),
        "rate_hz": snapshot.timing.rate_hz,
        "duration_s": snapshot.timing.duration_s(),
        "samples": snapshot.timing.samples,
        // kinds of all warnings of its own analysis
        "warnings": warnings.map(|warning| warning.kind.name()).collect::<Vec<_>>(),
    })
}

fn channel(tests: &[&OctaveTest], comparison: &Comparison) -> Option<Value> {
    let OctaveTest { channel, unit, .. } = tests.first()?;
    let octaves = tests.iter().map(|test| {
        json!({
            "tau_s": test.tau_s,
            "records": test.records,
            "deviations": test.deviations,
            "edf": test.edf,
            "p": test.chance.p,
            "corrected": test.chance.corrected,
            "differs": comparison.is_significant(test.chance),
        })
    });
    Some(json!({ "name": channel, "unit": unit, "octaves": octaves.collect::<Vec<_>>() }))
}

fn sensor(ranking: &Ranking, comparison: &Comparison) -> Value {
    let ranked = ranking.records.iter().map(|ranked| {
        let axes = ranked.axes.iter().map(|(name, white)| json!({ "name": name, "white": white }));
        json!({
            "record": ranked.record,
            // N: root of the mean square over the axes
            "white": ranked.white,
            "lower": ranked.lower,
            "upper": ranked.upper,
            "axes": axes.collect::<Vec<_>>(),
            // what averaging and decimation on board make of white noise
            "white_factor": ranked.white_factor,
        })
    });
    let tests = ranking.tests.iter().map(|test| {
        json!({
            "records": test.records,
            "p": test.chance.p,
            "corrected": test.chance.corrected,
            "differs": comparison.is_significant(test.chance),
        })
    });
    let leads = ranking.lead().is_some_and(|lead| comparison.is_significant(lead));
    json!({
        // gyro, accel or mag
        "sensor": sensor_of(ranking.quantity).map_or("", axes_name),
        "unit": ranking.unit,
        // the quietest first, by N over its factor
        "ranked": ranked.collect::<Vec<_>>(),
        // white noise folds alike in all of them; otherwise none is the quietest
        "folds_alike": ranking.folds_alike,
        // of those where it folds alike, corrected for all pairs of all sensors
        "tests": tests.collect::<Vec<_>>(),
        // the quietest record, where it is significantly quieter than every other one
        "quietest": ranking.records.first().filter(|_| leads).map(|first| first.record),
        // records where N is not estimated on every axis
        "not_ranked": ranking.not_ranked,
    })
}

fn means_of(means: &ChannelMeans, comparison: &Comparison) -> Value {
    let of_records = means.means.iter().map(|mean| {
        json!({
            "record": mean.record,
            "mean": mean.mean,
            // the deviation at `tau_s`, the longest known
            "standard_error": mean.error.map(|error| error.standard_error),
            "edf": mean.error.map(|error| error.edf),
            "tau_s": mean.error.map(|error| error.tau_s),
        })
    });
    let spread = means.spread.zip(means.chance).map(|(spread, chance)| {
        json!({
            "deviation": spread.deviation,
            "lower": spread.interval.lower,
            "upper": spread.interval.upper,
            "dof": spread.interval.edf,
            // what noise within the records alone would spread them by
            "from_noise": spread.from_noise,
            "p": chance.p,
            // for all channels with a spread
            "corrected": chance.corrected,
            "beyond_noise": comparison.is_significant(chance),
        })
    });
    json!({
        "name": means.channel,
        "unit": means.unit,
        "means": of_records.collect::<Vec<_>>(),
        // standard deviation of the means: turn-on to turn-on bias, if each record is a power cycle
        "spread": spread,
        // the sensor takes the bias out of one record at least
        "bias_removed": means.bias_removed,
    })
}
