//! What is shown of one source, as plain data, and the session that it is read from.

use std::{sync::Arc, time::Duration};

use tokio::sync::{mpsc, watch};
use vn100_analysis::{Assessment, End, LinkFacts, Parts, Snapshot, SourceResult, Warning};
use vn100_protocol::Quantity;
use vn100_report::{Evaluation, goals::Goals, names::QUANTITIES, no_sample, printable, remedies::remedy_words};
use vn100_session::{Command, Playback, Session, SourceState, Stage};

use crate::{faults::Faults, reference::Reference};

#[derive(Debug, Clone)]
pub(crate) struct SourceView {
    /// Without anything that steers a terminal.
    pub(crate) name: String,
    pub(crate) phase: SourcePhase,
    /// The result so far, compared with the data sheet.
    pub(crate) result: SourceResult,
    /// Its warnings, the most severe first, and the newest first of equal severity.
    pub(crate) warnings: Vec<Warning>,
    /// What is broken now.
    pub(crate) faults: Faults,
    pub(crate) reference: Option<Arc<Reference>>,
    /// What the measurement ends by.
    pub(crate) goals: Arc<Goals>,
    /// Since the view began.
    pub(crate) now: Duration,
    /// Since the command began, or the measurement was started over.
    pub(crate) elapsed: Duration,
    /// `None` for live sources.
    pub(crate) playback: Option<Playback>,
}

/// How far a source has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SourcePhase {
    Preparing,
    Measuring,
    /// No more data; the reason, unless the user ended it.
    Ended(Option<String>),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChannelGroup {
    pub(crate) quantity: Quantity,
    /// Places among the channels.
    pub(crate) channels: Vec<usize>,
}

impl SourceView {
    /// Whether nothing more is to be waited for.
    pub(crate) fn is_over(&self) -> bool {
        matches!(self.phase, SourcePhase::Ended(_)) || self.playback.is_some_and(|playback| playback.at_end)
    }

    pub(crate) fn new(name: String, result: SourceResult) -> Self {
        Self {
            name,
            result,
            phase: SourcePhase::Preparing,
            warnings: Vec::new(),
            faults: Faults::default(),
            reference: None,
            goals: Arc::default(),
            now: Duration::ZERO,
            elapsed: Duration::ZERO,
            playback: None,
        }
    }

    pub(crate) fn show(&mut self, result: SourceResult) {
        let age = |warning: &Warning| self.warnings.iter().rposition(|old| old.kind == warning.kind);
        let (new, mut known): (Vec<_>, Vec<_>) = result.warnings.iter().partition(|warning| age(warning).is_none());
        known.sort_by_key(|warning| age(warning));
        self.warnings = new.into_iter().chain(known).cloned().collect();
        self.warnings.sort_by_key(|warning| warning.severity);
        self.result = result;
    }

    /// What is to be read in the panel of the warnings: what is broken, then the warnings.
    pub(crate) fn findings(&self) -> usize {
        self.faults.all().len() + self.warnings.len()
    }

    pub(crate) fn groups(&self) -> Vec<ChannelGroup> {
        // what was read from registers stands after the stream's own
        let of = |quantity| {
            let channels = self.result.streamed().enumerate().filter(|(_, channel)| channel.quantity == quantity);
            ChannelGroup { quantity, channels: channels.map(|(place, _)| place).collect() }
        };
        QUANTITIES.into_iter().map(of).filter(|group| !group.channels.is_empty()).collect()
    }

    /// What the link is doing; `None` for what is no link.
    pub(crate) fn link(&self) -> Option<&LinkFacts> {
        self.result.source.link.as_ref()
    }

    /// Why there is no measurement to steer; `None` while there is one.
    pub(crate) fn no_measurement(&self) -> Option<&'static str> {
        match &self.phase {
            SourcePhase::Measuring if self.playback.is_some_and(|playback| playback.at_end) => {
                Some("the replay is at its end: q prints its result")
            }
            SourcePhase::Measuring => None,
            SourcePhase::Preparing => Some("the measurement has not begun"),
            SourcePhase::Ended(_) => Some("the measurement has ended: q prints its result"),
        }
    }
}

