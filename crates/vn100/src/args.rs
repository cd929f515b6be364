//! The command line.

mod choices;
mod duration;
mod export;
mod files;
mod help;
mod link;
mod measure;
mod plan;
mod report;
mod result;
mod serve;
mod sim;
mod view;

use std::{
    path::{Path, PathBuf},
    slice,
    time::Duration,
};

use clap::{CommandFactory, Parser, ValueEnum, error::ErrorKind};
use imu_noise::Estimator;
use vn100_capture::Rotation;
use vn100_protocol::BaudRate;
use vn100_session::WallLimits;

use choices::one_of;
use duration::length;
pub(crate) use export::{ExportArgs, Window};
pub(crate) use files::{ArchiveArgs, CompareArgs, FileArgs, ReplayArgs};
#[cfg(test)]
pub(crate) use help::help_of;
pub(crate) use link::{ChangeArgs, LinkArgs, OnHangup, SimSensorArgs, SourceName};
use link::{baud_rate, rotation};
pub(crate) use measure::MeasureArgs;
use measure::TARGETS;
pub(crate) use plan::{Fixed, PlanArgs};
pub(crate) use report::{ReportArgs, is_page};
pub(crate) use result::{Ndjson, OutputFormat, ResultArgs};
pub(crate) use serve::ServeArgs;
pub(crate) use sim::{CaptureMessage, SimArgs};
use view::ViewArgs;

/// Live Allan deviation and statistics for the VectorNav VN-100.
#[derive(Debug, Parser)]
#[command(
    name = "vn100",
    version = env!("VN100_VERSION"),
    max_term_width = 100,
    after_help = help::after(""),
    mut_subcommands = |command| { let help = help::after(command.get_name()); command.after_help(help) },
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Subcommand,
}

impl Args {
    /// Refuses what single options cannot.
    pub(crate) fn checked(self) -> Result<Self, clap::Error> {
        let (name, refusal) = match &self.command {
            Subcommand::Attach(args) => ("attach", args.refused()),
            Subcommand::Record(RecordArgs { source, live, .. }) => ("record", live.refused(slice::from_ref(source))),
            Subcommand::Info(InfoArgs { source: SourceName::Stdin, .. }) => ("info", Some(NO_REPLIES.into())),
            Subcommand::Configure(ConfigureArgs { source: SourceName::Stdin, .. }) => {
                ("configure", Some(NO_REPLIES.into()))
            }
            Subcommand::Witness(WitnessArgs { source: Some(SourceName::Stdin), .. }) => {
                ("witness", Some(NO_REPLIES.into()))
            }
            Subcommand::Replay(args) => ("replay", args.refused()),
            Subcommand::Archive(args) => {
                let has_stdin = args.files.files.iter().any(|path| path == Path::new("-"));
                let refusal = "an archive is of files and folders: standard input is none";
                ("archive", has_stdin.then(|| refusal.into()))
            }
            Subcommand::Compare(args) => {
                let refusal = "--taus is for replay and report: records are compared octave by octave";
                ("compare", args.files.taus.is_some().then(|| refusal.into()))
            }
            Subcommand::Report(args) => ("report", args.refused()),
            Subcommand::Sim(SimArgs { output: Some(_), sensor, .. }) => {
                let refusal = "--faults act on a link, and a capture has none: record an emulated sensor, as in \"vn100 record sim --faults ...\"";
                ("sim", (!sensor.faults.faults.is_empty()).then(|| refusal.into()))
            }
            _ => ("", None),
        };
        if let Some(refusal) = refusal { Err(refused(name, &refusal)) } else { Ok(self) }
    }
}

/// A usage error with the usage of the command with this name.
pub(crate) fn refused(name: &str, refusal: &str) -> clap::Error {
    let mut program = Args::command();
    // the usage of a command begins with the name of the program
    program.build();
    let command = program.get_subcommands().find(|command| command.get_name() == name).cloned();
    command.unwrap_or(program).error(ErrorKind::ArgumentConflict, refusal)
}

