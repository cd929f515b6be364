//! Every capture below folders as one document.

use std::{
    collections::BTreeSet,
    fs,
    io::Write,
    path::Path,
    process::{Command, Stdio},
    time::SystemTime,
};

use serde_json::Value;

use crate::support::{capture, document, replay, schema, vn100};

/// Five recordings of one sensor, one of them louder, a broken file and one that is no capture.
fn archive(folder: &Path) {
    fs::create_dir_all(folder.join("in/deep")).unwrap();
    for seed in ["1", "2", "3", "4", "5"] {
        let place = if seed < "3" { "in/deep" } else { "in" };
        let path = capture(
            &folder.join(place),
            &format!("{seed}.vnimu"),
            &["--message", "VNIMU", "--seed", seed, "--duration", "60s"],
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

fn run(folder: &Path, options: &[&str]) -> (Vec<u8>, i32, String) {
    let output =
        vn100().current_dir(folder).args(["archive", "in", "--rate", "40", "-q"]).args(options).output().unwrap();
    (output.stdout, output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn each_recording_is_a_row_and_each_sensor_a_pool() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path());
    let (bytes, exit, said) = run(folder.path(), &[]);
    assert_eq!(exit, 3, "a file held nothing: {said}");
    let found: Value = serde_json::from_slice(&bytes).unwrap();
    let mut seen = BTreeSet::new();
    assert_eq!(schema::errors(&found, &mut seen), Vec::<String>::new());
    let names: Vec<&str> =
        found["recordings"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["in/3.vnimu", "in/4.vnimu", "in/5.vnimu", "in/broken.vnymr", "in/deep/1.vnimu", "in/deep/2.vnimu"]
    );
    let error = found["recordings"][3]["error"].as_str().unwrap();
    assert!(error.contains("is not a capture") && said.contains(error), "{error}");
    assert!(said.contains("vn100: in/broken.vnymr"), "the place of the file too: {said}");
    let sensors = found["sensors"].as_array().unwrap();
    assert_eq!((sensors.len(), &sensors[0]["serial"]), (1, &"0100012345".into()));
    assert_eq!(sensors[0]["recordings"].as_array().unwrap().len(), 5);
    let pools = sensors[0]["pools"].as_array().unwrap();
    assert_eq!(pools.len(), 1);
    let left_out = pools[0]["not_pooled"].as_array().unwrap();
    let reason = |what: &str| left_out.iter().find(|left| left["what"] == what).map(|left| &left["reason"]);
    assert!(reason("spectrum").is_some() && reason("recording").is_none(), "{left_out:?}");
    // a row says what the replay of the file says
    let (single, _) = replay(&folder.path().join("in/4.vnimu"), &["--rate", "40"]);
    let white = &single["channels"][6]["noise"]["white"];
    let row = &found["recordings"][1]["channels"][6];
    let found_white = row["noise"].as_array().unwrap().iter().find(|row| row["parameter"] == "white").unwrap();
    assert_eq!(
        [&found_white["value"], &found_white["lower"], &found_white["status"]],
        [&white["value"], &white["lower"], &white["status"]]
    );
    assert_eq!(
        (&row["mean"], &row["std"]),
        (&single["channels"][6]["statistics"]["mean"], &single["channels"][6]["statistics"]["std"])
    );
    let stated = |rows: &Value| -> Vec<[Value; 3]> {
        let rows = rows.as_array().unwrap().iter();
        rows.map(|row| ["parameter", "claim", "verdict"].map(|key| row[key].clone())).collect()
    };
    assert_eq!(stated(&row["verdicts"]), stated(&single["channels"][6]["verdict"]));
    let (table, ..) = run(folder.path(), &["--csv"]);
    let table = String::from_utf8(table).unwrap();
    assert!(table.lines().next().unwrap().ends_with(",verdicts,warnings,error"), "{table}");
    let gyro = table.lines().find(|line| line.starts_with("in/4.vnimu") && line.contains(",gyro_x,")).unwrap();
    let cells: Vec<_> = gyro.split(',').collect();
    let [.., verdicts, warnings, ""] = cells[..] else { panic!("{gyro}") };
    assert!(verdicts.contains("bias_instability limit ") && verdicts.contains("bias_instability typical "), "{gyro}");
    let kinds: Vec<_> = warnings.split("; ").collect();
    assert_eq!(kinds.len(), kinds.iter().collect::<BTreeSet<_>>().len(), "{gyro}");
    assert_eq!(table.lines().count(), 1 + 5 * 11 + 1);
    assert!(table.lines().all(|line| line.starts_with("name,") || line.starts_with("in/")), "{table}");
}

#[test]
fn unchanged_files_are_not_read_again_and_the_document_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path());
    let (first, ..) = run(folder.path(), &["--state", "kept"]);
    assert_eq!(run(folder.path(), &[]).0, first);
    assert_eq!(fs::read_dir(folder.path().join("kept")).unwrap().count(), 6 + 1, "and the beginnings of all");
    // another content of the same size and time: not read again
    let path = folder.path().join("in/4.vnimu");
    let (text, time) = (fs::read(&path).unwrap(), fs::metadata(&path).unwrap().modified().unwrap());
    let set = |text: &[u8], time: SystemTime| {
        fs::write(&path, text).unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
    };
    set(&vec![b'x'; text.len()], time);
    assert_eq!(run(folder.path(), &["--state", "kept"]).0, first);
    // with another option, and at another time, it is
    let error = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).unwrap()["recordings"][1]["error"].is_string();
    assert!(error(&run(folder.path(), &["--state", "kept", "--skip", "1s"]).0));
    set(&text, time);
    assert!(!error(&run(folder.path(), &["--state", "kept"]).0));
    // a damaged state is made anew
    for entry in fs::read_dir(folder.path().join("kept")).unwrap() {
        fs::write(entry.unwrap().path(), "damaged").unwrap();
    }
    assert_eq!(run(folder.path(), &["--state", "kept", "-o", "out.json"]).0, b"");
    assert_eq!(fs::read(folder.path().join("out.json")).unwrap(), first);
}

