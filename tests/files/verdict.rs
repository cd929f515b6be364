//! Measurements against data sheets, end to end: verdicts, grades and the exit code for scripts.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;

use crate::support::{channel, document, real_captures, replay, vn100};

const GYRO: [&str; 3] = ["gyro_x", "gyro_y", "gyro_z"];
const RATE: [&str; 2] = ["--rate", "40"];

/// `$body*XX`, with its checksum.
fn sentence(body: &str) -> String {
    let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{checksum:02X}\r\n")
}

/// The averaging reported by the sensor.
fn register_85(window: u32) -> String {
    sentence(&format!("VNRRG,85,0,{window},{window},4,0,0,3,3,3,0"))
}

/// A capture of the emulated sensor, a window of 4 at 40 Hz, after `first`.
fn capture(folder: &Path, name: &str, message: &str, duration: &str, first: &str) -> PathBuf {
    let path = folder.join(name);
    let seeded = ["--message", message, "--duration", duration, "--seed", "3"];
    let output = vn100().args(["sim", "-o"]).arg(&path).args(seeded).output();
    assert!(output.unwrap().status.success());
    let lines = fs::read_to_string(&path).unwrap();
    fs::write(&path, first.to_owned() + &lines).unwrap();
    path
}

/// The `$VNIMU` capture with the rates about x, y and z multiplied by `factors`.
fn scaled(capture: &Path, factors: [f64; 3]) -> PathBuf {
    let mut lines = String::new();
    for line in fs::read_to_string(capture).unwrap().lines() {
        let fields: Vec<&str> = line.trim_start_matches('$').split(['*', ',']).collect();
        if fields[0] == "VNIMU" {
            let mut body = fields[..7].join(",");
            for (field, factor) in fields[7..10].iter().zip(factors) {
                write!(body, ",{:+010.6}", field.parse::<f64>().unwrap() * factor).unwrap();
            }
            write!(body, ",{}", fields[10..fields.len() - 1].join(",")).unwrap();
            lines += &sentence(&body);
        } else {
            lines += line;
            lines += "\r\n";
        }
    }
    let path = capture.with_extension("scaled");
    fs::write(&path, lines).unwrap();
    path
}

/// The comparisons of `parameter` on one channel.
fn verdicts<'a>(document: &'a Value, name: &str, parameter: &str) -> Vec<&'a Value> {
    let all = channel(document, name)["verdict"].as_array().unwrap();
    all.iter().filter(|comparison| comparison["parameter"] == parameter).collect()
}

/// A verdict, and what would decide it; empty for a typical figure.
fn words(comparison: &Value) -> String {
    let words = ["verdict", "decided_by"].map(|key| comparison[key].as_str().unwrap_or_default());
    words.join(" ").trim().to_owned()
}

/// The one verdict on `parameter`.
fn verdict(document: &Value, name: &str, parameter: &str) -> String {
    let [comparison] = verdicts(document, name, parameter)[..] else { panic!("{name} {parameter}: not one verdict") };
    words(comparison)
}

/// The ratio of the one figure of `parameter`, and the ends of its interval.
fn ratio(document: &Value, name: &str, parameter: &str) -> (Option<f64>, f64, f64) {
    let [comparison] = verdicts(document, name, parameter)[..] else { panic!("{name} {parameter}: not one verdict") };
    let of = |end: &str| comparison["ratio"][end].as_f64();
    (of("value"), of("lower").unwrap(), of("upper").unwrap())
}