/// A source of the view. Reading its state delays no other task.
#[derive(Debug)]
pub struct SourceMonitor {
    state: watch::Receiver<SourceState>,
    commands: mpsc::Sender<Command>,
    /// When the measurement began, or began anew, since the command did.
    began: Duration,
    /// When it was assessed.
    assessed: Option<Duration>,
    /// The numbers and the assessment that are shown.
    snapshot: Arc<Snapshot>,
    assessment: Arc<Assessment>,
    pub(crate) shown: SourceView,
}

impl SourceMonitor {
    /// Of a session that ends by these goals.
    pub fn of(session: &Session, goals: Goals) -> Self {
        let (state, commands) = (session.state.clone(), session.commands.clone());
        let now = state.borrow().clone();
        let name = printable(now.name());
        let assessment = now.assessment();
        let result = SourceResult::new(now.facts(), Arc::clone(&now.snapshot), Arc::clone(&assessment), Parts::All);
        let shown = SourceView { goals: Arc::new(goals), ..SourceView::new(name, result) };
        Self { state, commands, began: Duration::ZERO, assessed: None, snapshot: now.snapshot, assessment, shown }
    }

    /// Takes what is new; whether anything was.
    pub(crate) fn look(&mut self, now: Duration, evaluation: &Evaluation) -> bool {
        let elapsed = now.saturating_sub(self.began);
        let state = self.state.borrow_and_update().clone();
        let shown = &mut self.shown;
        let is_new_second = elapsed.as_secs() != shown.elapsed.as_secs();
        shown.elapsed = elapsed;
        let phase = phase(&state);
        let facts = state.facts();
        let is_other_link = shown.result.source.link != facts.link;
        let changed = is_new_second || shown.phase != phase || is_other_link || shown.playback != state.playback;
        shown.phase = phase;
        shown.playback = state.playback;
        shown.faults.watch(&facts, now);
        shown.now = now;
        if Arc::ptr_eq(&state.snapshot, &self.snapshot) {
            shown.result.update(facts);
            return changed;
        }
        self.assessment = self.due_assessment(&state, now);
        let (snapshot, assessment) = (Arc::clone(&state.snapshot), Arc::clone(&self.assessment));
        let mut result = SourceResult::new(facts, snapshot, assessment, Parts::All);
        evaluation.judge(&mut result);
        self.shown.show(result);
        self.snapshot = state.snapshot;
        true
    }

    /// The present assessment, or for a while the one before: it is as expensive as many seconds of
    /// measuring, and in its first moments a record grows by a twentieth at every look.
    fn due_assessment(&mut self, state: &SourceState, now: Duration) -> Arc<Assessment> {
        const LASTS: Duration = Duration::from_secs(4);
        let fits = self.assessment.channels.len() == state.snapshot.channels.len()
            && self.snapshot.timing.samples <= state.snapshot.timing.samples
            && state.playback.is_none();
        let lasts = LASTS.min(now.saturating_sub(self.began) / 3);
        if fits && self.assessed.is_some_and(|assessed| now.saturating_sub(assessed) < lasts) {
            return Arc::clone(&self.assessment);
        }
        self.assessed = Some(now);
        state.assessment()
    }

    /// Sends a command to the session; the answer for the user, if there is one.
    pub(crate) fn command(&mut self, command: Command) -> Option<String> {
        if !matches!(self.state.borrow().stage, Stage::Measuring) {
            return Some("no measurement is running there".into());
        }
        let starts_over = command == Command::StartOver;
        if self.commands.try_send(command).is_err() {
            return Some("the source is busy: press the key again".into());
        }
        if starts_over && self.shown.no_measurement().is_none() {
            self.began += self.shown.elapsed;
        }
        None
    }
}

fn phase(state: &SourceState) -> SourcePhase {
    match &state.stage {
        Stage::Preparing => SourcePhase::Preparing,
        Stage::Measuring | Stage::Finishing => SourcePhase::Measuring,
        Stage::Ended(end) => {
            let result = state.result(Parts::WithoutSignals);
            let is_empty = result.timing.samples == 0 && !matches!(**end, End::GoalsDecided);
            let error = vn100_report::words::end(state.name(), end, result.link.framed_bytes, remedy_words);
            let error = error.or_else(|| is_empty.then(|| no_sample(&result)));
            SourcePhase::Ended(error.map(|error| printable(&error)))
        }
    }
}
