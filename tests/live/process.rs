//! The program as a process: signals, pipes that close, kills, and commands that cannot be executed
//! as given. The emulated sensor is in the memory of the process.

use std::{
    fs,
    net::TcpListener,
    path::Path,
    process::{Child, Command, Stdio},
};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::support::{Lines, Running, document, replay, run, vn100};

fn samples(document: &Value) -> u64 {
    document["timing"]["samples"].as_u64().unwrap()
}

/// Checks that two documents are equal apart from their source and the reason of their end.
fn assert_same_but_source(mut a: Value, mut b: Value) {
    for document in [&mut a, &mut b] {
        (document["source"], document["end_reason"]) = (Value::Null, Value::Null);
    }
    assert_eq!(a, b);
}

/// The arguments are invalid, and nothing was done.
#[test]
fn invalid_arguments_end_with_exit_code_two() {
    for (command, options, expected) in [
        ("configure", &[][..], "nothing to change"),
        ("configure", &["--listen-only", "--set-rate", "20"], "cannot be used with"),
        ("info", &["--listen-only"], "cannot be identified"),
        ("record", &["--meta", "/dev/zero", "--duration", "1s", "-o", "/dev/null/x"], "longer than 1 MiB"),
    ] {
        let output = run(vn100().args([command, "sim"]).args(options));
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(expected), "{command} {options:?}: {error}");
        let code = if command == "record" { 1 } else { 2 };
        assert_eq!(output.status.code(), Some(code), "{command} {options:?}: {error}");
    }
}

#[test]
fn a_signal_without_a_view_ends_with_the_result() {
    for signal in [Signal::INT, Signal::HUP, Signal::TERM] {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("interrupted.mcap");
        // a test command under `nohup` inherits that hang-ups are ignored, and the program then continues
        let mut attach = Command::new("env");
        attach.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_vn100"), "attach", "sim", "--ndjson", "--record"]);
        let mut attached = Running::start(attach.arg(&recording).stdin(Stdio::null()));
        attached.nth_document(2);
        kill_process(Pid::from_child(&attached.process), signal).unwrap();
        let last: Value = serde_json::from_str(&attached.lines.by_ref().last().unwrap()).unwrap();
        assert_eq!(attached.end().0.code(), Some(0), "{signal:?}");
        let (recorded, _) = replay(&recording, &[]);
        assert_eq!(recorded["source"]["recorded"]["end_reason"], "stopped");
        assert_same_but_source(recorded, last);
    }
}

#[test]
fn a_step_of_a_witness_kit_says_one_line_of_what_it_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["witness", "sim", "-o", "kit.zip", "-d", "20s"];
    let mut witness = Running::start(vn100().current_dir(folder.path()).args(arguments).stdin(Stdio::null()));
    let begin: Vec<String> = witness.lines.by_ref().take(3).collect();
    kill_process(Pid::from_child(&witness.process), Signal::INT).unwrap();
    let lines: Vec<String> = begin.into_iter().chain(witness.lines.by_ref()).collect();
    let (status, error) = witness.end();
    assert!(lines[0].starts_with("step 1 of 8, 1s: ") && lines[2].starts_with("step 2 of 8, 3s: "), "{lines:?}");
    assert!(lines[1].ends_with(" samples, 0 missing, 40 Hz") && lines.len() <= 4, "{lines:?}");
    assert!(error.ends_with("vn100: step 2 is not recorded; the same command continues with it\n"), "{error}");
    assert!(!error.contains("window") && status.code() == Some(1), "{error}");
}

/// The interrupt comes during the search for the sensor, with any settings.
#[test]
fn an_interrupt_during_the_search_is_an_end_without_samples() {
    for options in [&[][..], &["--set-rate", "20"]] {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("tcp://{}", server.local_addr().unwrap());
        let mut attached = vn100();
        attached.args(["attach", &address, "--json"]).args(options).stdin(Stdio::null());
        let attached: Child = attached.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let _silent = server.accept().unwrap();
        kill_process(Pid::from_child(&attached), Signal::INT).unwrap();
        let output = attached.wait_with_output().unwrap();
        assert_eq!((output.status.code(), samples(&document(&output))), (Some(3), 0));
    }
}

