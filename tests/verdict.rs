//! Verdicts against a data sheet: by the interval, with what the stream does to the sensor's noise allowed for.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking")]

mod support;

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;
use support::{channel, replay, replay_log, vn100};

fn capture(folder: &Path, options: &[&str]) -> PathBuf {
    let path = folder.join("capture.vnymr");
    let output = vn100().args(["sim", "--force", "-o"]).arg(&path).args(options).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    path
}

/// The verdicts on one figure of a channel.
fn verdicts(document: &Value, name: &str, parameter: &str) -> Vec<String> {
    let all = channel(document, name)["verdict"].as_array().unwrap();
    let of = all.iter().filter(|verdict| verdict["parameter"] == parameter);
    of.map(|verdict| verdict["verdict"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn without_the_window_white_noise_is_consistent_and_never_passes() {
    let (document, exit) = replay(&replay_log("clean-minute.vnymr"), &[]);
    assert_eq!(exit, 0);
    assert_eq!(verdicts(&document, "gyro_x", "white"), ["consistent"]);
    assert_eq!(verdicts(&document, "gyro_x", "bias_instability"), ["not-comparable", "not-comparable"]);
    assert_eq!(channel(&document, "yaw")["verdict"], Value::Null);
    let verdict = &channel(&document, "gyro_x")["verdict"][0];
    assert!((verdict["factor"].as_f64().unwrap() - 5_f64.sqrt()).abs() < 1e-9);
    assert!(verdict["text"].as_str().unwrap().contains("deg/sqrt(h)"), "{verdict}");
    assert_eq!(channel(&document, "gyro_x")["grade"]["best"], Value::Null);
    assert!(channel(&document, "gyro_x")["grade"]["reason"].as_str().unwrap().contains("stream"));

    let output =
        vn100().args(["replay", "--fail-on", "gyro N"]).arg(replay_log("clean-minute.vnymr")).output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(String::from_utf8_lossy(&output.stderr).contains("gyro_x is consistent"));
    assert!(!output.stdout.is_empty());
    let wrong = vn100().args(["replay", "--fail-on", "gyro", "x.vnymr"]).output().unwrap();
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn bias_instability_is_judged_as_the_sheet_states_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), &["--message", "VNIMU", "--duration", "5h"]);
    let (document, exit) = replay(&path, &["--rate", "40", "--fail-on", "gyro B", "--fail-on", "accel B"]);
    assert_eq!(exit, 0, "6 deg/h of flicker has its minimum at 4 deg/h, below the limit of 10");
    assert_eq!(verdicts(&document, "gyro_y", "bias_instability"), ["pass", "pass"]);
    assert_eq!(channel(&document, "gyro_y")["grade"]["best"], "tactical");
    assert_eq!(channel(&document, "accel_y")["grade"], Value::Null);

    // the same B of 6 deg/h against sheets that mean the minimum, or the flicker noise itself
    let sheet = |convention: &str, limit: f64| {
        let text = format!(
            "name = \"mine\"\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"bias_instability\"\nunit = \"deg/h\"\nlimit = {limit}\n{convention}"
        );
        let file = folder.path().join("sheet.toml");
        fs::write(&file, text).unwrap();
        let (document, _) = replay(&path, &["--rate", "40", "--datasheet", file.to_str().unwrap()]);
        verdicts(&document, "gyro_y", "bias_instability")
    };
    assert_eq!(sheet("", 5.2), ["pass"]);
    assert_eq!(sheet("convention = \"flicker\"", 5.2), ["fail"]);
    assert_eq!(sheet("", 3.0), ["fail"]);
    assert_eq!(sheet("", 4.3), ["undecided"]);
}

#[test]
fn a_wrong_sheet_is_told_before_anything_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sheet.toml");
    fs::write(&file, "name = \"mine\"\n[[figure]]\nsensor = \"gyro\"").unwrap();
    for sheet in [file, folder.path().join("none.toml")] {
        let output =
            vn100().args(["replay", "--datasheet"]).arg(&sheet).arg(replay_log("clean-minute.vnymr")).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains(sheet.to_str().unwrap()) && output.stdout.is_empty(), "{stderr}");
    }
}
