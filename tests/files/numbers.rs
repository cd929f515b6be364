//! The numbers that an engineer relies on: noise parameters of records with known truth, and the
//! results for streams that do not show it.

mod disturbed;
mod temperature;

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use serde_json::{Value, json};

use crate::support::{capture, channel, deviation, real_captures, replay, replay_log, vn100, warned};

fn parameter<'a>(document: &'a Value, name: &str, parameter: &str) -> &'a Value {
    &channel(document, name)["noise"][parameter]
}

/// Whether the interval or the bound contains the truth.
fn holds(parameter: &Value, truth: f64) -> bool {
    parameter["lower"].as_f64().is_none_or(|lower| lower <= truth) && truth <= parameter["upper"].as_f64().unwrap()
}

fn kinds(document: &Value) -> Vec<&str> {
    document["warnings"].as_array().unwrap().iter().map(|warning| warning["kind"].as_str().unwrap()).collect()
}

/// N in deg/√h, K in deg/h/√h, B in deg/h, all in SI units.
const DEG_SQRT_H: f64 = 1.0 / 3_437.746_770_785;
const DEG_H15: f64 = 1.0 / 1.237_588_8e7;
const DEG_H: f64 = 1.0 / 206_264.806;

/// Below is a line at 18.4 Hz, above the attitude filter: hardly any octave of the gyroscope's y
/// shows only its noise.
#[test]
fn white_noise_is_found_between_a_line_and_the_attitude_filter() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--like", "lab3", "--message", "VNYMR", "--duration", "5h"];
    let (document, _) = replay(&capture(folder.path(), "lab3.vnymr", &options), &["--rate", "40"]);
    let white = parameter(&document, "gyro_y", "white");
    assert_eq!(white["status"], "estimated");
    assert!(holds(white, 0.354 * DEG_SQRT_H), "{white}");
    let [lower, upper] = ["lower", "upper"].map(|end| white[end].as_f64().unwrap());
    assert!(upper / lower < 1.01, "{white}");
    let mut warnings = document["warnings"].as_array().unwrap().iter();
    let line = warnings.find(|warning| warning["kind"] == "vibration-line").unwrap()["text"].as_str().unwrap();
    assert!(line.contains("gyro_y 18.40 Hz"), "{line}");
}

/// The reference record of `docs/validation.md`, measured once for all tests.
pub(crate) fn reference() -> &'static Value {
    static MEASURED: OnceLock<Value> = OnceLock::new();
    MEASURED.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let options = ["--message", "VNIMU", "--like", "lab3", "--duration", "5h", "--seed", "1"];
        let (document, exit) = replay(&capture(folder.path(), "reference.vnimu", &options), &["--rate", "40"]);
        assert_eq!(exit, 0);
        document
    })
}

#[test]
fn five_hours_of_a_published_sensor_give_its_truth() {
    let document = reference();
    let gyro = |term| parameter(document, "gyro_y", term);
    assert!(holds(gyro("white"), 0.354 * DEG_SQRT_H), "{}", gyro("white"));
    assert_eq!(gyro("bias_instability")["status"], "bounded");
    assert_eq!(gyro("rate_random_walk")["status"], "bounded", "five hours are too short for so small a walk");
    assert!(holds(gyro("rate_random_walk"), 0.8969 * DEG_H15), "{}", gyro("rate_random_walk"));
    assert_eq!(gyro("rate_ramp")["status"], "bounded");
    // the line at 18.4 Hz is in the shortest octaves, as a term in addition to the noise
    assert_eq!(channel(document, "gyro_y")["noise"]["fit"]["tau_min_s"], 0.025);

    let accel = |term| parameter(document, "accel_y", term);
    assert!(holds(accel("white"), 0.114 / 60.0), "{}", accel("white"));
    assert!(holds(accel("bias_instability"), 0.0131e-3 * 9.80665), "{}", accel("bias_instability"));
    assert_eq!(accel("rate_random_walk")["status"], "estimated");
    assert!(holds(accel("rate_random_walk"), 4.559 / 216_000.0), "{}", accel("rate_random_walk"));

    // as lab reports read the same record: 0.83 deg/h and 0.0356 mg, by twenty seeds 0.39 to 1.14 and 0.033 to 0.041
    let by_rule =
        |name: &str| channel(document, name)["noise"]["classical"]["bias_instability"]["value"].as_f64().unwrap();
    assert!((0.39..1.14).contains(&(by_rule("gyro_y") / DEG_H)), "{}", by_rule("gyro_y") / DEG_H);
    assert!((0.032..0.041).contains(&(by_rule("accel_y") / 9.80665e-3)), "{}", by_rule("accel_y") / 9.80665e-3);

    let unexpected: Vec<_> =
        kinds(document).into_iter().filter(|kind| !["rate-assumed", "vibration-line"].contains(kind)).collect();
    assert!(unexpected.is_empty(), "{unexpected:?}");
}

