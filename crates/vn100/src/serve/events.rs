//! The stream of what has changed: an event for each part of a new state of the page that the
//! reader does not have. A slow reader skips states. A reader who finds all streams taken gets the
//! present state and the end of the stream, and asks again after five seconds.

use std::{
    collections::VecDeque,
    convert::Infallible,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::body::Bytes;
use tokio::{
    sync::{OwnedSemaphorePermit, watch},
    time::{self, Interval},
};
use tokio_stream::{Stream, wrappers::WatchStream};
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};
use vn100_report::html::PagePart;

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

/// After this time without an event one is sent that changes nothing: the page tells by it that the
/// program runs, and is marked as old after five seconds without one.
const KEEP_ALIVE: Duration = Duration::from_secs(2);

/// Begins each stream that stays open, and keeps it.
const ALIVE: &[u8] = b"event: alive\ndata:\n\n";

/// Ends the stream of a reader who found all streams taken; browsers ask again after the time in
/// milliseconds.
const FULL: &str = "retry: 5000\nevent: full\ndata: ";

/// The content of a part, which all readers share.
struct Html(Arc<PagePart>);

impl AsRef<[u8]> for Html {
    fn as_ref(&self) -> &[u8] {
        self.0.html.as_bytes()
    }
}

/// Which parts of the page a reader receives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ShownParts {
    /// Every part.
    All,
    /// The details of these sources alone, by their prefixes.
    Open(Vec<String>),
}

impl ShownParts {
    /// The details of the sources with these prefixes, separated by commas.
    pub(crate) fn open(prefixes: &str) -> Self {
        Self::Open(prefixes.split(',').filter(|prefix| !prefix.is_empty()).map(str::to_owned).collect())
    }

    fn has(&self, part: &PagePart) -> bool {
        match (self, &part.detail_of) {
            (Self::All, _) | (_, None) => true,
            (Self::Open(open), Some(prefix)) => open.iter().any(|one| **one == **prefix),
        }
    }
}

/// The text of the events for one reader, piece by piece.
pub(crate) struct PageEvents {
    pages: WatchStream<Arc<PageState>>,
    over: Pin<Box<WaitForCancellationFutureOwned>>,
    /// What the reader has received so far; `None` for nothing.
    place: Option<EventPlace>,
    shown: ShownParts,
    /// The text that is still to be sent of the present state.
    unsent: VecDeque<Bytes>,
    quiet: Interval,
    /// Whether a state was taken from the pages.
    has_state: bool,
    is_over: bool,
    /// The place of the stream among those that stay open; `None` for a reader of one state.
    stream: Option<OwnedSemaphorePermit>,
}

impl PageEvents {
    pub(crate) fn new(
        pages: watch::Receiver<Arc<PageState>>,
        (place, shown): (Option<EventPlace>, ShownParts),
        over: CancellationToken,
        stream: Option<OwnedSemaphorePermit>,
    ) -> Self {
        let over = Box::pin(over.cancelled_owned());
        let pages = WatchStream::new(pages);
        let quiet = time::interval(KEEP_ALIVE);
        let unsent = stream.iter().map(|_| Bytes::from_static(ALIVE)).collect();
        Self { pages, over, place, shown, unsent, quiet, has_state: false, is_over: false, stream }
    }

    /// Takes the parts of this page that the reader does not have. Whether the reader had those of
    /// another run.
    fn take(&mut self, page: &PageState) -> bool {
        let run = page.run();
        if self.place.is_some_and(|place| place.run != run) {
            return true;
        }
        let (seen, version) = (self.place.map_or(0, |place| place.version), page.version());
        let mut parts = page.since(seen).filter(|part| self.shown.has(part)).peekable();
        while let Some(part) = parts.next() {
            // the id of the last event is where the reader continues
            let end = if parts.peek().is_some() { "\n\n".into() } else { format!("\nid: {run}-{version}\n\n") };
            let begin = format!("event: snapshot\ndata: {}\ndata: ", part.id);
            self.unsent.extend([begin.into(), Bytes::from_owner(Html(part)), end.into()]);
        }
        self.place = Some(EventPlace { run, version });
        false
    }

    /// The last event of the stream.
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
        loop {
            if let Some(piece) = self.unsent.pop_front() {
                self.quiet.reset();
                return Poll::Ready(Some(Ok(piece)));
            }
            if self.stream.is_none() && self.has_state {
                return self.last(format!("{FULL}{STREAMS}\n\n"));
            }
            match Pin::new(&mut self.pages).poll_next(context) {
                // not drawn yet
                Poll::Ready(Some(page)) if page.run() == 0 => {}
                Poll::Ready(Some(page)) => {
                    if self.take(&page) {
                        return self.last("event: other\ndata: another run\n\n");
                    }
                    self.has_state = true;
                }
                Poll::Ready(None) => return Poll::Ready(None),
                Poll::Pending => break,
            }
        }
        if self.over.as_mut().poll(context).is_ready() {
            return self.last("event: end\ndata: the program ends\n\n");
        }
        self.quiet.poll_tick(context).map(|_| Some(Ok(Bytes::from_static(ALIVE))))
    }
}
