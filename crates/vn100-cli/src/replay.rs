//! `vn100 replay`: recorded captures through the pipeline, one result each, in the order given; at
//! full speed, or in the view at the pace of the sensor or another.

use std::{path::PathBuf, sync::Arc};

use anyhow::{Context, Result, bail};
use tokio::{
    runtime::Builder,
    task::{self, JoinHandle},
};
use vn100_analysis::Settings;
use vn100_pipeline::{ReplaySpec, Session, Speed};
use vn100_report::{Completion, Evaluation, Measured};

use crate::{
    args::ReplayArgs,
    exit::{HangUp, stop_on_interrupt},
    files::{measure_files, replay_spec},
    log::{Entries, run_logged, takes_terminal},
    result::{FAULT, ResultWriter, all_of, evaluated_replay},
    user_files::evaluation,
    view::{self, MessageQueue, SourceMonitor, View},
    words,
};

pub(crate) fn replay(args: &ReplayArgs) -> Result<Completion> {
    let files = &args.files;
    if let Some(speed) = args.speed {
        return replay_in_view(args, speed);
    }
    let evaluation = evaluation(&files.measure, args.result.filter_models)?;
    let mut writer = ResultWriter::new(args.result.format());
    measure_files(files, evaluation, args.result.ndjson, |measured| writer.write(&measured))?;
    writer.finish()
}

/// Replays in the view until the user quits it, and writes the results as any replay does.
fn replay_in_view(args: &ReplayArgs, speed: Speed) -> Result<Completion> {
    if !view::is_there() {
        bail!(
            "--speed is for the view, which needs a terminal before and behind it; without --speed the result is printed at once"
        );
    }
    if takes_terminal(&args.files.log) {
        bail!("-v would be written over the view: --log FILE keeps the diagnostics beside it");
    }
    let work = async |log| replay_all(args, speed, log).await;
    run_logged(&mut Builder::new_multi_thread(), &args.files.log, work)
}

async fn replay_all(args: &ReplayArgs, speed: Speed, log: Entries) -> Result<Completion> {
    let files = &args.files;
    let stop = stop_on_interrupt(HangUp::HandledByView)?;
    let messages = MessageQueue::default();
    let evaluation = Arc::new(evaluation(&files.measure, args.result.filter_models)?);
    let session = |path: &PathBuf| {
        let settings = Settings { recent: true, ..files.measure.settings() };
        Session::replay(ReplaySpec { settings, speed: Some(speed), ..replay_spec(files, path, &log, &stop) })
    };
    let sessions: Vec<Session> = files.files.iter().map(session).collect();
    let monitors = sessions.iter().map(SourceMonitor::of).collect();
    let follow = |session| task::spawn(follow(session, messages.clone(), Arc::clone(&evaluation)));
    let results: Vec<JoinHandle<Result<Measured>>> = sessions.into_iter().map(follow).collect();
    let all_stop = stop.clone();
    let view = View::show(monitors, messages, evaluation, stop)?;
    let all = view.until(all_of(results), || all_stop.cancel()).await?;
    let mut writer = ResultWriter::new(args.result.format());
    all.iter().try_for_each(|measured| writer.write(measured))?;
    writer.finish()
}

async fn follow(mut session: Session, messages: MessageQueue, evaluation: Arc<Evaluation>) -> Result<Measured> {
    let name = session.state.borrow().name().to_owned();
    let report = |event| words::event(&name, event).into_iter().for_each(|text| messages.push(text));
    let result = loop {
        tokio::select! {
            // those that wait stand before the result
            biased;
            Some(event) = session.events.recv() => report(event),
            result = &mut session.result => break result.context(FAULT)?,
        }
    };
    evaluated_replay(result, &evaluation).await
}
