//! `vn100 attach` and `vn100 record`: live sensors through the pipeline until stopped, one result
//! each, in the order given.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use anyhow::{Context, Result};
use tokio::{
    runtime::Builder,
    task::{self, JoinHandle},
    time::{self, Instant, sleep_until},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Completion, Settings, SourceResult};
use vn100_driver::list_ports;
use vn100_protocol::stream::ReadOptions;
use vn100_report::{Evaluation, goals::Goals};
use vn100_session::{
    LiveSource, LiveSpec, RecordingSpec, SampleTap, Session, SessionEvent, SessionResult, SourceState, Stage,
    StartError,
};

use vn100_view::{MessageQueue, SourceMonitor, View};

use crate::{
    args::{AttachArgs, OnHangup, OutputFormat, SourceName},
    commands::ports::only_likely,
    exit::{HangUp, report, stop_on_interrupt, unless_closed},
    heartbeat::Heartbeat,
    live_source::live_source,
    log::{Entries, run_logged, takes_terminal},
    result::{FAULT, ResultOf, ResultWriter, all_of, evaluated, print_heartbeat, print_result, print_state},
    samples::SampleWriter,
    status::{StatusLine, StatusLines},
    user_files::{evaluation, read_conditions},
    watched::Watched,
    words,
};

/// Data time in which the temperature is asked for twice at least.
const TEMPERATURE_EXPECTED_S: f64 = 21.0;

pub(crate) fn attach(mut args: AttachArgs, format: OutputFormat) -> Result<Completion> {
    if args.sources.is_empty() {
        match only_likely(&list_ports()) {
            Ok(port) => {
                report(&format!("no SOURCE given: using {port}, the only likely port"));
                args.sources.push(SourceName::Port(port));
            }
            Err(why) => {
                report(&why);
                return Ok(Completion::NoData);
            }
        }
    }
    let conditions = read_conditions(args.live.meta.as_deref())?;
    let log = args.live.link.log.clone();
    // there is little work, in small pieces: a second worker would be woken for each and find nothing to do
    let mut runtime = Builder::new_multi_thread();
    run_logged(runtime.worker_threads(1), &log, async move |log| attach_all(args, format, conditions, log, None).await)
}

/// Said when the view of a recording begins.
const RECORDING_GOES_ON: &str =
    "if this terminal is closed, the recording goes on and keeps the port; --hangup stop ends it then";

/// Measures all sources until they end, or until `all` or else an interrupt stops them.
pub(super) async fn attach_all(
    args: AttachArgs,
    format: OutputFormat,
    conditions: BTreeMap<String, String>,
    log: Entries,
    all: Option<&CancellationToken>,
) -> Result<Completion> {
    let evaluation = Arc::new(evaluation(&args.measure)?);
    let watched = Watched::of(&args.serve)?;
    let logs_to_terminal = takes_terminal(&args.live.link.log);
    let messages = (format.is_text() && vn100_view::is_there() && !logs_to_terminal).then(MessageQueue::default);
    let hang_up = match args.live.hangup {
        _ if messages.is_some() => HangUp::HandledByView,
        Some(OnHangup::Continue) => HangUp::Ignored,
        Some(OnHangup::Stop) | None => HangUp::Stops,
    };
    let stop = all.map_or_else(|| stop_on_interrupt(hang_up), |all| Ok(all.child_token()))?;
    let mut settings = Settings { recent: messages.is_some() || watched.is_some(), ..args.measure.settings() };
    if messages.is_some() {
        settings.watch_every = vn100_view::FIRST_LOOKS;
    } else if format.lines().is_none() {
        // the status lines are not redrawn more often
        settings.watch_every = StatusLines::PERIOD;
    }
    let status = StatusLines::new(messages.clone(), logs_to_terminal, args.live.link.log.quiet);
    let job = Arc::new(Job { settings, evaluation, format, conditions, status, log, args });
    let recordings = job.args.record.iter().cloned().map(Some).chain(std::iter::repeat(None));
    let mut monitors = Vec::new();
    let mut unrecorded = Vec::new();
    let page = watched.as_ref().and_then(Watched::url);
    let view_options = messages.is_some().then(|| job.args.view.options(&job.settings, page, &stop)).transpose()?;
    let goals = Goals::of(&job.settings, job.args.live.limits().wall);
    let prepared: Vec<Prepared> = (0..)
        .zip(job.args.sources.iter().zip(recordings))
        .map(|(number, (source, recording))| {
            let stop = stop.child_token();
            if recording.is_none() {
                unrecorded.push(stop.clone());
            }
            let writer = job.args.result.samples.as_deref();
            let writer = writer.map(|path| SampleWriter::start(path, stop.clone())).transpose()?;
            let (writer, samples) = writer.unzip();
            let opened = job.source(source, number);
            let session = job.session(source, number, opened, recording, samples, stop.clone());
            monitors.push(SourceMonitor::of(&session, goals.clone()));
            Ok(Prepared { session, writer, stop })
        })
        .collect::<Result<_>>()?;
    let sessions = prepared.iter().map(|prepared| &prepared.session);
    let say = |text: String| job.status.report(&text);
    let show = |watched: Watched| watched.show(sessions, &goals, &job.settings, &job.evaluation, say);
    let server = watched.map(show).transpose()?;
    let sources: Vec<JoinHandle<Result<SourceResult>>> =
        prepared.into_iter().map(|prepared| task::spawn(attach_one(prepared, Arc::clone(&job)))).collect();
    let mut writer = ResultWriter::new(job.format.clone());
    if let Some(messages) = messages {
        let all = stop.clone();
        let view = View::show(monitors, messages, Arc::clone(&job.evaluation), view_options.unwrap_or_default(), stop)?;
        let on_hangup = job.args.live.hangup;
        if on_hangup.is_none() && !job.args.record.is_empty() {
            job.status.report(RECORDING_GOES_ON);
        }
        let alone = || match on_hangup {
            Some(OnHangup::Stop) => all.cancel(),
            Some(OnHangup::Continue) => {}
            // without a terminal only what is recorded is worth continuing for
            None => unrecorded.iter().for_each(CancellationToken::cancel),
        };
        let results = view.until(all_of(sources), alone, report).await?;
        unless_closed(results.into_iter().try_for_each(|measured| writer.write(measured)))?;
    } else {
        let mut written = Ok(());
        for source in sources {
            let measured = source.await.context(FAULT).and_then(|measured| measured);
            written = written.and(measured.and_then(|measured| job.status.suspend(|| writer.write(measured))));
            if written.is_err() {
                // the other sources end properly: recordings complete, settings restored
                stop.cancel();
            }
        }
        unless_closed(written)?;
    }
    // its last state is the end of all sources
    drop(server);
    writer.finish()
}