#[derive(Debug, clap::Subcommand)]
pub(crate) enum Subcommand {
    /// Measure live sensors until stopped; settings are not changed unless requested
    Attach(AttachArgs),
    /// Record a live sensor without measuring anything
    Record(RecordArgs),
    /// Show model, serial number, firmware and output of a sensor, and what its baud rate carries
    Info(InfoArgs),
    /// Change what a sensor sends: checked before, read back after
    Configure(ConfigureArgs),
    /// Measure recorded captures, as fast as the machine can
    Replay(ReplayArgs),
    /// Measure every capture below some folders, on all cores: a row for each recording and channel
    Archive(ArchiveArgs),
    /// Compare captures: which one to use, which is disturbed, and whether they differ
    /// significantly
    Compare(CompareArgs),
    /// Plan a measurement: message, rate, window, baud rate, and the length of the record for each
    /// parameter
    Plan(PlanArgs),
    /// Write the report of captures: one page with figures and tables, and files for other
    /// programs
    Report(ReportArgs),
    /// Write the file of a filter from a data sheet alone, without a record
    Export(ExportArgs),
    /// Emulate a sensor whose noise is known: on a serial port, or straight into a capture
    Sim(SimArgs),
    /// Record what settles open questions about a sensor: eight steps in 20 minutes, packed into one
    /// file that can be given to others
    Witness(WitnessArgs),
    /// Compare with published values: the test suites of NIST SP 1065 and NBS Monograph 140, and
    /// exact degrees of freedom and bounds, and tables that were published with public records; exit
    /// with 1 if one differs
    Selftest {
        /// Compare the public records at and below this folder with the tables published with them as
        /// well; without a folder: list these records, and where they can be had
        #[arg(long, value_name = "FOLDER")]
        published: Option<Option<PathBuf>>,
    },
    /// Explain a code or a parameter of results: what it means, why it matters, what to do
    Explain {
        /// A kind of warning, status, verdict or parameter, such as vibration-line, bounded, N, ARW
        /// or edf; without it all are listed
        #[arg(value_name = "CODE")]
        code: Vec<String>,
    },
    /// List the serial ports, those a VN-100 is likely on first
    Ports,
    /// Print the JSON Schema of a document, with a description of every field
    Schema {
        /// The document: analysis, of `vn100 attach` and `vn100 replay`; progress, of --ndjson=thin and
        /// of heartbeats
        #[arg(value_name = "DOCUMENT", value_enum, default_value = "analysis")]
        document: DescribedDocument,
    },
    /// Print the completion script for a shell
    Completions {
        /// For bash: vn100 completions bash > ~/.local/share/bash-completion/completions/vn100
        #[arg(value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write one for each command
    Man {
        /// Write vn100.1 and one page for each command into this folder; an existing page is never
        /// replaced
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

#[derive(Debug, Clone, clap::Args)]
pub(crate) struct AttachArgs {
    /// Serial ports such as /dev/ttyUSB0 or COM3, "sim" for an emulated sensor, tcp://host:port for
    /// a serial server, or "-" for bytes on standard input [default: the only likely port]
    ///
    /// The connection to a serial server is neither encrypted nor authenticated: anyone on the
    /// network path can read or modify the data and commands. The checksums detect accidents only.
    /// Use a network you trust, or a tunnel.
    #[arg(value_name = "SOURCE")]
    pub(crate) sources: Vec<SourceName>,

    #[command(flatten)]
    pub(crate) live: LiveArgs,

    /// Keep the raw bytes with their arrival times, as MCAP; once for each source, in their order
    #[arg(long, help_heading = "Recording", value_name = "FILE")]
    pub(crate) record: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) measure: MeasureArgs,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    #[command(flatten)]
    pub(crate) serve: ServeArgs,
}

impl AttachArgs {
    fn refused(&self) -> Option<String> {
        let Self { sources, live, record, measure, result, serve, .. } = self;
        if measure.estimator == Estimator::Full {
            return Some("--estimator full is for replay: its memory grows with the record, which has no end on a live sensor. Record it and replay the recording".into());
        }
        if live.resume && record.is_empty() {
            return Some("--resume appends to a recording: name it with --record".into());
        }
        if live.rotate.is_some() && record.is_empty() {
            return Some("--rotate cuts a recording into parts: name it with --record".into());
        }
        let (recordings, places) = (record.len(), sources.len().max(1));
        if recordings != 0 && recordings != places {
            let text = "give it once for each, in their order";
            return Some(format!("--record is given {recordings} times for {places} sources; {text}"));
        }
        (live.refused(sources))
            .or_else(|| result.refused(sources.len()))
            .or_else(|| serve.refused(sources.iter().map(ToString::to_string)))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct RecordArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", tcp://host:port, or "-" for standard
    /// input
    #[arg(value_name = "SOURCE")]
    pub(crate) source: SourceName,

    /// The recording to write, as MCAP; an existing file is never replaced
    #[arg(short, long, help_heading = "Recording", value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Stop after this much data time, for example 5h; a number without a unit is seconds
    #[arg(short, long, help_heading = "Recording", value_name = "T", value_parser = length)]
    pub(crate) duration: Option<Duration>,

    #[command(flatten)]
    pub(crate) live: LiveArgs,
}

impl From<RecordArgs> for AttachArgs {
    fn from(args: RecordArgs) -> Self {
        Self {
            sources: vec![args.source],
            live: args.live,
            record: vec![args.output],
            measure: MeasureArgs { duration: args.duration, ..MeasureArgs::default() },
            result: ResultArgs::default(),
            view: ViewArgs::default(),
            serve: ServeArgs::default(),
        }
    }
}

#[derive(Debug, Clone, clap::Args)]
pub(crate) struct WitnessArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", or tcp://host:port
    #[arg(value_name = "SOURCE", required_unless_present = "check")]
    pub(crate) source: Option<SourceName>,

    /// The kit to write, a ZIP file; the serial number of the sensor is replaced in it. Finished
    /// steps wait beside it in a folder, and the same command continues with the next
    #[arg(short, long, help_heading = "Recording", value_name = "KIT.zip", required_unless_present = "check")]
    pub(crate) output: Option<PathBuf>,

    /// Length of all steps together, for a trial; shorter steps settle less
    #[arg(short, long, help_heading = "Recording", value_name = "T", value_parser = length, default_value = "20min")]
    pub(crate) duration: Duration,

    /// Conditions to keep with the data, as TOML: place, mounting, axis up, supply, operator, note
    #[arg(long, help_heading = "Recording", value_name = "FILE.toml")]
    pub(crate) meta: Option<PathBuf>,

    /// Measure the recordings of this kit, and say what they settle
    #[arg(long, value_name = "KIT.zip", conflicts_with_all = ["source", "output", "meta"])]
    pub(crate) check: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) link: LinkArgs,
}

#[derive(Debug, Clone, clap::Args)]
pub(crate) struct LiveArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) change: ChangeArgs,

    /// Read temperature, pressure and uncompensated measurements every ten seconds between the
    /// sentences
    #[arg(long, help_heading = "Recording", conflicts_with = "listen_only")]
    pub(crate) temperature: bool,

    /// Append to existing recordings, after a gap; begin those that do not exist
    #[arg(long, help_heading = "Recording")]
    pub(crate) resume: bool,

    /// Continue in the next file, NAME.0001.mcap, NAME.0002.mcap ..., after so many bytes of the
    /// stream (500MB, 1GiB) or so much time (1h); a number without a unit is seconds
    #[arg(long, help_heading = "Recording", value_name = "SIZE|T", value_parser = rotation)]
    pub(crate) rotate: Option<Rotation>,

    /// Conditions to keep with the data, as TOML: place, mounting, axis up, supply, operator, note
    #[arg(long, help_heading = "Recording", value_name = "FILE.toml")]
    pub(crate) meta: Option<PathBuf>,

    /// End with exit 1 when no sample has come for this long by the clock, for example 10min
    /// [default: reconnect for ever]
    #[arg(long, help_heading = TARGETS, value_name = "T", value_parser = length)]
    pub(crate) give_up: Option<Duration>,

    /// End this long after the start by the clock, whatever came, for example 9h; with exit 1 if
    /// --duration has not passed, or neither it nor --until is given
    #[arg(long, help_heading = TARGETS, value_name = "T", value_parser = length)]
    pub(crate) wall: Option<Duration>,

    /// If the terminal is closed: end the measurement, or let it go on [default: what is recorded
    /// with --record goes on if its view is closed, everything else ends]
    #[arg(long, help_heading = TARGETS, value_name = "WHAT")]
    pub(crate) hangup: Option<OnHangup>,
}

