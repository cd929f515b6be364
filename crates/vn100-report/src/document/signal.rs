//! How a channel went through time and frequency, as it stands in the JSON document. Its times are
//! of the record, in seconds of data since the first sample, those skipped included: `skipped_s`
//! lie before the first sample that counts.

use serde_json::{Value, json};
use vn100_analysis::noise::{LevelChange, LevelShape, Normality, NotJudged};

use crate::units::{BlockValues, SignalValues};

pub(super) fn normality(normality: Result<Normality, NotJudged>) -> Value {
    let judged = normality.ok();
    json!({
        // 99 of 100 normal records are said to be; `null` where it cannot be judged
        "consistent": judged.map(|normality| normality.is_consistent()),
        "reason": normality.err().map(|reason| reason.to_string()),
        // if the values were normal
        "skewness_error": judged.map(|normality| normality.skewness_error),
        "excess_kurtosis_error": judged.map(|normality| normality.excess_kurtosis_error),
        // independent samples that say as much of the skewness
        "effective_samples": judged.map(|normality| normality.effective_samples),
    })
}

/// The power spectral density by Welch's method, and its peaks.
pub(super) fn spectrum(signal: &SignalValues) -> Value {
    let density = signal.density.as_ref();
    let points = density.map_or(&[][..], |density| &density.points);
    let lines = signal.disturbed.lines.iter().map(|line| {
        json!({
            "frequency_hz": line.frequency_hz,
            "amplitude": line.amplitude,
            "share_of_variance": line.share_of_variance,
        })
    });
    json!({
        "sides": "one",
        "segment_samples": density.map(|density| density.segment_samples),
        "segments": density.map(|density| density.segments),
        // of the first point, and from point to point
        "step_hz": points.first().map(|point| point.frequency_hz),
        "density": points.iter().map(|point| point.density_unit2_hz).collect::<Vec<_>>(),
        "lines": lines.collect::<Vec<_>>(),
    })
}

/// The blocks of a record, with times of the record.
pub(super) fn blocks(signal: &SignalValues, skipped_s: f64) -> Vec<BlockValues> {
    signal.blocks.iter().map(|block| BlockValues { start_s: skipped_s + block.start_s, ..*block }).collect()
}

/// What happened in the middle of the record.
pub(super) fn stationarity(signal: &SignalValues, skipped_s: f64) -> Value {
    let disturbances = signal.disturbed.disturbances.iter().map(|found| {
        json!({
            "start_s": skipped_s + found.start_s,
            "end_s": skipped_s + found.end_s,
            "sigmas": found.sigmas,
        })
    });
    json!({
        "disturbances": disturbances.collect::<Vec<_>>(),
        "level_change": signal.disturbed.level_change.map(|change| level_change(change, skipped_s)),
    })
}

fn level_change(change: LevelChange, skipped_s: f64) -> Value {
    let (shape, amplitude, start_s, time_constant_s, skip_s) = match change.shape {
        LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => {
            ("warm-up", amplitude, None, Some(time_constant_s), skip_s)
        }
        LevelShape::Step { start_s, amplitude } => ("step", amplitude, Some(start_s), None, None),
    };
    let of_record = |time_s: Option<f64>| time_s.map(|time_s| skipped_s + time_s);
    json!({
        "shape": shape,
        "amplitude": amplitude,
        // of a step
        "start_s": of_record(start_s),
        // of a warm-up, and the skip that excludes it
        "time_constant_s": time_constant_s,
        "skip_s": of_record(skip_s),
        "sigmas": change.sigmas,
    })
}
