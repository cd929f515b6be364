//! What the commands of the user do to a measurement under way.

use std::time::Duration;

use tokio::time::Instant;

use super::{MeasurementEnd, Measuring};
use crate::{
    assessor::GoalCheck,
    channels::Channels,
    command::{Command, CommandRefusal},
    excluded::Excluded,
    pace::PaceStart,
    session_event::SessionEvent,
};

impl Measuring {
    /// Executes a command. Returns the replay that takes the place of this one, if the command
    /// needs one.
    pub(super) fn handle(&mut self, command: Command, channels: &Channels) -> Option<MeasurementEnd> {
        let is_over = self.end.is_some();
        let now = Instant::now();
        match (command, &mut self.pace) {
            (Command::Stop, _) => channels.stop.cancel(),
            (Command::Mark(text), _) => {
                if !self.link.as_ref().is_some_and(|link| link.mark(text)) {
                    channels.report(SessionEvent::Refused(CommandRefusal::NoMark));
                }
                return None;
            }
            (Command::EndWarmUp | Command::StartOver, _) if is_over => {
                channels.report(SessionEvent::Refused(CommandRefusal::Over));
            }
            (Command::EndWarmUp, _) => {
                let warm_up = self.analysis.end_warm_up();
                self.excluded.end_warm_up(warm_up);
                self.begin_anew();
                channels.report(SessionEvent::WarmUpEnded { warm_up, excluded: self.excluded.total() });
            }
            (Command::StartOver, _) => {
                let after = self.analysis.start_over();
                if self.excluded.start_over(after) {
                    self.excluded.end_warm_up(self.analysis.end_warm_up());
                }
                self.begin_anew();
                channels.report(SessionEvent::StartedOver { after });
            }
            (_, None) => {}
            (Command::TogglePause | Command::Step, Some(_)) if is_over => {
                channels.report(SessionEvent::Refused(CommandRefusal::AtEnd));
            }
            (command @ (Command::GoTo(_) | Command::Seek(_)), Some(pace)) => {
                let Some(total) = channels.state.borrow().playback.and_then(|playback| playback.total) else {
                    channels.report(SessionEvent::Refused(CommandRefusal::NotCounted));
                    return None;
                };
                let part = match command {
                    Command::Seek(part) => part + pace.destination() as f64 / total.max(1) as f64,
                    Command::GoTo(part) => part,
                    _ => return None,
                };
                let place = (part.clamp(0.0, 1.0) * total as f64).round() as u64;
                if place < pace.playback(None).samples {
                    let start = pace.back_to(place);
                    return Some(self.replay_again(start, channels));
                }
                if !is_over {
                    pace.run_to(place, now);
                }
            }
            (Command::Select(from, to), Some(pace)) => {
                let Some(total) = channels.state.borrow().playback.and_then(|playback| playback.total) else {
                    channels.report(SessionEvent::Refused(CommandRefusal::NotCounted));
                    return None;
                };
                let place = |part: f64| (part.clamp(0.0, 1.0) * total as f64).round();
                let begin_s = place(from.min(to)) / self.rate_hz;
                let begin = Duration::try_from_secs_f64(begin_s).unwrap_or(Duration::MAX);
                let excluded = if begin.is_zero() { Excluded::default() } else { Excluded::until(begin) };
                return Some(MeasurementEnd::Again { start: pace.part_to(place(from.max(to)) as u64), excluded });
            }
            (command, Some(pace)) => pace.handle(command, now),
        }
        self.show_playback(channels);
        None
    }

    /// The record begins anew, and with it the count of seconds and the check of the goals.
    fn begin_anew(&mut self) {
        (self.seconds, self.goals) = (self.analysis.seconds(), GoalCheck::default());
        self.has_changed = true;
    }

    fn replay_again(&self, start: PaceStart, channels: &Channels) -> MeasurementEnd {
        let place_s = start.run_to as f64 / channels.state.borrow().snapshot.timing.rate_hz;
        let place = Duration::try_from_secs_f64(place_s).unwrap_or(Duration::MAX);
        let excluded = self.excluded.carried_to(place);
        match (self.excluded.total(), excluded.total()) {
            (Duration::ZERO, _) => {}
            (until, Duration::ZERO) => channels.report(SessionEvent::NoLongerExcluded { until }),
            (_, first) => channels.report(SessionEvent::StillExcluded { first }),
        }
        MeasurementEnd::Again { start, excluded }
    }
}
