//! Whole measurements of emulated sensors by the options of the command line, on the paused clock:
//! hours take seconds, and no host can stall.

mod ending;
mod faults;
mod recording;
mod settings;

use std::{collections::BTreeMap, path::PathBuf, sync::Arc, time::Duration};

use clap::Parser;
use serde_json::Value;
use tempfile::TempDir;
use tokio::{sync::watch, task::JoinHandle};
use tokio_util::sync::CancellationToken;
use vn100_analysis::Completion;
use vn100_capture::Clock;
use vn100_driver::{Configured, LinkHandle, OutputSettings};
use vn100_protocol::Register;
use vn100_report::Document;
use vn100_report::remedies::remedy_words;
use vn100_session::{Command, EmulatedPort, LiveError, LiveSource, ReplaySpec, Session, SourceState};
use vn100_view::MessageQueue;

use super::{Job, Prepared, attach_one};
use crate::{
    args::{Args, AttachArgs, OutputFormat, SourceName, Subcommand},
    live_source::{as_asked, emulated_port},
    log::Entries,
    result::evaluated_replay,
    samples::SampleWriter,
    status::StatusLines,
    user_files::evaluation,
};

/// An emulated sensor that commands measure, one after the other, and the files they write.
pub(super) struct Bench {
    port: EmulatedPort,
    folder: TempDir,
}

/// What came of a command.
pub(super) struct Outcome {
    pub(super) completion: Completion,
    pub(super) document: Value,
    pub(super) messages: Vec<String>,
}

/// A command under way.
pub(super) struct Running {
    pub(super) state: watch::Receiver<SourceState>,
    pub(super) commands: tokio::sync::mpsc::Sender<Command>,
    pub(super) stop: CancellationToken,
    messages: MessageQueue,
    ended: JoinHandle<anyhow::Result<vn100_analysis::SourceResult>>,
}

impl Bench {
    /// A sensor as the options of `sim` describe it; it was switched on two seconds ago.
    pub(super) fn new(options: &str) -> Self {
        let (args, _) = parsed(&format!("attach sim {options}"));
        let port = emulated_port(&args.live.link.sim, Clock::start()).unwrap().0;
        Self { port, folder: tempfile::tempdir().unwrap() }
    }

    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn source(&self) -> LiveSource {
        LiveSource::link(self.port.clone())
    }

    /// Starts `attach` or `record` with these options; `{}` stands for the folder of the bench.
    pub(super) fn start(&self, command: &str) -> Running {
        let (name, options) = command.split_once(' ').unwrap_or((command, ""));
        let options = options.replace("{}", self.folder.path().to_str().unwrap());
        let (args, format) = parsed(&format!("{name} imu {options}"));
        let messages = MessageQueue::default();
        let job = Arc::new(Job {
            settings: vn100_analysis::Settings { watch_every: StatusLines::PERIOD, ..args.measure.settings() },
            evaluation: Arc::new(evaluation(&args.measure).unwrap()),
            format,
            conditions: BTreeMap::new(),
            status: StatusLines::new(Some(messages.clone()), false, args.live.link.log.quiet),
            log: Entries::default(),
            args,
        });
        let source = SourceName::Port("imu".into());
        let opened = as_asked(self.source(), &source, &job.args.live.link, job.read_options(), &job.log);
        let stop = CancellationToken::new();
        let samples = job.args.result.samples.as_ref();
        let (writer, samples) =
            samples.map(|path| SampleWriter::start(path, stop.clone())).transpose().unwrap().unzip();
        let recording = job.args.record.first().cloned();
        let session = job.session(&source, 0, Ok(opened), recording, samples, stop.clone());
        let (state, commands) = (session.state.clone(), session.commands.clone());
        let prepared = Prepared { session, writer, stop: stop.clone() };
        Running { state, commands, stop, messages, ended: tokio::spawn(attach_one(prepared, job)) }
    }

    /// The same, up to its end.
    pub(super) async fn run(&self, command: &str) -> Outcome {
        self.start(command).end().await
    }

    /// Sets the sensor as `configure` does.
    pub(super) async fn configure(&self, settings: OutputSettings) -> Configured {
        self.set(settings).await.unwrap()
    }

    /// The same; what the sensor refuses is an error.
    pub(super) async fn set(&self, settings: OutputSettings) -> anyhow::Result<Configured> {
        let stop = CancellationToken::new();
        let set = async |link: LinkHandle| Ok(vn100_driver::configure(&link, &settings, &stop).await?);
        self.source().with_link(None, &stop, set).await
    }

    /// What the sensor answers for these registers.
    pub(super) async fn registers(&self, numbers: &[u8]) -> Vec<String> {
        let stop = CancellationToken::new();
        let read = async |link: LinkHandle| {
            let mut all = Vec::new();
            for number in numbers {
                all.push(link.read(Register(*number)).await?.map_or(String::new(), |found| found.fields.to_string()));
            }
            Ok::<_, anyhow::Error>(all)
        };
        self.source().with_link(None, &stop, read).await.unwrap()
    }

