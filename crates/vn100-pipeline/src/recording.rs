use std::{collections::BTreeMap, fs, path::PathBuf, time::Duration};

use tokio::task;
use vn100_capture::{RecordError, Recorder, RecordingState};

/// Which recording is made.
#[derive(Debug, Clone)]
pub struct RecordingSpec {
    /// The file.
    pub path: PathBuf,
    /// Whether to append to an existing recording, after a break; else the file must be new.
    pub resume: bool,
    /// What to write behind the reason of the end where this data time was excluded by command: the
    /// replay is to exclude the same.
    pub excluded_note: fn(Duration) -> String,
}

impl RecordingSpec {
    /// Begins the recording. An existing one is copied first, which takes its time.
    pub(crate) async fn begin(&self, metadata: BTreeMap<String, String>) -> Result<Recorder, RecordError> {
        let (path, resume) = (self.path.clone(), self.resume);
        let failed = |error| RecordError::Io { path: self.path.clone(), source: std::io::Error::other(error) };
        let begin = move || if resume { Recorder::resume(path, &metadata) } else { Recorder::create(path, &metadata) };
        task::spawn_blocking(begin).await.map_err(failed)?
    }

    /// A new recording in which nothing came is removed: it would stand in the way of the next
    /// attempt.
    pub(crate) async fn end(&self, recorder: Recorder, reason: &str, excluded: Duration) -> RecordingState {
        let state = match excluded {
            Duration::ZERO => recorder.finish(reason).await,
            excluded => recorder.finish(&format!("{reason}; {}", (self.excluded_note)(excluded))).await,
        };
        if state.bytes == 0 && state.error.is_none() && !self.resume {
            // one that cannot be removed holds nothing
            let _ = fs::remove_file(&state.path);
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(path: PathBuf, resume: bool) -> RecordingSpec {
        RecordingSpec { path, resume, excluded_note: |time| format!("without {time:?}") }
    }

    #[tokio::test]
    async fn an_empty_recording_is_removed_if_it_is_new() {
        let folder = tempfile::tempdir().unwrap();
        let new = spec(folder.path().join("a.mcap"), false);
        let recorder = new.begin(BTreeMap::new()).await.unwrap();
        assert!(new.path.exists());
        let state = new.end(recorder, "stopped", Duration::ZERO).await;
        assert!(state.ended && !new.path.exists());
        drop(Recorder::create(&new.path, &BTreeMap::new()).unwrap().finish("whole").await);
        let resumed = spec(new.path.clone(), true);
        assert!(matches!(new.begin(BTreeMap::new()).await, Err(RecordError::Exists { .. })));
        let recorder = resumed.begin(BTreeMap::new()).await.unwrap();
        resumed.end(recorder, "stopped", Duration::ZERO).await;
        assert!(resumed.path.exists());
    }
}
