//! Shared parts of the end-to-end tests: running the program, and finding the recordings of real
//! sensors.
#![allow(dead_code, reason = "each test target uses its own part")]
#![allow(clippy::panic, reason = "a test fails by panicking")]

pub(crate) mod schema;

use std::{
    io::{BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    sync::mpsc,
    thread,
    time::Duration,
};

use serde_json::Value;

/// The timeout of a run of the program, also on a busy machine; a longer run is ended and is a
/// failure.
const PATIENCE: Duration = Duration::from_secs(600);

pub(crate) fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A capture of the project.
pub(crate) fn replay_log(name: &str) -> PathBuf {
    workspace().join("replay-logs").join(name)
}

/// The recordings of real sensors, which are not part of the project; `None` with a message if
/// there are none.
pub(crate) fn real_captures() -> Option<PathBuf> {
    let folder = std::env::var_os("VN100_CAPTURES").map(PathBuf::from);
    match &folder {
        Some(folder) if folder.is_dir() => return Some(folder.clone()),
        Some(folder) => eprintln!("skipped: VN100_CAPTURES names {}, which is no folder", folder.display()),
        None => eprintln!("skipped: VN100_CAPTURES names no folder of real captures"),
    }
    None
}

/// The program, with a clean environment.
pub(crate) fn vn100() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vn100"));
    // some machines export it, which adds a backtrace to error messages
    command.env_remove("RUST_BACKTRACE").stdin(Stdio::null());
    command
}

/// A capture of the emulated sensor; one of the same name is replaced.
pub(crate) fn capture(folder: &Path, name: &str, options: &[&str]) -> PathBuf {
    let path = folder.join(name);
    let output = vn100().args(["sim", "--force", "-o"]).arg(&path).args(options).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    path
}

/// Runs `vn100 replay --json` on one file, with options, and returns its document and exit code.
pub(crate) fn replay(file: &Path, options: &[&str]) -> (Value, i32) {
    let output = vn100().arg("replay").arg(file).arg("--json").args(options).output().unwrap();
    (document(&output), output.status.code().unwrap())
}

/// The document on standard output, after a check against its schema.
pub(crate) fn document(output: &Output) -> Value {
    let document = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(&output.stderr)));
    schema::check(&document);
    document
}

/// Runs a live command to its end: a source that reconnects forever would prevent its end.
pub(crate) fn run(command: &mut Command) -> Output {
    finish(command.stdin(Stdio::null()), Vec::new())
}

/// Runs a command with bytes on its standard input.
pub(crate) fn with_stdin(command: &mut Command, bytes: &[u8]) -> Output {
    finish(command.stdin(Stdio::piped()), bytes.to_vec())
}

fn finish(command: &mut Command, bytes: Vec<u8>) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // a program that stops reading early closes the pipe; its output shows the rest
    let writer = child.stdin.take().map(|mut stdin| thread::spawn(move || drop(stdin.write_all(&bytes))));
    let stdout = read_on(child.stdout.take().unwrap());
    let stderr = read_on(child.stderr.take().unwrap());
    let stdout = stdout.recv_timeout(PATIENCE);
    if stdout.is_err() {
        child.kill().unwrap();
    }
    let (status, stderr) = (child.wait().unwrap(), stderr.recv().unwrap());
    let stdout = stdout.unwrap_or_else(|_| panic!("{command:?} does not end: {}", String::from_utf8_lossy(&stderr)));
    writer.into_iter().for_each(|writer| writer.join().unwrap());
    Output { status, stdout, stderr }
}

/// Runs a command until a line on its standard error contains `said`, and interrupts it then.
#[cfg(unix)]
pub(crate) fn interrupted_after(command: &mut Command, said: &str) -> Output {
    use rustix::process::{Pid, Signal, kill_process};
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let stdout = read_on(child.stdout.take().unwrap());
    let mut lines = Lines::of(child.stderr.take().unwrap());
    let mut stderr = String::new();
    for line in lines.by_ref() {
        stderr = stderr + &line + "\n";
        if line.contains(said) {
            break;
        }
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    lines.for_each(|line| stderr = std::mem::take(&mut stderr) + &line + "\n");
    Output {
        status: child.wait().unwrap(),
        stdout: stdout.recv_timeout(PATIENCE).unwrap(),
        stderr: stderr.into_bytes(),
    }
}

/// A program that is observed while it runs, and ended when dropped.
pub(crate) struct Running {
    pub(crate) process: Child,
    /// Its output, line by line; a missing line is a failure.
    pub(crate) lines: Lines,
    stderr: mpsc::Receiver<Vec<u8>>,
}

impl Running {
    pub(crate) fn start(command: &mut Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let lines = Lines::of(process.stdout.take().unwrap());
        let stderr = read_on(process.stderr.take().unwrap());
        Self { process, lines, stderr }
    }

    /// Waits for its end; returns its status, and its text on standard error.
    pub(crate) fn end(&mut self) -> (ExitStatus, String) {
        let stderr = self.stderr.recv_timeout(PATIENCE).unwrap();
        (self.process.wait().unwrap(), String::from_utf8(stderr).unwrap())
    }
}

impl Running {
    /// Waits for this many documents of a measurement in lines, and returns the last of them. Until
    /// the first sample, lines may be heartbeats.
    pub(crate) fn nth_document(&mut self, count: usize) -> Value {
        let documents = self.lines.by_ref().map(|line| serde_json::from_str::<Value>(&line).unwrap());
        documents.filter(|document| document["type"] != "heartbeat").nth(count - 1).unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Lines in the order of arrival, each with a timeout. Dropping them closes the pipe at the next
/// line.
pub(crate) struct Lines(mpsc::Receiver<String>);

impl Lines {
    pub(crate) fn of(stream: impl Read + Send + 'static) -> Self {
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            for line in BufReader::new(stream).lines() {
                if sender.send(line.unwrap()).is_err() {
                    return;
                }
            }
        });
        Self(lines)
    }
}

impl Iterator for Lines {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        match self.0.recv_timeout(PATIENCE) {
            Ok(line) => Some(line),
            Err(mpsc::RecvTimeoutError::Disconnected) => None,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("no line in {PATIENCE:?}"),
        }
    }
}

/// All bytes until the end, after the end.
fn read_on(mut stream: impl Read + Send + 'static) -> mpsc::Receiver<Vec<u8>> {
    let (sender, all) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        // a test that has failed waits no longer
        let _ = sender.send(bytes);
    });
    all
}

pub(crate) fn channel<'a>(document: &'a Value, name: &str) -> &'a Value {
    let channels = document["channels"].as_array().unwrap();
    channels.iter().find(|channel| channel["name"] == name).unwrap_or_else(|| panic!("no channel {name}"))
}

/// The deviation of a channel at averaging factor `m`.
pub(crate) fn deviation(document: &Value, name: &str, m: u64) -> f64 {
    let points = channel(document, name)["allan"]["points"].as_array().unwrap();
    points.iter().find(|point| point["m"] == m).unwrap()["deviation"].as_f64().unwrap()
}

pub(crate) fn warned(document: &Value, kind: &str) -> bool {
    document["warnings"].as_array().unwrap().iter().any(|warning| warning["kind"] == kind)
}
