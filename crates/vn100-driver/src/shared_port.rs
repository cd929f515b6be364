//! The search for another program on the port: the system locks it only for programs that ask for a
//! lock, and others read a part of the bytes unseen.

use std::{future::pending, path::Path, time::Duration};

use tokio::{task::JoinHandle, time::Instant};
use vn100_capture::Event;
use vn100_protocol::stream::LinkEventKind;

use crate::connect::other_program_on;

/// The shortest interval between two searches, as each takes milliseconds. A search is repeated
/// when frames are damaged.
const PERIOD: Duration = Duration::from_secs(60);

/// Searches when the link is connected, and when frames are damaged.
#[derive(Debug, Default)]
pub(crate) struct SharedPort {
    search: Option<JoinHandle<Option<String>>>,
    searched: Option<Instant>,
    /// Frames rejected until then.
    rejected: u64,
    /// The program that was reported last.
    reported: Option<String>,
}

impl SharedPort {
    /// Begins a search, where the event of the stream is a reason for one.
    pub(crate) fn handle_event(&mut self, event: &Event, device_file: Option<&Path>) {
        let is_due = match event {
            Event::Link(event) => matches!(event.kind, LinkEventKind::Up { .. }),
            Event::Batch(batch) => {
                let rejected = batch.link.tally.rejected.total();
                let is_due = rejected > self.rejected && self.searched.is_none_or(|at| at.elapsed() >= PERIOD);
                self.rejected = if is_due { rejected } else { self.rejected };
                is_due
            }
            Event::ReadAgain | Event::End(_) => false,
        };
        if let Some(file) = device_file.filter(|_| is_due && self.search.is_none()) {
            let file = file.to_owned();
            self.searched = Some(Instant::now());
            self.search = Some(tokio::task::spawn_blocking(move || other_program_on(&file)));
        }
    }

    /// The next program to report, each once; waits for ever while there is no search.
    pub(crate) async fn found(&mut self) -> Option<String> {
        let found = match &mut self.search {
            Some(search) => search.await.ok().flatten(),
            None => return pending().await,
        };
        self.search = None;
        let is_new = found.is_some() && found != self.reported;
        self.reported = found.clone().or(self.reported.take());
        found.filter(|_| is_new)
    }
}
