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
