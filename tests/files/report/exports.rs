//! The files that are exported with a report, as read by other programs.

use std::{fs, path::PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use super::{report, simulated, text, vn100};
use crate::support::real_captures;

#[test]
fn exports_are_read_by_others() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let forms = "csv,json,svg";
    let (page, _) = report(&folder, &[&capture], &["--export", forms]);
    let beside = |ending: &str| {
        let mut name = page.with_extension("").into_os_string();
        name.push(ending);
        PathBuf::from(name)
    };

    let document: Value = serde_json::from_str(&fs::read_to_string(beside(".json")).unwrap()).unwrap();
    let gyro = &document["channels"][10];
    assert_eq!((&gyro["name"], &document["schema"]), (&"gyro_y".into(), &"vn100.analysis/2".into()));

    let table = fs::read_to_string(beside(".allan.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let of_gyro: Vec<_> = rows.filter(|row| row[column("channel")] == "gyro_y").collect();
    let points = gyro["allan"]["points"].as_array().unwrap();
    assert_eq!(of_gyro.len(), points.len());
    for (row, point) in of_gyro.iter().zip(points) {
        assert_eq!(row[column("deviation")].parse::<f64>().unwrap(), point["deviation"].as_f64().unwrap());
        assert_eq!(row.len(), header.len());
    }
    for ending in [".metadata.csv", ".statistics.csv", ".parameters.csv", ".spectrum.csv"] {
        let table = fs::read_to_string(beside(ending)).unwrap();
        let columns = table.lines().next().unwrap().split(',').count();
        assert!(table.lines().count() > 8 && table.lines().all(|line| line.split(',').count() == columns), "{ending}");
    }

    let svg = fs::read_to_string(beside(".svg-figures").join("allan-gyro_y.svg")).unwrap();
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.ends_with("</svg>"));
    assert!(fs::read_dir(beside(".svg-figures")).unwrap().count() >= 24 + 12 + 3);
}

/// The values of imu.yaml; Kalibr reads nothing else of it.
fn kalibr_values(yaml: &str) -> Vec<(&str, f64)> {
    let lines = yaml.lines().filter(|line| !line.starts_with('#') && !line.starts_with("rostopic: "));
    let values = lines.map(|line| line.split_once(": ").unwrap());
    values.map(|(name, value)| (name, value.parse().unwrap())).collect()
}

#[test]
fn kalibr_gets_the_noisiest_axis_and_a_walk_that_covers_the_bias_instability() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnimu", &["--message", "VNIMU"]);
    let (page, html) = report(&folder, &[&capture], &["--export", "kalibr,json", "--span", "100s"]);
    let yaml = fs::read_to_string(page.with_extension("imu.yaml")).unwrap();
    let document: Value = serde_json::from_str(&fs::read_to_string(page.with_extension("json")).unwrap()).unwrap();
    let channels = document["channels"].as_array().unwrap();
    let of_sensor = |prefix: &str, of: fn(&Value) -> f64| {
        let axes = channels.iter().filter(|channel| channel["name"].as_str().unwrap().starts_with(prefix));
        axes.map(|channel| of(&channel["noise"])).fold(0.0, f64::max)
    };
    let known = |parameter: &Value| parameter["value"].as_f64().or(parameter["upper"].as_f64()).unwrap();
    let density = |noise: &Value| noise["white"]["value"].as_f64().unwrap();
    let walk = |noise: &Value| {
        let (walk, flicker) = (&noise["rate_random_walk"], &noise["bias_instability"]);
        let known = |parameter: &Value| parameter["value"].as_f64().or(parameter["upper"].as_f64()).unwrap();
        let is_alone = walk["status"] == "estimated" && flicker["status"] != "estimated";
        known(walk).max(if is_alone { 0.0 } else { 1.15 * known(flicker) / 10.0 })
    };
    assert!(channels.iter().any(|channel| channel["name"] == "gyro_x" && known(&channel["noise"]["white"]) > 0.0));
    let expected = [
        ("accelerometer_noise_density", of_sensor("accel", density)),
        ("accelerometer_random_walk", of_sensor("accel", walk)),
        ("gyroscope_noise_density", of_sensor("gyro", density)),
        ("gyroscope_random_walk", of_sensor("gyro", walk)),
        ("update_rate", 40.0),
    ];
    let found = kalibr_values(&yaml);
    assert_eq!(found.len(), expected.len(), "{yaml}");
    for ((name, value), (expected_name, expected)) in found.into_iter().zip(expected) {
        assert!(name == expected_name && (value / expected - 1.0).abs() < 1e-4, "{name} {value}, {expected}\n{yaml}");
    }
    assert!(yaml.contains("# N of the gyroscope = ") && yaml.contains(", estimated"), "{yaml}");
    assert!(yaml.contains(", upper bound"), "{yaml}");
    for label in yaml.lines().filter_map(|line| line.strip_prefix("# ")).filter(|line| line.contains(" = ")) {
        assert!(html.contains(label), "the page lacks {label}");
    }
}

