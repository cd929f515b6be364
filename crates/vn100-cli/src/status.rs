//! What is told of live sources while they are measured: a line on stderr for each, or words for the view where there is one.

use std::{borrow::Cow, time::Duration};

use indicatif::{HumanBytes, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use vn100_driver::{LinkState, RecordingState, Up};
use vn100_pipeline::Snapshot;

use crate::{
    exit::{about, printable, report},
    view::Notices,
};

/// The lines of all sources. Where stderr is no terminal, only what befalls a link is written.
pub(crate) struct Status {
    lines: MultiProgress,
    /// Where words go while a view has the terminal.
    view: Option<Notices>,
}

impl Status {
    /// How often a line is worth writing anew.
    pub(crate) const PERIOD: Duration = Duration::from_millis(500);

    /// Lines on stderr, or none where a view takes what is to be told, or something `else_is_told` there all the time.
    pub(crate) fn new(view: Option<Notices>, else_is_told: bool) -> Self {
        let target = if view.is_some() || else_is_told {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(4)
        };
        Self { lines: MultiProgress::with_draw_target(target), view }
    }

    /// Tells something for good.
    pub(crate) fn report(&self, text: &str) {
        match &self.view {
            Some(view) => view.tell(text.to_owned()),
            None => self.suspend(|| report(text)),
        }
    }

    /// A line for the source of that name.
    pub(crate) fn line(&self, name: &str) -> StatusLine {
        let bar = self.lines.add(ProgressBar::no_length());
        // the default style stands in for a template it does not understand
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        StatusLine { bar, view: self.view.clone(), name: printable(name), told: None, failure_told: false }
    }

    /// Takes the lines away while `print` writes to the terminal.
    pub(crate) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.lines.suspend(print)
    }
}

/// The line of one source.
pub(crate) struct StatusLine {
    bar: ProgressBar,
    view: Option<Notices>,
    name: String,
    /// What of the link was last told for good.
    told: Option<LinkState>,
    failure_told: bool,
}

impl StatusLine {
    /// Shows where the source and its recording are, and tells what befell them.
    pub(crate) fn show(&mut self, link: Option<&LinkState>, recording: Option<&RecordingState>, snapshot: &Snapshot) {
        if let Some(state) = link {
            self.tell(state);
        }
        if let Some(RecordingState { path, error: Some(error), .. }) = recording
            && !self.failure_told
        {
            self.failure_told = true;
            let failure =
                format!("{}: RECORDING FAILED, {}: {error}; the measurement goes on", self.name, path.display());
            self.report(&failure);
        }
        let state = link.map_or("reading".into(), short_state);
        let recorded = recording.map_or(String::new(), |recording| match recording.error {
            Some(_) => "RECORDING FAILED  ".into(),
            None => format!("recorded {}  ", HumanBytes(recording.bytes)),
        });
        self.bar.set_message(format!("{}  {state}  {recorded}{}", self.name, counts(snapshot)));
        self.bar.tick();
    }

    /// Tells what befell the link, once: a link that is looked for fails again and again, and its first cause is the one that says why.
    pub(crate) fn tell(&mut self, state: &LinkState) {
        let is_lost = matches!(self.told, Some(LinkState::Down { .. }));
        let Some(event) = event(state).filter(|_| !(is_lost && matches!(state, LinkState::Down { .. }))) else {
            return;
        };
        if self.told.as_ref() != Some(state) {
            self.report(&about(&self.name, &event));
            self.told = Some(state.clone());
        }
    }

    fn report(&self, text: &str) {
        match &self.view {
            Some(view) => view.tell(text.to_owned()),
            None => self.bar.suspend(|| report(text)),
        }
    }
}

impl Drop for StatusLine {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What is worth a line of its own; the coming and going of single attempts is not.
fn event(state: &LinkState) -> Option<String> {
    match state {
        LinkState::Up(Up { port, baud, .. }) => {
            let speed = baud.map_or(String::new(), |baud| format!(" at {baud} baud"));
            Some(format!("connected to {port}{speed}"))
        }
        LinkState::Silent(_) => Some("the sensor is silent".into()),
        LinkState::Down { was_up: true, cause, .. } => Some(format!("lost: {cause}; trying again")),
        LinkState::Down { was_up: false, cause, .. } => Some(format!("not there yet: {cause}; trying again")),
        _ => None,
    }
}

fn short_state(state: &LinkState) -> Cow<'static, str> {
    match state {
        LinkState::Opening => "opening".into(),
        LinkState::Probing { baud: Some(baud), .. } => format!("listening at {baud} baud").into(),
        LinkState::Probing { baud: None, .. } => "listening".into(),
        LinkState::Up(Up { baud: Some(baud), .. }) => format!("{baud} baud").into(),
        LinkState::Up(_) => "connected".into(),
        LinkState::Silent(_) => "SILENT".into(),
        LinkState::Down { was_up: true, .. } => "LOST".into(),
        LinkState::Down { was_up: false, .. } => "not there yet".into(),
        _ => "ending".into(),
    }
}

fn counts(snapshot: &Snapshot) -> String {
    let timing = &snapshot.timing;
    format!(
        "{} samples in {:.0} s at {} Hz, {} bad lines, {} missing",
        timing.samples,
        timing.duration_s(),
        timing.rate_hz,
        snapshot.link.tally.bad.total(),
        timing.missing
    )
}
