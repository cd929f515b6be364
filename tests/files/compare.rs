//! Captures side by side, and plans: the results for equal sensors, for one that is noisier, and
//! for the length of a measurement.

use std::{
    f64::consts::PI,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use serde_json::Value;

use crate::support::{capture, channel, document, replay_log, vn100};

/// A capture of ten minutes with this seed from 1 to 6, made once for all tests.
fn seeded(folder: &Path, seed: usize) -> PathBuf {
    static MADE: [OnceLock<Vec<u8>>; 6] = [const { OnceLock::new() }; 6];
    let name = format!("seed-{seed}.vnimu");
    let options = ["--seed", &seed.to_string(), "--duration", "10min", "--message", "VNIMU"];
    let path = folder.join(&name);
    fs::write(&path, MADE[seed - 1].get_or_init(|| fs::read(capture(folder, &name, &options)).unwrap())).unwrap();
    path
}

/// `vn100 compare --json`, its document and exit code.
fn compare(files: &[PathBuf], options: &[&str]) -> (Value, i32) {
    let output = vn100().arg("compare").args(files).arg("--json").args(options).output().unwrap();
    (document(&output), output.status.code().unwrap())
}

/// Names of channels with an octave that differs between two records.
fn differing(document: &Value) -> Vec<&str> {
    let channels = document["channels"].as_array().unwrap().iter();
    let differs =
        |channel: &&Value| channel["octaves"].as_array().unwrap().iter().any(|octave| octave["differs"] == true);
    channels.filter(differs).map(|channel| channel["name"].as_str().unwrap()).collect()
}

fn sensor<'a>(document: &'a Value, name: &str) -> &'a Value {
    document["sensors"].as_array().unwrap().iter().find(|sensor| sensor["sensor"] == name).unwrap()
}

/// What the records foretell of N of an axis.
fn population(document: &Value) -> &Value {
    let mut all = document["populations"].as_array().unwrap().iter();
    all.find(|one| one["channel"] == "accel_x" && one["parameter"] == "white").unwrap()
}

fn kinds(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|entry| entry["kind"].as_str().unwrap()).collect()
}

/// The angular rates of a `$VNIMU` capture as CSV, with those about x multiplied by `factor`.
fn gyro_csv(capture: &Path, factor: f64) -> PathBuf {
    let mut rows = String::from("wx,wy,wz\n");
    for line in fs::read_to_string(capture).unwrap().lines() {
        let fields: Vec<&str> = line.split(['*', ',']).collect();
        let wx = fields[7].parse::<f64>().unwrap() * factor;
        writeln!(rows, "{wx:.6},{},{}", fields[8], fields[9]).unwrap();
    }
    let path = capture.with_extension("csv");
    fs::write(&path, rows).unwrap();
    path
}

const GYRO_COLUMNS: [&str; 4] = ["--columns", "gyro_x=wx:rad/s,gyro_y=wy:rad/s,gyro_z=wz:rad/s", "--rate", "40"];

#[test]
fn equal_sensors_are_not_reported_as_different() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (1..=6).map(|seed| seeded(folder.path(), seed)).collect();
    let (document, exit) = compare(&files, &["--rate", "40"]);
    assert_eq!((exit, &document["schema"]), (0, &"vn100.comparison/1".into()));
    assert_eq!(document["records"].as_array().unwrap().len(), 6);
    assert_eq!(differing(&document), [""; 0]);
    for name in ["gyro", "accel", "mag"] {
        let sensor = sensor(&document, name);
        assert_eq!(sensor["quietest"], Value::Null, "{name}");
        assert_eq!(sensor["ranked"].as_array().unwrap().len(), 6);
    }
    let octaves = channel(&document, "gyro_x")["octaves"].as_array().unwrap();
    assert!(octaves.len() > 15 * 10, "15 pairs of {} octaves", octaves.len());
    assert_eq!(kinds(&document["caveats"]), [""; 0]);
    assert_eq!(document["same_samples"], Value::Array(vec![]));
    // without names they are records of one sensor
    let of_one = population(&document);
    let sensors = of_one["sensors"].as_array().unwrap();
    assert_eq!((sensors.len(), &sensors[0]["records"]), (1, &serde_json::json!([0, 1, 2, 3, 4, 5])));
    let number = |key: &str| of_one[key].as_f64().unwrap();
    assert!(number("next_lower") < number("lowest") && number("highest") < number("next_upper"), "{of_one}");
}

