//! The noise parameters of one axis, in SI units (magnetic field in gauss).

use imu_noise::{
    Convention, FitQuality, Grade, GraphicalReadings, NoCoefficient, Parameter, Sensor, Sides, SlowNoise, Status, Term,
    Withheld, conventions, si_unit, temperature_conventions,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::assessment::{AxisTemperature, ChannelNoise, LongTauValidity, NoGrade, WhiteBudget};

/// The noise model of an axis.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct NoiseResult {
    /// What the axis measures.
    #[serde(skip)]
    pub sensor: Sensor,
    /// Samples the parameters rest on; in a growing record up to a twentieth fewer than it has.
    pub samples: u64,
    /// Quality of the fit; null if no range of averaging times follows the model.
    pub fit: Option<FitQuality>,
    /// N: angle or velocity random walk, or noise density; two-sided.
    pub white: Option<ParameterResult>,
    /// B: the flat part of the deviation is 0.664 B.
    pub bias_instability: Option<ParameterResult>,
    /// Minimum of the deviation, as data sheets have in-run bias stability.
    pub curve_minimum: Option<ParameterResult>,
    /// K: rate or acceleration random walk.
    pub rate_random_walk: Option<ParameterResult>,
    /// R: rate ramp.
    pub rate_ramp: Option<ParameterResult>,
    /// Q: quantization noise, if it was asked for.
    pub quantization: Option<ParameterResult>,
    /// The likeliest noise beside N, proved or not, for emulation; null where a change of the level or
    /// the temperature poses as noise.
    pub likeliest: Option<SlowNoise>,
    /// Samples over which a low-pass filter correlates the white noise, if one is proved: N² over the
    /// mean density.
    pub correlation_samples: Option<f64>,
    /// Why B, K and R are no more than bounded; null if the record decides.
    pub withheld: Option<Withheld>,
    /// Whether long averaging times show the noise of the sensor itself.
    pub long_taus: LongTauValidity,
    /// Temperature coefficient of the bias; absent without a temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<TemperatureResult>,
    /// What the graphical slope method reads, for comparison with published figures.
    pub classical: GraphicalReadings,
}

/// A noise parameter, in its SI unit and in every other unit in use.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct ParameterResult {
    /// The parameter in the SI unit.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// SI unit.
    pub unit: &'static str,
    /// The same in every other unit in use.
    pub conventions: Vec<InUnit>,
    /// The same by sample; absent for parameters other than N and K.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discrete: Option<Discrete>,
    /// What N is uncertain by; absent for other parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
}

/// N and K by sample, as simulators and some filters take them: N √rate, the standard deviation of
/// the white noise of one sample, and K/√rate, that of the step of the walk between two.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Discrete {
    /// Samples per second.
    pub rate_hz: f64,
    /// Unit of a sample.
    pub unit: &'static str,
    /// Estimate; null if there is none.
    pub value: Option<f64>,
    /// Lower end of the interval.
    pub lower: Option<f64>,
    /// Upper end of the interval, or upper bound.
    pub upper: Option<f64>,
}

/// A parameter in another unit.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct InUnit {
    /// The unit.
    pub unit: &'static str,
    /// Frequencies that a density counts; null for any other unit.
    pub sides: Option<Sides>,
    /// Estimate; null if there is none.
    pub value: Option<f64>,
    /// Lower end of the interval.
    pub lower: Option<f64>,
    /// Upper end of the interval, or upper bound.
    pub upper: Option<f64>,
}

/// What N is uncertain by, each part relative to it; null if a part is not known. The scale factor of
/// the sensor is no part: a record at rest does not show it, and its relative error is that of N too.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Budget {
    /// The parts.
    #[serde(flatten)]
    pub parts: WhiteBudget,
    /// N of the sensor itself; bounded if the averaging window is not known.
    pub unaliased: Parameter,
}

