//! System faults for the program and its files: disks, pipes, and kills.

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;
use vn100_capture::RecordingReader;
use vn100_protocol::stream::StreamInput;

use crate::support::{capture, replay, replay_log, vn100};

const CLEAN: &str = "clean-minute.vnymr";

/// The exit code, and the text on standard error.
fn told(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8(output.stderr.clone()).unwrap())
}

/// Runs the program by a shell, which can close what it inherits.
fn by_shell(redirected: &str, arguments: &[&str]) -> Output {
    let script = format!("exec \"$0\" \"$@\" {redirected}");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_vn100")]).args(arguments).env_remove("RUST_BACKTRACE");
    shell.stdin(Stdio::null()).output().unwrap()
}

#[test]
fn a_closed_standard_input_is_no_source() {
    for arguments in [["replay", "-"], ["attach", "-"]] {
        let (exit, error) = told(&by_shell("<&-", &arguments));
        assert_eq!(exit, Some(3), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    }
}

#[test]
fn a_closed_standard_output_is_no_error() {
    let log = replay_log(CLEAN);
    let (exit, error) = told(&by_shell(">&-", &["replay", log.to_str().unwrap()]));
    assert_eq!((exit, error.as_str()), (Some(0), ""));
}

#[test]
fn a_reader_that_has_seen_enough_ends_the_lines() {
    let log = replay_log(CLEAN);
    let mut replay =
        vn100().args(["replay", "--ndjson"]).arg(&log).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(replay.stdout.take().unwrap());
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    assert!(serde_json::from_str::<Value>(&first).is_ok());
    drop(lines);
    let (exit, error) = told(&replay.wait_with_output().unwrap());
    assert_eq!((exit, error.as_str()), (Some(0), ""));
}

#[test]
fn a_reader_that_has_seen_enough_of_the_samples_is_no_interrupt() {
    let folder = tempfile::tempdir().unwrap();
    // more than any pipe can buffer
    let file = capture(folder.path(), "a.mcap", &["--message", "VNIMU", "--duration", "1h"]);
    let mut replay = vn100()
        .args(["replay", "--samples", "-"])
        .arg(&file)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(replay.stdout.take().unwrap());
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    assert!(first.starts_with("time"), "{first}");
    drop(lines);
    let (exit, error) = told(&replay.wait_with_output().unwrap());
    assert_eq!((exit, error.as_str()), (Some(0), ""));
}

#[test]
fn a_file_without_a_byte_gives_no_page() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("empty.mcap"), "").unwrap();
    let output = vn100().current_dir(folder.path()).args(["report", "empty.mcap"]).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(3), &b""[..]), "{output:?}");
    assert!(!folder.path().join("empty.html").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_reported_before_anything_is_measured() {
    // no user may create files there
    for (place, words, of_system) in [
        ("/proc/x.mcap", "cannot record to /proc/x.mcap", 1),
        ("/sys/x.mcap", "cannot record to /sys/x.mcap", 1),
        ("/nowhere/x.mcap", "there is no folder /nowhere: create it", 0),
    ] {
        let (exit, error) = told(&vn100().args(["attach", "sim", "--record", place]).output().unwrap());
        assert_eq!(exit, Some(1), "{place}: {error}");
        assert!(error.contains(words), "{error}");
        assert_eq!(error.matches("(os error").count(), of_system, "{error}");
    }
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_read_from_its_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let child = vn100().args(["replay", "--json"]).arg(&pipe).stdout(Stdio::piped()).spawn().unwrap();
    fs::write(&pipe, fs::read(replay_log(CLEAN)).unwrap()).unwrap();
    let output = child.wait_with_output().unwrap();
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["timing"]["samples"], 2400);
}

#[test]
fn a_capture_that_is_removed_while_it_is_read_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("capture");
    fs::copy(replay_log(CLEAN), &path).unwrap();
    let capture = vn100_capture::Capture::open(&path, &vn100_capture::CaptureOptions::default()).unwrap();
    fs::remove_file(&path).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let samples = runtime.block_on(async {
        let mut events = capture.read(Default::default(), Default::default()).unwrap();
        let mut samples = 0;
        while let Some(event) = events.recv().await {
            match event {
                vn100_capture::Event::Batch(batch) => samples += batch.row_count(),
                vn100_capture::Event::End(end) => assert!(end.error.is_none()),
                event => panic!("{event:?}"),
            }
        }
        samples
    });
    assert_eq!(samples, 2400);
    let (exit, error) = told(&vn100().arg("replay").arg(&path).output().unwrap());
    assert_eq!(exit, Some(3));
    assert!(error.contains("cannot read"), "{error}");
}

/// All bytes of the stream in a recording.
fn stream(path: &Path) -> Vec<u8> {
    let mut reader = RecordingReader::open(fs::File::open(path).unwrap()).unwrap();
    let inputs = std::iter::from_fn(|| reader.next_input().unwrap());
    inputs
        .filter_map(|input| if let StreamInput::Chunk(chunk) = input { Some(chunk.bytes) } else { None })
        .flatten()
        .collect()
}

/// Bytes of a stream that may be pending: 64 KiB, and heads of the reads.
const UNWRITTEN: usize = 72 * 1024;

#[test]
fn a_recording_killed_at_any_moment_holds_the_beginning_of_its_stream_and_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let log = fs::read(replay_log(CLEAN)).unwrap();
    let mut random = 1_u64;
    let mut goes_on = 0;
    for round in 0..50 {
        let path = folder.path().join(format!("{round}.mcap"));
        let mut kept = Vec::new();
        // begun and killed, resumed and killed again
        for resume in [false, true] {
            let mut drawn = |range: std::ops::Range<usize>| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                range.start + (random >> 33) as usize % range.len()
            };
            let fed = drawn(2 * UNWRITTEN..log.len());
            let least = kept.len() + drawn(1..fed - UNWRITTEN);
            let mut record = vn100();
            record.args(["record", "-", "-o"]).arg(&path).args(if resume { &["--resume"][..] } else { &[] });
            let mut record = record.stdin(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
            let mut stdin = record.stdin.take().unwrap();
            stdin.write_all(&log[..fed]).unwrap();
            let begun = Instant::now();
            let written = loop {
                let written = fs::metadata(&path).map_or(0, |file| file.len() as usize);
                if written >= least {
                    break written;
                }
                assert!(
                    begun.elapsed() < Duration::from_secs(60),
                    "round {round}: {written} of {least} bytes in the file"
                );
                thread::yield_now();
            };
            record.kill().unwrap();
            record.wait().unwrap();
            let now = stream(&path);
            assert!(now.starts_with(&kept), "round {round}: what was recorded has changed");
            // the last read may be cut, and each has a head
            assert!(now.len() + UNWRITTEN >= written, "round {round}: {} of {written} bytes are left", now.len());
            assert!(log[..fed].starts_with(&now[kept.len()..]), "round {round}: what was not sent was recorded");
            goes_on += usize::from(!kept.is_empty() && now.len() > kept.len());
            kept = now;
        }
        // the program reads every tenth of them, the library all
        if round % 10 == 0 && !kept.is_empty() {
            let samples = replay(&path, &[]).0["timing"]["samples"].as_u64().unwrap();
            assert!(samples <= kept.len() as u64 / 122);
        }
    }
    assert!(goes_on > 40, "only {goes_on} recordings went on");
}
