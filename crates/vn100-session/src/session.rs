//! A session, as seen by its faces.

use std::sync::Arc;

use tokio::{
    sync::{mpsc, watch},
    task::JoinHandle,
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Settings, SourceFacts};
use vn100_capture::Event;

use crate::{
    channels::{Channels, EventObserver},
    command::Command,
    live::{LiveSpec, run_live},
    measure::{Measuring, measure},
    replay::{ReplaySpec, run_replay},
    sample_tap::SampleTap,
    session_event::SessionEvent,
    session_result::{SessionResult, result},
    state::{SourceState, Stage},
};

/// Commands that may wait; beyond them `try_send` fails and `send` waits.
const WAITING_COMMANDS: usize = 8;

/// Session events that may wait to be taken; further ones are dropped.
const WAITING_EVENTS: usize = 64;

/// States of every second that may wait to be taken; when they are full, the measurement waits.
const WAITING_SECONDS: usize = 4;

/// A session in progress, in a task of its own. Dropping the handle does not end it: cancel its
/// token or send [`Command::Stop`].
#[derive(Debug)]
pub struct Session {
    /// The state, now and whenever it changes.
    pub state: watch::Receiver<SourceState>,
    /// Takes commands.
    pub commands: mpsc::Sender<Command>,
    /// Events besides the measurement.
    pub events: mpsc::Receiver<SessionEvent>,
    /// The state at every second of data time, if the specification asks for it. Until a state is
    /// taken, a capture or a stream waits; a link cannot wait, so the states of some seconds are
    /// dropped.
    pub seconds: mpsc::Receiver<SourceState>,
    /// The result. Awaiting it fails only if the task panics, or if the runtime ends before.
    pub result: JoinHandle<SessionResult>,
}

impl Session {
    /// Measures a live sensor until the session is stopped, its goals are decided or its stream
    /// ends: begins the recording, configures the sensor, measures, ends the recording, restores
    /// the settings.
    ///
    /// # Panics
    /// If called outside a tokio runtime with time enabled.
    pub fn live(spec: LiveSpec) -> Self {
        let source = SourceFacts {
            name: spec.name.clone(),
            kind: spec.kind,
            meta: (!spec.conditions.is_empty()).then(|| spec.conditions.clone()),
            ..SourceFacts::default()
        };
        let state = SourceState::new(source, &spec.settings);
        let observer = spec.source.as_ref().ok().and_then(|source| source.observer.clone());
        let (samples, stop) = (spec.samples.clone(), spec.stop.child_token());
        Self::start(state, observer, samples, spec.each_second, stop, |channels| run_live(spec, channels))
    }

    /// Measures a capture to its end, or until the session is stopped; with a speed, at the pace of
    /// the sensor, and until the session is stopped.
    ///
    /// # Panics
    /// If called outside a tokio runtime with time enabled.
    pub fn replay(spec: ReplaySpec) -> Self {
        let source = SourceFacts { name: spec.name(), ..SourceFacts::default() };
        let state = SourceState::new(source, &spec.settings);
        let (observer, samples, stop) = (spec.observer.clone(), spec.samples.clone(), spec.stop.child_token());
        Self::start(state, observer, samples, spec.each_second, stop, |channels| run_replay(spec, channels))
    }

    /// Measures the events of any source, until they end or the session is stopped.
    ///
    /// # Panics
    /// If called outside a tokio runtime with time enabled.
    pub fn of_events(source: SourceFacts, events: mpsc::Receiver<Event>, settings: Settings) -> Self {
        let state = SourceState::new(source, &settings);
        let stop = CancellationToken::new();
        Self::start(state, None, None, false, stop, |channels| run_events(events, settings, channels))
    }

    /// Runs `session` in a task of its own, with channels between the two.
    fn start<F>(
        state: SourceState,
        observer: Option<EventObserver>,
        samples: Option<SampleTap>,
        each_second: bool,
        stop: CancellationToken,
        session: impl FnOnce(Channels) -> F,
    ) -> Self
    where
        F: Future<Output = SessionResult> + Send + 'static,
    {
        let (publisher, state) = watch::channel(state);
        let (commands, inbox) = mpsc::channel(WAITING_COMMANDS);
        let (reporter, events) = mpsc::channel(WAITING_EVENTS);
        let (sender, seconds) = mpsc::channel(WAITING_SECONDS);
        let channels = Channels {
            state: publisher,
            commands: inbox,
            events: reporter,
            seconds: each_second.then_some(sender),
            samples,
            observer,
            stop,
        };
        Self { state, commands, events, seconds, result: tokio::spawn(session(channels)) }
    }
}

async fn run_events(events: mpsc::Receiver<Event>, settings: Settings, mut channels: Channels) -> SessionResult {
    let goals = settings.until.clone();
    let ending = measure(Measuring::new(settings), events, None, false, &mut channels).await;
    channels.end(result(ending, &goals, &channels))
}

impl Channels {
    pub(crate) fn end(&self, result: SessionResult) -> SessionResult {
        self.stage(Stage::Ended(Arc::clone(&result.end)));
        result
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::{Settings, SourceFacts};

    use super::*;
    use crate::{session_result::not_started, start_error::StartError};

    #[tokio::test(start_paused = true)]
    async fn events_of_a_session_that_are_not_taken_are_dropped() {
        let state = SourceState::new(SourceFacts::default(), &Settings::default());
        let mut session = Session::start(state, None, None, false, CancellationToken::new(), async |channels| {
            (0..1000).for_each(|_| channels.report(SessionEvent::OutputPausedAgain));
            not_started(StartError::Stopped, &channels)
        });
        session.result.await.unwrap();
        let mut taken = 0;
        while session.events.recv().await.is_some() {
            taken += 1;
        }
        assert_eq!(taken, 64);
    }
}
