//! Ctrl-C, a request to terminate, a terminal that hangs up: the first of them ends the data, the
//! second the program.

use std::io;

use anyhow::{Context, Result};
use tokio_util::sync::CancellationToken;

use crate::view::give_back;

/// The code of a process that Ctrl-C has ended.
const KILLED_BY_INTERRUPT: i32 = 130;

/// Who knows what to do when the terminal hangs up, as at the end of a remote session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HangUp {
    /// It ends the data too; not under `nohup`.
    Stops,
    /// The view.
    HandledByView,
}

/// Listens from now on, and gives the token that the first signal cancels.
pub(crate) fn stop_on_interrupt(hang_up: HangUp) -> Result<CancellationToken> {
    let stop = CancellationToken::new();
    let token = stop.clone();
    let mut signals = Signals::listen(hang_up).context("cannot listen to Ctrl-C")?;
    tokio::spawn(async move {
        signals.next().await;
        token.cancel();
        signals.next().await;
        give_back();
        std::process::exit(KILLED_BY_INTERRUPT);
    });
    Ok(stop)
}

#[cfg(unix)]
struct Signals {
    interrupt: tokio::signal::unix::Signal,
    terminate: tokio::signal::unix::Signal,
    hang_up: Option<tokio::signal::unix::Signal>,
}

#[cfg(unix)]
impl Signals {
    fn listen(hang_up: HangUp) -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        // a file that may not grow is an error of its write, and no reason to be killed
        drop(signal(SignalKind::from_raw(rustix::process::Signal::XFSZ.as_raw()))?);
        let stops = hang_up == HangUp::Stops && !hang_up_is_ignored();
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: stops.then(|| signal(SignalKind::hangup())).transpose()?,
        })
    }

    async fn next(&mut self) {
        let hang_up = async {
            match &mut self.hang_up {
                Some(signal) => signal.recv().await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
            _ = hang_up => {}
        }
    }
}

/// Whether this program was started to outlive its terminal, as by `nohup`; known on Linux only.
#[cfg(unix)]
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 << (rustix::process::Signal::HUP.as_raw() - 1) != 0)
}

#[cfg(not(unix))]
struct Signals;

#[cfg(not(unix))]
impl Signals {
    fn listen(_hang_up: HangUp) -> io::Result<Self> {
        Ok(Self)
    }

    async fn next(&mut self) {
        if tokio::signal::ctrl_c().await.is_err() {
            // nothing will ever come
            std::future::pending::<()>().await;
        }
    }
}
