//! What others wrote never steers the terminal, files are never written over unasked, and what comes with the program is whole.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

mod support;

use std::{fs, os::unix::fs::symlink, process::Command};

use support::{replay_log, vn100, with_stdin};

/// Clears the screen, in ASCII and as one character above it; rings; turns the direction of text; feigns a line.
const HOSTILE: &str = "x\x1b[2J\u{9b}2J\x07\u{202e}fdp\u{2066}\u{200f}\u{2028}\x7fy";

/// The output as text, in which no character is left that steers a terminal.
#[track_caller]
fn assert_harmless(bytes: &[u8]) -> String {
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    let harmful = |c: &char| {
        (c.is_control() && *c != '\n')
            || ('\u{2028}'..='\u{202e}').contains(c)
            || ('\u{2066}'..='\u{2069}').contains(c)
            || ['\u{61c}', '\u{200e}', '\u{200f}'].contains(c)
    };
    assert_eq!(text.chars().find(harmful), None, "{text:?}");
    text
}

#[test]
fn names_of_captures_steer_nothing_and_stay_whole_in_documents() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join(format!("good{HOSTILE}"));
    let other = folder.path().join(format!("other{HOSTILE}"));
    let none = folder.path().join(format!("none{HOSTILE}"));
    fs::copy(replay_log("corrupted.vnymr"), &good).unwrap();
    fs::copy(replay_log("clean-minute.vnymr"), &other).unwrap();
    for form in [&[][..], &["--json"], &["--ndjson"]] {
        let output = vn100().arg("replay").args([&good, &none]).args(form).output().unwrap();
        assert!(assert_harmless(&output.stdout).contains("good"), "{form:?}");
        assert!(assert_harmless(&output.stderr).contains("none"), "{form:?}");
    }
    for form in [&[][..], &["--json"]] {
        let output = vn100().arg("compare").args([&good, &other]).args(form).output().unwrap();
        assert!(assert_harmless(&output.stdout).contains("other"), "{form:?}");
    }
    let output = vn100().arg("replay").arg(&good).arg("--json").output().unwrap();
    assert_eq!(support::document(&output)["source"]["name"], format!("good{HOSTILE}"));
}

#[test]
fn what_captures_hold_steers_nothing() {
    let header = format!("t,gyr_x,gyr_y,gyr_z,{HOSTILE}\n");
    let rows: String = (0..200).map(|row| format!("{:.3},0.1,0.2,0.3,{HOSTILE}\n", f64::from(row) * 0.025)).collect();
    let odd = format!("1,{HOSTILE},2,3,4\n");
    let raw = format!("$VN{HOSTILE},1,2,3*00\r\n").repeat(50);
    for content in [format!("{header}{rows}"), format!("{header}{rows}{odd}"), odd, raw, HOSTILE.to_owned()] {
        for form in [&[][..], &["--json"]] {
            let output = with_stdin(vn100().args(["replay", "-"]).args(form), content.as_bytes());
            assert_harmless(&output.stdout);
            assert_harmless(&output.stderr);
            assert!(!output.stdout.is_empty() || !output.stderr.is_empty());
        }
    }
}

#[test]
fn a_command_line_steers_nothing() {
    let hostile = format!("--{HOSTILE}");
    let tcp = format!("tcp://{HOSTILE}");
    for arguments in [
        &["replay", &hostile][..],
        &[HOSTILE],
        &["replay", "x", "--rate", HOSTILE],
        &["replay", "x", "--columns", HOSTILE],
        &["replay", "x", "--datasheet", HOSTILE],
        &["plan", "--want", HOSTILE],
        &["sim", "--faults", HOSTILE],
        &["sim", "-o", "-", "--profile", HOSTILE],
        &["info", &tcp],
        &["info", HOSTILE],
        &["completions", HOSTILE],
    ] {
        let output = vn100().args(arguments).output().unwrap();
        assert_ne!(output.status.code(), Some(0), "{arguments:?}");
        assert_harmless(&output.stdout);
        assert!(!assert_harmless(&output.stderr).is_empty(), "{arguments:?}");
    }
}

#[test]
fn nothing_is_written_through_a_link_or_over_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let precious = folder.path().join("precious");
    fs::write(&precious, "precious").unwrap();
    let run = |arguments: &[&str]| {
        vn100().current_dir(folder.path()).args(arguments).output().unwrap().status.code().unwrap()
    };
    for name in ["link.vnymr", "link.mcap", "vn100.1"] {
        symlink(&precious, folder.path().join(name)).unwrap();
    }
    symlink(folder.path().join("made"), folder.path().join("dangling")).unwrap();
    for name in ["precious", "link.vnymr", "link.mcap", "dangling"] {
        assert_eq!(run(&["sim", "--duration", "1s", "-o", name]), 1, "sim -o {name}");
        assert_ne!(run(&["record", "sim", "--duration", "1s", "-o", name]), 0, "record -o {name}");
        assert_ne!(run(&["attach", "sim", "--duration", "1s", "--json", "--record", name]), 0, "--record {name}");
        if name != "precious" {
            assert_eq!(run(&["sim", "--duration", "1s", "--force", "-o", name]), 1, "sim --force -o {name}");
            assert_ne!(run(&["record", "sim", "--duration", "1s", "--resume", "-o", name]), 0, "--resume {name}");
        }
    }
    assert_eq!(run(&["man", "-o", "."]), 1);
    assert_eq!(fs::read_to_string(&precious).unwrap(), "precious");
    assert!(!folder.path().join("made").exists());
}

#[test]
fn completions_are_scripts() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = vn100().args(["completions", shell]).output().unwrap();
        assert_eq!(script.status.code(), Some(0), "{shell}");
        let text = String::from_utf8(script.stdout.clone()).unwrap();
        assert!(text.contains("listen-only") && !text.contains('\u{fffd}') && script.stderr.is_empty(), "{shell}");
        if shell == "bash" {
            match Command::new("bash").arg("--version").output() {
                Ok(_) => assert!(with_stdin(Command::new("bash").arg("-n"), &script.stdout).status.success()),
                Err(_) => eprintln!("skipped: there is no bash to parse the completions"),
            }
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let written = vn100().args(["man", "-o"]).arg(folder.path()).output().unwrap();
    assert_eq!((written.status.code(), written.stdout.len(), written.stderr.len()), (Some(0), 0, 0));
    let pages: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|page| page.unwrap().path()).collect();
    let help = String::from_utf8(vn100().arg("--help").output().unwrap().stdout).unwrap();
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // descriptions go on in lines that are further in
    let commands = commands.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let commands: Vec<_> = commands.filter(|command| !["", "help"].contains(command)).collect();
    assert!(commands.contains(&"attach") && commands.contains(&"man"), "{help}");
    for command in &commands {
        assert!(pages.iter().any(|page| page.ends_with(format!("vn100-{command}.1"))), "{command}");
    }
    let main = vn100().arg("man").output().unwrap().stdout;
    assert!(main == fs::read(folder.path().join("vn100.1")).unwrap());
    if Command::new("man").arg("--version").output().is_err() {
        return eprintln!("skipped: there is no man to render the pages");
    }
    for page in &pages {
        let rendered =
            Command::new("man").args(["--warnings", "-E", "UTF-8", "-l", "-Tutf8"]).arg(page).output().unwrap();
        assert!(rendered.status.success() && rendered.stderr.is_empty(), "{page:?}: {rendered:?}");
        assert!(!rendered.stdout.is_empty(), "{page:?}");
    }
}
