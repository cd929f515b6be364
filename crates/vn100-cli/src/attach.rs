//! `vn100 attach`: live sensors through the pipeline until stopped, one result each, in the order given.

use std::{sync::Arc, time::Duration};

use anyhow::{Context, Result};
use tokio::{
    runtime::Runtime,
    task::{self, JoinHandle},
    time::{self, Instant},
};
use tokio_util::sync::CancellationToken;
use vn100_driver::{LinkState, ReadOptions};
use vn100_pipeline::{Outcome, Settings, Snapshot, start};

use crate::{
    args::{AttachArgs, SourceName},
    document::{Document, Origin},
    exit::Exit,
    interrupt::stop_on_interrupt,
    live_source::LiveSource,
    measured::{Measured, Teller, Telling, print_line},
    status::Status,
};

/// A sensor that is heard and sends no measurement in this time will send none: it is set to something else.
const NO_MEASUREMENT_AFTER: Duration = Duration::from_secs(4);

pub(crate) fn attach(args: AttachArgs) -> Result<Exit> {
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    let exit = runtime.block_on(attach_all(args));
    // a thread may hang in a read of standard input that nobody waits for any more
    runtime.shutdown_background();
    exit
}

async fn attach_all(args: AttachArgs) -> Result<Exit> {
    let stop = stop_on_interrupt().context("cannot listen to Ctrl-C")?;
    let job = Arc::new(Job {
        settings: args.measure.settings(),
        read: args.measure.read_options(),
        telling: args.measure.telling(),
        status: Status::new(),
        args,
    });
    let sources: Vec<JoinHandle<Result<Measured>>> = (job.args.sources.iter())
        .map(|source| task::spawn(attach_one(source.clone(), Arc::clone(&job), stop.child_token())))
        .collect();
    let mut teller = Teller::new(job.telling);
    for source in sources {
        let measured = source.await.context("the measurement stopped by a fault of this program")??;
        job.status.suspend(|| teller.tell(&measured))?;
    }
    teller.finish()
}

/// What all sources of one command share.
struct Job {
    args: AttachArgs,
    settings: Settings,
    read: ReadOptions,
    telling: Telling,
    status: Status,
}

async fn attach_one(source: SourceName, job: Arc<Job>, stop: CancellationToken) -> Result<Measured> {
    let mut origin = Origin { name: source.to_string(), ..Origin::default() };
    let live = match LiveSource::open(&source, &job.args.link, job.read, stop.clone()) {
        Ok(live) => live,
        Err(error) => {
            origin.error = Some(format!("{error:#}"));
            return Ok(Measured::nothing(origin, job.settings));
        }
    };
    origin.kind = Some(live.kind);
    let outcome = measure(live, &origin, &job, &stop).await?;
    let measured = Measured::of(origin, outcome);
    if job.telling == Telling::Ndjson {
        tell_line(measured.document()).await?;
    }
    Ok(measured)
}

/// Measures one source to its end, showing where it is and writing the documents of every second meanwhile.
async fn measure(live: LiveSource, origin: &Origin, job: &Job, stop: &CancellationToken) -> Result<Outcome> {
    let states = live.link.as_ref().map(|link| link.state());
    let measurement = start(live.events, job.settings, None);
    let latest = measurement.latest.clone();
    let outcome = measurement.outcome();
    tokio::pin!(outcome);
    let mut line = job.status.line(&origin.name);
    let mut ticks = time::interval(Status::PERIOD);
    let mut seconds = latest.clone();
    let mut told_second = 0;
    let mut heard = None;
    loop {
        tokio::select! {
            outcome = &mut outcome => return Ok(outcome?),
            // a writer that stalls misses seconds and delays nothing
            Ok(()) = seconds.changed(), if job.telling == Telling::Ndjson => {
                let snapshot = Arc::clone(&seconds.borrow_and_update());
                let second = snapshot.timing.duration_s() as u64;
                if second > told_second {
                    told_second = second;
                    tell_line(Document::new(origin, &snapshot)).await?;
                }
            }
            _ = ticks.tick() => {
                let snapshot = Arc::clone(&latest.borrow());
                let state = states.as_ref().map(|state| state.borrow().clone());
                line.show(state.as_ref(), &snapshot);
                if sends_no_measurement(&snapshot) && matches!(state, None | Some(LinkState::Up(_) | LinkState::Silent(_))) {
                    let heard: &mut Instant = heard.get_or_insert_with(Instant::now);
                    if heard.elapsed() > NO_MEASUREMENT_AFTER {
                        stop.cancel();
                    }
                }
            }
        }
    }
}

/// Whether good lines came, and none of them was a measurement.
fn sends_no_measurement(snapshot: &Snapshot) -> bool {
    snapshot.layout.is_none() && snapshot.link.tally.good_lines() + snapshot.link.tally.packets > 0
}

/// Writes a document without holding up the tasks that measure.
async fn tell_line(document: Document) -> Result<()> {
    task::spawn_blocking(move || print_line(&document))
        .await
        .context("the output stopped by a fault of this program")?
}
