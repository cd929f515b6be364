//! How well a parameter must be known before a measurement ends: `gyro N ±5%`.

use std::{fmt, str::FromStr};

use crate::{
    invalid_text::InvalidText,
    noise_figure::{NoiseFigure, in_percent, share_of_percent},
};

/// A parameter, and the half-width of its interval that ends a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// The parameter.
    pub figure: NoiseFigure,
    /// The largest half-width of the interval, divided by the value; above 0.
    pub relative_half_width: f64,
}

impl FromStr for Goal {
    type Err = InvalidText;

    fn from_str(text: &str) -> Result<Self, InvalidText> {
        // `+-` for keyboards without the sign
        let split = text.split_once('±').or_else(|| text.split_once("+-"));
        let expected = "expected PARAMETER ±PERCENT, such as \"gyro N ±5%\"";
        let (figure, percent) = split.ok_or_else(|| InvalidText(format!("invalid target {text:?}; {expected}")))?;
        let relative_half_width = share_of_percent(percent, text)?;
        Ok(Self { figure: figure.parse()?, relative_half_width })
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ±{} %", self.figure, in_percent(self.relative_half_width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_read_in_every_spelling() {
        for text in ["gyro N ±5%", "gyro N ± 5 %", "gyro N +-5%", " gyro  n ±5"] {
            let goal: Goal = text.parse().unwrap();
            assert_eq!((goal.to_string(), goal.relative_half_width), ("gyro N ±5 %".into(), 0.05), "{text}");
        }
    }

    #[test]
    fn a_percentage_is_printed_as_it_was_given() {
        for text in ["gyro N ±7 %", "gyro N ±0.0001 %", "gyro N ±12.5 %", "gyro N ±29 %", "gyro N ±0.07 %"] {
            assert_eq!(text.parse::<Goal>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn what_is_no_goal_names_what_one_is() {
        for (text, expected) in [
            ("gyro N", "±5%"),
            ("gyro N ±x%", "percentage"),
            ("gyro N ±-1%", "percentage"),
            ("gyro Z ±5%", "N, B or K"),
            ("gyro_q N ±5%", "no axis of a sensor"),
            ("mag K ±5%", "field around it"),
        ] {
            let error = text.parse::<Goal>().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
