//! The sensors that have noise parameters, and the letters of the parameters.

use imu_noise::{Sensor, Term};
use vn100_protocol::{BINARY, Quantity};

/// The quantity of each sensor, and the sensor, in the order of results.
pub const SENSORS: [(Quantity, Sensor); 3] = [
    (Quantity::AngularRate, Sensor::Gyroscope),
    (Quantity::Acceleration, Sensor::Accelerometer),
    (Quantity::MagneticField, Sensor::Magnetometer),
];

/// The sensor of a quantity; `None` for a quantity without noise parameters.
pub fn sensor_of(quantity: Quantity) -> Option<Sensor> {
    SENSORS.into_iter().find(|(measured, _)| *measured == quantity).map(|(_, sensor)| sensor)
}

/// The name of a sensor in a sentence, such as `gyroscope`.
pub fn sensor_name(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Gyroscope => "gyroscope",
        Sensor::Accelerometer => "accelerometer",
        Sensor::Magnetometer => "magnetometer",
    }
}

/// The name of all axes of a sensor together, with which those of its channels begin.
pub fn axes_name(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Gyroscope => "gyro",
        Sensor::Accelerometer => "accel",
        Sensor::Magnetometer => "mag",
    }
}

/// The letter of a parameter: N, B, K, R or Q.
pub fn letter(term: Term) -> &'static str {
    match term {
        Term::White => "N",
        Term::BiasInstability => "B",
        Term::RateRandomWalk => "K",
        Term::RateRamp => "R",
        Term::Quantization => "Q",
    }
}

/// The message with uncompensated rates for this one: packets, or the sentence `VNIMU`.
pub fn uncompensated_message(message: &str) -> &'static str {
    if message == BINARY { BINARY } else { "VNIMU" }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::VNIMU;

    use super::*;

    #[test]
    fn every_axis_bears_the_name_of_its_sensor() {
        let axes = VNIMU.channels.iter().filter_map(|channel| Some((channel, sensor_of(channel.quantity)?)));
        assert_eq!(axes.clone().count(), 9);
        for (channel, sensor) in axes {
            assert!(channel.name.starts_with(axes_name(sensor)), "{}", channel.name);
            assert!(sensor_name(sensor).starts_with(axes_name(sensor)));
        }
        assert_eq!([Quantity::Angle, Quantity::Temperature, Quantity::Pressure].map(sensor_of), [None; 3]);
    }
}
