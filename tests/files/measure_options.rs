//! The effect of an option of a measurement on its result, and the unchanged rest.

use std::fs;

use serde_json::Value;

use crate::support::{capture, channel, deviation, document, replay, replay_log, vn100, warned, with_stdin};

const CLEAN: &str = "clean-minute.vnymr";

#[test]
fn skip_leaves_out_and_counts() {
    let (document, _) = replay(&replay_log(CLEAN), &["--skip", "10s"]);
    assert_eq!(document["timing"]["samples"], 2000);
    assert_eq!(document["timing"]["left_out"], 400);
    assert_eq!(document["link"]["frames"], 2400);
    let (nothing, exit) = replay(&replay_log(CLEAN), &["--skip", "1h"]);
    assert_eq!((&nothing["timing"]["samples"], exit), (&0.into(), 3));
}

#[test]
fn duration_ends_the_same_however_the_bytes_arrive() {
    let log = replay_log(CLEAN);
    let (mut from_file, exit) = replay(&log, &["--duration", "20s"]);
    assert_eq!((&from_file["timing"]["samples"], &from_file["link"]["frames"], exit), (&800.into(), &800.into(), 0));
    let options = ["replay", "-", "--json", "--duration", "20s"];
    let mut from_stdin = document(&with_stdin(vn100().args(options), &fs::read(&log).unwrap()));
    from_file["source"] = Value::Null;
    from_stdin["source"] = Value::Null;
    assert_eq!(from_file, from_stdin);
    assert_eq!(replay(&log, &["--duration", "1h"]).0["timing"]["samples"], 2400);
}

#[test]
fn a_measurement_that_ends_before_its_table_names_the_columns_and_counts_the_rows_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let row = |row: i64| format!("{:.2},{:.6},70\n", row as f64 * 0.01, (row * row * 31 % 997 - 498) as f64 * 1e-6);
    fs::write(&path, format!("t_s,gyro_x [rad/s],temperature [degF]\n{}", (0..8000).map(row).collect::<String>()))
        .unwrap();
    for end in [["--duration", "20s"], ["--until", "gyro N ±20%"]] {
        let output = vn100().arg("replay").arg(&path).args(end).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(" rows, times of column t_s, s; left out: temperature"), "{text}");
        let (document, _) = replay(&path, &end);
        let (csv, timing) = (&document["source"]["csv"], &document["timing"]);
        let read = timing["samples"].as_u64().unwrap() + timing["left_out"].as_u64().unwrap();
        assert_eq!((&csv["left_out"][0]["column"], &csv["rows"]), (&"temperature [degF]".into(), &read.into()));
    }
}

