//! A verdict on a figure of a data sheet, as a document has it.

use imu_noise::{Claim, Sides, Term, Verdict, conventions};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use crate::datasheet::FigureVerdict;

/// One figure of the data sheet and the verdict of the measurement, in SI units.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct VerdictDocument {
    /// Parameter.
    parameter: Term,
    /// Verdict.
    verdict: Verdict,
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
    /// Factor that averaging and decimation make of the figure of the sensor.
    factor: f64,
    /// How far the factor may be off, relative.
    factor_uncertainty: f64,
    /// Whether the averaging window is known.
    window_known: bool,
    /// Least that a sensor at the figure shows in this stream; a density of unknown sides as
    /// two-sided.
    expected_low: f64,
    /// Most that it shows.
    expected_high: f64,
    /// The verdict under each convention of a density of unknown sides; empty for any other figure.
    readings: Vec<ReadingDocument>,
}

/// A figure under one convention.
#[derive(Debug, JsonSchema, Serialize)]
struct ReadingDocument {
    /// Frequencies that the density counts.
    sides: Sides,
    /// Verdict under this convention.
    verdict: Verdict,
    /// Least that a sensor at the figure shows.
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
        let readings = verdict.readings.iter().map(|reading| ReadingDocument {
            sides: reading.sides,
            verdict: reading.verdict,
            expected_low: reading.expected.0,
            expected_high: reading.expected.1,
        });
        Self {
            parameter: figure.term,
            verdict: verdict.verdict,
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
            factor: verdict.stream.factor,
            factor_uncertainty: verdict.stream.uncertainty,
            window_known: verdict.window_known,
            expected_low: verdict.expected.0,
            expected_high: verdict.expected.1,
            readings: readings.collect(),
        }
    }
}
