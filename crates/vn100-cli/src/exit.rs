//! How the program speaks and ends: the exit codes scripts rely on, and the one place that writes
//! results and errors.

use std::{
    io::{self, Write},
    process::{self, ExitCode},
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

/// Writes lines of text to standard output, at once, without anything that steers a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    let text: String = text.chars().map(|c| if c == '\n' { c } else { shown(c) }).collect();
    write(&text)
}

/// Writes a JSON document and a line end to standard output, at once.
pub(crate) fn print_json(json: &str) -> Result<()> {
    write(&json_line(json))
}

/// A JSON document and a line end. What steers a terminal is escaped, so that the document means
/// the same: serde_json leaves DEL, the control characters above ASCII and those that turn the
/// direction of text as they are.
pub(crate) fn json_line(json: &str) -> String {
    let mut text = String::with_capacity(json.len() + 1);
    for c in json.chars() {
        // a line end stands between the values of a document, never within one
        if c != '\n' && steers(c) {
            // all of them are below U+10000
            text.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            text.push(c);
        }
    }
    text.push('\n');
    text
}

fn write(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write the result to standard output")
}

/// Tells of a wrong command line, or gives the help that was asked for, and ends the program. The
/// line is repeated in it, and is no more ours than a file name: scripts pass on what they find.
pub(crate) fn usage(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        error.exit();
    }
    let text = error.render().to_string();
    let text: String = text.chars().map(|c| if c == '\n' { c } else { shown(c) }).collect();
    // with stderr gone there is nobody left to tell
    let _ = write!(io::stderr(), "{text}");
    process::exit(error.exit_code())
}

/// Whether whoever read the output has left: enough was seen.
pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// The text in one line, with a mark for all that steers a terminal: file names, captures and what
/// a sensor says are not ours.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(shown).collect()
}

/// The text, with the source it is about before it where it does not name that itself.
pub(crate) fn about(name: &str, text: &str) -> String {
    let mut words = text.split_whitespace().map(|word| word.trim_end_matches([':', ';', ',']));
    if words.any(|word| word == name) { text.to_owned() } else { format!("{name}: {text}") }
}

fn shown(c: char) -> char {
    if steers(c) { char::REPLACEMENT_CHARACTER } else { c }
}

/// Control characters, ends of lines and paragraphs, and what turns the direction of text
/// (Unicode's property Bidi_Control): with these a name can look like another.
pub(crate) fn steers(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}c\nd"), "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d");
    }

    #[test]
    fn a_source_is_named_once() {
        let named = "cannot open /dev/ttyUSB0: there is no such port";
        assert_eq!(about("/dev/ttyUSB0", named), named);
        assert_eq!(about("/dev/ttyUSB", named), format!("/dev/ttyUSB: {named}"));
        assert_eq!(about("-", "no bytes came"), "-: no bytes came");
    }

    #[test]
    fn a_name_cannot_be_turned_round_to_look_like_another() {
        assert_eq!(printable("night\u{202e}pacm.exe\u{2066}\u{200f}"), "night\u{fffd}pacm.exe\u{fffd}\u{fffd}");
        assert_eq!(printable("größe 夜 שלום"), "größe 夜 שלום");
    }
}
