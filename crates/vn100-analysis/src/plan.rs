//! From what a record shall show to how the sensor is set, and how long it must rest.

use std::{fmt, str::FromStr};

use imu_noise::{Aim, Sides, Term, Wanted, conventions, visible_random_walk};
use thiserror::Error;
use vn100_protocol::{AsyncRate, AsyncType, BaudRate, LineForm, LinkLoad};

use crate::{
    datasheet::Datasheet,
    noise_figure::{NoiseFigure, NoiseFigureError, in_percent, share_of_percent},
};

/// The sensor takes so many values a second of acceleration and angular rate.
const IMU_REFRESH_HZ: u32 = 800;

/// The rate a sensor is sold with.
const SOLD_RATE_HZ: u32 = 40;

/// The fastest line of the sensor.
const FASTEST: BaudRate = BaudRate::ALL[BaudRate::ALL.len() - 1];

/// B, K and R of six axes are tested in one record.
const SLOW_TERMS: usize = 18;

/// Published practice leaves out between so much, in seconds; the maker states no figure.
const WARM_UP_S: [f64; 2] = [600.0, 1800.0];

/// A figure, and how well it shall be known.
#[derive(Debug, Clone, PartialEq)]
pub struct Want {
    /// Which figure.
    pub figure: NoiseFigure,
    /// How well.
    pub known: Known,
}

/// How well a figure shall be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// It is detected, at its typical size.
    Seen,
    /// Half the width of its interval over the value is so much at most.
    Within(f64),
    /// It is detected if it is at least so large, in SI units.
    AtLeast(f64),
    /// Whether it lies above or below this limit is decided, in SI units.
    AtMost(f64),
}

/// A text is no want, or one that no record meets.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WantError {
    /// There is no sign between a figure and what follows.
    #[error(
        "invalid target {0:?}; expected a parameter with a precision, as in \"gyro N ±5%\", a detectable size, as in \"gyro K >= 2e-7\", or a limit, as in \"accel B <= 0.04 mg\""
    )]
    Form(String),
    /// The figure is none.
    #[error(transparent)]
    NoiseFigure(#[from] NoiseFigureError),
    /// The part behind `±` is no percentage above 0.
    #[error("{0:?} is no percentage above 0, as in \"5%\"")]
    Percent(String),
    /// The part behind `>=` or `<=` is no number above 0.
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
    #[error("the precision of {0} is missing, as in \"{0} ±5%\"")]
    White(String),
    /// No typical random walk is known.
    #[error("the size of the random walk to detect is missing, as in \"{0} >= 2e-7\"; no typical figure is known")]
    Walk(String),
}

impl FromStr for Want {
    type Err = WantError;

    fn from_str(text: &str) -> Result<Self, WantError> {
        // not every keyboard has the signs
        let split_at = |signs: [&str; 2]| signs.iter().find_map(|sign| text.split_once(sign));
        let within = split_at(["±", "+-"]);
        let percent =
            within.map(|(_, percent)| share_of_percent(percent).ok_or_else(|| WantError::Percent(text.into())));
        let percent = percent.transpose()?;
        let at_least = split_at([">=", "≥"]).filter(|_| within.is_none());
        let at_most = split_at(["<=", "≤"]).filter(|_| within.or(at_least).is_none());
        let figure = within.or(at_least).or(at_most).map_or(text, |(figure, _)| figure);
        let figure: NoiseFigure = figure.parse().map_err(|error| match begins_with_figure(figure) {
            true => WantError::Form(text.into()),
            false => WantError::NoiseFigure(error),
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
            (Term::RateRandomWalk, ..) => return Err(WantError::Walk(figure.to_string())),
            _ => return Err(WantError::White(figure.to_string())),
        };
        Ok(Self { figure, known })
    }
}

/// Whether more follows a figure.
fn begins_with_figure(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let figure = words.by_ref().take(2).collect::<Vec<_>>().join(" ");
    words.next().is_some() && figure.parse::<NoiseFigure>().is_ok()
}

/// A number with one of the units in use, or none for SI.
fn in_si(amount: &str, figure: &NoiseFigure) -> Result<f64, WantError> {
    let (number, unit) = amount.split_once(char::is_whitespace).unwrap_or((amount, ""));
    let number = number.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    let number = number.ok_or_else(|| WantError::Number(amount.into()))?;
    let known =
        || conventions(figure.sensor, figure.term).iter().filter(|convention| convention.sides != Some(Sides::One));
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
            Known::AtLeast(value) | Known::AtMost(value) => {
                let sign = if matches!(self.known, Known::AtMost(_)) { "<=" } else { ">=" };
                let unit = conventions(self.figure.sensor, self.figure.term).first().map_or("", |si| si.unit);
                // rounded, without trailing zeros
                let digits = format!("{value:.3e}").parse().unwrap_or(value);
                write!(f, "{} {sign} {digits:e} {unit}", self.figure)
            }
        }
    }
}

