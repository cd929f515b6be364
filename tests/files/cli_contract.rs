//! The interface for users and their scripts: streams, exit codes, options, the document.

use std::{
    fs,
    io::Write,
    process::{Command, Stdio},
};

use flate2::{Compression, write::GzEncoder};
use serde_json::Value;

use crate::support::{Lines, channel, document, replay, replay_log, vn100, with_stdin};

const CLEAN: &str = "clean-minute.vnymr";

#[test]
fn help_and_version_go_to_stdout() {
    for argument in ["--help", "--version"] {
        let output = vn100().arg(argument).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty());
        assert!(String::from_utf8(output.stdout).unwrap().contains("vn100"));
    }
}

#[test]
fn a_wrong_command_line_is_usage() {
    for arguments in [
        &["replay"][..],
        &["replay", "x", "--rate", "0"],
        &["replay", "x", "--rate", "nan"],
        &["replay", "x", "--estimator", "best"],
        &["attach", "sim", "--estimator", "full", "--duration", "1s"],
        &["attach", "sim", "--set-rate", "3"],
        &["attach", "sim", "--window", "900"],
        &["attach", "sim", "--set-message", "VNYBA"],
        &["attach", "sim", "--resume", "--duration", "1s"],
        &["attach", "sim", "--rotate", "1h", "--duration", "1s"],
        &["attach", "sim", "--duration", "1s", "--serve", "127.0.0.1:8199"],
        &["replay", "x", "--speed", "10x", "--serve", "8199"],
        &["record", "sim", "-o", "x.mcap", "--set-message", "VNYBA"],
        &["configure", "sim", "--set-rate", "0"],
        &["configure", "sim", "--set-message", "VNXYZ"],
        &["configure", "sim", "--set-baud", "1200"],
        &["replay", "x", "--json", "--ndjson"],
        &["sim", "-o", "x.bin", "--faults", "drop@1s"],
        &["replay", "x", "--skip", "5 parsecs"],
        &["replay", "x", "--duration", "0s"],
        &["attach", "sim", "--duration", "0s"],
        &["record", "sim", "-o", "x.mcap", "--duration", "0ms"],
        &["report", "x", "-o", "x.html", "--duration", "0s"],
        &["compare", "x", "y", "--duration", "0s"],
        &["report", "x", "-o", "x.html", "--json"],
        &["report", "x", "-o", "x.html", "--ndjson"],
        &["attach", "sim", "sim", "--record", "x.mcap", "--duration", "1s"],
        &["attach", "-", "--temperature"],
        &["record", "-", "-o", "x.mcap", "--set-rate", "40"],
        &["info", "-"],
        &["configure", "-", "--set-rate", "40"],
        &["witness", "-", "-o", "x.zip"],
        &["plan", "--rate", "300"],
        &["export", "--datasheet", "vn-100", "--to", "kalibr", "--rate", "900", "--window", "1"],
        &["sim", "-o", "x.mcap", "--duration", "1ms"],
        &["fly"],
    ] {
        let output = vn100().args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    // the usage is that of the command
    for arguments in [
        &["attach", "sim", "--resume"][..],
        &["report", "x", "-o", "/dev/full"],
        &["sim", "-o", "x.bin", "--faults", "drop@1s"],
        &["archive", "-"],
    ] {
        let output = vn100().args(arguments).output().unwrap();
        let usage = format!("\nUsage: vn100 {} ", arguments[0]);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && stderr.contains(&usage), "{stderr}");
    }
}

