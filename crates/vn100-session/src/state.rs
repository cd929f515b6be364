//! The published state of a source.

use std::sync::Arc;

use vn100_analysis::{
    Analysis, Assessment, End, LinkFacts, LinkStatus, Parts, Playback, RecorderFacts, RecordingEndFacts,
    RecordingFacts, Settings, Snapshot, SourceFacts, SourceResult,
};
use vn100_capture::{Recorded, RecordingState};
use vn100_driver::LinkState;

use crate::assessor::Assessor;

/// One source at one moment. Cheap to clone.
#[derive(Debug, Clone)]
pub struct SourceState {
    /// The stage of the session.
    pub stage: Stage,
    /// The link of a live source; `None` for any other source.
    pub link: Option<LinkState>,
    /// The recording that is being made; `None` if there is none.
    pub recording: Option<RecordingState>,
    /// Bytes that the recording lacks because the disk was too slow.
    pub unrecorded_bytes: u64,
    /// The position of a paced replay; `None` for any other source.
    pub playback: Option<Playback>,
    /// Stored (compressed) bytes of the capture that were read; 0 for a live source.
    pub stored_bytes_read: u64,
    /// The latest numbers.
    pub snapshot: Arc<Snapshot>,
    /// The facts of the source from the beginning.
    pub(crate) source: Arc<SourceFacts>,
    pub(crate) recorded: Option<Recorded>,
    /// Makes and shares the assessment of the source.
    pub assessor: Assessor,
}

/// The stage of a session.
#[derive(Debug, Clone)]
pub enum Stage {
    /// Before the measurement: the source is opened and the sensor configured.
    Preparing,
    /// Samples are measured. A paced replay stays in this stage at its end, until it is stopped.
    Measuring,
    /// The measurement is over: the recording is ended and the settings of the sensor are restored.
    Finishing,
    /// The session is over, for this reason.
    Ended(Arc<End>),
}

impl SourceState {
    /// The state of a source before its measurement.
    pub fn new(source: SourceFacts, settings: &Settings) -> Self {
        Self {
            stage: Stage::Preparing,
            link: None,
            recording: None,
            unrecorded_bytes: 0,
            playback: None,
            stored_bytes_read: 0,
            snapshot: Arc::new(Analysis::new(settings.clone()).snapshot()),
            source: Arc::new(source),
            recorded: None,
            assessor: Assessor::new(settings.confidence),
        }
    }

    /// Name of the source: a file without its folder, a port as given, `-` for standard input.
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// The shared assessment of the snapshot, or of an earlier one with more than nineteen
    /// twentieths of its samples. The call takes milliseconds if a new assessment is made.
    pub fn assessment(&self) -> Arc<Assessment> {
        self.assessor.latest(&self.snapshot)
    }

    /// The facts of the source at this moment. Their `error` is `None`: the face puts the reason of
    /// an end into words.
    pub fn facts(&self) -> SourceFacts {
        let end = if let Stage::Ended(reason) = &self.stage { Some(reason.kind()) } else { None };
        SourceFacts { end, ..self.facts_at(end.is_some()) }
    }

    /// The result of the source as if it ended now. The call takes milliseconds if the assessment is
    /// made anew.
    pub fn result(&self, parts: Parts) -> SourceResult {
        SourceResult::new(self.facts(), Arc::clone(&self.snapshot), self.assessment(), parts)
    }

    /// The facts of the source. The recorded end of a replayed recording is read ahead, and is part
    /// of the facts only once the replay has `ended`.
    pub(crate) fn facts_at(&self, ended: bool) -> SourceFacts {
        SourceFacts {
            recording: self.recorded.as_ref().map(|recorded| recording_facts(recorded, ended)),
            link: self.link.as_ref().map(link_facts),
            recorder: self.recording.as_ref().map(|recording| RecorderFacts {
                path: recording.path.display().to_string(),
                bytes: recording.bytes,
                unrecorded_bytes: self.unrecorded_bytes,
                error: recording.error.as_ref().map(ToString::to_string),
            }),
            playback: self.playback,
            ..(*self.source).clone()
        }
    }
}

fn recording_facts(recorded: &Recorded, ended: bool) -> RecordingFacts {
    RecordingFacts {
        program: recorded.program.clone(),
        started_ns: recorded.started_ns,
        end: recorded.end.get().filter(|_| ended).map(|end| RecordingEndFacts {
            ended_ns: end.ended_ns,
            complete: end.complete,
            reason: end.reason.clone(),
        }),
    }
}

