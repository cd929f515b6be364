//! Output and end of the program: the exit codes scripts rely on, the one place that writes
//! results and errors, and the signals that end the data first and the program then.

use std::{
    io::{self, IsTerminal, Write},
    process::{self, ExitCode},
};

use anyhow::{Context, Result};
use clap::ColorChoice;
use serde::Serialize;
use tokio_util::sync::CancellationToken;
use vn100_analysis::Completion;
use vn100_report::{json_line, printable};

use vn100_view::give_back;

pub(crate) use vn100_report::words::about;

/// The exit code; 2 is also a wrong command line.
pub(crate) fn code(completion: Completion) -> ExitCode {
    ExitCode::from(match completion {
        Completion::Complete => 0,
        Completion::Failed => 1,
        Completion::NotGiven => 2,
        Completion::NoData => 3,
        Completion::NotMet => 4,
    })
}

pub(crate) fn report(message: &str) {
    // without stderr there is no other place to report to
    let _ = writeln!(io::stderr(), "vn100: {}", printable_lines(message));
}

/// Writes lines of text to standard output, at once, without anything that steers a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    write(&printable_lines(text))
}

/// Whether text on standard output is coloured.
pub(crate) fn is_coloured(color: ColorChoice) -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    match color {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            io::stdout().is_terminal()
                && !is_set("NO_COLOR")
                && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
        }
    }
}

/// Writes a JSON document and a line end to standard output, at once: indented on a terminal, else
/// in one line.
pub(crate) fn print_json(document: &impl Serialize) -> Result<()> {
    let is_read = io::stdout().is_terminal();
    let json = if is_read { serde_json::to_string_pretty(document) } else { serde_json::to_string(document) };
    write(&json_line(&json?))
}

/// The same in one line.
pub(crate) fn print_json_line(document: &impl Serialize) -> Result<()> {
    write(&json_line(&serde_json::to_string(document)?))
}

/// Writes text that is printable already, with the colours it has.
pub(crate) fn write(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write the result to standard output")
}

/// Reports a wrong command line, or prints the help that was asked for, and ends the program. The
/// text repeats the line, which is made printable like a file name: scripts pass on what they find.
pub(crate) fn usage(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        error.exit();
    }
    let text = printable_lines(&error.render().to_string());
    // without stderr there is no other place to report to
    let _ = write!(io::stderr(), "{text}");
    process::exit(error.exit_code())
}

/// What was written, or as much of it as the reader wanted: one that closes the output has seen
/// enough, and the outcome of the command stands.
pub(crate) fn unless_closed(written: Result<()>) -> Result<()> {
    written.or_else(|error| if is_broken_pipe(&error) { Ok(()) } else { Err(error) })
}

/// Whether the reader of the output has closed it: enough was seen.
pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

fn printable_lines(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

/// The code of a process that a signal has ended, less its number.
#[cfg(unix)]
const KILLED_BY_SIGNAL: i32 = 128;

/// The code of a process that Ctrl-C has ended.
const KILLED_BY_INTERRUPT: i32 = 130;

/// What handles a hang-up of the terminal, as at the end of a remote session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HangUp {
    /// It ends the data too; not under `nohup`.
    Stops,
    HandledByView,
    /// It ends nothing.
    Ignored,
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
        process::exit(KILLED_BY_INTERRUPT);
    });
    #[cfg(unix)]
    give_back_when_aborted().context("cannot listen to the signals that abort")?;
    Ok(stop)
}

/// A quit or an abort from outside ends the program at once, with the terminal as it was before.
#[cfg(unix)]
fn give_back_when_aborted() -> io::Result<()> {
    use rustix::process::Signal;
    use tokio::signal::unix::{SignalKind, signal};
    for aborts in [Signal::QUIT, Signal::ABORT] {
        let mut received = signal(SignalKind::from_raw(aborts.as_raw()))?;
        tokio::spawn(async move {
            received.recv().await;
            give_back();
            process::exit(KILLED_BY_SIGNAL + aborts.as_raw());
        });
    }
    Ok(())
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
        if hang_up == HangUp::Ignored {
            // what is listened to ends the program no more
            drop(signal(SignalKind::hangup())?);
        }
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
            // no signal exists on this system
            std::future::pending::<()>().await;
        }
    }
}
