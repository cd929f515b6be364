//! The whole program on emulated sensors behind real pseudo-terminals: each fault, with its counts.

use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::sensor::Sensor;
use crate::support::{Lines, Running, document, replay, run, vn100, warned};

fn number(document: &Value, pointer: &str) -> u64 {
    document.pointer(pointer).and_then(Value::as_u64).unwrap_or_else(|| panic!("no {pointer} in {document}"))
}

/// Every good line is a sample, a reply or something else, and none is lost.
fn assert_conserved(document: &Value) {
    let n = |pointer| number(document, pointer);
    let told = n("/timing/samples") + n("/timing/left_out") + n("/link/replies") + n("/link/other_messages");
    assert_eq!(n("/link/frames"), told, "{}", document["link"]);
}

/// How often a recording was resumed: where nothing is known of the time between two segments. A
/// busy machine may keep the emulated sensor from sending, which is a gap of known length.
fn joins(document: &Value) -> u64 {
    number(document, "/timing/segments") - 1 - number(document, "/timing/gaps")
}

/// What two documents say, but for where it came from, and why that ended.
fn assert_same_but_source(mut a: Value, mut b: Value) {
    for document in [&mut a, &mut b] {
        (document["source"], document["end_reason"]) = (Value::Null, Value::Null);
    }
    assert_eq!(a, b);
}

#[test]
fn the_baud_rate_is_found_and_a_replay_equals_the_measurement() {
    for baud in ["57600", "460800", "921600"] {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("live.mcap");
        let output = vn100()
            .args(["attach", "sim", "--duration", "2s", "--json", "--faults", &format!("baud@0s:{baud}"), "--record"])
            .arg(&recording)
            .output()
            .unwrap();
        let live = document(&output);
        assert_eq!((number(&live, "/timing/samples"), output.status.code()), (80, Some(0)), "{baud}");
        assert_eq!(number(&live, "/timing/missing"), 0);
        assert_eq!(live["source"]["kind"], "sim");
        assert_conserved(&live);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains(&format!("at {baud} baud")), "{stderr}");
        let (recorded, exit) = replay(&recording, &[]);
        assert_eq!(exit, 0);
        assert_eq!(recorded["source"]["recorded"]["complete"], true);
        assert_eq!(recorded["source"]["device"], live["source"]["device"]);
        assert_same_but_source(recorded, live);
    }
}

/// What was given is wrong, and nothing was done.
#[test]
fn what_cannot_be_done_as_given_ends_with_two() {
    let sensor = Sensor::start(&[]);
    for (command, options, expected) in [
        ("configure", &[][..], "nothing to change"),
        ("info", &["--listen-only"], "cannot be identified"),
        ("record", &["--meta", "/dev/zero", "--duration", "1s", "-o", "/dev/null/x"], "longer than 1 MiB"),
    ] {
        let output = sensor.run(command, options);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(expected), "{command} {options:?}: {error}");
        assert_eq!(
            output.status.code(),
            Some(if command == "record" { 1 } else { 2 }),
            "{command} {options:?}: {error}"
        );
    }
}

