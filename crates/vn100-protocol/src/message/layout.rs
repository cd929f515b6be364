//! What a message holds, as data: its channels, their units and their decimals.

use alloc::borrow::Cow;

/// A measuring message: its name and its channels in the order of the wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// The header of the sentence, without the `$`.
    pub message: Cow<'static, str>,
    /// Whether the sensor's attitude filter has had its hand in the values: user calibration
    /// applied, and the estimated bias taken off the angular rates.
    pub compensated: bool,
    /// The channels.
    pub channels: Cow<'static, [Channel]>,
}

/// One number of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name, unique within the message.
    pub name: Cow<'static, str>,
    /// What it measures.
    pub quantity: Quantity,
    /// The unit of its value.
    pub unit: Cow<'static, str>,
    /// The digits behind the point: a count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// Units in one of the numbers as printed: 1 for the sensor's own messages, another factor for
    /// a file in other units.
    pub scale: f64,
    /// The largest magnitude a count may have; beyond it the line is damaged.
    pub limit_counts: i32,
}

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Yaw, pitch or roll: the attitude of the body against north, east, down, as Euler angles in
    /// the order 3-2-1.
    Angle,
    /// The magnetic flux density along an axis of the body.
    MagneticField,
    /// The specific force along an axis of the body: at rest and level, z reads about -9.8 m/s².
    Acceleration,
    /// The angular rate about an axis of the body.
    AngularRate,
    /// The temperature inside the sensor.
    Temperature,
    /// The air pressure.
    Pressure,
}

impl Channel {
    /// The value of `count` in [`unit`](Self::unit): with a scale of 1 the float nearest to the
    /// printed decimal, for up to 22 decimals.
    #[must_use]
    pub fn value(&self, count: i32) -> f64 {
        let counts_per_unit = (0..self.decimals).fold(1.0, |power, _| power * 10.0);
        f64::from(count) / counts_per_unit * self.scale
    }
}

/// The rates in hertz at which the sensor sends a message, as register 7 takes them.
pub const OUTPUT_RATES_HZ: [u32; 11] = [1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200];

/// `$VNYMR`: attitude, and the compensated magnetic field, acceleration and angular rate.
pub static VNYMR: Layout =
    Layout { message: Cow::Borrowed("VNYMR"), compensated: true, channels: Cow::Borrowed(&YMR_CHANNELS) };

/// `$VNIMU`: the uncompensated magnetic field, acceleration and angular rate, with temperature and
/// pressure.
pub static VNIMU: Layout =
    Layout { message: Cow::Borrowed("VNIMU"), compensated: false, channels: Cow::Borrowed(&IMU_CHANNELS) };

pub(crate) static YMR_CHANNELS: [Channel; 12] = [
    angle("yaw"),
    angle("pitch"),
    angle("roll"),
    magnetic_field("mag_x"),
    magnetic_field("mag_y"),
    magnetic_field("mag_z"),
    acceleration("accel_x"),
    acceleration("accel_y"),
    acceleration("accel_z"),
    angular_rate("gyro_x"),
    angular_rate("gyro_y"),
    angular_rate("gyro_z"),
];

pub(crate) static IMU_CHANNELS: [Channel; 11] = [
    magnetic_field("mag_x"),
    magnetic_field("mag_y"),
    magnetic_field("mag_z"),
    acceleration("accel_x"),
    acceleration("accel_y"),
    acceleration("accel_z"),
    angular_rate("gyro_x"),
    angular_rate("gyro_y"),
    angular_rate("gyro_z"),
    channel("temperature", Quantity::Temperature, "degC", 1, 200),
    channel("pressure", Quantity::Pressure, "kPa", 3, 200),
];

const fn angle(name: &'static str) -> Channel {
    channel(name, Quantity::Angle, "deg", 3, 180)
}

const fn magnetic_field(name: &'static str) -> Channel {
    channel(name, Quantity::MagneticField, "gauss", 4, 10)
}

const fn acceleration(name: &'static str) -> Channel {
    channel(name, Quantity::Acceleration, "m/s^2", 3, 200)
}

const fn angular_rate(name: &'static str) -> Channel {
    channel(name, Quantity::AngularRate, "rad/s", 6, 40)
}

/// The limits are wider than any range the sensor is sold with: they are there to catch damage that
/// the checksum let through.
const fn channel(name: &'static str, quantity: Quantity, unit: &'static str, decimals: u8, limit: i32) -> Channel {
    let limit_counts = limit * 10_i32.pow(decimals as u32);
    Channel { name: Cow::Borrowed(name), quantity, unit: Cow::Borrowed(unit), decimals, scale: 1.0, limit_counts }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_the_nearest_floats() {
        for (channel, count, text) in
            [(0, -85_469, "-85.469"), (3, 4_403, "0.4403"), (9, -301, "-0.000301"), (9, 39_999_999, "39.999999")]
        {
            assert_eq!(VNYMR.channels[channel].value(count), text.parse().unwrap());
        }
    }

    #[test]
    fn names_are_unique() {
        for layout in [&VNYMR, &VNIMU] {
            let mut names: Vec<_> = layout.channels.iter().map(|channel| &channel.name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), layout.channels.len());
        }
    }

    #[test]
    fn limits_are_in_counts() {
        let limits: Vec<_> = VNYMR.channels.iter().map(|channel| channel.limit_counts).collect();
        assert_eq!(limits[2..=9], [180_000, 100_000, 100_000, 100_000, 200_000, 200_000, 200_000, 40_000_000]);
        assert_eq!((VNIMU.channels[9].limit_counts, VNIMU.channels[10].limit_counts), (2_000, 200_000));
    }
}
