//! `vn100 attach` and `vn100 record`: live sensors through the pipeline until stopped, one result
//! each, in the order given.

use std::{collections::BTreeMap, fs, path::PathBuf, sync::Arc};

use anyhow::{Context, Error, Result, bail};
use tokio::{
    runtime::Builder,
    sync::watch,
    task::{self, JoinHandle},
    time::{self, Instant},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Assessments, Settings, SourceFacts};
use vn100_capture::{RecordError, Recorder, RecordingState};
use vn100_driver::{Change, LinkState};
use vn100_pipeline::{self as pipeline, Outcome, StreamWatchdog, start};
use vn100_protocol::stream::ReadOptions;
use vn100_report::{Completion, Document, Evaluation, Measured};

use crate::{
    args::{AttachArgs, LinkArgs, RecordArgs, SourceName, Telling},
    conditions::{self, conditions},
    datasheet::evaluation,
    exit::{Exit, about},
    interrupt::{HangUp, stop_on_interrupt},
    live_source::{LiveSource, Opened, changed, closed},
    log::{Entries, Log, takes_terminal},
    measured::{self, all_of, note_recording},
    remedy_words::remedy_words,
    session_words::{self, Ceased},
    set_up::SetUp,
    status::Status,
    teller::{Teller, print_line},
    view::{self, LeftOut, Live, Notices, Stand, View, feed},
};

/// Data time in which the temperature is asked for twice at least.
const TEMPERATURE_EXPECTED_S: f64 = 21.0;

pub(crate) fn attach(args: AttachArgs) -> Result<Exit> {
    let telling = args.result.telling();
    run(args, telling)
}

pub(crate) fn record(args: RecordArgs) -> Result<Exit> {
    run(args.into(), Telling::Summary)
}

fn run(args: AttachArgs, telling: Telling) -> Result<Exit> {
    if !args.record.is_empty() && args.record.len() != args.sources.len() {
        bail!(
            "--record is given {} times for {} sources: give it once for each, in their order",
            args.record.len(),
            args.sources.len()
        );
    }
    let metadata = conditions::read(args.recording.meta.as_deref(), &args.measure.settings())?;
    let log = Log::open(&args.link.log)?;
    // the work is little and comes in small pieces: a second worker would be woken for each of them, and find nothing
    let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build();
    let runtime = runtime.context("cannot start the worker thread")?;
    let exit = runtime.block_on(attach_all(args, telling, metadata, log.entries()));
    // a thread may hang in a read of standard input that nobody waits for any more
    runtime.shutdown_background();
    exit
}

async fn attach_all(
    args: AttachArgs,
    telling: Telling,
    metadata: BTreeMap<String, String>,
    log: Entries,
) -> Result<Exit> {
    let evaluation = Arc::new(evaluation(&args.measure)?.with_filter_models(args.result.filter_models));
    let is_told_over = takes_terminal(&args.link.log);
    let notices = (telling == Telling::Text && view::is_there() && !is_told_over).then(Notices::default);
    let hang_up = if notices.is_some() { HangUp::IsSeenTo } else { HangUp::Stops };
    let stop = stop_on_interrupt(hang_up).context("cannot listen to Ctrl-C")?;
    let mut settings = Settings { recent: notices.is_some(), ..args.measure.settings() };
    if notices.is_none() && telling != Telling::Ndjson {
        // nobody looks more often
        settings.watch_every = Status::PERIOD;
    }
    let status = Status::new(notices.clone(), is_told_over);
    let job = Arc::new(Job { settings, evaluation, telling, metadata, status, log, args });
    let recordings = job.args.record.iter().cloned().map(Some).chain(std::iter::repeat(None));
    let mut feeds = Vec::new();
    let mut unrecorded = Vec::new();
    let sources: Vec<JoinHandle<Result<Measured>>> = (0..)
        .zip(job.args.sources.iter().zip(recordings))
        .map(|(number, (source, recording))| {
            let (stand, feed) = feed(&source.to_string(), Some(source.kind()));
            feeds.push(feed);
            let stop = stop.child_token();
            if recording.is_none() {
                unrecorded.push(stop.clone());
            }
            let mut link = job.args.link.clone();
            // two emulated sensors are two sensors
            link.sim.seed = link.sim.seed.wrapping_add(number);
            task::spawn(attach_one(source.clone(), link, recording, Arc::clone(&job), stand, stop))
        })
        .collect();
    let mut teller = Teller::new(job.telling);
    if let Some(notices) = notices {
        let view = View::show(feeds, job.settings.confidence, notices, Arc::clone(&job.evaluation), stop)?;
        // without a terminal only what is kept is worth going on for
        let all = view.until(all_of(sources), || unrecorded.iter().for_each(CancellationToken::cancel)).await?;
        all.iter().try_for_each(|measured| teller.tell(measured))?;
    } else {
        let mut told = Ok(());
        for source in sources {
            let measured = source.await.context(FAULT).and_then(|measured| measured);
            told = told.and(measured.and_then(|measured| job.status.suspend(|| teller.tell(&measured))));
            if told.is_err() {
                // the others end in order: with their recordings whole, and what was changed put back
                stop.cancel();
            }
        }
        told?;
    }
    teller.finish()
}