/// The state of a link as facts of its source.
pub fn link_facts(state: &LinkState) -> LinkFacts {
    let of = |status, port: &str, baud| LinkFacts { status, port: Some(port.into()), baud, ..LinkFacts::default() };
    match state {
        LinkState::Opening => LinkFacts::default(),
        LinkState::Probing { port, baud } => of(LinkStatus::Scanning, port, *baud),
        LinkState::Up(up) => of(LinkStatus::Connected, &up.port, up.baud),
        LinkState::Silent(up) => of(LinkStatus::Silent, &up.port, up.baud),
        LinkState::Down { was_up, cause, attempts, .. } => {
            let status = if *was_up { LinkStatus::Lost } else { LinkStatus::NotConnected };
            LinkFacts { status, cause: Some(cause.clone()), attempts: *attempts, ..LinkFacts::default() }
        }
        _ => LinkFacts { status: LinkStatus::Closed, ..LinkFacts::default() },
    }
}

#[cfg(test)]
mod tests {
    use std::{path::PathBuf, time::Duration};

    use vn100_analysis::Speed;
    use vn100_capture::RecordingEnd;
    use vn100_driver::Up;

    use super::*;

    fn state() -> SourceState {
        SourceState::new(SourceFacts { name: "imu".into(), ..SourceFacts::default() }, &Settings::default())
    }

    #[test]
    fn every_state_of_a_link_has_its_status() {
        let up = Up {
            port: "/dev/imu".into(),
            baud: Some(115_200),
            since_ns: 0,
            latency_timer: None,
            restarted: None,
            output_resumed: false,
        };
        let down = |was_up| LinkState::Down {
            was_up,
            cause: "unplugged".into(),
            needs_help: false,
            retry_in: Duration::from_millis(50),
            attempts: 3,
        };
        let probing = LinkState::Probing { port: "/dev/imu".into(), baud: Some(9600) };
        for (link, status, port, baud, cause) in [
            (LinkState::Opening, LinkStatus::Opening, None, None, None),
            (probing, LinkStatus::Scanning, Some("/dev/imu"), Some(9600), None),
            (LinkState::Up(up.clone()), LinkStatus::Connected, Some("/dev/imu"), Some(115_200), None),
            (LinkState::Silent(up), LinkStatus::Silent, Some("/dev/imu"), Some(115_200), None),
            (down(true), LinkStatus::Lost, None, None, Some("unplugged")),
            (down(false), LinkStatus::NotConnected, None, None, Some("unplugged")),
            (LinkState::Closed { paused_again: None }, LinkStatus::Closed, None, None, None),
        ] {
            let facts = SourceState { link: Some(link), ..state() }.facts().link.unwrap();
            let attempts = if cause.is_some() { 3 } else { 0 };
            let cause = cause.map(Into::into);
            assert_eq!(facts, LinkFacts { status, port: port.map(Into::into), baud, cause, attempts });
        }
    }

    #[test]
    fn facts_hold_recording_and_playback() {
        let error = Some(Arc::new(std::io::Error::other("no space")));
        let recording =
            RecordingState { path: PathBuf::from("a/b.mcap"), bytes: 7, low_space: None, error, ended: false };
        let playback = Playback { samples: 5, total: Some(9), speed: Speed::Max, paused: true, at_end: false };
        let state =
            SourceState { recording: Some(recording), unrecorded_bytes: 3, playback: Some(playback), ..state() };
        let facts = state.facts();
        let recorder =
            RecorderFacts { path: "a/b.mcap".into(), bytes: 7, unrecorded_bytes: 3, error: Some("no space".into()) };
        assert_eq!(facts.recorder, Some(recorder));
        assert_eq!(facts.playback, Some(playback));
        assert_eq!((facts.name.as_str(), facts.end, facts.link, facts.recording), ("imu", None, None, None));
    }

    #[test]
    fn the_end_of_a_replayed_recording_counts_only_at_the_end() {
        let recorded = Recorded { program: Some("vn100 1".into()), started_ns: Some(5), ..Recorded::default() };
        let end = RecordingEnd { ended_ns: Some(9), complete: true, reason: Some("stopped".into()) };
        recorded.end.set(end).unwrap();
        let mut state = SourceState { recorded: Some(recorded), ..state() };
        let before = state.facts().recording.unwrap();
        assert_eq!((before.program.as_deref(), before.started_ns, before.end), (Some("vn100 1"), Some(5), None));
        state.stage = Stage::Ended(Arc::new(End::SourceEnded));
        let end = state.facts().recording.unwrap().end.unwrap();
        assert_eq!((end.ended_ns, end.complete, end.reason.as_deref()), (Some(9), true, Some("stopped")));
    }
}
