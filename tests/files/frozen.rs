//! The numbers of every capture, frozen: the results of `replay --json` for each of them stay the same
//! in every integer and word, and to 1e-12 in every other number.
//!
//! `frozen/replay_logs.json` holds the numbers of `replay-logs`, `frozen/captures.json` those of the
//! recordings of real sensors, one line per channel. They contain no part of the recordings. A change
//! that alters numbers on purpose freezes them again, and lists the differences:
//!
//! ```sh
//! VN100_FREEZE=1 VN100_CAPTURES=FOLDER cargo test -p vn100 --test files frozen
//! git diff --word-diff tests/files/frozen
//! ```
//!
//! If the schema of the document changes, only the map below changes.

use std::{
    collections::BTreeMap,
    env, fs,
    io::Write,
    path::{Path, PathBuf},
};

use serde_json::{Map, Value, json};

use crate::support::{real_captures, replay, replay_log, workspace};

/// Names of the frozen numbers of a recording, and their places in its document. An object at such a
/// place is kept as it is.
const OF_RECORDING: [(&str, &str); 23] = [
    ("kind", "/source/kind"),
    ("stream", "/source/stream"),
    ("message", "/source/message"),
    ("compensated", "/source/compensated"),
    ("rate_hz", "/timing/rate_hz"),
    ("rate_from", "/timing/rate_from"),
    ("duration_s", "/timing/duration_s"),
    ("samples", "/timing/samples"),
    ("left_out", "/timing/left_out"),
    ("segments", "/timing/segments"),
    ("gaps", "/timing/gaps"),
    ("missing", "/timing/missing_at_least"),
    ("missing_from", "/timing/missing_from"),
    ("bytes", "/link/bytes"),
    ("frames", "/link/frames"),
    ("replies", "/link/replies"),
    ("other_messages", "/link/other_messages"),
    ("binary_packets", "/link/binary_packets"),
    ("rejected_packets", "/link/rejected_packets"),
    ("skipped_bytes", "/link/skipped_bytes"),
    ("overrun_bytes", "/link/overrun_bytes"),
    ("bad_frames", "/link/bad_frames"),
    ("end_reason", "/end_reason"),
];

/// The warnings of a document, and the places in one of its kind, severity and channels.
const WARNINGS: &str = "/warnings";
const OF_WARNING: [&str; 3] = ["/kind", "/severity", "/channels"];

/// The channels of a document, and the place of the name in one.
const CHANNELS: &str = "/channels";
const CHANNEL_NAME: &str = "/name";

/// Statistics of a channel, in the order of the frozen array.
const STATISTICS: [&str; 5] =
    ["/statistics/count", "/statistics/mean", "/statistics/std", "/statistics/min", "/statistics/max"];

/// The points of the deviation of a channel, and the places of the averaging factor and the deviation in
/// one.
const POINTS: &str = "/allan/points";
const POINT_FACTOR: &str = "/m";
const POINT_DEVIATION: &str = "/deviation";
/// Averaging factors whose deviations are frozen: 1, 2, 4 and so on.
const OCTAVES: u32 = 12;

/// Parameters of the noise of a channel, and the places of status, value and interval in one.
const PARAMETERS: [(&str, &str); 3] =
    [("N", "/noise/white"), ("B", "/noise/bias_instability"), ("K", "/noise/rate_random_walk")];
const OF_PARAMETER: [&str; 4] = ["/status", "/value", "/lower", "/upper"];

/// Captures that are also read with options: without these they are refused, or another method would
/// not be tested.
const WITH_OPTIONS: [(&str, &[&str]); 5] = [
    ("clean-minute.vnymr", &["--estimator", "full"]),
    ("gaps.vnymr", &["--estimator", "full"]),
    ("vn100-hand-thumatti-BADSTAMPS.csv", &["--rate", "40"]),
    ("vn100-circles-rohx17-NOCHECKSUM.vnymr", &["--accept-unchecked"]),
    ("binary/F00379_B", &["--rate", "10"]),
];

/// Files that describe captures.
const NOT_CAPTURES: [&str; 4] = ["md", "json", "yaml", "timing"];

#[test]
fn numbers_of_the_replay_logs_are_the_frozen_ones() {
    check(&replay_log(""), "replay_logs.json");
}

#[test]
fn numbers_of_real_captures_are_the_frozen_ones() {
    if let Some(folder) = real_captures() {
        check(&folder, "captures.json");
    }
}

/// Compares every capture of a folder with its frozen numbers, or freezes them.
fn check(folder: &Path, frozen_name: &str) {
    let found = derive_all(folder);
    let path = workspace().join("tests/files/frozen").join(frozen_name);
    if env::var_os("VN100_FREEZE").is_some() {
        return fs::write(path, text_of(&found)).unwrap();
    }
    let frozen: BTreeMap<String, Value> = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let (mut values, mut differences) = (0, Vec::new());
    let names = |all: &BTreeMap<String, Value>| all.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&found), names(&frozen), "other captures than the frozen ones");
    for (name, found) in &found {
        compare(found, &frozen[name], name, &mut values, &mut differences);
    }
    let differing = differences.len();
    differences.truncate(30);
    assert!(differing == 0, "{differing} of {values} values differ:\n{}", differences.join("\n"));
    // past the test's own capturing of its output, so that a run that passes shows it as well
    let _ = writeln!(std::io::stderr(), "frozen: {values} values of {} captures of {frozen_name} agree", found.len());
}

