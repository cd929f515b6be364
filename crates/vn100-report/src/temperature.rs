//! The temperature coefficient of the bias, for tables.

use vn100_analysis::AxisTemperature;
use vn100_analysis::noise::Parameter;

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

/// The most likely lag and its range, in seconds, as text; `None` if the record does not show
/// it: without a significant coefficient, or where the range reaches the longest lag searched.
#[must_use]
pub fn lag_text(temperature: &AxisTemperature) -> Option<String> {
    let found = temperature.coefficient.ok().filter(|found| temperature.is_proved && !found.is_lag_open)?;
    let seconds = |lag_s: f64| short(if lag_s < 10.0 { (10.0 * lag_s).round() / 10.0 } else { lag_s.round() });
    let (from_s, to_s) = found.lag_range_s;
    Some(format!("{} ({} to {})", seconds(found.lag_s), seconds(from_s), seconds(to_s)))
}

/// The largest share of the temperature in the variance of an octave, in percent, as text; `None`
/// for a coefficient that is not significant.
#[must_use]
pub fn share_text(temperature: &AxisTemperature) -> Option<String> {
    (!temperature.deviations.is_empty()).then(|| format!("{:.0}", 100.0 * temperature.largest_share()))
}

#[cfg(test)]
mod tests {
    use vn100_analysis::noise::TemperatureCoefficient;

    use super::*;

    #[test]
    fn a_lag_that_the_record_does_not_show_is_not_printed() {
        let of = |is_proved, is_lag_open| {
            let (lag_s, lag_range_s) = (22.0, (3.04, 48.0));
            let found =
                TemperatureCoefficient { value: 1.0, lower: 0.5, upper: 1.5, lag_s, lag_range_s, is_lag_open, p: 1e-4 };
            lag_text(&AxisTemperature {
                excursion_c: Some(3.0),
                correlation_with_time: Some(0.1),
                is_polled: false,
                coefficient: Ok(found),
                is_proved,
                deviations: Vec::new(),
            })
        };
        assert_eq!(of(true, false).as_deref(), Some("22 (3 to 48)"));
        assert_eq!([of(false, false), of(true, true)], [None, None]);
    }
}