/// A session that has begun.
struct Prepared {
    session: Session,
    writer: Option<SampleWriter>,
    stop: CancellationToken,
}

struct Job {
    args: AttachArgs,
    settings: Settings,
    evaluation: Arc<Evaluation>,
    format: OutputFormat,
    /// As given by the user.
    conditions: BTreeMap<String, String>,
    status: StatusLines,
    log: Entries,
}

impl Job {
    /// The name of the source in this place: emulated sensors have numbers if there are several.
    fn name_of(&self, name: &SourceName, place: u64) -> String {
        let emulated =
            |places: usize| self.args.sources.iter().take(places).filter(|name| **name == SourceName::Sim).count();
        match name {
            SourceName::Sim if emulated(usize::MAX) > 1 => format!("sim-{}", emulated(place as usize) + 1),
            name => name.to_string(),
        }
    }

    fn read_options(&self) -> ReadOptions {
        let args = &self.args;
        ReadOptions {
            // a result that is written between two reads must be the same however the bytes were read
            line_by_line: self.format.lines().is_some(),
            measured: args.measure.measure.or(args.live.change.measured()).unwrap_or_default(),
            ..args.measure.read_options()
        }
    }

    fn source(&self, name: &SourceName, number: u64) -> Result<LiveSource> {
        let mut link = self.args.live.link.clone();
        // two emulated sensors are two sensors
        link.sim.seed = link.sim.seed.wrapping_add(number);
        live_source(name, &link, self.read_options(), &self.log)
    }

    fn session(
        &self,
        name: &SourceName,
        number: u64,
        source: Result<LiveSource>,
        recording: Option<PathBuf>,
        samples: Option<SampleTap>,
        stop: CancellationToken,
    ) -> Session {
        let args = &self.args;
        let spec = LiveSpec {
            name: self.name_of(name, number),
            kind: (source.is_ok() || *name != SourceName::Sim).then(|| name.kind()),
            source: source.map_err(Into::into),
            settings: self.settings.clone(),
            temperature: args.live.temperature,
            output: args.live.change.settings(),
            conditions: self.conditions.clone(),
            recording: recording.map(|path| RecordingSpec {
                path,
                resume: args.live.resume,
                rotation: args.live.rotate,
            }),
            each_second: self.format.lines().is_some(),
            samples,
            limits: args.live.limits(),
            stop,
        };
        Session::live(spec)
    }
}

async fn attach_one(prepared: Prepared, job: Arc<Job>) -> Result<SourceResult> {
    let Prepared { session, writer: samples, stop } = prepared;
    let mut written = Ok(());
    let result = follow(session, &job, &stop, &mut written).await?;
    let was_opened = match &result.start_error {
        Some(StartError::StreamInput(_)) => result.measured.source.kind.is_some(),
        Some(error) => matches!(error, StartError::Live(_)),
        None => true,
    };
    // the recordings of a witness kit are named when they are packed
    if job.format != OutputFormat::Counts {
        job.status.report_recorded(&result.measured.source.name, result.recording.as_ref());
    }
    let of = if job.format.records_alone() { ResultOf::Recording } else { ResultOf::Sensor };
    let mut measured = evaluated(result, &job.evaluation, of).await?;
    if let Some(samples) = samples {
        samples.finish(&mut measured).await;
    }
    unless_closed(written)?;
    let is_polled = measured.channels.iter().any(|channel| !channel.is_streamed());
    if job.args.live.temperature && !is_polled && measured.timing.duration_s > TEMPERATURE_EXPECTED_S {
        let why = "the sensor does not reply, or its baud rate leaves no room between sentences";
        job.status.report(&format!("{}: no temperature received: {why}", measured.source.name));
    }
    match job.format.lines() {
        Some(form) if was_opened => {
            let goals = job.settings.until.clone();
            write_aside(move || unless_closed(print_result(&measured, form, &goals)).map(|()| measured)).await
        }
        _ => Ok(measured),
    }
}

