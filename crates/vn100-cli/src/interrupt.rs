//! Ctrl-C and a request to terminate: the first ends the data, the second the program.

use std::io;

use tokio_util::sync::CancellationToken;

use crate::view::give_back;

/// The code of a process that Ctrl-C has ended.
const KILLED_BY_INTERRUPT: i32 = 130;

/// Listens from now on, and gives the token that the first signal cancels.
///
/// # Errors
/// When the signals cannot be listened to.
///
/// # Panics
/// Outside a tokio runtime.
pub(crate) fn stop_on_interrupt() -> io::Result<CancellationToken> {
    let stop = CancellationToken::new();
    let token = stop.clone();
    let mut signals = Signals::listen()?;
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
}

#[cfg(unix)]
impl Signals {
    fn listen() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

#[cfg(not(unix))]
struct Signals;

#[cfg(not(unix))]
impl Signals {
    fn listen() -> io::Result<Self> {
        Ok(Self)
    }

    async fn next(&mut self) {
        if tokio::signal::ctrl_c().await.is_err() {
            // nothing will ever come
            std::future::pending::<()>().await;
        }
    }
}
