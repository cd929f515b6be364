//! The thread that has the terminal: listens to it, gathers what is shown, draws. No other thread
//! waits for it.

use std::{
    collections::VecDeque,
    io,
    sync::{Arc, Mutex, PoisonError, atomic::Ordering},
    time::{Duration, Instant},
};

use ratatui::{
    buffer::Buffer,
    crossterm::event::{Event, KeyEventKind},
};
use tokio_util::sync::CancellationToken;
use vn100_report::{Evaluation, printable};

use super::{
    Signals,
    draw::{Regions, Scene, draw},
    save::save,
    source::{Source, SourceMonitor},
    state::{Request, State, mouse},
    terminal::{Screen, next_event},
    theme::Theme,
};

/// At most fifteen screens a second.
const FRAME: Duration = Duration::from_millis(67);

/// How often new results are read: numbers that change faster cannot be read by people.
const LOOK: Duration = Duration::from_millis(250);

/// How long a message takes the place of the keys.
const MESSAGE_FOR: Duration = Duration::from_secs(6);

/// What the view shares with the program.
pub(crate) struct Shared {
    /// The view asks for the end.
    pub(crate) stop: CancellationToken,
    /// The program asks the view to end.
    pub(crate) close: CancellationToken,
    pub(crate) signals: Signals,
    pub(crate) messages: MessageQueue,
    pub(crate) evaluation: Arc<Evaluation>,
}

/// How the view ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// It was closed; with the last screen to be left on the terminal, if asked.
    Closed(Option<String>),
    /// The terminal is gone.
    TerminalGone,
}

/// Runs until it is closed, or the terminal is gone.
pub(crate) fn run(mut screen: Screen, mut monitors: Vec<SourceMonitor>, theme: Theme, shared: &Shared) -> Ended {
    let started = Instant::now();
    let mut state = State::new(monitors.len());
    let mut shown: Vec<Source> = monitors.iter().map(|source| source.shown.clone()).collect();
    let mut regions = Regions::default();
    let mut last_screen = None;
    let mut keep_screen = false;
    let mut dirty = true;
    let mut message_since: Option<Instant> = None;
    let mut drawn_at: Option<Instant> = None;
    let mut looked_at: Option<Instant> = None;
    loop {
        if shared.signals.hung_up.is_cancelled() {
            return Ended::TerminalGone;
        }
        if shared.close.is_cancelled() || !screen.is_ours() {
            let kept = last_screen.filter(|_| keep_screen);
            return Ended::Closed(kept.as_ref().map(text));
        }
        if shared.signals.continued.swap(false, Ordering::Relaxed) {
            if screen.take_again().is_err() {
                return Ended::TerminalGone;
            }
            dirty = true;
        }
        if looked_at.is_none_or(|at| at.elapsed() >= LOOK) {
            let looked = Instant::now();
            looked_at = Some(looked);
            let elapsed = started.elapsed();
            let changed =
                monitors.iter_mut().fold(false, |changed, source| source.look(elapsed, &shared.evaluation) | changed);
            if changed && !state.frozen {
                shown = monitors.iter().map(|source| source.shown.clone()).collect();
                dirty = true;
            }
            if let Some(message) = shared.messages.news() {
                state.message = Some(message);
                dirty = true;
            }
            message_since =
                message_since.filter(|_| state.message.is_some()).or_else(|| state.message.as_ref().map(|_| looked));
            if message_since.is_some_and(|at| at.elapsed() > MESSAGE_FOR) {
                state.message = None;
                dirty = true;
            }
        }
        if dirty && drawn_at.is_none_or(|at| at.elapsed() >= FRAME) {
            let scene = Scene { state: &state, sources: &shown, theme };
            match screen.draw(|frame| regions = draw(frame, scene)) {
                Ok(buffer) => last_screen = Some(buffer),
                Err(_) => return Ended::TerminalGone,
            }
            // from its end: a terminal that takes its time gets its time
            drawn_at = Some(Instant::now());
            dirty = false;
        }
        let frame = drawn_at.filter(|_| dirty).map(|at| FRAME.saturating_sub(at.elapsed()));
        let look = looked_at.map_or(Duration::ZERO, |at| LOOK.saturating_sub(at.elapsed()));
        let request = match next_event(frame.map_or(look, |frame| frame.min(look))) {
            Ok(Some(Event::Key(key))) if key.kind != KeyEventKind::Release => {
                dirty = true;
                state.key(key, &shown)
            }
            Ok(Some(Event::Mouse(event))) => {
                let request = mouse(event, &mut state, &regions, &shown);
                dirty |= request.is_some() || !matches!(event.kind, ratatui::crossterm::event::MouseEventKind::Moved);
                request
            }
            Ok(Some(Event::Resize(..))) => {
                dirty = true;
                None
            }
            Ok(_) => None,
            Err(_) => return Ended::TerminalGone,
        };
        match request {
            Some(Request::Quit { keep_screen: keep }) => {
                keep_screen = keep;
                state.message = Some("Ending: the result follows.".into());
                shared.stop.cancel();
            }
            Some(Request::Suspend) => {
                if screen.suspend().is_err() {
                    return Ended::TerminalGone;
                }
                dirty = true;
            }
            Some(Request::Save) => {
                let chosen = shown.get(state.source).zip(monitors.get(state.source));
                let saved = chosen.map(|(source, monitors)| {
                    save(&state, source, monitors.assess(&source.snapshot), &shared.evaluation)
                });
                state.message = saved;
            }
            Some(Request::Control(command)) => {
                if let Some(source) = monitors.get(state.source) {
                    state.message = source.command(command);
                }
            }
            None => {}
        }
    }
}

/// The screen as text.
fn text(buffer: &Buffer) -> String {
    let width = usize::from(buffer.area.width).max(1);
    let mut out = String::new();
    for row in buffer.content.chunks(width) {
        let line: String = row.iter().map(|cell| cell.symbol()).collect();
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// The error of a terminal that cannot be drawn on.
pub(crate) fn cannot_show(error: &io::Error) -> String {
    format!("the terminal cannot be drawn on: {error}; pipe the output through `cat` for text alone")
}

/// Messages that are kept until the end; the oldest are dropped first.
const MOST_MESSAGES: usize = 100;

/// What would be written to the terminal if it were free: shown in the view, and written when that
/// is over.
#[derive(Debug, Clone, Default)]
pub(crate) struct MessageQueue {
    messages: Arc<Mutex<Messages>>,
}

#[derive(Debug, Default)]
struct Messages {
    all: VecDeque<String>,
    seen: bool,
}

impl MessageQueue {
    /// Adds one.
    pub(crate) fn push(&self, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.all.len() == MOST_MESSAGES {
            messages.all.pop_front();
        }
        messages.all.push_back(message);
        messages.seen = false;
    }

    /// The latest, if it was not taken here before.
    pub(crate) fn news(&self) -> Option<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let seen = std::mem::replace(&mut messages.seen, true);
        if seen { None } else { messages.all.back().map(|message| printable(message)) }
    }

    /// All, to be written down.
    pub(crate) fn take(&self) -> Vec<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.all.drain(..).collect()
    }
}
