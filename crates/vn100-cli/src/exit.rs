//! How the program ends: the exit codes scripts rely on, and the one place that writes errors for people.

use std::{
    io::{self, Write},
    process::ExitCode,
};

/// What became of a command, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Exit {
    /// All is well: 0.
    Good,
    /// It could not be finished: 1.
    Failed,
    /// A source cannot be opened, or gave nothing valid: 3. (2 is a wrong command line.)
    NoData,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(match exit {
            Exit::Good => 0,
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
