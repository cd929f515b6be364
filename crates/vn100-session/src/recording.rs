//! The recording of a session, with the conditions and the requested end of the measurement. A
//! replay ends there as well, although the recording may contain one more line.

use std::{collections::BTreeMap, fs, path::PathBuf, sync::Arc, time::Duration};

use tokio::task;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{
    End, Goal, Settings,
    protocol::{
        Layout, MESSAGES, PacketMessage,
        stream::{MeasuredFrames, ReadOptions},
    },
};
use vn100_capture::{
    Capture, CaptureOptions, Event, RecordError, Recorded, Recorder, RecordingState, Rotation, part_path,
};

use crate::start_error::StartError;

/// The options of a recording.
#[derive(Debug, Clone)]
pub struct RecordingSpec {
    /// The file.
    pub path: PathBuf,
    /// Whether to append to an existing recording, after a break, and to begin one if there is
    /// none; if it is `false`, the file must be new.
    pub resume: bool,
    /// The condition under which the recording continues in the next file; `None` for one file.
    pub rotation: Option<Rotation>,
    /// Words the data time that was excluded by command. The text is appended to the recorded
    /// reason of the end, so that a replay shows it.
    pub excluded_note: fn(Duration) -> String,
}

impl RecordingSpec {
    /// Begins the recording. A resumed recording is copied first, which takes time.
    pub(crate) async fn begin(&self, metadata: BTreeMap<String, String>) -> Result<Recorder, RecordError> {
        let Self { path, resume, rotation, .. } = self.clone();
        let failed = |error| RecordError::Io { path: self.path.clone(), source: std::io::Error::other(error) };
        let begin = move || match rotation {
            Some(rotation) => Recorder::in_parts(path, &metadata, rotation, resume),
            None if resume => Recorder::resume_or_create(path, &metadata),
            None => Recorder::create(path, &metadata),
        };
        task::spawn_blocking(begin).await.map_err(failed)?
    }

