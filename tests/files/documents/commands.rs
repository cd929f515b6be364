//! Every command line in a document is run, in a folder with the files that it reads. A block is
//! run line by line, so that a line finds the files of earlier lines.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
    sync::Mutex,
    thread,
};

use tempfile::TempDir;

use super::{
    captures,
    shown::{Document, documents},
};
use crate::support::{interrupted_after, run, workspace};

/// Lines that are not run, with the reason. The targets of cargo in them must exist nevertheless.
const NOT_RUN: &[(&str, &str)] = &[
    ("cargo test", "this test is one of them"),
    (".ci/run", "this test is part of it"),
    ("VN100_WRITE=1 cargo test", "it writes a document"),
    ("cargo install --locked --path crates/vn100", "a build"),
    ("cargo bench", "minutes of measuring"),
    ("cargo run -p vn100-sim --example replay_logs", "a test compares what it writes"),
    ("vn100 replay reference.vnimu --rate 40", "a test compares what it measures"),
    (".ci/package", "a build, with the packages of one distribution"),
    (".ci/archive", "a build for another system"),
    ("pip install .", "a build, made by the gate"),
    ("ssh -L", "another machine"),
];

/// Replacements: ports become emulated sensors, and names of the reader's files become names of
/// existing files.
const STANDS_FOR: &[(&str, &str)] = &[
    ("/dev/ttyUSB0", "sim"),
    ("/dev/ttyUSB1", "sim"),
    ("tcp://bench:2000", "sim"),
    ("SOURCE", "sim"),
    ("/tmp/sensor", "sensor"),
    ("/usr/bin/vn100", "vn100"),
    ("/var/lib/vn100/night.mcap", "night.mcap"),
    ("FILE", "FILE.mcap"),
    ("CODE", "ARW"),
    ("NAME", "FILE.mcap"),
    ("COMMAND", "replay"),
    ("--serve", "--serve=:0"),
    ("--serve=:8101", "--serve=:0"),
];

/// Commands that do not succeed here, with their exit code and output.
const OTHER_ENDS: &[(&str, i32, &str)] = &[
    ("vn100 replay unit*.mcap --fail-on 'gyro B'", 4, ""),
    ("vn100 selftest --published FOLDER", 1, "FOLDER: No such file or directory"),
    ("vn100 replay FILE --speed 1x", 1, "--speed needs the live view, and that a terminal"),
];

/// The duration of a live measurement here, and that of a generated record without a known digest.
const LIVE: &str = "1s";
const GENERATED: &str = "10min";
const WITH_DIGEST: &str = "reference.vnimu";

/// Options whose value is a file to be written.
const WRITES: &[&str] = &["-o", "--record", "--samples"];

/// The lines of a script, and its place.
struct Script {
    document: String,
    lines: Vec<String>,
}

/// The command lines of the documents.
fn scripts() -> Vec<Script> {
    let mut scripts = Vec::new();
    for document in documents() {
        let mut add = |lines| scripts.push(Script { document: document.name.clone(), lines });
        for block in document.blocks() {
            let command = |line: &String| match &*block.language {
                "sh" if line.is_empty() || line.starts_with('#') => None,
                "sh" => Some(line.clone()),
                _ => line.strip_prefix("ExecStart=").map(str::to_owned),
            };
            add(block.lines.iter().filter_map(command).collect());
        }
        within_text(&document).for_each(|line| add(vec![line]));
    }
    scripts.retain(|script| !script.lines.is_empty());
    scripts
}

/// Commands within a text. A command that needs a file but names none only mentions its options.
fn within_text(document: &Document) -> impl Iterator<Item = String> {
    let spans = if document.is_to_be_followed() { document.spans() } else { Vec::new() };
    spans.into_iter().filter(|span| span.starts_with("vn100 ")).map(|span| {
        let words: Vec<&str> = span.split(' ').collect();
        let is_mention = words[2..].iter().all(|word| word.starts_with('-')) && words[1] != "attach";
        if is_mention { format!("{span} --help") } else { span }
    })
}

/// The line as it is run here; without its comment.
fn runnable(line: &str) -> String {
    let line = line.replace("cargo run -p vn100 -- ", "vn100 ");
    let line = line.split_once(" #").map_or(&*line, |(command, _)| command);
    let word = |word| STANDS_FOR.iter().find(|(name, _)| *name == word).map_or(word, |(_, here)| *here);
    let mut words: Vec<&str> = line.split_whitespace().map(word).collect();
    // the only likely port is an emulated sensor
    if words.starts_with(&["vn100", "attach"]) && words.get(2).is_none_or(|word| word.starts_with('-')) {
        words.insert(2, "sim");
    }
    let is_live = words.starts_with(&["vn100", "attach"])
        || words.starts_with(&["vn100", "record"])
        || words.starts_with(&["vn100", "sim"]) && ["--link", "--tcp"].iter().any(|word| words.contains(word));
    match words.iter().position(|word| ["-d", "--duration"].contains(word)) {
        Some(option) if is_live => words[option + 1] = LIVE,
        Some(option) if words.starts_with(&["vn100", "sim"]) && !words.contains(&WITH_DIGEST) => {
            words[option + 1] = GENERATED;
        }
        None if is_live => words.extend(["--duration", LIVE]),
        _ => {}
    }
    words.join(" ")
}

