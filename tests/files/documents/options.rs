//! Every option of the program in a document exists.

use std::collections::BTreeMap;

use super::shown::documents;
use crate::support::vn100;

/// Other programs: code that begins with one of them contains its options.
const OTHER_PROGRAMS: &[&str] = &["cargo", "python"];

/// Options of cargo, if they stand alone.
const OTHER_OPTIONS: &[&str] = &["--locked"];

/// The help of each command.
fn helps() -> BTreeMap<String, String> {
    let help = |words: &[&str]| {
        let output = vn100().args(words).arg("--help").output().unwrap();
        assert!(output.status.success(), "{words:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let commands = help(&[]);
    let name = |line: &str| Some(line.strip_prefix("  ")?.split(' ').next()?.to_owned());
    let names =
        commands.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    let names = names.filter_map(name).filter(|name| !name.is_empty() && name != "help");
    let helps = names.map(|name| (name.clone(), help(&[&name])));
    // the program itself has options as well
    helps.chain([("vn100".into(), commands.clone())]).collect()
}

fn has(help: &str, option: &str) -> bool {
    help.match_indices(option)
        .any(|(at, _)| !help[at + option.len()..].starts_with(|next: char| next.is_ascii_alphanumeric() || next == '-'))
}

/// Whether the word is a variable of the environment before a command.
fn is_variable(word: &str) -> bool {
    !word.starts_with('-') && word.contains('=')
}

#[test]
fn every_option_that_a_document_names_exists() {
    let helps = helps();
    assert!(helps.len() >= 16, "{:?}", helps.keys());
    let (mut found, mut missing) = (0, Vec::new());
    // the history names removed options
    for document in documents().into_iter().filter(|document| document.name != "CHANGELOG.md") {
        for span in document.spans() {
            let is_before = |word: &&str| *word == "vn100" || is_variable(word);
            let mut words = span.split_whitespace().skip_while(is_before).peekable();
            if words.peek().is_some_and(|first| OTHER_PROGRAMS.contains(first) || OTHER_OPTIONS.contains(first)) {
                continue;
            }
            let command = words.peek().and_then(|first| helps.get(*first));
            for word in words.filter(|word| word.starts_with("--") && word.len() > 2) {
                let option = word.split(['=', ',', '[']).next().unwrap();
                let exists = match command {
                    Some(help) => has(help, option),
                    None => helps.values().any(|help| has(help, option)),
                };
                found += 1;
                if !exists {
                    missing.push(format!("{}: `{span}`: {option}", document.name));
                }
            }
        }
    }
    assert!(found > 70, "{found} options");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
