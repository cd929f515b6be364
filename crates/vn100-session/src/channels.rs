//! The channels between a session and its faces.

use std::sync::Arc;

use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use vn100_capture::Event;

use crate::{
    command::Command,
    sample_tap::SampleTap,
    session_event::SessionEvent,
    state::{SourceState, Stage},
};

/// Commands that may wait; beyond them `try_send` fails and `send` waits.
const WAITING_COMMANDS: usize = 8;

/// Session events that may wait to be taken; further ones are dropped.
const WAITING_EVENTS: usize = 64;

/// States of every second that may wait to be taken; when they are full, the measurement waits.
const WAITING_SECONDS: usize = 4;

/// Called with every event of a source before the event is measured, for example by a log. It must
/// not block.
pub type EventObserver = Arc<dyn Fn(&Event) + Send + Sync>;

/// The session's ends of its channels.
pub(crate) struct Channels {
    pub(crate) state: watch::Sender<SourceState>,
    pub(crate) commands: mpsc::Receiver<Command>,
    pub(crate) events: mpsc::Sender<SessionEvent>,
    /// The states of every second of data time; while the channel is full the measurement waits.
    pub(crate) seconds: Option<mpsc::Sender<SourceState>>,
    /// Receives the samples as well. While it is full, a capture or a stream waits.
    pub(crate) samples: Option<SampleTap>,
    pub(crate) observer: Option<EventObserver>,
    /// Ends the session.
    pub(crate) stop: CancellationToken,
}

impl Channels {
    /// Reports an event. It is dropped if 64 events are waiting, because events do not affect the result.
    pub(crate) fn report(&self, event: SessionEvent) {
        let _ = self.events.try_send(event);
    }

    pub(crate) fn stage(&self, stage: Stage) {
        self.state.send_modify(|state| state.stage = stage);
    }

    pub(crate) fn observe(&self, event: &Event) {
        if let Some(observer) = &self.observer {
            observer(event);
        }
    }
}

/// The faces' ends of the channels, before the session has its task.
pub(crate) struct Face {
    pub(crate) state: watch::Receiver<SourceState>,
    pub(crate) commands: mpsc::Sender<Command>,
    pub(crate) events: mpsc::Receiver<SessionEvent>,
    pub(crate) seconds: mpsc::Receiver<SourceState>,
}

pub(crate) fn open(
    state: SourceState,
    observer: Option<EventObserver>,
    stop: CancellationToken,
    each_second: bool,
) -> (Channels, Face) {
    let (publisher, state) = watch::channel(state);
    let (commands, inbox) = mpsc::channel(WAITING_COMMANDS);
    let (reporter, events) = mpsc::channel(WAITING_EVENTS);
    let (sender, seconds) = mpsc::channel(WAITING_SECONDS);
    let sender = each_second.then_some(sender);
    let channels = Channels {
        state: publisher,
        commands: inbox,
        events: reporter,
        seconds: sender,
        samples: None,
        observer,
        stop,
    };
    (channels, Face { state, commands, events, seconds })
}

#[cfg(test)]
mod tests {
    use vn100_analysis::{Settings, SourceFacts};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn events_of_a_session_that_are_not_taken_are_dropped() {
        let state = SourceState::new(SourceFacts::default(), &Settings::default());
        let (channels, mut face) = open(state, None, CancellationToken::new(), false);
        (0..1000).for_each(|_| channels.report(SessionEvent::OutputPausedAgain));
        drop(channels);
        let mut taken = 0;
        while face.events.recv().await.is_some() {
            taken += 1;
        }
        assert_eq!(taken, 64);
    }
}
