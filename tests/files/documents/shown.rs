//! The code in the documents: their code blocks, and the code within their text.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::support::workspace;

/// A Markdown file of the project.
pub(crate) struct Document {
    /// Its path in the workspace.
    pub(crate) name: String,
    text: String,
}

/// The lines between two fences.
pub(crate) struct Block {
    pub(crate) language: String,
    pub(crate) lines: Vec<String>,
}

/// Every Markdown file of the project.
pub(crate) fn documents() -> Vec<Document> {
    let root = workspace();
    let mut paths = below(&root);
    paths.sort();
    let document = |path: PathBuf| Document {
        name: path.strip_prefix(&root).unwrap().display().to_string(),
        text: fs::read_to_string(&path).unwrap(),
    };
    let documents: Vec<Document> = paths.into_iter().map(document).collect();
    assert!(documents.len() >= 15, "{} documents", documents.len());
    documents
}

fn below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        !name.starts_with('.') && name != "target"
    };
    let found = |path: PathBuf| if path.is_dir() { below(&path) } else { vec![path] };
    let is_document = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    entries.filter(is_ours).flat_map(found).filter(is_document).collect()
}

impl Document {
    /// Whether its commands are for the reader, and not a record of the past.
    pub(crate) fn is_to_be_followed(&self) -> bool {
        !["BENCHMARKS.md", "CHANGELOG.md", "RELIABILITY.md"].contains(&&*self.name)
    }

    pub(crate) fn blocks(&self) -> Vec<Block> {
        let fenced = self.text.split("\n```").skip(1).step_by(2);
        fenced
            .map(|block| {
                let (language, lines) = block.split_once('\n').unwrap();
                Block { language: language.to_owned(), lines: lines.lines().map(str::to_owned).collect() }
            })
            .collect()
    }

    /// Code within the text, in a line of its own each.
    pub(crate) fn spans(&self) -> Vec<String> {
        let text: String = self.text.split("\n```").step_by(2).collect();
        let spans = text.split('`').skip(1).step_by(2);
        spans.map(|span| span.replace("\\|", "|").split_whitespace().collect::<Vec<_>>().join(" ")).collect()
    }
}
