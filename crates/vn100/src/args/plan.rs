//! The options of `plan`.

use std::path::PathBuf;

use vn100_analysis::{DEFAULT_CONFIDENCE, InvalidText, PlannedMessage, Want};
use vn100_protocol::BaudRate;

use super::{JsonArgs, link::baud_rate, measure::confidence};

#[derive(Debug, clap::Args)]
pub(crate) struct PlanArgs {
    /// Parameter to measure, as in "gyro N ±5%", "gyro B" or "gyro K >= 0.5 deg/h/√h",
    /// or a limit to decide on, as in "accel B <= 0.04 mg", always with a unit [default: a table of
    /// the usual ones]
    #[arg(long, value_name = "WANT", value_parser = want)]
    pub(crate) want: Vec<Want>,

    #[command(flatten)]
    pub(crate) fixed: Fixed,

    /// Two-sided level of the intervals, between 0 and 1
    #[arg(long, value_name = "P", value_parser = confidence, default_value_t = DEFAULT_CONFIDENCE)]
    pub(crate) confidence: f64,

    /// Noise of the sensor from this data sheet instead of the VN-100's: one that `vn100 explain` lists, or a
    /// file (TOML)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) output: JsonArgs,
}

/// What a plan may not choose.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Fixed settings")]
pub(crate) struct Fixed {
    /// What the sensor sends, if it is fixed: BINARY, BINARY+MAG or VNIMU [default: packets, with
    /// the magnetic field if something of it is wanted]
    #[arg(long, value_name = "NAME", value_parser = planned_message)]
    pub(crate) message: Option<PlannedMessage>,

    /// Output rate in hertz, if it is fixed: of packets 800 over a whole number, of sentences 1 2 4
    /// 5 10 20 25 40 50 100 200
    #[arg(short, long = "rate", value_name = "HZ")]
    pub(crate) rate_hz: Option<u32>,

    /// Baud rate, if it is fixed
    #[arg(long, value_name = "N", value_parser = baud_rate)]
    pub(crate) baud: Option<BaudRate>,
}

/// A want, whose unit may have the signs of summaries and pages: `°/h/√h`, `deg/h/√h` and `deg/h/sqrt(h)`
/// are read as `deg/h^1.5`, as documents have it.
fn want(text: &str) -> Result<Want, InvalidText> {
    let plain = [
        ("√Hz", "sqrt(Hz)"),
        ("√h", "sqrt(h)"),
        ("√s", "sqrt(s)"),
        ("/h/sqrt(h)", "/h^1.5"),
        ("²", "^2"),
        ("°", "deg"),
        ("µ", "u"),
        // the Greek letter
        ("μ", "u"),
    ];
    plain.into_iter().fold(text.to_owned(), |text, (sign, plain)| text.replace(sign, plain)).parse()
}

fn planned_message(name: &str) -> Result<PlannedMessage, String> {
    PlannedMessage::named(name).ok_or_else(|| format!("no plan is made for {name}: use BINARY, BINARY+MAG or VNIMU"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_want_takes_the_units_of_documents_and_those_of_summaries() {
        for (typed, plain) in [
            ("gyro K >= 0.5 deg/h/√h", "gyro K >= 0.5 deg/h^1.5"),
            ("gyro K >= 0.5 deg/h/sqrt(h)", "gyro K >= 0.5 deg/h^1.5"),
            ("gyro K >= 0.5 °/h/√h", "gyro K >= 0.5 deg/h^1.5"),
            ("gyro N <= 0.21 deg/√h", "gyro N <= 0.21 deg/sqrt(h)"),
            ("accel N <= 140 µg/√Hz", "accel N <= 140 ug/sqrt(Hz)"),
            ("accel K >= 0.01 m/s²/√s", "accel K >= 0.01 m/s^2/sqrt(s)"),
            ("accel K >= 4 m/s/h/√h", "accel K >= 4 m/s/h^1.5"),
        ] {
            assert_eq!(want(typed), plain.parse(), "{typed}");
            assert!(want(plain).is_ok(), "{plain}");
        }
    }
}
