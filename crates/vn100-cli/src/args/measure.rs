//! Options of every command that measures, and of those that read captures.

use std::{path::PathBuf, time::Duration};

use clap::{
    ValueEnum,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};
use imu_noise::{Deviation, Estimator};
use vn100_analysis::{AveragingTimes, DEFAULT_CONFIDENCE, Detrend, Goal, NoiseFigure, Settings};
use vn100_capture::ColumnMap;
use vn100_pipeline::Speed;
use vn100_protocol::stream::ReadOptions;

use super::LogArgs;

/// What is measured and how, the same for every command that measures.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct MeasureArgs {
    /// Nominal sample rate in hertz, where the capture does not contain it [default: 40 for
    /// sentences, with a warning; none for values without times]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,

    /// Windows that enter the deviation
    #[arg(long, value_parser = one_of(&ESTIMATORS), default_value = "strided")]
    pub(crate) estimator: Estimator,

    /// Which deviation
    #[arg(long, value_parser = one_of(&DEVIATIONS), default_value = "allan")]
    pub(crate) deviation: Deviation,

    /// Leave this much data time out at the beginning, for example 10min (warm-up)
    #[arg(long, value_name = "T", value_parser = humantime::parse_duration, default_value = "0s")]
    pub(crate) skip: Duration,

    /// Stop after this much data time, counted from the first sample, for example 1h
    #[arg(long, value_name = "T", value_parser = length)]
    pub(crate) duration: Option<Duration>,

    /// Stop when a figure is known so well, as in "gyro N ±5%": a group (gyro, accel, mag) or a
    /// channel, N, B or K, and half the width of its interval; exit with 4 if the data ends before
    #[arg(long, value_name = "GOAL")]
    pub(crate) until: Vec<Goal>,

    /// Exit with 4 unless a figure passes the limits of the data sheet, as in "gyro B": a group
    /// (gyro, accel, mag) or a channel, and N, B or K
    #[arg(long, value_name = "FIGURE")]
    pub(crate) fail_on: Vec<NoiseFigure>,

    /// Take the typical figures of the data sheet for limits: they pass and fail too
    #[arg(long)]
    pub(crate) typical_is_limit: bool,

    /// Compare with the figures of this TOML file instead of the VN-100's, as in
    /// crates/vn100-report/datasheets/vn-100.toml
    #[arg(long, value_name = "FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    /// Remove from each channel before its deviation is taken: a line, and the longest taus read
    /// low; or what follows the temperature, where the record proves that something does
    #[arg(long, value_parser = one_of(&DETRENDS))]
    pub(crate) detrend: Option<Detrend>,

    /// Also fit Q, quantisation noise: of sensors that count angle or velocity steps. The rounding
    /// of a printed rate is white noise, in N
    #[arg(long)]
    pub(crate) quantization: bool,

    /// Two-sided level of every interval, between 0 and 1 [default: 0.95]
    #[arg(long, value_name = "P", value_parser = confidence)]
    pub(crate) confidence: Option<f64>,

    /// Take lines that carry no checksum
    #[arg(long)]
    pub(crate) accept_unchecked: bool,
}

impl MeasureArgs {
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            rate_hz: self.rate,
            estimator: self.estimator,
            deviation: self.deviation,
            skip: self.skip,
            duration: self.duration,
            detrend: self.detrend,
            quantization: self.quantization,
            until: self.until.clone(),
            confidence: self.confidence.unwrap_or(DEFAULT_CONFIDENCE),
            ..Settings::default()
        }
    }

    pub(crate) fn read_options(&self) -> ReadOptions {
        ReadOptions { accept_unchecked: self.accept_unchecked, ..ReadOptions::default() }
    }
}

/// What the result of one source contains, and in which form.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct ResultArgs {
    /// Also give, for filters, a first-order Gauss-Markov process, and the white noise and random
    /// walk that lie above the whole curve
    #[arg(long)]
    pub(crate) filter_models: bool,

    /// Print one JSON document at the end, and nothing else, on standard output
    #[arg(long, conflicts_with = "ndjson")]
    pub(crate) json: bool,

    /// Print one JSON document per line, for every second of data time and at the end
    #[arg(long)]
    pub(crate) ndjson: bool,
}

impl ResultArgs {
    pub(crate) fn format(&self) -> OutputFormat {
        match (self.json, self.ndjson) {
            (true, _) => OutputFormat::Json,
            (_, true) => OutputFormat::Ndjson,
            _ => OutputFormat::Text,
        }
    }
}

/// How results are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutputFormat {
    /// As text, each when it is there.
    Text,
    /// As one JSON document at the end.
    Json,
    /// As text, without statistics and deviations.
    Summary,
    /// As JSON documents in lines, written during the measurement.
    Ndjson,
}

/// The windows of the deviation: name, help, estimator.
const ESTIMATORS: [(&str, &str, Estimator); 3] = [
    ("strided", "Octave windows at stride tau/16: fully overlapping up to m = 16, bounded memory", Estimator::Strided),
    ("full", "Fully overlapping at every octave (OADEV); memory grows with the record", Estimator::Full),
    ("plain", "The textbook non-overlapping deviation (ADEV), stride tau", Estimator::Plain),
];

const DEVIATIONS: [(&str, &str, Deviation); 2] = [
    ("allan", "Allan deviation", Deviation::Allan),
    ("hadamard", "Hadamard deviation, blind to a linear drift of the rate", Deviation::Hadamard),
];

