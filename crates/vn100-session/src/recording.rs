//! The recording of a session.

use std::{collections::BTreeMap, fs, path::PathBuf, sync::Arc, time::Duration};

use tokio::task;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{
    End,
    protocol::{
        Layout, MESSAGES, PACKET_MESSAGES, PacketMessage,
        stream::{MeasuredFrames, ReadOptions},
    },
    recorded_settings,
};
use vn100_capture::{Capture, CaptureOptions, Event, RecordError, Recorder, RecordingState, Rotation, part_path};

use crate::start_error::OtherMessage;

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
}

impl RecordingSpec {
    /// Begins the recording. A resumed recording is copied first, which takes time.
    pub(crate) async fn begin(&self, metadata: BTreeMap<String, String>) -> Result<Recorder, RecordError> {
        let Self { path, resume, rotation, .. } = self.clone();
        let failed = |error| RecordError::Io { path: self.path.clone(), source: std::io::Error::other(error) };
        let begin = move || match rotation {
            Some(rotation) => Recorder::in_parts(path, &metadata, rotation, resume),
            None if resume => Recorder::resume(path, &metadata),
            None => Recorder::create(path, &metadata),
        };
        task::spawn_blocking(begin).await.map_err(failed)?
    }

    /// The message of the recording to be resumed; `None` if there is none.
    pub(crate) async fn message(&self) -> Option<RecordedMessage> {
        let path = self.rotation.map_or_else(|| self.path.clone(), |_| part_path(&self.path, 1));
        let layout = if self.resume { first_layout(path).await } else { None };
        layout.map(|layout| RecordedMessage { path: self.path.clone(), layout })
    }

    /// Ends the recording. A new recording without input is removed, so that its name is free for
    /// the next one.
    pub(crate) async fn end(&self, recorder: Recorder, end: &End, excluded: Duration) -> RecordingState {
        let is_new = !recorder.is_resumed();
        // a recording holds all samples, and its replay shows what the measurement left out
        let note = match excluded {
            Duration::ZERO => String::new(),
            excluded => format!("; the first {:.3} s excluded by command", excluded.as_secs_f64()),
        };
        let state = recorder.finish(&(recorded_reason(end) + &note)).await;
        if state.bytes == 0 && state.error.is_none() && is_new {
            // an empty file that cannot be removed does no harm
            let _ = fs::remove_file(&state.path);
        }
        state
    }
}

/// The message of a recording that is resumed.
pub(crate) struct RecordedMessage {
    path: PathBuf,
    layout: Arc<Layout>,
}

impl RecordedMessage {
    /// Checks that the recording continues with its message: a replay would not measure another one.
    pub(crate) fn check(&self, sent: &Layout) -> Result<(), OtherMessage> {
        let other = || OtherMessage { path: self.path.clone(), recorded: name_of(&self.layout), sent: name_of(sent) };
        if is_same(&self.layout, sent) { Ok(()) } else { Err(other()) }
    }
}

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

pub(crate) fn layout_named(name: &str) -> Option<Arc<Layout>> {
    let sentence = MESSAGES.iter().find(|layout| layout.message == name);
    sentence.map(|layout| Arc::new((*layout).clone())).or_else(|| PacketMessage::named(name)?.layout())
}

/// The layout by which a replay measures a recording; `None` if it has none or does not exist.
async fn first_layout(path: PathBuf) -> Option<Arc<Layout>> {
    let capture = task::spawn_blocking(move || Capture::open(path, &CaptureOptions::default())).await.ok()?.ok()?;
    let measured = recorded_settings::frames(MeasuredFrames::First, &capture.recorded.as_ref()?.metadata);
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

/// The name by which a sensor is set to a message.
fn name_of(layout: &Layout) -> String {
    let packets = PACKET_MESSAGES.iter().find(|packets| packets.layout().is_some_and(|of| is_same(&of, layout)));
    packets.map_or_else(|| layout.message.to_string(), |packets| packets.name.to_owned())
}

fn is_same(recorded: &Layout, asked: &Layout) -> bool {
    let names = |layout: &Layout| layout.channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>();
    recorded.message == asked.message && names(recorded) == names(asked)
}

#[cfg(test)]
mod tests {
    use vn100_analysis::RateChange;

    use super::*;
    use crate::start_error::StartError;

    fn spec(path: PathBuf, resume: bool) -> RecordingSpec {
        RecordingSpec { path, resume, rotation: None }
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
}
