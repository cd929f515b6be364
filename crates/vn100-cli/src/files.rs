//! Measures recorded captures, several at a time: what every command does that takes files.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use tokio::{
    runtime::Builder,
    sync::Semaphore,
    task::{self, JoinHandle},
    time,
};
use tokio_util::sync::CancellationToken;
use vn100_pipeline::{ReplaySpec, Session, SessionResult};
use vn100_report::{Document, Evaluation, Measured};

use crate::{
    args::FileArgs,
    exit::{HangUp, print_json_line, stop_on_interrupt},
    log::{Entries, run_logged, takes_terminal},
    result::{FAULT, evaluated_replay, print_state},
    words::remedy_words,
};

const PROGRESS_PERIOD: Duration = Duration::from_millis(100);

/// Measures each file and passes the results to `take`, in the order given; the documents of every
/// second and of the end are `printed` on the way as lines, or only the end counts.
pub(crate) fn measure_files(
    args: &FileArgs,
    evaluation: Evaluation,
    printed: bool,
    take: impl FnMut(Measured) -> Result<()>,
) -> Result<()> {
    let work = async |log| measure_all(args, evaluation, printed, log, take).await;
    run_logged(&mut Builder::new_multi_thread(), &args.log, work)
}

async fn measure_all(
    args: &FileArgs,
    evaluation: Evaluation,
    printed: bool,
    log: Entries,
    mut take: impl FnMut(Measured) -> Result<()>,
) -> Result<()> {
    let job = Arc::new(Job {
        evaluation: Arc::new(evaluation),
        progress: progress_bar(args.files.iter().map(|file| stored_bytes(file)), takes_terminal(&args.log)),
        // documents of several files must not mingle line by line
        turns: Semaphore::new(if printed { 1 } else { thread::available_parallelism().map_or(1, Into::into) }),
    });
    let stop = stop_on_interrupt(HangUp::Stops)?;
    let spec = |path: &PathBuf| ReplaySpec { each_second: printed, ..replay_spec(args, path, &log, &stop) };
    let files: Vec<JoinHandle<Result<Measured>>> =
        args.files.iter().map(|file| task::spawn(measure_one(spec(file), Arc::clone(&job)))).collect();
    for file in files {
        let measured = file.await.context("a measurement stopped by a fault of this program")??;
        job.progress.suspend(|| take(measured))?;
    }
    Ok(())
}

pub(crate) fn replay_spec(args: &FileArgs, path: &Path, log: &Entries, stop: &CancellationToken) -> ReplaySpec {
    let spec = ReplaySpec {
        path: path.to_owned(),
        columns: args.columns.clone(),
        settings: args.measure.settings(),
        read: log.asked(args.measure.read_options()),
        speed: None,
        each_second: false,
        observer: None,
        stop: stop.clone(),
    };
    ReplaySpec { observer: log.observer(&spec.name()), ..spec }
}

struct Job {
    evaluation: Arc<Evaluation>,
    progress: ProgressBar,
    turns: Semaphore,
}

async fn measure_one(spec: ReplaySpec, job: Arc<Job>) -> Result<Measured> {
    let _turn = job.turns.acquire().await?;
    let printed = spec.each_second;
    let result = follow(Session::replay(spec), &job.progress).await?;
    let measured = evaluated_replay(result, &job.evaluation).await?;
    if printed {
        print_json_line(&Document::new(&measured, true, remedy_words))?;
    }
    Ok(measured)
}

/// Follows a session to its end: moves the progress bar, writes the documents of every second.
async fn follow(mut session: Session, progress: &ProgressBar) -> Result<SessionResult> {
    let mut ticks = time::interval(PROGRESS_PERIOD);
    let mut shown = 0;
    loop {
        tokio::select! {
            // those that wait stand before the result
            biased;
            Some(state) = session.seconds.recv() => print_state(&state)?,
            result = &mut session.result => return result.context(FAULT),
            _ = ticks.tick() => {
                let read = session.state.borrow().stored_bytes_read;
                progress.inc(read - shown);
                shown = read;
            }
        }
    }
}

/// The size of a regular file; nothing else knows how much it will bring.
fn stored_bytes(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|metadata| metadata.len())
}

/// A bar for the bytes of sources of these sizes together; without an end if one does not know its
/// size. Nothing is shown where it `is_hidden`, because something else is written there.
fn progress_bar(sizes: impl IntoIterator<Item = Option<u64>>, is_hidden: bool) -> ProgressBar {
    let total: Option<u64> = sizes.into_iter().sum();
    let target = if is_hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
    let template =
        if total.is_some() { "{wide_bar} {bytes}/{total_bytes} {eta}" } else { "{spinner} {bytes} in {elapsed}" };
    // the default style stands in for a template it does not understand
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(total, target).with_style(style).with_finish(ProgressFinish::AndClear)
}