/// `vn100 replay` with options: exit code and standard error.
fn ended(file: &Path, options: &[&str]) -> (i32, String) {
    let output = vn100().arg("replay").arg(file).args(options).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// A sheet with one figure of white noise of the gyroscope.
fn sheet(folder: &Path, claim: &str) -> PathBuf {
    let path = folder.join("sheet.toml");
    let figure = "[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\n";
    fs::write(&path, format!("name = \"x\"\n{figure}{claim}\n")).unwrap();
    path
}

const LIMIT: &str = "limit = 0.21\nunit = \"deg/sqrt(h)\"";

/// What is said of N of the x axis of the gyroscope beside its verdict.
fn reason_of_n(file: &Path, options: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("r.html");
    let output = vn100().args(["report", "--export", "csv", "-o"]).arg(&page).arg(file).args(options).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let table = fs::read_to_string(page.with_extension("verdicts.csv")).unwrap();
    let row = table.lines().find(|row| row.starts_with("gyro_x,white,")).unwrap();
    row.trim_end_matches('"').to_owned()
}

#[test]
fn a_sensor_that_is_as_its_sheet_says_is_typical_though_it_reads_twice_as_much() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "told.txt", "VNIMU", "10min", &register_85(4));
    let as_limit = [&RATE[..], &["--typical-is-limit", "--fail-on", "gyro N", "--fail-on", "accel_z N"]].concat();
    let (document, exit) = replay(&file, &as_limit);
    assert_eq!((exit, verdict(&document, "gyro_x", "white")), (0, "pass".into()));
    let (document, _) = replay(&file, &RATE);
    for name in GYRO {
        let comparison = verdicts(&document, name, "white")[0];
        assert_eq!((&comparison["verdict"], &comparison["claim"]), (&Value::Null, &"typical".into()));
        assert_eq!(comparison["figure"], "typically 0.2 deg/sqrt(h)");
        assert!(comparison["source"].as_str().unwrap().contains("quote"), "{comparison}");
        for end in comparison["factor"].as_array().unwrap() {
            assert!((end.as_f64().unwrap() - 5_f64.sqrt()).abs() < 1e-9);
        }
        // the sensor has 0.21, and is known to 10 %
        let (value, lower, upper) = ratio(&document, name, "white");
        assert!((value.unwrap() - 1.05).abs() < 0.05 && lower < 0.98 && upper > 1.12, "{value:?} {lower} {upper}");
    }
    let text = reason_of_n(&file, &RATE);
    assert!(text.contains(" x typical (") && text.contains("no guarantee"), "{text}");
    assert_eq!(channel(&document, "temperature")["verdict"], Value::Null);
    let summary = vn100().arg("replay").arg(&file).args(RATE).output().unwrap().stdout;
    let summary = String::from_utf8(summary).unwrap();
    assert!(summary.contains(" x typ\n"), "{summary}");
}

#[test]
fn one_noisy_axis_fails_only_if_what_is_typical_is_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "told.txt", "VNIMU", "10min", &register_85(4));
    let file = scaled(&file, [1.4, 1.0, 1.0]);
    let (document, exit) = replay(&file, &RATE);
    assert_eq!(exit, 0, "nothing was asked for");
    assert!(ratio(&document, "gyro_x", "white").1 > 1.25 && ratio(&document, "gyro_y", "white").2 < 1.3);
    let asked = [&RATE[..], &["--fail-on", "gyro N"]].concat();
    let (exit, said) = ended(&file, &asked);
    assert!(exit == 4 && said.contains("--fail-on \"gyro N\" needs a limit"), "{said}");
    assert!(said.contains("gyro_x has no limit in the data sheet"), "{said}");
    let (exit, said) = ended(&file, &[&asked[..], &["--typical-is-limit"]].concat());
    assert_eq!(exit, 4);
    assert!(said.contains("gyro_x is fail, measured") && !said.contains("gyro_y"), "{said}");
    let quiet_axis = [&RATE[..], &["--fail-on", "gyro_y N", "--typical-is-limit"]].concat();
    assert_eq!(ended(&file, &quiet_axis).0, 0);
}

#[test]
fn a_moved_sensor_is_not_compared_and_every_output_gives_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "told.txt", "VNIMU", "2min", &register_85(4));
    // fifty times the noise at rest is below the level of motion, ninety times is above
    assert!(channel(&replay(&scaled(&file, [50.0; 3]), &RATE).0, "gyro_x")["verdict"].is_array());
    let moved = scaled(&file, [90.0, 1.0, 1.0]);
    let (document, exit) = replay(&moved, &RATE);
    assert_eq!((exit, &channel(&document, "gyro_y")["verdict"]), (0, &Value::Null), "nothing was asked for");
    assert_eq!(channel(&document, "gyro_x")["grade"]["reason"], "moved");
    let why = "sensor moved: standard deviation of gyro_x 0.0";
    let warning = document["warnings"].as_array().unwrap().iter().find(|warning| warning["kind"] == "not-stationary");
    assert!(warning.unwrap()["text"].as_str().unwrap().starts_with(why));
    let (exit, said) = ended(&moved, &["--rate", "40", "--fail-on", "accel N"]);
    assert!(exit == 4 && said.contains(&format!("accel N does not pass: {why}")), "{said}");
    let text = vn100().arg("replay").arg(&moved).args(RATE).output().unwrap().stdout;
    assert!(String::from_utf8(text).unwrap().contains(&format!("MOVED    {why}")));
}

