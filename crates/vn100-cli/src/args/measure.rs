//! Options of every command that measures, and of those that read captures.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use clap::{
    ColorChoice, ValueEnum,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};
use imu_noise::{Deviation, Estimator};
use vn100_analysis::{AveragingTimes, DEFAULT_CONFIDENCE, Detrend, Goal, NoiseFigure, Settings};
use vn100_capture::ColumnMap;
use vn100_pipeline::Speed;
use vn100_protocol::stream::{MeasuredFrames, ReadOptions};
use vn100_report::{RosFrame, Stamps};

use super::{
    LogArgs, ServeArgs, ViewArgs,
    duration::{duration, length},
};

/// What is measured and how, the same for every command that measures.
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

    /// Compare with this data sheet (TOML) instead of the VN-100's, as in
    /// crates/vn100-report/datasheets/vn-100.toml
    #[arg(long, help_heading = TARGETS, value_name = "FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    /// Remove from each channel before its deviation is computed: a line, which lowers it at the
    /// longest tau; or the temperature dependence, where it is significant
    #[arg(long, value_parser = one_of(&DETRENDS))]
    pub(crate) detrend: Option<Detrend>,

    /// Also fit Q, quantization noise, of sensors that count steps of angle or velocity; the
    /// rounding of a printed rate is white noise, in N
    #[arg(long)]
    pub(crate) quantization: bool,

    /// Two-sided level of every interval, between 0 and 1 [default: 0.95]
    #[arg(long, value_name = "P", value_parser = confidence)]
    pub(crate) confidence: Option<f64>,

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
            detrend: self.detrend,
            quantization: self.quantization,
            until: self.until.clone(),
            confidence: self.confidence.unwrap_or(DEFAULT_CONFIDENCE),
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

/// What the result of one source contains, and in which form.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct ResultArgs {
    /// Also fit models for Kalman filters: a first-order Gauss-Markov process, and a conservative
    /// N and K that bound the whole Allan curve
    #[arg(long)]
    pub(crate) filter_models: bool,

    /// Print every section as tables, instead of the summary
    #[arg(long, conflicts_with = "show")]
    pub(crate) full: bool,

    /// Print these sections as tables, instead of the summary
    #[arg(long, value_name = "SECTION", value_enum, value_delimiter = ',')]
    pub(crate) show: Vec<Section>,

    /// Colours of the summary
    #[arg(long, value_name = "WHEN", value_enum, default_value_t)]
    pub(crate) color: ColorChoice,

    /// Print one JSON document at the end, and nothing else, on standard output
    #[arg(long, conflicts_with_all = ["ndjson", "full", "show"])]
    pub(crate) json: bool,

    /// Print one JSON document per line, for every second of data time and at the end; "thin"
    /// for short ones. A live source without data gives a heartbeat every second by the clock
    #[arg(long, value_name = "FORM", value_enum, num_args = 0..=1, require_equals = true,
        default_missing_value = "whole", conflicts_with_all = ["full", "show"])]
    pub(crate) ndjson: Option<Ndjson>,

    /// Write the samples as CSV, with the time of each; "-" for standard output, instead of the
    /// result. An existing file is never replaced
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) samples: Option<PathBuf>,
}

impl ResultArgs {
    /// Why these outputs cannot be given together.
    pub(super) fn refused(&self, sources: usize) -> Option<String> {
        let samples = self.samples.as_ref()?;
        if sources > 1 {
            return Some("--samples takes the samples of one source: give one".into());
        }
        let has_other = self.json || self.ndjson.is_some() || self.full || !self.show.is_empty();
        let refusal = "--samples - writes to standard output, where the result would be: name a file";
        (samples == Path::new("-") && has_other).then(|| refusal.into())
    }
}

/// What the lines of a measurement under way hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Ndjson {
    /// All of vn100.analysis/1 that is known so far
    Whole,
    /// vn100.progress/1, less than 2 KB: samples, standard deviations, N, warnings, targets
    Thin,
}

/// A section of the full text of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Section {
    /// Every warning in full: what was found, why it matters, what to do
    Warnings,
    /// Mean, standard deviation, minimum and maximum, and the length of each vector
    Statistics,
    /// Skewness, kurtosis, whether it is Gaussian; changes along the record, and what would show
    Distribution,
    /// The deviation at each averaging time, with its confidence limits
    Deviations,
    /// The noise parameters in every unit, with intervals and quality of the fit
    Noise,
    /// The comparison with the data sheet
    Verdicts,
}

impl ResultArgs {
    pub(crate) fn format(&self) -> OutputFormat {
        match (self.json, self.ndjson) {
            (true, _) => OutputFormat::Json,
            (_, Some(form)) => OutputFormat::Ndjson(form),
            _ if self.samples.as_deref() == Some(Path::new("-")) => OutputFormat::Samples,
            _ if self.full => OutputFormat::Sections(Section::value_variants().to_vec()),
            _ if !self.show.is_empty() => OutputFormat::Sections(self.show.clone()),
            _ => OutputFormat::Summary(self.color),
        }
    }
}