#[test]
fn the_document_has_every_field_of_the_contract() {
    let (document, exit) = replay(&replay_log(CLEAN), &[]);
    assert_eq!(exit, 0);
    assert_eq!(document["schema"], "vn100.analysis/2");
    for (pointer, expected) in [
        ("/source/kind", "text".into()),
        ("/source/name", CLEAN.into()),
        ("/source/message", "VNYMR".into()),
        ("/source/compensated", true.into()),
        ("/source/device", Value::Null),
        ("/source/recorded", Value::Null),
        ("/source/meta", Value::Null),
        ("/timing/rate_hz", 40.0.into()),
        ("/timing/rate_from", "assumed".into()),
        ("/timing/measured_hz", Value::Null),
        ("/timing/offset_ppm", Value::Null),
        ("/timing/duration_s", 60.0.into()),
        ("/timing/samples", 2400.into()),
        ("/timing/segments", 1.into()),
        ("/timing/gaps", 0.into()),
        ("/timing/missing", Value::Null),
        ("/timing/missing_at_least", 0.into()),
        ("/timing/missing_from", "bad-lines".into()),
        ("/timing/pending", 0.into()),
        ("/timing/interarrival_us", Value::Null),
        ("/link/bytes", fs::metadata(replay_log(CLEAN)).unwrap().len().into()),
        ("/link/frames", 2400.into()),
        ("/link/replies", 0.into()),
        ("/link/other_messages", 0.into()),
        ("/link/binary_packets", 0.into()),
        ("/link/damaged_packets", 0.into()),
        ("/link/skipped_bytes", 0.into()),
        ("/link/overrun_bytes", 0.into()),
        ("/link/reconnects", 0.into()),
        ("/link/down_s", 0.0.into()),
        ("/link/bad_frames/checksum", 0.into()),
        ("/link/bad_frames/unchecked", 0.into()),
        ("/link/bad_frames/grammar", 0.into()),
        ("/link/bad_frames/range", 0.into()),
        ("/link/bad_frames/truncated", 0.into()),
        ("/link/bad_frames/too_long", 0.into()),
    ] {
        assert_eq!(document.pointer(pointer), Some(&expected), "{pointer}");
    }
    let names: Vec<_> =
        document["channels"].as_array().unwrap().iter().map(|channel| channel["name"].as_str().unwrap()).collect();
    let expected = "yaw pitch roll mag_x mag_y mag_z accel_x accel_y accel_z gyro_x gyro_y gyro_z";
    assert_eq!(names.join(" "), expected);
    let gyro_y = channel(&document, "gyro_y");
    assert_eq!(gyro_y["unit"], "rad/s");
    assert_eq!(gyro_y["statistics"]["count"], 2400);
    assert_eq!(gyro_y["statistics"]["resolution"], 1e-6);
    assert_eq!(gyro_y["allan"]["deviation"], "allan");
    assert_eq!(gyro_y["allan"]["estimator"], "strided");
    assert_eq!(gyro_y["allan"]["confidence"], 0.95);
    let white = &gyro_y["noise"]["white"];
    assert_eq!((&white["status"], &white["unit"]), (&"estimated".into(), &"rad/s/sqrt(Hz)".into()));
    assert!(white["lower"].as_f64() < white["value"].as_f64() && white["value"].as_f64() < white["upper"].as_f64());
    for field in ["tau_min_s", "tau_max_s", "chi2", "dof", "p"] {
        assert!(gyro_y["noise"]["fit"][field].is_number(), "{field}");
    }
    for term in ["bias_instability", "rate_random_walk", "rate_ramp"] {
        assert_eq!(gyro_y["noise"][term]["status"], "not-measurable", "{term}");
    }
    assert_eq!(gyro_y["noise"]["quantization"], Value::Null);
    assert_eq!(channel(&document, "yaw")["noise"], Value::Null);
    assert_eq!(channel(&document, "mag_x")["noise"]["bias_instability"], Value::Null);
    assert_eq!((&gyro_y["verdict"][0]["verdict"], &gyro_y["verdict"][0]["claim"]), (&Value::Null, &"typical".into()));
    assert_eq!(channel(&document, "yaw")["verdict"], Value::Null);
    let points = gyro_y["allan"]["points"].as_array().unwrap();
    assert_eq!(points.len(), 11, "octaves up to m = 1024, the longest whose window fits 2400 samples");
    assert_eq!((&points[0]["m"], &points[0]["tau_s"], &points[0]["terms"]), (&1.into(), &0.025.into(), &2399.into()));
    for field in ["edf", "lower", "upper"] {
        assert!(points[0][field].is_number(), "{field}");
    }
    assert_eq!(points[1]["alpha"], 0, "white noise");
}

#[test]
fn the_same_bytes_give_the_same_bytes() {
    let run = || vn100().args(["replay", "--json"]).arg(replay_log("corrupted.vnymr")).output().unwrap().stdout;
    let first = run();
    assert!(!first.is_empty());
    assert_eq!(first, run());
}

#[cfg(unix)]
#[test]
fn a_file_of_the_user_without_an_end_is_refused() {
    let output = vn100().args(["replay", "--datasheet", "/dev/zero"]).arg(replay_log(CLEAN)).output().unwrap();
    assert!(!output.status.success() && output.stdout.is_empty());
    assert!(String::from_utf8_lossy(&output.stderr).contains("longer than 1 MiB"));
}

