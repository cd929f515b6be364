//! The temperature coefficient of the bias, for tables.

use vn100_analysis::noise::{Parameter, TemperatureCoefficient};
use vn100_analysis::{AxisTemperature, Detrend};

use crate::{codes::status_of_temperature, numbers::plain::short};

/// The temperature coefficient in the form of the other parameters of an axis, in the unit of the
/// channel per °C.
#[must_use]
pub fn coefficient_parameter(temperature: &AxisTemperature) -> Parameter {
    let found = temperature.coefficient.ok();
    Parameter {
        value: found.map(|found| found.value),
        lower: found.map(|found| found.lower),
        upper: found.map(|found| found.upper),
        p: found.map(|found| found.p),
        ..Parameter::without_value(status_of_temperature(temperature))
    }
}

/// The most likely lag and its range, in seconds, as text.
#[must_use]
pub fn lag_text(found: &TemperatureCoefficient) -> String {
    let seconds = |lag_s: f64| short(if lag_s < 10.0 { (10.0 * lag_s).round() / 10.0 } else { lag_s.round() });
    format!("{} ({} to {})", seconds(found.lag_s), seconds(found.lag_range_s.0), seconds(found.lag_range_s.1))
}

/// The largest share of the temperature in the variance of an octave, in percent, as text; `None`
/// for a coefficient that is not significant.
#[must_use]
pub fn share_text(temperature: &AxisTemperature) -> Option<String> {
    let removed = if temperature.is_removed { ", removed" } else { "" };
    (!temperature.deviations.is_empty()).then(|| format!("{:.0}{removed}", 100.0 * temperature.largest_share()))
}

/// The name of a detrending method, in documents and options.
#[must_use]
pub const fn detrend_name(detrend: Detrend) -> &'static str {
    match detrend {
        Detrend::Line => "linear",
        Detrend::Temperature => "temperature",
    }
}
