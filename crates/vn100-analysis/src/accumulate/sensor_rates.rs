//! The rates at which the sensor can send.

use vn100_protocol::{BINARY, Layout, MESSAGES, OUTPUT_RATES_HZ};

/// The sensor's output rates in hertz.
static OUTPUT_RATES: [f64; OUTPUT_RATES_HZ.len()] = {
    let mut rates = [0.0; OUTPUT_RATES_HZ.len()];
    let mut index = 0;
    while index < rates.len() {
        rates[index] = OUTPUT_RATES_HZ[index] as f64;
        index += 1;
    }
    rates
};

/// The rates of its binary outputs that give a whole number of packets a second, in hertz.
static PACKET_RATES: [f64; 18] =
    [800.0, 400.0, 200.0, 160.0, 100.0, 80.0, 50.0, 40.0, 32.0, 25.0, 20.0, 16.0, 10.0, 8.0, 5.0, 4.0, 2.0, 1.0];

/// The rates of the sensor that sends this message, in hertz; none for the columns of a table,
/// which may be those of any sensor.
pub(crate) fn rates_hz(layout: Option<&Layout>) -> &'static [f64] {
    let is_sentence = layout.is_some_and(|layout| MESSAGES.iter().any(|output| output.message == layout.message));
    match layout {
        Some(layout) if layout.message == BINARY => &PACKET_RATES,
        _ if is_sentence => &OUTPUT_RATES,
        _ => &[],
    }
}
