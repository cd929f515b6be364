//! What a record shall show, as users say it: `gyro N ±5%`, `gyro B`, `gyro K >= 2e-7`.

use std::{fmt, str::FromStr};

use imu_noise::{Sensor, Sides, Term, conventions};
use thiserror::Error;

use crate::{
    noise_figure::{NoiseFigure, NoiseFigureError, in_percent, share_of_percent},
    sensor::sensor_of,
};

/// A figure, and how well it shall be known.
#[derive(Debug, Clone, PartialEq)]
pub struct Want {
    /// Which figure.
    pub figure: NoiseFigure,
    /// Of which sensor.
    pub sensor: Sensor,
    /// How well.
    pub known: Known,
}

/// How well a figure shall be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// It is seen, at the size that is typical.
    Seen,
    /// Half the width of its interval over the value is so much at most.
    Within(f64),
    /// It is seen if it is so large, in SI units.
    AtLeast(f64),
}

/// A text is no want, or one that no record meets.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WantError {
    /// There is no sign between a figure and what follows.
    #[error(
        "{0:?} is no want: a figure and how well it shall be known, as in \"gyro N ±5%\", or how small it shall be seen, as in \"gyro K >= 2e-7\""
    )]
    Form(String),
    /// The figure is none.
    #[error(transparent)]
    NoiseFigure(#[from] NoiseFigureError),
    /// The part behind `±` is no percentage above 0.
    #[error("{0:?} is no percentage above 0, as in \"5%\"")]
    Percent(String),
    /// The part behind `>=` is no number above 0.
    #[error("{0:?} is no number above 0, with a unit if it is not SI, as in \"2e-7\" or \"0.5 deg/h^1.5\"")]
    Number(String),
    /// The parameter is not stated in that unit.
    #[error("{figure} is not stated in {unit:?}: {units}")]
    Unit {
        /// The figure.
        figure: String,
        /// The unit given.
        unit: String,
        /// Those in use.
        units: String,
    },
    /// N is always there.
    #[error("say how well {0} shall be known, as in \"{0} ±5%\"")]
    White(String),
    /// No typical random walk is known.
    #[error("say how small a walk shall be seen, as in \"{0} >= 2e-7\": no typical figure is known")]
    Walk(String),
}

impl FromStr for Want {
    type Err = WantError;

    fn from_str(text: &str) -> Result<Self, WantError> {
        // not every keyboard has the signs
        let split_at = |signs: [&str; 2]| signs.iter().find_map(|sign| text.split_once(sign));
        let (figure, known) = if let Some((figure, percent)) = split_at(["±", "+-"]) {
            let share = share_of_percent(percent).ok_or_else(|| WantError::Percent(text.into()))?;
            (figure, Asked::Within(share))
        } else if let Some((figure, amount)) = split_at([">=", "≥"]) {
            (figure, Asked::AtLeast(amount.trim()))
        } else {
            (text, Asked::Seen)
        };
        let figure: NoiseFigure = figure.parse().map_err(|error| match begins_with_figure(figure) {
            true => WantError::Form(text.into()),
            false => WantError::NoiseFigure(error),
        })?;
        let sensor = sensor(&figure).ok_or_else(|| NoiseFigureError::Channel(figure.to_string()))?;
        let name = || figure.to_string();
        let known = match (figure.term, known) {
            (_, Asked::Within(relative)) if figure.term != Term::RateRandomWalk => Known::Within(relative),
            (Term::BiasInstability, Asked::Seen) => Known::Seen,
            (Term::BiasInstability | Term::RateRandomWalk, Asked::AtLeast(amount)) => {
                Known::AtLeast(in_si(amount, &figure, sensor)?)
            }
            (Term::RateRandomWalk, _) => return Err(WantError::Walk(name())),
            _ => return Err(WantError::White(name())),
        };
        Ok(Self { figure, sensor, known })
    }
}

enum Asked<'a> {
    Seen,
    Within(f64),
    AtLeast(&'a str),
}

