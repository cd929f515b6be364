//! Recordings in parts: joined they equal the undivided one, for any order on the command line.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::Value;
use vn100_capture::{Recorder, RecordingReader, Rotation, part_path};
use vn100_protocol::stream::{Chunk, StreamInput};

use crate::support::{capture, document, replay_log, vn100};

/// A recording of an emulated sensor, as one file and in parts.
struct Recorded {
    _folder: tempfile::TempDir,
    whole: PathBuf,
    parts: Vec<PathBuf>,
}

/// The names of the whole recording and of its parts differ only in the numbers.
fn recorded(rotation: Rotation) -> Recorded {
    let folder = tempfile::tempdir().unwrap();
    let source = capture(folder.path(), "source.mcap", &["--message", "VNIMU", "--duration", "2min"]);
    let mut reader = RecordingReader::open(File::open(&source).unwrap()).unwrap();
    // a time since 1970, as in a recording
    let dated = |input| match input {
        StreamInput::Chunk(Chunk { bytes, at_ns }) => {
            StreamInput::Chunk(Chunk { bytes, at_ns: at_ns.map(|ns| ns + 1_700_000_000_000_000_000) })
        }
        event => event,
    };
    let inputs: Vec<StreamInput> = std::iter::from_fn(|| reader.next_input().unwrap()).map(dated).collect();
    let conditions = BTreeMap::from([("place".to_owned(), "bench".to_owned())]);
    fs::create_dir(folder.path().join("whole")).unwrap();
    let (whole, in_parts) = (folder.path().join("whole/night.mcap"), folder.path().join("night.mcap"));
    let recorders = [
        Recorder::create(&whole, &conditions).unwrap(),
        Recorder::in_parts(&in_parts, &conditions, rotation, false).unwrap(),
    ];
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    for recorder in recorders {
        runtime.block_on(async {
            for input in &inputs {
                recorder.inputs().send(input.clone()).await.unwrap();
            }
            let state = recorder.finish("stopped").await;
            assert!(state.error.is_none(), "{:?}", state.error);
        });
    }
    let parts = (1..).map(|number| part_path(&in_parts, number)).take_while(|part| part.exists()).collect();
    Recorded { _folder: folder, whole, parts }
}

fn replayed(files: &[&Path], options: &[&str]) -> (Value, String) {
    let output = vn100().args(["replay", "--json"]).args(options).args(files).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    (document(&output), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn parts_are_joined_to_the_document_of_the_undivided_recording_in_any_order() {
    for rotation in [Rotation::Bytes(150_000), Rotation::Time(Duration::from_secs(25))] {
        let Recorded { _folder, whole, parts } = recorded(rotation);
        assert!((4..=6).contains(&parts.len()), "{parts:?}");
        let (undivided, _) = replayed(&[&whole], &[]);
        let mut files: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
        assert_eq!(replayed(&files, &[]).0, undivided);
        // in another order, with another file between them
        files.reverse();
        files.swap(0, 2);
        let other = replay_log("clean-minute.vnymr");
        files.insert(2, &other);
        let (both, error) = replayed(&files, &[]);
        assert_eq!(
            (&both[0], &both[1]["source"]["name"], &both[2], error.as_str()),
            (&undivided, &"clean-minute.vnymr".into(), &Value::Null, "")
        );
        let report = |files: &[&Path], out: &Path| {
            let output = vn100().args(["report", "--export", "json", "-o"]).arg(out).args(files).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let mut document: Value = serde_json::from_slice(&fs::read(out.with_extension("json")).unwrap()).unwrap();
            // the parts are other files
            document["source"]["file"].take();
            document
        };
        files.remove(2);
        let folder = whole.parent().unwrap();
        assert_eq!(report(&files, &folder.join("a.html")), report(&[&whole], &folder.join("b.html")));
    }
}

#[test]
fn the_samples_of_all_parts_are_one_table() {
    let Recorded { _folder, whole, parts } = recorded(Rotation::Bytes(150_000));
    let folder = whole.parent().unwrap();
    let table = |name: &str, files: &[&Path]| {
        let path = folder.join(name);
        let output = vn100().args(["replay", "--json", "--samples"]).arg(&path).args(files).output();
        let output = output.unwrap();
        (fs::read_to_string(path).ok(), output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (undivided, _, _) = table("whole.csv", &[&whole]);
    assert_eq!(undivided.as_ref().unwrap().lines().count(), 4801);
    let mut files: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    files.swap(0, 2);
    assert_eq!(table("joined.csv", &files), (undivided.clone(), Some(0), String::new()));
    // across a missing part
    files.retain(|file| *file != parts[1]);
    let (text, status, error) = table("without.csv", &files);
    let (text, undivided) = (text.unwrap(), undivided.unwrap());
    assert_eq!(status, Some(0), "{error}");
    let rows: Vec<&str> = undivided.lines().collect();
    assert!((3000..4801).contains(&text.lines().count()) && text.lines().all(|row| rows.contains(&row)));
    // files that are not parts of one recording
    let (text, status, error) = table("refused.csv", &[&whole, &parts[0]]);
    assert_eq!((text, status), (None, Some(2)));
    assert!(error.contains("a capture or the parts of one recording: give one"), "{error}");
}

#[test]
fn each_part_replays_alone() {
    let Recorded { _folder, whole, parts } = recorded(Rotation::Bytes(150_000));
    let (samples, told): (Vec<_>, Vec<_>) = parts
        .iter()
        .map(|part| replayed(&[part], &[]))
        .map(|(document, error)| (document["timing"]["samples"].as_u64().unwrap(), error))
        .unzip();
    // a line that is cut between two parts is in neither
    let (all, most) = (samples.iter().sum::<u64>(), replayed(&[&whole], &[]).0["timing"]["samples"].as_u64().unwrap());
    assert!((most - parts.len() as u64..=most).contains(&all), "{all} of {most}");
    assert!(told.iter().all(String::is_empty), "{told:?}");
}

#[test]
fn a_missing_part_is_an_outage_and_reported() {
    let Recorded { _folder, parts, .. } = recorded(Rotation::Time(Duration::from_secs(25)));
    let (document, error) = replayed(&[&parts[0], &parts[2], &parts[3], &parts[4]], &[]);
    assert!(error.contains("night.0001.mcap: part 2 is missing"), "{error}");
    assert_eq!(document["timing"]["segments"], 2);
    let samples = document["timing"]["samples"].as_u64().unwrap();
    assert!((3790..=3800).contains(&samples), "a fifth of 4800 and a line: {samples}");
    let output = vn100().arg("replay").args([&parts[0], &parts[2]]).output().unwrap();
    let summary = String::from_utf8(output.stdout).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(summary.contains("data CHECK the recording was cut: its end or a part is missing"), "{summary}");
}

#[test]
fn a_last_part_that_was_cut_at_its_beginning_leaves_the_others_whole() {
    let Recorded { _folder, parts, .. } = recorded(Rotation::Time(Duration::from_secs(25)));
    let files: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    let (without, _) = replayed(&files[..files.len() - 1], &["-d", "1h"]);
    let last = files[files.len() - 1];
    fs::write(last, &fs::read(last).unwrap()[..500]).unwrap();
    let (document, _) = replayed(&files, &["-d", "1h"]);
    assert_eq!(document["timing"], without["timing"]);
    let recorded = &document["source"]["recorded"];
    assert_eq!((&recorded["ended"], &recorded["complete"]), (&without["source"]["recorded"]["ended"], &false.into()));
    assert!(recorded["ended"].is_string(), "{recorded}");
}
