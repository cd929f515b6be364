//! The stream of what has changed: an event for each part of a new state of the page that the
//! reader does not have. A slow reader skips states. A reader who finds all streams taken gets the
//! present state and the end of the stream, and asks again after five seconds.

use std::{
    convert::Infallible,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::body::Bytes;
use tokio::{
    sync::{OwnedSemaphorePermit, watch},
    time::{self, Interval, MissedTickBehavior},
};
use tokio_stream::{Stream, wrappers::WatchStream};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

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

/// The interval of an event that changes nothing: the page tells by it that its stream stays open, and
/// is marked as old after five seconds without any event.
const KEEP_ALIVE: Duration = Duration::from_secs(2);

/// Says that a stream stays open, and that the program runs.
const ALIVE: &[u8] = b"event: alive\ndata:\n\n";

/// Ends the stream of a reader who found all streams taken; browsers ask again after the time in
/// milliseconds.
const FULL: &str = "retry: 5000\nevent: full\ndata: ";

/// The text of the events of one page for one reader.
pub(crate) struct PageEvents {
    states: WatchStream<Arc<PageState>>,
    over: Pin<Box<WaitForCancellationFutureOwned>>,
    page: usize,
    /// What the reader has received so far; `None` for nothing.
    place: Option<EventPlace>,
    alive: Interval,
    /// Whether a state was taken.
    has_state: bool,
    is_over: bool,
    /// The place of the stream among those that stay open; `None` for a reader of one state.
    stream: Option<OwnedSemaphorePermit>,
}

impl PageEvents {
    pub(crate) fn new(
        states: watch::Receiver<Arc<PageState>>,
        (page, place): (usize, Option<EventPlace>),
        over: CancellationToken,
        stream: Option<OwnedSemaphorePermit>,
    ) -> Self {
        let over = Box::pin(over.cancelled_owned());
        let mut alive = time::interval(KEEP_ALIVE);
        alive.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Self { states: WatchStream::new(states), over, page, place, alive, has_state: false, is_over: false, stream }
    }

    /// An event for each part of this state that the reader does not have; `None` if the reader had
    /// those of another run.
    fn events(&mut self, state: &PageState) -> Option<String> {
        if self.place.is_some_and(|place| place.run != state.run) {
            return None;
        }
        let seen = self.place.map_or(0, |place| place.version);
        let mut parts = state.since(seen, self.page).peekable();
        let mut text = String::new();
        while let Some(part) = parts.next() {
            // between words a new line is a space, and elsewhere there is none
            let html = part.html.replace(['\n', '\r'], " ");
            text += &format!("event: snapshot\ndata: {}\ndata: {html}\n", part.id);
            // the id of the last event is where the reader continues
            if parts.peek().is_none() {
                text += &format!("id: {}-{}\n", state.run, state.version);
            }
            text.push('\n');
        }
        self.place = Some(EventPlace { run: state.run, version: state.version });
        Some(text)
    }

    fn last(&mut self, event: impl Into<Bytes>) -> Poll<Option<Result<Bytes, Infallible>>> {
        self.is_over = true;
        Poll::Ready(Some(Ok(event.into())))
    }
}

impl Stream for PageEvents {
    type Item = Result<Bytes, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if self.is_over {
            return Poll::Ready(None);
        }
        if self.stream.is_none() && self.has_state {
            return self.last(format!("{FULL}{STREAMS}\n\n"));
        }
        if self.stream.is_some() && self.alive.poll_tick(context).is_ready() {
            return Poll::Ready(Some(Ok(Bytes::from_static(ALIVE))));
        }
        while let Poll::Ready(state) = Pin::new(&mut self.states).poll_next(context) {
            let Some(state) = state else { return Poll::Ready(None) };
            // not drawn yet
            if state.run == 0 {
                continue;
            }
            let Some(text) = self.events(&state) else { return self.last("event: other\ndata: another run\n\n") };
            self.has_state = true;
            if !text.is_empty() {
                return Poll::Ready(Some(Ok(text.into())));
            }
            if self.stream.is_none() {
                return self.last(format!("{FULL}{STREAMS}\n\n"));
            }
        }
        if self.over.as_mut().poll(context).is_ready() {
            return self.last("event: end\ndata: the program ends\n\n");
        }
        Poll::Pending
    }
}
