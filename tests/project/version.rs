//! The version of the workspace, and the places that must repeat it.

use std::{fs, path::Path};

fn text(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file)).unwrap()
}

fn table(file: &str) -> toml::Table {
    toml::from_str(&text(file)).unwrap()
}

#[test]
fn every_place_repeats_the_version_of_the_workspace() {
    let workspace = table("Cargo.toml");
    let version = workspace["workspace"]["package"]["version"].as_str().unwrap();
    let crates = workspace["workspace"]["dependencies"].as_table().unwrap().iter();
    let crates: Vec<_> = crates.filter_map(|(name, asked)| asked.get("path").map(|_| (name, asked))).collect();
    assert_eq!(crates.len(), 9);
    for (name, asked) in crates {
        assert_eq!(asked.get("version").and_then(|version| version.as_str()), Some(version), "{name}");
    }
    assert_eq!(table("crates/vn100-python/Cargo.toml")["package"]["version"].as_str(), Some(version));
    assert!(text("CITATION.cff").lines().any(|line| line == format!("version: {version}")));
}
