//! Notices a sensor that is heard and sends no measurement, or not the one that a stream is about
//! any more, or that at another rate.

use std::time::Duration;

use tokio::time::Instant;
use vn100_analysis::{RateChange, Snapshot};

/// A sensor that is heard and sends no measurement in this time, or none at its rate, will send
/// none: it is set to something else. Bytes that were held back come at another rate for less.
const NO_MEASUREMENT_AFTER: Duration = Duration::from_secs(4);

/// What came of one source, and since when only other things have come.
#[derive(Debug, Default)]
pub(crate) struct OtherOutput {
    samples: u64,
    others: u64,
    since: Option<Instant>,
    other_rate: Option<OtherRate>,
}

/// A rate that is not that of the record, and since when the sensor has sent at it.
#[derive(Debug)]
struct OtherRate {
    change: RateChange,
    since: Option<Instant>,
}

impl OtherOutput {
    /// Whether what comes has been left out for so long, because of its rate, that all will be.
    /// While the link is not up it waits.
    pub(crate) fn is_at_another_rate(&mut self, snapshot: &Snapshot, is_up: bool) -> bool {
        let Some(other) = &mut self.other_rate else { return false };
        // time in which nothing comes is no time at that rate
        if !is_up || snapshot.rate_change.is_none() {
            other.since = None;
            return false;
        }
        other.since.get_or_insert_with(Instant::now).elapsed() > NO_MEASUREMENT_AFTER
    }

    /// That the rate has changed, or is again what it was: in words, when that is new.
    pub(crate) fn change_of_rate(&mut self, snapshot: &Snapshot) -> Option<String> {
        let told = self.other_rate.as_ref().map(|other| other.change);
        self.other_rate = match (snapshot.rate_change, self.other_rate.take()) {
            (Some(change), Some(other)) if other.change == change => Some(other),
            (change, _) => change.map(|change| OtherRate { change, since: None }),
        };
        match (told, snapshot.rate_change) {
            (told, Some(change)) if told != Some(change) => Some(format!(
                "the rate changed from {} to {} Hz: what comes so is left out",
                change.from_hz, change.to_hz
            )),
            (Some(_), None) => Some(format!("lines come at {} Hz again", snapshot.timing.rate_hz)),
            _ => None,
        }
    }

    /// Whether only other things have come for so long that no measurement will. While the link is
    /// not up it waits.
    pub(crate) fn is_all(&mut self, snapshot: &Snapshot, is_up: bool) -> bool {
        let link = &snapshot.link;
        let others = link.other_messages() + link.tally.packets;
        // before the first sample a sensor that only answers counts as well: the link tells of silence, not of this
        let others = if snapshot.layout.is_none() { others + link.tally.replies } else { others };
        if !is_up || link.samples() != self.samples {
            (self.samples, self.others, self.since) = (link.samples(), others, None);
            return false;
        }
        if others > self.others {
            self.since.get_or_insert_with(Instant::now);
        }
        self.since.is_some_and(|since| since.elapsed() > NO_MEASUREMENT_AFTER)
    }
}

/// Why a stream that still brings lines is over.
#[derive(Debug)]
pub(crate) struct Ceased {
    /// In a word, for a recording.
    pub(crate) reason: &'static str,
    /// With what cures it.
    pub(crate) told: String,
}

/// Of a stream whose measurements have ceased while others come; `None` where there never was one,
/// which the warnings tell.
pub(crate) fn ceased(name: &str, snapshot: &Snapshot) -> Option<Ceased> {
    let message = &snapshot.layout.as_ref()?.message;
    let instead =
        snapshot.link.other_message.map_or("binary packets".into(), |name| format!("other messages, such as {name}"));
    let rate = snapshot.rate_change.map_or(String::new(), |change| format!(" --set-rate {}", change.from_hz));
    let told = format!(
        "{name}: no {message} has come for {} s but {instead}{LOST}`vn100 configure {name} --set-message {message}{rate}` cures it; --save \
         keeps it",
        NO_MEASUREMENT_AFTER.as_secs()
    );
    Some(Ceased { reason: "the sensor sends another message", told })
}

/// Of a stream that ends behind a change of its rate; `None` where there was none.
pub(crate) fn at_another_rate(name: &str, snapshot: &Snapshot) -> Option<Ceased> {
    let RateChange { from_hz, to_hz, .. } = snapshot.rate_change?;
    let told = format!(
        "{name}: lines come at {to_hz} Hz, no longer at {from_hz}{LOST}`vn100 configure {name} --set-rate {from_hz}` cures it; --save \
         keeps it"
    );
    Some(Ceased { reason: "the sensor sends at another rate", told })
}

const LOST: &str = ", as after a restart that lost settings that were not saved; the result holds what came before. ";

#[cfg(test)]
mod tests {
    use vn100_analysis::{Analysis, Settings};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn another_rate_is_told_when_it_is_found_and_ends_it_after_four_seconds() {
        let mut snapshot = Analysis::new(Settings::default()).snapshot();
        let mut other = OtherOutput::default();
        let mut second = async |change: Option<RateChange>, is_up: bool| {
            snapshot.rate_change = change;
            tokio::time::advance(Duration::from_secs(1)).await;
            (other.change_of_rate(&snapshot), other.is_at_another_rate(&snapshot, is_up))
        };
        let change = Some(RateChange { after_samples: 400, from_hz: 200.0, to_hz: 40.0 });
        assert_eq!(second(None, true).await, (None, false));
        let told = Some("the rate changed from 200 to 40 Hz: what comes so is left out".to_owned());
        assert_eq!(second(change, true).await, (told.clone(), false));
        assert_eq!(second(change, true).await, (None, false), "told once");
        // as behind a burst of what was held back
        assert_eq!(second(None, true).await, (Some("lines come at 40 Hz again".into()), false));
        assert_eq!(second(change, true).await, (told, false));
        for _ in 0..10 {
            assert_eq!(second(change, false).await, (None, false), "the link is down");
        }
        for _ in 0..5 {
            assert_eq!(second(change, true).await, (None, false));
        }
        assert_eq!(second(change, true).await, (None, true));
    }

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
