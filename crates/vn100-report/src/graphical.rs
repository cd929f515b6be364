//! The results of the graphical slope method, in the words and units of laboratories.

use vn100_analysis::noise::{NotRead, Sensor, Term};

use crate::names::in_unit;

/// The parameters that the graphical slope method reads, and the rule by which it reads each.
pub const GRAPHICAL: [(Term, &str); 3] = [
    (Term::White, "slope −½ at τ = 1 s"),
    (Term::BiasInstability, "minimum / 0.664"),
    (Term::RateRandomWalk, "slope +½ at τ = 3 s"),
];

/// The unit in which laboratories report what they read off a curve, and how many of these units
/// are one SI unit; `None` for what they do not report.
#[must_use]
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

/// Why the graphical slope method gives no value of that parameter, in words.
#[must_use]
pub fn not_read(term: Term, why: NotRead) -> &'static str {
    match (why, term) {
        (NotRead::NoSlope, Term::White) => "not read: no slope −½ region",
        (NotRead::NoSlope, _) => "not read: no slope +½ region",
        (NotRead::NoMinimum, _) => "not read: no minimum within the curve",
        (NotRead::OutsideCurve, Term::White) => "not read: τ = 1 s lies outside the curve",
        (NotRead::OutsideCurve, _) => "not read: τ = 3 s lies outside the curve",
        (NotRead::NotApplicable, _) => "not read: no Allan deviation at rest",
    }
}

/// The same as a code of documents.
pub(crate) const fn not_read_code(why: NotRead) -> &'static str {
    match why {
        NotRead::NoSlope => "no-slope",
        NotRead::NoMinimum => "no-minimum",
        NotRead::OutsideCurve => "outside-curve",
        NotRead::NotApplicable => "not-applicable",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_of_gyroscope_and_accelerometer_has_a_unit_of_laboratories() {
        for (term, _) in GRAPHICAL {
            assert!(laboratory_unit(Sensor::Gyroscope, term).is_some_and(|(unit, _)| unit.starts_with("deg")));
            assert!(laboratory_unit(Sensor::Accelerometer, term).is_some_and(|(_, factor)| factor != 1.0));
            assert_eq!(laboratory_unit(Sensor::Magnetometer, term), None);
        }
    }
}
