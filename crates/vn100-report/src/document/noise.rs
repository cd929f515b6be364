//! The noise parameters of one channel, as they stand in the JSON document.

use imu_noise::{Convention, Parameter, Sides, Status, Term, conventions};
use serde::Serialize;
use vn100_analysis::{ChannelNoise, FilterModels};

#[derive(Debug, Serialize)]
pub(crate) struct NoiseDocument {
    /// Samples the parameters rest on; of a record that grows they may be a twentieth fewer than it
    /// has.
    samples: u64,
    fit: Option<Fit>,
    white: Option<ParameterDocument>,
    bias_instability: Option<ParameterDocument>,
    rate_random_walk: Option<ParameterDocument>,
    rate_ramp: Option<ParameterDocument>,
    quantization: Option<ParameterDocument>,
    /// Where this record is too short for the random walk: how small a one a longer record would
    /// show.
    rate_random_walk_seen_later: Option<SeenLater>,
    correlations: Vec<Correlation>,
    classical: Classical,
    /// Only where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    filter_models: Option<FilterModelsDocument>,
}

/// In the SI units of the parameters; sigma in that of the channel.
#[derive(Debug, Serialize)]
struct FilterModelsDocument {
    gauss_markov: Option<GaussMarkov>,
    over_bound: Option<OverBoundDocument>,
}

#[derive(Debug, Serialize)]
struct GaussMarkov {
    white: Bounds,
    sigma: Bounds,
    correlation_time_s: Bounds,
    chi2: f64,
    dof: usize,
    p: f64,
}

#[derive(Debug, Serialize)]
struct Bounds {
    status: &'static str,
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
}

#[derive(Debug, Serialize)]
struct OverBoundDocument {
    white: f64,
    rate_random_walk: f64,
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
    status: &'static str,
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
    unit: &'static str,
    /// The same in every other unit in use.
    conventions: Vec<InUnit>,
}

#[derive(Debug, Serialize)]
struct InUnit {
    unit: &'static str,
    /// Of a density, which frequencies it counts.
    sides: Option<&'static str>,
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
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

/// What the graphical rules read off the Allan deviation, N, B and K; all `null` of another
/// deviation.
#[derive(Debug, Serialize)]
struct Classical {
    white: Option<f64>,
    white_unit: &'static str,
    bias_instability: Option<f64>,
    bias_instability_unit: &'static str,
    rate_random_walk: Option<f64>,
    rate_random_walk_unit: &'static str,
}

impl NoiseDocument {
    pub(crate) fn new(noise: &ChannelNoise, samples: u64) -> Self {
        let parameter = |term| Some(ParameterDocument::new(noise.parameter(term)?, conventions(noise.sensor, term)));
        let unit = |term| conventions(noise.sensor, term).first().map_or("", |si| si.unit);
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
            white: parameter(Term::White),
            bias_instability: parameter(Term::BiasInstability),
            rate_random_walk: parameter(Term::RateRandomWalk),
            rate_ramp: parameter(Term::RateRamp),
            quantization: parameter(Term::Quantization),
            rate_random_walk_seen_later: noise
                .detectable_rrw
                .map(|later| SeenLater { duration_s: later.duration_s, at_least: later.at_least }),
            correlations,
            classical: Classical {
                white: noise.classical.white,
                white_unit: unit(Term::White),
                bias_instability: noise.classical.bias_instability,
                bias_instability_unit: unit(Term::BiasInstability),
                rate_random_walk: noise.classical.rate_random_walk,
                rate_random_walk_unit: unit(Term::RateRandomWalk),
            },
            filter_models: None,
        }
    }

    pub(crate) fn add_filter_models(&mut self, models: &FilterModels) {
        self.filter_models = Some(FilterModelsDocument {
            gauss_markov: models.gauss_markov.map(|fit| GaussMarkov {
                white: Bounds::new(fit.white),
                sigma: Bounds::new(fit.sigma),
                correlation_time_s: Bounds::new(fit.correlation_time_s),
                chi2: fit.chi2,
                dof: fit.dof,
                p: fit.p,
            }),
            over_bound: models
                .over_bound
                .map(|bound| OverBoundDocument { white: bound.white, rate_random_walk: bound.rate_random_walk }),
        });
    }
}

impl Bounds {
    fn new(parameter: Parameter) -> Self {
        let Parameter { value, lower, upper, .. } = parameter;
        Self { status: status(parameter.status), value, lower, upper }
    }
}

impl ParameterDocument {
    /// The SI unit comes first among `conventions`.
    fn new(parameter: Parameter, conventions: &[Convention]) -> Self {
        let says_something = parameter.value.is_some() || parameter.upper.is_some();
        let in_unit = |convention: &Convention| {
            let times = |value: Option<f64>| value.map(|value| value * convention.factor);
            InUnit {
                unit: convention.unit,
                sides: convention.sides.map(|sides| match sides {
                    Sides::One => "one",
                    Sides::Two => "two",
                }),
                value: times(parameter.value),
                lower: times(parameter.lower),
                upper: times(parameter.upper),
            }
        };
        Self {
            status: status(parameter.status),
            value: parameter.value,
            lower: parameter.lower,
            upper: parameter.upper,
            unit: conventions.first().map_or("", |si| si.unit),
            conventions: conventions.iter().skip(1).filter(|_| says_something).map(in_unit).collect(),
        }
    }
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