/// Runs a line, as a shell does.
fn run_line(line: &str, folder: &Path, programs: &Path) -> Output {
    let words: Vec<&str> = line.split(' ').collect();
    if !words.contains(&"--resume") {
        let written = words.windows(2).filter(|pair| WRITES.contains(&pair[0]));
        // if a file does not exist, none is in the way
        written.for_each(|pair| drop(fs::remove_file(folder.join(pair[1]))));
    }
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    shell.arg("-c").current_dir(folder).env_remove("RUST_BACKTRACE");
    shell.env("PATH", path);
    if words.starts_with(&["vn100", "replay"]) && words.contains(&"--serve=:0") {
        // a replay with a page stays at its end
        return interrupted_after(shell.arg(format!("exec {line}")), "replayed to its end");
    }
    run(shell.arg(line))
}

/// A folder of programs, before those of the system.
fn programs() -> TempDir {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    symlink(env!("CARGO_BIN_EXE_vn100"), folder.path().join("vn100")).unwrap();
    // the other machine is this one, and a page is shown
    for (name, script) in [("ssh", "#!/bin/sh\nshift\nexec \"$@\"\n"), ("xdg-open", "#!/bin/sh\ntest -f \"$1\"\n")] {
        let path = folder.path().join(name);
        fs::write(&path, script).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

#[test]
fn every_command_that_a_document_shows_is_run() {
    let (programs, made) = (programs(), tempfile::tempdir().unwrap());
    captures::make(made.path());
    let scripts = scripts();
    let lines = scripts.iter().map(|script| script.lines.len()).sum::<usize>();
    assert!(lines >= 75, "{lines} lines");
    let (left, failures) = (Mutex::new(scripts.iter()), Mutex::new(Vec::new()));
    let work = || {
        while let Some(script) = { left.lock().unwrap().next() } {
            if let Err(failure) = run_script(script, made.path(), programs.path()) {
                failures.lock().unwrap().push(format!("{}: {failure}", script.document));
            }
        }
    };
    // most of them wait for a sensor
    thread::scope(|scope| (0..8).for_each(|_| _ = scope.spawn(work)));
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn run_script(script: &Script, made: &Path, programs: &Path) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    captures::link(made, folder.path());
    for line in &script.lines {
        if NOT_RUN.iter().any(|(begin, _)| line.starts_with(begin)) {
            continue;
        }
        let runnable = runnable(line);
        let output = run_line(&runnable, folder.path(), programs);
        let said = String::from_utf8_lossy(&output.stderr);
        let other = OTHER_ENDS.iter().find(|(command, ..)| line.starts_with(command));
        let (status, reason) = other.map_or((0, ""), |(_, status, reason)| (*status, *reason));
        if output.status.code() != Some(status) || !said.contains(reason) {
            return Err(format!("{line}\n    as {runnable}: {}: {said}", output.status));
        }
        if let Some((_, digest)) = line.split_once("sha256sum").and_then(|(_, rest)| rest.split_once("# ")) {
            let digests = String::from_utf8_lossy(&output.stdout);
            if !digests.starts_with(digest) {
                return Err(format!("{line}: {digests}"));
            }
        }
    }
    Ok(())
}

#[test]
fn lines_that_are_not_run_exist_and_name_existing_targets() {
    let lines: Vec<String> = scripts().into_iter().flat_map(|script| script.lines).collect();
    for (begin, reason) in NOT_RUN {
        assert!(lines.iter().any(|line| line.starts_with(begin)), "{begin} ({reason}) is shown nowhere");
    }
    let root = workspace();
    for line in lines.iter().filter(|line| line.starts_with("cargo ")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let value = |option| words.iter().position(|word| *word == option).map(|at| words[at + 1]);
        let package = value("-p").map(|package| root.join("crates").join(package));
        if let Some(package) = value("--path").map(|path| root.join(path)).or(package.clone()) {
            assert!(package.join("Cargo.toml").is_file(), "{line}");
        }
        for (option, folder) in [("--bench", "benches"), ("--example", "examples"), ("--test", "tests")] {
            let Some(target) = value(option) else { continue };
            let folder = package.as_ref().unwrap().join(folder);
            let is_there =
                [format!("{target}.rs"), format!("{target}/main.rs")].iter().any(|name| folder.join(name).is_file());
            assert!(is_there, "{line}: no {target} in {}", folder.display());
        }
    }
}

#[test]
fn the_service_resumes_its_recording_and_gives_up_a_lost_sensor() {
    let services: Vec<String> = scripts()
        .into_iter()
        .flat_map(|script| script.lines)
        .filter(|line| line.starts_with("/usr/bin/vn100"))
        .collect();
    assert!(!services.is_empty());
    for service in services {
        assert!(service.contains(" --resume ") && service.contains(" --give-up "), "{service}");
    }
}