#[test]
fn averaging_times_are_as_requested_and_the_model_is_unchanged() {
    fn options(taus: &str) -> [&str; 6] {
        ["--rate", "40", "--estimator", "full", "--taus", taus]
    }
    let (octaves, _) = replay(&replay_log(CLEAN), &["--rate", "40", "--estimator", "full"]);
    let factors = |document: &Value| -> Vec<u64> {
        let points = channel(document, "gyro_x")["allan"]["points"].as_array().unwrap().clone();
        points.iter().map(|point| point["m"].as_u64().unwrap()).collect()
    };
    let (listed, exit) = replay(&replay_log(CLEAN), &options("10,0.025,0.2"));
    assert_eq!((factors(&listed), exit), (vec![1, 8, 400], 0));
    let (decades, exit) = replay(&replay_log(CLEAN), &options("decade"));
    assert_eq!((factors(&decades), exit), (vec![1, 2, 4, 10, 20, 40, 100, 200, 400, 1000], 0));
    let every: Vec<String> = (1..=1200).map(|m| (f64::from(m) / 40.0).to_string()).collect();
    let (all, exit) = replay(&replay_log(CLEAN), &options(&every.join(",")));
    assert_eq!((factors(&all), exit), ((1..=1200).collect(), 0));
    assert_eq!(channel(&all, "gyro_x")["noise"], channel(&octaves, "gyro_x")["noise"]);
    // a point at an octave equals that octave, bit for bit except for its degrees of freedom
    for point in channel(&octaves, "accel_z")["allan"]["points"].as_array().unwrap() {
        let same = &channel(&all, "accel_z")["allan"]["points"].as_array().unwrap().clone();
        let same = same.iter().find(|other| other["m"] == point["m"]).unwrap();
        assert_eq!((&same["deviation"], &same["terms"]), (&point["deviation"], &point["terms"]));
        let edf = |point: &Value| point["edf"].as_f64();
        assert!(edf(same).zip(edf(point)).is_none_or(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{same} {point}");
    }
    let mean = |m| deviation(&all, "gyro_x", m);
    assert!(mean(3) < mean(2) && mean(3) > mean(4));
}

#[test]
fn averaging_times_the_record_does_not_have_are_named() {
    let run = |options: &[&str]| vn100().args(["replay"]).arg(replay_log(CLEAN)).args(options).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    for (taus, options, code, named) in [
        (
            "0.03",
            &["--estimator", "full"][..],
            1,
            "no multiple of the sample interval of 0.025 s; the nearest: 0.025 s and 0.05 s",
        ),
        ("0.03", &["--estimator", "full", "--rate", "40"], 2, "no multiple"),
        ("1,40", &["--estimator", "full"], 1, "40 s needs 80 s without a gap"),
        ("decade", &[], 2, "--estimator full"),
        ("decade", &["--estimator", "plain"], 2, "--estimator full"),
        ("all", &["--estimator", "full"], 2, "no averaging time"),
        ("x", &["--estimator", "full"], 2, "no averaging time"),
    ] {
        let output = run(&[&["--taus", taus], options].concat());
        assert_eq!(output.status.code(), Some(code), "{taus} {options:?}");
        assert!(text(&output.stderr).contains(named), "{}", text(&output.stderr));
    }
}

#[test]
fn the_rate_scales_tau_and_nothing_else() {
    let (assumed, _) = replay(&replay_log(CLEAN), &[]);
    assert!(warned(&assumed, "rate-assumed"));
    let (asked, _) = replay(&replay_log(CLEAN), &["--rate", "200"]);
    assert!(!warned(&asked, "rate-assumed"));
    assert_eq!(asked["timing"]["rate_from"], "option");
    assert_eq!(asked["timing"]["duration_s"], 12.0);
    assert_eq!(channel(&asked, "yaw")["allan"]["points"][3]["tau_s"], 0.04);
    assert_eq!(deviation(&asked, "gyro_x", 8), deviation(&assumed, "gyro_x", 8));
}

#[test]
fn estimators_agree_as_required() {
    let (strided, _) = replay(&replay_log(CLEAN), &[]);
    let (full, _) = replay(&replay_log(CLEAN), &["--estimator", "full"]);
    let (plain, _) = replay(&replay_log(CLEAN), &["--estimator", "plain"]);
    for m in [1, 2, 4, 8, 16] {
        assert_eq!(deviation(&strided, "accel_z", m), deviation(&full, "accel_z", m));
    }
    assert_eq!(deviation(&plain, "accel_z", 1), deviation(&full, "accel_z", 1));
    assert_ne!(deviation(&plain, "accel_z", 2), deviation(&full, "accel_z", 2));
    let (hadamard, _) = replay(&replay_log(CLEAN), &["--deviation", "hadamard"]);
    assert_eq!(channel(&hadamard, "yaw")["allan"]["deviation"], "hadamard");
    assert_ne!(deviation(&hadamard, "accel_z", 1), deviation(&full, "accel_z", 1));
}

#[test]
fn a_stream_that_a_capture_of_one_does_not_have_is_refused() {
    let output = vn100().arg("replay").arg(replay_log(CLEAN)).args(["--topic", "/imu"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.stdout.is_empty() && said.contains("it has one stream and no \"/imu\""), "{said}");
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn columns_that_a_capture_of_another_format_does_not_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [bytes, image] = ["port.bin", "image.png"].map(|name| folder.path().join(name));
    fs::write(&bytes, [0x80, 1].repeat(2500)).unwrap();
    fs::write(&image, b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").unwrap();
    for (file, expected) in [
        (capture(folder.path(), "a.mcap", &["-d", "1s"]), "it is of the format mcap and has no columns; name none"),
        (bytes, "it is of the format raw and has no columns; name none"),
        (image, "found a PNG image"),
    ] {
        let output = vn100().args(["replay", "--columns", "gyro_x=wx:deg/s"]).arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.trim_end().ends_with(expected), "{said}");
        assert_eq!(output.status.code(), Some(3));
    }
}

#[test]
fn a_window_that_no_column_has_is_a_caution() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.csv");
    let rows = (0..500).map(|row| format!("{},{}\n", f64::from(row) * 0.01, row * 7 % 11));
    fs::write(&table, "t,gyro_x [deg/s]\n".to_owned() + &rows.collect::<String>()).unwrap();
    let ignored = |file, options: &[&str]| warned(&replay(file, options).0, "sensor-settings");
    assert!(ignored(&table, &["--window", "20"]) && !ignored(&table, &[]));
    assert!(ignored(&table, &["--window", "20", "--columns", "t=t:s,gyro_x=2:deg/s"]));
    assert!(!ignored(&replay_log(CLEAN), &["--window", "20"]));
}