const DETRENDS: [(&str, &str, Detrend); 2] = [
    ("linear", "The regression line over the record", Detrend::Line),
    ("temperature", "What the bias of gyroscope and accelerometer follows of the temperature", Detrend::Temperature),
];

/// One of `choices` by its name.
fn one_of<T: Copy + Send + Sync>(choices: &'static [(&str, &str, T)]) -> impl TypedValueParser<Value = T> {
    let described = choices.iter().map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(described).try_map(|name| {
        choices.iter().find(|(known, ..)| *known == name).map(|(.., choice)| *choice).ok_or("there is no such choice")
    })
}

/// A time that something can be measured in.
pub(super) fn length(text: &str) -> Result<Duration, String> {
    match humantime::parse_duration(text) {
        Ok(Duration::ZERO) => Err("no sample comes in no time: give a time such as 10min".into()),
        Ok(length) => Ok(length),
        Err(error) => Err(error.to_string()),
    }
}

pub(super) fn confidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(level) if level > 0.0 && level < 1.0 => Ok(level),
        Ok(level) => Err(format!("{level} is not between 0 and 1; 0.95 is usual")),
        Err(_) => Err("not a number between 0 and 1".into()),
    }
}

fn yes_or_no(text: &str) -> Result<bool, String> {
    match text {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err("neither \"yes\" nor \"no\"".into()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if hz.is_finite() && (1e-3..=1e5).contains(&hz) => Ok(hz),
        Ok(hz) => Err(format!("{hz} Hz is not between 0.001 and 100000 Hz")),
        Err(_) => Err("not a number of hertz".into()),
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct FileArgs {
    /// Captures: text, raw bytes, CSV, recordings, and ROS bags (.bag, .db3, .mcap, or the folder
    /// of one), also gzip or zstd, recognised by content; "-" is standard input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    /// Averaging times of the deviations, with --estimator full: octave (1, 2, 4 ... samples),
    /// decade (1, 2, 4, 10, 20, 40 ...), all (every one up to 1024 samples, then 128 in each
    /// octave), or seconds with commas between them, each a multiple of the sample interval. N, B
    /// and K rest on the octaves whatever is given [default: octave]
    #[arg(long, value_name = "TAUS")]
    pub(crate) taus: Option<AveragingTimes>,

    /// Columns of a CSV file of any inertial sensor, as OURS=THEIRS:UNIT, for example
    /// gyro_x=wx:deg/s,accel_z=az:g,t=stamp:ns; value=NAME:UNIT, in any unit, is a series of no
    /// sensor: its deviation is that of the numbers as rate data
    ///
    /// OURS: gyro_ accel_ mag_ with x y z, yaw pitch roll, quat_ with x y z w, temperature,
    /// pressure, value, t for the times, raw for a column of sentences (raw=NAME, without a unit).
    ///
    /// THEIRS: the name at the head of the column, which may hold spaces and brackets, or its
    /// number from 1, as in t=1:ns.
    ///
    /// UNIT: rad/s deg/s deg/h mdeg/s; m/s^2 g mg; gauss uT mT nT; deg rad; 1 for quat_; degC K;
    /// kPa hPa Pa.
    ///
    /// Times: s ms us ns since any moment; iso for dates with the year first
    /// (2023-03-06T02:25:02.45Z, 2023/03/06/02:25:02.45); dmy, mdy; clock for a time of day; two
    /// columns that are added, as in t=secs:s+nsecs:ns.
    #[arg(long, value_name = "MAP")]
    pub(crate) columns: Option<ColumnMap>,

    /// Stream to measure, where a file has several: the topic of a bag, or a group of columns of
    /// one rate in a CSV file, such as "gyro accel" or mag
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Option<String>,

    /// Averaging window of gyroscope and accelerometer that register 85 had, in samples at 800 Hz,
    /// where the capture does not contain the register
    #[arg(long, value_name = "N", conflicts_with = "columns", value_parser = clap::value_parser!(u32).range(1..=800))]
    pub(crate) window: Option<u32>,

    /// Whether a filter has taken the bias out of the angular rates, which a CSV file of values
    /// does not say. With yes, B, K and R of the gyroscope are not measurable
    #[arg(long, value_name = "yes|no", value_parser = yes_or_no)]
    pub(crate) compensated: Option<bool>,

    #[command(flatten)]
    pub(crate) log: LogArgs,
}

impl FileArgs {
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            averaging_times: self.taus.clone().unwrap_or_default(),
            window: self.window,
            compensated: self.compensated,
            ..self.measure.settings()
        }
    }

    /// Why these averaging times cannot be given.
    pub(super) fn refused_taus(&self) -> Option<String> {
        let taus = self.taus.as_ref().filter(|taus| **taus != AveragingTimes::Octave)?;
        if self.measure.estimator != Estimator::Full {
            let text = "--taus is for --estimator full: the others keep the sums of octaves alone, in bounded memory. Add --estimator full";
            return Some(text.into());
        }
        let missing = taus.no_multiples(1.0 / self.measure.rate?);
        missing.first().map(|missing| format!("--taus: {missing}"))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReplayArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    /// Also take the recordings as of one sensor: one curve, N, B and K with the spread between
    /// recordings and an interval for the next one, and which of them is an outlier
    #[arg(long, conflicts_with = "speed")]
    pub(crate) pool: bool,

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

    /// The sensor was not switched off between the recordings, which they do not say: differences
    /// of means are then tested against its noise over the time between
    #[arg(long)]
    pub(crate) stayed_on: bool,

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
