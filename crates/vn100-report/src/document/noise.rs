//! The noise parameters of one channel and the verdicts on them, as in the JSON document.

use serde::Serialize;
use vn100_analysis::noise::{Claim, Convention, Grade, Parameter, Sensor, Sides, Status, Term, conventions};
use vn100_analysis::{Aliasing, ChannelNoise, FigureVerdict, WhiteBudget, WindowFrom};

use super::{graphical::ClassicalDocument, temperature::TemperatureDocument};
use crate::{
    codes::{
        code_of_decided, code_of_rate, code_of_status, code_of_verdict, code_of_window, code_of_withheld, term_name,
    },
    names::{NO_SCALE_FACTOR, grade_name, grade_scheme, grade_text, no_grade, p_without, sentence},
    units::si_unit,
};

#[derive(Debug, Serialize)]
pub(crate) struct NoiseDocument {
    /// Samples the parameters rest on, in a growing record up to a twentieth fewer than it has.
    samples: u64,
    fit: Option<Fit>,
    white: Option<ParameterDocument>,
    bias_instability: Option<ParameterDocument>,
    /// The minimum of the deviation, as data sheets have in-run bias stability.
    curve_minimum: Option<ParameterDocument>,
    rate_random_walk: Option<ParameterDocument>,
    rate_ramp: Option<ParameterDocument>,
    quantization: Option<ParameterDocument>,
    /// Where the record is too short for a random walk: the smallest a longer one would show.
    rate_random_walk_seen_later: Option<SeenLater>,
    /// Why bias instability, random walk and ramp are no more than bounded: `level-change`,
    /// `temperature`, or, what is not proved beside a cycle that may be there, `perhaps-cycle`.
    withheld: Option<&'static str>,
    /// Of a record that has the temperature of the sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    temperature: Option<TemperatureDocument>,
    correlations: Vec<Correlation>,
    classical: ClassicalDocument,
}

#[derive(Debug, Serialize)]
struct Bounds {
    status: &'static str,
    #[serde(flatten)]
    range: Range,
}