/// The residual temperature coefficient of the bias: what the compensation of the sensor leaves.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct TemperatureResult {
    /// The coefficient in the SI unit per °C; p without any influence of the temperature, of this
    /// axis alone.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// Why there is no coefficient; null if there is one.
    pub reason: Option<&'static str>,
    /// SI unit.
    pub unit: &'static str,
    /// The same in every other unit in use.
    pub conventions: Vec<InUnit>,
    /// Whether all axes together prove that this one follows the temperature.
    pub proved: bool,
    /// Lag behind the temperature in seconds.
    pub lag_s: Option<f64>,
    /// Shortest lag that the record does not exclude.
    pub lag_lower_s: Option<f64>,
    /// Longest lag that the record does not exclude.
    pub lag_upper_s: Option<f64>,
    /// Whether longer lags than the longest that is searched may hold.
    pub lag_open: bool,
    /// Range of the temperature in °C.
    pub excursion_degc: Option<f64>,
    /// Correlation of the temperature with time, -1 to 1.
    pub correlation_with_time: Option<f64>,
    /// Where the temperature comes from: stream or register.
    pub from: &'static str,
    /// If it is proved, the most that it has in the power of an octave of the level, 0 to 1.
    pub largest_share: Option<f64>,
    /// Why there is no coefficient, with the numbers of this record.
    #[serde(skip)]
    pub why: Option<NoCoefficient>,
}

/// The grade of a gyroscope.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Graded {
    /// Best grade that the intervals leave possible; null if it is not known.
    pub best: Option<Grade>,
    /// Worst grade that they leave possible; equal to the best if the intervals decide.
    pub worst: Option<Grade>,
    /// Why there is none; null if there is one.
    pub reason: Option<NoGrade>,
}

impl NoiseResult {
    pub(super) fn of(noise: &ChannelNoise, samples: u64, rate_hz: f64) -> Self {
        let sensor = noise.sensor;
        let parameter = |term| {
            let found = noise.parameter(term)?;
            // white noise is in every record: that it may be absent is not tested
            let p = found.p.filter(|_| term != Term::White);
            let discrete = Discrete::of(&found, sensor, term, rate_hz);
            Some(ParameterResult {
                discrete,
                ..ParameterResult::of(Parameter { p, ..found }, conventions(sensor, term))
            })
        };
        let budget = noise.unaliased_white().map(|unaliased| Budget { parts: noise.white_budget, unaliased });
        let withheld = noise.withheld();
        let poses_as_noise = matches!(withheld, Some(Withheld::LevelChange | Withheld::Temperature));
        let minimum = |found| ParameterResult::of(found, conventions(sensor, Term::BiasInstability));
        Self {
            sensor,
            samples,
            fit: noise.fit.quality,
            white: parameter(Term::White).map(|white| ParameterResult { budget, ..white }),
            bias_instability: parameter(Term::BiasInstability),
            curve_minimum: noise.curve_minimum().map(minimum),
            rate_random_walk: parameter(Term::RateRandomWalk),
            rate_ramp: parameter(Term::RateRamp),
            quantization: parameter(Term::Quantization),
            likeliest: Some(&noise.fit.likeliest).filter(|_| !poses_as_noise).cloned(),
            correlation_samples: noise.fit.correlation_samples,
            withheld,
            long_taus: noise.long_taus,
            temperature: noise.temperature.as_ref().map(|found| TemperatureResult::of(found, sensor)),
            classical: noise.classical,
        }
    }

    /// A parameter in all its units: the one source of N, B, K, R and Q for every face, so that what
    /// is withheld is withheld everywhere. `None` for one that was not asked for.
    pub fn parameter_in_units(&self, term: Term) -> Option<&ParameterResult> {
        let found = match term {
            Term::White => &self.white,
            Term::BiasInstability => &self.bias_instability,
            Term::RateRandomWalk => &self.rate_random_walk,
            Term::RateRamp => &self.rate_ramp,
            Term::Quantization => &self.quantization,
        };
        found.as_ref()
    }

    /// The same parameter in SI units alone.
    pub fn parameter(&self, term: Term) -> Option<Parameter> {
        self.parameter_in_units(term).map(|found| found.parameter)
    }

    /// The minimum of the curve, in SI units; `None` if B was not asked for.
    pub fn curve_minimum(&self) -> Option<Parameter> {
        self.curve_minimum.as_ref().map(|found| found.parameter)
    }

