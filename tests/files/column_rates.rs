//! Tables whose columns come at different rates.

use std::{fmt::Write, fs};

use serde_json::Value;

use crate::support::{channel, document, replay, vn100, warned, with_stdin};

const ROWS: i64 = 8000;
const COLUMNS: &str = "gyro_x=gyro_x:rad/s,accel_z=accel_z:m/s^2,mag_x=mag_x:gauss,t=t:s";

/// A rate and an acceleration in each row, spaced by 10 ms, and a magnetic field in every fourth;
/// or the field 3 ms later, in rows of its own.
fn table(are_apart: bool) -> String {
    let mut text = "t,gyro_x,accel_z,mag_x\n".to_owned();
    for row in 0..ROWS {
        let noise = |factor: i64| (row * row * factor + row) % 997 - 498;
        let time_ms = row * 10;
        let inertial = format!("{:.6},{:.4}", noise(31) as f64 * 1e-6, noise(77) as f64 * 1e-4 - 9.8);
        let field = format!("{:.4}", noise(59) as f64 * 1e-4);
        let seconds = |ms: i64| format!("{}.{:03}", ms / 1000, ms % 1000);
        match (row % 4 == 0, are_apart) {
            (false, _) => writeln!(text, "{},{inertial},", seconds(time_ms)),
            (true, false) => writeln!(text, "{},{inertial},{field}", seconds(time_ms)),
            (true, true) => {
                writeln!(text, "{},{inertial},\n{},,,{field}", seconds(time_ms), seconds(time_ms + 3))
            }
        }
        .unwrap();
    }
    text
}

/// The columns at these places, in the rows that have all of them.
fn columns(text: &str, places: &[usize]) -> String {
    let mut columns = String::new();
    for line in text.lines() {
        let fields: Vec<_> = line.split(',').collect();
        let fields: Vec<_> = places.iter().map(|&place| fields[place]).collect();
        if fields.iter().all(|field| !field.is_empty()) {
            writeln!(columns, "{}", fields.join(",")).unwrap();
        }
    }
    columns
}

#[test]
fn columns_of_different_rates_are_measured_as_in_files_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let alone = folder.path().join("alone.csv");
    for are_apart in [false, true] {
        let text = table(are_apart);
        fs::write(&path, &text).unwrap();
        let (results, exit) = replay(&path, &["--columns", COLUMNS]);
        let results = results.as_array().unwrap();
        assert_eq!((results.len(), exit), (2, 0));
        let places: [(_, &[_], _, _); 2] = [
            ("gyro accel", &[0, 1, 2], "gyro_x=gyro_x:rad/s,accel_z=accel_z:m/s^2,t=t:s", 100.0),
            ("mag", &[0, 3], "mag_x=mag_x:gauss,t=t:s", 25.0),
        ];
        for (result, (name, places, map, rate_hz)) in results.iter().zip(places) {
            fs::write(&alone, columns(&text, places)).unwrap();
            let (expected, _) = replay(&alone, &["--columns", map]);
            assert_eq!(result["source"]["stream"], name);
            assert_eq!(result["source"]["name"], format!("log.csv {name}"));
            assert_eq!((&result["timing"], &result["channels"]), (&expected["timing"], &expected["channels"]));
            let timing = &result["timing"];
            assert_eq!((timing["rate_hz"].as_f64(), &timing["missing"]), (Some(rate_hz), &0.into()));
            assert!(!warned(result, "gaps"));
            let csv = &result["source"]["csv"];
            let count = |name: &str| csv[name].as_u64().unwrap();
            assert_eq!(csv["odd"], Value::Array(vec![]));
            assert_eq!(count("lines"), count("rows") + count("skipped_lines") + count("other_stream_rows"));
            let field_rows = ROWS as u64 / 4;
            let others = if name == "mag" { ROWS as u64 - if are_apart { 0 } else { field_rows } } else { 0 };
            let others = if are_apart && name != "mag" { field_rows } else { others };
            assert_eq!(count("other_stream_rows"), others, "{name}");
        }
        let (one, _) = replay(&path, &["--columns", COLUMNS, "--topic", "mag"]);
        assert_eq!((&one["channels"], &one["source"]["stream"]), (&results[1]["channels"], &"mag".into()));
    }
}