/// Heading of the options that decide about the end and the exit status.
const TARGETS: &str = "Targets and limits";

/// How results are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum OutputFormat {
    /// As the summary, each when it is there.
    Summary(ColorChoice),
    /// As these sections of the full text, each when it is there.
    Sections(Vec<Section>),
    /// As one JSON document at the end.
    Json,
    /// As text: the source, and its warnings.
    Head,
    /// Not at all: standard output has the samples.
    Samples,
    /// As JSON documents in lines, written during the measurement.
    Ndjson(Ndjson),
}

impl OutputFormat {
    /// Whether results are text, so that a view may be shown before.
    pub(crate) const fn is_text(&self) -> bool {
        matches!(self, Self::Summary(_) | Self::Sections(_))
    }

    /// The lines written during the measurement; `None` where there are none.
    pub(crate) const fn lines(&self) -> Option<Ndjson> {
        match self {
            Self::Ndjson(form) => Some(*form),
            _ => None,
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

const DETRENDS: [(&str, &str, Detrend); 2] = [
    ("linear", "The regression line over the record", Detrend::Line),
    ("temperature", "The temperature dependence of the bias of gyroscope and accelerometer", Detrend::Temperature),
];

const ROS_FRAMES: [(&str, &str, RosFrame); 2] = [
    ("ned", "The sensor's own: forwards, right, down, against north, east, down", RosFrame::Ned),
    ("enu", "As ROS assumes them: forwards, left, up, against east, north, up", RosFrame::Enu),
];

const STAMPS: [(&str, &str, Stamps); 2] = [
    ("fitted", "On the even grid of the measured rate, where no sample is missing", Stamps::Fitted),
    ("arrival", "When each line arrived", Stamps::Arrival),
];

/// One of `choices` by its name.
fn one_of<T: Copy + Send + Sync>(choices: &'static [(&str, &str, T)]) -> impl TypedValueParser<Value = T> {
    let described = choices.iter().map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(described).try_map(|name| {
        choices.iter().find(|(known, ..)| *known == name).map(|(.., choice)| *choice).ok_or("unknown choice")
    })
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
        _ => Err("expected \"yes\" or \"no\"".into()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if hz.is_finite() && (1e-3..=1e5).contains(&hz) => Ok(hz),
        Ok(hz) => Err(format!("{hz} Hz is not between 0.001 and 100000 Hz")),
        Err(_) => Err("not a number of hertz".into()),
    }
}

#[derive(Debug, Clone, clap::Args)]
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

    /// Do not join the parts of a recording that was cut by --rotate: a result for each file
    #[arg(long, help_heading = "Capture")]
    pub(crate) separate: bool,

    /// Averaging window of gyroscope and accelerometer that register 85 had, in samples at 800 Hz,
    /// where the capture does not contain the register
    #[arg(long, help_heading = "Capture", value_name = "N", conflicts_with = "columns", value_parser = clap::value_parser!(u32).range(1..=800))]
    pub(crate) window: Option<u32>,

    /// Whether a filter has removed the bias of the angular rates, which a CSV file of values does
    /// not contain. With yes, B, K and R of the gyroscope are not measurable
    #[arg(long, help_heading = "Capture", value_name = "yes|no", value_parser = yes_or_no)]
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

    /// Also pool the recordings of one sensor: one curve, N, B and K with the spread between
    /// recordings, a prediction interval for the next one, and outliers
    #[arg(long, help_heading = "Measurement", conflicts_with = "speed")]
    pub(crate) pool: bool,

    /// Replay in the live view or on the live page, at this many seconds of data a second, as in
    /// "1x" or "10x", or "max" for as fast as the machine can
    #[arg(long, help_heading = "Output", value_name = "SPEED", conflicts_with_all = ["json", "ndjson", "samples"])]
    pub(crate) speed: Option<Speed>,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    #[command(flatten)]
    pub(crate) serve: ServeArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ArchiveArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// Keep the sums of each recording here; a file that is as it was is then not read again
    #[arg(long, help_heading = "Output", value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,

    /// Write the document here, ending in .json, or the table, ending in .csv [default: standard
    /// output]
    #[arg(short, long, help_heading = "Output", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Print the table instead of the document: a row for each recording and channel
    #[arg(long, help_heading = "Output")]
    pub(crate) csv: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// The sensor stayed on between the recordings: differences of means are then tested against
    /// its noise over the time between
    #[arg(long, help_heading = "Measurement")]
    pub(crate) stayed_on: bool,

    /// Print one JSON document, and nothing else, on standard output
    #[arg(long, help_heading = "Output")]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) files: FileArgs,

    /// The page to write, ending in .html; another name begins the names of what is exported, and
    /// no page is written [default: NAME.html in the working folder, of the capture NAME]
    #[arg(short, long, help_heading = "Output", value_name = "OUT")]
    pub(crate) output: Option<PathBuf>,

    /// Open the page with the program that shows such pages; without one the page is written all
    /// the same
    #[arg(long, help_heading = "Output")]
    pub(crate) open: bool,

    /// Replace existing files
    #[arg(long, help_heading = "Output")]
    pub(crate) force: bool,

    /// Write the numbers for other programs beside it: once for each form, or with commas between
    /// them
    #[arg(long, help_heading = "Exports", value_name = "FORM", value_enum, value_delimiter = ',')]
    pub(crate) export: Vec<ExportForm>,

    /// Also give the models for filters, in the export as JSON
    #[arg(long, help_heading = "Exports")]
    pub(crate) filter_models: bool,

    /// Figures of the exports svg and png, by kind, channel or name: allan, graphical, gyro_y,
    /// spectrum-accel [default: all]
    #[arg(long, help_heading = "Exports", value_name = "LIST", value_delimiter = ',')]
    pub(crate) figures: Vec<String>,

    /// Axes of the export mcap
    #[arg(long, help_heading = "Exports", value_parser = one_of(&ROS_FRAMES), default_value = "ned")]
    pub(crate) ros_frame: RosFrame,

    /// Times of the messages of the export mcap
    #[arg(long, help_heading = "Exports", value_parser = one_of(&STAMPS), default_value = "fitted")]
    pub(crate) stamps: Stamps,

    /// How long Kalibr integrates: its random walk drifts over this time as the bias instability
    /// does
    #[arg(long, help_heading = "Exports", value_name = "T", value_parser = length, default_value = "60s")]
    pub(crate) kalibr_span: Duration,

    /// Refuse imu.yaml for Kalibr where one of its values is not estimated, with exit code 1
    #[arg(long, help_heading = "Exports")]
    pub(crate) require_estimated: bool,
}

impl ExportForm {
    /// A folder of figures.
    pub(crate) const fn is_figures(self) -> bool {
        matches!(self, Self::Svg | Self::Png)
    }
}

impl ReportArgs {
    /// The page, or the beginning of the names where no page is wanted.
    pub(crate) fn output(&self) -> PathBuf {
        self.output.clone().unwrap_or_else(|| match &self.files.files[..] {
            [only] if only == Path::new("-") => "stdin.html".into(),
            [only] => page_of(only),
            _ => "report.html".into(),
        })
    }

    /// What the options ask for together, and cannot have.
    pub(super) fn refused(&self) -> Option<String> {
        let output = self.output();
        let is_pdf = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("pdf"));
        let has_figures = self.export.iter().any(|form| form.is_figures());
        if !self.figures.is_empty() && !has_figures {
            return Some("--figures selects what --export svg or png writes: add one of them".into());
        }
        if is_page(&output) || (!is_pdf && !self.export.is_empty() && !self.open) {
            return self.files.refused_taus();
        }
        let advice = match is_pdf {
            true => "name a page, and print it as PDF in a browser",
            false if self.open => "name a page to open",
            false => "and nothing is exported: name a page, or --export something",
        };
        Some(format!("{} does not end in .html, {advice}", output.display()))
    }
}

/// Whether that is the name of a page.
pub(crate) fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("html") || end.eq_ignore_ascii_case("htm"))
}

