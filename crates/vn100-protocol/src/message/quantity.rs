//! The quantities of messages, one row each: units and limits, and the size of a count in sentences
//! and in packets, which contain floats.

use alloc::borrow::Cow;

use super::layout::{Channel, Quantity};

/// The form in which a sensor sends a quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuantityRow {
    quantity: Quantity,
    unit: &'static str,
    /// The largest magnitude in units: wider than any range of the sensor, to detect damage that
    /// passed the checksum.
    limit: i32,
    /// A count of sentences is 10^-`decimals` units.
    decimals: u8,
    /// A count of packets is 2^-`bits` units.
    bits: u8,
    /// The rate of new values in packets, if packets may repeat a value.
    refresh_hz: Option<u32>,
}

pub(crate) const fn row(quantity: Quantity, unit: &'static str, limit: i32, decimals: u8, bits: u8) -> QuantityRow {
    assert!((limit as i64) << bits <= i32::MAX as i64);
    // the magnetometer as in the VN-100 User Manual; the others as repeated by a real sensor
    let refresh_hz = match quantity {
        Quantity::MagneticField => Some(250),
        Quantity::Temperature | Quantity::Pressure => Some(120),
        _ => None,
    };
    QuantityRow { quantity, unit, limit, decimals, bits, refresh_hz }
}

/// A whole turn of an angle is a whole number of counts, in packets as well.
pub(crate) const ANGLE: QuantityRow = row(Quantity::Angle, "deg", 180, 3, 21);
pub(crate) const ELEMENT: QuantityRow = row(Quantity::Quaternion, "1", 2, 6, 29);
pub(crate) const MAGNETIC_FIELD: QuantityRow = row(Quantity::MagneticField, "gauss", 10, 4, 27);
pub(crate) const ACCELERATION: QuantityRow = row(Quantity::Acceleration, "m/s^2", 200, 3, 23);
pub(crate) const ANGULAR_RATE: QuantityRow = row(Quantity::AngularRate, "rad/s", 40, 6, 25);
pub(crate) const TEMPERATURE: QuantityRow = row(Quantity::Temperature, "degC", 200, 1, 23);
pub(crate) const PRESSURE: QuantityRow = row(Quantity::Pressure, "kPa", 200, 3, 23);

impl QuantityRow {
    /// A channel of printed numbers.
    pub(crate) const fn decimal(self, name: &'static str) -> Channel {
        let Self { quantity, unit, limit, decimals, .. } = self;
        let (name, unit) = (Cow::Borrowed(name), Cow::Borrowed(unit));
        let limit_counts = limit * 10_i32.pow(decimals as u32);
        Channel {
            name,
            quantity,
            unit,
            decimals,
            scale: 1.0,
            zero_counts: 0,
            limit_counts,
            refresh_hz: None,
            increment_step: None,
        }
    }

    /// A channel of floats.
    pub(crate) const fn binary(self, name: &'static str) -> Channel {
        self.of_floats(name, None)
    }

    /// A channel of increments with this step, as means over their interval.
    pub(crate) const fn integrated(self, name: &'static str, increment_step: f64) -> Channel {
        self.of_floats(name, Some(increment_step))
    }

    const fn of_floats(self, name: &'static str, increment_step: Option<f64>) -> Channel {
        let Self { quantity, unit, limit, bits, refresh_hz, .. } = self;
        let (name, unit) = (Cow::Borrowed(name), Cow::Borrowed(unit));
        let scale = 1.0 / (1_u64 << bits) as f64;
        let limit_counts = limit << bits;
        Channel { name, quantity, unit, decimals: 0, scale, zero_counts: 0, limit_counts, refresh_hz, increment_step }
    }
}

/// The nearest integer, ties to even; for magnitudes below 2^31.
#[inline]
pub(crate) fn rounded(value: f64) -> i32 {
    // the sum is between 2^52 and 2^53, where the addition rounds in this way and the low bits are
    // the integer
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (value + SHIFT).to_bits() as i32
}
