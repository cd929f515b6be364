//! `vn100 replay`, and what every command does that takes files: recorded captures through the
//! pipeline, several at a time, one result each, in the order given; at full speed, or in the view
//! at the pace of the sensor or another.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    thread,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use tokio::{
    runtime::Builder,
    sync::Semaphore,
    task::{self, JoinHandle},
    time,
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Completion, Goal, Settings, SourceResult};
use vn100_report::{Evaluation, goals::Goals};
use vn100_session::{ReplaySpec, Session, SessionResult, Speed};

use vn100_view::{MessageQueue, SourceMonitor, View};

use crate::{
    args::{FileArgs, Ndjson, ReplayArgs, refused},
    exit::{HangUp, report, stop_on_interrupt, unless_closed, usage},
    inputs::inputs,
    log::{Entries, run_logged, takes_terminal},
    result::{FAULT, ResultWriter, all_of, evaluated_replay, print_result, print_state},
    samples::SampleWriter,
    user_files::evaluation,
    watched::Watched,
    words,
};

const PROGRESS_PERIOD: Duration = Duration::from_millis(100);

pub(crate) fn replay(args: &ReplayArgs) -> Result<Completion> {
    let files = &args.files;
    if let Some(speed) = args.speed {
        return replay_in_view(args, speed);
    }
    let inputs = inputs(files);
    if args.result.samples.is_some()
        && let [first, second, ..] = &inputs[..]
    {
        let refusal = match files.files.len() == 1 && first.path == second.path {
            true => "--samples takes the samples of one stream, and the file has several: name one with --topic",
            false => "--samples takes the samples of one source, a capture or the parts of one recording: give one",
        };
        usage(&refused("replay", refusal));
    }
    let evaluation = evaluation(&files.measure)?;
    let mut writer = ResultWriter::new(args.result.format());
    let outputs = Outputs { printed: args.result.ndjson, samples: args.result.samples.clone() };
    unless_closed(measure_files(files, &inputs, evaluation, outputs, |measured| writer.write(measured)))?;
    writer.finish()
}

/// Replays in the view until the user quits it, and writes the results as any replay does.
fn replay_in_view(args: &ReplayArgs, speed: Speed) -> Result<Completion> {
    if args.serve.serve.is_none() && !vn100_view::is_there() {
        bail!(
            "--speed needs the live view, and that a terminal for input and output, or a page (--serve); without --speed the result is printed at once"
        );
    }
    if args.serve.serve.is_none() && takes_terminal(&args.files.log) {
        bail!("-v would overwrite the view: send it to a file, as in -v 2>FILE");
    }
    let work = async |log| replay_all(args, speed, log).await;
    run_logged(&mut Builder::new_multi_thread(), &args.files.log, work)
}

async fn replay_all(args: &ReplayArgs, speed: Speed, log: Entries) -> Result<Completion> {
    let files = &args.files;
    let watched = Watched::of(&args.serve)?;
    let messages = (vn100_view::is_there() && !takes_terminal(&files.log)).then(MessageQueue::default);
    let stop = stop_on_interrupt(if messages.is_some() { HangUp::HandledByView } else { HangUp::Stops })?;
    let evaluation = Arc::new(evaluation(&files.measure)?);
    let session = |input| {
        let settings = Settings { recent: true, ..files.settings() };
        Session::replay(ReplaySpec { settings, speed: Some(speed), ..replay_spec(input, &log, &stop) })
    };
    let page = watched.as_ref().and_then(Watched::url);
    let view_options = messages.is_some().then(|| args.view.options(&files.settings(), page, &stop)).transpose()?;
    let sessions: Vec<Session> = inputs(files).into_iter().map(session).collect();
    let goals = Goals::of(&files.settings(), None);
    let monitors = sessions.iter().map(|session| SourceMonitor::of(session, goals.clone())).collect();
    let say = |text| said(messages.as_ref(), text);
    let show = |watched: Watched| watched.show(&sessions, &goals, &files.settings(), &evaluation, say);
    let server = watched.map(show).transpose()?;
    let follow = |session| task::spawn(follow_paced(session, messages.clone(), Arc::clone(&evaluation)));
    let results: Vec<JoinHandle<Result<SourceResult>>> = sessions.into_iter().map(follow).collect();
    let mut writer = ResultWriter::new(args.result.format());
    let results = match messages {
        Some(messages) => {
            let all_stop = stop.clone();
            let view = View::show(monitors, messages, evaluation, view_options.unwrap_or_default(), stop)?;
            view.until(all_of(results), || all_stop.cancel(), report).await?
        }
        None => all_of(results).await?,
    };
    unless_closed(results.into_iter().try_for_each(|measured| writer.write(measured)))?;
    drop(server);
    writer.finish()
}

/// Says it in the view, or without one on standard error.
fn said(view: Option<&MessageQueue>, text: String) {
    if let Some(messages) = view { messages.push(text) } else { report(&text) }
}

async fn follow_paced(
    mut session: Session,
    messages: Option<MessageQueue>,
    evaluation: Arc<Evaluation>,
) -> Result<SourceResult> {
    let name = session.state.borrow().name().to_owned();
    let event = |event| words::event(&name, event).into_iter().for_each(|text| said(messages.as_ref(), text));
    let mut is_at_end = messages.is_some();
    let result = loop {
        tokio::select! {
            // pending messages are written before the result
            biased;
            Some(happened) = session.events.recv() => event(happened),
            result = &mut session.result => break result.context(FAULT)?,
            // a view shows it
            Ok(()) = session.state.changed(), if !is_at_end => {
                is_at_end = session.state.borrow_and_update().playback.is_some_and(|playback| playback.at_end);
                if is_at_end {
                    report(&format!("{name}: replayed to its end; it stays on the page until Ctrl-C, which prints the result"));
                }
            }
        }
    };
    evaluated_replay(result, &evaluation, false).await
}