#[test]
fn kalibr_gets_no_random_walk_of_a_compensated_gyroscope() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnymr", &[]);
    let page = folder.path().join("r.html");
    let export = |more: &[&str]| {
        let output = vn100(&[&["report", text(&capture), "-o", text(&page), "--export", "kalibr"], more].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let reason = "K of the gyroscope is missing: B and K are not measurable in a bias-compensated message";
    let file = folder.path().join("r.imu.yaml");
    let (code, told) = export(&[]);
    assert!(code == Some(1) && told.contains(reason) && page.exists() && !file.exists(), "{code:?} {told}");
    assert!(
        told.contains("`vn100 attach PORT --set-message VNIMU`") && told.contains("--fill-from-datasheet"),
        "{told}"
    );
    let (code, told) = export(&["--force", "--fill-from-datasheet"]);
    assert_eq!(code, Some(0), "{told}");
    let yaml = fs::read_to_string(&file).unwrap();
    let names: Vec<&str> = kalibr_values(&yaml).into_iter().map(|(name, _)| name).collect();
    let expected = [
        "accelerometer_noise_density",
        "accelerometer_random_walk",
        "gyroscope_noise_density",
        "gyroscope_random_walk",
        "update_rate",
    ];
    assert_eq!(names, expected);
    assert!(yaml.contains("# not measured, from the data sheet of VectorNav VN-100: K of the gyroscope\n"), "{yaml}");
}

#[test]
fn other_averaging_times_are_shown_and_change_no_figure_for_filters() {
    let folder = TempDir::new().unwrap();
    let capture = simulated(&folder, "a.vnimu", &["--message", "VNIMU"]);
    let exported = |taus: &str| {
        let options = ["--rate", "40", "--estimator", "full", "--taus", taus, "--export", "kalibr,csv"];
        let (page, _) = report(&folder, &[&capture], &options);
        let read = |ending: &str| fs::read_to_string(page.with_extension(ending)).unwrap();
        let yaml = read("imu.yaml");
        (yaml.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n"), read("allan.csv"))
    };
    let ((octaves, _), (listed, curve)) = (exported("octave"), exported("10,1"));
    assert_eq!(octaves, listed);
    assert!(octaves.contains("accelerometer_noise_density"), "{octaves}");
    let gyro: Vec<&str> = curve.lines().filter(|line| line.starts_with("gyro_x,")).collect();
    assert!(gyro.len() == 2 && gyro[0].contains(",40,1,") && gyro[1].contains(",400,10,"), "{gyro:?}");
}

#[test]
fn a_capture_of_motion_gives_no_filter_parameters() {
    let Some(captures) = real_captures() else { return };
    let capture = captures.join("vn100-shake-iwale-153s.vnymr");
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("r.html");
    let output = vn100(&["report", text(&capture), "-o", text(&page), "--export", "kalibr"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && told.contains("the sensor was moved"), "{told}");
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("MOVED</b> <span>sensor moved") && html.contains("Nothing is compared: sensor moved"));
    let parameters = html.split("id=\"parameters\"").nth(1).unwrap().split("id=\"datasheet\"").next().unwrap();
    assert!(parameters.contains("Not given: the sensor was moved") && !parameters.contains("≤"), "{parameters}");
    assert!(
        !html.contains("figure-graphical-gyro_y") && !html.contains("fitted model</text>"),
        "no line of the motion"
    );
    assert!(!html.contains("noise_density: ") && !html.contains("Vibration detected"));
    assert!(!folder.path().join("r.imu.yaml").exists());
}