/// What is fixed before anything is planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Output rate.
    pub rate: Option<AsyncRate>,
    /// Baud rate.
    pub baud: Option<BaudRate>,
    /// Two-sided level of the intervals, 0 < p < 1.
    pub confidence: f64,
}

/// A measurement as it should be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How long for what, in the order asked.
    pub wants: Vec<PlannedWant>,
    /// The message: the one whose angular rate still holds the sensor's own bias.
    pub message: AsyncType,
    /// What each line carries beyond it.
    pub form: LineForm,
    /// Bytes of a line.
    pub line_length: u32,
    /// Output rate.
    pub rate: AsyncRate,
    /// Values averaged for one that is sent, all that are taken: white noise keeps its density.
    pub window: u32,
    /// Baud rate.
    pub baud: BaudRate,
    /// To be excluded at the beginning, in seconds.
    pub warm_up_s: f64,
    /// Length after the warm-up in seconds, rounded up; `None` where something is out of reach.
    pub record_s: Option<f64>,
}

/// How long a record must be for one want.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedWant {
    /// What is wanted.
    pub want: Want,
    /// Seconds after the warm-up; `None` where 100 days are too short.
    pub record_s: Option<f64>,
    /// For a random walk: seconds if the sensor had no bias instability that hides it.
    pub without_bias_instability_s: Option<f64>,
    /// For a random walk: 20 √3 N/K, the rule of thumb, in seconds.
    pub by_rule_s: Option<f64>,
    /// For a limit: the value that the sensor is taken to have, in SI units. Nearer to the limit it
    /// takes longer.
    pub taken_at: Option<f64>,
}

/// A measurement cannot be made so.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanningError {
    /// The data sheet does not say what the length depends on.
    #[error(
        "the length for {want:?} depends on {missing}, which the data sheet {datasheet:?} does not give for that sensor: add it, or give a \
         value, as in \"gyro K >= 2e-7\""
    )]
    NotQuoted {
        /// What is wanted.
        want: String,
        /// The parameters without a figure.
        missing: &'static str,
        /// Name of the data sheet.
        datasheet: String,
    },
    /// The line is too slow.
    #[error("{line_length} bytes {rate_hz} times a second do not fit {baud} baud; {}", match highest_hz {
        Some(hz) => format!("reduce the rate to {hz} Hz, or use a higher baud rate"),
        None => "use a higher baud rate".into(),
    })]
    DoesNotFit {
        /// Bytes of a line.
        line_length: u32,
        /// The rate asked for.
        rate_hz: u32,
        /// The baud rate.
        baud: u32,
        /// The highest rate that fits.
        highest_hz: Option<u32>,
    },
}

impl Plan {
    /// The share of records of the planned length that meet a want, all its axes together.
    pub const MET_IN: f64 = 0.8;

    /// Plans a record that shows all of `wants`, of a sensor as `datasheet` has it.
    ///
    /// # Errors
    /// Where what is given does not go together, and where the data sheet does not say how large a
    /// thing wanted is, or the white noise that hides it.
    pub fn new(wants: &[Want], given: Given, datasheet: &Datasheet) -> Result<Self, PlanningError> {
        let message = AsyncType::IMU;
        let form = LineForm { count: true, ..LineForm::default() };
        let line_length = message.line_length(form).unwrap_or_default();
        let (rate, baud) = rate_and_baud(line_length, given)?;
        let interval_s = 1.0 / f64::from(rate.hz());
        let wants = wants.iter().map(|want| PlannedWant::new(want, interval_s, given.confidence, datasheet));
        let wants = wants.collect::<Result<Vec<_>, _>>()?;
        let longest = wants.iter().try_fold(0.0_f64, |longest, want| Some(longest.max(want.record_s?)));
        let white_alone = wants.iter().all(|want| want.want.figure.term == Term::White);
        Ok(Self {
            wants,
            message,
            form,
            line_length,
            rate,
            window: IMU_REFRESH_HZ / rate.hz().max(1),
            baud,
            warm_up_s: WARM_UP_S[usize::from(!white_alone)],
            record_s: longest.map(rounded_up),
        })
    }
}