#[test]
fn a_port_that_is_given_twice_is_in_use_by_the_program_itself() {
    let sensor = Sensor::start(&[]);
    let port = sensor.port();
    let output = sensor.run("attach", &[port.to_str().unwrap(), "--duration", "1s"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("in use by this program itself"), "{error}");
}

#[test]
fn what_is_configured_is_read_back_and_what_attach_changes_is_put_back() {
    let sensor = Sensor::start(&[]);
    let told = |output: &Output| (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned());
    let info = || document(&sensor.run("info", &["--json"]));
    let configured = sensor.run("configure", &["--set-rate", "20", "--window", "40"]);
    assert_eq!(configured.status.code(), Some(0), "{configured:?}");
    assert_eq!((&info()["rate_hz"], &info()["window"][2]), (&20.into(), &40.into()));

    let refused = sensor.run("configure", &["--set-rate", "100"]);
    let (exit, error) = told(&refused);
    assert_eq!(exit, Some(1));
    assert!(error.contains("at most 50 Hz fit"), "{error}");
    assert_eq!(info()["rate_hz"], 20);

    let attached = sensor.run("attach", &["--set-rate", "50", "--set-message", "VNIMU", "--duration", "2s", "--json"]);
    let measured = document(&attached);
    assert_eq!((&measured["timing"]["rate_hz"], &measured["source"]["message"]), (&50.0.into(), &"VNIMU".into()));
    assert_eq!(measured["timing"]["rate_from"], "device");
    assert!(told(&attached).1.contains("settings restored"), "{:?}", told(&attached));
    assert_eq!((&info()["rate_hz"], &info()["message"]), (&20.into(), &"VNYMR".into()));
}

#[test]
fn messages_with_a_quaternion_or_without_attitude_are_measured() {
    let sensor = Sensor::start(&[]);
    for (message, rate, channels) in [("VNMAR", "100", 9), ("VNQMR", "50", 13)] {
        let options = ["--set-message", message, "--set-rate", rate, "--duration", "2s", "--json"];
        let measured = document(&sensor.run("attach", &options));
        assert_eq!(measured["source"]["message"], message);
        assert_eq!(measured["timing"]["rate_hz"], rate.parse::<f64>().unwrap());
        assert_eq!(measured["channels"].as_array().unwrap().len(), channels);
        assert_conserved(&measured);
    }
    let refused = sensor.run("configure", &["--set-message", "VNQMR", "--set-rate", "100"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("at most 50 Hz fit"));
}

#[test]
fn a_counter_in_each_line_makes_the_losses_exact() {
    let sensor = Sensor::start(&["--faults", "flip@0.02%"]);
    let configured = sensor.run("configure", &["--count"]);
    assert_eq!(configured.status.code(), Some(0), "{configured:?}");
    let measured = document(&sensor.run("attach", &["--duration", "10s", "--json"]));
    assert_eq!(measured["timing"]["missing_from"], "counter");
    let n = |pointer| number(&measured, pointer);
    assert_eq!(n("/timing/samples") + n("/timing/missing"), 400);
    assert_conserved(&measured);
}

#[test]
fn flipped_bits_cost_their_lines_and_nothing_else() {
    let sensor = Sensor::start(&["--faults", "flip@0.02%", "--seed", "3"]);
    let measured = document(&sensor.run("attach", &["--duration", "10s", "--json"]));
    let n = |pointer| number(&measured, pointer);
    assert!(n("/link/bad_frames/checksum") > 0, "{}", measured["link"]);
    assert_eq!(n("/timing/samples") + n("/timing/missing"), 400);
    assert_conserved(&measured);
    assert!(warned(&measured, "bad-lines"));
}

#[test]
fn a_port_is_for_one() {
    let sensor = Sensor::start(&[]);
    let mut first = Running::start(&mut sensor.command("attach", &["--ndjson"]));
    first.nth_document(1);
    let second = sensor.run("attach", &["--duration", "1s", "--json"]);
    assert_eq!(second.status.code(), Some(3));
    let error = String::from_utf8(second.stderr).unwrap();
    // the emulator has the port open too, as what is behind it
    assert!(error.contains(&format!("in use by vn100 (process {})", first.process.id())), "{error}");
    drop(first);
    // a killed program leaves no lock behind
    assert_eq!(sensor.run("attach", &["--duration", "1s", "--json"]).status.code(), Some(0));
}

#[test]
fn an_unplugged_sensor_is_reconnected_and_the_measurement_continues() {
    let sensor = Sensor::start(&["--faults", "unplug@4s+1s"]);
    let recording = sensor.file("unplugged.mcap");
    let output = run(sensor.command("attach", &["--duration", "6s", "--json", "--record"]).arg(&recording));
    let measured = document(&output);
    let told = number(&measured, "/timing/samples") + number(&measured, "/timing/missing");
    assert_eq!(told, 240, "{}", String::from_utf8_lossy(&output.stderr));
    let down_s = measured["link"]["down_s"].as_f64().unwrap();
    assert!(down_s > 0.0, "{}", measured["link"]);
    assert!(down_s.to_string().len() <= 6, "milliseconds are enough: {down_s}");
    assert_eq!((number(&measured, "/link/reconnects"), number(&measured, "/timing/segments")), (1, 2));
    assert_conserved(&measured);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(error.matches(": disconnected: ").count(), 1, "not for every attempt: {error}");
    assert!(error.contains("disconnected: the port disappeared"), "the first cause, not that of an attempt: {error}");
    assert_same_but_source(replay(&recording, &[]).0, measured);
}

#[test]
fn a_sensor_that_returns_under_another_name_is_followed() {
    let output = run(vn100().args(["attach", "sim", "--duration", "6s", "--json", "--faults", "unplug@4s+1s:other"]));
    let measured = document(&output);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(number(&measured, "/timing/samples") + number(&measured, "/timing/missing"), 240);
    assert_eq!((number(&measured, "/link/reconnects"), number(&measured, "/timing/segments")), (1, 2));
    assert!(measured["link"]["down_s"].as_f64().is_some_and(|down_s| down_s > 0.0), "{}", measured["link"]);
    assert_conserved(&measured);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(error.matches(": disconnected: the port disappeared").count(), 1, "{error}");
}

#[test]
fn what_was_changed_is_restored_under_the_other_name() {
    let options = ["--set-rate", "20", "--duration", "8s", "--json", "--faults", "unplug@8s+1s:other"];
    let output = run(vn100().args(["attach", "sim"]).args(options));
    let measured = document(&output);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{error}");
    assert!(error.contains("settings restored"), "{error}");
    assert_eq!((&measured["timing"]["rate_hz"], number(&measured, "/timing/segments")), (&20.0.into(), 2));
}

#[test]
fn an_interrupt_and_a_hang_up_without_a_view_end_with_the_result() {
    for signal in ["-INT", "-HUP"] {
        let sensor = Sensor::start(&[]);
        let recording = sensor.file("interrupted.mcap");
        let mut attached = Running::start(sensor.command("attach", &["--ndjson", "--record"]).arg(&recording));
        // two seconds of data
        attached.nth_document(2);
        let told = Command::new("kill").args([signal, &attached.process.id().to_string()]).status().unwrap();
        assert!(told.success());
        let last: Value = serde_json::from_str(&attached.lines.by_ref().last().unwrap()).unwrap();
        assert_eq!(attached.end().0.code(), Some(0), "{signal}");
        assert!(number(&last, "/timing/samples") >= 80);
        let (recorded, _) = replay(&recording, &[]);
        assert_eq!(recorded["source"]["recorded"]["end_reason"], "stopped");
        assert_same_but_source(recorded, last);
    }
}

#[test]
fn the_samples_of_a_sensor_are_a_table_of_the_measured_ones() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("samples.csv");
    let output = run(vn100().args(["attach", "sim", "-d", "2s", "--json", "--samples"]).arg(&table));
    assert_eq!(output.status.code(), Some(0));
    let measured = document(&output);
    // rows that came before the rate was known may lie behind the end
    let (read, _) = replay(&table, &["--rate", "40", "-d", "2s"]);
    assert_eq!((&measured["timing"]["samples"], &read["timing"]["samples"]), (&80.into(), &80.into()));
    for (measured, read) in measured["channels"].as_array().unwrap().iter().zip(read["channels"].as_array().unwrap()) {
        assert_eq!((&measured["name"], &measured["statistics"]), (&read["name"], &read["statistics"]));
    }
}

#[test]
fn a_reader_that_leaves_ends_in_order() {
    let sensor = Sensor::start(&[]);
    let recording = sensor.file("left.mcap");
    let options = ["--set-rate", "20", "--ndjson", "--record"];
    let mut attached = Running::start(sensor.command("attach", &options).arg(&recording));
    attached.nth_document(1);
    attached.lines = Lines::of(std::io::empty());
    let (_, error) = attached.end();
    assert!(error.contains("settings restored"), "{error}");
    assert_eq!(document(&sensor.run("info", &["--json"]))["rate_hz"], 40);
    let (recorded, _) = replay(&recording, &[]);
    assert_eq!(recorded["source"]["recorded"]["complete"], true);
}

#[test]
fn what_never_began_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("typo.mcap");
    let record = |source: &str| {
        let output = vn100().args(["record", source, "--duration", "1s", "-o"]).arg(&recording).output().unwrap();
        output.status.code()
    };
    assert_eq!(record("/nowhere/ttyUSB7"), Some(3));
    assert!(!recording.exists());
    assert_eq!(record("sim"), Some(0));
    assert_eq!(record("sim"), Some(1), "it exists");
    for command in ["info", "configure"] {
        let mut vn100 = vn100();
        vn100.args([command, "/nowhere/ttyUSB7"]);
        if command == "configure" {
            vn100.args(["--set-rate", "20"]);
        }
        assert_eq!(vn100.output().unwrap().status.code(), Some(3), "{command}");
    }
}