/// Whether its recording continues; `None` if that is not known yet.
fn is_recorded(state: &SourceState) -> Option<bool> {
    match (&state.stage, &state.recording) {
        (Stage::Preparing, _) => None,
        (_, recording) => Some(recording.as_ref().is_some_and(|recording| recording.error.is_none())),
    }
}

/// Follows a session to its end, showing where it is and writing the documents of every second
/// meanwhile. If these cannot be written, `written` says why, and it ends as when it is stopped,
/// unless so much of it is to be recorded, and lacks nothing that was asked for; where it is only
/// recorded, it ends once that fails.
async fn follow(
    mut session: Session,
    job: &Job,
    stop: &CancellationToken,
    written: &mut Result<()>,
) -> Result<SessionResult> {
    let name = session.state.borrow().name().to_owned();
    let show = |event| {
        // what a step asks for is done
        let is_expected = matches!(event, SessionEvent::SensorConfigured(_) | SessionEvent::SettingsRestored { .. });
        if is_expected && job.format == OutputFormat::Counts {
            return;
        }
        words::event(&name, event).into_iter().for_each(|text| job.status.report(&text));
    };
    let mut line: Option<StatusLine> = None;
    let mut link = None;
    let mut is_left = false;
    let lines = job.format.lines();
    let mut heartbeat = Heartbeat::start(Instant::now());
    let mut ticks = time::interval(StatusLines::PERIOD);
    let records_alone = job.format.records_alone();
    let next = if records_alone { "the session ends" } else { "the measurement continues" };
    loop {
        let is_recorded = is_recorded(&session.state.borrow());
        let is_to_be_recorded = is_recorded != Some(false) && job.settings.duration.is_some();
        let has_no_reader = written.is_err() && !is_to_be_recorded;
        if (has_no_reader || records_alone && is_recorded == Some(false)) && !stop.is_cancelled() {
            let state = session.state.borrow().clone();
            let line = line.get_or_insert_with(|| job.status.line(&name, next));
            line.show(state.link.as_ref(), state.recording.as_ref(), &state.snapshot);
            is_left = has_no_reader;
            stop.cancel();
        }
        tokio::select! {
            // pending messages are written before the result
            biased;
            Some(event) = session.events.recv() => show(event),
            Some(state) = session.seconds.recv() => {
                if let (Some(form), true) = (lines, written.is_ok()) {
                    let goals = job.settings.until.clone();
                    *written = write_aside(move || print_state(&state, form, &goals)).await;
                }
            }
            result = &mut session.result => {
                // the recording may have failed since the last tick
                let line = line.get_or_insert_with(|| job.status.line(&name, next));
                let next = if records_alone { next } else { "the result has what was measured" };
                line.report_recording(session.state.borrow().recording.as_ref(), next);
                let result = result.context(FAULT)?;
                return Ok(if is_left { SessionResult { shortfall: None, unmet: Vec::new(), ..result } } else { result });
            }
            Ok(()) = session.state.changed() => {
                let state = session.state.borrow_and_update().clone();
                match state.stage {
                    Stage::Measuring => {}
                    Stage::Preparing => continue,
                    Stage::Finishing | Stage::Ended(_) => {
                        line.iter().for_each(StatusLine::clear);
                        continue;
                    }
                }
                heartbeat.note(state.snapshot.link.samples(), Instant::now());
                let line = line.get_or_insert_with(|| job.status.line(&name, next));
                if let Some(now) = state.link.as_ref().filter(|_| state.link != link) {
                    job.log.link_state(&name, now);
                    line.report_link(now);
                }
                link.clone_from(&state.link);
            }
            () = sleep_until(heartbeat.next()), if lines.is_some() => {
                let state = session.state.borrow().clone();
                heartbeat.note(state.snapshot.link.samples(), Instant::now());
                let is_due = heartbeat.next() <= Instant::now()
                    && matches!(state.stage, Stage::Preparing | Stage::Measuring);
                let silent = heartbeat.beat(Instant::now());
                if is_due && written.is_ok() {
                    *written = write_aside(move || print_heartbeat(&state, silent)).await;
                }
            }
            _ = ticks.tick() => {
                let state = session.state.borrow().clone();
                if let (Some(line), Stage::Measuring) = (&mut line, &state.stage) {
                    line.show(state.link.as_ref(), state.recording.as_ref(), &state.snapshot);
                }
            }
        }
    }
}

/// Assesses and writes without holding up the tasks that measure.
async fn write_aside<T: Send + 'static>(write: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    task::spawn_blocking(write).await.context("internal error: the output stopped")?
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests;