const FAULT: &str = "the measurement stopped by a fault of this program";

/// What all sources of one command share.
struct Job {
    args: AttachArgs,
    settings: Settings,
    evaluation: Arc<Evaluation>,
    telling: Telling,
    /// Goes into every recording.
    metadata: BTreeMap<String, String>,
    status: Status,
    log: Entries,
}

async fn attach_one(
    source: SourceName,
    link: LinkArgs,
    recording: Option<PathBuf>,
    job: Arc<Job>,
    stand: Stand,
    stop: CancellationToken,
) -> Result<Measured> {
    let measured = measure_one(source, link, recording, &job, &stand, stop).await;
    stand.ended(match &measured {
        Ok(measured) => measured.facts.error.clone(),
        Err(error) => Some(format!("{error:#}")),
    });
    measured
}

async fn measure_one(
    source: SourceName,
    link: LinkArgs,
    recording: Option<PathBuf>,
    job: &Job,
    stand: &Stand,
    stop: CancellationToken,
) -> Result<Measured> {
    let mut origin = SourceFacts { name: source.to_string(), ..SourceFacts::default() };
    let live = match LiveSource::new(source, link, job.log.clone()) {
        Ok(live) => live,
        Err(error) => {
            origin.error = Some(about(&origin.name, &format!("{error:#}")));
            return Ok(Measured::nothing(origin, &job.settings));
        }
    };
    origin.kind = Some(live.kind());
    origin.meta = conditions(&job.metadata);
    // first: nothing is changed for a recording that cannot be made
    let recorder = match recorder(recording, job).await {
        Ok(recorder) => recorder,
        Err(error) => {
            origin.error = Some(about(&origin.name, &format!("{error:#}")));
            let completion = if error.is::<RecordError>() { Completion::Failed } else { Completion::NoData };
            return Ok(Measured { completion, ..Measured::nothing(origin, &job.settings) });
        }
    };
    let live = live.with_known_serial(recorder.as_ref().and_then(Recorder::known_serial));
    let name = origin.name.clone();
    let tell = |text: &str| job.status.report(&format!("{name}: {text}"));
    let set_up = match SetUp::new(&live, job.args.change.settings(), &stop, tell).await {
        Ok(set_up) => set_up,
        Err(error) => return Ok(unopened(origin, &error, recorder, job).await),
    };
    let measured = measure_and_record(&live, set_up.changes(), recorder, origin, job, stand, &stop).await;
    // also where nobody takes the result any more
    let is_put_back = set_up.undo(&live, tell).await;
    let mut measured = measured?;
    let snapshot = &measured.snapshot;
    if job.args.temperature && snapshot.polled.is_empty() && snapshot.timing.duration_s() > TEMPERATURE_EXPECTED_S {
        let why = "the sensor does not answer, or the line has no room between its lines";
        tell(&format!("no temperature came: {why}"));
    }
    if !is_put_back {
        measured.completion = measured.completion.max(Completion::Failed);
    }
    if job.telling == Telling::Ndjson {
        tell_line(Document::of(&measured, remedy_words)).await?;
    }
    Ok(measured)
}

