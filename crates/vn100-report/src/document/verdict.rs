//! The verdicts on one channel, as they stand in the JSON document.

use imu_noise::{Claim, Grade, Parameter, Sensor, Term, conventions};
use serde::Serialize;
use vn100_analysis::{ChannelNoise, FigureVerdict, StreamUnknown};

use crate::{
    document::noise::term_name,
    verdict_words::{grade, grade_name, sentence, verdict_name},
};

/// One figure of the data sheet and what the measurement says of it, in SI units.
#[derive(Debug, Serialize)]
pub(crate) struct VerdictDocument {
    datasheet: String,
    parameter: &'static str,
    verdict: &'static str,
    /// As the sheet prints it.
    figure: String,
    claim: &'static str,
    /// A bias instability that is the minimum of the deviation, not divided by 0.664; so is what it
    /// is compared with.
    is_minimum: bool,
    source: Option<String>,
    unit: &'static str,
    measured: Option<f64>,
    measured_lower: Option<f64>,
    measured_upper: Option<f64>,
    /// What averaging and decimation make of the sensor's own figure, and how sure that is.
    factor: f64,
    factor_uncertainty: f64,
    window_known: bool,
    expected_low: f64,
    expected_high: f64,
    text: String,
}

impl VerdictDocument {
    pub(crate) fn new(datasheet: &str, sensor: Sensor, verdict: &FigureVerdict) -> Self {
        let Parameter { value, lower, upper, .. } = verdict.measured;
        let figure = &verdict.figure;
        Self {
            datasheet: datasheet.into(),
            parameter: term_name(figure.term),
            verdict: verdict_name(verdict.verdict),
            figure: figure.printed.clone(),
            claim: match figure.claim {
                Claim::Limit(_) => "limit",
                Claim::Typical { .. } => "typical",
            },
            is_minimum: figure.is_minimum && figure.term == Term::BiasInstability,
            source: figure.source.clone(),
            unit: conventions(sensor, figure.term).first().map_or("", |si| si.unit),
            measured: value,
            measured_lower: lower,
            measured_upper: upper,
            factor: verdict.stream.factor,
            factor_uncertainty: verdict.stream.uncertainty,
            window_known: verdict.unknown != Some(StreamUnknown::Window),
            expected_low: verdict.expected.0,
            expected_high: verdict.expected.1,
            text: sentence(sensor, verdict),
        }
    }
}

/// A class of gyroscopes and its limits.
#[derive(Debug, Serialize)]
pub(crate) struct GradeDocument {
    scheme: &'static str,
    /// Equal where the interval tells; `null` where it cannot be said.
    best: Option<&'static str>,
    worst: Option<&'static str>,
    /// Bias instability up to which a gyroscope is of that grade; the last has none.
    limits_deg_h: [(&'static str, Option<f64>); 3],
    /// Why it cannot be said.
    reason: Option<&'static str>,
}

const SCHEME: &str = "El-Sheimy and Youssef (2020), table 1, by bias instability";

impl GradeDocument {
    /// For gyroscopes only.
    pub(crate) fn new(noise: &ChannelNoise) -> Option<Self> {
        let graded = grade(noise)?;
        let range = graded.ok();
        let limit = |grade: Grade| (grade_name(grade), Some(grade.limit_deg_h()).filter(|limit| limit.is_finite()));
        Some(Self {
            scheme: SCHEME,
            best: range.map(|(best, _)| grade_name(best)),
            worst: range.map(|(_, worst)| grade_name(worst)),
            limits_deg_h: Grade::ALL.map(limit),
            reason: graded.err(),
        })
    }
}