    /// Checks that the recording to be resumed contains this message of the sensor: otherwise a
    /// replay would not measure the appended part.
    pub(crate) async fn continues(&self, message: Option<&str>) -> Result<(), StartError> {
        let Some(asked) = message.and_then(layout_named).filter(|_| self.resume) else { return Ok(()) };
        let path = self.rotation.map_or_else(|| self.path.clone(), |_| part_path(&self.path, 1));
        match first_layout(path).await {
            Some(recorded) if !is_same(&recorded, &asked) => Err(StartError::OtherMessage {
                path: self.path.clone(),
                recorded: recorded.message.to_string(),
                asked: message.unwrap_or_default().to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// Ends the recording. A new recording without input is removed, so that its name is free for
    /// the next one.
    pub(crate) async fn end(&self, recorder: Recorder, end: &End, excluded: Duration) -> RecordingState {
        let reason = recorded_reason(end);
        let is_new = !recorder.is_resumed();
        let state = match excluded {
            Duration::ZERO => recorder.finish(&reason).await,
            excluded => recorder.finish(&format!("{reason}; {}", (self.excluded_note)(excluded))).await,
        };
        if state.bytes == 0 && state.error.is_none() && is_new {
            // an empty file that cannot be removed does no harm
            let _ = fs::remove_file(&state.path);
        }
        state
    }
}

/// The reason of an end as a recording has it.
fn recorded_reason(end: &End) -> String {
    match end {
        End::NotStarted { text, .. } | End::SourceFailed(text) => text.clone(),
        End::SourceEnded => "end of the source".into(),
        End::DurationReached => "duration reached".into(),
        End::GoalsDecided => "goals decided".into(),
        End::Stopped | End::NoMeasurement => "stopped".into(),
        End::OtherMessages { .. } => "the sensor sends another message".into(),
        End::OtherRate(_) => "the sensor sends at another rate".into(),
        End::GaveUp { .. } => "the sensor was lost".into(),
        End::WallTime(_) => "wall time over".into(),
    }
}

/// The layout of a message by its name.
fn layout_named(name: &str) -> Option<Arc<Layout>> {
    let sentence = MESSAGES.iter().find(|layout| layout.message == name);
    sentence.map(|layout| Arc::new((*layout).clone())).or_else(|| PacketMessage::named(name)?.layout())
}

/// The layout by which a replay measures a recording; `None` if it has none or does not exist.
async fn first_layout(path: PathBuf) -> Option<Arc<Layout>> {
    let capture = task::spawn_blocking(move || Capture::open(path, &CaptureOptions::default())).await.ok()?.ok()?;
    let measured = recorded_frames(MeasuredFrames::First, capture.recorded.as_ref()?);
    let stop = CancellationToken::new();
    let mut events = capture.read(ReadOptions { measured, ..ReadOptions::default() }, stop.clone()).ok()?;
    let _stop_reading = stop.drop_guard();
    while let Some(event) = events.recv().await {
        if let Event::Batch(batch) = event
            && let Some(layout) = batch.layout
        {
            return Some(layout);
        }
    }
    None
}

fn is_same(recorded: &Layout, asked: &Layout) -> bool {
    let names = |layout: &Layout| layout.channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>();
    recorded.message == asked.message && names(recorded) == names(asked)
}

/// The requested data time.
const DURATION: &str = "measured.duration";

/// The goals for the measurement, separated by semicolons.
const UNTIL: &str = "measured.until";

/// Whether sentences or packets were measured, if one of them was chosen.
const MEASURED: &str = "measured.frames";
const SENTENCES: &str = "sentences";
const PACKETS: &str = "packets";

/// Whether a name is the program's own, rather than one of the user's conditions.
#[must_use]
pub fn is_reserved(name: &str) -> bool {
    [DURATION, UNTIL, MEASURED].contains(&name)
}

pub(crate) fn metadata(
    conditions: &BTreeMap<String, String>,
    settings: &Settings,
    measured: MeasuredFrames,
) -> BTreeMap<String, String> {
    let mut all = conditions.clone();
    let frames = match measured {
        MeasuredFrames::First => None,
        MeasuredFrames::Sentences => Some(SENTENCES),
        MeasuredFrames::Packets => Some(PACKETS),
    };
    all.extend(frames.map(|frames| (MEASURED.to_owned(), frames.to_owned())));
    let duration = settings.duration.map(|duration| humantime::format_duration(duration).to_string());
    all.extend(duration.map(|duration| (DURATION.to_owned(), duration)));
    if !settings.until.is_empty() {
        let goals: Vec<_> = settings.until.iter().map(Goal::to_string).collect();
        all.insert(UNTIL.to_owned(), goals.join("; "));
    }
    all
}

pub(crate) fn conditions(recorded: &Recorded) -> Option<BTreeMap<String, String>> {
    let users = recorded.metadata.iter().filter(|(name, _)| !is_reserved(name));
    let users: BTreeMap<_, _> = users.map(|(name, value)| (name.clone(), value.clone())).collect();
    (!users.is_empty()).then_some(users)
}

/// Whether sentences or packets of a recording are measured: as chosen now, else as in the recorded
/// measurement.
pub(crate) fn recorded_frames(asked: MeasuredFrames, recorded: &Recorded) -> MeasuredFrames {
    match (asked, recorded.metadata.get(MEASURED).map(String::as_str)) {
        (MeasuredFrames::First, Some(SENTENCES)) => MeasuredFrames::Sentences,
        (MeasuredFrames::First, Some(PACKETS)) => MeasuredFrames::Packets,
        (asked, _) => asked,
    }
}

/// The settings with the end of the recorded measurement, if they name none.
pub(crate) fn with_recorded_end(mut settings: Settings, recorded: &Recorded) -> Settings {
    // a resumed recording has the limits of the measurement before the break, and a part does not
    // end at the end of the whole
    if !recorded.resumed && recorded.part.is_none() {
        let duration = || humantime::parse_duration(recorded.metadata.get(DURATION)?).ok();
        settings.duration = settings.duration.or_else(duration);
        if settings.until.is_empty() {
            let goals = recorded.metadata.get(UNTIL).map_or("", String::as_str);
            settings.until = goals.split(';').filter_map(|goal| goal.parse().ok()).collect();
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use vn100_analysis::RateChange;

    use super::*;

    fn spec(path: PathBuf, resume: bool) -> RecordingSpec {
        RecordingSpec { path, resume, rotation: None, excluded_note: |time| format!("without {time:?}") }
    }

    #[tokio::test]
    async fn an_empty_recording_is_removed_if_it_is_new() {
        let folder = tempfile::tempdir().unwrap();
        let new = spec(folder.path().join("a.mcap"), false);
        let recorder = new.begin(BTreeMap::new()).await.unwrap();
        assert!(new.path.exists());
        let state = new.end(recorder, &End::Stopped, Duration::ZERO).await;
        assert!(state.ended && !new.path.exists());
        drop(Recorder::create(&new.path, &BTreeMap::new()).unwrap().finish("whole").await);
        let resumed = spec(new.path.clone(), true);
        assert!(matches!(new.begin(BTreeMap::new()).await, Err(RecordError::Exists { .. })));
        let recorder = resumed.begin(BTreeMap::new()).await.unwrap();
        resumed.end(recorder, &End::Stopped, Duration::ZERO).await;
        assert!(resumed.path.exists());
        let begun = spec(folder.path().join("b.mcap"), true);
        let recorder = begun.begin(BTreeMap::new()).await.unwrap();
        assert!(begun.path.exists());
        begun.end(recorder, &End::Stopped, Duration::ZERO).await;
        assert!(!begun.path.exists(), "it was new, and is empty");
    }

    #[test]
    fn a_recording_contains_its_end_reason() {
        let change = RateChange { after_samples: 1, from_hz: 200.0, to_hz: 40.0 };
        let message = "VNYMR".into();
        let other = End::OtherMessages { message, other: None, rate_hz: None, after: Duration::ZERO };
        for (end, text) in [
            (StartError::Stopped.end(), "not read, interrupted"),
            (End::SourceEnded, "end of the source"),
            (End::DurationReached, "duration reached"),
            (End::GoalsDecided, "goals decided"),
            (End::Stopped, "stopped"),
            (End::NoMeasurement, "stopped"),
            (End::SourceFailed("unplugged".into()), "unplugged"),
            (other, "the sensor sends another message"),
            (End::OtherRate(change), "the sensor sends at another rate"),
            (End::GaveUp { after: Duration::ZERO, cause: None }, "the sensor was lost"),
            (End::WallTime(Duration::ZERO), "wall time over"),
        ] {
            assert_eq!(recorded_reason(&end), text);
        }
    }

    fn ended() -> Settings {
        let until = ["gyro N ±5%", "accel_z K ±12.5 %"].map(|goal| goal.parse().unwrap()).to_vec();
        Settings { duration: Some(Duration::from_millis(90_500)), until, ..Settings::default() }
    }

    #[test]
    fn the_end_of_a_measurement_is_read_from_its_recording_and_is_no_condition() {
        let metadata = metadata(&BTreeMap::new(), &ended(), MeasuredFrames::First);
        let recorded = Recorded { metadata, ..Recorded::default() };
        assert_eq!(with_recorded_end(Settings::default(), &recorded), ended());
        assert_eq!(conditions(&recorded), None);
        let asked = Settings {
            duration: Some(Duration::from_secs(7)),
            until: vec!["gyro B ±20%".parse().unwrap()],
            ..Settings::default()
        };
        assert_eq!(with_recorded_end(asked.clone(), &recorded), asked);
        let resumed = Recorded { resumed: true, ..recorded };
        assert_eq!(with_recorded_end(Settings::default(), &resumed), Settings::default());
    }

    #[test]
    fn a_replay_measures_the_recorded_frames_by_default() {
        for measured in [MeasuredFrames::First, MeasuredFrames::Sentences, MeasuredFrames::Packets] {
            let metadata = metadata(&BTreeMap::new(), &Settings::default(), measured);
            let recorded = Recorded { metadata, ..Recorded::default() };
            assert_eq!(recorded_frames(MeasuredFrames::First, &recorded), measured);
            assert_eq!(recorded_frames(MeasuredFrames::Packets, &recorded), MeasuredFrames::Packets);
            assert_eq!(conditions(&recorded), None);
        }
    }

    #[test]
    fn conditions_are_kept_and_names_of_the_program_reserved() {
        let users = BTreeMap::from([("place".to_owned(), "bench 3".to_owned())]);
        assert_eq!(metadata(&users, &Settings::default(), MeasuredFrames::First), users);
        let recorded = Recorded { metadata: metadata(&users, &ended(), MeasuredFrames::First), ..Recorded::default() };
        assert_eq!(recorded.metadata.len(), 3);
        assert_eq!(conditions(&recorded), Some(users));
        assert!(recorded.metadata.keys().filter(|name| is_reserved(name)).count() == 2 && !is_reserved("place"));
    }
}
