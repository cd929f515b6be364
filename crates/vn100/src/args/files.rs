//! Options of the commands that read captures.

use std::path::PathBuf;

use imu_noise::Estimator;
use vn100_analysis::{AveragingTimes, Settings};
use vn100_capture::ColumnMap;
use vn100_session::Speed;

use super::{JsonArgs, LogArgs, MeasureArgs, ResultArgs, ServeArgs, ViewArgs, choices::one_of};

#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct FileArgs {
    /// Captures: text, raw bytes, CSV, recordings, and ROS bags (.bag, .db3, .mcap, or the folder
    /// of one), also gzip or zstd, recognised by content; "-" is standard input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    /// Averaging times of the deviations, with --estimator full: octave (1, 2, 4 ... samples),
    /// decade (1, 2, 4, 10, 20, 40 ...), or seconds with commas between them, each a multiple of
    /// the sample interval. N, B and K rest on the octaves whatever is given [default: octave]
    #[arg(long, help_heading = "Measurement", value_name = "TAUS")]
    pub(crate) taus: Option<AveragingTimes>,

    /// Columns of a CSV file of any inertial sensor, as OURS=THEIRS:UNIT, for example
    /// gyro_x=wx:deg/s,accel_z=az:g,t=stamp:ns; value=NAME:UNIT, in any unit, is a neutral series,
    /// whose deviation is that of the numbers as rate data
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
    /// (2023-03-06T02:25:02.45Z, 2023/03/06/02:25:02.45); dmy, mdy; clock for a time of day, mmss
    /// for minutes and seconds (25:02.4); two columns that are added, as in t=secs:s+nsecs:ns. In a
    /// bag THEIRS is the path of a number in the messages, as in
    /// gyro_x=imu.angular_velocity.x:rad/s, and a time may be such a number.
    #[arg(long, help_heading = "Capture", value_name = "MAP")]
    pub(crate) columns: Option<ColumnMap>,

    /// Stream to measure, where a file has several: the topic of a bag, or a group of columns of
    /// one rate in a CSV file, such as "gyro accel" or mag
    #[arg(long, help_heading = "Capture", value_name = "NAME")]
    pub(crate) topic: Option<String>,

    /// Averaging window of gyroscope and accelerometer that register 85 had, in samples at 800 Hz,
    /// where the capture does not contain the register
    #[arg(long, help_heading = "Capture", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=800))]
    pub(crate) window: Option<u32>,

    /// Whether a filter has removed the bias of the angular rates, which a CSV file of values does
    /// not contain. With yes, B, K and R of the gyroscope are not measurable
    #[arg(long, help_heading = "Capture", value_name = "yes|no", value_parser = one_of(&YES_OR_NO))]
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

    /// Replay in the live view or on the live page, at this many seconds of data a second, as in
    /// "1x" or "10x", or "max" for as fast as the machine can
    #[arg(long, help_heading = "Output", value_name = "SPEED", conflicts_with_all = ["json", "ndjson", "samples"])]
    pub(crate) speed: Option<Speed>,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    #[command(flatten)]
    pub(crate) serve: ServeArgs,
}

impl ReplayArgs {
    pub(super) fn refused(&self) -> Option<String> {
        let Self { files, result, speed, serve, .. } = self;
        if speed.is_none() && serve.serve.is_some() {
            return Some("--serve shows a replay while it lasts: give its pace, as in --speed 10x".into());
        }
        (files.refused_taus())
            // parts of a recording are one source, which the files themselves say
            .or_else(|| result.refused(1))
            .or_else(|| serve.refused(files.files.iter().map(|file| file.display().to_string())))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct ArchiveArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// Write the rows here, as lines of JSON in a file that ends in .jsonl, or as a table in one
    /// that ends in .csv. Rows that are there are kept: a file whose rows have its present path, size
    /// and time, by the same options, is not read again; its other rows are replaced [default: lines of JSON on standard output]
    #[arg(short, long, help_heading = "Output", value_name = "FILE", value_parser = lines_or_table)]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// The sensor of a recording, in place of its serial number or its folder: once for all, or for
    /// each recording in their order
    #[arg(long, help_heading = "Measurement", value_name = "NAME")]
    pub(crate) sensor: Vec<String>,

    #[command(flatten)]
    pub(crate) output: JsonArgs,
}

fn lines_or_table(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().map(|ending| ending.to_ascii_lowercase()) {
        Some(ending) if ending == "jsonl" || ending == "csv" => Ok(path),
        _ => Err("it must end in .jsonl, for lines of JSON, or .csv, for a table".into()),
    }
}

const YES_OR_NO: [(&str, &str, bool); 2] = [("yes", "Bias removed", true), ("no", "Bias kept", false)];