#[test]
fn a_killed_recording_loses_the_last_moments_at_most_and_can_be_resumed() {
    let sensor = Sensor::start(&[]);
    let recording = sensor.file("killed.mcap");
    let mut attached = Running::start(sensor.command("attach", &["--ndjson", "--record"]).arg(&recording));
    let second = attached.nth_document(2);
    // a second may wait in the program; another is for a machine too busy to give the recorder its turn
    attached.nth_document(2);
    drop(attached);
    let (recorded, exit) = replay(&recording, &[]);
    assert_eq!((exit, &recorded["source"]["recorded"]["complete"]), (0, &false.into()));
    assert!(number(&recorded, "/timing/samples") >= number(&second, "/timing/samples"));

    let existing = run(sensor.command("record", &["--duration", "1s", "-o"]).arg(&recording));
    assert_ne!(existing.status.code(), Some(0));
    let resumed = run(sensor.command("record", &["--duration", "1s", "--resume", "-o"]).arg(&recording));
    assert_eq!(resumed.status.code(), Some(0), "{}", String::from_utf8_lossy(&resumed.stderr));
    let (whole, _) = replay(&recording, &[]);
    assert_eq!(joins(&whole), 1);
    assert!(number(&whole, "/timing/samples") >= number(&recorded, "/timing/samples") + 40);
}

