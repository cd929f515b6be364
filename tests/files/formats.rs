//! Recordings with times, and recordings in other forms: the result equals that of the original
//! lines.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;

use crate::support::{channel, deviation, replay, replay_log, vn100, warned};

const CLEAN: &str = "clean-minute.vnymr";

/// The clean minute with an arrival time for each line, as a raw capture with its sidecar; lines
/// for which `lost` holds are removed.
fn stamped(folder: &Path, rate_hz: f64, lost: impl Fn(usize) -> bool) -> PathBuf {
    let path = folder.join("stamped.bin");
    let bytes = fs::read(replay_log(CLEAN)).unwrap();
    let (mut kept, mut timing) = (Vec::new(), String::from("t_ns,offset\n"));
    for (index, line) in bytes.chunks(122).enumerate().filter(|(index, _)| !lost(*index)) {
        // the port returns a line in two reads
        let at_ns = (1e9 / rate_hz * index as f64) as u64;
        timing += &format!("{},{}\n{},{}\n", at_ns, kept.len(), at_ns + 5_000_000, kept.len() + 62);
        kept.extend_from_slice(line);
    }
    fs::write(&path, kept).unwrap();
    fs::write(folder.join("stamped.bin.timing"), timing).unwrap();
    path
}

#[test]
fn every_message_of_the_emulated_sensor_is_measured_alike() {
    let folder = tempfile::tempdir().unwrap();
    let (clean, _) = replay(&replay_log(CLEAN), &[]);
    for (message, channels) in [("VNMAR", 9), ("VNQMR", 13)] {
        let options = ["sim", "--message", message, "--like", "lab3", "--duration", "60s", "--seed", "1", "-o"];
        for name in ["text", "recorded.mcap"] {
            let path = folder.path().join(format!("{message}-{name}"));
            assert!(vn100().args(options).arg(&path).status().unwrap().success());
            let (document, exit) = replay(&path, &[]);
            assert_eq!((exit, &document["source"]["message"]), (0, &message.into()), "{}", document["source"]);
            assert_eq!(
                (&document["source"]["compensated"], &document["timing"]["samples"]),
                (&true.into(), &2400.into())
            );
            assert_eq!(document["channels"].as_array().unwrap().len(), channels);
            // with the same sensor and seed, the values equal those of the message with angles
            for name in ["mag_x", "accel_z", "gyro_y"] {
                let (found, expected) = (channel(&document, name), channel(&clean, name));
                assert_eq!(
                    (&found["statistics"], &found["unit"]),
                    (&expected["statistics"], &expected["unit"]),
                    "{name}"
                );
            }
            if message == "VNQMR" {
                let elements = ["quat_x", "quat_y", "quat_z", "quat_w"].map(|name| channel(&document, name));
                assert!(elements.iter().all(|element| element["unit"] == "1" && element["noise"].is_null()));
                let squares = elements.map(|element| element["statistics"]["mean"].as_f64().unwrap().powi(2));
                assert!((squares.iter().sum::<f64>() - 1.0).abs() < 1e-5, "{squares:?}");
            }
        }
        let capture = folder.path().join(format!("{message}-text"));
        let report = folder.path().join(format!("{message}.html"));
        let written = vn100().arg("report").arg("-o").arg(&report).arg(&capture).output().unwrap();
        assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
        let page = fs::read_to_string(report).unwrap();
        assert_eq!(page.contains("quat_w"), message == "VNQMR");
    }
}

#[test]
fn lines_lost_whole_are_found_by_the_times_of_their_reads() {
    let folder = tempfile::tempdir().unwrap();
    let whole = stamped(folder.path(), 40.0, |_| false);
    let (document, exit) = replay(&whole, &[]);
    assert_eq!(exit, 0);
    assert_eq!(document["timing"]["rate_from"], "arrival");
    assert_eq!(document["timing"]["missing_from"], "arrival");
    assert_eq!((&document["timing"]["rate_hz"], &document["timing"]["missing"]), (&40.0.into(), &0.into()));
    assert!(!warned(&document, "rate-assumed"));

    let lossy = stamped(folder.path(), 40.0, |index| index == 500 || (1000..1007).contains(&index));
    let (document, _) = replay(&lossy, &[]);
    let timing = &document["timing"];
    assert_eq!((&timing["samples"], &timing["missing"], &timing["gaps"]), (&2392.into(), &8.into(), &2.into()));
    assert_eq!(channel(&document, "gyro_x")["allan"]["points"][0]["terms"], 2392 - 3);
    assert_eq!(timing["duration_s"], 60.0);
}