/// The drift after rests and coasts of chosen lengths, by the closed forms of white noise; the tilt is
/// the larger part of velocity and position.
#[test]
fn white_noise_drifts_as_the_textbook_says() {
    let folder = tempfile::tempdir().unwrap();
    let noise = |name, mean: f64, white: f64| json!({"name": name, "statistics": {"mean": mean}, "noise": {"white": {"value": white}}});
    let gyro = ["gyro_x", "gyro_y", "gyro_z"].map(|name| noise(name, 0.0, 1e-4));
    let accel = [("accel_x", 0.0), ("accel_y", 0.0), ("accel_z", -9.797)].map(|(name, mean)| noise(name, mean, 1e-3));
    let channels = [gyro, accel].concat();
    let white = json!({"source": {"name": "white"}, "timing": {"rate_hz": 40.0}, "channels": channels});
    let sensor = folder.path().join("white.json");
    fs::write(&sensor, white.to_string()).unwrap();
    let options = ["--message", "VNIMU", "--duration", "1h", "--like", sensor.to_str().unwrap()];
    let record = capture(folder.path(), "white.vnymr", &options);
    let (document, _) = replay(&record, &["--rate", "40", "--coast", "20s,10s+1min,2min"]);
    let density = |name| parameter(&document, name, "white")["value"].as_f64().unwrap();
    let drifts: Vec<(&str, &Value)> =
        document["drift"].as_array().unwrap().iter().map(|drift| (drift["of"].as_str().unwrap(), drift)).collect();
    let mut found = 0;
    for (rest, coast) in [(20.0_f64, 20.0_f64), (10.0, 60.0), (120.0, 120.0)] {
        let rate = (coast * (1.0 + coast / rest)).sqrt();
        let twice = (coast.powi(3) / 3.0 + coast.powi(4) / (4.0 * rest)).sqrt();
        let three_times = (coast.powi(5) / 20.0 + coast.powi(6) / (36.0 * rest)).sqrt();
        let own = density("accel_x");
        let tilt = density("gyro_y") * 9.797;
        let expected = [
            ("angle", "gyro_y", density("gyro_y").to_degrees() * rate),
            ("velocity", "accel_x", (own * rate).hypot(tilt * twice)),
            ("position", "accel_x", (own * twice).hypot(tilt * three_times)),
        ];
        for (of, axis, expected) in expected {
            let is_asked =
                |drift: &Value| drift["axis"] == axis && drift["rest_s"] == rest && drift["coast_s"] == coast;
            let Some((_, drift)) = drifts.iter().find(|(kind, drift)| *kind == of && is_asked(drift)) else {
                assert!(of != "angle" && coast > 60.0, "no {of} after {rest} s and {coast} s");
                continue;
            };
            found += 1;
            let std = drift["std"].as_f64().unwrap();
            assert!((std / expected - 1.0).abs() < 0.15, "{of} after {rest} s and {coast} s: {std} for {expected}");
            assert!(drift["within"].as_f64().unwrap() > 1.95 * std);
        }
    }
    assert_eq!((found, drifts.len()), (7, 3 * (3 + 2 + 2)));
}

/// Noise of a quarter of a step is hidden, and a dead axis shows no gravity.
#[test]
fn the_summary_says_why_there_is_no_drift() {
    let folder = tempfile::tempdir().unwrap();
    let coasting = |white: f64, down: f64| {
        let noise = |name: String, mean: f64, white: f64| json!({"name": name, "statistics": {"mean": mean}, "noise": {"white": {"value": white}}});
        let gyro = ["x", "y", "z"].map(|axis| noise(format!("gyro_{axis}"), 0.0, white));
        let accel =
            [("x", 0.0), ("y", 0.0), ("z", down)].map(|(axis, mean)| noise(format!("accel_{axis}"), mean, 1e-3));
        let channels = [gyro, accel].concat();
        let sensor = json!({"source": {"name": "white"}, "timing": {"rate_hz": 40.0}, "channels": channels});
        let path = folder.path().join("white.json");
        fs::write(&path, sensor.to_string()).unwrap();
        let options = ["--message", "VNIMU", "--duration", "10min", "--like", path.to_str().unwrap()];
        let record = capture(folder.path(), "white.vnimu", &options);
        let summary = vn100().args(["replay", "--rate", "40", "--coast", "10s"]).arg(record).output().unwrap().stdout;
        let summary = String::from_utf8(summary).unwrap();
        summary
            .split_once("Coasting ")
            .unwrap()
            .1
            .lines()
            .take(2)
            .map(|line| line.trim().to_owned())
            .collect::<Vec<_>>()
    };
    let hidden = coasting(4e-8, -9.797);
    assert!(hidden.iter().all(|line| line.ends_with(" not measurable: rounding hides the noise")), "{hidden:?}");
    let dead = coasting(1e-4, 0.0);
    assert!(dead[0].contains(" of heading errors "), "{dead:?}");
    assert_eq!(dead[1], "velocity not measurable: the mean acceleration is not gravity");
}

