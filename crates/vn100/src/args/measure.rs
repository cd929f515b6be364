//! Options of every command that measures.

use std::{path::PathBuf, time::Duration};

use imu_noise::{Deviation, Estimator};
use vn100_analysis::{Coast, DEFAULT_CONFIDENCE, Goal, NoiseFigure, Settings};
use vn100_protocol::stream::{MeasuredFrames, ReadOptions};

use super::{
    choices::one_of,
    duration::{coast, duration, length},
};

/// Heading of the options that decide about the end and the exit status.
pub(super) const TARGETS: &str = "Targets and limits";

#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Measurement")]
pub(crate) struct MeasureArgs {
    /// Nominal sample rate in hertz, where the capture does not contain it [default: 40 for
    /// sentences, with a warning; none for values without times]
    #[arg(short, long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,

    /// Overlap of the windows of the deviation
    #[arg(long, value_parser = one_of(&ESTIMATORS), default_value = "strided")]
    pub(crate) estimator: Estimator,

    /// Kind of deviation
    #[arg(long, value_parser = one_of(&DEVIATIONS), default_value = "allan")]
    pub(crate) deviation: Deviation,

    /// Exclude this much data time at the beginning (warm-up), for example 10min; a number without
    /// a unit is seconds
    #[arg(long, value_name = "T", value_parser = duration, default_value = "0s")]
    pub(crate) skip: Duration,

    /// Stop after this much data time, counted from the first sample, for example 1h; a number
    /// without a unit is seconds
    #[arg(short, long, value_name = "T", value_parser = length)]
    pub(crate) duration: Option<Duration>,

    /// Stop when a parameter reaches the given precision, as in "gyro N ±5%": a group (gyro, accel,
    /// mag) or a channel, N, B or K, and half the width of its interval; exit with 4 if the data
    /// ends before
    #[arg(long, help_heading = TARGETS, value_name = "TARGET")]
    pub(crate) until: Vec<Goal>,

    /// Exit with 4 unless a parameter passes the limits of the data sheet, as in "gyro B": a group
    /// (gyro, accel, mag) or a channel, and N, B or K
    #[arg(long, help_heading = TARGETS, value_name = "PARAMETER")]
    pub(crate) fail_on: Vec<NoiseFigure>,

    /// Treat the typical figures of the data sheet as limits, which pass and fail
    #[arg(long, help_heading = TARGETS)]
    pub(crate) typical_is_limit: bool,

    /// Compare with this data sheet instead of the VN-100's: one that `vn100 explain` lists, or a
    /// file (TOML) as in crates/vn100-report/datasheets
    #[arg(long, help_heading = TARGETS, value_name = "NAME|FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    /// Also fit Q, quantization noise, of sensors that count steps of angle or velocity; the
    /// rounding of a printed rate is white noise, in N
    #[arg(long)]
    pub(crate) quantization: bool,

    /// Two-sided level of every interval, between 0 and 1 [default: 0.95]
    #[arg(long, value_name = "P", value_parser = confidence)]
    pub(crate) confidence: Option<f64>,

    /// Length of a coast for which the drift is given, as in "5min", and of the rest that gives the
    /// bias if it is another, as in "10s+5min"; once for each, or with commas between them
    /// [default: 10s, 1min, 10min]
    #[arg(long, value_name = "[REST+]T", value_parser = coast, value_delimiter = ',')]
    pub(crate) coast: Vec<Coast>,

    /// Accept sentences without a checksum
    #[arg(long, help_heading = "Capture")]
    pub(crate) accept_unchecked: bool,

    /// What to measure where sentences and binary packets are mixed [default: what comes first]
    #[arg(long, help_heading = "Capture", value_parser = one_of(&MEASURED))]
    pub(crate) measure: Option<MeasuredFrames>,
}

impl MeasureArgs {
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            rate_hz: self.rate,
            estimator: self.estimator,
            deviation: self.deviation,
            skip: self.skip,
            duration: self.duration,
            quantization: self.quantization,
            until: self.until.clone(),
            confidence: self.confidence.unwrap_or(DEFAULT_CONFIDENCE),
            coasts: self.coast.clone(),
            ..Settings::default()
        }
    }

    pub(crate) fn read_options(&self) -> ReadOptions {
        ReadOptions {
            accept_unchecked: self.accept_unchecked,
            measured: self.measure.unwrap_or_default(),
            ..ReadOptions::default()
        }
    }
}

/// The windows of the deviation: name, help, estimator.
const ESTIMATORS: [(&str, &str, Estimator); 3] = [
    ("strided", "Octave windows at stride tau/16: fully overlapping up to m = 16, bounded memory", Estimator::Strided),
    ("full", "Fully overlapping at every octave (OADEV); memory grows with the record", Estimator::Full),
    ("plain", "Non-overlapping (ADEV), stride tau", Estimator::Plain),
];

const DEVIATIONS: [(&str, &str, Deviation); 2] = [
    ("allan", "Allan deviation", Deviation::Allan),
    ("hadamard", "Hadamard deviation, insensitive to a linear drift of the rate", Deviation::Hadamard),
];

const MEASURED: [(&str, &str, MeasuredFrames); 2] = [
    ("sentences", "Sentences such as $VNYMR", MeasuredFrames::Sentences),
    ("packets", "Binary packets, with the time of the sensor where they carry it", MeasuredFrames::Packets),
];

pub(super) fn confidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(level) if level > 0.0 && level < 1.0 => Ok(level),
        Ok(level) => Err(format!("{level} is not between 0 and 1; 0.95 is usual")),
        Err(_) => Err("not a number between 0 and 1".into()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if hz.is_finite() && (1e-3..=1e5).contains(&hz) => Ok(hz),
        Ok(hz) => Err(format!("{hz} Hz is not between 0.001 and 100000 Hz")),
        Err(_) => Err("not a number of hertz".into()),
    }
}
