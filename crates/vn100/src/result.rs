//! Results of sessions, evaluated and written to standard output.

use std::{
    io,
    sync::Arc,
    time::{Duration, SystemTime},
};

use anyhow::{Context, Result};
use indicatif::HumanBytes;
use tokio::task::{self, JoinHandle};
use vn100_analysis::{Completion, End, Goal, Parts, SourceResult};
use vn100_capture::RecordingState;
use vn100_report::{
    Document, Ended, Evaluation, HeartbeatDocument, ProgressDocument, note_failed_recording, note_interrupted,
    remedies::remedy_words,
};
use vn100_session::{SessionResult, SourceState};

use crate::{
    args::{Ndjson, OutputFormat},
    exit::{is_coloured, print, print_json, print_json_line, report, unless_closed, write},
    text,
};

/// A task of the measurement panicked.
pub(crate) const FAULT: &str = "internal error: the measurement stopped";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ResultOf {
    Capture,
    Sensor,
    /// A sensor that is recorded and not measured.
    Recording,
}

pub(crate) async fn evaluated(
    result: SessionResult,
    evaluation: &Arc<Evaluation>,
    of: ResultOf,
) -> Result<SourceResult> {
    let evaluation = Arc::clone(evaluation);
    // it is slow: other sources are measured meanwhile
    Ok(task::spawn_blocking(move || evaluation.complete(measured(result, of))).await?)
}

/// The result of a replay, evaluated; one that was interrupted says so, unless the reader of its
/// samples `has_enough`.
pub(crate) async fn evaluated_replay(
    result: SessionResult,
    evaluation: &Arc<Evaluation>,
    has_enough: bool,
) -> Result<SourceResult> {
    let is_stopped = matches!(*result.end, End::Stopped) && !has_enough;
    let mut measured = evaluated(result, evaluation, ResultOf::Capture).await?;
    if is_stopped {
        note_interrupted(&mut measured);
    }
    Ok(measured)
}

fn measured(result: SessionResult, of: ResultOf) -> SourceResult {
    let SessionResult { measured, end, shortfall, unmet, .. } = result;
    let is_live = of != ResultOf::Capture;
    let ended = Ended { end: &end, shortfall: shortfall.as_ref(), unmet: &unmet, is_live, words: remedy_words };
    let mut measured = ended.complete(measured);
    if let Some(recording) = &result.recording {
        note_recording(&mut measured, recording, result.unrecorded_bytes, of);
    }
    if !result.is_restored {
        measured.completion = measured.completion.max(Completion::Failed);
    }
    measured
}

/// The outcome of the recording made meanwhile. If it failed the result says so, and
/// the command has failed.
fn note_recording(measured: &mut SourceResult, recording: &RecordingState, unrecorded_bytes: u64, of: ResultOf) {
    let independent = if of == ResultOf::Recording { "" } else { ". The result does not depend on it" };
    let path = recording.path.display();
    let text = match &recording.error {
        Some(error) => {
            let advice = match error.kind() {
                io::ErrorKind::NotFound => "do not remove it before the end",
                _ => "free the disk, or record elsewhere",
            };
            let bytes = HumanBytes(recording.bytes);
            format!("{path} ends after {bytes} of the bytes read: {error}{independent}; {advice}")
        }
        None if unrecorded_bytes > 0 => {
            format!("{path} lacks {unrecorded_bytes} bytes, because the disk was too slow; it marks where{independent}")
        }
        None => return,
    };
    note_failed_recording(measured, text);
}

pub(crate) struct ResultWriter {
    format: OutputFormat,
    results: Vec<SourceResult>,
    completion: Completion,
    is_begun: bool,
}

impl ResultWriter {
    pub(crate) fn new(format: OutputFormat) -> Self {
        Self { format, results: Vec::new(), completion: Completion::Complete, is_begun: false }
    }

    /// Writes the next one, or keeps it for the document at the end.
    pub(crate) fn write(&mut self, measured: SourceResult) -> Result<()> {
        self.completion = self.completion.max(measured.completion);
        measured.failures().for_each(|text| report(text));
        // an error before the first byte says everything
        let source = &measured.source;
        let has_text = source.kind.is_some() && (source.error.is_none() || measured.link.bytes > 0);
        match &self.format {
            OutputFormat::Json => self.results.push(measured),
            OutputFormat::Summary(color) if has_text => {
                let separator = if self.is_begun { "\n" } else { "" };
                let summary = text::summary(&measured, is_coloured(*color));
                write(&format!("{separator}{summary}"))?;
            }
            OutputFormat::Head if has_text => print(&text::head(&measured))?,
            OutputFormat::Counts if has_text => print(&format!("  {}\n", text::counts(&measured)))?,
            _ => {}
        }
        self.is_begun = true;
        Ok(())
    }

    /// After the last: writes what was kept, and returns the outcome of the command.
    pub(crate) fn finish(self) -> Result<Completion> {
        if self.format == OutputFormat::Json {
            let documents: Vec<Document<'_>> =
                self.results.iter().map(|result| Document::new(result, remedy_words)).collect();
            unless_closed(match &documents[..] {
                [document] => print_json(document),
                _ => print_json(&documents),
            })?;
        }
        Ok(self.completion)
    }
}

pub(crate) fn print_state(state: &SourceState, form: Ndjson, goals: &[Goal]) -> Result<()> {
    print_result(&state.result(Parts::WithoutSignals), form, goals)
}

pub(crate) fn print_result(result: &SourceResult, form: Ndjson, goals: &[Goal]) -> Result<()> {
    match form {
        Ndjson::Whole => print_json_line(&Document::new(result, remedy_words)),
        Ndjson::Thin => print_json_line(&ProgressDocument::new(result, goals)),
    }
}

/// Writes that a live source has given no sample for so long.
pub(crate) fn print_heartbeat(state: &SourceState, silent: Duration) -> Result<()> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let now_ns = i64::try_from(now.as_nanos()).unwrap_or(i64::MAX);
    let (facts, samples) = (state.facts(), state.snapshot.link.samples());
    print_json_line(&HeartbeatDocument::new(&facts.name, samples, facts.link.as_ref(), silent, now_ns))
}

/// The results of all sources of a command, in their order.
pub(crate) async fn all_of(sources: Vec<JoinHandle<Result<SourceResult>>>) -> Result<Vec<SourceResult>> {
    let mut all = Vec::new();
    for source in sources {
        all.push(source.await.context(FAULT)??);
    }
    Ok(all)
}
