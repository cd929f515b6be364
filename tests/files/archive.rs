//! Every capture below folders as rows.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Command, Stdio},
};

use serde_json::Value;

use crate::support::{capture, replay, vn100, warned};

/// Three recordings of one sensor, a damaged file and one that is no capture.
fn archive(folder: &Path, message: &str) {
    fs::create_dir_all(folder.join("in/deep")).unwrap();
    for seed in ["1", "3", "4"] {
        let place = if seed == "1" { "in/deep" } else { "in" };
        let path = capture(
            &folder.join(place),
            &format!("{seed}.vnimu"),
            &["--message", message, "--seed", seed, "--duration", "20s"],
        );
        let mut text = fs::read_to_string(&path).unwrap();
        let body = "VNRRG,03,0100012345";
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        text.push_str(&format!("${body}*{checksum:02X}\r\n"));
        fs::write(&path, text).unwrap();
    }
    fs::write(folder.join("in/broken.vnymr"), "nothing of a sensor").unwrap();
    fs::write(folder.join("in/notes.md"), "about them").unwrap();
}

fn run(folder: &Path, options: &[&str]) -> (String, i32, String) {
    let output =
        vn100().current_dir(folder).args(["archive", "in", "--rate", "40", "-q"]).args(options).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), output.status.code().unwrap(), text(output.stderr))
}

fn rows(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Channels of `VNMAR`.
const VNMAR: usize = 9;
/// Channels of `VNIMU`.
const CHANNELS: usize = 11;

#[test]
fn each_recording_and_channel_is_a_row_with_the_numbers_of_its_replay() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path(), "VNIMU");
    let (text, exit, said) = run(folder.path(), &[]);
    assert_eq!(exit, 3, "a file held nothing: {said}");
    assert!(said.contains("vn100: in/broken.vnymr"), "the place of the file too: {said}");
    let rows = rows(&text);
    let mut names: Vec<&str> = rows.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names.len(), 3 * CHANNELS + 1);
    names.dedup();
    let files = ["in/3.vnimu", "in/4.vnimu", "in/broken.vnymr", "in/deep/1.vnimu"];
    assert_eq!(names, files);
    let broken = rows.iter().find(|row| row["name"] == "in/broken.vnymr").unwrap();
    assert!(broken["error"].as_str().unwrap().contains("is not a capture") && broken["channel"].is_null(), "{broken}");
    let (single, _) = replay(&folder.path().join("in/4.vnimu"), &["--rate", "40"]);
    for row in rows.iter().filter(|row| row["name"] == "in/4.vnimu") {
        let channel = crate::support::channel(&single, row["channel"].as_str().unwrap());
        assert_eq!((&row["serial"], &row["rows"]), (&"0100012345".into(), &CHANNELS.into()));
        for key in ["mean", "std", "min", "max"] {
            assert_eq!(row[key], channel["statistics"][key], "{key}");
        }
        for parameter in ["white", "bias_instability", "rate_random_walk"] {
            let found = &channel["noise"][parameter];
            let cells = ["status", "value", "lower", "upper"].map(|key| &found[key]);
            let keys = ["_status", "", "_lower", "_upper"].map(|end| &row[&format!("{parameter}{end}")]);
            assert_eq!(keys, cells, "{parameter}");
        }
    }
    let gyro = rows.iter().find(|row| row["name"] == "in/4.vnimu" && row["channel"] == "gyro_x").unwrap();
    let verdicts = gyro["verdicts"].as_str().unwrap();
    assert!(verdicts.contains("bias_instability limit ") && !verdicts.contains("typical"), "{gyro}");
    assert!(run(folder.path(), &["-o", "out.txt"]).2.contains("must end in .jsonl"));
}

#[test]
fn an_archive_continues_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path(), "VNMAR");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    for name in ["rows.jsonl", "rows.csv"] {
        let output = ["-o", name];
        assert_eq!(run(folder.path(), &output).1, 3);
        let whole = read(name);
        if name == "rows.jsonl" {
            assert_eq!(whole, run(folder.path(), &[]).0, "as on standard output");
        }
        let (_, exit, said) = run(folder.path(), &output);
        let kept_text =
            format!("vn100: nothing new: {} rows kept of 4 files; 1 of them did not succeed\n", 3 * VNMAR + 1);
        assert_eq!(
            (exit, said.as_str(), read(name)),
            (3, kept_text.as_str(), whole.clone()),
            "nothing is read again, and ends the same"
        );
        // named twice
        let options = ["archive", "in", "in/deep", "--rate", "40", "-q", "-o", name];
        let again = vn100().current_dir(folder.path()).args(options).output().unwrap();
        assert_eq!(String::from_utf8(again.stderr).unwrap(), kept_text);
        assert_eq!(read(name), whole);
        // the power failed in the middle of a row, and in the middle of the rows of a file
        for cut in [whole.len() - 7, whole.len() / 2] {
            fs::write(folder.path().join(name), &whole.as_bytes()[..cut]).unwrap();
            run(folder.path(), &output);
            assert_eq!(read(name), whole, "cut at {cut}");
        }
        // one of them is now another recording, and is listed after the others
        let path = folder.path().join("in/4.vnimu");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() / 2]).unwrap();
        let (_, exit, said) = run(folder.path(), &output);
        // the failure of another file, which is not read again
        let kept_text = format!("vn100: {} rows kept of 3 files; 1 of them did not succeed\n", 2 * VNMAR + 1);
        assert_eq!((exit, said), (3, kept_text));
        let again = read(name);
        assert_eq!(again.lines().count(), whole.lines().count());
        assert!(again.lines().last().unwrap().contains("in/4.vnimu"), "{again}");
        let kept = |text: &str| text.lines().filter(|row| !row.contains("in/4.vnimu")).collect::<String>();
        assert_eq!(kept(&again), kept(&whole));
        fs::write(&path, text).unwrap();
        // other options are another measurement
        run(folder.path(), &["-o", name, "--skip", "1s"]);
        assert!(!read(name).contains(again.lines().nth(1).unwrap()));
    }
    let (_, exit, said) = run(folder.path(), &["-o", "in/notes.csv"]);
    assert_eq!(exit, 3, "{said}");
    fs::write(folder.path().join("mine.csv"), "a,b\n1,2\n").unwrap();
    let (_, exit, said) = run(folder.path(), &["-o", "mine.csv"]);
    assert!(exit == 1 && said.contains("line 1 of mine.csv is no row of an archive"), "{said}");
}