#[test]
fn a_sensor_with_a_tenth_more_noise_is_found_and_the_quieter_one_named() {
    let folder = tempfile::tempdir().unwrap();
    for seeds in [[1, 2], [3, 4], [5, 6]] {
        let files = [gyro_csv(&seeded(folder.path(), seeds[0]), 1.1), gyro_csv(&seeded(folder.path(), seeds[1]), 1.0)];
        let (document, exit) = compare(&files, &GYRO_COLUMNS);
        assert_eq!(exit, 0);
        assert_eq!(differing(&document), ["gyro_x"], "{seeds:?}");
        let surest = &channel(&document, "gyro_x")["octaves"][0];
        let ratio = surest["deviations"][0].as_f64().unwrap() / surest["deviations"][1].as_f64().unwrap();
        assert!((1.07..1.13).contains(&ratio), "{ratio}");
        assert_eq!(sensor(&document, "gyro")["quietest"], 1, "{seeds:?}");
    }
}

#[test]
fn an_axis_that_one_record_lacks_does_not_rank_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let both = gyro_csv(&seeded(folder.path(), 1), 3.0);
    let rows = fs::read_to_string(&both).unwrap();
    fs::write(&both, rows.replace("wx,wy,wz", "gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s")).unwrap();
    let y_alone = gyro_csv(&seeded(folder.path(), 2), 1.0);
    let rows = fs::read_to_string(&y_alone).unwrap();
    let column: Vec<&str> = rows.lines().map(|row| row.split(',').nth(1).unwrap()).collect();
    fs::write(&y_alone, column.join("\n").replace("wy", "gyro_y_rad_s")).unwrap();
    let (document, _) = compare(&[both, y_alone], &["--rate", "40"]);
    let gyro = sensor(&document, "gyro");
    assert_eq!(gyro["quietest"], Value::Null, "{gyro}");
    let axes = gyro["ranked"].as_array().unwrap().iter().map(|record| record["axes"].as_array().unwrap().len());
    assert_eq!(axes.collect::<Vec<_>>(), [1, 1]);
}

#[test]
fn records_with_different_aliasing_have_no_quietest() {
    let folder = tempfile::tempdir().unwrap();
    let options = |rate: &'static str, seed: &'static str| {
        ["--duration", "10min", "--message", "VNIMU", "--rate", rate, "--seed", seed]
    };
    let fast = capture(folder.path(), "fast.mcap", &options("40", "1"));
    let slow = capture(folder.path(), "slow.mcap", &options("5", "2"));
    let (document, _) = compare(&[slow.clone(), fast.clone()], &[]);
    let ranked = &sensor(&document, "gyro")["ranked"];
    assert_eq!((&ranked[0]["white_factor"], &ranked[1]["white_factor"]), (&Value::Null, &Value::Null), "{ranked}");
    let (document, _) = compare(&[slow.clone(), fast.clone()], &["--window", "4"]);
    let gyro = sensor(&document, "gyro");
    assert_eq!((&gyro["quietest"], &gyro["folds_alike"]), (&Value::Null, &false.into()), "{gyro}");
    assert_eq!(gyro["tests"], Value::Array(vec![]));
    let own: Vec<f64> = (gyro["ranked"].as_array().unwrap().iter())
        .map(|ranked| ranked["white"].as_f64().unwrap() / ranked["white_factor"].as_f64().unwrap())
        .collect();
    assert!((0.8..=1.0).contains(&(own[0] / own[1])), "one sensor, as far as the factors are known: {own:?}");
    let text = vn100().arg("compare").args([&slow, &fast]).output().unwrap().stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("N is not compared"), "{text}");
}

