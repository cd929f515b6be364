//! Every form in which a sensor is recorded: repeatedly killed at random moments and resumed by the
//! same command line, and on a full disk. `VN100_KILLS=100` kills each form a hundred times.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use vn100_capture::{RecordingReader, part_path};
use vn100_protocol::stream::{Chunk, StreamInput};

use crate::support::{document, replay, run, vn100, warned};

/// The number of kills of each form in the gate.
const FEW: u64 = 2;

/// The latest time of a kill after the start of a program, or after its first bytes.
const LATEST_MS: u64 = 2500;

/// The timeout for the start of a recording.
const PATIENCE: Duration = Duration::from_secs(600);

fn kills() -> u64 {
    std::env::var("VN100_KILLS").map_or(FEW, |kills| kills.parse().unwrap())
}

/// Moments drawn at random, the same in each run. The first is the latest.
struct Moments {
    state: u64,
    is_first: bool,
}

impl Moments {
    fn new(seed: u64) -> Self {
        Self { state: seed, is_first: true }
    }

    fn below(&mut self, end: u64) -> u64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 33) % end
    }

    /// Lets a program run until such a moment, and kills it. The moment counts from its start, so that
    /// it is often before the first recorded byte, or from the first bytes that `recorded` reports.
    fn kill(&mut self, mut program: Child, recorded: impl Fn() -> bool) {
        let is_first = std::mem::take(&mut self.is_first);
        if is_first || self.below(3) > 0 {
            let begun = Instant::now();
            while !recorded() {
                assert!(begun.elapsed() < PATIENCE, "nothing is recorded");
                thread::park_timeout(Duration::from_millis(5));
            }
        }
        let moment = if is_first { LATEST_MS } else { self.below(LATEST_MS) };
        thread::park_timeout(Duration::from_millis(moment));
        program.kill().unwrap();
        program.wait().unwrap();
    }
}

/// The stream in some recordings.
fn stream(files: &[PathBuf]) -> Vec<u8> {
    let mut all = Vec::new();
    for file in files {
        // a recording that was cut before its beginning has no stream
        let Ok(mut reader) = RecordingReader::open(File::open(file).unwrap()) else { continue };
        while let Some(input) = reader.next_input().unwrap() {
            if let StreamInput::Chunk(Chunk { bytes, .. }) = input {
                all.extend(bytes);
            }
        }
    }
    all
}

/// The files of a recording, whole or in parts.
fn files(recording: &Path) -> Vec<PathBuf> {
    let parts = (1..).map(|number| part_path(recording, number));
    [recording.to_owned()]
        .into_iter()
        .filter(|file| file.exists())
        .chain(parts.take_while(|part| part.exists()))
        .collect()
}

fn stored(recording: &Path) -> u64 {
    files(recording).iter().map(|file| fs::metadata(file).map_or(0, |file| file.len())).sum()
}

/// Kills and resumes a recording with these options.
fn assert_survives(options: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("killed.mcap");
    let mut moments = Moments::new(1);
    let mut kept = Vec::new();
    let record = || {
        let mut record = vn100();
        record.args(["record", "sim", "-q", "--resume"]).args(options).arg("-o").arg(&recording);
        record
    };
    for kill in 0..kills() {
        let before = stored(&recording);
        let program = record().stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        moments.kill(program, || stored(&recording) > before + 2000);
        let now = stream(&files(&recording));
        assert!(now.starts_with(&kept), "kill {kill}: what was recorded has changed");
        kept = now;
    }
    assert!(!kept.is_empty(), "nothing was recorded before a kill");
    let ended = run(record().args(["--duration", "1s"]));
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let mut command = vn100();
    command.args(["replay", "--json"]).args(files(&recording));
    let document = document(&run(&mut command));
    assert!(document["timing"]["segments"].as_u64().unwrap() > 1, "{}", document["timing"]);
}

#[test]
fn killed_recordings_of_each_form_are_resumed() {
    let packets = ["--set-message", "BINARY", "--set-rate", "800"];
    let forms = [
        vec![],
        vec!["--set-rate", "100", "--set-message", "VNIMU"],
        packets.to_vec(),
        [&packets[..], &["--rotate", "20kB"]].concat(),
        [&packets[..], &["--rotate", "1s"]].concat(),
    ];
    let killing = forms.map(|options| thread::spawn(move || assert_survives(&options)));
    killing.into_iter().for_each(|form| form.join().unwrap());
}

