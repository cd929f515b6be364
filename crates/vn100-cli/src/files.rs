//! Measures recorded captures, several at a time: what every command does that takes files.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Arc, atomic::Ordering},
    thread,
};

use anyhow::{Context, Result};
use tokio::{
    runtime::Runtime,
    sync::Semaphore,
    task::{self, JoinHandle},
    time,
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Assessments, Settings, SourceFacts};
use vn100_capture::{Capture, ColumnMap, Format, MapHint, OpenError};
use vn100_pipeline::{Outcome, every_second, start};
use vn100_protocol::stream::ReadOptions;
use vn100_report::{Document, Evaluation, Measured};

use crate::{
    args::FileArgs,
    conditions::{conditions, measured_duration, measured_until},
    interrupt::{HangUp, stop_on_interrupt},
    log::{Entries, Log, takes_terminal},
    measured::{self, recording_facts},
    progress::Progress,
    remedy_words::remedy_words,
    teller::print_line,
};

/// Whether the documents of every second are written on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EachSecond {
    /// As lines on standard output.
    Printed,
    /// Only the end counts.
    Unseen,
}

/// Measures each file and hands the results to `take`, in the order given.
pub(crate) fn measure_files(
    args: &FileArgs,
    evaluation: Evaluation,
    each_second: EachSecond,
    take: impl FnMut(Measured) -> Result<()>,
) -> Result<()> {
    let log = Log::open(&args.log)?;
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    let result = runtime.block_on(measure_all(args, evaluation, each_second, log.entries(), take));
    // a thread may hang in a read of standard input that nobody waits for any more
    runtime.shutdown_background();
    result
}

async fn measure_all(
    args: &FileArgs,
    evaluation: Evaluation,
    each_second: EachSecond,
    log: Entries,
    mut take: impl FnMut(Measured) -> Result<()>,
) -> Result<()> {
    let printed = each_second == EachSecond::Printed;
    let job = Arc::new(Job {
        read: log.asked(args.measure.read_options()),
        settings: args.measure.settings(),
        columns: args.columns.clone(),
        ndjson: printed,
        evaluation: Arc::new(evaluation),
        progress: Progress::new(args.files.iter().map(|file| stored_bytes(file)), takes_terminal(&args.log)),
        log,
        // documents of several files must not mingle line by line
        turns: Semaphore::new(if printed { 1 } else { thread::available_parallelism().map_or(1, Into::into) }),
        stop: stop_on_interrupt(HangUp::Stops).context("cannot listen to Ctrl-C")?,
    });
    let files: Vec<JoinHandle<Result<Measured>>> =
        args.files.iter().map(|file| task::spawn(measure_one(file.clone(), Arc::clone(&job)))).collect();
    for file in files {
        let measured = file.await.context("a measurement stopped by a fault of this program")??;
        job.progress.suspend(|| take(measured))?;
    }
    Ok(())
}

/// What all files of one command share.
struct Job {
    read: ReadOptions,
    settings: Settings,
    columns: Option<ColumnMap>,
    ndjson: bool,
    evaluation: Arc<Evaluation>,
    progress: Progress,
    log: Entries,
    turns: Semaphore,
    stop: CancellationToken,
}

async fn measure_one(path: PathBuf, job: Arc<Job>) -> Result<Measured> {
    let _turn = job.turns.acquire().await?;
    let opened = tokio::select! {
        // checked first: after an interrupt no file more is begun
        biased;
        () = job.stop.cancelled() => Err(format!("{}: not read, interrupted", name(&path))),
        opened = open(&path, job.columns.clone(), &job.settings) => opened?,
    };
    let Opened { capture, mut origin, settings } = match opened {
        Ok(opened) => opened,
        Err(error) => return Ok(unreadable(&path, error, &job.settings)),
    };
    let line_by_line = job.read.line_by_line || job.ndjson || settings.duration.is_some() || !settings.until.is_empty();
    let read = ReadOptions { line_by_line, ..job.read };

    let recorded = capture.recorded.clone();
    let outcome = measure(capture, read, settings.clone(), &origin, &job).await?;
    origin.recording = recorded.as_ref().map(recording_facts);
    let measured = measured::of(origin, outcome, &settings);
    let evaluation = Arc::clone(&job.evaluation);
    let mut measured = task::spawn_blocking(move || evaluation.complete(measured)).await?;
    if job.stop.is_cancelled() {
        measured.note_interrupted();
    }
    if job.ndjson {
        print_line(&Document::of(&measured, remedy_words))?;
    }
    Ok(measured)
}

