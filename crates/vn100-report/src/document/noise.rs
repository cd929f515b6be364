//! The noise parameters of one channel, as they stand in the JSON document.

use imu_noise::{Convention, Parameter, Sides, Status, Term, conventions};
use serde_json::{Value, json};
use vn100_analysis::{ChannelNoise, FilterModels};

use crate::units::si_unit;

/// `samples`: what the parameters rest on; of a record that grows they may be a twentieth fewer than
/// it has.
pub(crate) fn noise(noise: &ChannelNoise, samples: u64) -> Value {
    let parameter_of = |term| Some(parameter(noise.parameter(term)?, conventions(noise.sensor, term)));
    let unit = |term| si_unit(noise.sensor, term);
    json!({
        "samples": samples,
        "fit": noise.fit.quality.map(|quality| json!({
            "tau_min_s": quality.tau_min_s,
            "tau_max_s": quality.tau_max_s,
            "chi2": quality.chi2,
            "dof": quality.dof,
            "p": quality.p,
        })),
        "white": parameter_of(Term::White),
        "bias_instability": parameter_of(Term::BiasInstability),
        "rate_random_walk": parameter_of(Term::RateRandomWalk),
        "rate_ramp": parameter_of(Term::RateRamp),
        "quantization": parameter_of(Term::Quantization),
        // where this record is too short for the random walk: how small a one a longer record would show
        "rate_random_walk_seen_later": noise.detectable_rrw.map(|later| json!({
            "duration_s": later.duration_s,
            "at_least": later.at_least,
        })),
        "correlations": correlations(noise),
        // what the graphical rules read off the Allan deviation; all `null` of another deviation
        "classical": {
            "white": noise.classical.white,
            "white_unit": unit(Term::White),
            "bias_instability": noise.classical.bias_instability,
            "bias_instability_unit": unit(Term::BiasInstability),
            "rate_random_walk": noise.classical.rate_random_walk,
            "rate_random_walk_unit": unit(Term::RateRandomWalk),
        },
    })
}

/// In the SI units of the parameters; sigma in that of the channel.
pub(crate) fn filter_models(models: &FilterModels) -> Value {
    json!({
        "gauss_markov": models.gauss_markov.map(|fit| json!({
            "white": bounds(fit.white),
            "sigma": bounds(fit.sigma),
            "correlation_time_s": bounds(fit.correlation_time_s),
            "chi2": fit.chi2,
            "dof": fit.dof,
            "p": fit.p,
        })),
        "over_bound": models.over_bound.map(|bound| json!({
            "white": bound.white,
            "rate_random_walk": bound.rate_random_walk,
        })),
    })
}

/// Of the squared amplitudes of two terms.
fn correlations(noise: &ChannelNoise) -> Vec<Value> {
    let shown = |term| noise.parameter(term).is_some_and(|parameter| parameter.status != Status::NotMeasurable);
    let mut correlations = Vec::new();
    for (index, &a) in Term::ALL.iter().enumerate().filter(|(_, term)| shown(**term)) {
        for &b in Term::ALL[index + 1..].iter().filter(|term| shown(**term)) {
            let value = noise.fit.correlation(a, b);
            correlations.extend(value.map(|value| json!({ "of": [term_name(a), term_name(b)], "value": value })));
        }
    }
    correlations
}

fn bounds(parameter: Parameter) -> Value {
    let Parameter { value, lower, upper, .. } = parameter;
    json!({ "status": status(parameter.status), "value": value, "lower": lower, "upper": upper })
}

/// The SI unit comes first among `conventions`; behind it the same in every other unit in use.
fn parameter(parameter: Parameter, conventions: &[Convention]) -> Value {
    let says_something = parameter.value.is_some() || parameter.upper.is_some();
    let in_unit = |convention: &Convention| {
        let times = |value: Option<f64>| value.map(|value| value * convention.factor);
        json!({
            "unit": convention.unit,
            // of a density, which frequencies it counts
            "sides": convention.sides.map(|sides| match sides {
                Sides::One => "one",
                Sides::Two => "two",
            }),
            "value": times(parameter.value),
            "lower": times(parameter.lower),
            "upper": times(parameter.upper),
        })
    };
    let others = conventions.iter().skip(1).filter(|_| says_something);
    let mut document = bounds(parameter);
    document["unit"] = conventions.first().map_or("", |si| si.unit).into();
    document["conventions"] = others.map(in_unit).collect();
    document
}

/// The parameter's name in results.
pub(crate) fn term_name(term: Term) -> &'static str {
    match term {
        Term::Quantization => "quantization",
        Term::White => "white",
        Term::BiasInstability => "bias_instability",
        Term::RateRandomWalk => "rate_random_walk",
        Term::RateRamp => "rate_ramp",
    }
}

pub(crate) fn status(status: Status) -> &'static str {
    match status {
        Status::Estimated => "estimated",
        Status::Bounded => "bounded",
        Status::NotObservable => "not-observable",
        Status::NotMeasurable => "not-measurable",
        Status::ModelRejected => "model-rejected",
    }
}