#[test]
fn a_killed_table_of_samples_holds_the_first_of_those_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let mut moments = Moments::new(2);
    let mut written = 0;
    for kill in 0..kills() {
        let [table, recording] = ["csv", "mcap"].map(|ending| folder.path().join(format!("{kill}.{ending}")));
        let mut attach = vn100();
        attach.args(["attach", "sim", "--samples"]).arg(&table).arg("--record").arg(&recording);
        let attach = attach.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        moments.kill(attach, || fs::metadata(&table).is_ok_and(|table| table.len() > 1000));
        let Ok(table) = fs::read_to_string(&table) else { continue };
        let whole = &table[..table.rfind('\n').map_or(0, |end| end + 1)];
        let replayed = run(vn100().arg("replay").arg(&recording).args(["--samples", "-"]));
        let replayed = String::from_utf8(replayed.stdout).unwrap();
        // the last line may be recorded without its end, and then has the time of the read before
        let replayed = replayed.trim_end().rsplit_once('\n').map_or("", |(before, _)| before);
        // either may be longer, because each is flushed at its own times
        let common = whole.len().min(replayed.len());
        assert_eq!(whole[..common], replayed[..common], "kill {kill}");
        written += whole.lines().count();
    }
    assert!(written > 0);
}

/// Runs the program with a limit of this many KiB for each of its files.
fn run_within(kib: u32, arguments: &[&str], recording: &Path) -> Output {
    let script = format!("ulimit -f {kib}; exec \"$0\" \"$@\"");
    let mut shell = Command::new("bash");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_vn100")]).args(arguments).arg(recording);
    shell.stdin(Stdio::null()).output().unwrap()
}

fn samples(recording: &Path) -> u64 {
    replay(recording, &[]).0["timing"]["samples"].as_u64().unwrap()
}

#[test]
fn a_full_disk_stops_the_recording_and_not_the_measurement() {
    let folder = tempfile::tempdir().unwrap();
    let packets = ["--set-message", "BINARY", "--set-rate", "800"];
    for (kib, form, measured) in [(8, &[][..], 120), (32, &packets[..], 2400)] {
        let recording = folder.path().join(format!("{kib}.mcap"));
        let options = [&["attach", "sim", "--duration", "3s", "--json"], form, &["--record"]].concat();
        let output = run_within(kib, &options, &recording);
        let document = document(&output);
        assert_eq!(output.status.code(), Some(1));
        let number = |name: &str| document["timing"][name].as_u64().unwrap();
        assert_eq!(number("samples") + number("missing"), measured, "{}", document["timing"]);
        assert!(warned(&document, "incomplete"));
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains("RECORDING FAILED"), "{error}");
        assert!(samples(&recording) > 20);
    }
}

#[test]
fn a_full_disk_is_left_without_an_empty_file() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("none.mcap");
    for _ in 0..2 {
        let output = run_within(0, &["record", "sim", "--duration", "1s", "-o"], &recording);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && error.contains("cannot record to"), "{error}");
        assert!(!recording.exists());
    }
}

#[test]
fn a_recording_alone_ends_where_it_fails_and_is_readable() {
    let packets = ["--set-message", "BINARY", "--set-rate", "800"];
    let rotate = ["--rotate", "1h"];
    for (kib, form) in [(8, &[][..]), (8, &rotate), (32, &packets), (32, &[&packets[..], &rotate].concat())] {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("full.mcap");
        // the recording has no end of its own
        let output = run_within(kib, &[&["record", "sim"], form, &["-o"]].concat(), &recording);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.contains("RECORDING FAILED") && error.contains("; the session ends"), "{error}");
        assert!(!error.contains("does not depend on it"), "{error}");
        let files = files(&recording);
        assert_eq!(files.len(), 1, "{files:?}");
        assert!(samples(&files[0]) > 20);
    }
}

#[test]
fn a_recording_that_is_resumed_on_a_full_disk_stays_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("day.mcap");
    let recorded = run(vn100().args(["record", "sim", "--duration", "2s", "-o"]).arg(&recording));
    assert!(recorded.status.success());
    let before = fs::read(&recording).unwrap();
    // the recording is copied first
    let output = run_within(4, &["record", "sim", "--duration", "1s", "--resume", "-o"], &recording);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(fs::read(&recording).unwrap(), before);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "a copy is left");
}
