//! The tasks of one measurement, and the channels between them.
//!
//! ```text
//! reading thread --2 chunks--> read_samples --4 batches--> analyse --latest--> watchers
//!                                        controls --4 wishes--/   \--4 snapshots--> every second, if asked
//! ```
//!
//! Every channel is bounded. A full one holds back the one before it, down to the source: a capture
//! waits, and what a live source does is its own affair, to count. A watcher that does not look in
//! time misses snapshots and delays nobody.

use std::{io, sync::Arc, time::Duration};

use tokio::{
    sync::{mpsc, oneshot, watch},
    task::JoinHandle,
    time::{self, MissedTickBehavior},
};
use vn100_analysis::{Analysis, Assessment, Settings, Snapshot};
use vn100_capture::{CsvReport, End, Event};

/// Snapshots of every second that may wait for whoever writes them down.
const WAITING_SECONDS: usize = 4;

/// Wishes that may wait to be taken; whoever has one then waits.
const WAITING_WISHES: usize = 4;

/// A measurement under way.
#[derive(Debug)]
pub struct Measurement {
    /// The latest snapshot, as often as the [settings](Settings::watch_every) say.
    pub latest: watch::Receiver<Arc<Snapshot>>,
    /// What may be asked of it meanwhile.
    pub controls: Controls,
    analysis: JoinHandle<Outcome>,
}

/// What may be asked of a measurement under way.
#[derive(Debug, Clone)]
pub struct Controls {
    wishes: mpsc::Sender<(Wish, oneshot::Sender<Duration>)>,
}

#[derive(Debug, Clone, Copy)]
enum Wish {
    EndWarmUp,
    StartOver,
}

impl Controls {
    /// See [`Analysis::end_warm_up`]; `None` when the measurement is over.
    pub async fn end_warm_up(&self) -> Option<Duration> {
        self.ask(Wish::EndWarmUp).await
    }

    /// See [`Analysis::start_over`]; `None` when the measurement is over.
    pub async fn start_over(&self) -> Option<Duration> {
        self.ask(Wish::StartOver).await
    }

    async fn ask(&self, wish: Wish) -> Option<Duration> {
        let (answer, answered) = oneshot::channel();
        self.wishes.send((wish, answer)).await.ok()?;
        answered.await.ok()
    }
}

/// How a measurement ended.
#[derive(Debug)]
pub struct Outcome {
    /// The final results.
    pub snapshot: Arc<Snapshot>,
    /// The error that ended the source, if one did. The results up to it stand.
    pub source_error: Option<io::Error>,
    /// What became of the lines, where the source is a CSV file.
    pub csv: Option<CsvReport>,
}

/// A task of the measurement died; its results are lost. This is a fault of the program.
#[derive(Debug, thiserror::Error)]
#[error("the analysis stopped by a fault of this program")]
pub struct Died(#[from] tokio::task::JoinError);

/// Starts a task that measures a stream of samples, until it ends.
///
/// `every_second` gets a snapshot whenever a second of data time has passed: see [`every_second`].
///
/// # Panics
/// Outside a tokio runtime with time enabled.
#[must_use]
pub fn start(
    events: mpsc::Receiver<Event>,
    settings: Settings,
    every_second: Option<mpsc::Sender<Arc<Snapshot>>>,
) -> Measurement {
    let analysis = Analysis::new(settings);
    let (watchers, latest) = watch::channel(Arc::new(analysis.snapshot()));
    let (wishes, wished) = mpsc::channel(WAITING_WISHES);
    let analysis = tokio::spawn(analyse(events, analysis, wished, watchers, every_second));
    Measurement { latest, controls: Controls { wishes }, analysis }
}

/// A channel for the snapshots of every second of data time; see [`start`]. When it is full the
/// measurement waits: only for sources that can.
#[must_use]
pub fn every_second() -> (mpsc::Sender<Arc<Snapshot>>, mpsc::Receiver<Arc<Snapshot>>) {
    mpsc::channel(WAITING_SECONDS)
}

impl Measurement {
    /// Waits for the end.
    ///
    /// # Errors
    /// [`Died`] when the analysis panicked.
    pub async fn outcome(self) -> Result<Outcome, Died> {
        Ok(self.analysis.await?)
    }
}

/// Looks whether the goals of a measurement are met, or one of them is out of reach: at every
/// second of data time at first, later whenever the record has grown by a twentieth. Where it ends
/// depends on the samples alone.
#[derive(Debug, Default)]
struct EndOfSearch {
    next_second: u64,
}

impl EndOfSearch {
    fn is_reached(&mut self, analysis: &Analysis) -> bool {
        let goals = &analysis.settings().until;
        let second = analysis.seconds();
        if goals.is_empty() || second < self.next_second {
            return false;
        }
        self.next_second = second + second.div_ceil(20).max(1);
        let snapshot = analysis.snapshot();
        if goals.iter().any(|goal| goal.out_of_reach(&snapshot).is_some()) {
            return true;
        }
        let assessment = Assessment::new(&snapshot, analysis.settings().confidence);
        goals.iter().all(|goal| goal.is_met(&snapshot, &assessment))
    }
}

async fn analyse(
    mut events: mpsc::Receiver<Event>,
    mut analysis: Analysis,
    mut wishes: mpsc::Receiver<(Wish, oneshot::Sender<Duration>)>,
    watchers: watch::Sender<Arc<Snapshot>>,
    every_second: Option<mpsc::Sender<Arc<Snapshot>>>,
) -> Outcome {
    let mut ticks = time::interval(analysis.settings().watch_every.max(Duration::from_millis(1)));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut changed = false;
    let mut seconds = 0;
    let mut end_of_search = EndOfSearch::default();
    let end = loop {
        tokio::select! {
            event = events.recv() => match event {
                Some(event) => {
                    match event {
                        Event::Batch(batch) => analysis.absorb(&batch),
                        // a lost link sets free the lines that waited for others
                        Event::Link(event) => analysis.take_link_event(&event),
                        Event::End(end) => break end,
                    }
                    changed = true;
                    if analysis.is_complete() || end_of_search.is_reached(&analysis) {
                        break End { error: None, csv: None };
                    }
                    if let Some(queue) = &every_second
                        && analysis.seconds() > seconds
                    {
                        seconds = analysis.seconds();
                        // whoever asked for them may have left; the measurement goes on
                        let _ = queue.send(Arc::new(analysis.snapshot())).await;
                    }
                }
                // the reading task died: what it delivered stands
                None => {
                    let error = io::Error::other("the task that reads the source stopped");
                    break End { error: Some(error), csv: None };
                }
            },
            // without anybody to wish, the other branches go on
            Some((wish, answer)) = wishes.recv() => {
                let so_far = match wish {
                    Wish::EndWarmUp => analysis.end_warm_up(),
                    Wish::StartOver => analysis.start_over(),
                };
                (seconds, end_of_search) = (analysis.seconds(), EndOfSearch::default());
                // whoever asked may have left
                let _ = answer.send(so_far);
                changed = true;
            }
            _ = ticks.tick(), if changed && watchers.receiver_count() > 0 => {
                changed = false;
                watchers.send_replace(Arc::new(analysis.snapshot()));
            }
        }
    };
    analysis.finish();
    let snapshot = Arc::new(analysis.snapshot());
    watchers.send_replace(Arc::clone(&snapshot));
    Outcome { snapshot, source_error: end.error, csv: end.csv }
}