#[test]
fn angles_have_no_mean_and_a_bias_that_is_taken_out_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let ymr = |seed: &str| capture(folder.path(), &format!("{seed}.vnymr"), &["--seed", seed, "--duration", "5min"]);
    let (document, _) = compare(&[ymr("1"), ymr("2")], &[]);
    let means = document["means"].as_array().unwrap();
    let named: Vec<_> = means.iter().map(|means| means["name"].as_str().unwrap()).collect();
    assert_eq!(named.join(" "), "mag_x mag_y mag_z accel_x accel_y accel_z gyro_x gyro_y gyro_z");
    let removed: Vec<_> = means.iter().map(|means| means["bias_removed"] == true).collect();
    assert_eq!(removed, [false, false, false, false, false, false, true, true, true]);
    assert!(means.iter().all(|means| means["spread"]["dof"] == 1 && means["spread"]["deviation"].is_f64()));
}

#[test]
fn a_recording_is_known_again() {
    let folder = tempfile::tempdir().unwrap();
    let first = capture(folder.path(), "first.mcap", &["--duration", "2min", "--message", "VNIMU", "--seed", "1"]);
    let again = folder.path().join("again.mcap");
    fs::copy(&first, &again).unwrap();
    let files = [first, again];
    let (document, _) = compare(&files, &[]);
    assert_eq!(document["same_samples"], serde_json::json!([{ "records": [0, 1], "of_first": 1.0, "of_second": 1.0 }]));
    assert_eq!((kinds(&document["caveats"]), &document["channels"]), (vec!["same-samples"], &serde_json::json!([])));
    let text = String::from_utf8(vn100().arg("compare").args(&files).output().unwrap().stdout).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn the_disturbed_record_is_named_with_the_time() {
    let folder = tempfile::tempdir().unwrap();
    let [quiet, slammed] = [1, 2].map(|seed| gyro_csv(&seeded(folder.path(), seed), 1.0));
    // five standard deviations for a second, after five minutes
    let rows = fs::read_to_string(&slammed).unwrap();
    let rows = rows.lines().enumerate().fold(String::new(), |mut rows, (number, line)| {
        match line.split_once(',').map(|(wx, rest)| (wx.parse::<f64>(), rest)) {
            Some((Ok(wx), rest)) if (12_001..12_041).contains(&number) => writeln!(rows, "{:.6},{rest}", wx + 4.3e-3),
            _ => writeln!(rows, "{line}"),
        }
        .unwrap();
        rows
    });
    fs::write(&slammed, rows).unwrap();
    let (document, _) = compare(&[quiet, slammed.clone()], &GYRO_COLUMNS);
    let [disturbance] = &document["disturbances"].as_array().unwrap()[..] else { panic!("{document}") };
    assert_eq!((&disturbance["record"], &disturbance["kind"]), (&1.into(), &"not-stationary".into()));
    assert_eq!(disturbance["channels"], serde_json::json!(["gyro_x"]));
    let told = disturbance["text"].as_str().unwrap().to_owned();
    assert!(told.contains("from 5:00 to 5:0") && !told.contains("from 5:00 to 5:00"), "{told}");
    // if a part is left out, the times are still those of the record, in words and numbers
    let output =
        vn100().args(["replay", "--json", "--skip", "2min"]).args(GYRO_COLUMNS).arg(&slammed).output().unwrap();
    let document = crate::support::document(&output);
    let warnings = document["warnings"].as_array().unwrap();
    let text = |warning: &Value| warning["text"].as_str().unwrap().to_owned();
    assert!(warnings.iter().any(|warning| text(warning).contains("from 5:00 to 5:0")), "{warnings:?}");
    let gyro_x = channel(&document, "gyro_x");
    let found = &gyro_x["stationarity"]["disturbances"][0];
    let [start_s, end_s] = ["start_s", "end_s"].map(|name| found[name].as_f64().unwrap());
    assert!((299.0..=300.5).contains(&start_s) && (300.5..303.0).contains(&end_s), "{found}");
    assert_eq!(gyro_x["blocks"][0]["start_s"], 120.0);
}

#[test]
fn incomparable_parts_are_reported_and_the_rest_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        capture(folder.path(), "ymr-40", &["--duration", "5min"]),
        capture(folder.path(), "imu-20", &["--duration", "5min", "--rate", "20", "--message", "VNIMU", "--seed", "2"]),
        capture(
            folder.path(),
            "imu-50.mcap",
            &["--duration", "5min", "--rate", "50", "--message", "VNIMU", "--seed", "3"],
        ),
        folder.path().join("missing"),
    ];
    // the rate of a text capture is not known: 40 Hz are assumed, correctly for the first and wrongly for
    // the second
    let (document, exit) = compare(&files, &[]);
    assert_eq!(exit, 3);
    let records = document["records"].as_array().unwrap();
    assert!(records[3]["error"].as_str().unwrap().contains("missing"));
    assert_eq!(records[3]["samples"], 0);
    let found = kinds(&document["caveats"]);
    for kind in ["no-samples", "rate-assumed", "channels", "compensation", "no-common-tau", "sampling"] {
        assert!(found.contains(&kind), "{kind}: {found:?}");
    }
    let octaves = channel(&document, "gyro_x")["octaves"].as_array().unwrap();
    assert!(!octaves.is_empty());
    for octave in octaves {
        assert_eq!(octave["records"], serde_json::json!([0, 1]));
        assert!(octave["tau_s"].as_f64().unwrap() <= 10.0, "a bias that is taken out is not compared: {octave}");
    }
    let text = vn100().arg("compare").args(&files).output().unwrap();
    assert_eq!(text.status.code(), Some(3));
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("! the gyroscope's bias") && text.contains("missing: nothing to compare"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn no_test_is_reported_without_a_shared_octave() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, rate: &str| {
        capture(folder.path(), name, &["--duration", "1min", "--message", "VNIMU", "--rate", rate])
    };
    let text = vn100().arg("compare").args([of("a.mcap", "40"), of("b.mcap", "50")]).output().unwrap().stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("differences of deviations\n  nothing could be tested\n"), "{text}");
    assert!(!text.contains("\n  none\n"), "{text}");
}

