//! One source, as the view follows it: its state is read, and commands go to its session.

use std::{sync::Arc, time::Duration};

use tokio::sync::{mpsc, watch};
use vn100_analysis::{Assessment, Snapshot};
use vn100_pipeline::{Command, EndReason, Session, SourceState, Stage};
use vn100_report::{Evaluation, no_sample, printable};

use super::source::{self, Source};
use crate::session_words;

/// A source of the view. Reading its state delays no other task.
#[derive(Debug)]
pub(crate) struct SourceMonitor {
    state: watch::Receiver<SourceState>,
    commands: mpsc::Sender<Command>,
    /// As it was looked at last.
    pub(crate) shown: Source,
}

impl SourceMonitor {
    /// The source of a session.
    pub(crate) fn of(session: &Session) -> Self {
        let (state, commands) = (session.state.clone(), session.commands.clone());
        let now = state.borrow().clone();
        let name = printable(now.name());
        let shown = Source::new(name, now.facts(), Arc::clone(&now.snapshot), now.assessment());
        Self { state, commands, shown }
    }

    /// Takes what is new; whether anything was.
    pub(crate) fn look(&mut self, elapsed: Duration, evaluation: &Evaluation) -> bool {
        let state = self.state.borrow_and_update().clone();
        let shown = &mut self.shown;
        let is_new_second = elapsed.as_secs() != shown.elapsed.as_secs();
        shown.elapsed = elapsed;
        let stage = stage(&state);
        let mut changed =
            is_new_second || shown.stage != stage || shown.link != state.link || shown.playback != state.playback;
        shown.stage = stage;
        shown.link.clone_from(&state.link);
        shown.playback = state.playback;
        shown.recording.clone_from(&state.recording);
        shown.origin = Arc::new(state.facts());
        if !Arc::ptr_eq(&state.snapshot, &shown.snapshot) {
            let assessment = state.assessment();
            if !Arc::ptr_eq(&assessment, &shown.assessment) {
                shown.verdicts = evaluation.verdicts(&state.snapshot, &assessment);
            }
            shown.show(state.snapshot, assessment);
            changed = true;
        }
        changed
    }

    /// The assessment of this very snapshot.
    pub(crate) fn assess(&self, snapshot: &Snapshot) -> Assessment {
        // the state is not kept locked meanwhile
        let assessor = self.state.borrow().assessor();
        assessor.exact(snapshot)
    }

    /// Sends a command to the session; the answer for the user, if there is one.
    pub(crate) fn command(&self, command: Command) -> Option<String> {
        if !matches!(self.state.borrow().stage, Stage::Measuring) {
            return Some("nothing is measured there".into());
        }
        // who presses a key again finds room
        self.commands.try_send(command).err().map(|_| "that cannot be done now".into())
    }
}

fn stage(state: &SourceState) -> source::Stage {
    match &state.stage {
        Stage::Preparing => source::Stage::Preparing,
        Stage::Measuring | Stage::Finishing => source::Stage::Measuring,
        Stage::Ended(end) => {
            let (name, snapshot) = (state.name(), &state.snapshot);
            let is_empty = snapshot.timing.samples == 0 && !matches!(**end, EndReason::GoalsDecided);
            let error = session_words::end(name, end, snapshot);
            let error = error.or_else(|| is_empty.then(|| no_sample(name, snapshot)));
            source::Stage::Ended(error.map(|error| printable(&error)))
        }
    }
}
