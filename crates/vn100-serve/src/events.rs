//! The stream of what has changed: an event for each part of a new state of the page that the
//! reader does not have. One who reads slowly skips states.

use std::{
    collections::{BTreeMap, VecDeque},
    convert::Infallible,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
};

use axum::response::sse::Event;
use tokio::sync::{OwnedSemaphorePermit, watch};
use tokio_stream::{Stream, wrappers::WatchStream};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};
use vn100_report::PagePart;

use crate::drawing::PageState;

/// Where a reader has come: the run of the program, and the version of its page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct EventPlace {
    pub(crate) run: u64,
    pub(crate) version: u64,
}

impl EventPlace {
    /// As the events are numbered.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (run, version) = text.split_once('-')?;
        Some(Self { run: run.parse().ok()?, version: version.parse().ok()? })
    }
}

/// The events for one reader.
pub(crate) struct PageEvents {
    pages: WatchStream<Arc<PageState>>,
    over: Pin<Box<WaitForCancellationFutureOwned>>,
    /// `None` for one who has nothing yet.
    place: Option<EventPlace>,
    /// Parts of the state that is being sent, one at a time: a whole one is large.
    unsent: VecDeque<Arc<PagePart>>,
    is_over: bool,
    _stream: OwnedSemaphorePermit,
}

impl PageEvents {
    pub(crate) fn new(
        pages: watch::Receiver<Arc<PageState>>,
        place: Option<EventPlace>,
        over: CancellationToken,
        stream: OwnedSemaphorePermit,
    ) -> Self {
        let over = Box::pin(over.cancelled_owned());
        Self { pages: WatchStream::new(pages), over, place, unsent: VecDeque::new(), is_over: false, _stream: stream }
    }

    /// The next part; with the last of a state its place, from which a reader continues.
    fn part(&mut self) -> Option<Event> {
        let part = self.unsent.pop_front()?;
        let content = BTreeMap::from([(&part.id, &part.html)]);
        // texts alone are serialised
        let event = Event::default().event("snapshot").data(serde_json::to_string(&content).unwrap_or_default());
        match self.place.filter(|_| self.unsent.is_empty()) {
            Some(EventPlace { run, version }) => Some(event.id(format!("{run}-{version}"))),
            None => Some(event),
        }
    }

    /// Takes what the reader does not have of this page; whether it is of another run.
    fn take(&mut self, page: &PageState) -> bool {
        let run = page.run();
        if self.place.is_some_and(|place| place.run != run) {
            return true;
        }
        let seen = self.place.map_or(0, |place| place.version);
        self.unsent = page.since(seen).collect();
        self.place = Some(EventPlace { run, version: page.version() });
        false
    }
}

impl Stream for PageEvents {
    type Item = Result<Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if self.is_over {
            return Poll::Ready(None);
        }
        loop {
            if let Some(part) = self.part() {
                return Poll::Ready(Some(Ok(part)));
            }
            match Pin::new(&mut self.pages).poll_next(context) {
                // not drawn yet
                Poll::Ready(Some(page)) if page.run() == 0 => {}
                Poll::Ready(Some(page)) => {
                    if self.take(&page) {
                        self.is_over = true;
                        return Poll::Ready(Some(Ok(Event::default().event("other").data("another run"))));
                    }
                }
                Poll::Ready(None) => return Poll::Ready(None),
                Poll::Pending => break,
            }
        }
        if self.over.as_mut().poll(context).is_ready() {
            self.is_over = true;
            return Poll::Ready(Some(Ok(Event::default().event("end").data("the program ends"))));
        }
        Poll::Pending
    }
}
