//! What a planned record is to show: a parameter, and how well it is to be known.

use std::{fmt, str::FromStr};

use imu_noise::{Sides, Term, conventions};

use crate::{
    datasheet::Datasheet,
    invalid_text::InvalidText,
    noise_figure::{NoiseFigure, in_percent, share_of_percent},
};

/// A parameter, and how well a record is to show it.
#[derive(Debug, Clone, PartialEq)]
pub struct Want {
    /// The parameter.
    pub figure: NoiseFigure,
    /// How well it is to be known.
    pub known: Known,
}

/// How well a parameter is to be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// The parameter is detected, if it has its typical size.
    Seen,
    /// Half the width of the interval over the value is at most this; above 0.
    Within(f64),
    /// The parameter is detected, if it is at least this large, in SI units; above 0.
    AtLeast(f64),
    /// It is decided whether the parameter is above or below this limit, in SI units; above 0.
    AtMost(f64),
}

/// What a want looks like.
const EXPECTED: &str = "expected a parameter with a precision, as in \"gyro N ±5%\", a detectable size, as in \
                        \"gyro K >= 0.5 deg/h^1.5\", or a limit, as in \"accel B <= 0.04 mg\"";

impl FromStr for Want {
    type Err = InvalidText;

    fn from_str(text: &str) -> Result<Self, InvalidText> {
        // other signs for keyboards without these
        let split_at = |signs: [&str; 2]| signs.iter().find_map(|sign| text.split_once(sign));
        let within = split_at(["±", "+-"]);
        let percent = within.map(|(_, percent)| share_of_percent(percent, text)).transpose()?;
        let at_least = split_at([">=", "≥"]).filter(|_| within.is_none());
        let at_most = split_at(["<=", "≤"]).filter(|_| within.or(at_least).is_none());
        let figure = within.or(at_least).or(at_most).map_or(text, |(figure, _)| figure);
        let figure: NoiseFigure = figure.parse().map_err(|error| match begins_with_figure(figure) {
            true => InvalidText(format!("invalid target {text:?}; {EXPECTED}")),
            false => error,
        })?;
        if let Some((_, limit)) = at_most {
            let known = Known::AtMost(in_si(limit.trim(), &figure)?);
            return Ok(Self { figure, known });
        }
        let known = match (figure.term, percent, at_least) {
            (Term::White | Term::BiasInstability, Some(relative), _) => Known::Within(relative),
            (Term::BiasInstability, None, None) => Known::Seen,
            (Term::BiasInstability | Term::RateRandomWalk, None, Some((_, amount))) => {
                Known::AtLeast(in_si(amount.trim(), &figure)?)
            }
            (Term::RateRandomWalk, ..) => {
                let example = format!("{figure} >= 2e-7 {}", si_unit(&figure));
                return Err(InvalidText(format!(
                    "the size of the random walk to detect is missing, as in \"{example}\"; no typical figure is known"
                )));
            }
            // N is in every record: it cannot be detected, only measured
            _ => return Err(InvalidText(format!("the precision of {figure} is missing, as in \"{figure} ±5%\""))),
        };
        Ok(Self { figure, known })
    }
}

impl Want {
    /// What the length of a record for it depends on, and the data sheet does not give of the sensor: its
    /// white noise, or the size of the parameter if the want does not state it. `None` if nothing is missing.
    pub fn missing_in(&self, datasheet: &Datasheet) -> Option<&'static str> {
        let typical = datasheet.typical_noise(self.figure.sensor);
        let is_given = |term| typical.iter().any(|(given, _)| *given == term);
        let states_size = matches!(self.known, Known::AtLeast(_) | Known::AtMost(_));
        match (is_given(Term::White), states_size || is_given(self.figure.term)) {
            (true, true) => None,
            (true, false) => Some("its own size"),
            (false, _) => Some("the white noise"),
        }
    }
}

/// Whether the text begins with a parameter, so that a want may follow it.
fn begins_with_figure(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let figure = words.by_ref().take(2).collect::<Vec<_>>().join(" ");
    words.next().is_some() && figure.parse::<NoiseFigure>().is_ok()
}

fn si_unit(figure: &NoiseFigure) -> &'static str {
    imu_noise::si_unit(figure.sensor, figure.term)
}

