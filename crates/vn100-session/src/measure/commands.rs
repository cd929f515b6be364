//! The effects of the user's commands on a measurement in progress.

use std::time::Duration;

use tokio::time::Instant;
use vn100_analysis::GoalCheck;

use super::Measuring;
use crate::{
    channels::Channels,
    command::{Command, CommandRefusal},
    session_event::SessionEvent,
};

impl Measuring {
    pub(super) fn handle(&mut self, command: Command, channels: &Channels) {
        let is_over = self.end.is_some();
        match (command, &mut self.pace) {
            (Command::Stop, _) => channels.stop.cancel(),
            (Command::Mark(text), _) => {
                if !self.link.as_ref().is_some_and(|link| link.mark(text)) {
                    channels.report(SessionEvent::Refused(CommandRefusal::NoMark));
                }
                return;
            }
            (Command::EndWarmUp | Command::StartOver, _) if is_over => {
                channels.report(SessionEvent::Refused(CommandRefusal::Over));
            }
            (Command::EndWarmUp, _) => {
                let warm_up = self.analysis.end_warm_up();
                self.warm_up = warm_up;
                self.begin_anew();
                channels.report(SessionEvent::WarmUpEnded { warm_up, excluded: self.excluded() });
            }
            (Command::StartOver, _) => {
                let after = self.analysis.start_over();
                (self.before, self.warm_up) = (self.before.saturating_add(after), Duration::ZERO);
                self.begin_anew();
                channels.report(SessionEvent::StartedOver { after });
            }
            (_, None) => {}
            (Command::TogglePause, Some(_)) if is_over => {
                channels.report(SessionEvent::Refused(CommandRefusal::AtEnd));
            }
            (command, Some(pace)) => pace.handle(command, Instant::now()),
        }
        self.show_playback(channels);
    }

    /// Excluded data time from the beginning of the record: a measurement with this skip gives the
    /// same result.
    pub(super) fn excluded(&self) -> Duration {
        self.before.saturating_add(self.warm_up)
    }

    /// Restarts the record, the count of seconds and the check of the goals.
    fn begin_anew(&mut self) {
        (self.seconds, self.goals) = (self.analysis.seconds(), GoalCheck::default());
        self.has_changed = true;
    }
}
