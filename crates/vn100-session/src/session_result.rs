//! The result of a session.

use std::{sync::Arc, time::Duration};

use vn100_analysis::{End, Goal, Parts, Shortfall, Snapshot, SourceResult};
use vn100_capture::RecordingState;

use crate::{channels::Channels, measure::Ending, start_error::StartError};

/// The result of a session, and how the session ended.
#[derive(Debug)]
pub struct SessionResult {
    /// The result of the source; one without samples if nothing could be measured. Its error is
    /// `None`, for the face to put into words.
    pub measured: SourceResult,
    /// Why the session ended.
    pub end: Arc<End>,
    /// The error of a source that could not be opened; `None` for any other end.
    pub start_error: Option<StartError>,
    /// The data time that is missing from what was asked for; `None` if none is missing, or no
    /// duration was asked for.
    pub shortfall: Option<Shortfall>,
    /// The goals that were not met.
    pub unmet: Vec<Goal>,
    /// Data time at the beginning that was excluded by command; zero for none.
    pub excluded: Duration,
    /// The recording made during the measurement; `None` if none was asked for or begun.
    pub recording: Option<RecordingState>,
    /// Bytes that the recording lacks because the disk was too slow.
    pub unrecorded_bytes: u64,
    /// Whether the sensor is set as before, as far as the session changed its settings.
    pub is_restored: bool,
}

pub(crate) fn result(ending: Ending, goals: &[Goal], channels: &Channels) -> SessionResult {
    let Ending { mut snapshot, reason, report, excluded, shortfall } = ending;
    let state = channels.state.borrow();
    let assessment = Arc::new(state.assessor.exact(&snapshot));
    let facts = state.facts_at(true).at_end(report.map(Arc::unwrap_or_clone), reason.kind());
    drop(state);
    if let Some(cut) = facts.recording.as_ref().and_then(|recording| recording.end.as_ref()?.warning()) {
        Arc::make_mut(&mut snapshot).warnings.push(cut);
        channels.state.send_modify(|state| state.snapshot = Arc::clone(&snapshot));
    }
    SessionResult {
        shortfall,
        unmet: Goal::unmet(goals, &snapshot, &assessment),
        measured: SourceResult::new(facts, snapshot, assessment, Parts::All),
        end: Arc::new(reason),
        start_error: None,
        excluded,
        recording: None,
        unrecorded_bytes: 0,
        is_restored: true,
    }
}

/// The result for a source that could not be opened; it has no samples.
pub(crate) fn not_started(error: impl Into<StartError>, channels: &Channels) -> SessionResult {
    let snapshot: Arc<Snapshot> = Arc::clone(&channels.state.borrow().snapshot);
    let error = error.into();
    let ending = Ending { snapshot, reason: error.end(), report: None, excluded: Duration::ZERO, shortfall: None };
    SessionResult { start_error: Some(error), ..result(ending, &[], channels) }
}
