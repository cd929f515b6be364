//! `vn100 archive`: every capture below some folders, on all cores, as one document or table. The
//! state of each is kept where that is asked for, and a file that is as it was is not read again.

mod state_folder;

use std::{
    fs::File,
    io::{Read, Write},
    path::{Path, PathBuf},
    sync::Arc,
    thread,
};

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use tokio::{runtime::Builder, sync::Semaphore, task};
use tokio_util::sync::CancellationToken;
use vn100_analysis::State;
use vn100_capture::captures_below;
use vn100_pipeline::{EndReason, Session, StartError};
use vn100_report::{ArchiveDocument, Completion, archive_table, is_export, state_of_measured};

use self::state_folder::StateFolder;
use vn100_report::words::remedy_words;

use crate::{
    args::{ArchiveArgs, FileArgs},
    commands::replay::{progress_bar, replay_spec, stored_bytes},
    exit::{HangUp, print, report, stop_on_interrupt, unless_closed},
    inputs::{FileStream, inputs, inputs_of},
    log::{Entries, run_logged, takes_terminal},
    output::Output,
    result::{FAULT, ResultOf, measured},
    user_files::evaluation,
};

pub(crate) fn archive(args: &ArchiveArgs) -> Result<Completion> {
    let evaluation = evaluation(&args.files.measure)?;
    let (exports, mut files): (Vec<PathBuf>, Vec<PathBuf>) =
        args.files.files.iter().flat_map(|path| captures_below(path)).partition(|file| {
            // a file that is named is measured, whatever it is
            !args.files.files.contains(file) && is_exported(file)
        });
    files.sort();
    files.dedup();
    match exports.len() {
        0 => {}
        1 => report(&format!("{} is an export, no capture: skipped", exports[0].display())),
        count => report(&format!("{count} files are exports, no captures, as {}: skipped", exports[0].display())),
    }
    if files.is_empty() {
        report("no capture is there: in folders they are known by their endings, and a file that is named is one");
    }
    let output = args.output.as_deref().map(|path| (path, Output::new(path, true)));
    if let Some((path, output)) = &output {
        output.check(path, &files)?;
    }
    let folder = args.state.as_deref().map(StateFolder::open).transpose()?.map(Arc::new);
    let found = FileArgs { files, ..args.files.clone() };
    let work = async |log| measure_all(&found, folder.clone(), log).await;
    let state = run_logged(&mut Builder::new_multi_thread(), &found.log, work)?;
    let document = ArchiveDocument::new(&state, &evaluation, remedy_words);
    let unread = StartError::Stopped.to_string();
    let (unread, notes): (Vec<_>, Vec<_>) = document.notes().into_iter().partition(|text| text.ends_with(&unread));
    notes.iter().for_each(|text| report(text));
    if !unread.is_empty() {
        report(&format!("interrupted: {} of {} captures were not read", unread.len(), document.recordings()));
    }
    let text = match args.csv || args.output.as_deref().is_some_and(is_table) {
        true => archive_table(&document),
        false => serde_json::to_string_pretty(&document)? + "\n",
    };
    match output {
        Some((path, output)) => output.write(path, |file| Ok(file.write_all(text.as_bytes())?))?,
        None => unless_closed(print(&text))?,
    }
    let failure = folder.as_ref().and_then(|folder| folder.failure());
    failure.iter().for_each(|text| report(text));
    Ok(document.completion().max(if failure.is_some() { Completion::Failed } else { Completion::Complete }))
}

fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

/// Whether this program wrote the file from captures.
fn is_exported(path: &Path) -> bool {
    let mut beginning = Vec::new();
    // a pipe is read once, and what cannot be read says why later
    path.is_file()
        && File::open(path).and_then(|file| file.take(1024).read_to_end(&mut beginning)).is_ok()
        && is_export(&beginning)
}

struct Job {
    args: FileArgs,
    folder: Option<Arc<StateFolder>>,
    progress: ProgressBar,
    turns: Semaphore,
    log: Entries,
    stop: CancellationToken,
}

async fn measure_all(files: &FileArgs, folder: Option<Arc<StateFolder>>, log: Entries) -> Result<State> {
    let inputs = match &folder {
        Some(folder) => inputs_of(files, &folder.heads(files)),
        None => inputs(files),
    };
    // a bag may be a folder
    let sizes = inputs.iter().flat_map(FileStream::files).map(|file| Some(stored_bytes(file).unwrap_or(0)));
    let job = Arc::new(Job {
        args: files.clone(),
        folder,
        progress: progress_bar(sizes, files.log.quiet || takes_terminal(&files.log)),
        turns: Semaphore::new(thread::available_parallelism().map_or(1, Into::into)),
        log,
        stop: stop_on_interrupt(HangUp::Stops)?,
    });
    let streams: Vec<_> = inputs.into_iter().map(|input| task::spawn(state_of(input, Arc::clone(&job)))).collect();
    let mut all = State::default();
    for stream in streams {
        all = all.merged(stream.await.context(FAULT)??)?;
    }
    Ok(all)
}

async fn state_of(input: FileStream, job: Arc<Job>) -> Result<State> {
    let _turn = job.turns.acquire().await?;
    let bytes: u64 = input.files().filter_map(stored_bytes).sum();
    let spec = replay_spec(&job.args, input, &job.log, &job.stop);
    let name = spec.name_with_folder();
    let kept = job.folder.as_ref().map(|folder| (Arc::clone(folder), folder.entry(&name, &spec)));
    let known = kept.as_ref().and_then(|(folder, entry)| folder.known(entry));
    let state = match known {
        Some(state) => state,
        None => {
            let mut result = Session::replay(spec).result.await.context(FAULT)?;
            task::spawn_blocking(move || {
                let mut analysis = result.analysis.take();
                let is_stopped = matches!(*result.end, EndReason::Stopped | EndReason::NotStarted(StartError::Stopped));
                let mut measured = measured(result, ResultOf::Capture);
                if is_stopped {
                    measured.note_interrupted();
                }
                let state = state_of_measured(&name, &measured, analysis.as_deref_mut());
                if let Some((folder, entry)) = kept.filter(|_| !is_stopped) {
                    folder.keep(&entry, &state);
                }
                state
            })
            .await?
        }
    };
    job.progress.inc(bytes);
    Ok(state)
}