    /// Why no averaging time of the curve shows the sensor as it is; `Ok` where each does.
    pub(super) fn of_sensor(&self) -> Result<(), Status> {
        match self.long_taus {
            // rounding hides N, and makes a curve of its own
            LongTauValidity::Sensor
                if self.parameter(Term::White).is_some_and(|white| white.status == Status::NotMeasurable) =>
            {
                Err(Status::NotMeasurable)
            }
            LongTauValidity::Sensor => Ok(()),
            LongTauValidity::Motion => Err(Status::Moved),
            LongTauValidity::Spoiled => Err(Status::ModelRejected),
            _ => Err(Status::NotMeasurable),
        }
    }

    /// What N is uncertain by; `None` without N.
    pub fn budget(&self) -> Option<&Budget> {
        self.white.as_ref()?.budget.as_ref()
    }

    /// N of the sensor itself, without what averaging and decimation on board add.
    pub fn unaliased_white(&self) -> Option<Parameter> {
        self.budget().map(|budget| budget.unaliased)
    }
}

impl ParameterResult {
    /// The SI unit comes first among `conventions`.
    fn of(parameter: Parameter, conventions: &[Convention]) -> Self {
        let unit = conventions.first().map_or("", |si| si.unit);
        Self { parameter, unit, conventions: in_other_units(&parameter, conventions), discrete: None, budget: None }
    }
}

/// A parameter in all units but the first; in none if nothing is known of it.
fn in_other_units(parameter: &Parameter, conventions: &[Convention]) -> Vec<InUnit> {
    let says_something = parameter.value.or(parameter.upper).is_some();
    let in_unit = |convention: &Convention| {
        let Parameter { value, lower, upper, .. } = parameter.scaled(convention.factor);
        InUnit { unit: convention.unit, sides: convention.sides, value, lower, upper }
    };
    conventions.iter().skip(1).filter(|_| says_something).map(in_unit).collect()
}

impl Discrete {
    fn of(found: &Parameter, sensor: Sensor, term: Term, rate_hz: f64) -> Option<Self> {
        let factor = match term {
            Term::White => rate_hz.sqrt(),
            Term::RateRandomWalk => 1.0 / rate_hz.sqrt(),
            Term::BiasInstability | Term::RateRamp | Term::Quantization => return None,
        };
        let Parameter { value, lower, upper, .. } = found.scaled(factor);
        // B has the unit of a sample
        let unit = si_unit(sensor, Term::BiasInstability);
        Some(Self { rate_hz, unit, value, lower, upper })
    }
}

impl TemperatureResult {
    fn of(temperature: &AxisTemperature, sensor: Sensor) -> Self {
        let (found, why) = (temperature.coefficient.ok(), temperature.coefficient.err());
        let parameter = match temperature.coefficient {
            Ok(found) => Parameter { p: Some(found.p), ..Parameter::estimated(found.value, found.lower, found.upper) },
            Err(NoCoefficient::BiasNotInStream) => Parameter::without_value(Status::NotMeasurable),
            Err(_) => Parameter::without_value(Status::NotObservable),
        };
        let conventions = temperature_conventions(sensor);
        Self {
            parameter,
            reason: why.map(NoCoefficient::code),
            unit: conventions.first().map_or("", |si| si.unit),
            conventions: in_other_units(&parameter, conventions),
            proved: temperature.is_proved,
            lag_s: found.map(|found| found.lag_s),
            lag_lower_s: found.map(|found| found.lag_range_s.0),
            lag_upper_s: found.map(|found| found.lag_range_s.1),
            lag_open: found.is_some_and(|found| found.is_lag_open),
            excursion_degc: temperature.excursion_c,
            correlation_with_time: temperature.correlation_with_time,
            from: if temperature.is_polled { "register" } else { "stream" },
            largest_share: found.filter(|_| temperature.is_proved).map(|found| found.largest_share),
            why,
        }
    }
}

impl Graded {
    pub(super) fn of(graded: Result<(Grade, Grade), NoGrade>) -> Self {
        let range = graded.ok();
        Self { best: range.map(|(best, _)| best), worst: range.map(|(_, worst)| worst), reason: graded.err() }
    }
}