/// What is written while files are measured.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    /// Lines of this form on standard output, for each second and at the end.
    printed: Option<Ndjson>,
    /// The samples of the only stream, as CSV.
    samples: Option<PathBuf>,
}

/// Measures each input and passes the results to `take`, in the order given; the documents of every
/// second and the samples are written on the way as `outputs` say.
pub(crate) fn measure_files(
    args: &FileArgs,
    inputs: &[ReplaySpec],
    evaluation: Evaluation,
    outputs: Outputs,
    take: impl FnMut(SourceResult) -> Result<()>,
) -> Result<()> {
    let work = async |log| measure_all(args, inputs, evaluation, outputs, log, take).await;
    run_logged(&mut Builder::new_multi_thread(), &args.log, work)
}

async fn measure_all(
    args: &FileArgs,
    inputs: &[ReplaySpec],
    evaluation: Evaluation,
    outputs: Outputs,
    log: Entries,
    mut take: impl FnMut(SourceResult) -> Result<()>,
) -> Result<()> {
    let Outputs { printed, samples } = outputs;
    let cores = thread::available_parallelism().map_or(1, Into::into);
    let files = inputs.iter().flat_map(|input| std::iter::once(&input.path).chain(&input.capture.later_parts));
    let job = Arc::new(Job {
        evaluation: Arc::new(evaluation),
        progress: progress_bar(files.map(|path| stored_bytes(path)), args.log.quiet || takes_terminal(&args.log)),
        // documents of several files must not mingle line by line
        turns: Semaphore::new(if printed.is_some() { 1 } else { cores }),
        printed,
    });
    let stop = stop_on_interrupt(HangUp::Stops)?;
    let mut files: Vec<JoinHandle<Result<SourceResult>>> = Vec::new();
    for input in inputs {
        let spec = replay_spec(input.clone(), &log, &stop);
        let writer = samples.as_deref().map(|path| SampleWriter::start(path, stop.clone())).transpose()?;
        let (writer, samples) = writer.unzip();
        let spec = ReplaySpec { each_second: printed.is_some(), samples, ..spec };
        files.push(task::spawn(measure_one(spec, writer, Arc::clone(&job))));
    }
    for file in files {
        let measured = file.await.context("internal error: a measurement stopped")??;
        job.progress.suspend(|| take(measured))?;
    }
    Ok(())
}

/// The input with that log, ended by that token.
pub(crate) fn replay_spec(input: ReplaySpec, log: &Entries, stop: &CancellationToken) -> ReplaySpec {
    let observer = log.observer(&input.name());
    ReplaySpec { read: log.asked(input.read), observer, stop: stop.clone(), ..input }
}

struct Job {
    evaluation: Arc<Evaluation>,
    progress: ProgressBar,
    turns: Semaphore,
    printed: Option<Ndjson>,
}

async fn measure_one(spec: ReplaySpec, samples: Option<SampleWriter>, job: Arc<Job>) -> Result<SourceResult> {
    let _turn = job.turns.acquire().await?;
    let goals = spec.settings.until.clone();
    let result = follow(Session::replay(spec), &job, &goals).await?;
    let has_enough = samples.as_ref().is_some_and(SampleWriter::has_enough);
    let mut measured = evaluated_replay(result, &job.evaluation, has_enough).await?;
    if let Some(samples) = samples {
        samples.finish(&mut measured).await;
    }
    if let Some(form) = job.printed {
        unless_closed(print_result(&measured, form, &goals))?;
    }
    Ok(measured)
}

/// Follows a session to its end: moves the progress bar, writes the documents of every second.
async fn follow(mut session: Session, job: &Job, goals: &[Goal]) -> Result<SessionResult> {
    let mut ticks = time::interval(PROGRESS_PERIOD);
    let mut shown = 0;
    loop {
        tokio::select! {
            // pending messages are written before the result
            biased;
            Some(state) = session.seconds.recv() => {
                job.printed.map_or(Ok(()), |form| print_state(&state, form, goals))?;
            }
            result = &mut session.result => return result.context(FAULT),
            _ = ticks.tick() => {
                let read = session.state.borrow().stored_bytes_read;
                job.progress.inc(read - shown);
                shown = read;
            }
        }
    }
}

/// The size of a regular file; no other source has a known size.
pub(crate) fn stored_bytes(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|metadata| metadata.len())
}

/// A bar for the bytes of sources of these sizes together; without an end if one does not know its
/// size. Nothing is shown where it `is_hidden`, because something else is written there.
pub(crate) fn progress_bar(sizes: impl IntoIterator<Item = Option<u64>>, is_hidden: bool) -> ProgressBar {
    let total: Option<u64> = sizes.into_iter().sum();
    let target = if is_hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
    let template = if total.is_some() {
        "reading {wide_bar} {bytes}/{total_bytes} {bytes_per_sec} {eta}"
    } else {
        "{spinner} read {bytes} in {elapsed}"
    };
    // the default style stands in for a template it does not understand
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(total, target).with_style(style).with_finish(ProgressFinish::AndClear)
}
