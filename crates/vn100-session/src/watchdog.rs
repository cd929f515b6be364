//! Detects a live sensor that sends no measurement, another message, or at another rate. Pure.

use std::time::Duration;

use tokio::time::Instant;
use vn100_analysis::{End, RateChange, Snapshot};

/// A sensor that sends no measurement for this time, or none at the rate of the record, was set to
/// other output. A burst of delayed bytes is shorter than this. So is the time in which the link
/// detects a paused output, including the first frame of the slowest sensor after that.
const NO_MEASUREMENT_AFTER: Duration = Duration::from_secs(5);

#[derive(Debug, Default)]
pub(crate) struct StreamWatchdog {
    samples: u64,
    others: u64,
    only_others_since: Option<Instant>,
    other_rate: Option<OtherRate>,
}

/// Another rate than that of the record, and the time when the sensor began to send at it.
#[derive(Debug)]
struct OtherRate {
    change: RateChange,
    since: Option<Instant>,
}

/// The rate of a live stream has changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RateEvent {
    /// The sensor sends at another rate than that of the record; those samples are excluded.
    Changed(RateChange),
    /// The sensor sends at the rate of the record again, in hertz.
    Restored(f64),
}

impl StreamWatchdog {
    pub(crate) const PERIOD: Duration = Duration::from_millis(500);

    /// The change of the rate since the last call; each change is reported once.
    pub(crate) fn rate_event(&mut self, snapshot: &Snapshot) -> Option<RateEvent> {
        let reported = self.other_rate.as_ref().map(|other| other.change);
        if reported == snapshot.rate_change {
            return None;
        }
        self.other_rate = snapshot.rate_change.map(|change| OtherRate { change, since: None });
        Some(snapshot.rate_change.map_or(RateEvent::Restored(snapshot.timing.rate_hz), RateEvent::Changed))
    }

    /// The reason of the end if no measurement has arrived for [`NO_MEASUREMENT_AFTER`] although the
    /// sensor sends, or none at the rate of the record. Time without a connected link does not count.
    pub(crate) fn stream_end(&mut self, snapshot: &Snapshot, is_up: bool, now: Instant) -> Option<End> {
        let is_all_other_messages = self.is_all_other_messages(snapshot, is_up, now);
        let is_at_other_rate = self.is_at_other_rate(snapshot, is_up, now);
        match (&snapshot.layout, snapshot.rate_change) {
            (None, _) if is_all_other_messages => Some(End::NoMeasurement),
            (Some(layout), change) if is_all_other_messages => Some(End::OtherMessages {
                message: layout.message.to_string(),
                other: snapshot.link.other_message,
                rate_hz: change.map(|change| change.from_hz),
                after: NO_MEASUREMENT_AFTER,
            }),
            (_, change) => change.filter(|_| is_at_other_rate).map(End::OtherRate),
        }
    }

    fn is_at_other_rate(&mut self, snapshot: &Snapshot, is_up: bool, now: Instant) -> bool {
        let Some(other) = &mut self.other_rate else { return false };
        // time without samples does not count as time at that rate
        if !is_up || snapshot.rate_change.is_none() {
            other.since = None;
            return false;
        }
        now.duration_since(*other.since.get_or_insert(now)) > NO_MEASUREMENT_AFTER
    }

