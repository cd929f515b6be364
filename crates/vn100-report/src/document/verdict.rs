//! The verdicts on one channel, as they stand in the JSON document.

use imu_noise::{Claim, Grade, Parameter, Sensor, Term};
use serde_json::{Value, json};
use vn100_analysis::{ChannelNoise, FigureVerdict, StreamUnknown};

use crate::{
    document::noise::term_name,
    units::si_unit,
    verdict_words::{grade, grade_name, sentence, verdict_name},
};

/// One figure of the data sheet and what the measurement says of it, in SI units.
pub(crate) fn verdict(datasheet: &str, sensor: Sensor, verdict: &FigureVerdict) -> Value {
    let Parameter { value, lower, upper, .. } = verdict.measured;
    let figure = &verdict.figure;
    json!({
        "datasheet": datasheet,
        "parameter": term_name(figure.term),
        "verdict": verdict_name(verdict.verdict),
        // as the sheet prints it
        "figure": figure.printed,
        "claim": match figure.claim {
            Claim::Limit(_) => "limit",
            Claim::Typical { .. } => "typical",
        },
        // a bias instability that is the minimum of the deviation, not divided by 0.664; so is what it is compared with
        "is_minimum": figure.is_minimum && figure.term == Term::BiasInstability,
        "source": figure.source,
        "unit": si_unit(sensor, figure.term),
        "measured": value,
        "measured_lower": lower,
        "measured_upper": upper,
        // what averaging and decimation make of the sensor's own figure, and how sure that is
        "factor": verdict.stream.factor,
        "factor_uncertainty": verdict.stream.uncertainty,
        "window_known": verdict.unknown != Some(StreamUnknown::Window),
        "expected_low": verdict.expected.0,
        "expected_high": verdict.expected.1,
        "text": sentence(sensor, verdict),
    })
}

const SCHEME: &str = "El-Sheimy and Youssef (2020), table 1, by bias instability";

/// The class of a gyroscope and the limits of all classes; `None` for other sensors.
pub(crate) fn grade_of(noise: &ChannelNoise) -> Option<Value> {
    let graded = grade(noise)?;
    let range = graded.ok();
    let limit = |grade: Grade| (grade_name(grade), Some(grade.limit_deg_h()).filter(|limit| limit.is_finite()));
    Some(json!({
        "scheme": SCHEME,
        // equal where the interval tells; `null` where it cannot be said
        "best": range.map(|(best, _)| grade_name(best)),
        "worst": range.map(|(_, worst)| grade_name(worst)),
        // bias instability up to which a gyroscope is of that grade; the last has none
        "limits_deg_h": Grade::ALL.map(limit),
        // why it cannot be said
        "reason": graded.err(),
    }))
}
