//! The verdicts on one channel, as they stand in the JSON document.

use imu_noise::{Claim, Grade, Parameter, Sensor, Term, Verdict, conventions};
use serde::Serialize;
use vn100_pipeline::{ChannelNoise, FigureVerdict, LongTaus, StreamUnknown};

use crate::{judging::verdict_name, noise_document::term_name};

/// One figure of the data sheet and what the measurement says of it, in SI units.
#[derive(Debug, Serialize)]
pub(crate) struct VerdictDocument {
    datasheet: String,
    parameter: &'static str,
    verdict: &'static str,
    /// As the sheet prints it.
    figure: String,
    claim: &'static str,
    /// A bias instability that is the minimum of the deviation, not divided by 0.664; so is what it is compared with.
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

/// The best and the worst grade a gyroscope may be of, or why that cannot be said; `None` for any other sensor.
pub(crate) fn grade(noise: &ChannelNoise) -> Option<Result<(Grade, Grade), &'static str>> {
    if noise.sensor != Sensor::Gyroscope {
        return None;
    }
    let bias_instability = noise.parameter(Term::BiasInstability);
    Some(match noise.long_taus {
        LongTaus::Sensor => {
            let range = bias_instability.as_ref().and_then(Grade::range);
            range.ok_or("the record says nothing of the bias instability")
        }
        LongTaus::Compensated | LongTaus::LooksCompensated | LongTaus::Surroundings => {
            Err("the stream does not carry the sensor's bias instability")
        }
        LongTaus::Motion => Err("the sensor was moved"),
    })
}

pub(crate) fn grade_name(grade: Grade) -> &'static str {
    match grade {
        Grade::Navigation => "navigation",
        Grade::Tactical => "tactical",
        Grade::Commercial => "commercial",
    }
}

/// What was measured and what a sensor at the figure reads in this stream.
pub(crate) fn sentence(sensor: Sensor, verdict: &FigureVerdict) -> String {
    let figure = &verdict.figure;
    let shown = shown_in(sensor, figure.term);
    let number = |value: f64| crate::text::four_digits(value * shown.1);
    let Parameter { value, lower, upper, .. } = verdict.measured;
    let minimum =
        if figure.is_minimum && figure.term == Term::BiasInstability { " as the minimum of the curve" } else { "" };
    let measured = match (value, lower, upper) {
        (Some(value), Some(lower), Some(upper)) => {
            format!("measured {} {} ({} to {}){minimum}", number(value), shown.0, number(lower), number(upper))
        }
        (None, Some(lower), Some(upper)) => {
            format!("measured {} to {} {}{minimum}", number(lower), number(upper), shown.0)
        }
        (_, _, Some(upper)) => format!("measured at most {} {}{minimum}", number(upper), shown.0),
        (_, Some(lower), None) => format!("measured at least {} {}{minimum}", number(lower), shown.0),
        _ if verdict.verdict == Verdict::NotComparable => "not in this stream".into(),
        _ => "not known from this record".into(),
    };
    let (low, high) = verdict.expected;
    let window = if verdict.unknown == Some(StreamUnknown::Window) { "the default window" } else { "window" };
    let expected = if verdict.stream.factor == 1.0 {
        format!("the data sheet says {}", figure.printed)
    } else {
        let (middle, half) = ((low + high) / 2.0 * shown.1, (high - low) / 2.0 * shown.1);
        let decimals = (-half.log10().floor()).clamp(0.0, 9.0) as usize;
        format!(
            "a sensor of {} reads {middle:.decimals$} ± {half:.decimals$} at this rate and {window}",
            figure.printed
        )
    };
    format!("{measured}; {expected}{}", why(verdict))
}

/// Why what speaks for a figure does not let it pass.
pub(crate) const WHY_CONSISTENT: &str = "nothing speaks against the figure, and nothing can pass or fail, for the averaging on board (register \
                                         85) or the rate is not known, or a line was removed";

/// What the numbers do not say by themselves.
fn why(verdict: &FigureVerdict) -> &'static str {
    match (verdict.verdict, verdict.figure.claim) {
        (Verdict::Fail, Claim::Typical { .. }) => ": above what is typical, which is no guarantee",
        (Verdict::Undecided, _) if verdict.measured.lower.is_some() => match (verdict.unknown, verdict.figure.term) {
            (Some(StreamUnknown::Window), Term::White) => ": more than the usual averaging on board explains",
            (Some(StreamUnknown::Window), _) => {
                ": above the figure, and cannot fail, for the averaging on board is not known"
            }
            (Some(StreamUnknown::Rate), _) => ": above the figure, and cannot fail, for the rate is assumed",
            (Some(StreamUnknown::LineRemoved), _) => ": above the figure, and cannot fail, for a line was removed",
            (None, _) => "",
        },
        _ => "",
    }
}

/// The unit people compare this figure in.
pub(crate) fn shown_in(sensor: Sensor, term: Term) -> (&'static str, f64) {
    let unit = match (sensor, term) {
        (Sensor::Gyroscope, Term::White) => "deg/sqrt(h)",
        (Sensor::Gyroscope, Term::BiasInstability) => "deg/h",
        (Sensor::Gyroscope, Term::RateRandomWalk) => "deg/h^1.5",
        (Sensor::Accelerometer, Term::White) => "mg/sqrt(Hz)",
        (Sensor::Accelerometer, Term::BiasInstability) => "mg",
        _ => "",
    };
    let all = conventions(sensor, term);
    let convention = all.iter().find(|convention| convention.unit == unit).or(all.first());
    convention.map_or(("", 1.0), |convention| (convention.unit, convention.factor))
}