#[test]
fn no_parameter_is_given_of_a_moved_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let moved = scaled(&capture(folder.path(), "told.txt", "VNIMU", "2min", &register_85(4)), [90.0, 1.0, 1.0]);
    let withheld = |parameter: &Value, at: &str| {
        assert_eq!(parameter["status"], "moved", "{at}");
        assert!(["value", "lower", "upper"].iter().all(|end| parameter[*end].is_null()), "{at}: {parameter}");
    };
    let goals = ["--until", "gyro N ±90%", "--until", "accel_z N ±90%"];
    let (document, exit) = replay(&moved, &[&RATE[..], &goals].concat());
    assert_eq!(exit, 4, "no goal is met by the motion");
    for name in ["gyro_x", "gyro_y", "accel_z", "mag_x"] {
        let noise = &channel(&document, name)["noise"];
        let of_long_taus = ["bias_instability", "rate_random_walk", "curve_minimum"];
        for parameter in ["white"].iter().chain(of_long_taus.iter().filter(|_| name != "mag_x")) {
            withheld(&noise[parameter], &format!("{parameter} of {name}"));
        }
        withheld(&noise["white"]["budget"]["unaliased"], name);
        assert!(noise["fit"].is_null(), "{name}");
        let points = channel(&document, name)["allan"]["points"].as_array().unwrap();
        assert!(points.iter().all(|point| point["fitted"].is_null() && point["deviation"].is_f64()), "{name}");
    }
}

#[test]
fn the_window_may_be_given_if_the_capture_does_not_contain_it() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = capture(folder.path(), "unknown.txt", "VNIMU", "10min", "");
    let sheet = sheet(folder.path(), "limit = 0.25\nunit = \"deg/sqrt(h)\"");
    let asked = ["--rate", "40", "--datasheet", sheet.to_str().unwrap(), "--fail-on", "gyro N"];
    assert_eq!(ended(&unknown, &asked).0, 4);
    let given = |window| [&asked[..], &["--window", window]].concat();
    let (document, exit) = replay(&unknown, &given("4"));
    assert_eq!((exit, verdict(&document, "gyro_x", "white")), (0, "pass".into()));
    let budget = &channel(&document, "gyro_x")["noise"]["white"]["budget"];
    assert_eq!(budget["aliasing"]["window_from"], "option");
    // the same noise from a window of 20 is too much
    let (document, exit) = replay(&unknown, &given("20"));
    assert_eq!((exit, verdict(&document, "gyro_x", "white")), (4, "fail".into()));
    // the capture knows better
    let known = capture(folder.path(), "known.txt", "VNIMU", "10min", &register_85(4));
    let (document, exit) = replay(&known, &given("20"));
    assert_eq!((exit, verdict(&document, "gyro_x", "white")), (0, "pass".into()));
    let warnings = document["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning["text"].as_str().unwrap().contains("averaging window 20 ignored")));
    assert_eq!(ended(&unknown, &["--window", "0"]).0, 2);
}

#[test]
fn with_the_window_that_averages_all_samples_the_sheet_applies_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "whole.txt", "VNIMU", "1h", &register_85(20));
    // the noise of a window of 4 is too much for one of 20
    let file = scaled(&file, [1.0, 1.0 / 2.307, 0.97 / 2.307]);
    let sheet = sheet(folder.path(), LIMIT);
    let (document, _) = replay(&file, &["--rate", "40", "--datasheet", sheet.to_str().unwrap()]);
    let of = |name| verdicts(&document, name, "white")[0];
    assert_eq!(of("gyro_x")["factor"], Value::from(vec![1.0; 2]));
    assert_eq!(GYRO.map(|name| verdict(&document, name, "white")), ["fail", "undecided nothing", "pass"]);
}

#[test]
fn rates_without_their_bias_have_no_bias_instability_and_no_grade() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "compensated.txt", "VNYMR", "10min", &register_85(4));
    let (document, _) = replay(&file, &RATE);
    for name in GYRO {
        let bias = verdicts(&document, name, "bias_instability");
        assert_eq!(bias.len(), 2);
        assert!(bias.iter().all(|comparison| comparison["verdict"] == "not-comparable"));
        let grade = &channel(&document, name)["grade"];
        assert_eq!([&grade["best"], &grade["worst"]], [&Value::Null; 2]);
        assert_eq!(grade["reason"], "bias-not-in-stream");
    }
    assert_eq!(channel(&document, "accel_x")["grade"], Value::Null);
    let (exit, said) = ended(&file, &["--rate", "40", "--fail-on", "gyro B"]);
    assert_eq!(exit, 4);
    assert!(said.contains("gyro_x is not comparable"), "{said}");
}

