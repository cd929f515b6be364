//! `vn100 archive`: every capture below some folders, each measured by itself, on all cores, a row
//! for each recording and channel. Rows are written as they are known, in the order of the files,
//! so that an archive of any size takes the memory of a few files, and continues where it stopped.

mod rows_file;

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fs::File,
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
    thread,
};

use anyhow::{Context, Result};
use tokio::{
    runtime::Builder,
    sync::Semaphore,
    task::{self, JoinHandle},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Completion, End};
use vn100_capture::{RecordingPart, captures_below, file_stamp, joined_parts};
use vn100_report::{ArchiveRow, ArchivedFile, Evaluation, is_export};
use vn100_session::{ReplaySpec, Session, StartError};

use self::rows_file::{RowForm, RowsFile};
use crate::{
    args::{ArchiveArgs, FileArgs},
    commands::replay::{progress_bar, replay_spec},
    exit::{HangUp, print, report, stop_on_interrupt},
    inputs::{any_input, inputs},
    log::{Entries, run_logged, takes_terminal},
    output::Output,
    result::{FAULT, evaluated_replay},
    user_files::evaluation,
};

pub(crate) fn archive(args: &ArchiveArgs) -> Result<Completion> {
    let evaluation = evaluation(&args.files.measure)?.verdicts_only();
    let files = captures(&args.files.files);
    if files.is_empty() {
        report("no capture is there: in folders they are known by their endings, and a file that is named is one");
        return Ok(Completion::NoData);
    }
    if let Some(path) = &args.output {
        Output::new(path, true).check(path, &files)?;
    }
    let captures = archived(&args.files, files);
    let wanted = || captures.iter().map(|capture| (capture.file.path.clone(), capture.file.clone())).collect();
    let output = args.output.as_ref().map(|path| RowsFile::open(path, &wanted())).transpose()?;
    let work = async |log| measure_all(&args.files, captures, evaluation, output, log).await;
    run_logged(&mut Builder::new_multi_thread(), &args.files.log, work)
}

/// The captures at and below these paths, each once, in the order of their names.
fn captures(paths: &[PathBuf]) -> Vec<PathBuf> {
    let (exports, mut files): (Vec<PathBuf>, Vec<PathBuf>) = paths
        .iter()
        .flat_map(|path| captures_below(path))
        // a file that is named is measured, whatever it is
        .partition(|file| !paths.contains(file) && is_exported(file));
    files.sort();
    files.dedup();
    match exports.len() {
        0 => {}
        1 => report(&format!("{} is an export, no capture: skipped", exports[0].display())),
        count => report(&format!("{count} files are exports, no captures, as {}: skipped", exports[0].display())),
    }
    files
}

/// Whether this program wrote the file from captures.
fn is_exported(path: &Path) -> bool {
    let mut beginning = Vec::new();
    // a pipe is read once, and what cannot be read says why later
    path.is_file()
        && File::open(path).and_then(|file| file.take(1024).read_to_end(&mut beginning)).is_ok()
        && is_export(&beginning)
}

/// A file, or the parts of a recording.
struct ArchivedCapture {
    files: Vec<PathBuf>,
    file: ArchivedFile,
}

fn archived(args: &FileArgs, files: Vec<PathBuf>) -> Vec<ArchivedCapture> {
    let measure = &args.measure;
    let judged_by = match (&measure.datasheet, measure.typical_is_limit, &measure.fail_on[..]) {
        (None, false, []) => String::new(),
        judged_by => format!("{judged_by:?}"),
    };
    let options = any_input(args).options_digest(&judged_by);
    let groups = joined_parts(files.into_iter().map(|path| (path.clone(), RecordingPart::of(&path))));
    let capture = |parts: BTreeMap<u32, PathBuf>| {
        let files: Vec<PathBuf> = parts.into_values().collect();
        let (bytes, modified_ns) = file_stamp(&files);
        let path = ReplaySpec::of(&files[0]).name_with_folder();
        ArchivedCapture { files, file: ArchivedFile { path, bytes, modified_ns, options: options.clone() } }
    };
    // a file that is named twice counts once; one that is missing is told of each time
    let mut known = BTreeSet::new();
    let mut is_new =
        |capture: &ArchivedCapture| capture.files[0].canonicalize().map_or(true, |path| known.insert(path));
    groups.into_iter().map(capture).filter(|capture| is_new(capture)).collect()
}

