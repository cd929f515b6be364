//! The README is short, begins with a picture, and every link of the documentation has a target.

use std::{
    fs,
    path::{Path, PathBuf},
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The Markdown files of the project: in its root and `docs`, and the code map.
fn documents() -> Vec<PathBuf> {
    let of = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>();
    let mut all = of(root());
    all.extend(of(root().join("docs")));
    all.extend(of(root().join("crates")));
    all.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    all
}

/// Targets of links and pictures within the project.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split([')', '#']).next())
        .filter(|target| !target.is_empty() && !target.contains("://") && !target.contains(' '))
}

#[test]
fn every_link_leads_to_a_file() {
    let documents = documents();
    assert!(documents.len() >= 8, "{documents:?}");
    for document in documents {
        let text = fs::read_to_string(&document).unwrap();
        for target in targets(&text) {
            assert!(document.parent().unwrap().join(target).exists(), "{}: {target}", document.display());
        }
    }
}

#[test]
fn the_readme_is_read_in_five_minutes_and_begins_with_a_picture() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let words = text.split_whitespace().count();
    assert!(words <= 800, "{words} words");
    let picture = text.lines().position(|line| line.starts_with("![")).unwrap();
    assert!(picture < 10, "the first picture is in line {}", picture + 1);
    for term in ["angle random walk", "bias instability", "rate random walk"] {
        assert!(text.lines().take(6).any(|line| line.contains(term)), "no {term} at the beginning");
    }
}
