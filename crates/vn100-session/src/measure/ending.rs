//! The end of a measurement: limits of time, the watchdog of its stream, the reason in its result.

use std::{sync::Arc, time::Duration};

use tokio::time::Instant;
use vn100_analysis::{End, Shortfall, Snapshot, protocol::stream::FileReport};
use vn100_driver::LinkState;

use super::Measuring;
use crate::{channels::Channels, session_event::SessionEvent};

pub(crate) struct Ending {
    pub(crate) snapshot: Arc<Snapshot>,
    pub(crate) reason: End,
    pub(crate) report: Option<Arc<FileReport>>,
    pub(crate) excluded: Duration,
    pub(crate) shortfall: Option<Shortfall>,
}

impl Measuring {
    pub(super) fn end_by_wall_time(&mut self, channels: &Channels) {
        self.end_stream(End::WallTime(self.deadlines.limits.wall.unwrap_or_default()), channels);
    }

    pub(super) fn give_up(&mut self, channels: &Channels) {
        let after = self.deadlines.limits.give_up.unwrap_or_default();
        let cause = match &channels.state.borrow().link {
            Some(LinkState::Down { cause, .. }) => Some(cause.clone()),
            _ => None,
        };
        self.end_stream(End::GaveUp { after, cause }, channels);
    }

    fn end_stream(&mut self, reason: End, channels: &Channels) {
        self.stream_ended = Some(reason);
        channels.stop.cancel();
    }

    pub(super) fn watch(&mut self, channels: &Channels) {
        let Some(watchdog) = &mut self.watchdog else { return };
        let state = channels.state.borrow().clone();
        let is_up = matches!(state.link, None | Some(LinkState::Up(_) | LinkState::Silent(_)));
        if let Some(sent) = &state.snapshot.layout
            && let Some(Err(other)) = self.recorded.take().map(|recorded| recorded.check(sent))
        {
            channels.report(SessionEvent::OtherMessage(other));
        }
        if let Some(event) = watchdog.rate_event(&state.snapshot) {
            channels.report(SessionEvent::Rate(event));
        }
        let ended = watchdog.stream_end(&state.snapshot, is_up, Instant::now());
        if let Some(ended) = ended.filter(|_| !channels.stop.is_cancelled()) {
            self.end_stream(ended, channels);
        }
    }

    /// A paced replay has reached its end, and stays there until it is stopped.
    pub(super) fn stand_at_end(&mut self, channels: &Channels) {
        if let Some(pace) = &mut self.pace {
            pace.playback.at_end = true;
        }
        self.analysis.finish();
        self.publish(channels);
    }

    pub(super) async fn finish(mut self, channels: &Channels) -> Ending {
        // if the rate becomes known only now, the pending rows complete seconds as well
        while self.analysis.finish_to_second() {
            self.send_second(channels).await;
        }
        self.tap(channels).await;
        let snapshot = Arc::new(self.analysis.final_snapshot());
        self.show(Arc::clone(&snapshot), channels);
        let (reason, report) = (self.end.take().unwrap_or(End::SourceEnded), self.report.take());
        let is_short = self.watchdog.is_some() && self.analysis.settings().duration.is_some();
        let is_reached = matches!(reason, End::DurationReached | End::GoalsDecided);
        let by_clock = |ended: &End| matches!(ended, End::GaveUp { .. } | End::WallTime(_));
        // samples before the link was closed may have completed the measurement
        let stream_ended = self.stream_ended.take().filter(|ended| !(is_reached && by_clock(ended)));
        let reason = match (reason, stream_ended, snapshot.rate_change) {
            (End::SourceFailed(error), ..) => End::SourceFailed(error),
            (_, Some(ended), _) => ended,
            (End::SourceEnded | End::DurationReached, None, Some(change)) if is_short => End::OtherRate(change),
            (reason, ..) => reason,
        };
        let has_all = self.analysis.is_complete() || matches!(reason, End::DurationReached | End::GoalsDecided);
        let wanted = self.analysis.settings().duration.filter(|_| !has_all);
        let shortfall = wanted.map(|wanted| Shortfall { wanted, measured: self.analysis.data_time() });
        Ending { snapshot, reason, report, excluded: self.excluded(), shortfall }
    }
}