struct Job {
    args: FileArgs,
    evaluation: Arc<Evaluation>,
    turns: Semaphore,
    log: Entries,
    stop: CancellationToken,
}

struct Found {
    rows: Vec<ArchiveRow>,
    errors: Vec<String>,
    completion: Completion,
    is_stopped: bool,
    bytes: u64,
}

async fn measure_all(
    args: &FileArgs,
    mut captures: Vec<ArchivedCapture>,
    evaluation: Evaluation,
    mut output: Option<RowsFile>,
    log: Entries,
) -> Result<Completion> {
    captures.retain(|capture| !output.as_ref().is_some_and(|rows| rows.holds(&capture.file.path)));
    let cores = thread::available_parallelism().map_or(1, Into::into);
    let is_hidden = args.log.quiet || takes_terminal(&args.log);
    let progress = progress_bar(captures.iter().map(|capture| Some(capture.file.bytes)), is_hidden);
    let job = Arc::new(Job {
        args: args.clone(),
        evaluation: Arc::new(evaluation),
        turns: Semaphore::new(cores),
        log,
        stop: stop_on_interrupt(HangUp::Stops)?,
    });
    let (total, mut written) = (captures.len(), 0);
    let mut completion = output.as_ref().map_or(Completion::Complete, |rows| rows.completion());
    // a failure among them is one of this run too
    if let Some(rows) = output.as_ref().filter(|_| total == 0 || completion != Completion::Complete) {
        report(&format!("{}{}", if total == 0 { "nothing new: " } else { "" }, rows.kept_in_words()));
    }
    let mut captures = captures.into_iter();
    let mut started: VecDeque<JoinHandle<Result<Found>>> = VecDeque::new();
    loop {
        // rows wait for those before them; only so many wait that the memory stays that of a few files
        let next = captures.by_ref().take(2 * cores - started.len());
        started.extend(next.map(|capture| task::spawn(measure_one(capture, Arc::clone(&job)))));
        let Some(next) = started.pop_front() else { break };
        let found = next.await.context(FAULT)??;
        if found.is_stopped {
            // others that began may be at their end
            captures = Vec::new().into_iter();
            continue;
        }
        progress.suspend(|| {
            found.errors.iter().for_each(|text| report(text));
            if let Some(rows) = &mut output { rows.add(&found.rows) } else { print(&RowForm::Lines.text(&found.rows)) }
        })?;
        progress.inc(found.bytes);
        completion = completion.max(found.completion);
        written += 1;
    }
    progress.finish_and_clear();
    if written < total {
        let again = if output.is_some() { ": the same command measures these alone" } else { "" };
        report(&format!("interrupted: {} of {total} captures were not measured{again}", total - written));
        completion = completion.max(Completion::Failed);
    }
    Ok(completion)
}

async fn measure_one(capture: ArchivedCapture, job: Arc<Job>) -> Result<Found> {
    let _turn = job.turns.acquire().await?;
    let ArchivedCapture { files, file } = capture;
    let args = FileArgs { files, ..job.args.clone() };
    let inputs = task::spawn_blocking(move || inputs(&args)).await?;
    let (mut recordings, mut errors) = (Vec::new(), Vec::new());
    let (mut completion, mut is_stopped) = (Completion::Complete, false);
    for input in inputs {
        let spec = replay_spec(input, &job.log, &job.stop);
        let name = spec.name_with_folder();
        let result = Session::replay(spec).result.await.context(FAULT)?;
        is_stopped |= matches!(*result.end, End::Stopped) || matches!(result.start_error, Some(StartError::Stopped));
        let mut measured = evaluated_replay(result, &job.evaluation, false).await?;
        errors.extend(measured.failures().map(|text| with_folder(text, &name)));
        completion = completion.max(measured.completion);
        measured.source.name = name;
        recordings.push(measured);
    }
    let rows = ArchiveRow::of_file(&file, &recordings);
    Ok(Found { rows, errors, completion, is_stopped, bytes: file.bytes })
}

/// An error whose source is a file without its folder, with the folder.
fn with_folder(error: &str, name: &str) -> String {
    let (source, rest) = error.split_once(": ").unwrap_or(("", error));
    if name.ends_with(source) && !error.contains(name) { format!("{name}: {rest}") } else { error.to_owned() }
}
