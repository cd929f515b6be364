//! The command line.

mod link;
mod measure;

use std::{path::PathBuf, time::Duration};

use clap::{
    CommandFactory, Parser,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
    error::ErrorKind,
};
use imu_noise::Estimator;
use vn100_analysis::{DEFAULT_CONFIDENCE, Want};
use vn100_protocol::{AsyncRate, AsyncType, BaudRate, MESSAGES};
use vn100_sim::Message;

pub(crate) use link::{ChangeArgs, LinkArgs, RecordingArgs, SimSensorArgs, SourceName};
use link::{baud_rate, output_rate};
pub(crate) use measure::{
    CompareArgs, ExportForm, FileArgs, MeasureArgs, OutputFormat, ReplayArgs, ReportArgs, ResultArgs,
};
use measure::{confidence, length};

/// Live Allan deviation and statistics for the VectorNav VN-100.
#[derive(Debug, Parser)]
#[command(
    name = "vn100",
    version,
    max_term_width = 100,
    after_help = "Exit codes: 0 good, 1 failed, 2 usage, 3 no source or nothing valid in it, 4 --until or --fail-on not met."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Subcommand,
}

impl Args {
    /// Refuses what single options cannot.
    pub(crate) fn checked(self) -> Result<Self, clap::Error> {
        let refusal = match &self.command {
            Subcommand::Attach(args) if args.measure.estimator == Estimator::Full => Some(
                "--estimator full is for replay: its memory grows with the record, and a live sensor has no end. Record it, and replay that"
                    .into(),
            ),
            Subcommand::Attach(args) if args.recording.resume && args.record.is_empty() => {
                Some("--resume goes on with a recording: name it with --record".into())
            }
            Subcommand::Attach(AttachArgs { change, .. }) | Subcommand::Record(RecordArgs { change, .. }) => {
                change.not_measured()
            }
            Subcommand::Replay(ReplayArgs { files, pool: true, .. }) if files.files.len() < 2 => {
                Some("--pool is for two recordings or more, and makes a result of three or more".into())
            }
            Subcommand::Replay(ReplayArgs { files, .. }) | Subcommand::Report(ReportArgs { files, .. }) => {
                files.refused_taus()
            }
            Subcommand::Compare(args) if args.files.taus.is_some() => {
                Some("--taus is for replay and report: records are compared octave by octave".into())
            }
            _ => None,
        };
        match refusal {
            Some(refusal) => Err(Self::command().error(ErrorKind::ArgumentConflict, refusal)),
            None => Ok(self),
        }
    }
}

#[derive(Debug, clap::Subcommand)]
pub(crate) enum Subcommand {
    /// Measure live sensors, until stopped; nothing is changed on them unless asked
    Attach(AttachArgs),
    /// Record a live sensor without measuring anything
    Record(RecordArgs),
    /// Ask a sensor what it is, what it sends, and what its line can carry
    Info(InfoArgs),
    /// Change what a sensor sends: checked before, read back after
    Configure(ConfigureArgs),
    /// Run recorded captures through the pipeline, as fast as the machine can
    Replay(ReplayArgs),
    /// Compare captures: which is the quietest, which is disturbed, and whether they differ beyond
    /// chance
    Compare(CompareArgs),
    /// Plan a measurement: message, rate, window, line speed, and how long for what
    Plan(PlanArgs),
    /// Write the report of captures: one page with every figure and table, and the numbers for
    /// other programs
    Report(ReportArgs),
    /// Emulate a sensor whose noise is known: on a serial port, or straight into a capture
    Sim(SimArgs),
    /// Compare with published values: the test suites of NIST SP 1065 and NBS Monograph 140, and
    /// exact degrees of freedom and bounds; exit with 1 where one differs
    Selftest(SelftestArgs),
    /// List the serial ports, those a VN-100 is likely on first
    Ports(PortsArgs),
    /// Print the completions of the command line for a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write one for each command
    Man(ManArgs),
}

#[derive(Debug, Clone, clap::Args)]
pub(crate) struct AttachArgs {
    /// Serial ports such as /dev/ttyUSB0 or COM3, "sim" for an emulated sensor, tcp://host:port for
    /// a serial server, or "-" for bytes on standard input
    ///
    /// The connection to a serial server is neither encrypted nor authenticated: anyone on the
    /// network path can read or modify the data and commands. The checksums detect accidents only.
    /// Use a network you trust, or a tunnel.
    #[arg(required = true, value_name = "SOURCE")]
    pub(crate) sources: Vec<SourceName>,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) change: ChangeArgs,

    /// Read temperature, pressure and uncompensated measurements every ten seconds between the
    /// lines
    #[arg(long, conflicts_with = "listen_only")]
    pub(crate) temperature: bool,

    /// Keep the raw bytes with their arrival times, as MCAP; once for each source, in their order
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) recording: RecordingArgs,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    #[command(flatten)]
    pub(crate) result: ResultArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct RecordArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", tcp://host:port, or "-" for standard
    /// input
    #[arg(value_name = "SOURCE")]
    pub(crate) source: SourceName,

    /// The recording to write, as MCAP; an existing file is never replaced
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Stop after this much data time, for example 5h
    #[arg(long, value_name = "T", value_parser = length)]
    pub(crate) duration: Option<Duration>,

    /// Read temperature, pressure and uncompensated measurements every ten seconds between the
    /// lines
    #[arg(long, conflicts_with = "listen_only")]
    pub(crate) temperature: bool,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) change: ChangeArgs,

    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
}