/// The results for each capture of a folder, by the name of its file and the options.
fn derive_all(folder: &Path) -> BTreeMap<String, Value> {
    let mut files = Vec::new();
    find_captures(folder, &mut files);
    let mut runs: Vec<(String, PathBuf, &[&str])> = Vec::new();
    for file in files {
        let name = file.strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/");
        for (_, options) in WITH_OPTIONS.iter().filter(|(of, _)| *of == name) {
            runs.push((format!("{name} {}", options.join(" ")), file.clone(), options));
        }
        runs.push((name, file, &[]));
    }
    runs.into_iter().map(|(name, file, options)| (name, derive(&file, options))).collect()
}

fn find_captures(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if path.is_dir() {
            find_captures(&path, files);
        } else if !NOT_CAPTURES.contains(&extension) {
            files.push(path);
        }
    }
}

/// The results for one capture: the exit code, and each of its recordings.
fn derive(file: &Path, options: &[&str]) -> Value {
    let (document, exit) = replay(file, options);
    let documents = match document {
        Value::Array(documents) => documents,
        one => vec![one],
    };
    json!({ "exit": exit, "recordings": documents.iter().map(of_recording).collect::<Vec<_>>() })
}

fn at(value: &Value, place: &str) -> Value {
    value.pointer(place).cloned().unwrap_or_default()
}

fn all<'a>(value: &'a Value, place: &str) -> impl Iterator<Item = &'a Value> {
    value.pointer(place).and_then(Value::as_array).into_iter().flatten()
}

fn of_recording(document: &Value) -> Value {
    let numbers: Map<_, _> = OF_RECORDING.iter().map(|(name, place)| (name.to_string(), at(document, place))).collect();
    let warnings: Vec<Value> =
        all(document, WARNINGS).map(|warning| OF_WARNING.iter().map(|place| at(warning, place)).collect()).collect();
    let channels: Vec<Value> = all(document, CHANNELS).map(of_channel).collect();
    json!({ "numbers": numbers, "warnings": warnings, "channels": channels })
}

fn of_channel(channel: &Value) -> Value {
    let statistics: Value = STATISTICS.iter().map(|place| at(channel, place)).collect();
    let deviation = |m: u64| {
        let point = all(channel, POINTS).find(|point| at(point, POINT_FACTOR) == m);
        point.map_or(Value::Null, |point| at(point, POINT_DEVIATION))
    };
    let mut deviations: Vec<Value> = (0..OCTAVES).map(|octave| deviation(1 << octave)).collect();
    while deviations.last().is_some_and(Value::is_null) {
        deviations.pop();
    }
    let mut frozen = Map::from_iter([
        ("name".into(), at(channel, CHANNEL_NAME)),
        ("statistics".into(), statistics),
        ("deviations".into(), deviations.into()),
    ]);
    for (name, place) in PARAMETERS {
        let parameter = at(channel, place);
        if !parameter.is_null() {
            frozen.insert(name.into(), OF_PARAMETER.iter().map(|place| at(&parameter, place)).collect());
        }
    }
    frozen.into()
}

/// Notes the places at which two trees of numbers and words differ, and counts their values.
fn compare(found: &Value, frozen: &Value, place: &str, values: &mut usize, differences: &mut Vec<String>) {
    match (found, frozen) {
        (Value::Object(found), Value::Object(frozen)) => {
            for name in found.keys().chain(frozen.keys().filter(|name| !found.contains_key(*name))) {
                let [found, frozen] = [found, frozen].map(|one| one.get(name).unwrap_or(&Value::Null));
                compare(found, frozen, &format!("{place} {name}"), values, differences);
            }
        }
        (Value::Array(found), Value::Array(frozen)) => {
            for index in 0..found.len().max(frozen.len()) {
                let [found, frozen] = [found, frozen].map(|one| one.get(index).unwrap_or(&Value::Null));
                let name = found.get("name").and_then(Value::as_str).map_or(index.to_string(), str::to_owned);
                compare(found, frozen, &format!("{place} {name}"), values, differences);
            }
        }
        _ => {
            *values += 1;
            if !same(found, frozen) {
                differences.push(format!("{place}: {found}, frozen as {frozen}"));
            }
        }
    }
}

/// Whether two values are the same: numbers with a fraction to 1e-12, others exactly.
fn same(found: &Value, frozen: &Value) -> bool {
    match (found, frozen) {
        (Value::Number(found_number), Value::Number(frozen_number))
            if found_number.is_f64() && frozen_number.is_f64() =>
        {
            let [found, frozen] = [found_number, frozen_number].map(|number| number.as_f64().unwrap());
            (found - frozen).abs() <= 1e-12 * frozen.abs()
        }
        _ => found == frozen,
    }
}

/// Frozen numbers as text, one line for each channel, each recording and each warning.
fn text_of(all: &BTreeMap<String, Value>) -> String {
    let captures: Vec<String> = all
        .iter()
        .map(|(name, capture)| {
            let recordings: Vec<String> = capture["recordings"].as_array().unwrap().iter().map(lines_of).collect();
            format!("{}:{{\"exit\":{},\"recordings\":[\n{}]}}", json!(name), capture["exit"], recordings.join(",\n"))
        })
        .collect();
    format!("{{\n{}\n}}\n", captures.join(",\n"))
}

fn lines_of(recording: &Value) -> String {
    let lines = |name: &str| {
        let lines: Vec<String> = recording[name].as_array().unwrap().iter().map(Value::to_string).collect();
        format!("\"{name}\":[\n{}]", lines.join(",\n"))
    };
    format!("{{\"numbers\":{},\n{},\n{}}}", recording["numbers"], lines("warnings"), lines("channels"))
}
