//! No text of a library names an option or a command: remedies are data there, and each face words
//! them with its own names.

use crate::source::{source_files, strings};

/// The program and its words, which name them.
const FACES: [&str; 4] = ["vn100/", "vn100-view/", "vn100-report/src/words.rs", "vn100-report/src/remedies.rs"];

const COMMANDS: [&str; 14] = [
    "attach",
    "compare",
    "completions",
    "configure",
    "explain",
    "info",
    "man",
    "plan",
    "ports",
    "record",
    "replay",
    "report",
    "schema",
    "selftest",
];

fn named(text: &str) -> Option<&str> {
    let is_command = |rest: &str| COMMANDS.iter().any(|command| rest.starts_with(command));
    let option = text.match_indices("--").find(|(at, _)| {
        let before = text[..*at].chars().next_back();
        let after = text[at + 2..].chars().next();
        before.is_none_or(|letter| !letter.is_alphanumeric() && letter != '-')
            && after.is_some_and(|letter| letter.is_ascii_lowercase())
    });
    let command = text.match_indices("vn100 ").find(|(at, name)| is_command(&text[at + name.len()..]));
    option.or(command).map(|(at, _)| &text[at..])
}

#[test]
fn no_library_names_an_option_or_a_command() {
    let mut read = 0;
    for (name, text) in source_files() {
        if FACES.iter().any(|face| name.starts_with(face)) {
            continue;
        }
        for (line, literal) in strings(&text) {
            read += 1;
            assert_eq!(named(&literal), None, "{name}:{line}: {literal}");
        }
    }
    assert!(read > 1000, "{read} literals");
}

#[test]
fn texts_that_name_an_option_or_a_command_are_found() {
    for (text, found) in [
        ("give --rate 40", Some("--rate 40")),
        ("(vn100 attach PORT)", Some("vn100 attach PORT)")),
        ("`vn100 configure", Some("vn100 configure")),
        ("a---b, -- c, x--y", None),
        ("vn100 1.0.0", None),
    ] {
        assert_eq!(named(text), found, "{text}");
    }
}
