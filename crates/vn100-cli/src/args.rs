//! The command line.

mod link;
mod measure;

use std::{path::PathBuf, time::Duration};

use clap::{Parser, Subcommand};
use vn100_driver::ColumnMap;

pub(crate) use link::{Baud, LinkArgs, SourceName};
pub(crate) use measure::MeasureArgs;

/// Live Allan deviation and statistics for the VectorNav VN-100.
#[derive(Debug, Parser)]
#[command(
    name = "vn100",
    version,
    max_term_width = 100,
    after_help = "Exit codes: 0 good, 1 failed, 2 usage, 3 no source or nothing valid in it."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Measure live sensors, until stopped; nothing is changed on them unless asked
    Attach(AttachArgs),
    /// Run recorded captures through the pipeline, as fast as the machine can
    Replay(ReplayArgs),
    /// Write a capture of an emulated sensor whose noise is known
    Sim(SimArgs),
    /// List the serial ports, those a VN-100 is likely on first
    Ports(PortsArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct AttachArgs {
    /// Serial ports such as /dev/ttyUSB0 or COM3, tcp://host:port for a serial server, or "-" for bytes on standard
    /// input
    #[arg(required = true, value_name = "SOURCE")]
    pub(crate) sources: Vec<SourceName>,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReplayArgs {
    /// Captures: text, raw bytes, CSV or MCAP, also gzip or zstd, recognised by content; "-" is standard input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    /// Columns of a CSV file of any inertial sensor, as OURS=THEIRS:UNIT, for example
    /// gyro_x=wx:deg/s,accel_z=az:g,t=stamp:ns
    #[arg(long, value_name = "MAP")]
    pub(crate) columns: Option<ColumnMap>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SimArgs {
    /// The capture to write, with a time for each line where the name ends in .mcap; "-" is standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Length of the record, for example 5h
    #[arg(long, value_name = "T", value_parser = humantime::parse_duration, default_value = "60s")]
    pub(crate) duration: Duration,

    /// Output rate in hertz, one the sensor has: 1 2 4 5 10 20 25 40 50 100 200
    #[arg(long, value_name = "HZ", default_value_t = 40)]
    pub(crate) rate: u32,

    /// Seed of the noise; the same seed gives the same bytes
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Noise of the sensor: "datasheet" or "lab3"
    #[arg(long, default_value = "datasheet")]
    pub(crate) profile: String,

    /// Replace an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PortsArgs {
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}