impl From<RecordArgs> for AttachArgs {
    fn from(args: RecordArgs) -> Self {
        Self {
            sources: vec![args.source],
            link: args.link,
            change: args.change,
            temperature: args.temperature,
            record: vec![args.output],
            recording: args.recording,
            measure: MeasureArgs { duration: args.duration, ..MeasureArgs::default() },
            result: ResultArgs::default(),
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", or tcp://host:port
    #[arg(value_name = "SOURCE")]
    pub(crate) source: SourceName,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    /// Print a JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ConfigureArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", or tcp://host:port
    #[arg(value_name = "SOURCE")]
    pub(crate) source: SourceName,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) change: ChangeArgs,

    /// Set the baud rate: 9600 19200 38400 57600 115200 128000 230400 460800 921600
    #[arg(long, value_name = "N", value_parser = |text: &str| baud_rate(text).map(BaudRate::bits_per_s))]
    pub(crate) set_baud: Option<u32>,

    /// Append a counter to each line, so that dropped samples are counted exactly; "off" ends that
    #[arg(long, value_name = "on|off", num_args = 0..=1, default_missing_value = "on", value_parser = on_or_off)]
    pub(crate) count: Option<bool>,

    /// Keep all settings through switching off
    #[arg(long)]
    pub(crate) save: bool,
}

/// Diagnostics; without them, warnings only.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct LogArgs {
    /// Log link events, commands and rejected lines to stderr (disables the live view)
    #[arg(short, long)]
    pub(crate) verbose: bool,

    /// Write the log to FILE (must not exist)
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PlanArgs {
    /// What the record shall show, as in "gyro N ±5%", "gyro B", "gyro K >= 2e-7" or "accel B >=
    /// 0.02 mg", or a limit on which the verdict shall be decided, as in "accel B <= 0.04 mg"; a
    /// table of the usual wants unless given
    #[arg(long, value_name = "WANT")]
    pub(crate) want: Vec<Want>,

    /// Output rate in hertz, if it is fixed: 1 2 4 5 10 20 25 40 50 100 200
    #[arg(long, value_name = "HZ", value_parser = output_rate)]
    pub(crate) rate: Option<AsyncRate>,

    /// Baud rate, if it is fixed
    #[arg(long, value_name = "N", value_parser = baud_rate)]
    pub(crate) baud: Option<BaudRate>,

    /// Two-sided level of the intervals, between 0 and 1
    #[arg(long, value_name = "P", value_parser = confidence, default_value_t = DEFAULT_CONFIDENCE)]
    pub(crate) confidence: f64,

    /// Take the noise from the figures of this TOML file instead of the VN-100's
    #[arg(long, value_name = "FILE")]
    pub(crate) datasheet: Option<PathBuf>,

    /// Print a JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SimArgs {
    /// Write a capture at once instead of emulating a port, with a time for each line where the
    /// name ends in .mcap; "-" is standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Length of the capture [default: 60s], or how long to emulate the port [default: until
    /// stopped]; for example 5h
    #[arg(long, value_name = "T", value_parser = humantime::parse_duration)]
    pub(crate) duration: Option<Duration>,

    /// Output rate of the capture in hertz, one the sensor has: 1 2 4 5 10 20 25 40 50 100 200
    /// [default: 40]
    #[arg(long, value_name = "HZ", requires = "output")]
    pub(crate) rate: Option<u32>,

    /// Message of the capture; its angular rates are those of the sensor in either
    #[arg(long, value_name = "NAME", value_parser = sim_message(), ignore_case = true, default_value = "VNYMR", requires = "output")]
    pub(crate) message: &'static Message,

    #[command(flatten)]
    pub(crate) sensor: SimSensorArgs,

    /// A name that leads to the emulated port, whatever the system calls it; after an unplugging
    /// with `:other` it is PATH-1
    #[arg(long, value_name = "PATH", conflicts_with = "output")]
    pub(crate) link: Option<PathBuf>,

    /// Hand bytes on as a USB adapter does: in pieces of 62, or after this time, 16ms unless given
    #[arg(long, value_name = "T", value_parser = humantime::parse_duration, num_args = 0..=1,
        default_missing_value = "16ms", conflicts_with = "output")]
    pub(crate) usb: Option<Duration>,

    /// Replace an existing capture
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

/// The messages of emulated captures: those that are measured.
fn sim_message() -> impl TypedValueParser<Value = &'static Message> {
    let described = MESSAGES.iter().map(|layout| {
        let message = AsyncType::from_header(layout.message.as_bytes());
        PossibleValue::new(&*layout.message).help(message.and_then(AsyncType::description).unwrap_or_default())
    });
    PossibleValuesParser::new(described)
        .try_map(|name| Message::named(&name.to_ascii_uppercase()).ok_or("the emulated sensor does not send it"))
}

#[derive(Debug, clap::Args)]
pub(crate) struct PortsArgs {
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SelftestArgs {
    /// Print a JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// For bash: vn100 completions bash > ~/.local/share/bash-completion/completions/vn100
    #[arg(value_name = "SHELL")]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// Write vn100.1 and one page for each command into this folder; an existing page is never
    /// replaced
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("neither \"on\" nor \"off\"".into()),
    }
}

#[cfg(test)]
mod tests;
