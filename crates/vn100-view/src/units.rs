//! The units that one steps through: one for a sensor on all panels, with those of N, B and K that
//! belong to it.

use imu_noise::{Convention, Sensor, Sides, Term, conventions};
use vn100_analysis::{ChannelResult, sensor_of};
use vn100_report::units::parameter_unit;

/// How the values and deviations of a channel are shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ShownUnit {
    pub(crate) name: String,
    /// One of the channel's own unit in this one.
    pub(crate) factor: f64,
    /// That resolve a sample.
    pub(crate) decimals: usize,
}

impl ShownUnit {
    /// After so many steps.
    pub(crate) fn of(channel: &ChannelResult, steps: usize) -> Self {
        let Some(sensor) = sensor_of(channel.quantity) else {
            return Self { name: channel.unit.clone(), factor: 1.0, decimals: channel.decimals };
        };
        let unit = convention(sensor, Term::BiasInstability, steps);
        let decimals = (channel.decimals as f64 - unit.factor.log10()).ceil().max(0.0) as usize;
        Self { name: shown_unit(unit), factor: unit.factor, decimals }
    }
}

/// Places among the conventions of N, B and K. Deviations are in the unit of B.
type Together = [usize; 3];

/// Those that follow the units of the summary; of the SI third. Each unit of N has its turn.
const GYRO: [Together; 5] = [[2, 1, 1], [5, 2, 2], [0, 0, 0], [1, 0, 0], [3, 1, 1]];
const ACCEL: [Together; 5] = [[4, 2, 2], [5, 2, 2], [0, 0, 0], [2, 0, 1], [1, 0, 0]];
const MAG: [Together; 3] = [[0, 0, 0], [2, 1, 0], [1, 0, 0]];

/// The unit of a parameter after so many steps, from that of the summary on.
pub(crate) fn convention(sensor: Sensor, term: Term, steps: usize) -> Convention {
    let others: &[Together] = match sensor {
        Sensor::Gyroscope => &GYRO,
        Sensor::Accelerometer => &ACCEL,
        Sensor::Magnetometer => &MAG,
    };
    let known = conventions(sensor, term);
    let Some(step) = (steps % (others.len() + 1)).checked_sub(1) else {
        let (unit, factor) = parameter_unit(sensor, term);
        return Convention { unit, factor, sides: None };
    };
    let [white, bias, walk] = others[step];
    known[match term {
        Term::White => white,
        Term::BiasInstability => bias,
        Term::RateRandomWalk => walk,
        Term::Quantization | Term::RateRamp => 0,
    }]
}

/// The unit with signs for what ASCII spells out; one-sided densities are marked.
pub(crate) fn shown_unit(convention: Convention) -> String {
    let unit = convention.unit.replace("/h^1.5", "/h/√h").replace("sqrt(", "√").replace(')', "").replace("^2", "²");
    if convention.sides == Some(Sides::One) { format!("{unit} one-sided") } else { unit }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_units_of_the_summary_come_first_and_every_other_has_its_turn() {
        for (sensor, turns) in [(Sensor::Gyroscope, 6), (Sensor::Accelerometer, 6), (Sensor::Magnetometer, 4)] {
            for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
                let (first, factor) = parameter_unit(sensor, term);
                let begin = convention(sensor, term, 0);
                assert_eq!((begin.unit, begin.factor), (first, factor), "{sensor:?} {term:?}");
                let seen: BTreeSet<_> = (0..turns).map(|steps| shown_unit(convention(sensor, term, steps))).collect();
                let known = conventions(sensor, term).iter().map(|known| shown_unit(*known));
                let all: BTreeSet<_> = known.chain([first.to_owned()]).collect();
                assert_eq!(seen, all, "{sensor:?} {term:?}");
                assert_eq!(convention(sensor, term, turns), begin);
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
