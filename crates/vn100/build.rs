//! Tells the program which commit it is built from, where that is known.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=VN100_COMMIT");
    // a package may say it; a checkout knows it; elsewhere it stays unknown
    let said = std::env::var("VN100_COMMIT").ok();
    let commit = said.or_else(|| git(&["rev-parse", "--short=12", "HEAD"])).unwrap_or_default();
    println!("cargo::rustc-env=VN100_COMMIT={commit}");
    let release = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let version = if commit.is_empty() { release } else { format!("{release} ({commit})") };
    println!("cargo::rustc-env=VN100_VERSION={version}");
    match git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        // grows with every commit
        Some(log) => println!("cargo::rerun-if-changed={log}"),
        None => println!("cargo::rerun-if-changed=build.rs"),
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}