#[test]
fn a_recording_that_was_cut_is_complete_with_a_warning_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    let path = capture(&folder.path().join("in"), "a.mcap", &["--duration", "20s"]);
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let (text, exit, said) = run(folder.path(), &[]);
    let row = &rows(&text)[0];
    let (document, status) = replay(&path, &[]);
    assert_eq!((exit, status), (0, 0), "{said}");
    assert!(row["completion"] == "complete" && document["completion"] == "complete", "{row}");
    assert!(row["warnings"].as_str().unwrap().contains("incomplete") && warned(&document, "incomplete"), "{row}");
    // the times of an emulated sensor are no dates
    assert!(row["started_ns"].is_null() && document["source"]["recorded"]["started"].is_null(), "{row}");
}

#[test]
fn files_of_a_capture_count_as_part_of_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    let path = capture(&folder.path().join("in"), "a.bin", &["--duration", "20s"]);
    let warnings = || {
        run(folder.path(), &["-o", "rows.jsonl"]);
        rows(&fs::read_to_string(folder.path().join("rows.jsonl")).unwrap())[0]["warnings"].clone()
    };
    let without_times = warnings();
    // a second is missing, as the times beside it say
    let half = fs::metadata(&path).unwrap().len() / 2;
    let times = format!("t_ns,offset\n0,0\n9000000000,{half}\n20000000000,{}\n", half * 2);
    fs::write(folder.path().join("in/a.bin.timing"), times).unwrap();
    let with_times = warnings();
    assert_ne!(with_times, without_times);
    assert_eq!(with_times, rows(&run(folder.path(), &[]).0)[0]["warnings"]);
    fs::remove_file(folder.path().join("in/a.bin.timing")).unwrap();
    assert_eq!(warnings(), without_times);
}

#[cfg(unix)]
#[test]
fn an_interrupted_archive_keeps_the_rows_it_has() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path(), "VNMAR");
    let pipe = folder.path().join("in/endless.vnimu");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut command = vn100();
    command.current_dir(folder.path()).args([
        "archive",
        "in",
        "in/endless.vnimu",
        "--rate",
        "40",
        "-q",
        "-o",
        "rows.jsonl",
    ]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // it is opened when the pipe is read
    let mut writer = fs::File::options().write(true).open(&pipe).unwrap();
    writer.write_all(&fs::read(folder.path().join("in/3.vnimu")).unwrap()[..30_000]).unwrap();
    assert!(Command::new("kill").arg("-INT").arg(child.id().to_string()).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    drop(writer);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("captures were not measured: the same command measures these alone"), "{said}");
    let text = fs::read_to_string(folder.path().join("rows.jsonl")).unwrap();
    assert!(!text.contains("endless"), "{text}");
    fs::remove_file(&pipe).unwrap();
    run(folder.path(), &["-o", "rows.jsonl"]);
    assert_eq!(fs::read_to_string(folder.path().join("rows.jsonl")).unwrap(), run(folder.path(), &[]).0);
}

#[test]
fn exports_among_the_captures_are_skipped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    capture(&folder.path().join("in"), "a.mcap", &["--message", "VNIMU", "--duration", "30s"]);
    let forms = ["--export", "csv,json", "--force", "-q"];
    let report = vn100().current_dir(folder.path().join("in")).args(["report", "a.mcap"]).args(forms).output().unwrap();
    assert!(report.status.success(), "{report:?}");
    let table = ["-o", "in/all.csv"];
    let (_, exit, said) = run(folder.path(), &table);
    assert_eq!(exit, 0, "{said}");
    assert!(said.contains("7 files are exports, no captures, as in/a.allan.csv: skipped"), "{said}");
    let first = fs::read_to_string(folder.path().join("in/all.csv")).unwrap();
    assert!(first.lines().skip(1).all(|row| row.starts_with("in/a.mcap,")), "{first}");
    let (_, exit, said) = run(folder.path(), &table);
    assert_eq!(exit, 0, "its own table of the run before is no capture: {said}");
    assert_eq!(fs::read_to_string(folder.path().join("in/all.csv")).unwrap(), first);
}
