//! A verdict on a figure of a data sheet, as a document has it.

use imu_noise::{Claim, Term, Verdict, conventions};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use crate::datasheet::{DecidedBy, FigureVerdict, Ratio};

/// One figure of the data sheet and the verdict of the measurement, in SI units.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct VerdictDocument {
    /// Parameter.
    parameter: Term,
    /// Verdict; null for a typical figure that is not taken for a limit.
    verdict: Option<Verdict>,
    /// What would decide; null unless the verdict is undecided.
    decided_by: Option<DecidedBy>,
    /// Figure as printed, such as typical 0.0035 deg/s/sqrt(Hz).
    figure: String,
    /// Kind of figure: limit or typical.
    claim: &'static str,
    /// Whether a bias instability is the minimum of the deviation, as is the measured value beside it.
    is_minimum: bool,
    /// Where the figure was found.
    source: Option<String>,
    /// SI unit of the numbers.
    unit: &'static str,
    /// Measured value.
    measured: Option<f64>,
    /// Lower end of its interval.
    measured_lower: Option<f64>,
    /// Upper end of its interval.
    measured_upper: Option<f64>,
    /// Measured value over the expected one.
    ratio: Ratio,
    /// Least factor by which averaging and decimation may raise the figure of the sensor.
    factor_low: f64,
    /// Most by which they may raise it.
    factor_high: f64,
    /// Least that a sensor at the figure shows in this stream.
    expected_low: f64,
    /// Most that it shows.
    expected_high: f64,
}

pub(super) fn as_documents<S: Serializer>(
    verdicts: &Option<Vec<FigureVerdict>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let documents = verdicts.as_ref().map(|verdicts| verdicts.iter().map(VerdictDocument::of).collect::<Vec<_>>());
    documents.serialize(serializer)
}

impl VerdictDocument {
    fn of(verdict: &FigureVerdict) -> Self {
        let figure = &verdict.figure;
        Self {
            parameter: figure.term,
            verdict: verdict.verdict,
            decided_by: verdict.decided_by,
            figure: figure.printed.clone(),
            claim: match figure.claim {
                Claim::Limit(_) => "limit",
                Claim::Typical { .. } => "typical",
            },
            is_minimum: figure.is_curve_minimum(),
            source: figure.source.clone(),
            unit: conventions(figure.sensor, figure.term).first().map_or("", |si| si.unit),
            measured: verdict.measured.value,
            measured_lower: verdict.measured.lower,
            measured_upper: verdict.measured.upper,
            ratio: verdict.ratio,
            factor_low: verdict.factor.0,
            factor_high: verdict.factor.1,
            expected_low: verdict.expected.0,
            expected_high: verdict.expected.1,
        }
    }
}
