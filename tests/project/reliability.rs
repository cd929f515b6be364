//! Every test that `RELIABILITY.md` names exists.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// All Rust files in a folder and its subfolders.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(below).filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

#[test]
fn every_test_in_the_fault_table_exists() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = fs::read_to_string(workspace.join("RELIABILITY.md")).unwrap();
    let folders = ["crates", "tests"].map(|folder| sources(&workspace.join(folder)));
    let code: String = folders.iter().flatten().map(|path| fs::read_to_string(path).unwrap()).collect();
    let is_test = |name: &&str| {
        name.matches('_').count() >= 2 && name.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_'))
    };
    let named: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_test).collect();
    assert!(named.len() > 50, "{} tests are named", named.len());
    let missing: Vec<_> = named.iter().filter(|name| !code.contains(&format!("fn {name}("))).collect();
    assert!(missing.is_empty(), "no such test: {missing:?}");
    // each fault has a test
    let faults = text
        .lines()
        .filter(|line| line.starts_with("| ") && line.matches(" | ").count() == 3 && !line.contains("| test |"));
    for fault in faults {
        assert!(
            fault.rsplit(" | ").next().unwrap().split('`').skip(1).step_by(2).any(|name| is_test(&name)),
            "{fault}"
        );
    }
}