/// Runs one capture to its end, moving the progress bar and writing the documents of every second
/// meanwhile.
async fn measure(
    capture: Capture,
    read: ReadOptions,
    settings: Settings,
    origin: &SourceFacts,
    job: &Job,
) -> Result<Outcome> {
    let read_so_far = Arc::clone(&capture.stored_bytes_read);
    let (seconds, mut each_second) = every_second();
    let seconds = job.ndjson.then_some(seconds);
    let mut assessments = Assessments::new(settings.confidence);
    let events = capture.read(read, job.stop.clone()).context("cannot start the reading thread")?;
    let measurement = start(job.log.watch(&origin.name, events), settings, seconds);
    let outcome = async {
        // ends with the measurement: it holds the only sender
        while let Some(snapshot) = each_second.recv().await {
            print_line(&Document::new(origin, &snapshot, &assessments.of(&snapshot), false, remedy_words))?;
        }
        anyhow::Ok(measurement.outcome().await?)
    };
    tokio::pin!(outcome);
    let mut ticks = time::interval(Progress::PERIOD);
    let mut shown = 0;
    loop {
        tokio::select! {
            outcome = &mut outcome => return outcome,
            _ = ticks.tick() => {
                let read = read_so_far.load(Ordering::Relaxed);
                job.progress.add(read - shown);
                shown = read;
            }
        }
    }
}

/// A capture ready to be read, and what is asked of it.
pub(crate) struct Opened {
    pub(crate) capture: Capture,
    pub(crate) origin: SourceFacts,
    pub(crate) settings: Settings,
}

/// Opens a capture; where it cannot be, the inner error says why.
pub(crate) async fn open(
    path: &Path,
    columns: Option<ColumnMap>,
    settings: &Settings,
) -> Result<Result<Opened, String>> {
    let from = path.to_owned();
    let opening = move || open_capture(&from, columns.as_ref());
    let capture = match task::spawn_blocking(opening).await.context("the capture could not be opened")? {
        Ok(capture) => capture,
        Err(error) => return Ok(Err(unopened(error))),
    };
    let name = name(path);
    let metadata = capture.recorded.as_ref().map(|recorded| &recorded.metadata);
    let is_resumed = capture.recorded.as_ref().is_some_and(|recorded| recorded.resumed);
    let mut settings = settings.clone();
    if let Some(metadata) = metadata.filter(|_| !is_resumed) {
        settings.duration = settings.duration.or_else(|| measured_duration(metadata));
        if settings.until.is_empty() {
            settings.until = measured_until(metadata);
        }
    }
    let origin = SourceFacts {
        kind: Some(kind(&capture, &name)),
        recording: capture.recorded.as_ref().map(recording_facts),
        meta: metadata.and_then(conditions),
        name,
        ..SourceFacts::default()
    };
    Ok(Ok(Opened { capture, origin, settings }))
}

/// Why, and the option that would cure it.
fn unopened(error: OpenError) -> String {
    let hint = match &error {
        OpenError::Csv { problem, .. } => problem.hint(),
        _ => None,
    };
    let cure = match hint {
        Some(MapHint::Columns(map)) => format!("; name the columns with a map (--columns), as in {map}"),
        Some(MapHint::StampUnit(map)) => format!("; name the unit, as in --columns {map} (or s, us, ns)"),
        None => String::new(),
    };
    format!("{:#}{cure}", anyhow::Error::from(error))
}

/// The result of a capture that could not be opened.
pub(crate) fn unreadable(path: &Path, error: String, settings: &Settings) -> Measured {
    Measured::nothing(SourceFacts { name: name(path), error: Some(error), ..SourceFacts::default() }, settings)
}

/// Opens a file, or standard input by the name of `-`.
pub(crate) fn open_capture(path: &Path, columns: Option<&ColumnMap>) -> Result<Capture, OpenError> {
    if path == Path::new("-") { Capture::from_reader(io::stdin(), columns) } else { Capture::open(path, columns) }
}

/// The size of a regular file; nothing else knows how much it will bring.
fn stored_bytes(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|metadata| metadata.len())
}

/// The file's name without its folder: a document says the same wherever its capture lies.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn kind(capture: &Capture, name: &str) -> &'static str {
    match capture.format {
        _ if name == "-" => "stdin",
        Format::Text => "text",
        Format::Raw => "raw",
        Format::Csv => "csv",
        Format::Mcap => "mcap",
    }
}
