//! Notices a sensor that is heard and sends no measurement, or not the one that a stream is about any more.

use std::time::Duration;

use tokio::time::Instant;
use vn100_pipeline::Snapshot;

/// A sensor that is heard and sends no measurement in this time will send none: it is set to something else.
const NO_MEASUREMENT_AFTER: Duration = Duration::from_secs(4);

/// What came of one source, and since when only other things have come.
#[derive(Debug, Default)]
pub(crate) struct OtherOutput {
    samples: u64,
    others: u64,
    since: Option<Instant>,
}

impl OtherOutput {
    /// Whether only other things have come for so long that no measurement will. While the link is not up it waits.
    pub(crate) fn is_all(&mut self, snapshot: &Snapshot, is_up: bool) -> bool {
        let link = &snapshot.link;
        let others = link.other_messages() + link.tally.packets;
        // before the first sample a sensor that only answers counts as well: the link tells of silence, not of this
        let others = if snapshot.layout.is_none() { others + link.tally.replies } else { others };
        if !is_up || link.samples() != self.samples {
            *self = Self { samples: link.samples(), others, since: None };
            return false;
        }
        if others > self.others {
            self.since.get_or_insert_with(Instant::now);
        }
        self.since.is_some_and(|since| since.elapsed() > NO_MEASUREMENT_AFTER)
    }
}

/// What to tell of a stream whose measurements have ceased while others come; `None` where there never was one, which the warnings tell.
pub(crate) fn ceased(name: &str, snapshot: &Snapshot) -> Option<String> {
    let message = &snapshot.layout.as_ref()?.message;
    let instead =
        snapshot.link.other_message.map_or("binary packets".into(), |name| format!("other messages, such as {name}"));
    Some(format!(
        "{name}: no {message} has come for {} s but {instead}, as after a restart that lost settings that were not saved; the \
         result holds what came before. `vn100 configure {name} --set-message {message}` cures it; --save keeps it",
        NO_MEASUREMENT_AFTER.as_secs()
    ))
}

#[cfg(test)]
mod tests {
    use vn100_pipeline::{Analysis, Settings};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn only_other_lines_for_four_seconds_end_it_and_a_sample_does_not() {
        let mut snapshot = Analysis::new(Settings::default()).snapshot();
        let mut other = OtherOutput::default();
        let mut second = async |samples: u64, others: u64, is_up: bool| {
            snapshot.link.tally.samples += samples;
            snapshot.link.tally.other += others;
            tokio::time::advance(Duration::from_secs(1)).await;
            other.is_all(&snapshot, is_up)
        };
        for _ in 0..10 {
            assert!(!second(1, 40, true).await, "both come");
        }
        for _ in 0..10 {
            assert!(!second(0, 0, true).await, "nothing comes");
        }
        for _ in 0..10 {
            assert!(!second(0, 1, false).await, "the link is down");
        }
        for _ in 0..5 {
            assert!(!second(0, 40, true).await);
        }
        assert!(second(0, 40, true).await);
    }
}