    fn is_all_other_messages(&mut self, snapshot: &Snapshot, is_up: bool, now: Instant) -> bool {
        let link = &snapshot.link;
        let others = link.other_messages() + link.tally.packets;
        // before the first sample a sensor that only answers counts as well; the link reports a
        // silent sensor
        let others = if snapshot.layout.is_none() { others + link.tally.replies } else { others };
        if !is_up || link.samples() != self.samples {
            (self.samples, self.others, self.only_others_since) = (link.samples(), others, None);
            return false;
        }
        if others > self.others {
            self.only_others_since.get_or_insert(now);
        }
        self.only_others_since.is_some_and(|since| now.duration_since(since) > NO_MEASUREMENT_AFTER)
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::protocol::VNYMR;
    use vn100_analysis::{Analysis, EndKind, Settings};

    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    struct TestStream {
        snapshot: Snapshot,
        watchdog: StreamWatchdog,
        now: Instant,
    }

    impl TestStream {
        fn new() -> Self {
            let snapshot = Analysis::new(Settings::default()).snapshot();
            Self { snapshot, watchdog: StreamWatchdog::default(), now: Instant::now() }
        }

        /// A second with these numbers of samples and other messages.
        fn second(&mut self, samples: u64, others: u64, is_up: bool) -> Option<EndKind> {
            self.snapshot.link.tally.samples += samples;
            self.snapshot.link.tally.other += others;
            self.now += SECOND;
            self.watchdog.stream_end(&self.snapshot, is_up, self.now).map(|reason| reason.kind())
        }

        fn second_at(&mut self, change: Option<RateChange>, is_up: bool) -> (Option<RateEvent>, Option<EndKind>) {
            self.snapshot.rate_change = change;
            let event = self.watchdog.rate_event(&self.snapshot);
            (event, self.second(1, 0, is_up))
        }
    }

    #[test]
    fn another_rate_is_reported_once_and_ends_the_stream_after_five_seconds() {
        let mut stream = TestStream::new();
        let change = RateChange { after_samples: 400, from_hz: 200.0, to_hz: 40.0 };
        let changed = Some(RateEvent::Changed(change));
        assert_eq!(stream.second_at(None, true), (None, None));
        assert_eq!(stream.second_at(Some(change), true), (changed, None));
        assert_eq!(stream.second_at(Some(change), true), (None, None));
        // as after a burst of delayed bytes
        assert_eq!(stream.second_at(None, true), (Some(RateEvent::Restored(40.0)), None));
        assert_eq!(stream.second_at(None, true), (None, None));
        assert_eq!(stream.second_at(Some(change), true), (changed, None));
        for _ in 0..10 {
            assert_eq!(stream.second_at(Some(change), false), (None, None), "the link is down");
        }
        for _ in 0..6 {
            assert_eq!(stream.second_at(Some(change), true), (None, None));
        }
        assert_eq!(stream.second_at(Some(change), true), (None, Some(EndKind::OtherRate)));
    }

    #[test]
    fn a_second_change_of_the_rate_restarts_its_time() {
        let mut stream = TestStream::new();
        let first = RateChange { after_samples: 400, from_hz: 200.0, to_hz: 40.0 };
        for _ in 0..4 {
            stream.second_at(Some(first), true);
        }
        let second = RateChange { to_hz: 50.0, ..first };
        assert_eq!(stream.second_at(Some(second), true), (Some(RateEvent::Changed(second)), None));
        for _ in 0..5 {
            assert_eq!(stream.second_at(Some(second), true), (None, None));
        }
        assert_eq!(stream.second_at(Some(second), true), (None, Some(EndKind::OtherRate)));
    }

    #[test]
    fn only_other_messages_for_five_seconds_end_the_stream_and_a_sample_does_not() {
        let mut stream = TestStream::new();
        for _ in 0..10 {
            assert_eq!(stream.second(1, 40, true), None, "both come");
        }
        for _ in 0..10 {
            assert_eq!(stream.second(0, 0, true), None, "nothing comes");
        }
        for _ in 0..10 {
            assert_eq!(stream.second(0, 1, false), None, "the link is down");
        }
        for _ in 0..6 {
            assert_eq!(stream.second(0, 40, true), None);
        }
        stream.snapshot.rate_change = Some(RateChange { after_samples: 400, from_hz: 200.0, to_hz: 40.0 });
        stream.snapshot.layout = Some(VNYMR.clone().into());
        let reason = stream.watchdog.stream_end(&stream.snapshot, true, stream.now + SECOND).unwrap();
        let End::OtherMessages { message, other: None, rate_hz: Some(200.0), .. } = reason else {
            panic!("{reason:?}")
        };
        assert_eq!(message, "VNYMR");
    }

    #[test]
    fn packets_and_before_the_first_sample_replies_are_other_messages() {
        for (packets, replies, is_measured, ends) in
            [(1, 0, true, true), (0, 1, false, true), (0, 1, true, false), (0, 0, false, false)]
        {
            let mut stream = TestStream::new();
            stream.snapshot.layout = is_measured.then(|| VNYMR.clone().into());
            for _ in 0..6 {
                stream.snapshot.link.tally.packets += packets;
                stream.snapshot.link.tally.replies += replies;
                assert_eq!(stream.second(0, 0, true), None);
            }
            let end = stream.second(0, 0, true);
            let kind = if is_measured { EndKind::OtherMessage } else { EndKind::NoMeasurement };
            assert_eq!(end, ends.then_some(kind), "{packets} {replies} {is_measured}");
        }
    }
}
