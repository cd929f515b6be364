//! The units in which noise parameters are published, and their factors from SI units. N² is the
//! two-sided power spectral density of the white noise, and N is what data sheets and Kalibr print.
//! A spectrum over positive frequencies only shows √2·N; [`Sides::One`] marks that.

use std::f64::consts::{PI, SQRT_2};

use serde::Deserialize;

use super::noise_model::Term;
use crate::accumulate::spectrum::Sides;

/// Standard gravity in m/s², by definition (3rd General Conference on Weights and Measures, 1901).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// What the channel measures, and so its SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensor {
    /// Angular rate in rad/s.
    Gyroscope,
    /// Specific force in m/s².
    Accelerometer,
    /// Magnetic flux density in gauss.
    Magnetometer,
}

/// A unit in which a parameter is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convention {
    /// The unit.
    pub unit: &'static str,
    /// Its value for a parameter of 1 in SI units.
    pub factor: f64,
    /// Of a density per √Hz, which sides it counts; `None` for any other unit.
    pub sides: Option<Sides>,
}

impl Convention {
    /// The same unit for an amplitude density over positive frequencies only: √2 times the number.
    pub const fn one_sided(self) -> Self {
        one_sided(self.unit, self.factor)
    }
}

/// All conventions for a parameter; the SI unit comes first.
pub const fn conventions(sensor: Sensor, parameter: Term) -> &'static [Convention] {
    use Sensor::{Accelerometer, Gyroscope, Magnetometer};
    use Term::{BiasInstability, Quantization, RateRamp, RateRandomWalk, White};
    match (sensor, parameter) {
        (Gyroscope, Quantization) => const { &[unit("rad", 1.0), unit("arcsec", DEG * HOUR_S), unit("urad", 1e6)] },
        (Gyroscope, White) => {
            const {
                &[
                    density("rad/s/sqrt(Hz)", 1.0),
                    one_sided("rad/s/sqrt(Hz)", 1.0),
                    density("deg/s/sqrt(Hz)", DEG),
                    one_sided("deg/s/sqrt(Hz)", DEG),
                    unit("deg/sqrt(h)", DEG * SQRT_HOUR),
                    density("deg/h/sqrt(Hz)", DEG * HOUR_S),
                ]
            }
        }
        (Gyroscope, BiasInstability) => {
            const { &[unit("rad/s", 1.0), unit("deg/s", DEG), unit("deg/h", DEG * HOUR_S)] }
        }
        (Gyroscope, RateRandomWalk) => {
            const { &[unit("rad/s/sqrt(s)", 1.0), unit("deg/s/sqrt(s)", DEG), unit("deg/h^1.5", DEG * HOUR_S * SQRT_HOUR)] }
        }
        (Gyroscope, RateRamp) => {
            const { &[unit("rad/s^2", 1.0), unit("deg/s^2", DEG), unit("deg/h^2", DEG * HOUR_S * HOUR_S)] }
        }
        (Accelerometer, Quantization) => const { &[unit("m/s", 1.0)] },
        (Accelerometer, White) => {
            const {
                &[
                    density("m/s^2/sqrt(Hz)", 1.0),
                    one_sided("m/s^2/sqrt(Hz)", 1.0),
                    unit("m/s/sqrt(h)", SQRT_HOUR),
                    density("mg/sqrt(Hz)", MG),
                    density("ug/sqrt(Hz)", 1e3 * MG),
                    one_sided("ug/sqrt(Hz)", 1e3 * MG),
                ]
            }
        }
        (Accelerometer, BiasInstability) => const { &[unit("m/s^2", 1.0), unit("mg", MG), unit("ug", 1e3 * MG)] },
        (Accelerometer, RateRandomWalk) => {
            const { &[unit("m/s^2/sqrt(s)", 1.0), unit("m/s/h^1.5", HOUR_S * SQRT_HOUR), unit("mg/sqrt(h)", MG * SQRT_HOUR)] }
        }
        (Accelerometer, RateRamp) => const { &[unit("m/s^3", 1.0), unit("mg/h", MG * HOUR_S)] },
        (Magnetometer, Quantization) => const { &[unit("gauss s", 1.0)] },
        (Magnetometer, White) => {
            const { &[density("gauss/sqrt(Hz)", 1.0), one_sided("gauss/sqrt(Hz)", 1.0), density("nT/sqrt(Hz)", 1e5)] }
        }
        (Magnetometer, BiasInstability) => const { &[unit("gauss", 1.0), unit("nT", 1e5)] },
        (Magnetometer, RateRandomWalk) => const { &[unit("gauss/sqrt(s)", 1.0)] },
        (Magnetometer, RateRamp) => const { &[unit("gauss/s", 1.0)] },
    }
}