#[test]
fn what_lies_beside_a_capture_counts_as_part_of_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    let path = capture(&folder.path().join("in"), "a.bin", &["--duration", "20s"]);
    let missing = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).unwrap()["recordings"][0]["missing"].clone();
    let kept = || run(folder.path(), &["--state", "kept"]);
    assert_eq!(missing(&kept().0), 0);
    // a second is missing, as the times beside it say
    let half = fs::metadata(&path).unwrap().len() / 2;
    let times = format!("t_ns,offset\n0,0\n9000000000,{half}\n20000000000,{}\n", half * 2);
    fs::write(folder.path().join("in/a.bin.timing"), times).unwrap();
    assert_eq!(kept().0, run(folder.path(), &[]).0);
    fs::remove_file(folder.path().join("in/a.bin.timing")).unwrap();
    assert_eq!(missing(&kept().0), 0);
}

#[test]
fn states_that_cannot_be_kept_cost_the_exit_code_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path());
    fs::remove_file(folder.path().join("in/broken.vnymr")).unwrap();
    let (first, exit, _) = run(folder.path(), &["--state", "kept"]);
    assert_eq!(exit, 0);
    // a folder where a file should be
    for entry in fs::read_dir(folder.path().join("kept")).unwrap() {
        let path = entry.unwrap().path();
        fs::remove_file(&path).unwrap();
        fs::create_dir(path).unwrap();
    }
    let (again, exit, said) = run(folder.path(), &["--state", "kept"]);
    assert_eq!((again == first, exit), (true, 1));
    assert_eq!(said.matches("cannot keep states in kept").count(), 1, "{said}");
    let left = fs::read_dir(folder.path().join("kept")).unwrap();
    assert!(left.map(|entry| entry.unwrap().path()).all(|path| path.is_dir()), "no part of a file is left");
    fs::copy(folder.path().join("in/3.vnimu"), folder.path().join("in/3.csv")).unwrap();
    for wrong in [["--state", "in/3.vnimu"], ["-o", "nowhere/out.json"], ["-o", "in/3.csv"]] {
        assert_eq!(run(folder.path(), &wrong).1, 1, "{wrong:?}");
    }
}

#[test]
fn runs_that_share_their_states_do_not_disturb_each_other() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path());
    let start = || {
        let mut command = vn100();
        command.current_dir(folder.path()).args(["archive", "in", "--rate", "40", "-q", "--state", "kept"]);
        command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap()
    };
    let runs = [start(), start(), start()];
    let (expected, ..) = run(folder.path(), &[]);
    for child in runs {
        assert_eq!(child.wait_with_output().unwrap().stdout, expected);
    }
    assert_eq!(fs::read_dir(folder.path().join("kept")).unwrap().count(), 7);
}

#[cfg(unix)]
#[test]
fn an_interrupted_recording_is_marked_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    archive(folder.path());
    let pipe = folder.path().join("in/endless.vnimu");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut command = vn100();
    command.current_dir(folder.path()).args(["archive", "in", "--rate", "40", "-q", "--state", "kept"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // it is opened once the pipe is read
    let mut writer = fs::File::options().write(true).open(&pipe).unwrap();
    writer.write_all(&fs::read(folder.path().join("in/3.vnimu")).unwrap()[..30_000]).unwrap();
    assert!(Command::new("kill").arg("-INT").arg(child.id().to_string()).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    drop(writer);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = found["recordings"].as_array().unwrap();
    let row = rows.iter().find(|row| row["name"] == "in/endless.vnimu").unwrap();
    assert!(row["error"].as_str().unwrap().contains("interrupted"), "{row}");
    fs::remove_file(&pipe).unwrap();
    assert_eq!(run(folder.path(), &["--state", "kept"]).0, run(folder.path(), &[]).0);
}

#[test]
fn exports_beside_the_captures_are_skipped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    capture(&folder.path().join("in"), "a.mcap", &["--message", "VNIMU", "--duration", "30s"]);
    let forms = ["--export", "csv,json,lot", "--force", "-q"];
    let report = vn100().current_dir(folder.path().join("in")).args(["report", "a.mcap"]).args(forms).output().unwrap();
    assert!(report.status.success(), "{report:?}");
    let table = ["-o", "in/all.csv"];
    let (_, exit, said) = run(folder.path(), &table);
    assert_eq!(exit, 0, "{said}");
    assert!(said.contains("11 files are exports, no captures, as in/a.allan.csv: skipped"), "{said}");
    let first = fs::read_to_string(folder.path().join("in/all.csv")).unwrap();
    assert!(first.lines().skip(1).all(|row| row.starts_with("in/a.mcap,")), "{first}");
    let (_, exit, said) = run(folder.path(), &table);
    assert_eq!(exit, 0, "its own table of the run before is no capture: {said}");
    assert_eq!(fs::read_to_string(folder.path().join("in/all.csv")).unwrap(), first);
    let (_, exit, said) = run(folder.path(), &["-o", "out.txt"]);
    assert!(exit == 2 && said.contains("must end in .json") && !folder.path().join("out.txt").exists(), "{said}");
}

#[test]
fn the_schema_of_archives_is_printed() {
    let output = vn100().args(["schema", "archive"]).output().unwrap();
    assert_eq!(document(&output)["title"], "vn100.archive/1");
}
