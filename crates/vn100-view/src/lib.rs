//! The live view: what is measured, on the whole terminal, until the user quits.
//!
//! One thread has the terminal. It looks at the states of the sessions (`source.rs`), and draws
//! plain data (`draw.rs`) by what was chosen (`state.rs`). It waits for its terminal, and no
//! other thread waits for it.

mod draw;
mod faults;
mod keys;
mod messages;
mod panels;
mod question;
mod reference;
mod save;
mod scene;
mod source;
mod state;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;
mod units;

use std::{
    io,
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use draw::{draw, is_too_small};
use messages::ShownMessage;
use ratatui::crossterm::event::{Event, KeyEventKind};
use save::save;
use scene::Scene;
use source::SourceView;
use state::{ViewRequest, ViewState};
use terminal::{Screen, give_back_line, leave_screen, next_event};
use theme::Theme;
use thiserror::Error;
use tokio::{sync::oneshot, task::spawn_blocking, time::timeout};
use tokio_util::sync::CancellationToken;
use vn100_report::Evaluation;

pub use messages::MessageQueue;
pub use reference::{PendingReference, Reference};
pub use source::SourceMonitor;
pub use terminal::{give_back, is_there};
pub use theme::ThemeChoice;

/// A terminal that does not take the last words in this time is left.
const LEAVE_AFTER: Duration = Duration::from_secs(2);

/// The view, as long as it is shown. The terminal is given back when this is dropped.
pub struct View {
    close: CancellationToken,
    ended: oneshot::Receiver<Ended>,
    messages: MessageQueue,
}

impl View {
    /// Takes the terminal and shows the sources; `stop` is cancelled when the user quits.
    pub fn show(
        sources: Vec<SourceMonitor>,
        messages: MessageQueue,
        evaluation: Arc<Evaluation>,
        options: ViewOptions,
        stop: CancellationToken,
    ) -> Result<Self, ViewError> {
        let signals = TerminalSignals::listen().map_err(ViewError::Signals)?;
        let theme = Theme::of_terminal(options.theme);
        let screen = Screen::take().map_err(ViewError::Terminal)?;
        let close = CancellationToken::new();
        let shared = ViewContext { stop, close: close.clone(), signals, messages: messages.clone(), evaluation };
        let (sender, ended) = oneshot::channel();
        thread::Builder::new()
            .name("vn100-view".into())
            .spawn(move || {
                let mut state = ViewState::new(sources.len());
                state.page = options.page;
                let ended = run_view(screen, sources, state, theme, options.reference, &shared);
                // the program may have left without waiting
                let _ = sender.send(ended);
            })
            .map_err(ViewError::Thread)?;
        Ok(Self { close, ended, messages })
    }

    /// Shows until `work` is done; then gives the terminal back, and reports the queued messages. If
    /// the terminal disappears before, `alone` is called, and the work continues.
    pub async fn until<T>(mut self, work: impl Future<Output = T>, alone: impl FnOnce(), report: impl Fn(&str)) -> T {
        tokio::pin!(work);
        let result = tokio::select! {
            result = &mut work => {
                self.close.cancel();
                let is_left = if timeout(LEAVE_AFTER, &mut self.ended).await.is_err() {
                    // it draws still, or its terminal takes nothing. The result waits for that in any case, and belongs on the screen
                    // before, which is left once, after the last picture
                    give_back_line();
                    let _ = (&mut self.ended).await;
                    false
                } else {
                    give_back()
                };
                if !is_left {
                    let _ = spawn_blocking(leave_screen).await;
                }
                result
            }
            ended = &mut self.ended => {
                match ended {
                    Ok(Ended::TerminalGone) => alone(),
                    // the panic was reported
                    Ok(Ended::Closed) | Err(_) => report(FAULT),
                }
                give_back();
                work.await
            }
        };
        self.messages.take().iter().for_each(|message| report(message));
        result
    }
}

/// Why the view cannot be shown.
#[derive(Debug, Error)]
pub enum ViewError {
    /// The signals of the terminal cannot be listened to.
    #[error("cannot read the events of the terminal: {0}")]
    Signals(#[source] io::Error),
    /// The terminal refuses what a picture needs.
    #[error("cannot draw on the terminal: {0}; pipe the output through `cat` for plain text")]
    Terminal(#[source] io::Error),
    /// The system gives no thread.
    #[error("cannot start the thread of the live view: {0}")]
    Thread(#[source] io::Error),
}

/// What is chosen before it is shown.
#[derive(Debug, Default)]
pub struct ViewOptions {
    /// Colours.
    pub theme: ThemeChoice,
    /// An earlier record, drawn below the curves once it is measured.
    pub reference: Option<PendingReference>,
    /// The address of the live page.
    pub page: Option<String>,
}

const FAULT: &str = "internal error: the live view has ended; the measurement continues, Ctrl-C ends it";

impl Drop for View {
    fn drop(&mut self) {
        self.close.cancel();
        give_back();
    }
}

#[derive(Debug, Clone, Default)]
pub(crate) struct TerminalSignals {
    pub(crate) hung_up: CancellationToken,
    /// The program was stopped, and continues.
    pub(crate) continued: Arc<AtomicBool>,
}

impl TerminalSignals {
    /// Listens from now on. Once the terminal was hung up, that no longer ends the program.
    #[cfg(unix)]
    pub(crate) fn listen() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        let signals = Self::default();
        let received = signals.clone();
        let mut hangup = signal(SignalKind::hangup())?;
        let mut resumed = signal(SignalKind::from_raw(rustix::process::Signal::CONT.as_raw()))?;
        tokio::spawn(async move {
            let mut kept = None;
            loop {
                tokio::select! {
                    _ = hangup.recv() => {
                        received.hung_up.cancel();
                        kept = kept.or_else(|| terminal::quiet_input().ok());
                    }
                    _ = resumed.recv() => received.continued.store(true, Ordering::Relaxed),
                }
            }
        });
        Ok(signals)
    }

    #[cfg(not(unix))]
    pub(crate) fn listen() -> io::Result<Self> {
        Ok(Self::default())
    }
}

/// At most fifteen screens a second.
const FRAME: Duration = Duration::from_millis(67);

/// How often new results are read: numbers that change faster cannot be read by people.
const LOOK: Duration = Duration::from_millis(500);
/// The same in the first three seconds, when there is little to read and more of it each time.
pub const FIRST_LOOKS: Duration = Duration::from_millis(250);
const FIRST: Duration = Duration::from_secs(3);

fn look_period(elapsed: Duration) -> Duration {
    if elapsed < FIRST { FIRST_LOOKS } else { LOOK }
}

pub(crate) struct ViewContext {
    /// The view asks for the end.
    pub(crate) stop: CancellationToken,
    /// The program asks the view to end.
    pub(crate) close: CancellationToken,
    pub(crate) signals: TerminalSignals,
    pub(crate) messages: MessageQueue,
    pub(crate) evaluation: Arc<Evaluation>,
}

#[derive(Debug)]
pub(crate) enum Ended {
    Closed,
    TerminalGone,
}

/// Runs until it is closed, or the terminal is gone.
fn run_view(
    mut screen: Screen,
    mut monitors: Vec<SourceMonitor>,
    mut state: ViewState,
    theme: Theme,
    mut reference: Option<PendingReference>,
    shared: &ViewContext,
) -> Ended {
    let started = Instant::now();
    let mut shown: Vec<SourceView> = monitors.iter().map(|source| source.shown.clone()).collect();
    let mut dirty = true;
    let mut shown_message = ShownMessage::default();
    let mut drawn_at: Option<Instant> = None;
    let mut looked_at: Option<Instant> = None;
    loop {
        if shared.signals.hung_up.is_cancelled() {
            return Ended::TerminalGone;
        }
        if shared.close.is_cancelled() || !screen.is_ours() {
            return Ended::Closed;
        }
        if shared.signals.continued.swap(false, Ordering::Relaxed) {
            if screen.take_again().is_err() {
                return Ended::TerminalGone;
            }
            dirty = true;
        }
        if looked_at.is_none_or(|at| at.elapsed() >= look_period(started.elapsed())) {
            let looked = Instant::now();
            looked_at = Some(looked);
            let elapsed = started.elapsed();
            if let Some(Ok(measured)) = reference.as_mut().map(PendingReference::try_recv) {
                reference = None;
                match measured {
                    Ok(found) => {
                        monitors.iter_mut().for_each(|source| source.shown.reference = Some(Arc::clone(&found)))
                    }
                    Err(why) => state.message = Some(why),
                }
            }
            let changed =
                monitors.iter_mut().fold(false, |changed, source| source.look(elapsed, &shared.evaluation) | changed);
            if changed {
                shown = monitors.iter().map(|source| source.shown.clone()).collect();
                dirty = true;
            }
            // a question hides every message
            let visible = state.message.as_deref().filter(|_| state.question.is_none());
            if shown_message.is_over(visible, looked) {
                state.message = None;
                dirty = true;
            }
            if state.question.is_none()
                && shown_message.may_be_followed(looked)
                && let Some(message) = shared.messages.news()
            {
                (state.message, shown_message) = (Some(message), ShownMessage::default());
                dirty = true;
            }
        }
        if dirty && drawn_at.is_none_or(|at| at.elapsed() >= FRAME) {
            let scene = Scene { state: &state, sources: &shown, source: &shown[state.source], theme };
            match screen.draw(|frame| draw(frame, scene)) {
                Ok(area) => state.is_too_small = is_too_small((area.width, area.height)),
                Err(_) => return Ended::TerminalGone,
            }
            // from its end: a terminal that takes its time gets its time
            drawn_at = Some(Instant::now());
            dirty = false;
        }
        let frame = drawn_at.filter(|_| dirty).map(|at| FRAME.saturating_sub(at.elapsed()));
        let look = looked_at.map_or(Duration::ZERO, |at| look_period(started.elapsed()).saturating_sub(at.elapsed()));
        let request = match next_event(frame.map_or(look, |frame| frame.min(look))) {
            Ok(Some(Event::Key(key))) if key.kind != KeyEventKind::Release => {
                dirty = true;
                state.key(key, &shown)
            }
            Ok(Some(Event::Resize(width, height))) => {
                dirty = true;
                // a key may come before the picture does
                state.is_too_small = is_too_small((width, height));
                None
            }
            Ok(_) => None,
            Err(_) => return Ended::TerminalGone,
        };
        match request {
            Some(ViewRequest::Quit) => {
                state.message = Some("Ending: the result follows.".into());
                shared.stop.cancel();
            }
            Some(ViewRequest::Suspend) => {
                if screen.suspend(&shared.signals.continued).is_err() {
                    return Ended::TerminalGone;
                }
                dirty = true;
            }
            Some(ViewRequest::Save) => {
                let source = shown.get(state.source);
                state.message = source.map(|source| save(Path::new("."), &state, source, &shared.evaluation));
            }
            Some(ViewRequest::Control(command)) => {
                if let Some(source) = monitors.get_mut(state.source)
                    && let Some(answer) = source.command(command)
                {
                    state.message = Some(answer);
                }
            }
            None => {}
        }
    }
}