/// The SI unit of a noise parameter.
pub const fn si_unit(sensor: Sensor, parameter: Term) -> &'static str {
    conventions(sensor, parameter)[0].unit
}

/// All conventions for the temperature coefficient of the bias; the SI unit comes first.
pub const fn temperature_conventions(sensor: Sensor) -> &'static [Convention] {
    match sensor {
        Sensor::Gyroscope => {
            const { &[unit("rad/s/degC", 1.0), unit("deg/s/degC", DEG), unit("deg/h/degC", DEG * HOUR_S)] }
        }
        Sensor::Accelerometer => const { &[unit("m/s^2/degC", 1.0), unit("mg/degC", MG)] },
        Sensor::Magnetometer => const { &[unit("gauss/degC", 1.0)] },
    }
}

const DEG: f64 = 180.0 / PI;
const HOUR_S: f64 = 3600.0;
const SQRT_HOUR: f64 = 60.0;
const MG: f64 = 1e3 / STANDARD_GRAVITY_M_S2;

const fn unit(unit: &'static str, factor: f64) -> Convention {
    Convention { unit, factor, sides: None }
}

const fn density(unit: &'static str, factor: f64) -> Convention {
    Convention { unit, factor, sides: Some(Sides::Two) }
}

const fn one_sided(unit: &'static str, factor: f64) -> Convention {
    Convention { unit, factor: SQRT_2 * factor, sides: Some(Sides::One) }
}

#[cfg(test)]
mod tests {
    use super::{
        Sensor::{Accelerometer, Gyroscope, Magnetometer},
        Term::{BiasInstability, Quantization, RateRamp, RateRandomWalk, White},
        *,
    };

    const SENSORS: [Sensor; 3] = [Gyroscope, Accelerometer, Magnetometer];

    #[test]
    fn factors_are_those_of_the_reference_works() {
        for (sensor, parameter, unit, sides, published) in [
            (Gyroscope, White, "deg/s/sqrt(Hz)", Some(Sides::Two), 57.29578),
            (Gyroscope, White, "deg/sqrt(h)", None, 3437.747),
            (Gyroscope, White, "deg/h/sqrt(Hz)", Some(Sides::Two), 206_264.8),
            (Gyroscope, White, "rad/s/sqrt(Hz)", Some(Sides::One), SQRT_2),
            (Gyroscope, BiasInstability, "deg/h", None, 206_264.806),
            (Gyroscope, RateRandomWalk, "deg/h^1.5", None, 1.23759e7),
            (Gyroscope, RateRamp, "deg/h^2", None, 57.29578 * 12_960_000.0),
            (Gyroscope, Quantization, "arcsec", None, 206_264.806),
            (Gyroscope, Quantization, "urad", None, 1e6),
            (Accelerometer, White, "ug/sqrt(Hz)", Some(Sides::Two), 101_971.621),
            (Accelerometer, White, "mg/sqrt(Hz)", Some(Sides::Two), 101.971_621),
            (Accelerometer, White, "m/s/sqrt(h)", None, 60.0),
            (Accelerometer, BiasInstability, "mg", None, 101.971_621),
            (Accelerometer, RateRandomWalk, "mg/sqrt(h)", None, 6118.297),
            (Accelerometer, RateRandomWalk, "m/s/h^1.5", None, 216_000.0),
            (Accelerometer, RateRamp, "mg/h", None, 367_097.8),
            (Magnetometer, White, "nT/sqrt(Hz)", Some(Sides::Two), 1e5),
        ] {
            let found = conventions(sensor, parameter)
                .iter()
                .find(|convention| convention.unit == unit && convention.sides == sides)
                .unwrap_or_else(|| panic!("{unit}, {sides:?}"));
            let off = found.factor / published - 1.0;
            assert!(off.abs() < 2e-6, "{unit}: {} instead of {published}", found.factor);
        }
    }

    #[test]
    fn the_si_unit_comes_first_and_no_unit_twice() {
        for sensor in SENSORS {
            for parameter in Term::ALL {
                let all = conventions(sensor, parameter);
                assert_eq!(all[0].factor, 1.0, "{sensor:?} {parameter:?}");
                for (index, convention) in all.iter().enumerate() {
                    let again = all[..index].iter().any(|c| (c.unit, c.sides) == (convention.unit, convention.sides));
                    assert!(!again, "{sensor:?} {parameter:?} {}", convention.unit);
                    let is_density = convention.unit.ends_with("/sqrt(Hz)");
                    assert_eq!(convention.sides.is_some(), is_density, "{}", convention.unit);
                }
            }
        }
    }
}
