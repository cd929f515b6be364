//! The samples as a table, which reads back to the same numbers.

use std::{fs, path::Path};

use serde_json::Value;

use crate::support::{capture, replay, replay_log, vn100};

/// The results that depend on the samples: time base, statistics and deviations.
fn numbers(document: &Value) -> Value {
    let channels = document["channels"].as_array().unwrap();
    let of = |channel: &Value| {
        Value::from(vec![channel["name"].clone(), channel["statistics"].clone(), channel["allan"].clone()])
    };
    let mut timing = document["timing"].clone();
    // a table has no nominal rate for an offset
    timing["offset_ppm"] = Value::Null;
    Value::from(vec![timing, channels.iter().map(of).collect()])
}

/// Writes the samples of a capture with these options, and measures the table with the same options.
fn written_and_read(file: &Path, table: &Path, options: &[&str]) -> (Value, Value) {
    let (document, status) = replay(file, &[options, &["--samples", table.to_str().unwrap()]].concat());
    assert_eq!(status, 0);
    (document, replay(table, options).0)
}

#[test]
fn samples_read_back_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str| folder.path().join(name);
    let timed = capture(folder.path(), "a.mcap", &["--message", "VNIMU", "--duration", "5min"]);
    let (written, read) = written_and_read(&timed, &table("timed.csv"), &["--skip", "10s"]);
    assert_eq!(numbers(&written), numbers(&read));
    // without times the rate is given
    let untimed = ["--rate", "40", "--compensated", "yes", "-d", "30s"];
    let (written, read) = written_and_read(&replay_log("clean-minute.vnymr"), &table("untimed.csv"), &untimed);
    assert_eq!(numbers(&written), numbers(&read));
    assert_eq!(fs::read_to_string(table("untimed.csv")).unwrap().lines().count(), 1201, "as many as were measured");
    // packets are floats: their counts are finer than those of a table
    let packets = capture(folder.path(), "b.mcap", &["--message", "BINARY", "--duration", "1min"]);
    let (written, read) = written_and_read(&packets, &table("packets.csv"), &[]);
    assert_eq!(written["timing"]["samples"], read["timing"]["samples"]);
    let head = fs::read_to_string(table("packets.csv")).unwrap();
    assert!(head.starts_with("time [ns],device time [ns],accel_x [m/s^2],"), "{:.80}", head);
    for (written, read) in written["channels"].as_array().unwrap().iter().zip(read["channels"].as_array().unwrap()) {
        let std = |channel: &Value| channel["statistics"]["std"].as_f64().unwrap();
        assert!((std(written) / std(read) - 1.0).abs() < 1e-6, "{}", written["name"]);
    }
    // their own times show missing samples, even without arrival times
    let mut bytes = fs::read(capture(folder.path(), "c.bin", &["--message", "BINARY", "--duration", "1min"])).unwrap();
    bytes.drain(44 * 500..44 * 521);
    bytes.drain(44 * 1000..44 * 1003);
    fs::write(folder.path().join("lost.bin"), bytes).unwrap();
    let (written, read) = written_and_read(&folder.path().join("lost.bin"), &table("lost.csv"), &[]);
    for key in ["samples", "missing", "gaps", "rate_hz"] {
        assert_eq!(written["timing"][key], read["timing"][key], "{key}");
    }
    assert_eq!(written["timing"]["missing"], 24);
}

#[test]
fn a_restart_of_the_sensor_is_one_in_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let boot = capture(folder.path(), "boot.bin", &["--message", "BINARY", "--duration", "20s"]);
    let twice = folder.path().join("twice.bin");
    fs::write(&twice, fs::read(boot).unwrap().repeat(2)).unwrap();
    let (written, read) = written_and_read(&twice, &folder.path().join("twice.csv"), &[]);
    assert_eq!(written["timing"]["segments"], 2);
    assert!(written["warnings"].to_string().contains("the sensor restarted 1 time"), "{}", written["warnings"]);
    assert_eq!(written["timing"], read["timing"]);
}

#[test]
fn samples_are_the_only_standard_output_and_no_file_is_replaced() {
    let log = replay_log("clean-minute.vnymr");
    let output = vn100().args(["replay", "--samples", "-"]).arg(&log).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(0), 2401));
    assert!(text.lines().all(|line| line.split(',').count() == 12));
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().join("there.csv");
    fs::write(&there, "precious").unwrap();
    let output = vn100().args(["replay", "--samples"]).args([&there, &log]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(fs::read_to_string(&there).unwrap(), "precious");
    for wrong in [&["--json", "--samples", "-"][..], &["--samples", "x.csv", "other.vnymr"]] {
        let output = vn100().arg("replay").arg(&log).args(wrong).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
    }
}
