//! The rates a stream can have, by what it carries.

use vn100_protocol::{Layout, MESSAGES, OUTPUT_RATES_HZ};

/// Those of a sensor of this make, in hertz.
static OUTPUT_RATES: [f64; OUTPUT_RATES_HZ.len()] = {
    let mut rates = [0.0; OUTPUT_RATES_HZ.len()];
    let mut index = 0;
    while index < rates.len() {
        rates[index] = OUTPUT_RATES_HZ[index] as f64;
        index += 1;
    }
    rates
};

/// The rates in hertz of the sensor that sends this message; none for columns that may come from
/// any sensor.
pub(crate) fn rates_hz(layout: Option<&Layout>) -> &'static [f64] {
    let is_output = layout.is_some_and(|layout| MESSAGES.iter().any(|output| output.message == layout.message));
    if is_output { &OUTPUT_RATES } else { &[] }
}