#[test]
fn ten_minutes_of_it_give_means_and_white_noise() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--like", "lab3", "--message", "VNIMU", "--duration", "10min", "--seed", "1"];
    let (document, _) = replay(&capture(folder.path(), "lab3.vnymr", &options), &["--rate", "40"]);
    for (name, mean, std) in [
        ("mag_x", 0.225998, 0.001378),
        ("mag_z", 0.057567, 0.003743),
        ("accel_x", 0.048526, 0.011822),
        ("accel_z", -9.717405, 0.020968),
        ("gyro_x", 0.000051, 0.000638),
    ] {
        let statistics = &channel(&document, name)["statistics"];
        let [found_mean, found_std] = ["mean", "std"].map(|field| statistics[field].as_f64().unwrap());
        // five standard deviations of the mean and of the deviation of 24 000 independent samples
        assert!((found_mean - mean).abs() < 5.0 * std / 24_000_f64.sqrt(), "{name}: {found_mean}");
        assert!((found_std / std - 1.0).abs() < 5.0 / 48_000_f64.sqrt(), "{name}: {found_std}");
    }
    assert!(holds(parameter(&document, "gyro_y", "white"), 0.354 * DEG_SQRT_H));
    assert!(holds(parameter(&document, "accel_y", "white"), 0.114 / 60.0));
    for term in ["bias_instability", "rate_random_walk"] {
        for name in ["gyro_y", "accel_y"] {
            assert_eq!(parameter(&document, name, term)["status"], "bounded", "{name} {term}");
        }
    }
}

#[test]
fn the_static_record_of_a_real_sensor_invents_nothing() {
    let Some(folder) = real_captures() else { return };
    let (document, _) = replay(&folder.join("vn100-static-kiran-330s.vnymr"), &[]);
    // reference from Welch's method between the lines: Blackman-Harris windows of 1024 samples, medians
    // of bands from 0.2 to 16 Hz, 1.17e-4 to 1.24e-4 and 1.8e-3 to 2.4e-3
    let gyro_y = parameter(&document, "gyro_y", "white");
    assert!(gyro_y["lower"].as_f64() < Some(1.24e-4) && gyro_y["upper"].as_f64() > Some(1.17e-4), "{gyro_y}");
    assert!(holds(parameter(&document, "accel_y", "white"), 2.0e-3));
    for term in ["bias_instability", "rate_random_walk", "rate_ramp"] {
        assert_eq!(parameter(&document, "gyro_y", term)["status"], "not-measurable", "{term}");
        assert_ne!(parameter(&document, "accel_y", term)["status"], "estimated", "{term}");
    }
    for kind in ["compensated-stream", "rate-assumed"] {
        assert!(warned(&document, kind), "{kind}");
    }
    // a 1 Hz record is decimated by no more than its rate implies
    let (document, _) = replay(&folder.join("vn100-static1hz-ramirez-run2-623s.csv"), &[]);
    let factor = parameter(&document, "gyro_y", "white")["budget"]["aliasing"]["factor"].as_f64().unwrap();
    assert!((factor / 14.14 - 1.0).abs() < 1e-3, "{factor}");
}