#[test]
fn stdin_differs_in_its_source_only() {
    for log in ["corrupted.vnymr", "binary-between.bin"] {
        let bytes = fs::read(replay_log(log)).unwrap();
        let (mut from_file, _) = replay(&replay_log(log), &[]);
        let mut from_stdin = document(&with_stdin(vn100().args(["replay", "-", "--json"]), &bytes));
        assert_eq!(from_stdin["source"]["kind"], "stdin");
        assert_eq!(from_stdin["source"]["name"], "-");
        from_file["source"] = Value::Null;
        from_stdin["source"] = Value::Null;
        assert_eq!(from_file, from_stdin);
    }
}

#[test]
fn a_cut_archive_gives_what_it_holds_and_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.gz");
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&fs::read(replay_log(CLEAN)).unwrap()).unwrap();
    let stored = encoder.finish().unwrap();
    fs::write(&path, &stored[..stored.len() / 2]).unwrap();
    let (document, exit) = replay(&path, &[]);
    assert_eq!(exit, 1);
    assert!(document["timing"]["samples"].as_u64().unwrap() > 1000);
    assert!(document["source"]["error"].as_str().unwrap().contains("reading failed"));
    let data = &document["statuses"][0];
    assert_eq!((&data["aspect"], &data["status"]), (&"data".into(), &"problem".into()));
    assert!(data["findings"][0].as_str().unwrap().starts_with("reading failed"), "{data}");
}

#[test]
fn line_ends_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = fs::read(replay_log(CLEAN)).unwrap();
    let (plain, _) = replay(&replay_log(CLEAN), &[]);
    let text = String::from_utf8(bytes).unwrap();
    for (name, end) in [("lf", "\n"), ("cr", "\r"), ("blank-lines", "\r\n\r\n"), ("doubled", "\r\r\n"), ("none", "")] {
        let path = folder.path().join(name);
        fs::write(&path, text.replace("\r\n", end)).unwrap();
        let (document, exit) = replay(&path, &[]);
        assert_eq!(exit, 0, "{name}");
        assert_eq!(document["channels"], plain["channels"], "{name}");
        assert_eq!(document["link"]["bad_frames"], plain["link"]["bad_frames"], "{name}");
    }
}

#[test]
fn several_files_come_in_the_order_given_and_the_worst_decides() {
    let folder = tempfile::tempdir().unwrap();
    let notes = folder.path().join("notes.txt");
    fs::write(&notes, "shopping: bread, milk\n").unwrap();
    let output = vn100()
        .arg("replay")
        .arg(replay_log("gaps.vnymr"))
        .arg(&notes)
        .arg(replay_log(CLEAN))
        .arg("--json")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3));
    let documents = document(&output);
    let names: Vec<_> = documents.as_array().unwrap().iter().map(|d| d["source"]["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["gaps.vnymr", "notes.txt", CLEAN]);
    assert_eq!(documents[1]["timing"]["samples"], 0);
    assert_eq!(documents[2]["timing"]["samples"], 2400);
}

#[test]
fn a_file_that_is_no_capture_is_reported_with_its_content() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content, found) in
        [("notes.txt", "shopping: bread, milk\n", "shopping: bread, milk"), ("empty", "", "an empty file")]
    {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        let output = vn100().arg("replay").arg(&path).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{name}");
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains("$VNYMR") && error.contains(found) && error.contains(name), "{error}");
    }
    let output = vn100().args(["replay", "/does/not/exist"]).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8(output.stderr).unwrap().contains("/does/not/exist"));
    let output = vn100().arg("replay").arg(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8(output.stderr).unwrap().contains("is a folder"));
}

#[test]
fn ndjson_gives_every_second_and_the_end() {
    let output = vn100().args(["replay", "--ndjson"]).arg(replay_log(CLEAN)).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let documents: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(documents.len(), 61, "one for each of 60 seconds, one at the end");
    for (second, document) in (1..=60).zip(&documents) {
        assert_eq!(document["timing"]["duration_s"], f64::from(second));
        // the line end after the last sample does not belong to it yet
        assert_eq!(document["link"]["bytes"], second * 40 * 122 - 2);
    }
    let (whole, _) = replay(&replay_log(CLEAN), &[]);
    assert_eq!(documents[60], whole);
}

#[test]
fn another_message_is_named_with_its_remedy() {
    let output =
        with_stdin(vn100().args(["replay", "-"]), b"$VNYPR,-129.867,-000.355,-000.296*61\r\n".repeat(20).as_slice());
    assert_eq!(output.status.code(), Some(3));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("VNYPR") && !text.contains("$VNWRG") && text.contains("--set-message VNIMU"), "{text}");
}

