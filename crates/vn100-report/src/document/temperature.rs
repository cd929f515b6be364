//! How the bias of one channel follows the temperature, as in the JSON document.

use serde::Serialize;
use vn100_analysis::noise::{Convention, Sensor, TemperatureCoefficient, temperature_conventions};
use vn100_analysis::{AxisTemperature, BeforeAndAfter};

use crate::codes::{code_of_no_coefficient, code_of_status, status_of_temperature};

/// The residual coefficient of the bias: what the sensor's own compensation leaves.
#[derive(Debug, Serialize)]
pub(crate) struct TemperatureDocument {
    status: &'static str,
    /// Why there is none, as a code and in words.
    reason: Option<&'static str>,
    text: Option<String>,
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
    unit: &'static str,
    /// The same in every other unit in use.
    conventions: Vec<InUnit>,
    /// Probability that noise without any influence of the temperature would show as much, the
    /// search for the lag allowed for; of this axis alone.
    p: Option<f64>,
    /// All axes together prove that this one follows the temperature.
    proved: bool,
    lag_s: Option<f64>,
    lag_lower_s: Option<f64>,
    lag_upper_s: Option<f64>,
    excursion_degc: Option<f64>,
    correlation_with_time: Option<f64>,
    /// Where the temperature comes from: `stream` or `register`.
    from: &'static str,
    /// The most that it has in the variance of an octave.
    largest_share: Option<f64>,
    /// If it is proved, the deviation of each octave.
    deviations: Vec<DeviationDocument>,
}

#[derive(Debug, Serialize)]
struct InUnit {
    unit: &'static str,
    value: f64,
    lower: f64,
    upper: f64,
}

#[derive(Debug, Serialize)]
struct DeviationDocument {
    m: u64,
    tau_s: f64,
    before: f64,
    after: f64,
}

impl TemperatureDocument {
    pub(crate) fn new(temperature: &AxisTemperature, sensor: Sensor, rate_hz: f64) -> Self {
        let found = temperature.coefficient.ok();
        let why = temperature.coefficient.err();
        let conventions = temperature_conventions(sensor);
        let in_unit = |TemperatureCoefficient { value, lower, upper, .. }: TemperatureCoefficient| {
            let of = move |convention: &Convention| InUnit {
                unit: convention.unit,
                value: value * convention.factor,
                lower: lower * convention.factor,
                upper: upper * convention.factor,
            };
            conventions.iter().skip(1).map(of).collect()
        };
        let deviation = |&BeforeAndAfter { m, before, after }: &BeforeAndAfter| DeviationDocument {
            m,
            tau_s: m as f64 / rate_hz,
            before,
            after,
        };
        Self {
            status: code_of_status(status_of_temperature(temperature)).code,
            reason: why.map(|why| code_of_no_coefficient(why).code),
            text: why.map(|why| why.to_string()),
            value: found.map(|found| found.value),
            lower: found.map(|found| found.lower),
            upper: found.map(|found| found.upper),
            unit: conventions.first().map_or("", |si| si.unit),
            conventions: found.map_or_else(Vec::new, in_unit),
            p: found.map(|found| found.p),
            proved: temperature.is_proved,
            lag_s: found.map(|found| found.lag_s),
            lag_lower_s: found.map(|found| found.lag_range_s.0),
            lag_upper_s: found.map(|found| found.lag_range_s.1),
            excursion_degc: temperature.excursion_c,
            correlation_with_time: temperature.correlation_with_time,
            from: if temperature.is_polled { "register" } else { "stream" },
            largest_share: (!temperature.deviations.is_empty()).then(|| temperature.largest_share()),
            deviations: temperature.deviations.iter().map(deviation).collect(),
        }
    }
}