#[test]
fn five_hours_show_bias_instability_and_grade() {
    let folder = tempfile::tempdir().unwrap();
    let file = capture(folder.path(), "long.txt", "VNIMU", "5h", &register_85(4));
    let (document, exit) = replay(&file, &["--rate", "40", "--fail-on", "gyro B", "--fail-on", "accel B"]);
    assert_eq!(exit, 0);
    for name in GYRO {
        // B is 6 deg/h, and the minimum of its curve 0.664 times that
        let [limit, _] = verdicts(&document, name, "bias_instability")[..] else { panic!() };
        assert_eq!([&limit["claim"], &limit["is_minimum"]], [&Value::from("limit"), &Value::from(true)]);
        let [lower, upper] = ["lower", "upper"].map(|end| limit["measured"][end].as_f64().unwrap());
        assert!(lower < 1.932e-5 && 1.932e-5 < upper, "{lower} to {upper}");
        let grade = &channel(&document, name)["grade"];
        assert_eq!([&grade["best"], &grade["worst"]], ["industrial"; 2]);
        let minimum = &channel(&document, name)["noise"]["curve_minimum"];
        assert_eq!(["lower", "upper"].map(|end| &minimum[end]), ["lower", "upper"].map(|end| &limit["measured"][end]));
    }
    // 6 deg/h of flicker noise are above 5; the minimum of its curve is not, but its interval reaches there
    let figure = |convention: &str| {
        format!(
            "[[figure]]\nsensor = \"gyroscope\"\nparameter = \"bias_instability\"\nlimit = 5\nunit = \"deg/h\"\nconvention = \"{convention}\"\n"
        )
    };
    let path = folder.path().join("sheet.toml");
    fs::write(&path, format!("name = \"x\"\n{}{}", figure("minimum"), figure("flicker"))).unwrap();
    let (document, _) = replay(&file, &["--rate", "40", "--datasheet", path.to_str().unwrap()]);
    let judged: Vec<String> = verdicts(&document, "gyro_x", "bias_instability").into_iter().map(words).collect();
    assert_eq!(judged, ["undecided longer-record", "fail"]);
}

#[test]
fn other_sensors_are_compared_with_the_sheet_that_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let capture = capture(folder.path(), "other.txt", "VNIMU", "10min", "");
    let mut rows = String::from("wx,wy,wz\n");
    for line in fs::read_to_string(&capture).unwrap().lines() {
        let fields: Vec<&str> = line.split(['*', ',']).collect();
        writeln!(rows, "{},{},{}", fields[7], fields[8], fields[9]).unwrap();
    }
    let csv = folder.path().join("other.csv");
    fs::write(&csv, rows).unwrap();
    let columns = ["--columns", "gyro_x=wx:rad/s,gyro_y=wy:rad/s,gyro_z=wz:rad/s", "--rate", "40"];
    let (document, _) = replay(&csv, &columns);
    assert_eq!(channel(&document, "gyro_x")["verdict"], Value::Null);
    assert_eq!(ended(&csv, &[&columns[..], &["--fail-on", "gyro N"]].concat()).0, 4);
    // the noise is 0.47 deg/√h, which is 0.0111 deg/s/√Hz one-sided
    let judged = |onboard: &str, limit: f64, convention: &str| {
        let claim = format!(
            "sensor = \"gyroscope\"\nparameter = \"white\"\nlimit = {limit}\nunit = \"deg/s/sqrt(Hz)\"\nconvention = \"{convention}\"\n"
        );
        let path = folder.path().join("sheet.toml");
        fs::write(&path, format!("name = \"x\"\n{onboard}[[figure]]\n{claim}")).unwrap();
        let (document, _) = replay(&csv, &[&columns[..], &["--datasheet", path.to_str().unwrap()]].concat());
        verdict(&document, "gyro_x", "white")
    };
    let (exact, folded) = ("[onboard]\nrefresh_hz = 40\nwindow = 1\n", "[onboard]\nrefresh_hz = 800\nwindow = 4\n");
    assert_eq!(judged(exact, 0.0085, "two-sided"), "pass");
    assert_eq!(judged(exact, 0.0085, "one-sided"), "fail");
    assert_eq!(judged(folded, 0.0085, "one-sided"), "pass");
    assert_eq!(judged(folded, 0.0035, "two-sided"), "undecided unaliased");
    // a sheet that says nothing of its averaging is compared with the stream as it is
    assert_eq!(judged("", 0.0085, "two-sided"), "pass");
    // neighbours that share refreshes make white noise read low, unless the fit was told
    assert_eq!(judged("[onboard]\nrefresh_hz = 40\nwindow = 8\n", 0.0085, "two-sided"), "undecided window");
    // of a foreign sensor no word of a VN-100 is said
    let sheet = folder.path().join("sheet.toml");
    let summary = vn100().arg("replay").arg(&csv).args(columns).arg("--datasheet").arg(sheet).output().unwrap();
    let summary = String::from_utf8(summary.stdout).unwrap();
    assert!(!summary.contains("register") && !summary.contains("set-message"), "{summary}");
}

