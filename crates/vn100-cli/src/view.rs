//! The live view: what is measured, on the whole terminal, until the user quits.
//!
//! One thread has the terminal ([`task`]). It looks at the states of the sessions
//! ([`mod@source`]), and draws plain data ([`mod@draw`]) by what was chosen ([`state`]). It waits
//! for its terminal, and no other thread waits for it.

mod allan;
mod channels;
mod curve;
mod draw;
mod health;
mod keys;
mod parameters;
mod save;
mod source;
mod state;
mod task;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;
mod units;
mod warnings;

use std::{
    sync::{Arc, atomic::AtomicBool},
    thread,
    time::Duration,
};

use anyhow::{Context, Result, anyhow};
use tokio::{sync::oneshot, task::spawn_blocking, time::timeout};
use tokio_util::sync::CancellationToken;

pub(crate) use source::SourceMonitor;
pub(crate) use task::MessageQueue;
pub(crate) use terminal::{give_back, is_there};

use crate::exit::{print, report};
use task::{Ended, Shared, cannot_show};
use terminal::leave_screen;
use vn100_report::Evaluation;

/// A terminal that does not take the last words in this time is left.
const LEAVE_AFTER: Duration = Duration::from_secs(2);

/// The view, as long as it is shown. The terminal is given back when this is dropped.
pub(crate) struct View {
    close: CancellationToken,
    ended: oneshot::Receiver<Ended>,
    messages: MessageQueue,
}

impl View {
    /// Takes the terminal and shows the sources; `stop` is cancelled when the user quits.
    ///
    /// # Errors
    /// When the terminal cannot be set up.
    pub(crate) fn show(
        sources: Vec<SourceMonitor>,
        messages: MessageQueue,
        evaluation: Arc<Evaluation>,
        stop: CancellationToken,
    ) -> Result<Self> {
        let signals = Signals::listen().context("cannot listen to what the terminal tells")?;
        let screen = terminal::Screen::take().map_err(|error| anyhow!(cannot_show(&error)))?;
        let close = CancellationToken::new();
        let shared = Shared { stop, close: close.clone(), signals, messages: messages.clone(), evaluation };
        let (sender, ended) = oneshot::channel();
        let theme = theme::Theme::of_terminal();
        thread::Builder::new()
            .name("vn100-view".into())
            .spawn(move || {
                let ended = task::run(screen, sources, theme, &shared);
                // the program may have left without waiting
                let _ = sender.send(ended);
            })
            .context("cannot start the thread of the view")?;
        Ok(Self { close, ended, messages })
    }

    /// Shows until `work` is done; then gives the terminal back, with the last screen where that
    /// was asked for, and prints the queued messages. If the terminal disappears before, `alone` is
    /// called, and the work continues.
    ///
    /// # Errors
    /// That of the work.
    pub(crate) async fn until<T>(mut self, work: impl Future<Output = Result<T>>, alone: impl FnOnce()) -> Result<T> {
        tokio::pin!(work);
        let mut last = None;
        let done = tokio::select! {
            done = &mut work => {
                self.close.cancel();
                last = timeout(LEAVE_AFTER, &mut self.ended).await.ok();
                if !give_back() || last.is_none() {
                    // the result waits for the terminal in any case, and belongs on the screen before
                    if last.is_none() {
                        last = Some((&mut self.ended).await);
                    }
                    let _ = spawn_blocking(leave_screen).await;
                }
                done
            }
            ended = &mut self.ended => {
                match ended {
                    Ok(Ended::TerminalGone) => alone(),
                    // the panic was reported
                    Ok(Ended::Closed(_)) | Err(_) => report(FAULT),
                }
                give_back();
                work.await
            }
        };
        let screen = if let Some(Ok(Ended::Closed(screen))) = last { screen } else { None };
        self.messages.take().iter().for_each(|message| report(message));
        if let Some(screen) = screen {
            print(&screen)?;
        }
        done
    }
}

const FAULT: &str = "the view has ended by a fault of this program; the measurement goes on, Ctrl-C ends it";

impl Drop for View {
    fn drop(&mut self) {
        self.close.cancel();
        give_back();
    }
}

/// Signals about the terminal.
#[derive(Debug, Clone, Default)]
pub(crate) struct Signals {
    /// The terminal was hung up.
    pub(crate) hung_up: CancellationToken,
    /// The program was stopped, and continues.
    pub(crate) continued: Arc<AtomicBool>,
}

impl Signals {
    /// Listens from now on. Once the terminal was hung up, that no longer ends the program.
    ///
    /// # Errors
    /// When the signals cannot be listened to.
    ///
    /// # Panics
    /// Outside a tokio runtime.
    #[cfg(unix)]
    pub(crate) fn listen() -> std::io::Result<Self> {
        use std::sync::atomic::Ordering;
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

    /// There are none here.
    #[cfg(not(unix))]
    pub(crate) fn listen() -> std::io::Result<Self> {
        Ok(Self::default())
    }
}
