//! The stream of what has changed: an event for each new state of the page, with the parts that the
//! reader does not have. One who reads slowly skips states.

use std::{
    convert::Infallible,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
};

use axum::response::sse::Event;
use tokio::sync::{OwnedSemaphorePermit, watch};
use tokio_stream::{Stream, wrappers::WatchStream};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

use crate::drawing::PageState;

/// Where a reader has come: the run of the program, and the version of its page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) run: u64,
    pub(crate) version: u64,
}

impl Place {
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
    place: Option<Place>,
    is_over: bool,
    _stream: OwnedSemaphorePermit,
}

impl PageEvents {
    pub(crate) fn new(
        pages: watch::Receiver<Arc<PageState>>,
        place: Option<Place>,
        over: CancellationToken,
        stream: OwnedSemaphorePermit,
    ) -> Self {
        let over = Box::pin(over.cancelled_owned());
        Self { pages: WatchStream::new(pages), over, place, is_over: false, _stream: stream }
    }

    /// What the reader does not have of this page.
    fn event(&mut self, page: &PageState) -> Option<Event> {
        let run = page.run();
        if self.place.is_some_and(|place| place.run != run) {
            self.is_over = true;
            return Some(Event::default().event("other").data("another run"));
        }
        let seen = self.place.map_or(0, |place| place.version);
        let changed = page.since(seen);
        if changed.is_empty() {
            return None;
        }
        self.place = Some(Place { run, version: page.version() });
        // texts alone are serialised
        let data = serde_json::to_string(&changed).unwrap_or_default();
        Some(Event::default().event("snapshot").id(format!("{run}-{}", page.version())).data(data))
    }
}

impl Stream for PageEvents {
    type Item = Result<Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if self.is_over {
            return Poll::Ready(None);
        }
        loop {
            match Pin::new(&mut self.pages).poll_next(context) {
                // not drawn yet
                Poll::Ready(Some(page)) if page.run() == 0 => {}
                Poll::Ready(Some(page)) => {
                    if let Some(event) = self.event(&page) {
                        return Poll::Ready(Some(Ok(event)));
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
