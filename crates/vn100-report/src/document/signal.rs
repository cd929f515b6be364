//! How a channel went through time and frequency, as it stands in the JSON document. Its times are
//! of the record, in seconds of data since the first sample, those skipped included: `skipped_s`
//! lie before the first sample that counts.

use imu_noise::{LevelChange, LevelShape, Normality, NotJudged};
use serde_json::{Value, json};

use crate::units::{BlockValues, SignalValues};

/// Whether the values are normally distributed.
pub(crate) fn normality(normality: Result<Normality, NotJudged>) -> Value {
    let judged = normality.ok();
    json!({
        // 99 of 100 normal records are said to be; `null` where it cannot be judged
        "consistent": judged.map(|normality| normality.is_consistent()),
        // why it cannot be judged
        "reason": normality.err().map(|reason| reason.to_string()),
        // if the values were normal
        "skewness_error": judged.map(|normality| normality.skewness_error),
        "excess_kurtosis_error": judged.map(|normality| normality.excess_kurtosis_error),
        // independent samples that say as much of the skewness
        "effective_samples": judged.map(|normality| normality.effective_samples),
    })
}

/// The power spectral density by Welch's method, and the lines that stand out of it.
pub(crate) fn spectrum(signal: &SignalValues) -> Value {
    let density = signal.density.as_ref();
    let points = density.map_or(&[][..], |density| &density.points);
    json!({
        "sides": "one",
        "segment_samples": density.map(|density| density.segment_samples),
        "segments": density.map(|density| density.segments),
        // of the first point, and from point to point
        "step_hz": points.first().map(|point| point.frequency_hz),
        "density": points.iter().map(|point| point.density_unit2_hz).collect::<Value>(),
        "lines": signal.disturbed.lines.iter().map(|line| json!({
            "frequency_hz": line.frequency_hz,
            "amplitude": line.amplitude,
            "share_of_variance": line.share_of_variance,
        })).collect::<Value>(),
    })
}

/// The deviation per segment of the record.
pub(crate) fn blocks(signal: &SignalValues, skipped_s: f64) -> Vec<BlockValues> {
    signal.blocks.iter().map(|block| BlockValues { start_s: skipped_s + block.start_s, ..*block }).collect()
}

/// What happened in the middle of the record.
pub(crate) fn stationarity(signal: &SignalValues, skipped_s: f64) -> Value {
    json!({
        "disturbances": signal.disturbed.disturbances.iter().map(|found| json!({
            "start_s": skipped_s + found.start_s,
            "end_s": skipped_s + found.end_s,
            "sigmas": found.sigmas,
        })).collect::<Value>(),
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
    json!({
        "shape": shape,
        "amplitude": amplitude,
        "start_s": start_s.map(|start_s| skipped_s + start_s),
        "time_constant_s": time_constant_s,
        // the skip that leaves it out
        "skip_s": skip_s.map(|skip_s| skipped_s + skip_s),
        "sigmas": change.sigmas,
    })
}