/// A number in SI units, from one with a unit in use.
fn in_si(amount: &str, figure: &NoiseFigure) -> Result<f64, InvalidText> {
    let (number, unit) = amount.split_once(char::is_whitespace).unwrap_or((amount, ""));
    let number = number.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    let number = number.ok_or_else(|| {
        let examples = "as in \"0.04 mg\" or \"0.5 deg/h^1.5\"";
        InvalidText(format!("{amount:?} is no number above 0 with a unit after a space, {examples}"))
    })?;
    let known =
        || conventions(figure.sensor, figure.term).iter().filter(|convention| convention.sides != Some(Sides::One));
    let unit = unit.trim();
    if let Some(convention) = known().find(|convention| convention.unit == unit) {
        return Ok(number / convention.factor);
    }
    let units = known().map(|convention| convention.unit).collect::<Vec<_>>().join(", ");
    Err(InvalidText(match unit {
        // the units in use lie factors of thousands apart
        "" => format!("the unit of {amount:?} is missing; {figure} is stated in {units}"),
        _ => format!("{figure} is not stated in {unit:?}: {units}"),
    }))
}

impl fmt::Display for Want {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.known {
            Known::Seen => write!(f, "{}", self.figure),
            Known::Within(relative) => write!(f, "{} ±{} %", self.figure, in_percent(relative)),
            Known::AtLeast(value) | Known::AtMost(value) => {
                let sign = if matches!(self.known, Known::AtMost(_)) { "<=" } else { ">=" };
                // rounded, without trailing zeros
                let digits = format!("{value:.3e}").parse().unwrap_or(value);
                write!(f, "{} {sign} {digits:e} {}", self.figure, si_unit(&self.figure))
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
            ("gyro K >= 2e-7 rad/s/sqrt(s)", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro K≥2e-7 rad/s/sqrt(s)", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro K >= 2.475178 deg/h^1.5", "gyro K >= 2e-7 rad/s/sqrt(s)"),
            ("gyro B >= 5 deg/h", "gyro B >= 2.424e-5 rad/s"),
            ("accel B >= 0.04 mg", "accel B >= 3.923e-4 m/s^2"),
            ("mag N ±10%", "mag N ±10 %"),
            ("accel B <= 0.04 mg", "accel B <= 3.923e-4 m/s^2"),
            ("gyro N≤1e-4 rad/s/sqrt(Hz)", "gyro N <= 1e-4 rad/s/sqrt(Hz)"),
            ("gyro_z K <= 2e-7 rad/s/sqrt(s)", "gyro_z K <= 2e-7 rad/s/sqrt(s)"),
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
            ("gyro K", "\"gyro K >= 2e-7 rad/s/sqrt(s)\""),
            ("accel K ±5%", "\"accel K >= 2e-7 m/s^2/sqrt(s)\""),
            ("gyro R", "N, B or K"),
            ("gyro N 2%", "invalid target \"gyro N 2%\"; expected a parameter with a precision, as in \"gyro N ±5%\""),
            ("gyro N 2 %", "\"gyro N ±5%\""),
            ("gyro K 2e-7", "\"gyro K >= 0.5 deg/h^1.5\""),
            ("gyro R 2%", "N, B or K"),
            ("gyro B ±0%", "percentage above 0"),
            ("gyro K >= -1", "number above 0"),
            ("gyro K >= 1 deg/h", "deg/h^1.5"),
            ("gyro K >= 0.04mg", "after a space"),
            (
                "gyro N <= 0.47",
                "the unit of \"0.47\" is missing; gyro N is stated in rad/s/sqrt(Hz), deg/s/sqrt(Hz), deg/sqrt(h), deg/h/sqrt(Hz)",
            ),
            ("accel B >= 0.02", "m/s^2, mg, ug"),
            ("mag K <= 1e-6", "field around it"),
            ("gyro_x K <= 2e-7", "rad/s/sqrt(s), deg/s/sqrt(s), deg/h^1.5"),
            ("mag B", "field around it"),
            ("yaw N ±5%", "no axis of a sensor"),
            ("temperature N ±5%", "no axis of a sensor"),
        ] {
            let error = text.parse::<Want>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
