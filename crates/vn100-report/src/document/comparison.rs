//! The JSON document of several captures side by side, schema `vn100.comparison/1`: a contract with
//! scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `record` is a place in
//! `records`, from 0. A probability `p` is that of one test alone, `corrected` is `p` with Holm's
//! correction; `differs` is `corrected` < 1 - `confidence`.

use serde_json::{Value, json};
use vn100_analysis::{
    Chance, ChannelMeans, Comparison, MeanDifference, OctaveTest, Population, RankedRecord, Ranking, RemedyWords,
    SourceResult, Untested, axes_name, sensor_of,
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

/// The JSON document of a comparison of `all`, in the order in which they were compared, those that
/// could not be read too; remedies are put into `words`.
#[must_use]
pub fn comparison_document(
    all: &[SourceResult],
    comparison: &Comparison,
    populations: &[Population],
    words: RemedyWords,
) -> Value {
    let channels = tests_by_channel(&comparison.octaves).into_iter().filter_map(|tests| {
        let OctaveTest { channel, unit, .. } = tests.first()?;
        let octaves: Vec<Value> = tests.iter().map(|test| octave(test, comparison)).collect();
        Some(json!({ "name": channel, "unit": unit, "octaves": octaves }))
    });
    let disturbances = comparison.disturbances.iter().map(|disturbance| {
        let warning = &disturbance.warning;
        let text = in_words(warning, words);
        json!({ "record": disturbance.record, "kind": warning.kind.name(), "channels": warning.channels, "text": text })
    });
    let caveats = comparison.caveats.iter().map(|caveat| {
        json!({ "kind": caveat.kind.name(), "records": caveat.records, "text": caveat_in_words(caveat, words) })
    });
    let same_samples = comparison.same_samples.iter().map(
        |same| json!({ "records": same.records, "of_first": same.shared.of_first, "of_second": same.shared.of_second }),
    );
    json!({
        "schema": "vn100.comparison/1",
        "confidence": comparison.confidence,
        "records": all.iter().map(record).collect::<Vec<_>>(),
        "channels": channels.collect::<Vec<_>>(),
        "sensors": comparison.rankings.iter().map(|ranking| sensor(ranking, comparison)).collect::<Vec<_>>(),
        "recommended": recommended(comparison),
        "same_samples": same_samples.collect::<Vec<_>>(),
        "means": comparison.means.iter().map(|means| means_of(means, comparison)).collect::<Vec<_>>(),
        "populations": populations.iter().map(population).collect::<Vec<_>>(),
        "disturbances": disturbances.collect::<Vec<_>>(),
        "caveats": caveats.collect::<Vec<_>>(),
    })
}

fn record(result: &SourceResult) -> Value {
    let SourceResult { source, timing, warnings, .. } = result;
    json!({
        "name": source.name,
        "kind": source.kind,
        "error": source.error,
        "message": source.message,
        "compensated": source.compensated,
        "rate_hz": timing.rate_hz,
        "duration_s": timing.duration_s,
        "samples": timing.samples,
        "warnings": warnings.iter().map(|warning| warning.kind.name()).collect::<Vec<_>>(),
    })
}

fn octave(test: &OctaveTest, comparison: &Comparison) -> Value {
    let Chance { p, corrected } = test.chance;
    json!({
        "tau_s": test.tau_s,
        "records": test.records,
        "deviations": test.deviations,
        "edf": test.edf,
        "p": p,
        "corrected": corrected,
        "differs": comparison.is_significant(test.chance),
    })
}

/// The records of a sensor, the quietest first by N over its factor; the quietest is named if it is
/// significantly quieter than every other one.
fn sensor(ranking: &Ranking, comparison: &Comparison) -> Value {
    let ranked = ranking.records.iter().map(|RankedRecord { record, white, lower, upper, axes, white_factor }| {
        let axes: Vec<Value> = axes.iter().map(|(name, white)| json!({ "name": name, "white": white })).collect();
        json!({
            "record": record,
            "white": white,
            "lower": lower,
            "upper": upper,
            "axes": axes,
            "white_factor": white_factor,
        })
    });
    let tests = ranking.tests.iter().map(|test| {
        let Chance { p, corrected } = test.chance;
        let differs = comparison.is_significant(test.chance);
        json!({ "records": test.records, "p": p, "corrected": corrected, "differs": differs })
    });
    let leads = ranking.lead().is_some_and(|lead| comparison.is_significant(lead));
    json!({
        "sensor": sensor_of(ranking.quantity).map_or("", axes_name),
        "unit": ranking.unit,
        "ranked": ranked.collect::<Vec<_>>(),
        "folds_alike": ranking.folds_alike,
        "tests": tests.collect::<Vec<_>>(),
        "quietest": ranking.records.first().filter(|_| leads).map(|first| first.record),
        "not_ranked": ranking.not_ranked,
    })
}

fn recommended(comparison: &Comparison) -> Value {
    let (record, why) = match &comparison.recommended {
        Ok(recommended) => (Some(recommended.record), recommended.why.name()),
        Err(why) => (None, why.name()),
    };
    json!({ "record": record, "why": why, "text": recommendation(comparison, run_name) })
}

fn means_of(means: &ChannelMeans, comparison: &Comparison) -> Value {
    let each = means.means.iter().map(|mean| {
        let error = mean.error;
        json!({
            "record": mean.record,
            "mean": mean.mean,
            "standard_error": error.map(|error| error.standard_error),
            "edf": error.map(|error| error.edf),
            "tau_s": error.map(|error| error.tau_s),
        })
    });
    let spread = means.spread.map(|spread| {
        json!({
            "deviation": spread.deviation,
            "lower": spread.interval.map(|interval| interval.lower),
            "upper": spread.interval.map(|interval| interval.upper),
            "dof": means.means.len() - 1,
        })
    });
    let differences = means.differences.iter().map(|difference| of_difference(difference, comparison));
    json!({
        "name": means.channel,
        "unit": means.unit,
        "means": each.collect::<Vec<_>>(),
        "spread": spread,
        "differences": differences.collect::<Vec<_>>(),
        "bias_removed": means.bias_removed,
    })
}

fn of_difference(difference: &MeanDifference, comparison: &Comparison) -> Value {
    let test = difference.test.ok();
    json!({
        "records": difference.records,
        "difference": difference.difference,
        "standard_error": test.map(|test| test.standard_error),
        "edf": test.map(|test| test.edf),
        "p": test.map(|test| test.chance.p),
        "corrected": test.map(|test| test.chance.corrected),
        "differs": test.map(|test| comparison.is_significant(test.chance)),
        "untested": difference.test.err().map(Untested::name),
    })
}

/// N, B or K over three recordings or more, copies counted once.
fn population(population: &Population) -> Value {
    let next = population.prediction.ok();
    let sensors = population
        .units
        .iter()
        .map(|unit| json!({ "name": unit.name, "records": unit.records, "value": unit.value, "bound": unit.is_bound }));
    json!({
        "channel": population.channel,
        "parameter": term_name(population.term),
        "unit": si_unit(population.sensor, population.term),
        "median": population.median,
        "lowest": population.range[0],
        "highest": population.range[1],
        "spread": population.spread,
        "next_lower": next.map(|next| next[0]),
        "next_upper": next.map(|next| next[1]),
        "no_interval": population.prediction.err().map(no_prediction),
        "sensors": sensors.collect::<Vec<_>>(),
    })
}