#[test]
fn a_sidecar_that_ends_early_is_reported_and_the_rest_excluded() {
    let folder = tempfile::tempdir().unwrap();
    let capture = stamped(folder.path(), 40.0, |_| false);
    let sidecar = folder.path().join("stamped.bin.timing");
    let rows = fs::read_to_string(&sidecar).unwrap();
    // two rows per line, after the names
    let cut = rows.lines().take(2001).fold(String::new(), |text, row| text + row + "\n");
    fs::write(&sidecar, cut).unwrap();
    let (document, exit) = replay(&capture, &[]);
    assert_eq!(exit, 1);
    let error = document["source"]["error"].as_str().unwrap();
    let last_offset = 999 * 122 + 62;
    assert!(error.contains(&format!("the rows end at line 2001 with offset {last_offset}")), "{error}");
    assert_eq!(document["timing"]["samples"], (last_offset + 4096) / 122);
}

#[test]
fn a_given_rate_that_the_stamps_contradict_is_not_asked_for_again() {
    let folder = tempfile::tempdir().unwrap();
    let (document, _) = replay(&stamped(folder.path(), 40.0, |_| false), &["--rate", "50"]);
    let mut warnings = document["warnings"].as_array().unwrap().iter();
    let found = warnings.find(|warning| warning["kind"] == "stamps-doubtful").unwrap();
    assert_eq!((&found["severity"], &found["remedies"]), (&"problem".into(), &Value::Array(vec![])), "{found}");
}

#[test]
fn stamps_at_the_ends_of_64_bits_cost_no_sample() {
    let folder = tempfile::tempdir().unwrap();
    let capture = stamped(folder.path(), 40.0, |_| false);
    let rows = (0..2400_i64).map(|line| match line % 3 {
        0 => format!("{},{}\n", i64::MIN, 122 * line),
        1 => format!("{},{}\n", i64::MAX, 122 * line),
        _ => format!("{},{}\n", 25_000_000 * line, 122 * line),
    });
    fs::write(folder.path().join("stamped.bin.timing"), rows.collect::<String>()).unwrap();
    let (document, exit) = replay(&capture, &[]);
    assert_eq!((exit, &document["timing"]["samples"]), (0, &2400.into()));
    assert!(warned(&document, "stamps-doubtful"));

    // one leap of 584 years
    let rows = (0..2400_i64).map(|line| {
        let at_ns = if line < 1200 { i64::MIN } else { i64::MAX - 60_000_000_000 } + 25_000_000 * line;
        format!("{at_ns},{}\n", 122 * line)
    });
    fs::write(folder.path().join("stamped.bin.timing"), rows.collect::<String>()).unwrap();
    let (document, exit) = replay(&capture, &[]);
    assert_eq!((exit, &document["timing"]["samples"]), (0, &2400.into()));
}

/// The clean minute as stored by a laboratory's script: a stamp, and the twelve fields.
fn as_csv(rows: usize) -> String {
    let text = String::from_utf8(fs::read(replay_log(CLEAN)).unwrap()).unwrap();
    let header = "t,yaw,pitch,roll,mag_x,mag_y,mag_z,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n".to_owned();
    text.lines().take(rows).enumerate().fold(header, |csv, (index, line)| {
        let fields = line.strip_prefix("$VNYMR,").unwrap().split('*').next().unwrap();
        csv + &format!("{:.6},{fields}\n", 1_761_939_167.0 + 0.025 * index as f64)
    })
}

/// The channels without the interval of N, which depends on arrival times, and without verdicts from it.
fn of_samples(document: &Value) -> Value {
    let mut channels = document["channels"].clone();
    for channel in channels.as_array_mut().unwrap() {
        channel.as_object_mut().unwrap().remove("verdict");
        if let Some(white) = channel["noise"]["white"].as_object_mut() {
            white.retain(|key, _| ["status", "value", "unit", "p"].contains(&key.as_str()));
        }
        if let Some(noise) = channel["noise"].as_object_mut() {
            noise.remove("curve_minimum");
        }
    }
    channels
}

