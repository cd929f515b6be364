//! Bags through the whole program: as JSON, text and report, one stream or two, and the real ones.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

use crate::support::{deviation, document, real_captures, replay, vn100, with_stdin, workspace};

fn bag(name: &str) -> PathBuf {
    workspace().join("crates/vn100-capture/tests/bags").join(name)
}

fn refused(command: &mut Command) -> (Option<i32>, String) {
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// Overlapping Allan deviation of the numbers written to the bags, by allantools 2024.06, of
/// `gyro_x` and `accel_x` at m = 1 and 4.
const GYRO_X: [(u64, f64); 2] = [(1, 0.001_791_025_617_172_726), (4, 0.001_020_680_837_395_936_2)];
const ACCEL_X: [(u64, f64); 2] = [(1, 0.015_626_816_962_917_17), (4, 0.010_552_917_870_242_595)];

fn assert_deviations(document: &Value, name: &str, expected: [(u64, f64); 2]) {
    for (m, expected) in expected {
        let found = deviation(document, name, m);
        assert!((found - expected).abs() < 1e-5 * expected, "{name}, m = {m}: {found} is not {expected}");
    }
}

#[test]
fn deviations_of_a_bag_are_those_of_the_numbers_in_it() {
    for name in ["imu_none.bag", "imu_bz2.bag", "db3", "db3_file_zstd", "mcap_swapped"] {
        let (document, exit) = replay(&bag(name), &["--estimator", "full"]);
        assert_eq!(exit, 0);
        assert_deviations(&document, "gyro_x", GYRO_X);
        assert_deviations(&document, "accel_x", ACCEL_X);
        let source = &document["source"];
        assert_eq!((&source["stream"], &source["compensated"]), (&"/imu/data".into(), &Value::Null));
        assert_eq!((&source["bag"]["used"], &source["bag"]["stamps"]), (&60.into(), &"field".into()), "{source}");
        assert_eq!(document["timing"]["rate_hz"], 100.0);
        assert_eq!(source["recorded"]["started"], "2023-11-14T22:13:20.003Z", "{source}");
    }
}

#[test]
fn two_streams_of_one_bag_are_two_results() {
    let output = vn100().arg("replay").arg(bag("db3_two")).args(["--json", "--estimator", "full"]).output().unwrap();
    assert!(output.status.success());
    let both = document(&output);
    let [rates, accelerations] = &both.as_array().unwrap()[..] else { panic!("{both}") };
    assert_deviations(rates, "gyro_x", GYRO_X);
    assert_eq!((&rates["timing"]["rate_hz"], &accelerations["timing"]["rate_hz"]), (&100.0.into(), &50.0.into()));
    let names = [rates, accelerations].map(|document| document["source"]["name"].as_str().unwrap());
    assert_eq!(names, ["db3_two /camera/gyro/sample", "db3_two /camera/accel/sample"]);
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("two.html");
    let report = vn100().arg("report").arg(bag("db3_two")).arg("-o").arg(&page).args(["--export", "csv"]).output();
    assert!(report.unwrap().status.success());
    let text = fs::read_to_string(&page).unwrap();
    assert!(names.iter().all(|name| text.contains(name)) && text.contains("by header.stamp in the messages"));
    assert!(["-1", "-2"].iter().all(|number| folder.path().join(format!("two{number}.allan.csv")).exists()));
    // one of them, by name, and from a stream
    let one = with_stdin(
        vn100().args(["replay", "-", "--topic", "camera/gyro/sample", "--json"]),
        &fs::read(bag("db3_two/db3_two.db3")).unwrap(),
    );
    assert_eq!(document(&one)["timing"]["samples"], 60);
}

#[test]
fn two_streams_of_one_bag_are_compared_and_exported_apart() {
    let compare = |args: &[&str], file: &Path| vn100().arg("compare").args(args).arg(file).output().unwrap();
    let both = compare(&["--json"], &bag("db3_two"));
    assert!(both.status.success(), "{}", String::from_utf8_lossy(&both.stderr));
    assert_eq!(document(&both)["records"].as_array().unwrap().len(), 2);
    for (args, file) in [(&[][..], bag("mcap")), (&["--topic", "/camera/gyro/sample"], bag("db3_two"))] {
        let (code, text) = refused(vn100().arg("compare").args(args).arg(file));
        assert!(code == Some(2) && text.contains("contains one stream"), "{code:?}: {text}");
    }
    let (code, text) = refused(vn100().arg("compare").arg(bag("none.bag")));
    assert!(code == Some(3) && text.contains("none.bag") && !text.contains("one stream"), "{code:?}: {text}");

    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("two.html");
    let mut report = vn100();
    report.arg("report").arg(bag("db3_two")).arg("-o").arg(&page).args(["--export", "kalibr,json"]);
    let output = report.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    // the accelerometer is that of the other stream, which is short
    let missing =
        "two-1.imu.yaml not written: N of the accelerometer is missing: neither an estimate nor an upper bound";
    assert!(output.status.code() == Some(1) && text.contains(missing), "{text}");
    // of no known sensor, so that a sheet must be named
    let filled = ["--export", "kalibr", "--fill-from-datasheet", "--force"];
    let output = vn100().arg("report").arg(bag("db3_two")).arg("-o").arg(&page).args(filled).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("`--datasheet FILE.toml`") && !text.contains("--fill-from-datasheet"), "{text}");
    let sheet = ["--export", "kalibr", "--fill-from-datasheet", "--datasheet", "adis16470", "--force"];
    let output = vn100().arg("report").arg(bag("db3_two")).arg("-o").arg(&page).args(sheet).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    assert_eq!(names, ["two-1.imu.yaml", "two-1.json", "two-2.imu.yaml", "two-2.json", "two.html"]);
    let yaml = fs::read_to_string(folder.path().join("two-1.imu.yaml")).unwrap();
    assert!(yaml.contains("\nrostopic: /camera/gyro/sample\n"), "{yaml}");
    assert!(
        yaml.contains(": N of the accelerometer, as printed: what aliases in this stream is not known\n"),
        "{yaml}"
    );
}

