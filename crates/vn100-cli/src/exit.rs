//! How the program speaks and ends: the exit codes scripts rely on, and the one place that writes results and errors.

use std::{
    io::{self, Write},
    process::ExitCode,
};

use anyhow::{Context, Result};

/// What became of a command, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Exit {
    /// All is well: 0.
    Good,
    /// It finished, but what `--until` asked for was not met: 4.
    NotMet,
    /// It could not be finished: 1.
    Failed,
    /// A source cannot be opened, or gave nothing valid: 3. (2 is a wrong command line.)
    NoData,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(match exit {
            Exit::Good => 0,
            Exit::NotMet => 4,
            Exit::Failed => 1,
            Exit::NoData => 3,
        })
    }
}

/// Tells the user of an error, on stderr.
pub(crate) fn report(message: &str) {
    // with stderr gone there is nobody left to tell
    let _ = writeln!(io::stderr(), "vn100: {}", printable(message));
}

/// Writes results to standard output, at once.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write the result to standard output")
}

/// Whether whoever read the output has left: enough was seen.
pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// The text without anything that steers a terminal: file names and captures are not ours.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}c\nd"), "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d");
    }
}
