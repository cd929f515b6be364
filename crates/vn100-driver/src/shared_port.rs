//! The search for another program on the port. The system refuses the port only to programs that
//! request a lock; others read a part of the bytes unnoticed.

use std::{collections::BTreeSet, future::pending, path::Path, time::Duration};

use tokio::{task::JoinHandle, time::Instant};
use vn100_protocol::stream::Batch;

use crate::connect::other_program_on;

/// The shortest interval between two searches, each of which takes milliseconds. A search is
/// repeated when frames are damaged.
const PERIOD: Duration = Duration::from_secs(60);

/// Searches when the port is opened, and when frames are damaged.
#[derive(Debug, Default)]
pub(crate) struct SharedPort {
    search: Option<JoinHandle<Option<String>>>,
    searched: Option<Instant>,
    /// Rejected lines, and bytes without a frame (such as damaged packets), at the last search.
    damage: u64,
    reported: BTreeSet<String>,
}

impl SharedPort {
    /// Searches again if this batch of the stream shows damaged frames.
    pub(crate) fn handle_batch(&mut self, batch: &Batch, device_file: Option<&Path>) {
        let damage = batch.link.tally.rejected.total() + batch.link.tally.skipped_bytes;
        if damage > self.damage && self.searched.is_none_or(|at| at.elapsed() >= PERIOD) {
            self.damage = damage;
            self.search(device_file);
        }
    }

    pub(crate) fn search(&mut self, device_file: Option<&Path>) {
        if let Some(file) = device_file.filter(|_| self.search.is_none()) {
            let file = file.to_owned();
            self.searched = Some(Instant::now());
            self.search = Some(tokio::task::spawn_blocking(move || other_program_on(&file)));
        }
    }

    /// The next program to report, each once; waits forever while no search is running.
    pub(crate) async fn found(&mut self) -> Option<String> {
        let found = match &mut self.search {
            Some(search) => search.await.ok().flatten(),
            None => return pending().await,
        };
        self.search = None;
        found.filter(|program| self.reported.insert(program.clone()))
    }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::{
        RejectedCounts, Tally,
        stream::{Batch, StreamCounts},
    };

    use super::*;

    /// Whether a search begins after this many rejected lines.
    async fn searches(port: &mut SharedPort, rejected: u64) -> bool {
        searches_after(port, rejected, 0).await
    }

    /// Whether a search begins after this many rejected lines and bytes without a frame.
    async fn searches_after(port: &mut SharedPort, rejected: u64, skipped_bytes: u64) -> bool {
        let rejected = RejectedCounts { checksum: rejected, ..RejectedCounts::default() };
        let tally = Tally { rejected, skipped_bytes, ..Tally::default() };
        let link = StreamCounts { tally, ..StreamCounts::default() };
        port.handle_batch(&Batch { link, ..Batch::default() }, Some(Path::new("/nonexistent/port")));
        let begins = port.search.is_some();
        if begins {
            assert_eq!(port.found().await, None, "another program has what does not exist");
        }
        begins
    }

    #[tokio::test(start_paused = true)]
    async fn newly_damaged_frames_start_one_search_per_minute() {
        let mut port = SharedPort::default();
        assert!(!searches(&mut port, 0).await);
        assert!(searches(&mut port, 2).await);
        tokio::time::advance(PERIOD / 2).await;
        assert!(!searches(&mut port, 5).await, "it is soon after the last search");
        tokio::time::advance(PERIOD).await;
        assert!(searches(&mut port, 5).await);
        tokio::time::advance(2 * PERIOD).await;
        assert!(!searches(&mut port, 5).await, "none is damaged since");
        assert!(searches_after(&mut port, 5, 44).await, "a packet is damaged");
    }
}