/// Where the bytes of a source are kept.
async fn recorder(path: Option<PathBuf>, job: &Job) -> Result<Option<Recorder>> {
    let Some(path) = path else { return Ok(None) };
    let (resume, metadata) = (job.args.recording.resume, job.metadata.clone());
    let create = move || if resume { Recorder::resume(path, &metadata) } else { Recorder::create(path, &metadata) };
    Ok(Some(task::spawn_blocking(create).await.context("the recording stopped by a fault of this program")??))
}

/// Ends a recording. A new one in which nothing came is removed: it would only stand in the way of
/// the next attempt.
async fn end_recording(recorder: Recorder, reason: &str, resumed: bool) -> RecordingState {
    let state = recorder.finish(reason).await;
    if state.bytes == 0 && state.error.is_none() && !resumed {
        // one that cannot be removed holds nothing
        let _ = fs::remove_file(&state.path);
    }
    state
}

/// The result of a source that is not measured.
async fn unopened(mut origin: SourceFacts, error: &Error, recorder: Option<Recorder>, job: &Job) -> Measured {
    origin.error = Some(about(&origin.name, &format!("{error:#}")));
    if let Some(recorder) = recorder {
        end_recording(recorder, &error.to_string(), job.args.recording.resume).await;
    }
    Measured::nothing(origin, &job.settings)
}

async fn measure_and_record(
    live: &LiveSource,
    changes: &[Change],
    recorder: Option<Recorder>,
    origin: SourceFacts,
    job: &Job,
    stand: &Stand,
    stop: &CancellationToken,
) -> Result<Measured> {
    let inputs = recorder.as_ref().map(Recorder::inputs);
    let read = job.args.measure.read_options();
    // a result that is told between two reads must be the same however the bytes were read
    let read = ReadOptions { line_by_line: read.line_by_line || job.telling == Telling::Ndjson, ..read };
    let opened = match live.open(read, job.args.temperature, changes.to_vec(), inputs, stop.clone()) {
        Ok(opened) => opened,
        Err(error) => return Ok(unopened(origin, &error, recorder, job).await),
    };
    let link = opened.link.clone();
    let recording = recorder.as_ref().map(Recorder::state);
    let mut told = Ok(());
    let Ended { outcome, left_out, ceased } = measure(opened, recording, &origin, job, stand, stop, &mut told).await?;
    if let Some(link) = &link {
        let told = match closed(link).await {
            Some(true) => Some("its output is paused again, as it was found"),
            Some(false) => Some("its output was found paused, and could not be paused again: $VNASY,0*4F pauses it"),
            None => None,
        };
        told.into_iter().for_each(|told| job.status.report(&format!("{}: {told}", origin.name)));
    }
    let reason = match &outcome.source_error {
        Some(error) => error.to_string(),
        None => match &ceased {
            Some(ceased) => ceased.reason.into(),
            None if stop.is_cancelled() => "stopped".into(),
            None => "the end of the source, or of the time asked for".into(),
        },
    };
    let measured = measured::of(origin, outcome, &job.settings);
    let evaluation = Arc::clone(&job.evaluation);
    let mut measured = task::spawn_blocking(move || evaluation.complete(measured)).await?;
    if let Some(ceased) = ceased {
        measured.note_failure(ceased.told);
    }
    if let Some(recorder) = recorder {
        // the recording has all samples: a replay must be told what was left out here
        let reason = match left_out.option() {
            Some(option) => format!("{reason}; left out by hand, as by {option}"),
            None => reason,
        };
        let unrecorded_bytes = link.map_or(0, |link| link.unrecorded_bytes());
        let recording = end_recording(recorder, &reason, job.args.recording.resume).await;
        note_recording(&mut measured, &recording, unrecorded_bytes);
    }
    told.map(|()| measured)
}

/// How the measurement of one source ended.
struct Ended {
    outcome: Outcome,
    left_out: LeftOut,
    /// Where it ended, or is shorter than asked for, because its measurements ceased.
    ceased: Option<Ceased>,
}