#[test]
fn a_reader_that_leaves_ends_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("left.mcap");
    let options = ["attach", "sim", "--set-rate", "20", "--ndjson", "--record"];
    let mut attached = Running::start(vn100().args(options).arg(&recording));
    attached.nth_document(1);
    attached.lines = Lines::of(std::io::empty());
    let (_, error) = attached.end();
    assert!(error.contains("settings restored"), "{error}");
    let (recorded, _) = replay(&recording, &[]);
    assert_eq!(recorded["source"]["recorded"]["complete"], true);
}

#[test]
fn a_failed_start_leaves_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("typo.mcap");
    let record =
        |source: &str| run(vn100().args(["record", source, "--duration", "1s", "-o"]).arg(&recording)).status.code();
    assert_eq!(record("/nowhere/ttyUSB7"), Some(3));
    assert!(!recording.exists());
    assert_eq!(record("sim"), Some(0));
    assert_eq!(record("sim"), Some(1), "it exists");
    for command in [&["info", "/nowhere/ttyUSB7"][..], &["configure", "/nowhere/ttyUSB7", "--set-rate", "20"]] {
        assert_eq!(run(vn100().args(command)).status.code(), Some(3), "{command:?}");
    }
}

#[test]
fn a_recording_continues_without_a_reader_of_the_documents() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("unread.mcap");
    let script = "\"$0\" attach sim --duration 4s --ndjson=thin --record \"$1\" | head -n 1";
    let output =
        Command::new("bash").args(["-c", script]).arg(env!("CARGO_BIN_EXE_vn100")).arg(&recording).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 1);
    let (whole, _) = replay(&recording, &[]);
    assert_eq!(samples(&whole) + whole["timing"]["missing"].as_u64().unwrap(), 160);
}

#[test]
fn a_closed_pipe_hides_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let unopened = folder.path().join("none").join("a.mcap");
    for (arguments, code) in [
        (&["/nowhere", "--json"][..], 3),
        (&["/nowhere", "--ndjson"], 3),
        (&["sim", "--duration", "1s", "--json", "--record", unopened.to_str().unwrap()], 1),
        (&["sim", "--duration", "1s", "--ndjson"], 0),
    ] {
        let mut command = vn100();
        command.arg("attach").args(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), told.is_empty()), (Some(code), false), "{arguments:?}: {told}");
    }
}

#[test]
fn two_emulated_sensors_are_two() {
    let output = run(vn100().args(["attach", "sim", "sim", "--duration", "1s", "--json"]));
    let documents = document(&output);
    let least = |index: usize| {
        let channels = documents[index]["channels"].as_array().unwrap();
        channels.iter().map(|channel| channel["statistics"]["min"].to_string()).collect::<Vec<_>>()
    };
    assert_eq!(output.status.code(), Some(0));
    assert_eq!((&documents[0]["source"]["name"], &documents[1]["source"]["name"]), (&"sim-1".into(), &"sim-2".into()));
    let serial = |index: usize| &documents[index]["source"]["device"]["serial_number"];
    assert_eq!((serial(0), serial(1)), (&"0100000001".into(), &"0100000002".into()));
    // two measurements of one sensor show the same values, apart from a line or two at the ends
    let shared = least(0).iter().zip(&least(1)).filter(|(a, b)| a == b).count();
    assert!(shared < 6, "{:?}, {:?}", least(0), least(1));
}

/// Runs the program without a place for temporary files.
#[test]
fn an_emulated_sensor_needs_no_file() {
    let output = run(vn100().args(["attach", "sim", "-d", "1s", "--json"]).env("TMPDIR", Path::new("/nowhere")));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(fs::metadata("/nowhere").is_err());
}
