//! What is broken now, and since when: the link, the sensor's output, or the recording.

use std::time::Duration;

use vn100_capture::RecordingState;
use vn100_driver::LinkState;
use vn100_report::{
    health::{FaultKind, recording_cause, silent_cause},
    numbers::plain::time,
    printable,
};

/// Something that is broken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LiveFault {
    pub(crate) kind: FaultKind,
    /// Since the view began.
    pub(crate) since: Duration,
    /// Without anything that steers a terminal.
    pub(crate) cause: String,
}

impl LiveFault {
    /// In a line: what, for how long, and why.
    pub(crate) fn title(&self, now: Duration) -> String {
        let lasting = time(now.saturating_sub(self.since).as_secs_f64());
        let attempt = match self.kind {
            FaultKind::Disconnected { attempts: attempts @ 1.. } => format!(", attempt {attempts}"),
            _ => String::new(),
        };
        format!("{} for {lasting}{attempt}: {}", self.kind.name(), self.cause)
    }
}

/// The faults of a source, followed through its states.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Faults(Vec<LiveFault>);

impl Faults {
    pub(crate) fn all(&self) -> &[LiveFault] {
        &self.0
    }

    /// Takes the present state. A fault lasts until it is over: an attempt to connect does not end
    /// it.
    pub(crate) fn watch(&mut self, link: Option<&LinkState>, recording: Option<&RecordingState>, now: Duration) {
        let link = match link {
            Some(LinkState::Down { was_up: true, cause, attempts, .. }) => {
                Some((FaultKind::Disconnected { attempts: *attempts }, printable(cause)))
            }
            Some(LinkState::Opening | LinkState::Probing { .. }) => {
                let lost = self.0.iter().find(|fault| matches!(fault.kind, FaultKind::Disconnected { .. }));
                lost.map(|fault| (fault.kind, fault.cause.clone()))
            }
            Some(LinkState::Silent(up)) => Some((FaultKind::Silent, silent_cause(&up.port))),
            _ => None,
        };
        let recording = recording
            .and_then(|recording| recording.error.as_ref())
            .map(|error| (FaultKind::RecordingFailed, recording_cause(&error.to_string())));
        let since = |kind: FaultKind| {
            let known = self.0.iter().find(|known| known.kind.name() == kind.name());
            known.map_or(now, |known| known.since)
        };
        let present = link.into_iter().chain(recording);
        self.0 = present.map(|(kind, cause)| LiveFault { kind, since: since(kind), cause }).collect();
    }
}

#[cfg(test)]
mod tests {
    use vn100_driver::Up;

    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn down(attempts: u32) -> LinkState {
        let (cause, retry_in) = ("the port is gone: unplugged".into(), SECOND);
        LinkState::Down { was_up: true, cause, needs_help: false, retry_in, attempts }
    }

    #[test]
    fn a_lost_link_lasts_through_its_attempts_until_it_is_up() {
        let mut faults = Faults::default();
        let mut title = |link: &LinkState, at: u32| {
            faults.watch(Some(link), None, at * SECOND);
            faults.all().iter().map(|fault| fault.title(at * SECOND)).collect::<Vec<_>>()
        };
        assert!(title(&LinkState::Opening, 1).is_empty());
        assert_eq!(title(&down(0), 3), ["DISCONNECTED for 0 s: the port is gone: unplugged"]);
        assert_eq!(title(&down(4), 15), ["DISCONNECTED for 12 s, attempt 4: the port is gone: unplugged"]);
        assert_eq!(title(&LinkState::Opening, 16), ["DISCONNECTED for 13 s, attempt 4: the port is gone: unplugged"]);
        let up = Up {
            port: "/dev/imu".into(),
            baud: None,
            since_ns: 0,
            latency_timer: None,
            restarted: None,
            output_resumed: false,
        };
        assert_eq!(
            title(&LinkState::Silent(up.clone()), 20),
            ["SILENT for 0 s: /dev/imu is open, but no data arrives"]
        );
        assert!(title(&LinkState::Up(up), 21).is_empty());
    }
}
