//! The JSON document of one capture, schema `vn100.analysis/1`: a contract with scripts.

pub(crate) mod comparison;
pub(crate) mod noise;
pub(crate) mod plan;
pub(crate) mod recording;
mod signal;
mod source;
mod verdict;

use std::collections::BTreeMap;

use imu_noise::{Deviation, Estimator};
use serde::Serialize;
use serde_json::{Value, json};
use vn100_analysis::{Assessment, MissingFrom, RateFrom, RemedyWords, Snapshot, SourceFacts};

use crate::{
    measured::Measured,
    units::{ChannelValues, channel_values, norm_values},
};

/// The JSON document of one source.
#[derive(Debug, Serialize)]
pub struct Document(Value);

impl Document {
    /// The document of a measurement under way, or of one that has `ended`; what the user can do is
    /// in these `words`.
    #[must_use]
    pub fn new(
        facts: &SourceFacts,
        snapshot: &Snapshot,
        assessment: &Assessment,
        ended: bool,
        words: RemedyWords,
    ) -> Self {
        let channel = |values: &ChannelValues| channel(values, snapshot, assessment, ended);
        let warnings = snapshot.warnings.iter().chain(&assessment.warnings);
        Self(json!({
            "schema": "vn100.analysis/1",
            "source": source::source(facts, snapshot),
            "timing": timing(snapshot),
            "link": link(snapshot),
            "channels": channel_values(snapshot, assessment).iter().map(channel).collect::<Value>(),
            // the length of each sensor's vector, sample by sample; `of_mean` is that of the mean vector
            "norms": norm_values(snapshot),
            "warnings": warnings.map(|warning| json!({
                "kind": warning.kind.name(),
                "channels": warning.channels,
                "text": warning.text.in_words(words),
            })).collect::<Value>(),
        }))
    }

    /// The document of a result, with all that was made of it.
    #[must_use]
    pub fn of(measured: &Measured, words: RemedyWords) -> Self {
        let Measured { facts, snapshot, assessment, filter_models, verdicts, .. } = measured;
        let mut document = Self::new(facts, snapshot, assessment, true, words);
        for (place, noise) in assessment.channels.iter().map(|channel| channel.noise.as_ref()).enumerate() {
            let (Some(noise), Some(channel)) = (noise, document.0["channels"].get_mut(place)) else { continue };
            if let Some(Some(models)) = filter_models.get(place) {
                channel["noise"]["filter_models"] = noise::filter_models(models);
            }
            channel["grade"] = json!(verdict::grade_of(noise));
            let figures = verdicts.as_ref().and_then(|verdicts| Some((verdicts, verdicts.channels.get(place)?)));
            if let Some((verdicts, figures)) = figures.filter(|(_, figures)| !figures.is_empty()) {
                let of = |figure| verdict::verdict(&verdicts.datasheet, noise.sensor, figure);
                channel["verdict"] = figures.iter().map(of).collect();
            }
        }
        document
    }
}

fn timing(snapshot: &Snapshot) -> Value {
    let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
    json!({
        "rate_hz": timing.rate_hz,
        "rate_from": match timing.rate_from {
            RateFrom::Option => "option",
            RateFrom::Device => "device",
            RateFrom::Arrival => "arrival",
            RateFrom::Assumed => "assumed",
        },
        "measured_hz": arrivals.and_then(|arrivals| arrivals.measured_hz),
        "offset_ppm": arrivals.and_then(|arrivals| arrivals.offset_ppm),
        "duration_s": timing.duration_s(),
        "samples": timing.samples,
        "left_out": timing.excluded,
        "segments": timing.segments,
        "gaps": timing.gaps,
        "missing": timing.missing,
        "missing_from": match timing.missing_from {
            MissingFrom::Counter => "counter",
            MissingFrom::Arrival => "arrival",
            MissingFrom::RejectedRows => "bad-lines",
        },
        "interarrival_us": arrivals.and_then(|arrivals| arrivals.arrivals).map(|times| json!({
            "p50": times.p50_us,
            "p99": times.p99_us,
            "max": times.max_us,
        })),
    })
}

fn link(snapshot: &Snapshot) -> Value {
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let errors = link.unsolicited_errors.iter();
    json!({
        "bytes": link.bytes(),
        "frames": tally.valid_sentences(),
        "replies": link.answers(),
        // questions that the line brought back
        "echoes": link.echoes,
        "other_messages": link.other_messages(),
        "binary_packets": tally.packets,
        "skipped_bytes": link.skipped_bytes(),
        "overrun_bytes": link.overrun_bytes,
        // how often each code was reported
        "unasked_errors": errors.map(|(error, count)| (format!("{:02X}", error.code()), count)).collect::<BTreeMap<_, _>>(),
        // how often its output was found paused, and was resumed
        "outputs_resumed": link.outputs_resumed,
        "reconnects": link.connects.saturating_sub(1),
        // time in which the link was lost
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

/// Spectrum, blocks and histogram only at the end; verdicts and grade are those of a result.
fn channel(values: &ChannelValues, snapshot: &Snapshot, assessment: &Assessment, ended: bool) -> Value {
    let (signal, skipped_s) = (values.signal.as_ref(), snapshot.skipped.as_secs_f64());
    let at_end = signal.filter(|_| ended);
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
            // an angle's are of the unwrapped angle, in the branch of its mean
            "histogram": values.bars.as_ref().filter(|_| ended),
        },
        "allan": {
            "deviation": match snapshot.deviation {
                Deviation::Allan => "allan",
                Deviation::Hadamard => "hadamard",
            },
            "estimator": match snapshot.estimator {
                Estimator::Strided => "strided",
                Estimator::Full => "full",
                Estimator::Plain => "plain",
            },
            "confidence": assessment.confidence,
            // what was removed before
            "detrend": snapshot.detrended.then_some("linear"),
            // of the regression line over the record, in the unit per second
            "slope_s": values.slope_s,
            "points": values.deviations,
        },
        "noise": values.noise.as_ref().map(|noise| noise::noise(noise, assessment.samples)),
        "stationarity": signal.map(|signal| signal::stationarity(signal, skipped_s)),
        "spectrum": at_end.map(signal::spectrum),
        "blocks": at_end.map(|signal| signal::blocks(signal, skipped_s)),
        "verdict": null,
        "grade": null,
    })
}