/// A replay measures one message: another one behind it would be recorded in vain.
#[test]
fn a_recording_is_resumed_with_its_own_message_alone() {
    let sensor = Sensor::start(&[]);
    for rotation in [&[][..], &["--rotate", "1h"]] {
        let recording = sensor.file(&format!("packets-{}.mcap", rotation.len()));
        let attach = |message: &str| {
            let mut attach = sensor.command("attach", &["--duration", "1s", "--resume", "--set-message", message]);
            run(attach.args(rotation).arg("--record").arg(&recording))
        };
        assert!(attach("BINARY").status.success());
        for (message, expected) in [("VNIMU", 1), ("BINARY+MAG", 1), ("BINARY", 0)] {
            let resumed = attach(message);
            let error = String::from_utf8(resumed.stderr).unwrap();
            assert_eq!(resumed.status.code(), Some(expected), "{message}: {error}");
            assert_eq!(error.contains("holds BINARY, and a replay would not measure"), expected == 1, "{error}");
        }
    }
}

#[test]
fn a_recording_that_was_resumed_is_replayed_to_its_end_and_nobody_else_resumes_it_meanwhile() {
    let sensor = Sensor::start(&[]);
    let recording = sensor.file("resumed.mcap");
    assert!(run(sensor.command("record", &["--duration", "1s", "-o"]).arg(&recording)).status.success());
    let mut other = Running::start(sensor.command("attach", &["--ndjson", "--resume", "--record"]).arg(&recording));
    other.nth_document(2);
    let refused = run(vn100().args(["record", "sim", "--duration", "1s", "--resume", "-o"]).arg(&recording));
    assert_eq!(refused.status.code(), Some(1));
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(told.contains("is being recorded to"), "{told}");
    drop(other);
    let (whole, _) = replay(&recording, &[]);
    assert_eq!(joins(&whole), 1);
    assert!(number(&whole, "/timing/samples") > 40, "{whole}");
}

