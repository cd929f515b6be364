//! The glossary of results: each code and parameter in words, what it means, why it matters, what
//! to do, and where it is defined.

mod codes;
mod filters;
mod parameters;
mod summary;

use vn100_analysis::{Remedy, RemedyWords, WarningKind};

use crate::codes::meanings_of;
use crate::warnings::{WarningWords, actions, warning_words};

/// The entry of the glossary for one code.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Explanation {
    /// The kind of code, as a title.
    pub group: &'static str,
    /// The code, as results spell it.
    pub code: String,
    /// Other names by which the entry is found.
    pub aliases: Vec<&'static str>,
    /// The name or the word of the code, with symbol and slope, or severity.
    pub title: String,
    /// The meaning, in sentences.
    pub meaning: String,
    /// Why it matters, in sentences.
    pub why: &'static str,
    /// What to do, in sentences; may be empty.
    pub advice: &'static str,
    /// What this program has for it.
    pub remedies: &'static [Remedy],
    /// The standard or manual that defines the code; empty for codes of this program alone.
    pub source: &'static str,
}

impl Explanation {
    /// What to do, with the remedies in the words of a face.
    pub fn advice(&self, words: RemedyWords) -> String {
        let advice = (!self.advice.is_empty()).then(|| self.advice.to_owned());
        advice.into_iter().chain(actions(self.remedies, words)).collect::<Vec<_>>().join(" ")
    }
}

/// All entries, parameters first.
pub fn glossary() -> Vec<Explanation> {
    let mut all = parameters::explanations();
    all.extend(WarningKind::ALL.into_iter().zip(meanings_of::<WarningKind>()).map(of_warning));
    all.extend(codes::explanations());
    all.extend(summary::explanations());
    all.extend(filters::explanations());
    all
}

/// The entries for a code or a name, in any letter case. A code of several groups has several
/// entries; an unknown one has none.
pub fn explain(code: &str) -> Vec<Explanation> {
    let wanted = plain(code);
    let mut found = glossary();
    found.retain(|entry| plain(&entry.code) == wanted || entry.aliases.iter().any(|name| plain(name) == wanted));
    found
}

/// In lower case, words joined by hyphens.
fn plain(code: &str) -> String {
    code.trim().to_lowercase().replace([' ', '_'], "-")
}

fn of_warning((kind, (code, meaning)): (WarningKind, (String, String))) -> Explanation {
    let WarningWords { why, advice, remedies, source } = warning_words(kind);
    let title = kind.severity().name().into();
    Explanation { group: "Warnings", code, aliases: Vec::new(), title, meaning, why, advice, remedies, source }
}

/// A code with its aliases; its title; in sentences what it means, why it matters and what to do; its
/// remedies and its source.
type Entry =
    ((&'static str, &'static [&'static str]), &'static str, [&'static str; 3], &'static [Remedy], &'static str);

fn entry(group: &'static str, entry: Entry) -> Explanation {
    let ((code, aliases), title, [meaning, why, advice], remedies, source) = entry;
    let (code, title, meaning) = (code.into(), title.into(), meaning.into());
    Explanation { group, code, aliases: aliases.to_vec(), title, meaning, why, advice, remedies, source }
}

#[cfg(test)]
mod tests;
