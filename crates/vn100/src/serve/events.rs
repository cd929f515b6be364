//! The stream of what has changed: an event for each part of a new state of the page that the
//! reader does not have. A slow reader skips states. A reader who finds all streams taken gets the
//! present state and the end of the stream, and asks again after five seconds.

use std::{convert::Infallible, sync::Arc, time::Duration};

use axum::response::{
    IntoResponse, Response,
    sse::{Event, KeepAlive, Sse},
};
use tokio::sync::{OwnedSemaphorePermit, mpsc, watch};
use tokio_stream::{StreamExt, wrappers::ReceiverStream};
use tokio_util::sync::CancellationToken;

use crate::serve::{STREAMS, drawing::PageState};

/// How far a reader has come: the run of the program, and the version of its page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct EventPlace {
    pub(crate) run: u64,
    pub(crate) version: u64,
}

impl EventPlace {
    /// The place in the form of event ids, `run-version`; `None` for any other text.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (run, version) = text.split_once('-')?;
        Some(Self { run: run.parse().ok()?, version: version.parse().ok()? })
    }
}

/// The longest time without an event: the page is marked as old after five seconds without any.
const KEEP_ALIVE: Duration = Duration::from_secs(2);

/// When a reader who found all streams taken asks again.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// A reader of the events of one page.
pub(crate) struct EventReader {
    pub(crate) states: watch::Receiver<Arc<PageState>>,
    pub(crate) page: usize,
    /// What the reader has received so far; `None` for nothing.
    pub(crate) place: Option<EventPlace>,
    pub(crate) over: CancellationToken,
    /// The place of the stream among those that stay open; `None` for a reader of one state.
    pub(crate) stream: Option<OwnedSemaphorePermit>,
}

impl EventReader {
    /// The answer to the reader. One event waits to be taken, and the next one for its place;
    /// meanwhile no other state is taken.
    pub(crate) fn answer(self) -> Response {
        let (events, inbox) = mpsc::channel(1);
        let stays_open = self.stream.is_some();
        // ends with the program, or when the answer is dropped
        tokio::spawn(self.send(events));
        let events = Sse::new(ReceiverStream::new(inbox).map(Ok::<_, Infallible>));
        match stays_open {
            true => events.keep_alive(KeepAlive::new().interval(KEEP_ALIVE).event(alive())).into_response(),
            false => events.into_response(),
        }
    }

    async fn send(mut self, events: mpsc::Sender<Event>) {
        tokio::select! {
            () = events.closed() => {}
            last = self.send_states(&events) => if let Some(last) = last {
                let _ = events.send(last).await;
            },
        }
    }

    /// Sends each new state; returns the last event.
    async fn send_states(&mut self, events: &mpsc::Sender<Event>) -> Option<Event> {
        if self.stream.is_some() {
            events.send(alive()).await.ok()?;
        }
        loop {
            let state = Arc::clone(&self.states.borrow_and_update());
            // 0 is not drawn yet
            if state.run != 0 {
                if self.place.is_some_and(|place| place.run != state.run) {
                    return Some(event("other", "another run"));
                }
                let seen = self.place.map_or(0, |place| place.version);
                let mut parts = state.since(seen, self.page).peekable();
                while let Some(part) = parts.next() {
                    let snapshot = event("snapshot", &format!("{}\n{}", part.id, part.html));
                    // the id of the last event is where the reader continues
                    let is_last = parts.peek().is_none();
                    let id = || format!("{}-{}", state.run, state.version);
                    events.send(if is_last { snapshot.id(id()) } else { snapshot }).await.ok()?;
                }
                self.place = Some(EventPlace { run: state.run, version: state.version });
                if self.stream.is_none() {
                    return Some(Event::default().retry(ASK_AGAIN).event("full").data(STREAMS.to_string()));
                }
            }
            tokio::select! {
                // checked first: the last state comes before the end
                biased;
                changed = self.states.changed() => changed.ok()?,
                () = self.over.cancelled() => return Some(event("end", "the program ends")),
            }
        }
    }
}

fn event(name: &str, data: &str) -> Event {
    Event::default().event(name).data(data)
}

/// Says that a stream stays open, and that the program runs.
fn alive() -> Event {
    event("alive", "the program runs")
}