#[test]
fn a_wrong_sheet_or_figure_is_reported_before_any_read() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = folder.path().join("wrong.toml");
    fs::write(
        &sheet,
        "name = \"x\"\n\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\nlimit = 1\nunit = \"deg/h\"\n",
    )
    .unwrap();
    let missing = folder.path().join("missing.txt");
    let (exit, said) = ended(&missing, &["--datasheet", sheet.to_str().unwrap()]);
    assert_eq!(exit, 1);
    for part in ["wrong.toml", "line 3", "deg/sqrt(h)"] {
        assert!(said.contains(part), "{said}");
    }
    for no_figure in ["gyro R", "gyro_w N", "yaw N", "mag B"] {
        assert_eq!(ended(&missing, &["--fail-on", no_figure]).0, 2, "{no_figure}");
        assert_eq!(ended(&missing, &["--until", &format!("{no_figure} ±5%")]).0, 2, "{no_figure}");
    }
    assert_eq!(ended(&missing, &["--fail-on", "gyro N"]).0, 3, "no data is worse than no verdict");
    let file = capture(folder.path(), "short.txt", "VNIMU", "20s", "");
    let (exit, said) = ended(&file, &["--rate", "40", "--fail-on", "mag_x N", "--fail-on", "gyro_x K"]);
    assert_eq!(exit, 4);
    assert!(
        said.contains("\"mag_x N\" needs a limit") && said.contains("gyro_x has no limit in the data sheet"),
        "{said}"
    );
}

#[test]
fn the_static_record_agrees_with_the_sheet_as_far_as_decidable() {
    let Some(folder) = real_captures() else { return };
    let file = folder.join("vn100-static-kiran-330s.vnymr");
    let output = vn100().arg("replay").arg(file).args(["--rate", "40", "--json"]).output().unwrap();
    let document = document(&output);
    for name in GYRO {
        let (value, lower, upper) = ratio(&document, name, "white");
        assert!(value.is_none() && lower < 1.0 && upper > 1.0, "{name}: {lower} {upper}");
        let bias = verdicts(&document, name, "bias_instability");
        assert!(bias.iter().all(|comparison| comparison["verdict"] == "not-comparable"), "{name}");
    }
}

/// Records of 0.4 to 20 s, most too short for a part of the model.
#[test]
fn a_record_that_would_decide_is_longer_than_this_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = capture(folder.path(), "short.vnymr", "VNYMR", "20s", "");
    for tenths in [4, 7, 10, 20, 50, 200] {
        let length_s = f64::from(tenths) / 10.0;
        let (document, _) = replay(&path, &["--rate", "40", "--duration", &length_s.to_string()]);
        for name in ["gyro_x", "accel_x", "accel_z"] {
            let of_axis = channel(&document, name);
            for verdict in of_axis["verdict"].as_array().into_iter().flatten() {
                let Some(deciding_s) = verdict["deciding_record_s"].as_f64() else { continue };
                assert!(deciding_s > length_s, "{name}, {length_s} s: {verdict}");
                let is_white = verdict["parameter"] == "white";
                assert!(is_white || of_axis["noise"]["white"]["value"].is_number(), "{name}, {length_s} s: {verdict}");
            }
        }
    }
}