/// Whether more follows a figure.
fn begins_with_figure(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let figure = words.by_ref().take(2).collect::<Vec<_>>().join(" ");
    words.next().is_some() && figure.parse::<NoiseFigure>().is_ok()
}

fn sensor(figure: &NoiseFigure) -> Option<Sensor> {
    sensor_of(figure.quantity()?)
}

/// A number with one of the units in use, or none for SI.
fn in_si(amount: &str, figure: &NoiseFigure, sensor: Sensor) -> Result<f64, WantError> {
    let (number, unit) = amount.split_once(char::is_whitespace).unwrap_or((amount, ""));
    let number = number.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    let number = number.ok_or_else(|| WantError::Number(amount.into()))?;
    let known = || conventions(sensor, figure.term).iter().filter(|convention| convention.sides != Some(Sides::One));
    let unit = unit.trim();
    if unit.is_empty() {
        return Ok(number);
    }
    match known().find(|convention| convention.unit == unit) {
        Some(convention) => Ok(number / convention.factor),
        None => Err(WantError::Unit {
            figure: figure.to_string(),
            unit: unit.into(),
            units: known().map(|convention| convention.unit).collect::<Vec<_>>().join(", "),
        }),
    }
}

impl fmt::Display for Want {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.known {
            Known::Seen => write!(f, "{}", self.figure),
            Known::Within(relative) => write!(f, "{} ±{} %", self.figure, in_percent(relative)),
            Known::AtLeast(value) => {
                let unit = conventions(self.sensor, self.figure.term).first().map_or("", |si| si.unit);
                // rounded, without the zeros behind
                let digits = format!("{value:.3e}").parse().unwrap_or(value);
                write!(f, "{} >= {digits:e} {unit}", self.figure)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wants_are_read_in_every_spelling() {
        for (text, printed) in [
            ("gyro N ±5%", "gyro N ±5 %"),
            ("gyro_x n +-5", "gyro_x N ±5 %"),
            ("gyro N ±7%", "gyro N ±7 %"),
            ("gyro N ±0.0001%", "gyro N ±0.0001 %"),
            ("gyro B", "gyro B"),
            ("accel B ± 20 %", "accel B ±20 %"),
            ("gyro K >= 2e-7", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro K≥2e-7", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro K >= 2.475178 deg/h^1.5", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro B >= 5 deg/h", "gyro B >= 2.424e-5 rad/s"),
            ("accel B >= 0.04 mg", "accel B >= 3.923e-4 m/s^2"),
            ("mag N ±10%", "mag N ±10 %"),
        ] {
            let want: Want = text.parse().unwrap();
            assert_eq!(want.to_string(), printed, "{text}");
            assert_eq!(printed.parse::<Want>().unwrap().to_string(), printed);
        }
    }

    #[test]
    fn what_is_no_want_names_what_one_is() {
        for (text, expected) in [
            ("gyro N", "\"gyro N ±5%\""),
            ("gyro N >= 1e-5", "\"gyro N ±5%\""),
            ("gyro K", "gyro K >= 2e-7"),
            ("gyro K ±5%", "gyro K >= 2e-7"),
            ("gyro R", "N, B or K"),
            ("gyro N 2%", "\"gyro N 2%\" is no want: a figure and how well it shall be known, as in \"gyro N ±5%\""),
            ("gyro N 2 %", "\"gyro N ±5%\""),
            ("gyro K 2e-7", "\"gyro K >= 2e-7\""),
            ("gyro R 2%", "N, B or K"),
            ("gyro B ±0%", "percentage above 0"),
            ("gyro K >= -1", "number above 0"),
            ("gyro K >= 1 deg/h", "deg/h^1.5"),
            ("mag B", "field around it"),
            ("yaw N ±5%", "no axis of a sensor"),
            ("temperature N ±5%", "no axis of a sensor"),
        ] {
            let error = text.parse::<Want>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