#[test]
fn a_refused_bag_is_listed_and_its_cure_named() {
    let (code, text) = refused(vn100().args(["replay", "--topic", "/nope"]).arg(bag("db3_two")));
    assert_eq!(code, Some(3));
    assert!(text.contains("\n  /camera/gyro/sample (sensor_msgs/Imu, 60 messages, 100.0000 Hz)\n"), "{text}");
    assert!(text.ends_with("name one topic: `--topic NAME`\n"), "{text}");
    let map = ["--columns", "gyro_x=imu.gyro.x:rad/s"];
    let (code, text) = refused(vn100().arg("replay").args(map).arg(bag("mcap")));
    assert!(
        code == Some(3) && text.contains("no number \"imu.gyro.x\"") && text.contains("angular_velocity.x"),
        "{text}"
    );
}

#[test]
fn real_bags_give_the_sentences_that_another_reader_finds() {
    let Some(folder) = real_captures().map(|folder| folder.join("bags")) else { return };
    let expected: Value = serde_json::from_slice(&fs::read(folder.join("expected.json")).unwrap()).unwrap();
    for (name, expected) in expected.as_object().unwrap() {
        let Some(sentences) = expected.get("sentences") else { continue };
        let (document, exit) = replay(&folder.join(name), &["--estimator", "full", "--rate", "40"]);
        assert_eq!(exit, 0, "{name}");
        assert_eq!(document["timing"]["samples"], sentences["good"], "{name}");
        assert_eq!(document["source"]["bag"]["used"], sentences["found"], "{name}");
    }
    // without a gap the deviation is that of the whole series
    for (name, rate, gaps) in
        [("iwale_moving.bag", "40", 0), ("olive_free.mcap", "40", 0), ("ramirez_run2.db3", "1", 0)]
    {
        let (document, _) = replay(&folder.join(name), &["--estimator", "full", "--rate", rate]);
        assert_eq!(document["timing"]["missing"], gaps, "{name}");
        for m in ["1", "16"] {
            let expected = expected[name]["sentences"]["gyro_x_counts_oadev"][m].as_f64().unwrap();
            let found = deviation(&document, "gyro_x", m.parse().unwrap());
            assert!((found - expected).abs() < 1e-9 * expected, "{name}, m = {m}: {found} is not {expected}");
        }
    }
    let (rl, _) = replay(&folder.join("rl_test1.bag"), &["--estimator", "full"]);
    assert_eq!(rl["timing"]["samples"], 11_865);
    for (m, expected) in [(1, 0.024_699_196_3), (16, 0.015_263_997_7)] {
        let found = deviation(&rl, "gyro_x", m);
        assert!((found - expected).abs() < 1e-5 * expected, "m = {m}: {found} is not {expected}");
    }
    let (phidgets, _) = replay(&folder.join("imutools_phidgets.bag"), &[]);
    assert_eq!(phidgets["timing"]["samples"], 13_964);
    let (unchecked, _) = replay(&folder.join("rohx_circles.bag"), &["--accept-unchecked"]);
    assert_eq!(unchecked["timing"]["samples"], 3991);
    for (name, words) in [("fox_lz4.bag", "no topic has"), ("r2_empty_bag_0.db3", "without a message")] {
        let output = vn100().arg("replay").arg(folder.join(name)).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(3) && text.contains(words), "{name}: {text}");
    }
}
