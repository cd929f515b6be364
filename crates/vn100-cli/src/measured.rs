//! What the measurement of one source came to.

use std::io;

use anyhow::{Context, Result};
use indicatif::HumanBytes;
use tokio::task::JoinHandle;
use vn100_analysis::{CsvFacts, RecordingEndFacts, RecordingFacts, RejectedRows, Settings, SourceFacts};
use vn100_capture::{CsvReport, Recorded, RecordingState};
use vn100_pipeline::Outcome;
use vn100_report::Measured;

use crate::exit::about;

/// The result of a source that ended.
pub(crate) fn of(mut facts: SourceFacts, outcome: Outcome, settings: &Settings) -> Measured {
    let Outcome { snapshot, source_error, csv } = outcome;
    facts.csv = csv.map(csv_facts);
    facts.error = source_error.map(|error| failure(&facts.name, snapshot.link.tally.bytes(), &error));
    Measured::ended(facts, snapshot, settings)
}

/// What a recording says of itself, as far as it was read.
pub(crate) fn recording_facts(recorded: &Recorded) -> RecordingFacts {
    RecordingFacts {
        program: recorded.program.clone(),
        started_ns: recorded.started_ns,
        end: recorded.end.get().map(|end| RecordingEndFacts {
            ended_ns: end.ended_ns,
            complete: end.complete,
            reason: end.reason.clone(),
        }),
    }
}

fn csv_facts(report: CsvReport) -> CsvFacts {
    let rejected = report.odd.into_iter().map(|odd| RejectedRows {
        reason: odd.reason,
        count: odd.count,
        first_line: odd.first_line,
        first_text: odd.first_text,
    });
    CsvFacts {
        lines: report.lines,
        rows: report.rows,
        skipped_lines: report.skipped_lines,
        rejected: rejected.collect(),
        ignored_columns: report.ignored_columns,
        rounded: report.rounded,
    }
}

/// What became of the recording that was made meanwhile. Where it failed the result says so, and
/// the command has failed.
pub(crate) fn note_recording(measured: &mut Measured, recording: &RecordingState, unrecorded_bytes: u64) {
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

/// The results of all sources of a command, in their order.
pub(crate) async fn all_of(sources: Vec<JoinHandle<Result<Measured>>>) -> Result<Vec<Measured>> {
    let mut all = Vec::new();
    for source in sources {
        all.push(source.await.context("the measurement stopped by a fault of this program")??);
    }
    Ok(all)
}

/// A source on which no sensor was heard was not cut short.
fn failure(name: &str, bytes: u64, error: &io::Error) -> String {
    match bytes {
        0 => about(name, &error.to_string()),
        _ => format!("{name}: reading failed after {bytes} bytes, the result holds what came before: {error}"),
    }
}