#[test]
fn parsed_fields_read_as_the_lines_they_came_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("minute.csv");
    fs::write(&path, as_csv(2400)).unwrap();
    let (unsaid, _) = replay(&path, &[]);
    assert_eq!(unsaid["source"]["compensated"], Value::Null);
    assert!(warned(&unsaid, "compensation-unknown") && !warned(&unsaid, "compensated-stream"));
    assert_ne!(channel(&unsaid, "gyro_y")["noise"]["bias_instability"]["status"], "not-measurable");
    let (csv, exit) = replay(&path, &["--compensated", "yes"]);
    assert!(!warned(&csv, "compensation-unknown") && warned(&csv, "compensated-stream"));
    let (lines, _) = replay(&replay_log(CLEAN), &[]);
    assert_eq!(exit, 0);
    assert_eq!(csv["source"]["kind"], "csv");
    assert_eq!(of_samples(&csv), of_samples(&lines));
    assert_eq!(csv["link"]["bytes"], fs::metadata(&path).unwrap().len());
    assert_eq!(csv["timing"]["rate_from"], "arrival");
    assert!(warned(&csv, "bad-lines"));
    assert_eq!(csv["source"]["csv"]["rows"], 2400);
    assert_eq!(lines["source"]["csv"], Value::Null);
}

#[test]
fn values_without_a_rate_are_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("untimed.csv");
    let untimed: String = as_csv(300).lines().map(|row| row.split_once(',').unwrap().1.to_owned() + "\n").collect();
    let refused = |text: String| {
        fs::write(&path, text).unwrap();
        let (document, exit) = replay(&path, &[]);
        let error = document["source"]["error"].as_str().unwrap().to_owned();
        assert_eq!((exit, &document["timing"]["samples"]), (2, &0.into()), "{error}");
        assert!(error.contains("its sample rate is unknown") && error.contains("--rate HZ"), "{error}");
        error
    };
    assert!(refused(untimed.clone()).contains("if a column has the times, set --columns 't=NAME:s'"));
    // all rows at one time
    let stopped = untimed.lines().map(|row| format!("1.5,{row}\n")).collect::<String>().replacen("1.5", "t", 1);
    assert!(refused(stopped).contains("all 300 lines have the same"));
    fs::write(&path, untimed).unwrap();
    let (document, exit) = replay(&path, &["--rate", "40"]);
    assert_eq!((exit, &document["timing"]["rate_from"]), (0, &"option".into()));
    let lines = fs::read(replay_log(CLEAN)).unwrap();
    fs::write(&path, &lines).unwrap();
    let (document, exit) = replay(&path, &[]);
    assert_eq!((exit, &document["timing"]["rate_from"]), (0, &"assumed".into()));
}

/// The text of the first warning of that kind.
fn warning(document: &Value, kind: &str) -> String {
    let mut warnings = document["warnings"].as_array().unwrap().iter().filter(|warning| warning["kind"] == kind);
    warnings.next().unwrap()["text"].as_str().unwrap().to_owned()
}

#[test]
fn advice_on_a_csv_file_is_about_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.csv");
    let text =
        as_csv(300).replace("\n1761939168.000000,", "\n1761939168.000000,x").replace("\n1761939169.000000,", "\n");
    fs::write(&path, text).unwrap();
    let (document, _) = replay(&path, &[]);
    let advice = warning(&document, "bad-lines");
    assert!(advice.starts_with("2 of 300 lines rejected (fields 1, number 1). "), "{advice}");

    let nothing = "t,gyro_x\n".to_owned() + &"0.025,none\n".repeat(100);
    fs::write(&path, nothing).unwrap();
    let (document, exit) = replay(&path, &[]);
    assert_eq!(exit, 3);
    let advice = warning(&document, "no-valid-lines");
    assert!(advice.starts_with("100 of 100 lines rejected (number 100). ") && advice.contains("--columns"), "{advice}");
}

/// The minute as `vn100 sim` records it.
fn recorded(folder: &Path) -> PathBuf {
    let path = folder.join("minute.mcap");
    let sim = "sim --like lab3 --duration 60s --rate 40 --seed 1 -o".split(' ');
    assert!(vn100().args(sim).arg(&path).status().unwrap().success());
    path
}

#[test]
fn a_recording_reads_as_its_lines_and_knows_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let (document, exit) = replay(&recorded(folder.path()), &[]);
    let (lines, _) = replay(&replay_log(CLEAN), &["--rate", "40"]);
    assert_eq!((exit, &document["source"]["kind"]), (0, &"mcap".into()));
    assert_eq!((of_samples(&document), &document["link"]), (of_samples(&lines), &lines["link"]));
    let timing = &document["timing"];
    assert_eq!((&timing["rate_from"], &timing["rate_hz"]), (&"arrival".into(), &40.0.into()));
    assert_eq!(timing["interarrival_us"]["max"], 25_000);
    let recorded = &document["source"]["recorded"];
    // the times of an emulated sensor count from zero
    assert_eq!((&recorded["started"], &recorded["ended"]), (&Value::Null, &Value::Null));
    assert_eq!(recorded["complete"], true);
    assert_eq!(document["source"]["meta"]["sim.seed"], "1");
}

