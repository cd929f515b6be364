//! Captures replayed in the view: at the pace of the sensor or another, with places to go to.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use tokio::{
    runtime::Runtime,
    sync::{mpsc, watch},
    task::{self, JoinHandle},
    time,
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{DEFAULT_RATE_HZ, Settings, SourceFacts};
use vn100_capture::{Capture, ColumnMap, Event};
use vn100_pipeline::{Beginning, Outcome, PaceWish, Speed, paced, start};
use vn100_protocol::stream::ReadOptions;
use vn100_report::{Evaluation, Measured};

use crate::{
    args::ReplayArgs,
    datasheet::evaluation,
    exit::Exit,
    files::{Opened, name, open, open_capture, unreadable},
    interrupt::{HangUp, stop_on_interrupt},
    log::{Entries, Log, takes_terminal},
    measured::{self, all_of, recording_facts},
    teller::Teller,
    view::{self, LeftOut, Live, Notices, SourceRequest, Stand, View, feed},
};

/// Wishes that may wait for the pace.
const WAITING_WISHES: usize = 8;

/// How often the pace is told the rate of the samples.
const LOOK: Duration = Duration::from_millis(100);

/// Replays in the view until somebody quits it, and tells the results as any replay does.
pub(super) fn replay_shown(args: &ReplayArgs, speed: Speed) -> Result<Exit> {
    if !view::is_there() {
        bail!(
            "--speed is for the view, which needs a terminal before and behind it; without --speed the result is printed at once"
        );
    }
    if takes_terminal(&args.files.log) {
        bail!("-v would be written over the view: --log FILE keeps the diagnostics beside it");
    }
    let log = Log::open(&args.files.log)?;
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    let exit = runtime.block_on(replay_all(args, speed, log.entries()));
    // a thread may hang in a read of standard input that nobody waits for any more
    runtime.shutdown_background();
    exit
}

async fn replay_all(args: &ReplayArgs, speed: Speed, log: Entries) -> Result<Exit> {
    let files = &args.files;
    let stop = stop_on_interrupt(HangUp::IsSeenTo).context("cannot listen to Ctrl-C")?;
    let notices = Notices::default();
    let settings = Settings { recent: true, ..files.measure.settings() };
    let confidence = settings.confidence;
    let job = Arc::new(Job {
        read: log.asked(ReadOptions { line_by_line: true, ..files.measure.read_options() }),
        settings,
        columns: files.columns.clone(),
        evaluation: Arc::new(evaluation(&files.measure)?.with_filter_models(args.result.filter_models)),
        speed,
        notices: notices.clone(),
        stop: stop.clone(),
        log,
    });
    let evaluation = Arc::clone(&job.evaluation);
    let mut feeds = Vec::new();
    let files: Vec<JoinHandle<Result<Measured>>> = (files.files.iter())
        .map(|file| {
            let (stand, feed) = feed(&name(file), None);
            feeds.push(feed);
            task::spawn(replay_one(file.clone(), Arc::clone(&job), stand))
        })
        .collect();
    let all_stop = stop.clone();
    let view = View::show(feeds, confidence, notices, evaluation, stop)?;
    let all = view.until(all_of(files), || all_stop.cancel()).await?;
    let mut teller = Teller::new(args.result.telling());
    all.iter().try_for_each(|measured| teller.tell(measured))?;
    teller.finish()
}

/// What all files of one command share.
struct Job {
    read: ReadOptions,
    settings: Settings,
    columns: Option<ColumnMap>,
    evaluation: Arc<Evaluation>,
    speed: Speed,
    notices: Notices,
    stop: CancellationToken,
    log: Entries,
}

/// Replays one capture, from its beginning again whenever the view goes back in it, until the view
/// is quit.
async fn replay_one(path: PathBuf, job: Arc<Job>, stand: Stand) -> Result<Measured> {
    let (counted, total) = watch::channel(None);
    let beginning = Beginning { speed: job.speed, paused: false, run_to: 0 };
    let mut from = Start { beginning, left_out: LeftOut::default() };
    let mut count = None;
    loop {
        let Opened { capture, mut origin, mut settings } = match open(&path, job.columns.clone(), &job.settings).await?
        {
            Ok(opened) => opened,
            Err(error) => {
                stand.ended(Some(error.clone()));
                job.stop.cancelled().await;
                return Ok(unreadable(&path, error, &job.settings));
            }
        };
        if count.is_none() {
            count = Some(task::spawn(count_samples(path.clone(), Arc::clone(&job), counted.clone())));
        }
        settings.skip = from.left_out.skip_or(settings.skip);
        let recorded = capture.recorded.clone();
        match replay_once(capture, &settings, &job, &stand, &total, from, &origin).await? {
            Next::Again(place) => from = place,
            Next::Over { outcome, whole } => {
                origin.recording = recorded.as_ref().map(recording_facts);
                let measured = measured::of(origin, outcome, &settings);
                let evaluation = Arc::clone(&job.evaluation);
                let mut measured = task::spawn_blocking(move || evaluation.complete(measured)).await?;
                if !whole {
                    measured.note_interrupted();
                }
                return Ok(measured);
            }
        }
    }
}

