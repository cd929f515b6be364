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
    channels::{Channels, Face, open},
    command::Command,
    live::{LiveSpec, run_live},
    measure::{Measurement, Origin, measure},
    replay::{ReplaySpec, run_replay},
    session_event::SessionEvent,
    session_result::{SessionResult, result},
    state::{SourceState, Stage},
};

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
    #[must_use]
    pub fn live(spec: LiveSpec) -> Self {
        let source = SourceFacts {
            name: spec.name.clone(),
            kind: spec.kind,
            meta: (!spec.conditions.is_empty()).then(|| spec.conditions.clone()),
            ..SourceFacts::default()
        };
        let state = SourceState::new(source, &spec.settings);
        let (mut channels, face) = open(state, spec.observer(), spec.stop.child_token(), spec.each_second);
        channels.samples.clone_from(&spec.samples);
        face.run(run_live(spec, channels))
    }

    /// Measures a capture to its end, or until the session is stopped; with a speed, at the pace of
    /// the sensor, and until the session is stopped.
    ///
    /// # Panics
    /// If called outside a tokio runtime with time enabled.
    #[must_use]
    pub fn replay(spec: ReplaySpec) -> Self {
        let source = SourceFacts { name: spec.name(), ..SourceFacts::default() };
        let state = SourceState::new(source, &spec.settings);
        let (mut channels, face) = open(state, spec.observer.clone(), spec.stop.child_token(), spec.each_second);
        channels.samples.clone_from(&spec.samples);
        face.run(run_replay(spec, channels))
    }

    /// Measures the events of any source, until they end or the session is stopped.
    ///
    /// # Panics
    /// If called outside a tokio runtime with time enabled.
    #[must_use]
    pub fn of_events(source: SourceFacts, events: mpsc::Receiver<Event>, settings: Settings) -> Self {
        let state = SourceState::new(source, &settings);
        let (channels, face) = open(state, None, CancellationToken::new(), false);
        face.run(run_events(events, settings, channels))
    }
}

async fn run_events(events: mpsc::Receiver<Event>, settings: Settings, mut channels: Channels) -> SessionResult {
    let goals = settings.until.clone();
    let measurement = Measurement { events, settings, origin: Origin::Events, ends_as_recorded: false };
    let ending = measure(measurement, &mut channels).await;
    channels.end(result(ending, &goals, &channels))
}

impl Face {
    fn run(self, session: impl Future<Output = SessionResult> + Send + 'static) -> Session {
        let Self { state, commands, events, seconds } = self;
        Session { state, commands, events, seconds, result: tokio::spawn(session) }
    }
}

impl Channels {
    pub(crate) fn end(&self, result: SessionResult) -> SessionResult {
        self.stage(Stage::Ended(Arc::clone(&result.end)));
        result
    }
}
