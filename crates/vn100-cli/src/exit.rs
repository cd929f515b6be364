//! How the program speaks and ends: the exit codes scripts rely on, and the one place that writes
//! results and errors.

use std::{
    io::{self, Write},
    process::{self, ExitCode},
};

use anyhow::{Context, Result};
use serde::Serialize;
use vn100_report::{Completion, json_line, printable};

/// The exit code; 2 is a wrong command line.
pub(crate) fn code(completion: Completion) -> ExitCode {
    ExitCode::from(match completion {
        Completion::Complete => 0,
        Completion::Failed => 1,
        Completion::NoData => 3,
        Completion::NotMet => 4,
    })
}

pub(crate) fn report(message: &str) {
    // without stderr there is no other place to report to
    let _ = writeln!(io::stderr(), "vn100: {}", printable(message));
}

/// Writes lines of text to standard output, at once, without anything that steers a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    write(&printable_lines(text))
}

/// Writes a JSON document and a line end to standard output, at once.
pub(crate) fn print_json(document: &impl Serialize) -> Result<()> {
    write(&json_line(&serde_json::to_string_pretty(document)?))
}

/// The same in one line.
pub(crate) fn print_json_line(document: &impl Serialize) -> Result<()> {
    write(&json_line(&serde_json::to_string(document)?))
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
