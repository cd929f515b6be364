//! The units in which faces show numbers.

use vn100_analysis::noise::{Sensor, Term, conventions};

/// A unit as people write it: `rad/s/sqrt(Hz)` as `rad/s/√Hz`, `m/s^2` as `m/s²`, `deg/h^1.5` as
/// `°/h/√h`.
pub fn pretty_unit(unit: &str) -> String {
    let unit = match unit.strip_prefix('u') {
        Some(rest) if rest.starts_with("g/") || rest == "g" || rest == "rad" => format!("µ{rest}"),
        _ => unit.to_owned(),
    };
    let written = [
        ("sqrt(Hz)", "√Hz"),
        ("sqrt(h)", "√h"),
        ("sqrt(s)", "√s"),
        ("/h^1.5", "/h/√h"),
        ("^2", "²"),
        ("^3", "³"),
        ("deg", "°"),
    ];
    written.into_iter().fold(unit, |unit, (plain, pretty)| unit.replace(plain, pretty))
}

/// The unit with this name of a parameter of a sensor, and how many of these units are one SI unit;
/// the SI unit and 1 if the parameter is not given in such a unit.
pub fn in_unit(sensor: Sensor, term: Term, unit: &str) -> (&'static str, f64) {
    let all = conventions(sensor, term);
    let convention = all.iter().find(|convention| convention.unit == unit).or(all.first());
    convention.map_or(("", 1.0), |convention| (convention.unit, convention.factor))
}

/// The unit of a parameter in summaries, close to that of data sheets, and how many of these units
/// are one SI unit.
pub fn parameter_unit(sensor: Sensor, term: Term) -> (&'static str, f64) {
    const DEG: f64 = 180.0 / std::f64::consts::PI;
    const MG: f64 = 1e3 / vn100_analysis::noise::STANDARD_GRAVITY_M_S2;
    match (sensor, term) {
        (Sensor::Gyroscope, Term::White) => ("deg/√h", 60.0 * DEG),
        (Sensor::Gyroscope, Term::BiasInstability) => ("deg/h", 3600.0 * DEG),
        (Sensor::Gyroscope, Term::RateRandomWalk) => ("deg/h/√h", 3600.0 * 60.0 * DEG),
        (Sensor::Gyroscope, Term::RateRamp) => ("deg/h²", 3600.0 * 3600.0 * DEG),
        (Sensor::Gyroscope, Term::Quantization) => ("arcsec", 3600.0 * DEG),
        (Sensor::Accelerometer, Term::White) => ("mg/√Hz", MG),
        (Sensor::Accelerometer, Term::BiasInstability) => ("mg", MG),
        (Sensor::Accelerometer, Term::RateRandomWalk) => ("mg/√h", 60.0 * MG),
        (Sensor::Accelerometer, Term::RateRamp) => ("mg/h", 3600.0 * MG),
        (Sensor::Accelerometer, Term::Quantization) => ("m/s", 1.0),
        (Sensor::Magnetometer, Term::White) => ("mG/√Hz", 1e3),
        (Sensor::Magnetometer, Term::BiasInstability) => ("mG", 1e3),
        (Sensor::Magnetometer, Term::RateRandomWalk) => ("mG/√h", 60e3),
        (Sensor::Magnetometer, Term::RateRamp) => ("mG/h", 3600e3),
        (Sensor::Magnetometer, Term::Quantization) => ("mG s", 1e3),
    }
}

/// The unit in which laboratories report a reading, and how many of these are one SI unit.
pub fn laboratory_unit(sensor: Sensor, term: Term) -> Option<(&'static str, f64)> {
    let unit = match (sensor, term) {
        (Sensor::Gyroscope, Term::White) => "deg/sqrt(h)",
        (Sensor::Gyroscope, Term::BiasInstability) => "deg/h",
        (Sensor::Gyroscope, Term::RateRandomWalk) => "deg/h^1.5",
        (Sensor::Accelerometer, Term::White) => "m/s/sqrt(h)",
        (Sensor::Accelerometer, Term::BiasInstability) => "mg",
        (Sensor::Accelerometer, Term::RateRandomWalk) => "m/s/h^1.5",
        _ => return None,
    };
    Some(in_unit(sensor, term, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_written_as_people_do() {
        for (unit, pretty) in [
            ("rad/s/sqrt(Hz)", "rad/s/√Hz"),
            ("m/s^2", "m/s²"),
            ("deg/h^1.5", "°/h/√h"),
            ("m/s/h^1.5", "m/s/h/√h"),
            ("ug/sqrt(Hz)", "µg/√Hz"),
            ("gauss", "gauss"),
            ("urad", "µrad"),
        ] {
            assert_eq!(pretty_unit(unit), pretty);
        }
    }

    #[test]
    fn graphical_readings_of_gyroscope_and_accelerometer_have_a_unit_of_laboratories() {
        for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
            assert!(laboratory_unit(Sensor::Gyroscope, term).is_some_and(|(unit, _)| unit.starts_with("deg")));
            assert!(laboratory_unit(Sensor::Accelerometer, term).is_some_and(|(_, factor)| factor != 1.0));
            assert_eq!(laboratory_unit(Sensor::Magnetometer, term), None);
        }
    }
}
