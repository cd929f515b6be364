//! The program on serial ports of this machine: pseudo-terminals with the emulated sensor, or
//! without a device, at their other end.

use std::{
    fs::{self, File, OpenOptions},
    io::{Read, Write},
    path::Path,
    process::Command,
    thread,
};

use rustix::{
    process::{Pid, Signal, kill_process},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{OptionalActions, tcgetattr, tcsetattr},
};
use serde_json::Value;
use vn100_driver::other_program_on;

use crate::sensor::Sensor;
use crate::support::{Running, document, interrupted_after, replay, run, vn100, warned};

/// A port of this machine: its name, its own side of the line, and the side of the device at the other
/// end.
fn port() -> (String, File, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let line = OpenOptions::new().read(true).write(true).open(&name).unwrap();
    let mut modes = tcgetattr(&line).unwrap();
    modes.make_raw();
    tcsetattr(&line, OptionalActions::Now, &modes).unwrap();
    (name, line, File::from(master))
}

#[test]
fn a_sensor_is_found_set_measured_recorded_and_restored() {
    let sensor = Sensor::start(&["--faults", "baud@0s:57600"]);
    let recording = sensor.file("port.mcap");
    let options = ["--set-rate", "20", "--duration", "6s", "--json", "--record"];
    let output = run(sensor.command("attach", &options).arg(&recording));
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{error}");
    let mut measured = document(&output);
    let number = |pointer| measured.pointer(pointer).and_then(Value::as_u64).unwrap();
    assert_eq!(number("/timing/samples") + number("/timing/missing"), 120, "{}", measured["timing"]);
    assert_eq!(measured["timing"]["rate_hz"], 20.0);
    assert!(error.contains("settings restored"), "{error}");
    let (mut replayed, _) = replay(&recording, &[]);
    for document in [&mut replayed, &mut measured] {
        (document["source"], document["end_reason"]) = (Value::Null, Value::Null);
    }
    assert_eq!(replayed, measured);
    assert_eq!(document(&sensor.run("info", &["--json"]))["rate_hz"], 40);
}

#[test]
fn a_port_is_for_one() {
    let sensor = Sensor::start(&[]);
    let mut first = Running::start(&mut sensor.command("attach", &["--ndjson"]));
    first.nth_document(1);
    let second = sensor.run("attach", &["--duration", "1s", "--json"]);
    assert_eq!(second.status.code(), Some(3));
    let error = String::from_utf8(second.stderr).unwrap();
    // the emulator has the port open as well, as the device at its other end
    assert!(error.contains(&format!("in use by vn100 (process {})", first.process.id())), "{error}");
    drop(first);
    // a killed program leaves no lock
    assert_eq!(sensor.run("attach", &["--duration", "1s", "--json"]).status.code(), Some(0));
}

#[test]
fn a_port_that_is_given_twice_is_in_use_by_the_program_itself() {
    let (name, _line, _other_end) = port();
    let output = interrupted_after(vn100().args(["attach", &name, &name]), "in use by this program itself");
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("in use by this program itself"), "{error}");
}

#[test]
fn another_program_that_has_the_port_open_without_a_lock_is_named() {
    let sensor = Sensor::start(&[]);
    let port = File::open(sensor.port()).unwrap();
    // it has the port open and does not read
    let mut program = Command::new("tail").args(["-f", "/dev/null"]).stdin(port).spawn().unwrap();
    let recording = sensor.file("a.mcap");
    let mut attached = Running::start(sensor.command("attach", &["--ndjson", "--record"]).arg(&recording));
    let live = loop {
        let document = attached.nth_document(1);
        if warned(&document, "link-errors") {
            break document;
        }
    };
    kill_process(Pid::from_child(&attached.process), Signal::INT).unwrap();
    let (_, errors) = attached.end();
    program.kill().unwrap();
    program.wait().unwrap();
    let headline = format!("tail (process {}) has the port open too", program.id());
    assert!(live["warnings"].to_string().contains(&headline), "{}", live["warnings"]);
    assert!(errors.contains(&headline), "{errors}");
    // the recording says so too
    assert!(warned(&replay(&recording, &[]).0, "link-errors"));
    let alone = sensor.run("attach", &["--duration", "1s", "--json"]);
    assert!(!warned(&document(&alone), "link-errors"));
}

/// As with a loopback plug.
#[test]
fn a_port_that_only_hands_back_what_is_sent_is_named_with_what_to_do() {
    let commands = [&["attach"][..], &["info"], &["configure", "--set-rate", "20"]];
    let running = commands.map(|arguments| {
        thread::spawn(move || {
            let (name, _line, mut plug) = port();
            thread::spawn(move || {
                let mut buffer = [0; 256];
                while let Ok(n @ 1..) = plug.read(&mut buffer) {
                    plug.write_all(&buffer[..n]).unwrap();
                }
            });
            let output = run(vn100().args(arguments).arg(&name));
            let error = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(3), "{arguments:?}: {error}");
            let told = format!(
                "no sensor found on {name} at 9 baud rates: the line echoes, and only the sent bytes were received"
            );
            assert!(error.contains(&told) && error.contains("loopback plug"), "{arguments:?}: {error}");
            assert!(!error.contains("connected"), "{error}");
        })
    });
    for command in running {
        command.join().unwrap();
    }
}

/// Until it runs its own program, a process has all files of the one that started it.
#[test]
fn a_program_that_is_being_started_has_no_port_open() {
    let (name, _line, _device) = port();
    let starting = thread::spawn(|| {
        for _ in 0..500 {
            Command::new("true").status().unwrap();
        }
    });
    while !starting.is_finished() {
        assert_eq!(other_program_on(Path::new(&name)), None);
    }
    starting.join().unwrap();
}

#[test]
fn a_file_is_no_port() {
    let file = fs::canonicalize(crate::support::replay_log("clean-minute.vnymr")).unwrap();
    let output = run(vn100().args(["attach", "--json"]).arg(&file));
    assert_eq!(output.status.code(), Some(3));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("not a serial port"), "{error}");
    // no other output: no summary without a measurement
    let output = run(vn100().args(["attach", "/nowhere/ttyUSB7"]));
    assert_eq!((output.status.code(), String::from_utf8(output.stdout).unwrap()), (Some(3), String::new()));
    assert_eq!(String::from_utf8(output.stderr).unwrap().lines().count(), 1);
}
