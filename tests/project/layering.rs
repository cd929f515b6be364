//! The code map's table of allowed imports, compared with the manifests.

use std::{collections::BTreeSet, fs, path::Path};

/// Crate, its allowed crates of this project, and its forbidden dependencies.
const RULES: &[(&str, &[&str], &[&str])] = &[
    ("vn100-protocol", &[], &["tokio", "tokio-util", "serialport", "clap", "tracing", "anyhow", "serde_json"]),
    ("imu-noise", &[], &["tokio", "tokio-util", "serialport", "clap", "tracing", "anyhow", "serde_json"]),
    ("vn100-capture", &["vn100-protocol"], &["serialport", "clap", "ratatui", "anyhow", "serde"]),
    ("vn100-driver", &["vn100-protocol", "vn100-capture"], &["clap", "ratatui", "anyhow", "serde"]),
    ("vn100-sim", &["vn100-protocol"], &["tokio", "tokio-util", "clap", "anyhow", "serde"]),
    (
        "vn100-analysis",
        &["vn100-protocol", "imu-noise"],
        &["tokio", "tokio-util", "serialport", "clap", "ratatui", "anyhow", "serde_json"],
    ),
    (
        "vn100-session",
        &["vn100-capture", "vn100-driver", "vn100-sim", "vn100-analysis"],
        &["serialport", "clap", "ratatui", "indicatif", "anyhow", "serde"],
    ),
    (
        "vn100-report",
        &["vn100-analysis"],
        &["tokio", "tokio-util", "serialport", "clap", "ratatui", "indicatif", "anyhow"],
    ),
    (
        "vn100-web",
        &["vn100-capture", "vn100-sim", "vn100-analysis", "vn100-report"],
        &["tokio", "tokio-util", "serialport", "clap", "ratatui", "indicatif", "anyhow"],
    ),
    (
        "vn100-view",
        &["vn100-protocol", "imu-noise", "vn100-analysis", "vn100-session", "vn100-report"],
        &["serialport", "anyhow", "maud"],
    ),
    (
        "vn100-python",
        &[
            "vn100-protocol",
            "vn100-capture",
            "imu-noise",
            "vn100-sim",
            "vn100-analysis",
            "vn100-session",
            "vn100-report",
        ],
        &["serialport", "clap", "ratatui", "indicatif", "anyhow"],
    ),
    (
        "vn100",
        &[
            "vn100-protocol",
            "vn100-capture",
            "vn100-driver",
            "imu-noise",
            "vn100-sim",
            "vn100-analysis",
            "vn100-session",
            "vn100-report",
            "vn100-view",
        ],
        &[],
    ),
];

fn crates() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn dependencies(name: &str) -> BTreeSet<String> {
    let text = fs::read_to_string(crates().join(name).join("Cargo.toml")).unwrap();
    let manifest: toml::Table = toml::from_str(&text).unwrap();
    let table = manifest["dependencies"].as_table().unwrap();
    table.keys().cloned().collect()
}

#[test]
fn every_crate_is_in_the_table() {
    let found: BTreeSet<_> = fs::read_dir(crates())
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().join("Cargo.toml").exists())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    let ruled: BTreeSet<_> = RULES.iter().map(|(name, ..)| (*name).to_owned()).collect();
    assert_eq!(found, ruled);
}

#[test]
fn crates_use_only_what_the_code_map_allows() {
    let ours: BTreeSet<_> = RULES.iter().map(|(name, ..)| *name).collect();
    for (name, allowed, banned) in RULES {
        for dependency in dependencies(name) {
            let foreign = !ours.contains(dependency.as_str());
            assert!(foreign || allowed.contains(&dependency.as_str()), "{name} must not use {dependency}");
            assert!(!banned.contains(&dependency.as_str()), "{name} must not use {dependency}");
        }
    }
}

#[test]
fn the_code_map_agrees() {
    let map = fs::read_to_string(crates().join("README.md")).unwrap();
    for (name, allowed, _) in RULES {
        let row = map
            .lines()
            .find(|line| line.starts_with(&format!("| `{name}` |")))
            .unwrap_or_else(|| panic!("no row for {name}"));
        let column = row.split('|').nth(3).unwrap();
        for ours in RULES.iter().map(|(other, ..)| other) {
            let said = column.contains(&format!("`{ours}`"));
            let all = column.trim() == "all";
            assert_eq!(said || (all && ours != name), allowed.contains(ours), "row of {name}, {ours}");
        }
    }
}

#[test]
fn the_code_map_has_fifty_terms_at_most() {
    let map = fs::read_to_string(crates().join("README.md")).unwrap();
    let (_, below) = map.split_once("## Terms").unwrap();
    let (table, _) = below.split_once("## Where to look").unwrap();
    let terms = table.lines().filter(|line| line.starts_with("| ")).skip(1).count();
    assert!((1..=50).contains(&terms), "{terms} terms, 50 at most");
}

#[test]
fn the_code_map_names_files_that_exist() {
    let map = fs::read_to_string(crates().join("README.md")).unwrap();
    let table = map.split_once("## Where to look").unwrap().1;
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("| ") && line.contains('`')).collect();
    assert!((1..=20).contains(&rows.len()), "{} rows, 20 at most", rows.len());
    for row in rows {
        let paths: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        // A later path of a row may be given from the folder of the first one.
        let folder = Path::new(paths[0]).parent().unwrap();
        for path in &paths {
            let exists = crates().join(path).exists() || crates().join(folder).join(path).exists();
            assert!(exists, "no {path}: {row}");
        }
    }
}
