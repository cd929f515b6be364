//! Options of the commands that read captures.

use std::path::PathBuf;

use clap::ValueEnum;
use vn100_capture::ColumnMap;

use super::{
    LogArgs,
    measure::{MeasureArgs, ResultArgs},
};
use vn100_pipeline::Speed;

#[derive(Debug, clap::Args)]
pub(crate) struct FileArgs {
    /// Captures: text, raw bytes, CSV or MCAP, also gzip or zstd, recognised by content; "-" is
    /// standard input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    /// Columns of a CSV file of any inertial sensor, as OURS=THEIRS:UNIT, for example
    /// gyro_x=wx:deg/s,accel_z=az:g,t=stamp:ns
    #[arg(long, value_name = "MAP")]
    pub(crate) columns: Option<ColumnMap>,

    #[command(flatten)]
    pub(crate) log: LogArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReplayArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    /// Replay in the live view, at this many seconds of data a second, as in "1x" or "10x", or
    /// "max" for as fast as the machine can
    #[arg(long, value_name = "SPEED", conflicts_with_all = ["json", "ndjson"])]
    pub(crate) speed: Option<Speed>,
}

/// At least two files; one alone is a wrong command line.
#[derive(Debug, clap::Args)]
#[command(mut_arg("files", |files| files.num_args(2..)))]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// Print one JSON document, and nothing else, on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// The page to write, ending in .html; another name begins the names of what is exported, and
    /// no page is written
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,

    /// Write the numbers for other programs beside it: once for each form, or with commas between
    /// them
    #[arg(long, value_name = "FORM", value_enum, value_delimiter = ',')]
    pub(crate) export: Vec<ExportForm>,

    /// Also give the models for filters: in the export as JSON, and to Kalibr a bound where the
    /// random walk is not estimated
    #[arg(long)]
    pub(crate) filter_models: bool,

    /// Replace existing files
    #[arg(long)]
    pub(crate) force: bool,
}

/// What a report is exported as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportForm {
    /// Curves, statistics, parameters, spectrum, segments and histograms as tables
    Csv,
    /// The document of `vn100 replay --json`
    Json,
    /// imu.yaml for Kalibr; refused where the random walk is not estimated, unless --filter-models
    /// gives a bound
    Kalibr,
    /// Each figure as SVG, in a folder
    Svg,
    /// Each figure as PNG, in a folder
    Png,
    /// The samples as ROS 2 messages, Imu and MagneticField
    Mcap,
}