#[derive(Debug, Serialize)]
struct Range {
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Fit {
    tau_min_s: f64,
    tau_max_s: f64,
    chi2: f64,
    dof: usize,
    p: f64,
}

#[derive(Debug, Serialize)]
struct ParameterDocument {
    #[serde(flatten)]
    bounds: Bounds,
    unit: &'static str,
    /// The same in every other unit in use.
    conventions: Vec<InUnit>,
    /// Probability that noise without the term would show as much of it, of this term alone.
    p: Option<f64>,
    /// Of white noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    budget: Option<BudgetDocument>,
}

/// What N is uncertain by, each relative to it; what is not known is `null`.
#[derive(Debug, Serialize)]
struct BudgetDocument {
    sampling: SamplingDocument,
    rate: RateDocument,
    /// What averaging and decimation on board add to the sensor's own noise.
    aliasing: AliasingDocument,
    scale_factor: ScaleFactorDocument,
}

/// The randomness of the record: how far the interval of the fit reaches below and above the value.
#[derive(Debug, Serialize)]
struct SamplingDocument {
    below: Option<f64>,
    above: Option<f64>,
}

#[derive(Debug, Serialize)]
struct RateDocument {
    from: &'static str,
    verified_by: Option<&'static str>,
    relative: Option<f64>,
}

#[derive(Debug, Serialize)]
struct AliasingDocument {
    /// N in the stream over that of the sensor, with the window as known or by default.
    factor: Option<f64>,
    /// How far the factor may be off; `null` if the window is not known.
    relative: Option<f64>,
    /// The most that any window makes of the factor.
    largest_factor: Option<f64>,
    window_from: Option<&'static str>,
    /// N of the sensor itself; bounded where the window is not known.
    unaliased: Bounds,
}

/// A record at rest does not show it.
#[derive(Debug, Serialize)]
struct ScaleFactorDocument {
    relative: Option<f64>,
    reason: &'static str,
}

#[derive(Debug, Serialize)]
struct InUnit {
    unit: &'static str,
    /// Of a density, which frequencies it counts.
    sides: Option<&'static str>,
    #[serde(flatten)]
    range: Range,
}

#[derive(Debug, Serialize)]
struct SeenLater {
    duration_s: f64,
    at_least: f64,
}

/// Of the squared amplitudes of two terms.
#[derive(Debug, Serialize)]
struct Correlation {
    of: [&'static str; 2],
    value: f64,
}

impl NoiseDocument {
    pub(crate) fn new(noise: &ChannelNoise, samples: u64, rate_hz: f64) -> Self {
        let parameter = |term| {
            let found = noise.parameter(term)?;
            let found = Parameter { p: p_without(term, &found), ..found };
            Some(ParameterDocument::new(found, conventions(noise.sensor, term)))
        };
        let shown = |term| noise.parameter(term).is_some_and(|parameter| parameter.status != Status::NotMeasurable);
        let mut correlations = Vec::new();
        for (index, &a) in Term::ALL.iter().enumerate().filter(|(_, term)| shown(**term)) {
            for &b in Term::ALL[index + 1..].iter().filter(|term| shown(**term)) {
                let value = noise.fit.correlation(a, b);
                correlations.extend(value.map(|value| Correlation { of: [term_name(a), term_name(b)], value }));
            }
        }
        Self {
            samples,
            fit: noise.fit.quality.map(|quality| Fit {
                tau_min_s: quality.tau_min_s,
                tau_max_s: quality.tau_max_s,
                chi2: quality.chi2,
                dof: quality.dof,
                p: quality.p,
            }),
            white: parameter(Term::White)
                .map(|white| ParameterDocument { budget: BudgetDocument::new(noise), ..white }),
            bias_instability: parameter(Term::BiasInstability),
            curve_minimum: (noise.curve_minimum())
                .map(|minimum| ParameterDocument::new(minimum, conventions(noise.sensor, Term::BiasInstability))),
            rate_random_walk: parameter(Term::RateRandomWalk),
            rate_ramp: parameter(Term::RateRamp),
            quantization: parameter(Term::Quantization),
            rate_random_walk_seen_later: noise
                .detectable_rrw
                .map(|later| SeenLater { duration_s: later.duration_s, at_least: later.at_least }),
            withheld: noise.withheld().map(|why| code_of_withheld(why).code),
            temperature: (noise.temperature.as_ref())
                .map(|temperature| TemperatureDocument::new(temperature, noise.sensor, rate_hz)),
            correlations,
            classical: ClassicalDocument::new(noise),
        }
    }
}

impl Bounds {
    fn new(parameter: Parameter) -> Self {
        Self { status: code_of_status(parameter.status).code, range: Range::new(parameter, 1.0) }
    }
}

impl Range {
    /// In a unit of which one of the parameter's is `factor`.
    fn new(Parameter { value, lower, upper, .. }: Parameter, factor: f64) -> Self {
        let [value, lower, upper] = [value, lower, upper].map(|value| value.map(|value| value * factor));
        Self { value, lower, upper }
    }
}

impl ParameterDocument {
    /// The SI unit comes first among `conventions`.
    fn new(parameter: Parameter, conventions: &[Convention]) -> Self {
        let says_something = parameter.value.is_some() || parameter.upper.is_some();
        let in_unit = |convention: &Convention| InUnit {
            unit: convention.unit,
            sides: convention.sides.map(sides_name),
            range: Range::new(parameter, convention.factor),
        };
        Self {
            bounds: Bounds::new(parameter),
            unit: conventions.first().map_or("", |si| si.unit),
            conventions: conventions.iter().skip(1).filter(|_| says_something).map(in_unit).collect(),
            p: parameter.p,
            budget: None,
        }
    }
}

impl BudgetDocument {
    fn new(noise: &ChannelNoise) -> Option<Self> {
        let WhiteBudget { sampling, rate, aliasing } = noise.white_budget;
        let is_known = |aliasing: &Aliasing| aliasing.window_from != WindowFrom::Default;
        Some(Self {
            sampling: SamplingDocument {
                below: sampling.map(|(below, _)| below),
                above: sampling.map(|(_, above)| above),
            },
            rate: RateDocument {
                from: code_of_rate(rate.from).code,
                verified_by: rate.relative.map(|_| "arrival-times"),
                relative: rate.relative,
            },
            aliasing: AliasingDocument {
                factor: aliasing.map(|aliasing| aliasing.factor),
                relative: aliasing.filter(is_known).map(|aliasing| aliasing.uncertainty),
                largest_factor: aliasing.map(|aliasing| aliasing.most),
                window_from: aliasing.map(|aliasing| code_of_window(aliasing.window_from).code),
                unaliased: Bounds::new(noise.unaliased_white()?),
            },
            scale_factor: ScaleFactorDocument { relative: None, reason: NO_SCALE_FACTOR },
        })
    }
}

pub(crate) fn sides_name(sides: Sides) -> &'static str {
    match sides {
        Sides::One => "one",
        Sides::Two => "two",
    }
}

/// One figure of the data sheet and the verdict of the measurement, in SI units.
#[derive(Debug, Serialize)]
pub(crate) struct VerdictDocument {
    datasheet: String,
    parameter: &'static str,
    /// `null` for a typical figure that is not taken for a limit.
    verdict: Option<&'static str>,
    decided_by: Option<&'static str>,
    figure: String,
    claim: &'static str,
    /// A bias instability that is the minimum of the deviation, as is what it is compared with.
    is_minimum: bool,
    source: Option<String>,
    unit: &'static str,
    measured: Option<f64>,
    measured_lower: Option<f64>,
    measured_upper: Option<f64>,
    /// Measured over expected.
    ratio: Range,
    /// What averaging and decimation may make of the sensor's own figure.
    factor_low: f64,
    factor_high: f64,
    expected_low: f64,
    expected_high: f64,
    text: String,
}

pub(crate) const fn claim_name(claim: &Claim) -> &'static str {
    match claim {
        Claim::Limit(_) => "limit",
        Claim::Typical { .. } => "typical",
    }
}

