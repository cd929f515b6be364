//! The options of `export`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use vn100_report::Consumer;

use super::ForceArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The data sheet of the sensor: its name, as `vn100 explain` lists them, or a file (TOML)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) datasheet: PathBuf,

    /// The program that reads the values
    #[arg(long, value_name = "PROGRAM", value_parser = consumer())]
    pub(crate) to: &'static Consumer,

    /// Samples per second in the stream that the program gets
    #[arg(short, long, help_heading = "Stream", value_name = "HZ", value_parser = positive)]
    pub(crate) rate: f64,

    /// Internal samples that the sensor averages for one sample, or "all" between two samples, as
    /// after a low-pass filter at half the rate: what is not averaged aliases
    #[arg(short, long, help_heading = "Stream", value_name = "N|all", value_parser = window)]
    pub(crate) window: Window,

    /// Internal samples per second, unless the data sheet has them
    #[arg(long, help_heading = "Stream", value_name = "HZ", value_parser = positive)]
    pub(crate) refresh: Option<f64>,

    #[command(flatten)]
    pub(crate) not_shown: ScaleFactorArgs,

    /// The file to write [default: standard output]
    #[arg(short, long, help_heading = "Output", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) existing: ForceArgs,
}

/// What filters need and no record at rest shows.
#[derive(Debug, clap::Args)]
pub(crate) struct ScaleFactorArgs {
    /// Error of the scale factor, which kf-gins needs and no record at rest shows
    #[arg(long, help_heading = "Exports", value_name = "PPM", value_parser = positive)]
    pub(crate) scale_factor: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Window {
    /// Everything between two samples: nothing aliases.
    All,
    /// This many internal samples.
    Samples(u32),
}

fn consumer() -> impl TypedValueParser<Value = &'static Consumer> {
    let consumers = Consumer::ALL.iter().map(|consumer| PossibleValue::new(consumer.name).help(consumer.help()));
    PossibleValuesParser::new(consumers).try_map(|name| Consumer::named(&name).ok_or("unknown program"))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("not a number above 0".into()),
    }
}

fn window(text: &str) -> Result<Window, String> {
    match (text, text.parse::<u32>()) {
        ("all", _) => Ok(Window::All),
        (_, Ok(samples)) if samples > 0 => Ok(Window::Samples(samples)),
        _ => Err("not a number of samples, nor \"all\"".into()),
    }
}