/// Where a replay begins, and what of the capture it leaves out by hand.
struct Start {
    beginning: Beginning,
    left_out: LeftOut,
}

/// What comes after a replay.
enum Next {
    /// Another, to a place that was passed already.
    Again(Start),
    /// Nothing; whether it had come to the end of the capture.
    Over { outcome: Outcome, whole: bool },
}

async fn replay_once(
    capture: Capture,
    settings: &Settings,
    job: &Job,
    stand: &Stand,
    total: &watch::Receiver<Option<u64>>,
    from: Start,
    origin: &SourceFacts,
) -> Result<Next> {
    let name = &origin.name;
    let Start { beginning, mut left_out } = from;
    // this replay alone; a task that still waits ends with it
    let ends = job.stop.child_token();
    let _ends = ends.clone().drop_guard();
    let events = capture.read(job.read, ends.clone()).context("cannot start the reading thread")?;
    let events = job.log.watch(&origin.name, events);
    let (paces, wished) = mpsc::channel(WAITING_WISHES);
    let (rate, rate_hz) = watch::channel(settings.rate_hz.unwrap_or(DEFAULT_RATE_HZ));
    let (events, position) = paced(events, wished, rate_hz, beginning, ends);
    let measurement = start(events, settings.clone(), None);
    let latest = measurement.latest.clone();
    let controls = measurement.controls.clone();
    let (wishes, mut wished) = view::controls();
    stand.measuring(Live {
        origin: Arc::new(origin.clone()),
        latest: latest.clone(),
        link: None,
        recording: None,
        playback: Some((position.clone(), total.clone())),
        controls: wishes,
    });
    let outcome = measurement.outcome();
    tokio::pin!(outcome);
    let mut over = None;
    let mut ticks = time::interval(LOOK);
    loop {
        tokio::select! {
            outcome = &mut outcome, if over.is_none() => over = Some(outcome?),
            _ = ticks.tick() => {
                let now_hz = latest.borrow().timing.rate_hz;
                rate.send_if_modified(|rate_hz| std::mem::replace(rate_hz, now_hz) != now_hz);
            }
            Some(wish) = wished.recv() => {
                let now = *position.borrow();
                let wish = match wish {
                    SourceRequest::PauseOrGoOn | SourceRequest::Step if now.at_end => {
                        job.notices.tell(format!("{name}: nothing more comes; [ or g goes back, and pauses there"));
                        continue;
                    }
                    SourceRequest::PauseOrGoOn => PaceWish::PauseOrGoOn,
                    SourceRequest::Step => PaceWish::Step,
                    SourceRequest::Faster => PaceWish::Faster,
                    SourceRequest::Slower => PaceWish::Slower,
                    SourceRequest::GoTo(part) => {
                        let Some(total) = *total.borrow() else {
                            job.notices.tell(format!("{name}: its samples are still being counted, or cannot be"));
                            continue;
                        };
                        let place = (part.clamp(0.0, 1.0) * total as f64).round() as u64;
                        if place < now.rows {
                            // who looks back from the end wants to see that place, not the end again
                            let paused = now.paused || now.at_end;
                            let place_s = place as f64 / latest.borrow().timing.rate_hz;
                            let reached = Duration::try_from_secs_f64(place_s).unwrap_or(Duration::MAX);
                            let (left_out, told) = left_out.carried_to(reached);
                            if let Some(told) = told {
                                job.notices.tell(format!("{name}: {told}"));
                            }
                            let beginning = Beginning { speed: now.speed, paused, run_to: place };
                            return Ok(Next::Again(Start { beginning, left_out }));
                        }
                        PaceWish::RunTo(place)
                    }
                    SourceRequest::EndWarmUp | SourceRequest::StartOver => {
                        let told = left_out.obey(wish, &controls).await;
                        job.notices.tell(told.map_or("the capture is over".into(), |told| format!("{name}: {told}")));
                        continue;
                    }
                };
                // a full queue means that several wait already
                let _ = paces.try_send(wish);
            }
            // what came so far is the result
            () = job.stop.cancelled(), if over.is_some() => {}
        }
        if job.stop.is_cancelled()
            && let Some(outcome) = over
        {
            return Ok(Next::Over { outcome, whole: position.borrow().at_end });
        }
    }
}

/// How many samples the capture has; told when it is known. What cannot be read twice is not
/// counted.
async fn count_samples(path: PathBuf, job: Arc<Job>, counted: watch::Sender<Option<u64>>) -> Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    let columns = job.columns.clone();
    let capture = task::spawn_blocking(move || open_capture(&path, columns.as_ref())).await??;
    let read = ReadOptions { line_by_line: false, diagnostics: false, ..job.read };
    let mut events = capture.read(read, job.stop.clone())?;
    let mut rows = 0;
    while let Some(event) = events.recv().await {
        match event {
            Event::Batch(batch) => rows += batch.row_count() as u64,
            Event::Link(_) => {}
            Event::End(_) => break,
        }
    }
    counted.send_replace(Some(rows));
    Ok(())
}
