//! The JSON document of one capture, schema `vn100.analysis/1`: a contract with scripts.
//!
//! Here and below a document is written as it is read: one literal with its keys in their order.
//! What is not known is `null`.

pub(crate) mod comparison;
pub(crate) mod noise;
pub(crate) mod plan;
mod signal;
pub(crate) mod source;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Value, json};
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::{Assessment, MissingFrom, RateFrom, RemedyWords, Snapshot, SourceFacts};

use crate::{
    measured::Measured,
    units::{ChannelValues, channel_values, norm_values},
};

/// The JSON document of one source.
#[derive(Debug, Serialize)]
pub struct Document(Value);

impl Document {
    /// Of a measurement under way; remedies are in these `words`.
    #[must_use]
    pub fn so_far(facts: &SourceFacts, snapshot: &Snapshot, assessment: &Assessment, words: RemedyWords) -> Self {
        Self(document(facts, snapshot, assessment, None, words))
    }

    /// Of a result, with all that was made of it.
    #[must_use]
    pub fn of(measured: &Measured, words: RemedyWords) -> Self {
        Self(document(&measured.facts, &measured.snapshot, &measured.assessment, Some(measured), words))
    }
}

fn document(
    facts: &SourceFacts,
    snapshot: &Snapshot,
    assessment: &Assessment,
    end: Option<&Measured>,
    words: RemedyWords,
) -> Value {
    let channels = channel_values(snapshot, assessment).into_iter().enumerate();
    let channels: Vec<Value> =
        channels.map(|(place, values)| channel(place, values, snapshot, assessment, end)).collect();
    let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
    let warnings: Vec<Value> = warnings
        .map(|w| json!({ "kind": w.kind.name(), "channels": w.channels, "text": w.text.in_words(words) }))
        .collect();
    json!({
        "schema": "vn100.analysis/1",
        "source": source::source(facts, snapshot),
        "timing": timing(snapshot),
        "link": link(snapshot),
        "channels": channels,
        "norms": norm_values(snapshot),
        "warnings": warnings,
    })
}

fn timing(snapshot: &Snapshot) -> Value {
    let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
    let rate_from = match timing.rate_from {
        RateFrom::Option => "option",
        RateFrom::Device => "device",
        RateFrom::Arrival => "arrival",
        RateFrom::Assumed => "assumed",
    };
    let missing_from = match timing.missing_from {
        MissingFrom::Counter => "counter",
        MissingFrom::Arrival => "arrival",
        MissingFrom::RejectedRows => "bad-lines",
    };
    let interarrival_us = arrivals
        .and_then(|arrivals| arrivals.arrivals)
        .map(|times| json!({ "p50": times.p50_us, "p99": times.p99_us, "max": times.max_us }));
    json!({
        "rate_hz": timing.rate_hz,
        "rate_from": rate_from,
        "measured_hz": arrivals.and_then(|arrivals| arrivals.measured_hz),
        "offset_ppm": arrivals.and_then(|arrivals| arrivals.offset_ppm),
        "duration_s": timing.duration_s(),
        "samples": timing.samples,
        "left_out": timing.excluded,
        "segments": timing.segments,
        "gaps": timing.gaps,
        "missing": timing.missing,
        "missing_from": missing_from,
        "interarrival_us": interarrival_us,
    })
}

fn link(snapshot: &Snapshot) -> Value {
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let errors = link.unsolicited_errors.iter().map(|(error, count)| (format!("{:02X}", error.code()), count));
    json!({
        "bytes": link.bytes(),
        "frames": tally.valid_sentences(),
        "replies": link.answers(),
        "echoes": link.echoes,
        "other_messages": link.other_messages(),
        "binary_packets": tally.packets,
        "skipped_bytes": link.skipped_bytes(),
        "overrun_bytes": link.overrun_bytes,
        // unsolicited device errors: how often each code was reported
        "unasked_errors": errors.collect::<BTreeMap<_, _>>(),
        // how often its output was found paused, and was resumed
        "outputs_resumed": link.outputs_resumed,
        "reconnects": link.connects.saturating_sub(1),
        "down_s": if snapshot.outages.times == 0 { Some(0.0) } else { snapshot.outages.seconds() },
        "bad_frames": {
            "checksum": tally.rejected.checksum,
            "unchecked": tally.rejected.unchecked,
            "grammar": tally.rejected.grammar,
            "range": tally.rejected.range,
            "truncated": tally.rejected.truncated,
            "too_long": tally.rejected.too_long,
        },
    })
}

fn channel(
    place: usize,
    values: ChannelValues,
    snapshot: &Snapshot,
    assessment: &Assessment,
    end: Option<&Measured>,
) -> Value {
    let (noise, signal) = (values.noise.as_ref(), values.signal.as_ref());
    let at_end = signal.filter(|_| end.is_some());
    let skipped_s = snapshot.skipped.as_secs_f64();
    let models = end.and_then(|end| end.filter_models.get(place)?.as_ref());
    let sheet = end.and_then(|end| end.verdicts.as_ref());
    let deviation = match snapshot.deviation {
        Deviation::Allan => "allan",
        Deviation::Hadamard => "hadamard",
    };
    let estimator = match snapshot.estimator {
        Estimator::Strided => "strided",
        Estimator::Full => "full",
        Estimator::Plain => "plain",
    };
    json!({
        "name": values.name,
        "unit": values.unit,
        "statistics": {
            "count": values.count,
            "mean": values.mean,
            "std": values.std,
            "skewness": values.skewness,
            "excess_kurtosis": values.excess_kurtosis,
            "min": values.min,
            "max": values.max,
            "resolution": values.resolution,
            "normality": signal.and_then(|signal| signal.normality).map(signal::normality),
            // in the unit of the channel, an angle's in the branch of its mean; only at the end
            "histogram": values.bars.filter(|_| end.is_some()),
        },
        "allan": {
            "deviation": deviation,
            "estimator": estimator,
            "confidence": assessment.confidence,
            // what was removed before
            "detrend": snapshot.detrended.then_some("linear"),
            // of the regression line over the record, in the unit per second
            "slope_s": values.slope_s,
            "points": values.deviations,
        },
        "noise": noise.map(|noise| noise::noise(noise, assessment.samples, models)),
        "stationarity": signal.map(|signal| signal::stationarity(signal, skipped_s)),
        // these two only at the end
        "spectrum": at_end.map(signal::spectrum),
        "blocks": at_end.map(|signal| signal::blocks(signal, skipped_s)),
        // against each figure of the data sheet; only at the end
        "verdict": noise.zip(sheet).and_then(|(noise, sheet)| noise::verdicts(noise.sensor, sheet, place)),
        // of a gyroscope; only at the end
        "grade": noise.filter(|_| end.is_some()).and_then(noise::graded),
    })
}