    /// Whether the sensor sends by itself: only listened to, for ten seconds.
    pub(super) async fn sends(&self) -> bool {
        let mut source = self.source();
        (source.options.baud, source.options.listen_only) = (Some(115_200), true);
        let work = async |_: LinkHandle| Ok::<_, LiveError>(());
        source.with_link(None, &CancellationToken::new(), work).await.is_ok()
    }

    /// Pauses the output, as a program does that breaks off in the middle of its work.
    pub(super) async fn pause(&self) {
        use vn100_driver::{Connect, Connection};
        let mut port = self.port.clone().open(115_200).await.unwrap();
        port.write(b"$VNASY,0*4F\r\n").await.unwrap();
        tokio::time::sleep(Duration::from_secs(1)).await;
        drop(port.close().await);
        assert!(!self.sends().await, "it is paused");
    }
}

impl Running {
    pub(super) async fn until(&mut self, is_so: impl FnMut(&SourceState) -> bool) {
        self.state.wait_for(is_so).await.unwrap();
    }

    pub(super) async fn end(self) -> Outcome {
        let measured = self.ended.await.unwrap().unwrap();
        let document = serde_json::to_value(Document::new(&measured, remedy_words)).unwrap();
        Outcome { completion: measured.completion, document, messages: self.messages.take() }
    }
}

impl Outcome {
    pub(super) fn number(&self, pointer: &str) -> u64 {
        number(&self.document, pointer)
    }

    /// Samples and dropped ones together.
    pub(super) fn expected_samples(&self) -> u64 {
        self.number("/timing/samples") + self.number("/timing/missing")
    }

    pub(super) fn warned(&self, kind: &str) -> bool {
        self.document["warnings"].as_array().unwrap().iter().any(|warning| warning["kind"] == kind)
    }

    /// How many messages contain this.
    pub(super) fn said(&self, text: &str) -> usize {
        self.messages.iter().filter(|message| message.contains(text)).count()
    }

    pub(super) fn error(&self) -> &str {
        self.document["source"]["error"].as_str().unwrap_or_default()
    }

    /// Every good line is a sample, a reply or something else, and none is lost.
    pub(super) fn assert_conserved(&self) {
        let n = |pointer| self.number(pointer);
        let told = n("/timing/samples") + n("/timing/left_out") + n("/link/replies") + n("/link/other_messages");
        assert_eq!(n("/link/frames"), told, "{}", self.document["link"]);
    }
}

pub(super) fn number(document: &Value, pointer: &str) -> u64 {
    document.pointer(pointer).and_then(Value::as_u64).unwrap_or_else(|| panic!("no {pointer} in {document}"))
}

/// What a replay of a file says, with the options of `replay`.
pub(super) async fn replayed(file: &std::path::Path, options: &str) -> Outcome {
    let line = format!("vn100 replay {} {options}", file.display());
    let Subcommand::Replay(args) = Args::try_parse_from(line.split_whitespace()).unwrap().command else { panic!() };
    let inputs = crate::inputs::inputs(&args.files);
    let [input] = &inputs[..] else { panic!("{} inputs", inputs.len()) };
    let spec = ReplaySpec { settings: args.files.settings(), ..ReplaySpec::of(&input.path) };
    let result = Session::replay(spec).result.await.unwrap();
    let evaluation = Arc::new(evaluation(&args.files.measure).unwrap());
    let measured = evaluated_replay(result, &evaluation, false).await.unwrap();
    let document = serde_json::to_value(Document::new(&measured, remedy_words)).unwrap();
    Outcome { completion: measured.completion, document, messages: Vec::new() }
}

/// What two documents say, apart from their source and the reason of their end.
pub(super) fn assert_same_but_source(a: &Value, b: &Value) {
    let [a, b] = [a, b].map(|document| {
        let mut document = document.clone();
        (document["source"], document["end_reason"]) = (Value::Null, Value::Null);
        document
    });
    assert_eq!(a, b);
}

pub(super) fn rate(rate_hz: u32) -> OutputSettings {
    OutputSettings { rate_hz: Some(rate_hz), ..OutputSettings::default() }
}

pub(super) fn message(name: &str) -> OutputSettings {
    OutputSettings { message: Some(name.into()), ..OutputSettings::default() }
}

fn parsed(line: &str) -> (AttachArgs, OutputFormat) {
    let line = format!("vn100 {line}");
    match Args::try_parse_from(line.split_whitespace()).unwrap_or_else(|error| panic!("{line}: {error}")).command {
        Subcommand::Attach(args) => {
            let format = args.result.format();
            (args, format)
        }
        Subcommand::Record(args) => (args.into(), OutputFormat::Head),
        _ => panic!("{line} measures no sensor"),
    }
}