#[test]
fn a_recording_goes_on_where_nobody_reads_the_documents() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("unread.mcap");
    let script = "\"$0\" attach sim --duration 4s --ndjson=thin --record \"$1\" | head -n 1";
    let output =
        Command::new("bash").args(["-c", script]).arg(env!("CARGO_BIN_EXE_vn100")).arg(&recording).output().unwrap();
    assert!(String::from_utf8(output.stdout).unwrap().lines().count() == 1);
    assert_eq!(number(&replay(&recording, &[]).0, "/timing/samples"), 160);
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
fn another_message_is_named_with_the_line_that_cures_it() {
    let sensor = Sensor::start(&[]);
    let configured = sensor.run("configure", &["--set-message", "VNYPR"]);
    assert_eq!(configured.status.code(), Some(0), "its lines come as set: {configured:?}");
    let told = String::from_utf8(configured.stdout).unwrap();
    assert!(
        told.contains("the message (register 06) from 14 to 1;") && told.contains("unless --save is given"),
        "{told}"
    );
    let output = sensor.run("attach", &["--json"]);
    assert_eq!(output.status.code(), Some(3));
    let told = document(&output);
    assert!(number(&told, "/link/other_messages") > 0);
    assert!(told["warnings"].to_string().contains("VNYPR"), "{}", told["warnings"]);
}

#[test]
fn a_sensor_that_comes_back_with_another_message_ends_the_measurement() {
    let sensor = Sensor::start(&["--faults", "reboot@8s"]);
    let configured = sensor.run("configure", &["--set-message", "VNIMU"]);
    assert_eq!(configured.status.code(), Some(0), "{configured:?}");
    let output = sensor.run("attach", &["--duration", "60s", "--json"]);
    let told = document(&output);
    assert_eq!((output.status.code(), &told["source"]["message"]), (Some(1), &"VNIMU".into()));
    assert!(number(&told, "/timing/samples") > 0);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("VNYMR") && error.contains("--set-message VNIMU"), "{error}");
}

#[test]
fn a_sensor_that_returns_at_another_rate_ends_the_measurement() {
    let sensor = Sensor::start(&["--faults", "reboot@8s"]);
    let configured = sensor.run("configure", &["--set-rate", "20"]);
    assert_eq!(configured.status.code(), Some(0), "{configured:?}");
    let recording = sensor.file("rate.mcap");
    let output = run(sensor.command("attach", &["--duration", "60s", "--json", "--record"]).arg(&recording));
    let told = document(&output);
    assert_eq!((output.status.code(), &told["timing"]["rate_hz"]), (Some(1), &20.0.into()));
    assert!(number(&told, "/timing/samples") > 0 && warned(&told, "rate-changed"));
    let error = String::from_utf8(output.stderr).unwrap();
    let cure = format!("configure {} --set-rate 20`", sensor.port().display());
    assert!(error.contains("changed from 20 to 40 Hz") && error.contains(&cure), "{error}");
    let (replayed, exit) = replay(&recording, &[]);
    assert_eq!((exit, &replayed["channels"]), (0, &told["channels"]));
    assert_eq!(replayed["source"]["recorded"]["end_reason"], "the sensor sends at another rate");
}

#[test]
fn listening_only_asks_nothing() {
    let sensor = Sensor::start(&[]);
    let measured =
        document(&sensor.run("attach", &["--listen-only", "--baud", "115200", "--duration", "2s", "--json"]));
    assert_eq!((number(&measured, "/timing/samples"), number(&measured, "/link/replies")), (80, 0));
    assert_eq!(measured["source"]["device"], Value::Null);
    let refused = sensor.run("configure", &["--listen-only", "--set-rate", "20"]);
    assert_ne!(refused.status.code(), Some(0));
}