/// The page of a capture: its name, in the working folder.
fn page_of(capture: &Path) -> PathBuf {
    const COMPRESSED: [&str; 5] = ["gz", "zst", "bz2", "xz", "zip"];
    let name = Path::new(capture.file_name().unwrap_or("report".as_ref()));
    let is_compressed =
        name.extension().is_some_and(|end| COMPRESSED.iter().any(|form| end.eq_ignore_ascii_case(form)));
    let name = if is_compressed { name.with_extension("") } else { name.to_owned() };
    name.with_extension("html")
}

/// What a report is exported as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportForm {
    /// Metadata, curves, statistics, parameters in all units, fits, verdicts, warnings, spectrum,
    /// segments and histograms as tables
    Csv,
    /// One table of all captures for incoming inspection: a row each with identity, N, B and K in
    /// the units of data sheets, verdicts and warnings
    Lot,
    /// The document of `vn100 replay --json`
    Json,
    /// imu.yaml for Kalibr: N as estimated, and the larger of K and 1.15 B/√span as random walk;
    /// an upper bound, marked in a comment, where there is no estimate
    Kalibr,
    /// Each figure as SVG, in a folder
    Svg,
    /// Each figure as PNG, in a folder
    Png,
    /// The samples as ROS 2 messages: Imu, MagneticField, Temperature and FluidPressure
    Mcap,
}
