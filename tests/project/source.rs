//! The source files of all crates, and their text without string literals.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Every file in a folder `src` of a crate, with its path from the folder of all crates.
pub(crate) fn source_files() -> Vec<(String, String)> {
    let crates = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).canonicalize().unwrap();
    let mut files = Vec::new();
    for entry in fs::read_dir(&crates).unwrap() {
        let src = entry.unwrap().path().join("src");
        if src.is_dir() {
            collect(&src, &mut files);
        }
    }
    files.sort();
    assert!(files.len() > 200, "only {} source files", files.len());
    files
        .into_iter()
        .map(|path| {
            let name = path.strip_prefix(&crates).unwrap().to_str().unwrap().replace('\\', "/");
            (name, fs::read_to_string(&path).unwrap())
        })
        .collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The code and comments of a file: string literals are emptied, lines keep their numbers.
pub(crate) fn without_strings(text: &str) -> String {
    split_strings(text).0
}

/// The string literals of a file, each with the number of its first line, from 1.
pub(crate) fn strings(text: &str) -> Vec<(usize, String)> {
    split_strings(text).1
}

fn split_strings(text: &str) -> (String, Vec<(usize, String)>) {
    let (mut kept, mut strings) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let in_word = kept.chars().next_back().is_some_and(|last| last.is_alphanumeric() || last == '_');
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some((begin, end)) = string(rest).filter(|_| !in_word || next == '"') {
            let content = &rest[begin..end.0];
            strings.push((1 + kept.matches('\n').count(), content.to_owned()));
            kept.push_str("\"\"");
            kept.extend(content.chars().filter(|c| *c == '\n'));
            rest = &rest[end.1..];
            continue;
        } else if let Some(length) = character(rest) {
            length
        } else {
            next.len_utf8()
        };
        kept.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    (kept, strings)
}

/// The start and the end of the content of a string literal at the beginning of the text, and the
/// end of the literal.
fn string(text: &str) -> Option<(usize, (usize, usize))> {
    let prefix = text.find(|c| !matches!(c, 'b' | 'c' | 'r'))?;
    let is_raw = prefix > 0 && text[..prefix].ends_with('r');
    let hashes = if is_raw { text[prefix..].find(|c| c != '#')? } else { 0 };
    let begin = prefix + hashes + 1;
    if prefix > 2 || !text[prefix + hashes..].starts_with('"') {
        return None;
    }
    if is_raw {
        let end = format!("\"{}", "#".repeat(hashes));
        let at = begin + text[begin..].find(&end)?;
        return Some((begin, (at, at + end.len())));
    }
    let mut escaped = false;
    let at = text[begin..].find(|c| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    })?;
    Some((begin, (begin + at, begin + at + 1)))
}

/// The length of a character literal at the beginning of the text; a lifetime is none.
fn character(text: &str) -> Option<usize> {
    let mut chars = text.strip_prefix('\'')?.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        chars.next()?;
        let (at, _) = chars.find(|(_, c)| *c == '\'')?;
        return Some(1 + at + 1);
    }
    let (at, second) = chars.next()?;
    (second == '\'').then_some(1 + at + 1)
}

#[test]
fn string_literals_are_separated_from_code_and_comments() {
    let text = "let a = \"x\\\"y\"; // \"no\nf('\"', r#\"z\n\"#, b\"w\", 'life, '\\'', br\"v\")";
    assert_eq!(without_strings(text), "let a = \"\"; // \"no\nf('\"', \"\"\n, \"\", 'life, '\\'', \"\")");
    let strings: Vec<String> = strings(text).into_iter().map(|(line, text)| format!("{line} {text}")).collect();
    assert_eq!(strings, ["1 x\\\"y", "2 z\n", "3 w", "3 v"]);
}