impl LiveArgs {
    pub(crate) const fn limits(&self) -> WallLimits {
        WallLimits { give_up: self.give_up, wall: self.wall }
    }
}

const NO_REPLIES: &str = "standard input is not a sensor that replies: name a port";

impl LiveArgs {
    fn refused(&self, sources: &[SourceName]) -> Option<String> {
        let asks = self.temperature || self.change.settings().is_some();
        let asks_stream = asks && sources.contains(&SourceName::Stdin);
        self.change.not_measured().or_else(|| asks_stream.then(|| NO_REPLIES.into()))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// A serial port such as /dev/ttyUSB0 or COM3, "sim", or tcp://host:port
    #[arg(value_name = "SOURCE")]
    pub(crate) source: SourceName,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    #[command(flatten)]
    pub(crate) output: JsonArgs,
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
    #[arg(long, help_heading = "Sensor settings", value_name = "N", value_parser = |text: &str| baud_rate(text).map(BaudRate::bits_per_s))]
    pub(crate) set_baud: Option<u32>,

    /// Append a counter to each sentence, which makes the count of dropped samples exact
    #[arg(long, help_heading = "Sensor settings", value_name = "on|off", num_args = 0..=1, default_missing_value = "on", value_parser = one_of(&ON_OR_OFF))]
    pub(crate) count: Option<bool>,

    /// Save all settings to flash memory
    #[arg(long, help_heading = "Sensor settings")]
    pub(crate) save: bool,
}

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct JsonArgs {
    /// Print one JSON document, and nothing else, on standard output
    #[arg(long, help_heading = "Output")]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct ForceArgs {
    /// Replace existing files
    #[arg(long, help_heading = "Output")]
    pub(crate) force: bool,
}

/// Diagnostics; without them, warnings only.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Diagnostics")]
pub(crate) struct LogArgs {
    /// Log link events, commands and rejected lines to stderr; disables the live view, unless stderr
    /// is a file
    #[arg(short, long)]
    pub(crate) verbose: bool,

    /// No progress and no status lines; results, warnings and errors stay
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum DescribedDocument {
    /// The result of a measurement, vn100.analysis/2
    Analysis,
    /// The lines of a measurement under way, vn100.progress/2
    Progress,
}

const ON_OR_OFF: [(&str, &str, bool); 2] = [("on", "With a counter", true), ("off", "Without", false)];

#[cfg(test)]
mod tests;
