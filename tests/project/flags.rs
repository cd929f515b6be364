//! No text of a library names an option or a command: what a user can do is data there, and each
//! face calls it by its own names.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// The driver still names options in the causes of a lost link, the capture a command in an error.
const LIBRARIES: [&str; 6] =
    ["vn100-protocol", "imu-noise", "vn100-analysis", "vn100-pipeline", "vn100-report", "vn100-sim"];

/// The commands of the program.
const COMMANDS: [&str; 11] =
    ["attach", "compare", "completions", "configure", "info", "man", "plan", "ports", "record", "replay", "report"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(below).filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// The contents of all string literals, without those in comments.
fn literals(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut letters = code.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '/' if letters.peek() == Some(&'/') => {
                letters.by_ref().find(|letter| *letter == '\n');
            }
            // a quote as a character
            '\'' if letters.peek() == Some(&'"') => {
                letters.next();
            }
            '"' => {
                let mut literal = String::new();
                while let Some(letter) = letters.next().filter(|letter| *letter != '"') {
                    literal.push(letter);
                    literal.extend((letter == '\\').then(|| letters.next()).flatten());
                }
                found.push(literal);
            }
            _ => {}
        }
    }
    found
}

/// The option or the command that a text names.
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
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut read = 0;
    for library in LIBRARIES {
        for path in sources(&crates.join(library).join("src")) {
            for literal in literals(&fs::read_to_string(&path).unwrap()) {
                read += 1;
                assert_eq!(named(&literal), None, "{}: {literal}", path.display());
            }
        }
    }
    assert!(read > 1000, "{read} literals");
}

#[test]
fn what_names_an_option_or_a_command_is_found() {
    for (text, found) in [
        ("give --rate 40", Some("--rate 40")),
        ("(vn100 attach PORT)", Some("vn100 attach PORT)")),
        ("`vn100 configure", Some("vn100 configure")),
        ("a---b, -- c, x--y", None),
        ("vn100 1.0.0", None),
    ] {
        assert_eq!(named(text), found, "{text}");
    }
    let code = "a(\"x \\\" y\", '\"', \"z\") // \"not this\"\n/// \"nor this\"\nb(\"w\")";
    assert_eq!(literals(code), ["x \\\" y", "z", "w"]);
}
