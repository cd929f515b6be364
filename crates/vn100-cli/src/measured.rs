//! What a session came to, with what stands in the way of a good result in words.

use std::{io, sync::Arc};

use anyhow::Result;
use indicatif::HumanBytes;
use tokio::task;
use vn100_capture::RecordingState;
use vn100_pipeline::{EndReason, SessionResult, StartError};
use vn100_report::{Completion, Evaluation, Measured};

use crate::session_words;

/// A task of the measurement died.
pub(crate) const FAULT: &str = "the measurement stopped by a fault of this program";

/// The result of a session, evaluated.
pub(crate) async fn evaluated(result: SessionResult, evaluation: &Arc<Evaluation>) -> Result<Measured> {
    let evaluation = Arc::clone(evaluation);
    // it takes its time, in which other sources are measured
    Ok(task::spawn_blocking(move || evaluation.complete(of(result))).await?)
}

/// The result of a replay, evaluated; one that was interrupted says so.
pub(crate) async fn evaluated_replay(result: SessionResult, evaluation: &Arc<Evaluation>) -> Result<Measured> {
    let is_stopped = matches!(*result.end, EndReason::Stopped);
    let mut measured = evaluated(result, evaluation).await?;
    if is_stopped {
        measured.note_interrupted();
    }
    Ok(measured)
}

fn of(result: SessionResult) -> Measured {
    let SessionResult { mut facts, snapshot, assessment, end, unmet, .. } = result;
    let error = session_words::end(&facts.name, &end, &snapshot);
    let (failed, cut_short) = match *end {
        EndReason::NotStarted(_) | EndReason::SourceFailed(_) => (error, None),
        _ => (None, error),
    };
    facts.error = failed;
    let mut measured = Measured::ended(facts, snapshot, assessment, &unmet);
    if matches!(*end, EndReason::NotStarted(StartError::Recording(_))) {
        // the source itself may be well
        measured.completion = Completion::Failed;
    }
    cut_short.into_iter().for_each(|text| measured.note_failure(text));
    if let Some(recording) = &result.recording {
        note_recording(&mut measured, recording, result.unrecorded_bytes);
    }
    if !result.is_restored {
        measured.completion = measured.completion.max(Completion::Failed);
    }
    measured
}

/// What became of the recording that was made meanwhile. Where it failed the result says so, and
/// the command has failed.
fn note_recording(measured: &mut Measured, recording: &RecordingState, unrecorded_bytes: u64) {
    let path = recording.path.display();
    let text = match &recording.error {
        Some(error) => {
            let advice = match error.kind() {
                io::ErrorKind::NotFound => "leave it in its place until the end",
                _ => "free the disk, or record elsewhere",
            };
            let bytes = HumanBytes(recording.bytes);
            format!("{path} ends after {bytes} of the bytes read: {error}. The result does not depend on it; {advice}")
        }
        None if unrecorded_bytes > 0 => format!(
            "{path} lacks {unrecorded_bytes} bytes, which the disk did not take in time, and says where; the result does not depend on it"
        ),
        None => return,
    };
    measured.note_failed_recording(text);
}
