//! The units one steps through with a key: for each sensor, units of N, B and K that are used
//! together.

use imu_noise::{Convention, Sensor, Sides, Term, conventions};

/// Places among the conventions of N, B and K. Deviations are in the unit of B.
type Together = [usize; 3];

/// Those of data sheets first. Each unit of N has its turn.
const GYRO: [Together; 6] = [[2, 1, 1], [4, 2, 2], [5, 2, 2], [0, 0, 0], [1, 0, 0], [3, 1, 1]];
const ACCEL: [Together; 6] = [[3, 1, 2], [4, 2, 2], [5, 2, 2], [2, 0, 1], [0, 0, 0], [1, 0, 0]];
const MAG: [Together; 3] = [[0, 0, 0], [2, 1, 0], [1, 0, 0]];

/// The unit of a parameter after so many steps.
pub(crate) fn convention(sensor: Sensor, term: Term, steps: usize) -> Convention {
    let all: &[Together] = match sensor {
        Sensor::Gyroscope => &GYRO,
        Sensor::Accelerometer => &ACCEL,
        Sensor::Magnetometer => &MAG,
    };
    let [white, bias, walk] = all[steps % all.len()];
    let known = conventions(sensor, term);
    known[match term {
        Term::White => white,
        Term::BiasInstability => bias,
        Term::RateRandomWalk => walk,
        Term::Quantization | Term::RateRamp => 0,
    }]
}

/// The unit with signs for what ASCII spells out; one-sided densities are marked.
pub(crate) fn written(convention: Convention) -> String {
    let unit = convention.unit.replace("sqrt(", "√").replace(')', "").replace("^2", "²");
    if convention.sides == Some(Sides::One) { format!("{unit} one-sided") } else { unit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_unit_has_its_turn() {
        for (sensor, turns) in [(Sensor::Gyroscope, 6), (Sensor::Accelerometer, 6), (Sensor::Magnetometer, 3)] {
            for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
                let seen: BTreeSet<_> = (0..turns).map(|steps| written(convention(sensor, term, steps))).collect();
                let all: BTreeSet<_> = conventions(sensor, term).iter().map(|known| written(*known)).collect();
                assert_eq!(seen, all, "{sensor:?} {term:?}");
                assert_eq!(convention(sensor, term, turns), convention(sensor, term, 0));
            }
        }
    }

    #[test]
    fn units_shown_together_belong_together() {
        for steps in 0..6 {
            let [n, b, k] = [Term::White, Term::BiasInstability, Term::RateRandomWalk]
                .map(|term| convention(Sensor::Gyroscope, term, steps).unit);
            let angle = |unit: &str| unit.split('/').next().unwrap_or_default().to_owned();
            assert!(angle(n) == angle(b) && angle(b) == angle(k), "{n} {b} {k}");
        }
    }
}
