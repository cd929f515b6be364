//! A verdict on a figure of a data sheet, as a document has it, and the record that would decide it.

use imu_noise::{Aim, Claim, Term, Verdict, Wanted, conventions};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use crate::{
    assessment::ChannelNoise,
    datasheet::{DecidedBy, FigureVerdict, Ratio, floor_of_flicker},
    plan::{Plan, SLOW_TERMS, TakenAt},
};

/// One figure of the data sheet and the verdict of the measurement, in SI units.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct VerdictDocument {
    /// Parameter.
    parameter: Term,
    /// Verdict; null for a typical figure that is not taken for a limit.
    verdict: Option<Verdict>,
    /// What would decide; null unless the verdict is undecided.
    decided_by: Option<DecidedBy>,
    /// Length in seconds of a record that would probably decide; null unless a longer record would
    /// decide, and if 100 days do not.
    deciding_record_s: Option<f64>,
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
            deciding_record_s: verdict.deciding_record_s,
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

/// The length in seconds of a record with the noise that this axis shows and that would decide a
/// verdict which the interval leaves open; `None` if 100 days do not. A parameter that is only bounded is taken at as much of the limit as in a plan.
pub(super) fn deciding_record_s(
    verdict: &FigureVerdict,
    noise: &ChannelNoise,
    interval_s: f64,
    confidence: f64,
) -> Option<f64> {
    let FigureVerdict { figure, range: (passes_below, fails_above), .. } = verdict;
    let term = figure.term;
    let of_term = if figure.is_curve_minimum() { floor_of_flicker() } else { 1.0 };
    let value = verdict.measured.value.unwrap_or(TakenAt::BESIDE * passes_below);
    let aim = match value > *fails_above {
        true => Aim::Above(fails_above / of_term),
        false => Aim::Below(passes_below / of_term),
    };
    let others = Term::ALL.into_iter().filter(|other| ![term, Term::Quantization].contains(other));
    let others = others.filter_map(|other| Some((other, noise.parameter(other)?.value?)));
    let truth: Vec<(Term, f64)> = others.chain([(term, value / of_term)]).collect();
    let wanted = Wanted { term, aim, truth: &truth, missed: 1.0 - Plan::MET_IN, tests: SLOW_TERMS };
    wanted.record_s(interval_s, confidence)
}