#[test]
fn converted_numbers_are_exact_to_the_last_digit_of_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let (path, page) = (folder.path().join("rate.csv"), folder.path().join("rate.html"));
    // 10.0 to 12.4 deg/h, and 100 to 124 mdeg/s
    let row = |n: u32| format!("{},{}.{},{}\n", n * 10, 10 + n * 7 % 25 / 10, n * 7 % 25 % 10, 100 + n * 7 % 25);
    fs::write(&path, (0..1000).map(row).fold("t,wx,wy\n".to_owned(), |text, row| text + &row)).unwrap();
    let columns = ["--columns", "t=t:ms,gyro_x=wx:deg/h,gyro_y=wy:mdeg/s"];
    let (document, _) = replay(&path, &columns);
    assert!(vn100().args(["report", "-o"]).arg(&page).arg(&path).args(columns).status().unwrap().success());
    let html = fs::read_to_string(&page).unwrap();
    for name in ["gyro_x", "gyro_y"] {
        let (_, cells) = html.split_once(&format!("<th scope=\"row\">{name}</th>")).unwrap();
        let cells = cells.split("<td>").skip(2).map(|cell| cell.split('<').next().unwrap());
        for (figure, text) in ["mean", "std", "min", "max"].into_iter().zip(cells) {
            let is = channel(&document, name)["statistics"][figure].as_f64().unwrap();
            let error = text.parse::<f64>().unwrap() / is - 1.0;
            assert!(error.abs() < 0.005, "{name} {figure} is {is}, and told as {text}");
        }
    }
}

#[test]
fn a_recording_that_was_cut_gives_its_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let (document, exit) = replay(&path, &[]);
    let samples = document["timing"]["samples"].as_u64().unwrap();
    assert_eq!(exit, 0);
    assert!((1150..=1200).contains(&samples), "{samples}");
    assert_eq!(document["link"]["bytes"], samples * 122, "whole lines only");
    assert_eq!(document["source"]["recorded"]["complete"], false);
    let said = "the recording was cut: its end or a part is missing";
    let warnings = document["warnings"].as_array().unwrap();
    let cut: Vec<&Value> = warnings.iter().filter(|warning| warning["kind"] == "incomplete").collect();
    assert!(cut.len() == 1 && cut[0]["severity"] == "caution", "{warnings:?}");
    assert!(cut[0]["text"].as_str().unwrap().starts_with(said), "{cut:?}");
    let text = String::from_utf8(vn100().arg("replay").arg(&path).output().unwrap().stdout).unwrap();
    assert!(text.contains(&format!("CHECK    {said}")), "{text}");
    let page = folder.path().join("r.html");
    let report = vn100().args(["report", "--export", "csv", "-o"]).arg(&page).arg(&path).output().unwrap();
    assert!(report.status.success() && fs::read_to_string(&page).unwrap().contains(said));
    let table = fs::read_to_string(folder.path().join("r.warnings.csv")).unwrap();
    assert!(table.contains(&format!("incomplete,caution,,{said},")), "{table}");
    fs::write(&path, &whole).unwrap();
    assert!(!warned(&replay(&path, &[]).0, "incomplete"));
}

#[test]
fn a_series_of_no_sensor_is_measured_as_rate_data() {
    let folder = tempfile::tempdir().unwrap();
    let numbers = "892\n809\n823\n798\n671\n644\n883\n903\n677\n";
    for (text, column, unit) in [(format!("n,y\n{}", numbered(numbers)), "y", "s/s"), (numbers.into(), "1", "any unit")]
    {
        let file = folder.path().join("series.csv");
        fs::write(&file, text).unwrap();
        let columns = format!("value={column}:{unit}");
        let (document, exit) = replay(&file, &["--columns", &columns, "--rate", "1", "--estimator", "full"]);
        assert_eq!(exit, 0);
        let value = channel(&document, "value");
        assert_eq!((&value["unit"], &value["allan"]["data"]), (&unit.into(), &"rate".into()));
        // NBS Monograph 140, annex 8.E
        assert!((deviation(&document, "value", 1) / 91.22945 - 1.0).abs() < 1e-6);
        assert!((deviation(&document, "value", 2) / 85.95287 - 1.0).abs() < 1e-6);
        for key in ["noise", "verdict", "grade"] {
            assert_eq!(value[key], Value::Null, "{key}");
        }
        assert_eq!(document["warnings"].as_array().unwrap().len(), 0, "{}", document["warnings"]);
    }
}

/// The lines as rows, each after its number.
fn numbered(lines: &str) -> String {
    lines.lines().enumerate().map(|(number, line)| format!("{number},{line}\n")).collect()
}
