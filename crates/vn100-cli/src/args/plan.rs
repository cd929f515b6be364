//! The options of `plan`.

use std::path::PathBuf;

use vn100_analysis::{DEFAULT_CONFIDENCE, PlannedMessage, Want};
use vn100_protocol::BaudRate;

use super::{link::baud_rate, measure::confidence};

#[derive(Debug, clap::Args)]
pub(crate) struct PlanArgs {
    /// Parameter to measure, as in "gyro N ±5%", "gyro B" or "gyro K >= 0.5 deg/h^1.5",
    /// or a limit to decide on, as in "accel B <= 0.04 mg", always with a unit [default: a table of
    /// the usual ones]
    #[arg(long, value_name = "WANT")]
    pub(crate) want: Vec<Want>,

    #[command(flatten)]
    pub(crate) fixed: Fixed,

    /// Two-sided level of the intervals, between 0 and 1
    #[arg(long, value_name = "P", value_parser = confidence, default_value_t = DEFAULT_CONFIDENCE)]
    pub(crate) confidence: f64,

    /// Noise of the sensor from this data sheet (TOML) instead of the VN-100's
    #[arg(long, value_name = "FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    /// Print a JSON document
    #[arg(long, help_heading = "Output")]
    pub(crate) json: bool,
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

fn planned_message(name: &str) -> Result<PlannedMessage, String> {
    PlannedMessage::named(name).ok_or_else(|| format!("no plan is made for {name}: use BINARY, BINARY+MAG or VNIMU"))
}