impl VerdictDocument {
    pub(crate) fn new(datasheet: &str, sensor: Sensor, verdict: &FigureVerdict) -> Self {
        let Parameter { value, lower, upper, .. } = verdict.measured;
        let (figure, ratio) = (&verdict.figure, verdict.ratio);
        Self {
            datasheet: datasheet.into(),
            parameter: term_name(figure.term),
            verdict: verdict.verdict.map(|verdict| code_of_verdict(verdict).code),
            decided_by: verdict.decided_by.map(|by| code_of_decided(by).code),
            figure: figure.printed.clone(),
            claim: claim_name(&figure.claim),
            is_minimum: figure.is_curve_minimum(),
            source: figure.source.clone(),
            unit: si_unit(sensor, figure.term),
            measured: value,
            measured_lower: lower,
            measured_upper: upper,
            ratio: Range { value: ratio.value, lower: ratio.lower, upper: ratio.upper },
            factor_low: verdict.factor.0,
            factor_high: verdict.factor.1,
            expected_low: verdict.expected.0,
            expected_high: verdict.expected.1,
            text: sentence(sensor, verdict),
        }
    }
}

/// A class of gyroscopes and its limits.
#[derive(Debug, Serialize)]
pub(crate) struct GradeDocument {
    scheme: String,
    /// Equal where the intervals decide; `null` if it is not known.
    best: Option<&'static str>,
    worst: Option<&'static str>,
    /// The same in words.
    text: Option<String>,
    /// Bias instability below which a gyroscope may be of that grade; the last has none.
    limits_deg_h: [(&'static str, Option<f64>); 4],
    /// The same of its angle random walk.
    limits_deg_sqrt_h: [(&'static str, Option<f64>); 4],
    reason: Option<&'static str>,
}

impl GradeDocument {
    pub(crate) fn new(noise: &ChannelNoise) -> Option<Self> {
        let graded = noise.grade()?;
        let range = graded.ok();
        let limit =
            |of: fn(Grade) -> f64| move |grade| (grade_name(grade), Some(of(grade)).filter(|limit| limit.is_finite()));
        Some(Self {
            scheme: grade_scheme(),
            best: range.map(|(best, _)| grade_name(best)),
            worst: range.map(|(_, worst)| grade_name(worst)),
            text: range.and_then(|_| grade_text(noise)),
            limits_deg_h: Grade::ALL.map(limit(Grade::limit_deg_h)),
            limits_deg_sqrt_h: Grade::ALL.map(limit(Grade::limit_deg_sqrt_h)),
            reason: graded.err().map(no_grade),
        })
    }
}