impl PlannedWant {
    fn new(want: &Want, interval_s: f64, confidence: f64, datasheet: &Datasheet) -> Result<Self, PlanningError> {
        let term = want.figure.term;
        let typical = datasheet.typical_noise(want.figure.sensor);
        let quoted = typical.iter().find(|(quoted, _)| *quoted == term).map(|(_, value)| *value);
        let (aim, assumed) = match want.known {
            Known::Seen => (Aim::Found, None),
            Known::Within(half_width) => (Aim::HalfWidth(half_width), None),
            Known::AtLeast(value) => (Aim::Found, Some((term, value))),
            Known::AtMost(limit) => {
                let value = beside(limit, quoted);
                (if value > limit { Aim::Above(limit) } else { Aim::Below(limit) }, Some((term, value)))
            }
        };
        let is_quoted = |term| typical.iter().any(|(quoted, _)| *quoted == term);
        let missing = match (is_quoted(Term::White), assumed.is_some() || is_quoted(term)) {
            (true, true) => None,
            (true, false) => Some("its own size"),
            (false, _) => Some("the white noise"),
        };
        if let Some(missing) = missing {
            return Err(PlanningError::NotQuoted {
                want: want.to_string(),
                missing,
                datasheet: datasheet.name.clone(),
            });
        }
        let truth: Vec<_> =
            typical.iter().copied().filter(|(named, _)| assumed.is_none() || *named != term).chain(assumed).collect();
        let missed = 1.0 - Plan::MET_IN.powf(1.0 / f64::from(want.figure.axes()));
        let length = |truth: &[(Term, f64)]| {
            Wanted { term, aim, truth, missed, tests: SLOW_TERMS }.record_s(interval_s, confidence)
        };
        let is_walk = term == Term::RateRandomWalk;
        let without: Vec<_> = truth.iter().copied().filter(|(term, _)| *term != Term::BiasInstability).collect();
        let white = typical.iter().find(|(term, _)| *term == Term::White).map(|(_, white)| *white);
        Ok(Self {
            want: want.clone(),
            record_s: length(&truth),
            without_bias_instability_s: if is_walk { length(&without) } else { None },
            // what is visible falls as the record grows
            by_rule_s: white
                .zip(assumed)
                .filter(|_| is_walk)
                .map(|(white, (_, walk))| visible_random_walk(white, 1.0) / walk),
            taken_at: assumed.map(|(_, value)| value).filter(|_| matches!(want.known, Known::AtMost(_))),
        })
    }
}

/// What a sensor is taken to have that shall be judged by a `limit`: what is typical, but where
/// that is not known, or so near that a verdict would take for ever, a fifth below the limit.
fn beside(limit: f64, typical: Option<f64>) -> f64 {
    const NEAREST: f64 = 0.2;
    typical.filter(|typical| (typical / limit - 1.0).abs() > NEAREST).unwrap_or((1.0 - NEAREST) * limit)
}

/// The sensor's own settings where they fit: long averaging times do not need more lines.
fn rate_and_baud(line_length: u32, given: Given) -> Result<(AsyncRate, BaudRate), PlanningError> {
    let load = |rate| LinkLoad::of_lines(line_length, rate);
    let baud_for = |rate: AsyncRate| match given.baud {
        Some(baud) => Some(baud).filter(|baud| load(rate).fits(*baud)),
        None if load(rate).fits(BaudRate::DEFAULT) => Some(BaudRate::DEFAULT),
        None => load(rate).lowest_baud_rate(),
    };
    let highest = LinkLoad::NONE.highest_rate_beside(line_length, given.baud.unwrap_or(FASTEST));
    let rates = match given.rate {
        Some(rate) => [Some(rate), None],
        None => [AsyncRate::new(SOLD_RATE_HZ), highest],
    };
    let fitting = rates.into_iter().flatten().find_map(|rate| Some((rate, baud_for(rate)?)));
    fitting.ok_or_else(|| PlanningError::DoesNotFit {
        line_length,
        rate_hz: given.rate.map_or(SOLD_RATE_HZ, AsyncRate::hz),
        baud: given.baud.unwrap_or(FASTEST).bits_per_s(),
        highest_hz: highest.map(AsyncRate::hz),
    })
}

/// To minutes, from an hour on to ten, from ten hours on to hours.
fn rounded_up(seconds: f64) -> f64 {
    let step = match seconds {
        ..3600.0 => 60.0,
        ..36_000.0 => 600.0,
        _ => 3600.0,
    };
    (seconds / step).ceil() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_up_to_minutes_ten_minutes_and_hours() {
        for (seconds, rounded) in [
            (1.0, 60.0),
            (60.0, 60.0),
            (61.0, 120.0),
            (3599.0, 3600.0),
            (3601.0, 4200.0),
            (35_500.0, 36_000.0),
            (36_001.0, 39_600.0),
        ] {
            assert_eq!(rounded_up(seconds), rounded, "{seconds} s");
        }
    }

    #[test]
    fn what_shall_be_judged_lies_a_fifth_below_the_limit_unless_it_is_known_and_not_near() {
        for (typical, taken) in
            [(None, 8.0), (Some(8.1), 8.0), (Some(11.9), 8.0), (Some(7.9), 7.9), (Some(12.1), 12.1), (Some(1.0), 1.0)]
        {
            assert_eq!(beside(10.0, typical), taken, "{typical:?}");
        }
    }

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
            ("accel B <= 0.04 mg", "accel B <= 3.923e-4 m/s^2"),
            ("gyro N≤1e-4", "gyro N <= 1e-4 rad/s/sqrt(Hz)"),
            ("gyro_z K <= 2e-7", "gyro_z K <= 2e-7 rad/s/sqrt(s)"),
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
            ("gyro N 2%", "invalid target \"gyro N 2%\"; expected a parameter with a precision, as in \"gyro N ±5%\""),
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