#[test]
fn a_closed_pipe_is_no_error() {
    let mut child =
        vn100().args(["replay"]).arg(replay_log(CLEAN)).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_closed_pipe_hides_no_failure() {
    for (arguments, code) in [
        (&["replay", "missing", "--json"][..], 3),
        (&["replay", "missing", "--ndjson"], 3),
        (&["replay", CLEAN, "--json", "--until", "gyro N ±0.01%"], 4),
        (&["compare", CLEAN, CLEAN, "--until", "gyro N ±0.01%"], 4),
    ] {
        let mut command = vn100();
        command.current_dir(replay_log(CLEAN).parent().unwrap()).args(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(!output.stderr.is_empty(), "{arguments:?}");
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
}

#[test]
fn each_command_tells_the_goal_that_was_not_reached() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let log = replay_log(CLEAN);
    let (log, page) = (log.to_str().unwrap(), page.to_str().unwrap());
    let expected = "the measurement ended before gyro N ±0.01 % was reached: ";
    for command in [&["replay", log][..], &["compare", log, log], &["archive", log], &["report", log, "-o", page]] {
        let output = vn100().args(command).args(["--until", "gyro N ±0.01%"]).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(4) && said.contains(expected), "{command:?}: {said}");
    }
    assert!(fs::read_to_string(page).unwrap().contains(expected));
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_like_the_end_of_the_data() {
    for signal in ["-INT", "-TERM"] {
        let mut command = vn100();
        let mut child =
            command.args(["replay", "-", "--ndjson"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(&fs::read(replay_log(CLEAN)).unwrap()[..80 * 122]).unwrap();
        let mut output = Lines::of(child.stdout.take().unwrap());
        // it is alive and waits for more
        let second = |line: Option<String>| -> Value { serde_json::from_str(&line.unwrap()).unwrap() };
        assert_eq!(second(output.next())["timing"]["samples"], 40);
        assert_eq!(second(output.next())["timing"]["samples"], 80);
        assert!(Command::new("kill").arg(signal).arg(child.id().to_string()).status().unwrap().success());
        let last = second(output.next());
        assert_eq!(last["timing"]["samples"], 80);
        assert!(last["source"]["error"].as_str().unwrap().contains("interrupted"));
        assert_eq!(child.wait().unwrap().code(), Some(0), "{signal}");
        drop(stdin);
    }
}

#[cfg(target_os = "linux")]
#[cfg(unix)]
#[test]
fn a_capture_that_does_not_fit_on_the_disk_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    // a file may have eight blocks; the signal for further ones is ignored
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" sim -o \"$1\"";
    for name in ["x.vnymr", "x.mcap"] {
        let file = folder.path().join(name);
        let program = env!("CARGO_BIN_EXE_vn100");
        let output = Command::new("sh").args(["-c", script, program]).arg(&file).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && told.contains("cannot write"), "{told}");
        assert!(!file.exists(), "{name}");
    }
}

#[test]
fn a_full_disk_is_reported() {
    let full = || Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    for arguments in [&["replay", "clean-minute.vnymr"][..], &["sim", "-o", "-", "--duration", "1s"]] {
        let output = vn100().args(arguments).current_dir(replay_log("")).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains("standard output") && error.contains("No space left"), "{error}");
    }
}

#[test]
fn the_simulated_capture_is_the_shipped_one() {
    let output = vn100().args("sim -o - --like lab3 --duration 60s --rate 40 --seed 1".split(' ')).output().unwrap();
    assert!(output.stdout == fs::read(replay_log(CLEAN)).unwrap(), "the recipe of {CLEAN} gives other bytes");
}

#[test]
fn sim_replaces_nothing_unasked_and_names_its_choices() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.vnymr");
    let run = |more: &[&str]| vn100().args(["sim", "--duration", "1s", "-o"]).arg(&path).args(more).output().unwrap();
    assert_eq!(run(&[]).status.code(), Some(0));
    assert_eq!(fs::read(&path).unwrap().len(), 40 * 122);
    let refused = run(&[]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8(refused.stderr).unwrap().contains("--force"));
    assert_eq!(run(&["--force", "--rate", "200"]).status.code(), Some(0));
    assert_eq!(fs::read(&path).unwrap().len(), 200 * 122);
    let unknown = run(&["--force", "--like", "mars"]);
    assert!(String::from_utf8(unknown.stderr).unwrap().contains("lab3"));
    let odd = run(&["--force", "--rate", "33"]);
    assert!(String::from_utf8(odd.stderr).unwrap().contains("200"));
    assert_eq!(fs::read(&path).unwrap().len(), 200 * 122, "a refused command leaves the file as it was");
}
