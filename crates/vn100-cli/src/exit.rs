//! How the program speaks and ends: the exit codes scripts rely on, and the one place that writes
//! results and errors.

use std::{
    io::{self, Write},
    process::{self, ExitCode},
};

use anyhow::{Context, Result};
use vn100_report::{Completion, json_line, printable};

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

impl From<Completion> for Exit {
    fn from(completion: Completion) -> Self {
        match completion {
            Completion::Complete => Self::Good,
            Completion::NotMet => Self::NotMet,
            Completion::Failed => Self::Failed,
            Completion::NoData => Self::NoData,
        }
    }
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

/// Reports an error on stderr.
pub(crate) fn report(message: &str) {
    // without stderr there is no other place to report to
    let _ = writeln!(io::stderr(), "vn100: {}", printable(message));
}

/// Writes lines of text to standard output, at once, without anything that steers a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    write(&printable_lines(text))
}

/// Writes a JSON document and a line end to standard output, at once.
pub(crate) fn print_json(json: &str) -> Result<()> {
    write(&json_line(json))
}

fn write(text: &str) -> Result<()> {
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

/// Whether the reader of the output has closed it: enough was seen.
pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// The text, with the source it is about before it where it does not name that itself.
pub(crate) fn about(name: &str, text: &str) -> String {
    let mut words = text.split_whitespace().map(|word| word.trim_end_matches([':', ';', ',']));
    if words.any(|word| word == name) { text.to_owned() } else { format!("{name}: {text}") }
}

fn printable_lines(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_named_once() {
        let named = "cannot open /dev/ttyUSB0: there is no such port";
        assert_eq!(about("/dev/ttyUSB0", named), named);
        assert_eq!(about("/dev/ttyUSB", named), format!("/dev/ttyUSB: {named}"));
        assert_eq!(about("-", "no bytes came"), "-: no bytes came");
    }
}
