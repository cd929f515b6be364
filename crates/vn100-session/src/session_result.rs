//! The result of a session.

use std::{sync::Arc, time::Duration};

use vn100_analysis::protocol::stream::{BagReport, CsvReport, FileReport};
use vn100_analysis::{
    End, Goal, Parts, RecordingEndFacts, RecordingFacts, Shortfall, Snapshot, SourceFacts, SourceResult, UnmetGoal,
};
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
    pub unmet: Vec<UnmetGoal>,
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
    let (csv, bag) = match report {
        Some(FileReport::Csv(csv)) => (Some(csv), None),
        Some(FileReport::Bag(bag)) => (None, Some(bag)),
        None => (None, None),
    };
    let state = channels.state.borrow();
    let assessment = Arc::new(state.assessor.exact(&snapshot));
    let facts = state.facts_at(true);
    let recording = (facts.recording.clone())
        .or_else(|| bag.as_ref().and_then(|bag| recorded_times(bag, &reason)))
        .or_else(|| csv.as_ref().and_then(start_of_rows));
    drop(state);
    if let Some(cut) = recording.as_ref().and_then(|recording| recording.end.as_ref()?.warning()) {
        Arc::make_mut(&mut snapshot).warnings.push(cut);
        channels.state.send_modify(|state| state.snapshot = Arc::clone(&snapshot));
    }
    let facts = SourceFacts { csv, bag, recording, end: Some(reason.kind()), ..facts };
    SessionResult {
        shortfall,
        unmet: UnmetGoal::of(goals, &snapshot, &assessment),
        measured: SourceResult::new(facts, snapshot, assessment, Parts::All),
        end: Arc::new(reason),
        start_error: None,
        excluded,
        recording: None,
        unrecorded_bytes: 0,
        is_restored: true,
    }
}

/// Earlier times belong to a simulation, or count from the power-up of the sensor.
const YEAR_2001_NS: i64 = 978_307_200_000_000_000;

/// The time of the first row of a table, if its times count from 1970. A date may be in any time
/// zone.
fn start_of_rows(csv: &CsvReport) -> Option<RecordingFacts> {
    let is_count = |part: &str| part.rsplit_once(':').is_some_and(|(_, form)| ["s", "ms", "us", "ns"].contains(&form));
    let counts = csv.times.as_ref()?.split('+').all(is_count);
    let started_ns = csv.first_stamp_ns.filter(|first_ns| counts && *first_ns >= YEAR_2001_NS)?;
    Some(RecordingFacts { started_ns: Some(started_ns), ..RecordingFacts::default() })
}

/// The times of the recording of a bag, if they are dates and not those of a simulation; the end
/// only if the bag was read to its end.
fn recorded_times(bag: &BagReport, reason: &End) -> Option<RecordingFacts> {
    let (first_ns, last_ns) = bag.recorded_ns.filter(|(first_ns, _)| *first_ns >= YEAR_2001_NS)?;
    let end = match reason {
        End::SourceEnded => Some(RecordingEndFacts { ended_ns: Some(last_ns), complete: true, reason: None }),
        End::SourceFailed(_) => Some(RecordingEndFacts { ended_ns: Some(last_ns), complete: false, reason: None }),
        _ => None,
    };
    Some(RecordingFacts { program: None, started_ns: Some(first_ns), end })
}

/// The result for a source that could not be opened; it has no samples.
pub(crate) fn not_started(error: impl Into<StartError>, channels: &Channels) -> SessionResult {
    let snapshot: Arc<Snapshot> = Arc::clone(&channels.state.borrow().snapshot);
    let error = error.into();
    let ending = Ending { snapshot, reason: error.end(), report: None, excluded: Duration::ZERO, shortfall: None };
    SessionResult { start_error: Some(error), ..result(ending, &[], channels) }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::protocol::stream::StampSource;

    use super::*;

    #[test]
    fn a_bag_has_times_that_are_dates_and_an_end_if_read_to_its_end() {
        let bag =
            |recorded_ns| BagReport { recorded_ns, ..BagReport::of("/imu", "sensor_msgs/Imu", StampSource::Recorded) };
        let dates = Some((YEAR_2001_NS, YEAR_2001_NS + 5));
        let times = recorded_times(&bag(dates), &End::SourceEnded).unwrap();
        assert_eq!(times.started_ns, Some(YEAR_2001_NS));
        assert_eq!(times.end.map(|end| (end.ended_ns, end.complete)), Some((Some(YEAR_2001_NS + 5), true)));
        let times = recorded_times(&bag(dates), &End::SourceFailed("cut".into())).unwrap();
        assert_eq!(times.end.map(|end| (end.ended_ns, end.complete)), Some((Some(YEAR_2001_NS + 5), false)));
        let times = recorded_times(&bag(dates), &End::Stopped).unwrap();
        assert_eq!((times.started_ns, times.end.is_none()), (Some(YEAR_2001_NS), true));
        // times since the start of a simulation
        assert!(recorded_times(&bag(Some((YEAR_2001_NS - 1, YEAR_2001_NS))), &End::SourceEnded).is_none());
        assert!(recorded_times(&bag(None), &End::SourceEnded).is_none());
    }
}
