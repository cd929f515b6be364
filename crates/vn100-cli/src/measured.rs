//! What a measurement of one source came to.

use std::{io, sync::Arc};

use anyhow::{Context, Result};
use indicatif::HumanBytes;
use tokio::task::JoinHandle;
use vn100_analysis::{
    Analysis, Assessment, FigureVerdict, FilterModels, Goal, Settings, Snapshot, Warning, WarningKind,
};
use vn100_capture::RecordingState;
use vn100_pipeline::Outcome;

use crate::{
    exit::{Exit, about},
    source_document::Origin,
};

/// One source's result. Where nothing could be read it is that of no samples, and `origin` says
/// why.
pub(crate) struct Measured {
    pub(crate) origin: Origin,
    pub(crate) snapshot: Arc<Snapshot>,
    pub(crate) assessment: Assessment,
    /// By channel; empty unless asked for.
    pub(crate) filter_models: Vec<Option<FilterModels>>,
    /// `None` without a data sheet for the sensor.
    pub(crate) verdicts: Option<Verdicts>,
    /// Goals that were not reached, and figures that did not pass, in words.
    pub(crate) unmet: Vec<String>,
    pub(crate) exit: Exit,
}

/// Verdicts against one data sheet.
#[derive(Debug, Clone)]
pub(crate) struct Verdicts {
    /// Name of the sheet.
    pub(crate) datasheet: String,
    /// How far its figures can be trusted.
    pub(crate) note: Option<String>,
    /// By channel.
    pub(crate) channels: Vec<Vec<FigureVerdict>>,
}

impl Measured {
    /// The result of a source as it would be if it ended now.
    pub(crate) fn so_far(origin: Origin, snapshot: Arc<Snapshot>, confidence: f64) -> Self {
        let assessment = Assessment::new(&snapshot, confidence);
        let (filter_models, unmet) = (Vec::new(), Vec::new());
        Self { origin, snapshot, assessment, filter_models, verdicts: None, unmet, exit: Exit::Good }
    }

    /// The result of a source that could not be opened, as `origin` says.
    pub(crate) fn nothing(origin: Origin, settings: &Settings) -> Self {
        let snapshot = Arc::new(Analysis::new(settings.clone()).snapshot());
        Self { exit: Exit::NoData, ..Self::so_far(origin, snapshot, settings.confidence) }
    }

    /// The result of a source that ended.
    pub(crate) fn of(mut origin: Origin, outcome: Outcome, settings: &Settings) -> Self {
        let Outcome { snapshot, source_error, csv } = outcome;
        origin.csv = csv;
        let mut exit = Exit::Good;
        if let Some(error) = source_error {
            origin.error = Some(failure(&origin.name, snapshot.link.tally.bytes(), &error));
            exit = Exit::Failed;
        }
        let out_of_reach = settings.until.iter().any(|goal| goal.out_of_reach(&snapshot).is_some());
        // where a goal is out of reach the measurement ended before there had to be a sample
        if snapshot.timing.samples == 0 && !out_of_reach {
            origin.error.get_or_insert_with(|| {
                let bytes = snapshot.link.bytes();
                match snapshot.timing.left_out {
                    0 => format!("{}: no valid sample in {bytes} bytes", origin.name),
                    1 => format!("{}: its one sample lies in the time to be skipped", origin.name),
                    left_out => format!("{}: all {left_out} samples lie in the time to be skipped", origin.name),
                }
            });
            exit = Exit::NoData;
        }
        let assessment = Assessment::new(&snapshot, settings.confidence);
        let unmet = settings.until.iter().filter(|goal| !goal.is_met(&snapshot, &assessment));
        let unmet: Vec<String> = unmet.map(|goal| not_met(&origin.name, goal, &snapshot, &assessment)).collect();
        if !unmet.is_empty() {
            exit = exit.max(Exit::NotMet);
        }
        Self { origin, snapshot, assessment, filter_models: Vec::new(), verdicts: None, unmet, exit }
    }

    /// What became of the recording that was made meanwhile. Where it failed the result says so,
    /// and the command has failed.
    pub(crate) fn note_recording(&mut self, recording: &RecordingState, unrecorded_bytes: u64) {
        let path = recording.path.display();
        let text = match &recording.error {
            Some(error) => {
                let advice = match error.kind() {
                    io::ErrorKind::NotFound => "leave it in its place until the end",
                    _ => "free the disk, or record elsewhere",
                };
                let bytes = HumanBytes(recording.bytes);
                format!(
                    "{path} ends after {bytes} of the bytes read: {error}. The result does not depend on it; {advice}"
                )
            }
            None if unrecorded_bytes > 0 => format!(
                "{path} lacks {unrecorded_bytes} bytes, which the disk did not take in time, and says where; the result does not depend on it"
            ),
            None => return,
        };
        let warning = Warning { kind: WarningKind::RecordingFailed, channels: Vec::new(), text };
        Arc::make_mut(&mut self.snapshot).warnings.insert(0, warning);
        self.exit = self.exit.max(Exit::Failed);
    }

    /// A result cut short by a fault that is no error of the source says so, and the command has
    /// failed.
    pub(crate) fn note_failure(&mut self, text: String) {
        self.origin.error.get_or_insert(text);
        self.exit = self.exit.max(Exit::Failed);
    }

    /// A result cut short says so, though an interrupt ends like the end of the data.
    pub(crate) fn note_interrupted(&mut self) {
        let origin = &mut self.origin;
        origin.error.get_or_insert_with(|| format!("{}: interrupted, the result holds what came before", origin.name));
    }
}

/// The results of all sources of a command, in their order.
pub(crate) async fn all_of(sources: Vec<JoinHandle<Result<Measured>>>) -> Result<Vec<Measured>> {
    let mut all = Vec::new();
    for source in sources {
        all.push(source.await.context("the measurement stopped by a fault of this program")??);
    }
    Ok(all)
}

/// How well the figure is known instead.
fn not_met(name: &str, goal: &Goal, snapshot: &Snapshot, assessment: &Assessment) -> String {
    if let Some(why) = goal.out_of_reach(snapshot) {
        return format!("{name}: {goal} cannot be reached: {why}");
    }
    let axes = goal.relative_half_widths(snapshot, assessment);
    let known: Vec<String> = (axes.iter())
        .map(|(axis, width)| match width {
            Some(width) => format!("{axis} ±{:.1} %", 100.0 * width),
            None => format!("{axis} is not estimated"),
        })
        .collect();
    let known = if known.is_empty() { "the stream has no such channel".into() } else { known.join(", ") };
    format!("{name}: the data ended before {goal} was reached: {known}")
}

/// A source on which no sensor was heard was not cut short.
fn failure(name: &str, bytes: u64, error: &io::Error) -> String {
    match bytes {
        0 => about(name, &error.to_string()),
        _ => format!("{name}: reading failed after {bytes} bytes, the result holds what came before: {error}"),
    }
}