#[test]
fn intervals_follow_the_confidence() {
    let width = |options: &[&str]| {
        let (document, _) = replay(&replay_log("clean-minute.vnymr"), options);
        let point = &channel(&document, "gyro_z")["allan"]["points"][4];
        let white = parameter(&document, "gyro_z", "white");
        assert!(point["lower"].as_f64() < point["deviation"].as_f64());
        [point, white].map(|of| of["upper"].as_f64().unwrap() / of["lower"].as_f64().unwrap())
    };
    let [point, white] = width(&[]);
    let [narrow_point, narrow_white] = width(&["--confidence", "0.5"]);
    let [wide_point, wide_white] = width(&["--confidence", "0.999"]);
    assert!(narrow_point < point && point < wide_point);
    assert!(narrow_white < white && white < wide_white);
    for confidence in ["0", "1", "-1", "95", "NaN", "x"] {
        let output = vn100().args(["replay", "x.vnymr", &format!("--confidence={confidence}")]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{confidence}");
    }
}

#[test]
fn a_measurement_ends_when_the_figure_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "imu.vnymr", &["--message", "VNIMU", "--duration", "10min"]);
    let (document, exit) = replay(&path, &["--rate", "40", "--until", "gyro N ±2%"]);
    assert_eq!(exit, 0);
    let duration_s = document["timing"]["duration_s"].as_f64().unwrap();
    assert!((60.0..600.0).contains(&duration_s), "{duration_s} s");
    for name in ["gyro_x", "gyro_y", "gyro_z"] {
        let white = parameter(&document, name, "white");
        let [value, lower, upper] = ["value", "lower", "upper"].map(|field| white[field].as_f64().unwrap());
        assert!((upper - lower) / 2.0 <= 0.02 * value, "{white}");
    }
    // a looser goal is met earlier, the same one at the same sample for any other goals
    let (looser, _) = replay(&path, &["--rate", "40", "--until", "gyro N +-4%"]);
    assert!(looser["timing"]["duration_s"].as_f64().unwrap() < duration_s);
    let both = ["--rate", "40", "--until", "gyro N ±2%", "--until", "gyro_x N ±50%", "--estimator", "strided"];
    let (again, _) = replay(&path, &both);
    assert_eq!(again["timing"]["samples"], document["timing"]["samples"]);
}

#[test]
fn graphical_readings_have_their_letter_and_their_unit() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "imu.vnymr", &["--message", "VNIMU", "--duration", "10min"]);
    let (document, _) = replay(&path, &["--rate", "40"]);
    let classical = &channel(&document, "gyro_x")["noise"]["classical"];
    let units = ["white", "bias_instability", "rate_random_walk"].map(|name| &classical[name]["unit"]);
    assert_eq!(units, ["rad/s/sqrt(Hz)", "rad/s", "rad/s/sqrt(s)"]);
}

#[test]
fn a_figure_that_the_message_does_not_carry_ends_the_measurement_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "ymr.vnymr", &["--duration", "1min"]);
    for options in [&["--rate", "40"][..], &["--rate", "40", "--skip", "30s"]] {
        let output =
            vn100().args(["replay", "--json", "--until", "gyro B ±20%"]).args(options).arg(&path).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{stderr}");
        assert_eq!(stderr.matches("gyro B is not measurable in VNYMR").count(), 1, "{stderr}");
    }
}

#[test]
fn impossible_magnitudes_on_earth_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "still.vnymr", &["--duration", "30s"]);
    let (document, _) = replay(&path, &[]);
    for kind in ["magnitude-off", "quantisation-floor"] {
        assert!(!warned(&document, kind), "{kind}");
    }
    let names: Vec<_> = document["norms"].as_array().unwrap().iter().map(|norm| norm["name"].clone()).collect();
    assert_eq!(names, ["mag_norm", "accel_norm", "gyro_norm"]);
    assert!((document["norms"][1]["of_mean"].as_f64().unwrap() - 9.80665).abs() < 1e-3);

    let mut table = String::from("ax,ay,az,mx,my,mz\n");
    for row in 0..400 {
        table += &format!("0.00{},0.1,12.5,0.01,0.0{},0.02\n", row % 7, row % 9);
    }
    let path = folder.path().join("odd.csv");
    fs::write(&path, table).unwrap();
    let columns = "accel_x=ax:m/s^2,accel_y=ay:m/s^2,accel_z=az:m/s^2,mag_x=mx:gauss,mag_y=my:gauss,mag_z=mz:gauss";
    let (document, _) = replay(&path, &["--columns", columns, "--rate", "40"]);
    let off: Vec<_> = kinds(&document).into_iter().filter(|kind| *kind == "magnitude-off").collect();
    assert_eq!(off.len(), 2, "acceleration and field");
}

#[test]
fn a_rotation_is_no_warm_up_and_a_line_is_reported_with_its_aliases() {
    let Some(folder) = real_captures() else { return };
    for moved in ["vn100-donut-huang-155s.vnymr", "vn100-walk-circle-sazgar-CORRUPT.vnymr"] {
        let (document, _) = replay(&folder.join(moved), &[]);
        assert!(!warned(&document, "warm-up"), "{moved}");
    }
    let (document, _) = replay(&folder.join("vn100-static-kiran-330s.vnymr"), &[]);
    let told = document["warnings"].to_string();
    assert!(told.contains("gyro_y 18.4") && told.contains("an alias of 21.6, 58.4, 61.6 Hz"), "{told}");
    // a line at half the rate is its own mirror
    let (document, _) = replay(&folder.join("emulator-loop-pattala-449s.vnymr"), &[]);
    let told = document["warnings"].to_string();
    assert!(told.contains("20.00 Hz") && told.contains("an alias of 60.0, 100.0, 140.0 Hz"), "{told}");
}
