//! The schema of documents: it describes every existing field, and no others.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;
use vn100_capture::RecordingWriter;
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, StreamInput};

use crate::support::{capture, document, replay_log, schema, vn100, workspace};

/// What needs a record with a fault of its own to appear: the tests of those faults check their
/// documents against the schema, too.
const RARE: [&str; 17] = [
    // no probability is tested for N without its aliasing, the one parameter in this form
    "/$defs/Parameter/properties/p",
    // K is estimated in long records alone
    "/$defs/Inflation/properties/walk_factor",
    "/$defs/CsvReport/properties/other_stream_rows",
    "/$defs/Curve/properties/data",
    "/$defs/Disturbance/",
    "/$defs/Frozen/",
    "/$defs/GaussMarkovProcess/",
    "/$defs/LevelChange/",
    "/$defs/LinkCounts/properties/other_model",
    "/$defs/NoiseChange/",
    "/$defs/NoiseResult/properties/correlation_samples",
    "/$defs/NoiseResult/properties/withheld",
    "/$defs/RateChange/",
    "/$defs/Spikes/",
    "/$defs/Stationarity/properties/",
    "/$defs/TemperatureResult/",
    "/$defs/TimeBase/properties/rate_change",
];

/// What only documents of reports have.
const OF_REPORTS: [&str; 2] = ["/$defs/FileFacts/", "/$defs/SourceFacts/properties/file"];

#[test]
fn the_schema_describes_every_field_of_documents_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let imu = capture(folder.path(), "a.mcap", &["--message", "VNIMU", "--duration", "10min"]);
    let mut seen = BTreeSet::new();
    let mut see = |files: &[&Path], options: &[&str]| {
        let output = vn100().args(["replay", "--json"]).args(options).args(files).output().unwrap();
        let documents = document(&output);
        for document in documents.as_array().unwrap_or(&vec![documents.clone()]) {
            assert_eq!(schema::errors(document, &mut seen), Vec::<String>::new());
        }
    };
    see(&[&imu], &["--quantization"]);
    let mut logs: Vec<_> =
        fs::read_dir(workspace().join("replay-logs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    logs.retain(|path| path.is_file() && path.extension().is_some_and(|end| end != "md"));
    logs.sort();
    assert!(logs.contains(&replay_log("clean-minute.vnymr")));
    for log in &logs {
        see(&[log], &[]);
    }
    see(&[&workspace().join("crates/vn100-capture/tests/bags/db3_two")], &[]);
    let table = folder.path().join("odd.csv");
    let row = |index: u32| format!("{:.2},{},{},1\n", 0.01 * f64::from(index), index * 7919 % 101, index * 7919 % 89);
    let rows: String = (0..400).map(row).collect();
    fs::write(&table, format!("t,gyro_x,gyro_y,gyr_x\n{rows}4.00,,3,1\n4.01,1\n")).unwrap();
    see(&[&table], &[]);
    let answers = capture(folder.path(), "b.vnymr", &["--duration", "60s"]);
    let mut lines = fs::read_to_string(&answers).unwrap();
    for body in
        ["VNRRG,01,VN-100S-CR", "VNRRG,02,7", "VNRRG,03,0100012345", "VNRRG,04,2.1.0.0", "VNRRG,85,0,4,4,4,0,0,3,3,3,0"]
    {
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        lines.push_str(&format!("${body}*{checksum:02X}\r\n"));
    }
    fs::write(&answers, lines).unwrap();
    see(&[&answers], &["--rate", "40"]);
    see(&[&marked(folder.path())], &["--rate", "40"]);
    let mut places = Vec::new();
    schema::places(&schema::analysis(), "", &mut places);
    let missing: Vec<&String> = places
        .iter()
        .filter(|place| !seen.contains(*place) && !RARE.iter().chain(&OF_REPORTS).any(|rare| place.starts_with(rare)))
        .collect();
    assert!(missing.is_empty(), "described, and in no document: {missing:#?}");
}

/// A recording of a clean minute with a mark in its middle.
fn marked(folder: &Path) -> PathBuf {
    let mut writer = RecordingWriter::new(Vec::new(), &BTreeMap::new()).unwrap();
    let lines = fs::read_to_string(replay_log("clean-minute.vnymr")).unwrap();
    for (line, at_ns) in lines.split_inclusive('\n').zip((0..).step_by(25_000_000)) {
        let bytes = line.as_bytes().to_vec().into();
        writer.write(&StreamInput::Chunk(Chunk { at_ns: Some(at_ns), bytes })).unwrap();
        if at_ns == 30_000_000_000 {
            let kind = LinkEventKind::Marked { text: "fan on".into() };
            writer.write(&StreamInput::Link(LinkEvent { at_ns, kind })).unwrap();
        }
    }
    let path = folder.join("marked.mcap");
    fs::write(&path, writer.finish(None).unwrap()).unwrap();
    path
}

#[test]
fn thin_lines_are_short_and_as_their_schema_has_them() {
    let folder = tempfile::tempdir().unwrap();
    for message in ["VNYMR", "VNQMR", "BINARY+MAG"] {
        let file = capture(folder.path(), message, &["--message", message, "--duration", "20s"]);
        let goals = ["--until", "gyro N ±1%", "--until", "accel B ±5%"];
        let output = vn100().arg("replay").arg(&file).arg("--ndjson=thin").args(goals).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.lines().count(), 21, "{message}");
        for (second, line) in (1..=20).chain([20]).zip(text.lines()) {
            assert!(line.len() < 2000, "{}", line.len());
            let line: Value = serde_json::from_str(line).unwrap();
            schema::check(&line);
            assert_eq!((&line["type"], &line["elapsed_s"]), (&"progress".into(), &f64::from(second).into()));
            assert_eq!(line["goals"].as_array().unwrap().len(), 2);
        }
        let reasons: Vec<_> =
            text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["end_reason"].clone()).collect();
        assert!(reasons[..20].iter().all(Value::is_null) && reasons[20] == "end-of-input");
    }
}

#[test]
fn the_schema_of_progress_describes_every_field_and_has_every_status() {
    let mut places = Vec::new();
    schema::places(&schema::progress(), "", &mut places);
    assert!(places.len() > 25, "{places:?}");
    assert_eq!(schema::progress()["$defs"]["Status"], schema::analysis()["$defs"]["Status"]);
    let output = vn100().args(["schema", "progress"]).output().unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap(), schema::progress());
}

#[test]
fn the_program_prints_the_schema() {
    for arguments in [&["schema"][..], &["schema", "analysis"]] {
        let output = vn100().args(arguments).output().unwrap();
        assert!(output.status.success());
        assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap(), schema::analysis());
    }
}
