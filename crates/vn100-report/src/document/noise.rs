//! The noise parameters of one channel and the verdicts on them, as in the JSON document.

use serde_json::{Value, json};
use vn100_analysis::noise::{Claim, Grade, Parameter, Sensor, Sides, Status, Term, conventions};
use vn100_analysis::{ChannelNoise, FigureVerdict, FilterModels, StreamUnknown, Verdicts};

use crate::{
    names::{grade, grade_name, sentence, verdict_name},
    units::si_unit,
};

/// `samples` are those the parameters rest on: in a growing record up to a twentieth fewer than it
/// has.
pub(super) fn noise(noise: &ChannelNoise, samples: u64, models: Option<&FilterModels>) -> Value {
    let parameter = |term| noise.parameter(term).map(|found| parameter(found, noise.sensor, term));
    let unit = |term| si_unit(noise.sensor, term);
    let shown = |term| noise.parameter(term).is_some_and(|parameter| parameter.status != Status::NotMeasurable);
    let mut correlations = Vec::new();
    for (index, &a) in Term::ALL.iter().enumerate().filter(|(_, term)| shown(**term)) {
        for &b in Term::ALL[index + 1..].iter().filter(|term| shown(**term)) {
            let value = noise.fit.correlation(a, b);
            correlations.extend(value.map(|value| json!({ "of": [term_name(a), term_name(b)], "value": value })));
        }
    }
    let fit = noise.fit.quality.map(|fit| {
        json!({
            "tau_min_s": fit.tau_min_s,
            "tau_max_s": fit.tau_max_s,
            "chi2": fit.chi2,
            "dof": fit.dof,
            "p": fit.p,
        })
    });
    let later = noise.detectable_rrw;
    let mut document = json!({
        "samples": samples,
        "fit": fit,
        "white": parameter(Term::White),
        "bias_instability": parameter(Term::BiasInstability),
        "rate_random_walk": parameter(Term::RateRandomWalk),
        "rate_ramp": parameter(Term::RateRamp),
        "quantization": parameter(Term::Quantization),
        // where the record is too short for a random walk: the smallest a longer one would show
        "rate_random_walk_seen_later":
            later.map(|later| json!({ "duration_s": later.duration_s, "at_least": later.at_least })),
        // of the squared amplitudes of two terms
        "correlations": correlations,
        // by the graphical rules; all `null` unless of the Allan deviation
        "classical": {
            "white": noise.classical.white,
            "white_unit": unit(Term::White),
            "bias_instability": noise.classical.bias_instability,
            "bias_instability_unit": unit(Term::BiasInstability),
            "rate_random_walk": noise.classical.rate_random_walk,
            "rate_random_walk_unit": unit(Term::RateRandomWalk),
        },
    });
    // only where asked for
    if let Some(models) = models {
        document["filter_models"] = filter_models(models);
    }
    document
}

/// In the SI units of the parameters; sigma in that of the channel.
fn filter_models(models: &FilterModels) -> Value {
    let gauss_markov = models.gauss_markov.map(|fit| {
        json!({
            "white": bounds(fit.white),
            "sigma": bounds(fit.sigma),
            "correlation_time_s": bounds(fit.correlation_time_s),
            "chi2": fit.chi2,
            "dof": fit.dof,
            "p": fit.p,
        })
    });
    let over_bound =
        models.over_bound.map(|bound| json!({ "white": bound.white, "rate_random_walk": bound.rate_random_walk }));
    json!({ "gauss_markov": gauss_markov, "over_bound": over_bound })
}

fn bounds(Parameter { status, value, lower, upper }: Parameter) -> Value {
    json!({ "status": status_name(status), "value": value, "lower": lower, "upper": upper })
}

/// In SI units, and where it says something in every other unit in use.
fn parameter(parameter: Parameter, sensor: Sensor, term: Term) -> Value {
    let says_something = parameter.value.is_some() || parameter.upper.is_some();
    let others = conventions(sensor, term).iter().skip(1).filter(|_| says_something);
    let others = others.map(|convention| {
        let sides = convention.sides.map(|sides| match sides {
            Sides::One => "one",
            Sides::Two => "two",
        });
        let in_unit = |value: Option<f64>| value.map(|value| value * convention.factor);
        json!({
            "unit": convention.unit,
            // of a density, which frequencies it counts
            "sides": sides,
            "value": in_unit(parameter.value),
            "lower": in_unit(parameter.lower),
            "upper": in_unit(parameter.upper),
        })
    });
    let mut document = bounds(parameter);
    document["unit"] = si_unit(sensor, term).into();
    document["conventions"] = others.collect();
    document
}

pub(crate) fn term_name(term: Term) -> &'static str {
    match term {
        Term::Quantization => "quantization",
        Term::White => "white",
        Term::BiasInstability => "bias_instability",
        Term::RateRandomWalk => "rate_random_walk",
        Term::RateRamp => "rate_ramp",
    }
}

pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Estimated => "estimated",
        Status::Bounded => "bounded",
        Status::NotObservable => "not-observable",
        Status::NotMeasurable => "not-measurable",
        Status::ModelRejected => "model-rejected",
    }
}

/// The figures of the data sheet for the channel at `place`; `None` where it has none.
pub(super) fn verdicts(sensor: Sensor, sheet: &Verdicts, place: usize) -> Option<Value> {
    let figures = sheet.channels.get(place).filter(|figures| !figures.is_empty())?;
    Some(figures.iter().map(|figure| verdict(&sheet.datasheet, sensor, figure)).collect())
}

/// One figure of the data sheet and what the measurement says of it, in SI units.
fn verdict(datasheet: &str, sensor: Sensor, verdict: &FigureVerdict) -> Value {
    let figure = &verdict.figure;
    let claim = match figure.claim {
        Claim::Limit(_) => "limit",
        Claim::Typical { .. } => "typical",
    };
    json!({
        "datasheet": datasheet,
        "parameter": term_name(figure.term),
        "verdict": verdict_name(verdict.verdict),
        "figure": figure.printed,
        "claim": claim,
        // a bias instability that is the minimum of the deviation, as is what it is compared with
        "is_minimum": figure.is_minimum && figure.term == Term::BiasInstability,
        "source": figure.source,
        "unit": si_unit(sensor, figure.term),
        "measured": verdict.measured.value,
        "measured_lower": verdict.measured.lower,
        "measured_upper": verdict.measured.upper,
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

/// A class of gyroscopes and its limits; `None` for any other sensor.
pub(super) fn graded(noise: &ChannelNoise) -> Option<Value> {
    let graded = grade(noise)?;
    let range = graded.ok();
    let limit = |grade: Grade| (grade_name(grade), Some(grade.limit_deg_h()).filter(|limit| limit.is_finite()));
    Some(json!({
        "scheme": SCHEME,
        // equal where the interval decides
        "best": range.map(|(best, _)| grade_name(best)),
        "worst": range.map(|(_, worst)| grade_name(worst)),
        // bias instability up to which a gyroscope is of that grade; the last has none
        "limits_deg_h": Grade::ALL.map(limit),
        "reason": graded.err(),
    }))
}
