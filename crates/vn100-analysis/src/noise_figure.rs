//! A noise parameter of some channels, as users write it: `gyro N`, `accel_y B`.

use std::{fmt, str::FromStr, sync::Arc};

use imu_noise::{Sensor, Term};
use vn100_protocol::{BINARY, Channel, Layout, Quantity, VNIMU};

use crate::{
    invalid_text::InvalidText,
    sensor::{SENSORS, axes_name, letter, sensor_of, uncompensated_message},
};

/// One of N, B and K, of one channel or of all axes of a sensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoiseFigure {
    /// One axis by its name, or all axes by the name of the sensor: `gyro`, `accel` or `mag`.
    channels: String,
    /// The sensor.
    pub sensor: Sensor,
    /// The parameter.
    pub term: Term,
}

const TERMS: [Term; 3] = [Term::White, Term::BiasInstability, Term::RateRandomWalk];

impl NoiseFigure {
    /// Whether the channel of this name and quantity is one of the channels of the figure.
    pub fn concerns(&self, name: &str, quantity: Quantity) -> bool {
        name == self.channels || self.channels == axes_name(self.sensor) && sensor_of(quantity) == Some(self.sensor)
    }

    /// Whether `layout` has a channel of this figure.
    pub fn is_in(&self, layout: &Layout) -> bool {
        layout.channels.iter().any(|channel| self.concerns(&channel.name, channel.quantity))
    }

    /// Whether one of `others` has a channel of this figure, and `own` has none.
    pub fn is_only_in(&self, others: &[Arc<Layout>], own: Option<&Layout>) -> bool {
        !own.is_some_and(|own| self.is_in(own)) && others.iter().any(|other| self.is_in(other))
    }

    /// The number of axes of the figure.
    pub(crate) fn axes(&self) -> u32 {
        if self.channels == axes_name(self.sensor) { 3 } else { 1 }
    }

    /// Why no record of `layout`, however long, shows the parameter; `None` if one may.
    pub(crate) fn absent_from(&self, layout: &Layout) -> Option<String> {
        let message = &layout.message;
        let is_of = |channel: &&Channel| self.concerns(&channel.name, channel.quantity);
        let concerned: Vec<&Channel> = layout.channels.iter().filter(is_of).collect();
        if concerned.is_empty() {
            return Some(format!("{self} is not measurable in {message}, which lacks the channel"));
        }
        let bias_removed = layout.compensated == Some(true)
            && concerned.iter().any(|channel| channel.quantity == Quantity::AngularRate);
        (bias_removed && self.term != Term::White).then(|| {
            let uncompensated = match uncompensated_message(message) {
                // the message has packets already: another form of packets has the same name
                BINARY => "packets of uncompensated rates show it",
                _ => "VNIMU is uncompensated",
            };
            format!("{self} is not measurable in {message}: the attitude filter removes the bias; {uncompensated}")
        })
    }
}

/// A percentage above 0, which ends a `text`, as a fraction; a percent sign may follow the number.
pub(crate) fn share_of_percent(percent: &str, text: &str) -> Result<f64, InvalidText> {
    let percent = percent.trim().trim_end_matches('%').trim_end().parse().unwrap_or(f64::NAN);
    let is_usable = percent > 0.0 && f64::is_finite(percent);
    let invalid = || InvalidText(format!("{text:?} is no percentage above 0, as in \"5%\""));
    is_usable.then_some(percent / 100.0).ok_or_else(invalid)
}

/// A fraction in percent, without the digits that binary fractions add.
pub(crate) fn in_percent(share: f64) -> f64 {
    let percent = 100.0 * share;
    format!("{percent:.12e}").parse().unwrap_or(percent)
}

impl FromStr for NoiseFigure {
    type Err = InvalidText;

    fn from_str(text: &str) -> Result<Self, InvalidText> {
        let mut words = text.split_whitespace();
        let (Some(channels), Some(name), None) = (words.next(), words.next(), words.next()) else {
            return Err(InvalidText(format!(
                "{text:?} names no figure: a group (gyro, accel, mag) or a channel, and N, B or K, as in \"gyro N\""
            )));
        };
        let term = TERMS.into_iter().find(|term| letter(*term).eq_ignore_ascii_case(name));
        let term = term.ok_or_else(|| InvalidText(format!("{name:?} is no parameter: N, B or K")))?;
        let axis = VNIMU.channels.iter().find(|channel| channel.name == channels);
        let of_axis = axis.and_then(|axis| sensor_of(axis.quantity));
        let of_all = SENSORS.into_iter().map(|(_, sensor)| sensor).find(|sensor| axes_name(*sensor) == channels);
        let no_axis = || {
            let text = text.trim();
            InvalidText(format!("{text:?} is no axis of a sensor: gyro, accel, mag, or one of them with _x, _y or _z"))
        };
        let sensor = of_axis.or(of_all).ok_or_else(no_axis)?;
        let figure = Self { channels: channels.into(), sensor, term };
        if sensor == Sensor::Magnetometer && term != Term::White {
            return Err(InvalidText(format!(
                "{figure} is not the sensor's: at long averaging times a magnetometer shows the field around it"
            )));
        }
        Ok(figure)
    }
}

impl fmt::Display for NoiseFigure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.channels, letter(self.term))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vn100_protocol::VNYMR;

    #[test]
    fn figures_are_read_as_they_are_printed() {
        for (text, concerned) in [("gyro N", 3), ("accel B", 3), ("mag N", 3), ("gyro_y K", 1), ("mag_x N", 1)] {
            let figure: NoiseFigure = text.parse().unwrap();
            assert_eq!(figure.to_string(), text);
            let is_of = |channel: &&Channel| figure.concerns(&channel.name, channel.quantity);
            assert_eq!(VNYMR.channels.iter().filter(is_of).count(), concerned, "{text}");
        }
        assert_eq!("gyro  n".parse::<NoiseFigure>().unwrap().to_string(), "gyro N");
    }

    #[test]
    fn what_is_no_figure_names_what_one_is() {
        for (text, expected) in [
            ("", "gyro N"),
            ("gyro", "gyro N"),
            ("gyro N 5", "gyro N"),
            ("gyro R", "N, B or K"),
            ("gyro_q N", "no axis of a sensor"),
            ("yaw N", "no axis of a sensor"),
            ("temperature K", "no axis of a sensor"),
            ("mag B", "field around it"),
            ("mag_z K", "field around it"),
        ] {
            let error = text.parse::<NoiseFigure>().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_message_that_cannot_show_a_figure_says_why() {
        let absent = |text: &str, layout| text.parse::<NoiseFigure>().unwrap().absent_from(layout);
        for text in ["gyro N", "accel B", "accel_x K", "mag N"] {
            assert_eq!((absent(text, &VNYMR), absent(text, &VNIMU)), (None, None), "{text}");
        }
        for text in ["gyro B", "gyro_z K"] {
            assert!(absent(text, &VNYMR).unwrap().starts_with(&format!("{text} is not measurable in VNYMR")), "{text}");
            assert_eq!(absent(text, &VNIMU), None, "{text}");
        }
        let without_gyro = Layout { channels: VNIMU.channels[..6].to_vec().into(), ..VNIMU.clone() };
        assert!(absent("gyro N", &without_gyro).unwrap().contains("lacks the channel"));
    }
}
