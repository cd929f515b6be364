//! Recordings of one sensor as one.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{channel, vn100};

/// A minute of an emulated sensor.
fn recording(folder: &Path, seed: u32, message: &str) -> PathBuf {
    let path = folder.join(format!("{message}-{seed}.txt"));
    let options = ["--message", message, "--seed", &seed.to_string(), "--duration", "1min"];
    assert!(vn100().args(["sim", "-o"]).arg(&path).args(options).status().unwrap().success());
    path
}

fn pooled(files: &[PathBuf]) -> (Vec<Value>, i32, String) {
    let options = ["--pool", "--json", "--rate", "40"];
    let output = vn100().arg("replay").args(files).args(options).output().unwrap();
    let documents = serde_json::from_slice(&output.stdout).unwrap();
    (documents, output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn white<'a>(pool: &'a Value, name: &str) -> &'a Value {
    let parameters = channel(pool, name)["noise"].as_array().unwrap();
    parameters.iter().find(|parameter| parameter["parameter"] == "white").unwrap()
}

#[test]
fn recordings_of_one_sensor_make_one_curve_and_one_set_of_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (1..=4).map(|seed| recording(folder.path(), seed, "VNIMU")).collect();
    let (documents, exit, _) = pooled(&files);
    assert_eq!((documents.len(), exit), (5, 0));
    let (singles, pool) = (&documents[..4], &documents[4]);
    assert_eq!((&pool["schema"], &pool["source"]["kind"]), (&"vn100.pool/1".into(), &"pool".into()));
    assert_eq!(pool["source"]["parts"].as_array().unwrap().len(), 4);
    for name in ["gyro_x", "accel_z", "mag_y"] {
        let points = channel(pool, name)["points"].as_array().unwrap();
        for (index, point) in points.iter().enumerate() {
            let of = |document: &Value| channel(document, name)["allan"]["points"][index].clone();
            let terms: u64 = singles.iter().map(|document| of(document)["terms"].as_u64().unwrap()).sum();
            assert_eq!(point["terms"], terms, "{name}");
            let square = |document: &Value| {
                let point = of(document);
                point["deviation"].as_f64().unwrap().powi(2) * point["terms"].as_u64().unwrap() as f64
            };
            let expected = (singles.iter().map(square).sum::<f64>() / terms as f64).sqrt();
            assert!((point["deviation"].as_f64().unwrap() / expected - 1.0).abs() < 1e-12, "{name}");
        }
        let found = &white(pool, name)["pooled"];
        let number = |key: &str| found[key].as_f64().unwrap();
        assert!(number("next_lower") < number("lower") && number("upper") < number("next_upper"), "{found}");
        let parts = white(pool, name)["parts"].as_array().unwrap();
        let values = parts.iter().filter_map(|part| part["value"].as_f64());
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        assert!(low < number("value") && number("value") < high, "{found}");
        assert_eq!(found["farthest"]["outlier"], false, "{name}");
    }
    let parameters =
        pool["channels"].as_array().unwrap().iter().flat_map(|channel| channel["noise"].as_array().unwrap());
    let mut bounded = 0;
    for parameter in parameters {
        let statuses: Vec<&Value> = parameter["parts"].as_array().unwrap().iter().map(|part| &part["status"]).collect();
        let count = |wanted: &str| statuses.iter().filter(|status| **status == wanted).count();
        let by_all = count("bounded") > 2 && count("estimated") == 0;
        assert_eq!(parameter["common_upper"].is_number(), by_all, "{parameter}");
        bounded += usize::from(by_all);
    }
    assert!(bounded > 0, "a minute estimates every B and K");
    let text = vn100().arg("replay").args(&files).args(["--pool", "--rate", "40"]).output().unwrap();
    let text = String::from_utf8(text.stdout).unwrap();
    let pool = text.split("\npool of 4 recordings: ").nth(1).unwrap();
    for expected in ["VNIMU-1.txt", "  median", "  spread, %", "  next, lower", "serial number unknown"] {
        assert!(pool.contains(expected), "{expected}: {pool}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn a_recording_that_differs_is_excluded_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> = (1..=2).map(|seed| recording(folder.path(), seed, "VNIMU")).collect();
    files.insert(1, recording(folder.path(), 3, "VNYMR"));
    let (documents, exit, errors) = pooled(&files);
    let pool = &documents[3];
    assert_eq!(exit, 1);
    let reason = "it is of VNYMR, and VNIMU-1.txt of VNIMU";
    assert!(errors.contains(&format!("VNYMR-3.txt is excluded from the pool: {reason}")), "{errors}");
    assert_eq!(pool["source"]["parts"][1]["reason"], reason);
    assert_eq!(white(pool, "gyro_y")["pooled"], Value::Null, "two stand side by side");
    assert_eq!(white(pool, "gyro_y")["parts"].as_array().unwrap().len(), 2);
    let alone = vn100().arg("replay").args(&files[..1]).arg("--pool").output().unwrap();
    assert_eq!(alone.status.code(), Some(2));
}