#[test]
fn streams_of_a_table_are_reported_and_compared_and_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    fs::write(&path, table(false)).unwrap();
    let page = folder.path().join("page.html");
    let report = vn100().arg("report").arg(&path).arg("-o").arg(&page).args(["--export", "csv"]).output().unwrap();
    assert!(report.status.success(), "{}", String::from_utf8_lossy(&report.stderr));
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("log.csv gyro accel") && text.contains("log.csv mag"));
    let compared = vn100().arg("compare").args([&path, &path]).output().unwrap();
    let text = String::from_utf8(compared.stdout).unwrap();
    assert!(text.starts_with("4 runs, 95 % confidence\n") && text.contains("\n  run 2  log.csv mag: CSV"), "{text}");
    // a table on standard input is read once: completely, unless a stream is named
    let bytes = fs::read(&path).unwrap();
    let all = document(&with_stdin(vn100().args(["replay", "-", "--json"]), &bytes));
    assert!(warned(&all, "gaps") && channel(&all, "mag_x")["statistics"]["count"] == 2000);
    assert!(all["source"].get("stream").is_none() && all["source"]["csv"].get("other_stream_rows").is_none());
    let one = document(&with_stdin(vn100().args(["replay", "-", "--topic", "mag", "--json"]), &bytes));
    assert_eq!((&one["timing"]["samples"], one["timing"]["rate_hz"].as_f64()), (&2000.into(), Some(25.0)));
    let refused = vn100().arg("replay").arg(&path).args(["--topic", "magg"]).output().unwrap();
    let text = String::from_utf8(refused.stderr).unwrap();
    assert!(text.contains("log.csv: no columns of \"magg\": name some of gyro, accel, mag"), "{text}");
    assert_eq!(refused.status.code(), Some(3));
}

/// A gyroscope at 100 Hz and an accelerometer at 25 Hz.
#[test]
fn what_one_stream_has_is_not_asked_of_another() {
    const SENSORS: [&str; 2] = ["--columns", "gyro_x=gyro_x:rad/s,accel_x=mag_x:m/s^2,t=t:s"];
    let folder = tempfile::tempdir().unwrap();
    let [path, sheet, page] = ["log.csv", "sheet.toml", "page.html"].map(|name| folder.path().join(name));
    let mut state = 1_796_067_846_u64;
    let mut text = "t,gyro_x,mag_x\n".to_owned();
    for row in 0..ROWS {
        let mut noise = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % 1000) as f64 * 1e-6
        };
        let acceleration = if row % 4 == 0 { noise().to_string() } else { String::new() };
        writeln!(text, "{:.2},{:.6},{acceleration}", row as f64 * 0.01, noise()).unwrap();
    }
    fs::write(&path, text).unwrap();
    let figure = "sensor = \"gyroscope\"\nparameter = \"white\"\nunit = \"rad/s/sqrt(Hz)\"\nlimit = 1e-4";
    fs::write(&sheet, format!("name = \"x\"\ndensity = \"two-sided\"\n[[figure]]\n{figure}\n")).unwrap();
    for (option, asked, met) in [
        ("--until", "gyro N ±20%", true),
        ("--until", "accel_x N ±60%", true),
        ("--until", "gyro_y N ±20%", false),
        ("--fail-on", "gyro_x N", true),
        ("--fail-on", "gyro_y N", false),
        ("--fail-on", "accel N", false),
    ] {
        let options = [&SENSORS[..], &["--datasheet", sheet.to_str().unwrap(), option, asked]].concat();
        let (results, exit) = replay(&path, &options);
        assert_eq!(exit, if met { 0 } else { 4 }, "{asked} {results}");
        let whole = |place: usize, rows| results[place]["timing"]["samples"] == rows;
        let whole = [whole(0, ROWS), whole(1, ROWS / 4)];
        assert!(!met || whole == [!asked.ends_with("20%"), !asked.ends_with("60%")], "{asked} {whole:?}");
    }
    let (results, _) = replay(&path, &SENSORS);
    let export = |more: &[&str]| {
        let report = ["--export", "kalibr", "--force", "-o", page.to_str().unwrap()];
        vn100().arg("report").arg(&path).args(SENSORS).args(report).args(more).output().unwrap()
    };
    let made = export(&[]);
    assert!(made.status.success(), "{made:?}");
    for (place, rate) in [("-1", "100"), ("-2", "25")] {
        let file = fs::read_to_string(folder.path().join(format!("page{place}.imu.yaml"))).unwrap();
        for (sensor, result, axis) in [("gyroscope", 0, "gyro_x"), ("accelerometer", 1, "accel_x")] {
            let (_, value) = file.split_once(&format!("\n{sensor}_noise_density: ")).unwrap();
            let value: f64 = value.lines().next().unwrap().parse().unwrap();
            let expected = channel(&results[result], axis)["noise"]["white"]["value"].as_f64().unwrap();
            assert!((value / expected - 1.0).abs() < 1e-4, "{value} {expected}\n{file}");
        }
        assert!(file.contains(&format!("update_rate: {rate}")) && file.contains("is that of another stream"), "{file}");
    }
    let alone = String::from_utf8(export(&["--topic", "gyro"]).stderr).unwrap();
    assert!(alone.contains("the stream has no channel accel"), "{alone}");
}
