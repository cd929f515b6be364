//! Words that the project no longer uses, kept out of code, comments, messages and documents.

use std::{
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use crate::{
    readme::documents,
    source::{source_files, strings, without_strings},
};

/// A word or phrase, what stands for it now, and where it may still stand.
struct Retired {
    /// Words in lower case; a last one that ends in `*` stands for all that begin so.
    phrase: Vec<String>,
    instead: String,
    /// Beginnings of the names of files in which they may stand.
    allowed_files: Vec<String>,
    /// Longer phrases in which the words mean something else.
    allowed_phrases: Vec<Vec<String>>,
}

impl Retired {
    /// A row of the file: words, what stands for them, and where they are allowed.
    fn parse(row: &str) -> Self {
        let mut columns = row.split('|').map(str::trim);
        let phrase = columns.next().unwrap().split(' ').map(str::to_owned).collect();
        let instead = columns.next().unwrap_or_else(|| panic!("no replacement: {row}")).to_owned();
        let allowed = columns.next().unwrap_or_default().split(',').map(str::trim).filter(|text| !text.is_empty());
        let (files, phrases): (Vec<&str>, Vec<&str>) = allowed.partition(|text| text.contains('/'));
        let allowed_files = files.into_iter().map(str::to_owned).collect();
        Self { phrase, instead, allowed_files, allowed_phrases: phrases.into_iter().map(words).collect() }
    }
}

/// The rows of `retired-words.txt`.
fn retired() -> Vec<Retired> {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/project/retired-words.txt"));
    let text = fs::read_to_string(file).unwrap();
    text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(Retired::parse).collect()
}

/// The words of a line in lower case: `RowCounter`, `row_counter` and `row counter` are the same.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in line.chars() {
        let begins = c.is_uppercase() && (before.is_lowercase() || before.is_numeric());
        if !c.is_alphanumeric() || begins {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().unwrap().extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

fn is_at(phrase: &[String], words: &[String]) -> bool {
    phrase.len() <= words.len()
        && phrase.iter().zip(words).all(|(wanted, word)| match wanted.strip_suffix('*') {
            Some(beginning) => word.starts_with(beginning),
            None => word == wanted,
        })
}

/// Whether the phrase stands in a line outside the phrases that are allowed.
fn stands_in(retired: &Retired, line: &[String]) -> bool {
    let mut at = 0;
    while at < line.len() {
        let allowed = retired.allowed_phrases.iter().filter(|phrase| is_at(phrase, &line[at..]));
        match allowed.map(Vec::len).max() {
            Some(length) => at += length,
            None if is_at(&retired.phrase, &line[at..]) => return true,
            None => at += 1,
        }
    }
    false
}

/// Where a retired word stands in these lines of a file.
fn found_in(name: &str, lines: impl Iterator<Item = (usize, String)>, retired: &[Retired]) -> Vec<String> {
    let is_here = |word: &&Retired| !word.allowed_files.iter().any(|file| name.starts_with(file.as_str()));
    let here: Vec<&Retired> = retired.iter().filter(is_here).collect();
    let mut found = Vec::new();
    for (number, line) in lines {
        let line_words = words(&line);
        for word in here.iter().filter(|word| stands_in(word, &line_words)) {
            let (phrase, instead) = (word.phrase.join(" "), &word.instead);
            found.push(format!("{name}:{number}: \"{phrase}\", say {instead}: {}", line.trim()));
        }
    }
    found
}

#[test]
fn retired_words_are_gone_from_code_and_comments() {
    let retired = retired();
    assert!((1..=60).contains(&retired.len()), "{} retired words, 60 at most", retired.len());
    let mut found = Vec::new();
    for (name, text) in source_files() {
        let lines = without_strings(&text);
        found.extend(found_in(&name, (1..).zip(lines.lines().map(str::to_owned)), &retired));
    }
    assert!(found.is_empty(), "{} retired words:\n{}", found.len(), found.join("\n"));
}

#[test]
fn retired_words_are_gone_from_messages() {
    let retired = retired();
    let (mut read, mut found) = (0, Vec::new());
    for (name, text) in source_files() {
        // one word alone may be a code, which is a contract
        let texts: Vec<(usize, String)> = strings(&text).into_iter().filter(|(_, text)| text.contains(' ')).collect();
        read += texts.len();
        found.extend(found_in(&name, texts.into_iter(), &retired));
    }
    assert!(read > 2000, "{read} texts");
    assert!(found.is_empty(), "{} retired words:\n{}", found.len(), found.join("\n"));
}

/// The files that users read as they are: documents, the parts of the page, schemas, data sheets.
fn shown_files() -> Vec<PathBuf> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let (report, page) = (root.join("crates/vn100-report"), root.join("crates/vn100-page"));
    let more = [root.join("replay-logs"), page.join("assets"), report.join("schemas"), report.join("datasheets")];
    let more = more.iter().flat_map(|folder| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    let is_text = |path: &PathBuf| {
        let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        ["md", "js", "css", "toml"].contains(&ending) || path.ends_with("schemas/analysis.json")
    };
    documents().into_iter().chain(more).filter(is_text).collect()
}

/// The line without names of tests, keys and codes: what stands in backquotes, and all of a schema
/// but its descriptions.
fn without_code(name: &str, line: &str) -> String {
    if name.ends_with(".json") {
        return line.split_once("\"description\": \"").map_or("", |(_, rest)| rest.split('"').next().unwrap()).into();
    }
    line.split('`').step_by(2).collect::<Vec<_>>().join(" ")
}

#[test]
fn retired_words_are_gone_from_documents() {
    let retired = retired();
    let files = shown_files();
    assert!(files.len() >= 15, "{files:?}");
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let name = file.strip_prefix(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).unwrap().to_str().unwrap();
        found.extend(found_in(name, (1..).zip(text.lines().map(|line| without_code(name, line))), &retired));
    }
    assert!(found.is_empty(), "{} retired words:\n{}", found.len(), found.join("\n"));
}

#[test]
fn words_are_found_in_names_and_phrases() {
    let retired = |phrase: &str, allowed: &str| Retired::parse(&format!("{phrase} | another | {allowed}"));
    let stands = |word: &Retired, line: &str| stands_in(word, &words(line));
    assert!(stands(&retired("told", ""), "fn is_told_over() {"));
    assert!(stands(&retired("wish*", ""), "enum PaceWishes {"));
    assert!(stands(&retired("set aside", ""), "self.set_aside(held)"));
    assert!(!stands(&retired("told", "told apart"), "they cannot be told apart"));
    assert!(stands(&retired("told", "told apart"), "told apart, or told"));
    assert!(!stands(&retired("odd", ""), "an oddity"));
}
