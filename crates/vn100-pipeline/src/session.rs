//! A session, as its faces see it.

use std::sync::Arc;

use tokio::{
    sync::{mpsc, watch},
    task::JoinHandle,
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::stream::{BagReport, CsvReport, FileReport, ReadOptions};
use vn100_analysis::{Goal, RecordingEndFacts, RecordingFacts, Settings, SourceFacts, UnmetGoal};
use vn100_capture::Event;

use crate::{
    channels::{Channels, Face, open},
    command::Command,
    end_reason::{EndReason, SessionResult, StartError},
    excluded::Excluded,
    live::{LiveSpec, run_live},
    measure::{Ending, Measurement, MeasurementEnd, Origin, measure},
    replay::{ReplaySpec, run_replay},
    session_event::SessionEvent,
    state::{SourceState, Stage},
};

/// A session under way, in a task of its own. Dropping the handle does not end it: cancel its token
/// or send [`Command::Stop`].
#[derive(Debug)]
pub struct Session {
    /// The state, now and whenever it changes.
    pub state: watch::Receiver<SourceState>,
    /// Takes commands.
    pub commands: mpsc::Sender<Command>,
    /// Events besides the measurement.
    pub events: mpsc::Receiver<SessionEvent>,
    /// The state at every second of data time, if asked for. Until they are taken, a capture or a
    /// stream waits; a link cannot wait, and the states of some seconds are then dropped.
    pub seconds: mpsc::Receiver<SourceState>,
    /// The result. It fails only where the task panics, or the runtime ends before.
    pub result: JoinHandle<SessionResult>,
}

impl Session {
    /// Measures a live sensor until it is stopped, its goals are decided or its stream ends: begins
    /// the recording, configures the sensor, measures, ends the recording, restores the settings.
    ///
    /// # Panics
    /// Outside a tokio runtime with time enabled.
    #[must_use]
    pub fn live(spec: LiveSpec) -> Self {
        let source = SourceFacts {
            name: spec.name.clone(),
            kind: spec.kind,
            meta: (!spec.conditions.is_empty()).then(|| spec.conditions.clone()),
            ..SourceFacts::default()
        };
        let state = SourceState::new(source, &spec.settings);
        let (mut channels, face) = open(state, spec.observer(), spec.stop.child_token(), spec.each_second);
        channels.samples.clone_from(&spec.samples);
        face.run(run_live(spec, channels))
    }

    /// Measures a capture to its end, or until it is stopped; with a speed, at the pace of the
    /// sensor and until it is stopped.
    ///
    /// # Panics
    /// Outside a tokio runtime with time enabled.
    #[must_use]
    pub fn replay(spec: ReplaySpec) -> Self {
        let source = SourceFacts { name: spec.name(), ..SourceFacts::default() };
        let state = SourceState::new(source, &spec.settings);
        let (mut channels, face) = open(state, spec.observer.clone(), spec.stop.child_token(), spec.each_second);
        channels.samples.clone_from(&spec.samples);
        face.run(run_replay(spec, channels))
    }

    /// Measures the events of any source, until they end or the session is stopped.
    ///
    /// # Panics
    /// Outside a tokio runtime with time enabled.
    #[must_use]
    pub fn of_events(source: SourceFacts, events: mpsc::Receiver<Event>, settings: Settings) -> Self {
        let state = SourceState::new(source, &settings);
        let (channels, face) = open(state, None, CancellationToken::new(), false);
        face.run(run_events(events, settings, channels))
    }
}

async fn run_events(events: mpsc::Receiver<Event>, settings: Settings, mut channels: Channels) -> SessionResult {
    let (goals, excluded) = (settings.until.clone(), Excluded::default());
    let measurement = Measurement { events, settings, excluded, origin: Origin::Events, ends_as_recorded: false };
    match measure(measurement, &mut channels).await {
        MeasurementEnd::Ended(ending) => channels.end(result(ending, &goals, &channels)),
        // only a paced replay seeks back
        MeasurementEnd::Again { .. } => channels.end(not_started(StartError::Stopped, &channels)),
    }
}

impl Face {
    fn run(self, session: impl Future<Output = SessionResult> + Send + 'static) -> Session {
        let Self { state, commands, events, seconds } = self;
        Session { state, commands, events, seconds, result: tokio::spawn(session) }
    }
}

impl Channels {
    pub(crate) fn end(&self, result: SessionResult) -> SessionResult {
        self.stage(Stage::Ended(Arc::clone(&result.end)));
        result
    }
}

pub(crate) fn result(ending: Ending, goals: &[Goal], channels: &Channels) -> SessionResult {
    let Ending { snapshot, analysis, reason, report, excluded, shortfall } = ending;
    let (csv, bag) = match report {
        Some(FileReport::Csv(csv)) => (Some(csv), None),
        Some(FileReport::Bag(bag)) => (None, Some(bag)),
        None => (None, None),
    };
    let state = channels.state.borrow();
    let assessment = state.assessor.exact(&snapshot);
    let facts = state.facts_at(true);
    let recording = (facts.recording.clone())
        .or_else(|| bag.as_ref().and_then(|bag| recorded_times(bag, &reason)))
        .or_else(|| csv.as_ref().and_then(start_of_rows));
    SessionResult {
        facts: SourceFacts { csv, bag, recording, end: Some(reason.kind()), ..facts },
        shortfall,
        unmet: UnmetGoal::of(goals, &snapshot, &assessment),
        snapshot,
        assessment,
        analysis,
        end: Arc::new(reason),
        excluded: excluded.total(),
        recording: None,
        unrecorded_bytes: 0,
        is_restored: true,
    }
}

/// Times before are those of a simulation, or since the sensor was switched on.
const YEAR_2001_NS: i64 = 978_307_200_000_000_000;

/// When the first row of a table was measured, if its times count since 1970. A date may be that of
/// any time zone.
fn start_of_rows(csv: &CsvReport) -> Option<RecordingFacts> {
    let is_count = |part: &str| part.rsplit_once(':').is_some_and(|(_, form)| ["s", "ms", "us", "ns"].contains(&form));
    let counts = csv.times.as_ref()?.split('+').all(is_count);
    let started_ns = csv.first_stamp_ns.filter(|first_ns| counts && *first_ns >= YEAR_2001_NS)?;
    Some(RecordingFacts { started_ns: Some(started_ns), ..RecordingFacts::default() })
}

/// When a bag was recorded, if its times are dates and not those of a simulation; its end only
/// where it was read to there.
fn recorded_times(bag: &BagReport, reason: &EndReason) -> Option<RecordingFacts> {
    let (first_ns, last_ns) = bag.recorded_ns.filter(|(first_ns, _)| *first_ns >= YEAR_2001_NS)?;
    let end = match reason {
        EndReason::SourceEnded => Some(RecordingEndFacts { ended_ns: Some(last_ns), complete: true, reason: None }),
        EndReason::SourceFailed(_) => {
            Some(RecordingEndFacts { ended_ns: Some(last_ns), complete: false, reason: None })
        }
        _ => None,
    };
    Some(RecordingFacts { program: None, started_ns: Some(first_ns), end })
}

/// The result of a source that could not be opened: one without samples.
pub(crate) fn not_started(error: impl Into<StartError>, channels: &Channels) -> SessionResult {
    let snapshot = Arc::clone(&channels.state.borrow().snapshot);
    let (reason, excluded) = (EndReason::NotStarted(error.into()), Excluded::default());
    let ending = Ending { snapshot, analysis: None, reason, report: None, excluded, shortfall: None };
    result(ending, &[], channels)
}

/// So that a result that ends between two reads is the same however they were cut.
pub(crate) fn read_options(read: ReadOptions, settings: &Settings) -> ReadOptions {
    let ends_between = settings.duration.is_some() || !settings.until.is_empty();
    ReadOptions { line_by_line: read.line_by_line || ends_between, ..read }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vn100_analysis::protocol::stream::StampSource;

    use super::*;

    #[test]
    fn a_bag_has_its_times_where_they_are_dates_and_its_end_where_it_was_read_to_there() {
        let bag =
            |recorded_ns| BagReport { recorded_ns, ..BagReport::of("/imu", "sensor_msgs/Imu", StampSource::Recorded) };
        let dates = Some((YEAR_2001_NS, YEAR_2001_NS + 5));
        let times = recorded_times(&bag(dates), &EndReason::SourceEnded).unwrap();
        assert_eq!(times.started_ns, Some(YEAR_2001_NS));
        assert_eq!(times.end.map(|end| (end.ended_ns, end.complete)), Some((Some(YEAR_2001_NS + 5), true)));
        let times = recorded_times(&bag(dates), &EndReason::SourceFailed(std::io::Error::other("cut"))).unwrap();
        assert_eq!(times.end.map(|end| (end.ended_ns, end.complete)), Some((Some(YEAR_2001_NS + 5), false)));
        let times = recorded_times(&bag(dates), &EndReason::Stopped).unwrap();
        assert_eq!((times.started_ns, times.end.is_none()), (Some(YEAR_2001_NS), true));
        // since the start of a simulation
        assert!(recorded_times(&bag(Some((YEAR_2001_NS - 1, YEAR_2001_NS))), &EndReason::SourceEnded).is_none());
        assert!(recorded_times(&bag(None), &EndReason::SourceEnded).is_none());
    }

    #[test]
    fn a_result_that_ends_between_two_reads_is_read_line_by_line() {
        let whole = ReadOptions::default();
        let line_by_line = ReadOptions { line_by_line: true, ..whole };
        let timed = Settings { duration: Some(Duration::from_secs(1)), ..Settings::default() };
        let sought = Settings { until: vec!["gyro N ±5%".parse().unwrap()], ..Settings::default() };
        assert!(!read_options(whole, &Settings::default()).line_by_line);
        assert!(read_options(whole, &timed).line_by_line && read_options(whole, &sought).line_by_line);
        assert!(read_options(line_by_line, &Settings::default()).line_by_line);
    }
}