#[test]
fn one_capture_and_options_of_one_capture_are_no_comparison() {
    let files = ["clean-minute.vnymr", "gaps.vnymr"].map(replay_log);
    let exit = |arguments: &[&str], files: &[PathBuf]| {
        vn100().arg("compare").args(files).args(arguments).output().unwrap().status.code()
    };
    assert_eq!(exit(&[], &files[..1]), Some(2));
    assert_eq!(exit(&["--ndjson"], &files), Some(2));
}

fn plan(options: &[&str]) -> Value {
    let output = vn100().args(["plan", "--json"]).args(options).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    document(&output)
}

#[test]
fn a_plan_fits_the_line_and_its_window_is_exact() {
    for (options, message, rate, window, baud) in [
        (&[][..], "BINARY", 200, 4, 115_200),
        (&["--baud", "9600"], "BINARY", 16, 50, 9600),
        (&["--baud", "921600"], "BINARY", 200, 4, 921_600),
        (&["--rate", "800"], "BINARY", 800, 1, 460_800),
        (&["--message", "BINARY+MAG"], "BINARY+MAG", 160, 5, 115_200),
        (&["--message", "VNIMU"], "VNIMU", 40, 20, 115_200),
        (&["--message", "VNIMU", "--baud", "9600"], "VNIMU", 5, 160, 9600),
        (&["--message", "VNIMU", "--rate", "200"], "VNIMU", 200, 4, 460_800),
        (&["--message", "VNIMU", "--rate", "100", "--baud", "128000"], "VNIMU", 100, 8, 128_000),
    ] {
        let document = plan(&[options, &["--want", "gyro N ±5%"]].concat());
        assert_eq!(document["schema"], "vn100.plan/1");
        let settings = &document["settings"];
        assert_eq!(settings["message"], message);
        assert_eq!((&settings["rate_hz"], &settings["window"]), (&rate.into(), &window.into()), "{options:?}");
        assert_eq!(settings["baud"], baud, "{options:?}");
        assert!(settings["line_bytes"].as_u64().unwrap() * rate * 10 <= baud);
        let commands = &document["commands"];
        let set = format!("--set-message {message} --set-rate {rate} --window {window}");
        let setting = if message == "VNIMU" { &commands["configure"] } else { &commands["attach"] };
        assert!(setting.as_str().unwrap().contains(&set), "{commands}");
    }
    let output = vn100().args(["plan", "--message", "VNIMU", "--rate", "200", "--baud", "115200"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("reduce the rate to 50 Hz"));
    let output = vn100().args(["plan", "--message", "VNQTN"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_plan_is_as_long_as_its_longest_goal() {
    let wants = ["--want", "gyro N ±5%", "--want", "gyro B", "--want", "gyro K >= 2e-7 rad/s/sqrt(s)"];
    let document = plan(&wants);
    let seconds: Vec<f64> =
        document["wants"].as_array().unwrap().iter().map(|want| want["record_s"].as_f64().unwrap()).collect();
    assert!(seconds[0] < seconds[1] && seconds[1] < seconds[2], "{seconds:?}");
    let all = document["record_s"].as_f64().unwrap();
    assert!((seconds[2]..1.05 * seconds[2]).contains(&all), "{all} of {seconds:?}");
    let attach = document["commands"]["attach"].as_str().unwrap();
    assert!(attach.contains("--skip 30min") && attach.contains("--duration"), "{attach}");
    let text = String::from_utf8(
        vn100().args(["plan", "--message", "BINARY+MAG", "--rate", "200"]).args(wants).output().unwrap().stdout,
    )
    .unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("magnetometer is not averaged: aliasing raises its N 1.12 times, sqrt(250/200)"), "{text}");
    let asked = vn100().args(["plan", "--want", "gyro K >= 0.5 °/h/√h"]).output().unwrap().stdout;
    assert!(String::from_utf8(asked).unwrap().contains("gyro K >= 0.5 deg/h^1.5 "), "in its own unit");
    for wrong in ["gyro N", "gyro K", "mag B", "gyro N ±x%"] {
        assert_eq!(vn100().args(["plan", "--want", wrong]).output().unwrap().status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn a_plan_is_for_the_sensor_of_the_data_sheet() {
    let of = |document: &Value| document["wants"][0]["record_s"].as_f64().unwrap();
    let built_in = plan(&["--want", "gyro B"]);
    // 5 deg/h as the minimum of the deviation are a B of 5/0.664
    let assumed = built_in["assumed"][0]["bias_instability"].as_f64().unwrap();
    assert!((assumed / (5.0 / 0.664 / 3600.0_f64).to_radians() - 1.0).abs() < 1e-3, "{assumed}");
    let folder = tempfile::tempdir().unwrap();
    let sheet = folder.path().join("better.toml");
    let white =
        "[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\nunit = \"deg/s/sqrt(Hz)\"\ntypical = 0.0035\n";
    let bias = "[[figure]]\nsensor = \"gyroscope\"\nparameter = \"bias_instability\"\nunit = \"deg/h\"\nlimit = 1.0\n";
    fs::write(&sheet, format!("name = \"better\"\n{white}{bias}")).unwrap();
    let better = plan(&["--want", "gyro B", "--datasheet", sheet.to_str().unwrap()]);
    assert!(of(&better) > 4.0 * of(&built_in), "{} s against {} s", of(&better), of(&built_in));
    fs::write(&sheet, format!("name = \"better\"\n{white}")).unwrap();
    let output = vn100().args(["plan", "--want", "gyro B", "--datasheet"]).arg(&sheet).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("its own size") && error.contains("better"), "{error}");
}

/// A record of the planned length and with the planned window shows the requested parameters.
#[test]
fn a_record_of_the_planned_length_meets_the_goals() {
    let document = plan(&["--want", "gyro N ±2%", "--rate", "200"]);
    let seconds = format!("{}s", document["wants"][0]["record_s"].as_f64().unwrap().ceil());
    let folder = tempfile::tempdir().unwrap();
    // the factory default of the window is exact at 200 Hz
    let file = capture(folder.path(), "n", &["--duration", &seconds, "--rate", "200", "--message", "VNIMU"]);
    let output = vn100().arg("replay").arg(file).args(["--rate", "200", "--json"]).output().unwrap();
    let measured = crate::support::document(&output);
    for axis in ["gyro_x", "gyro_y", "gyro_z"] {
        let white = &channel(&measured, axis)["noise"]["white"];
        let number = |name: &str| white[name].as_f64().unwrap();
        let half_width = (number("upper") - number("lower")) / 2.0 / number("value");
        assert!((0.006..0.022).contains(&half_width), "{axis}: {half_width}");
        assert!((number("value") / 0.0035_f64.to_radians() - 1.0).abs() < 0.04, "{axis}: {white}");
    }
}

#[test]
fn three_sensors_foretell_the_next_and_a_copy_counts_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> = (1..=4).map(|seed| seeded(folder.path(), seed)).collect();
    let copy = folder.path().join("copy.vnymr");
    fs::copy(&files[1], &copy).unwrap();
    files.push(copy);
    let names = ["a", "b", "c", "a", "b"];
    let options: Vec<&str> =
        ["--rate", "40"].into_iter().chain(names.iter().flat_map(|name| ["--sensor", name])).collect();
    let (document, _) = compare(&files, &options);
    let of_three = population(&document);
    let records: Vec<&Value> = of_three["sensors"].as_array().unwrap().iter().map(|unit| &unit["records"]).collect();
    assert_eq!(records, [&serde_json::json!([0, 3]), &serde_json::json!([1]), &serde_json::json!([2])]);
    assert!(of_three["next_upper"].is_number() && of_three["no_interval"].is_null(), "{of_three}");
    // a parameter with only a bound has no interval
    let bounded = document["populations"].as_array().unwrap().iter().find(|one| one["spread"].is_null()).unwrap();
    assert!(bounded["no_interval"] == "bound" && bounded["next_upper"].is_null());
    let text = vn100().arg("compare").args(&files).args(&options).output().unwrap();
    let text = String::from_utf8(text.stdout).unwrap();
    for expected in ["Sensors\n", "  median", "  spread, %", "  next, lower", "no interval: a recording only bounds it"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn a_record_in_other_units_is_the_same_recording() {
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str, mut state: u64, unit: &str, factor: f64| {
        let mut text = format!("t,gyro_x [{unit}],gyro_y [{unit}],gyro_z [{unit}]\n");
        for row in 0..5000 {
            let rates = [0.1, -0.2, 0.05].map(|mean| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                format!(",{:.7}", factor * (mean + (state % 10_000) as f64 * 1e-5))
            });
            writeln!(text, "{:.2}{}", f64::from(row) * 0.01, rates.concat()).unwrap();
        }
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let degrees = table("degrees.csv", 1, "deg/s", 1.0);
    for (state, expected) in [(1, vec!["same-samples"]), (2, vec![])] {
        let (document, _) = compare(&[degrees.clone(), table("radians.csv", state, "rad/s", PI / 180.0)], &[]);
        assert_eq!(kinds(&document["caveats"]), expected, "{state}");
    }
}
