//! A short, seeded run of every fuzz target, on the stable compiler and without a tool, as part of
//! the gate.
//!
//! `VN100_FUZZ_CASES=1000000 cargo test --release -p vn100 --test fuzz` makes it a long one. The
//! search guided by coverage needs `cargo install cargo-fuzz`, and uses the seeds that `cargo test
//! -p vn100 --test fuzz -- --ignored` writes: `cargo fuzz run --fuzz-dir tests/fuzz -s none
//! framer`.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod mutate;
#[path = "../../crates/vn100/src/serve/mod.rs"]
#[allow(dead_code, reason = "the program uses all of it")]
mod serve;
mod targets;

use std::{fs, panic, path::Path};

use mutate::Mutator;
use targets::{TARGETS, Target};

/// Mutations of each target unless the environment sets another number.
const CASES: u64 = 700;

fn run(name: &str) {
    let Target { check, seeds, .. } = TARGETS.iter().find(|target| target.name == name).unwrap();
    let seeds = seeds();
    let cases = std::env::var("VN100_FUZZ_CASES").map_or(CASES, |cases| cases.parse().unwrap());
    let mut mutator = Mutator::new(name.len() as u64, &seeds);
    for case in 0..seeds.len() as u64 + cases {
        let input = seeds.get(case as usize).cloned().unwrap_or_else(|| mutator.next_input());
        let result = panic::catch_unwind(|| check(&input));
        assert!(result.is_ok(), "case {case} of {name}: b\"{}\"", input.escape_ascii());
    }
}

#[test]
fn framer() {
    run("framer");
}

#[test]
fn messages() {
    run("messages");
}

#[test]
fn packets() {
    run("packets");
}

#[test]
fn session() {
    run("session");
}

#[test]
fn captures() {
    run("captures");
}

#[test]
fn bags() {
    run("bags");
}

#[test]
fn timing() {
    run("timing");
}

#[test]
fn options() {
    run("options");
}

#[test]
fn requests() {
    run("requests");
}

#[test]
fn each_target_is_a_binary_of_the_fuzzer() {
    // the gate does not compile these
    let manifest =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/Cargo.toml")).unwrap();
    let binaries = manifest.split("[[bin]]").skip(1).map(|binary| binary.split('"').nth(1).unwrap());
    assert!(binaries.eq(TARGETS.iter().map(|target| target.name)), "tests/fuzz/Cargo.toml has other binaries");
}

#[test]
#[ignore = "writes the corpus that libFuzzer begins with"]
fn write_the_seeds() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/corpus");
    for target in TARGETS {
        let corpus = fuzz.join(target.name);
        fs::create_dir_all(&corpus).unwrap();
        for (index, seed) in (target.seeds)().iter().enumerate() {
            fs::write(corpus.join(format!("seed-{index}")), seed).unwrap();
        }
    }
}
