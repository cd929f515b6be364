//! How a channel went through time and frequency, as it stands in the JSON document. Its times are
//! of the record, in seconds of data since the first sample, those skipped included: `skipped_s`
//! lie before the first sample that counts.

use serde::Serialize;
use vn100_analysis::noise::{LevelChange, LevelShape, Normality, NotJudged};

use crate::units::{BlockValues, SignalValues};

#[derive(Debug, Serialize)]
pub(crate) struct NormalityDocument {
    /// 99 of 100 normal records are said to be; `null` where it cannot be judged.
    consistent: Option<bool>,
    reason: Option<String>,
    /// If the values were normal.
    skewness_error: Option<f64>,
    excess_kurtosis_error: Option<f64>,
    /// Independent samples that say as much of the skewness.
    effective_samples: Option<f64>,
}

/// The power spectral density by Welch's method, and its peaks.
#[derive(Debug, Serialize)]
pub(crate) struct SpectrumDocument {
    sides: &'static str,
    segment_samples: Option<usize>,
    segments: Option<u64>,
    /// Of the first point, and from point to point.
    step_hz: Option<f64>,
    density: Vec<f64>,
    lines: Vec<LineDocument>,
}

#[derive(Debug, Serialize)]
struct LineDocument {
    frequency_hz: f64,
    amplitude: f64,
    share_of_variance: f64,
}

/// What happened in the middle of the record.
#[derive(Debug, Serialize)]
pub(crate) struct StationarityDocument {
    disturbances: Vec<Disturbance>,
    level_change: Option<LevelChangeDocument>,
}

#[derive(Debug, Serialize)]
struct Disturbance {
    start_s: f64,
    end_s: f64,
    sigmas: f64,
}

#[derive(Debug, Serialize)]
struct LevelChangeDocument {
    shape: &'static str,
    amplitude: f64,
    /// Of a step.
    start_s: Option<f64>,
    /// Of a warm-up.
    time_constant_s: Option<f64>,
    /// The skip that leaves it out.
    skip_s: Option<f64>,
    sigmas: f64,
}

impl NormalityDocument {
    pub(crate) fn new(normality: Result<Normality, NotJudged>) -> Self {
        let judged = normality.ok();
        Self {
            consistent: judged.map(|normality| normality.is_consistent()),
            reason: normality.err().map(|reason| reason.to_string()),
            skewness_error: judged.map(|normality| normality.skewness_error),
            excess_kurtosis_error: judged.map(|normality| normality.excess_kurtosis_error),
            effective_samples: judged.map(|normality| normality.effective_samples),
        }
    }
}

impl SpectrumDocument {
    pub(crate) fn new(signal: &SignalValues) -> Self {
        let density = signal.density.as_ref();
        Self {
            sides: "one",
            segment_samples: density.map(|density| density.segment_samples),
            segments: density.map(|density| density.segments),
            step_hz: density.and_then(|density| density.points.first()).map(|point| point.frequency_hz),
            density: density.iter().flat_map(|density| &density.points).map(|point| point.density_unit2_hz).collect(),
            lines: (signal.disturbed.lines.iter())
                .map(|line| LineDocument {
                    frequency_hz: line.frequency_hz,
                    amplitude: line.amplitude,
                    share_of_variance: line.share_of_variance,
                })
                .collect(),
        }
    }
}

/// The blocks of a record, with times of the record.
pub(crate) fn blocks(signal: &SignalValues, skipped_s: f64) -> Vec<BlockValues> {
    signal.blocks.iter().map(|block| BlockValues { start_s: skipped_s + block.start_s, ..*block }).collect()
}

impl StationarityDocument {
    pub(crate) fn new(signal: &SignalValues, skipped_s: f64) -> Self {
        Self {
            disturbances: (signal.disturbed.disturbances.iter())
                .map(|found| Disturbance {
                    start_s: skipped_s + found.start_s,
                    end_s: skipped_s + found.end_s,
                    sigmas: found.sigmas,
                })
                .collect(),
            level_change: signal.disturbed.level_change.map(|change| LevelChangeDocument::new(change, skipped_s)),
        }
    }
}

impl LevelChangeDocument {
    fn new(change: LevelChange, skipped_s: f64) -> Self {
        let (shape, amplitude, start_s, time_constant_s, skip_s) = match change.shape {
            LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => {
                ("warm-up", amplitude, None, Some(time_constant_s), skip_s)
            }
            LevelShape::Step { start_s, amplitude } => ("step", amplitude, Some(start_s), None, None),
        };
        let of_record = |time_s: Option<f64>| time_s.map(|time_s| skipped_s + time_s);
        let (start_s, skip_s) = (of_record(start_s), of_record(skip_s));
        Self { shape, amplitude, start_s, time_constant_s, skip_s, sigmas: change.sigmas }
    }
}
