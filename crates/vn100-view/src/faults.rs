//! What is broken now, and since when: the link, the sensor's output, or the recording.

use std::time::Duration;

use vn100_analysis::{LinkStatus, SourceFacts};
use vn100_report::{health::FaultKind, numbers::plain::time, printable};

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
    pub(crate) fn watch(&mut self, facts: &SourceFacts, now: Duration) {
        let connects =
            facts.link.as_ref().is_some_and(|link| matches!(link.status, LinkStatus::Opening | LinkStatus::Scanning));
        let is_lost = |fault: &&LiveFault| matches!(fault.kind, FaultKind::Disconnected { .. });
        let lost = self.0.iter().find(is_lost).filter(|_| connects).map(|fault| (fault.kind, fault.cause.clone()));
        let since = |kind: FaultKind| {
            let known = self.0.iter().find(|known| known.kind.name() == kind.name());
            known.map_or(now, |known| known.since)
        };
        let present = lost.into_iter().chain(FaultKind::of(facts));
        self.0 =
            present.map(|(kind, cause)| LiveFault { kind, since: since(kind), cause: printable(&cause) }).collect();
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::LinkFacts;

    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn link(status: LinkStatus, attempts: u32) -> SourceFacts {
        let cause = (status == LinkStatus::Lost).then(|| "the port is gone: unplugged".into());
        let link = LinkFacts { status, port: Some("/dev/imu".into()), attempts, cause, ..LinkFacts::default() };
        SourceFacts { link: Some(link), ..SourceFacts::default() }
    }

    #[test]
    fn a_lost_link_lasts_through_its_attempts_until_it_is_up() {
        let mut faults = Faults::default();
        let mut title = |status, attempts, at: u32| {
            faults.watch(&link(status, attempts), at * SECOND);
            faults.all().iter().map(|fault| fault.title(at * SECOND)).collect::<Vec<_>>()
        };
        let (opening, lost, silent, up) =
            (LinkStatus::Opening, LinkStatus::Lost, LinkStatus::Silent, LinkStatus::Connected);
        assert!(title(opening, 0, 1).is_empty());
        assert_eq!(title(lost, 0, 3), ["DISCONNECTED for 0 s: the port is gone: unplugged"]);
        assert_eq!(title(lost, 4, 15), ["DISCONNECTED for 12 s, attempt 4: the port is gone: unplugged"]);
        assert_eq!(title(opening, 4, 16), ["DISCONNECTED for 13 s, attempt 4: the port is gone: unplugged"]);
        assert_eq!(title(silent, 0, 20), ["SILENT for 0 s: /dev/imu is open, but no data arrives"]);
        assert!(title(up, 0, 21).is_empty());
    }
}
