//! Output and end of the program: the exit codes scripts rely on, the one place that writes
//! results and errors, and the signals that end the data first and the program then.

use std::{
    io::{self, IsTerminal, Write},
    process::{self, ExitCode},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
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

/// Listens from now on, and gives the token that the first signal cancels; the second one ends the
/// program.
pub(crate) fn stop_on_interrupt(hang_up: HangUp) -> Result<CancellationToken> {
    let stop = CancellationToken::new();
    let (token, is_second) = (stop.clone(), AtomicBool::new(false));
    let interrupt = move || {
        if is_second.swap(true, Ordering::Relaxed) {
            give_back();
            process::exit(KILLED_BY_INTERRUPT);
        }
        token.cancel();
    };
    listen(hang_up, Arc::new(interrupt)).context("cannot listen to Ctrl-C")?;
    Ok(stop)
}

/// Calls `interrupt` at each signal that ends the data. A quit or an abort from outside ends the
/// program at once, with the terminal as it was before.
#[cfg(unix)]
fn listen(hang_up: HangUp, interrupt: Arc<dyn Fn() + Send + Sync>) -> io::Result<()> {
    use rustix::process::Signal;
    // a file that may not grow is an error of its write, and no reason to be killed
    at_each(Signal::XFSZ, || {})?;
    for signal in [Signal::INT, Signal::TERM] {
        let interrupt = Arc::clone(&interrupt);
        at_each(signal, move || interrupt())?;
    }
    match hang_up {
        HangUp::Stops if !hang_up_is_ignored() => at_each(Signal::HUP, move || interrupt())?,
        HangUp::Ignored => at_each(Signal::HUP, || {})?,
        HangUp::Stops | HangUp::HandledByView => {}
    }
    for aborts in [Signal::QUIT, Signal::ABORT] {
        at_each(aborts, move || {
            give_back();
            process::exit(KILLED_BY_SIGNAL + aborts.as_raw());
        })?;
    }
    Ok(())
}

/// Calls `then` at each signal of this kind, which ends the program no more.
#[cfg(unix)]
fn at_each(signal: rustix::process::Signal, then: impl Fn() + Send + 'static) -> io::Result<()> {
    use tokio::signal::unix::{SignalKind, signal as received};
    let mut received = received(SignalKind::from_raw(signal.as_raw()))?;
    tokio::spawn(async move {
        while received.recv().await.is_some() {
            then();
        }
    });
    Ok(())
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
fn listen(_hang_up: HangUp, interrupt: Arc<dyn Fn() + Send + Sync>) -> io::Result<()> {
    tokio::spawn(async move {
        while tokio::signal::ctrl_c().await.is_ok() {
            interrupt();
        }
    });
    Ok(())
}