/// Measures one source to its end, showing where it is and writing the documents of every second
/// meanwhile; tells what was left out. Where these cannot be written it ends as when it is stopped,
/// and `told` says why.
async fn measure(
    opened: Opened,
    recording: Option<watch::Receiver<RecordingState>>,
    origin: &SourceFacts,
    job: &Job,
    stand: &Stand,
    stop: &CancellationToken,
    told: &mut Result<()>,
) -> Result<Ended> {
    let state = opened.link.as_ref().map(|link| link.state());
    let measurement = start(opened.events, job.settings.clone(), None);
    let mut latest = measurement.latest.clone();
    let (wishes, mut wished) = view::controls();
    stand.measuring(Live {
        origin: Arc::new(origin.clone()),
        latest: latest.clone(),
        link: state.clone(),
        recording: recording.clone(),
        playback: None,
        controls: wishes,
    });
    let controls = measurement.controls.clone();
    let outcome = measurement.outcome();
    tokio::pin!(outcome);
    let mut line = job.status.line(&origin.name);
    let mut changing = state.clone();
    let mut ticks = time::interval(Status::PERIOD);
    let mut told_second = 0;
    let mut assessments = Assessments::new(job.settings.confidence);
    let mut watchdog = StreamWatchdog::default();
    let mut has_ceased = None;
    let mut left_out = LeftOut::default();
    loop {
        tokio::select! {
            outcome = &mut outcome => {
                let outcome = outcome?;
                let is_short = job.settings.duration.is_some() && !stop.is_cancelled();
                let short = if is_short { session_words::other_rate(&origin.name, &outcome.snapshot) } else { None };
                return Ok(Ended { outcome, left_out, ceased: has_ceased.or(short) });
            }
            // a writer that stalls misses seconds and delays nothing
            Ok(()) = latest.changed(), if job.telling == Telling::Ndjson && told.is_ok() => {
                let snapshot = Arc::clone(&latest.borrow_and_update());
                let second = snapshot.timing.duration_s() as u64;
                if second > told_second {
                    told_second = second;
                    // assessing takes milliseconds now and then: no more than writing shall it hold up the samples
                    let origin = origin.clone();
                    let telling = task::spawn_blocking(move || {
                        let told = print_line(&Document::new(&origin, &snapshot, &assessments.of(&snapshot), false, remedy_words));
                        (told, assessments)
                    });
                    (*told, assessments) = telling.await.context("the output stopped by a fault of this program")?;
                    if told.is_err() {
                        stop.cancel();
                    }
                }
            }
            Some(wish) = wished.recv() => {
                if let Some(told) = left_out.obey(wish, &controls).await {
                    job.status.report(&format!("{}: {told}", origin.name));
                }
            }
            () = changed(&mut changing) => {
                if let Some(state) = &mut changing {
                    let state = state.borrow_and_update().clone();
                    job.log.tell_state(&origin.name, &state);
                    line.tell(&state);
                }
            }
            _ = ticks.tick() => {
                let snapshot = Arc::clone(&latest.borrow());
                let state = state.as_ref().map(|state| state.borrow().clone());
                line.show(state.as_ref(), recording.as_ref().map(|state| state.borrow().clone()).as_ref(), &snapshot);
                let is_up = matches!(state, None | Some(LinkState::Up(_) | LinkState::Silent(_)));
                if let Some(event) = watchdog.rate_event(&snapshot) {
                    job.status.report(&format!("{}: {}", origin.name, session_words::rate_event(event)));
                }
                if let Some(ceased) = watchdog.ceased(&snapshot, is_up, Instant::now()).filter(|_| !stop.is_cancelled()) {
                    has_ceased = match ceased {
                        pipeline::Ceased::OtherMessages => session_words::other_messages(&origin.name, &snapshot),
                        pipeline::Ceased::OtherRate => session_words::other_rate(&origin.name, &snapshot),
                    };
                    stop.cancel();
                }
            }
        }
    }
}

/// Writes a document without holding up the tasks that measure.
async fn tell_line(document: Document) -> Result<()> {
    task::spawn_blocking(move || print_line(&document))
        .await
        .context("the output stopped by a fault of this program")?
}
