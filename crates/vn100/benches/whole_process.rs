//! The program as its user runs it, from start to exit, beside `cat` and, where Python has them,
//! pandas with allantools.
//!
//! Five hours at 40 Hz, 720 000 lines, 88 MB, warm cache, as text and in every other form. Commands
//! take turns; CPU time is the kernel's account of each finished process, wall time the median of
//! the runs. `cargo bench -p vn100` prints the tables; what they are of takes 0.7 GB in the
//! target folder.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints, and stops at the first surprise")]

#[path = "../../../benches/figures.rs"]
mod figures;

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
    process::{Command, Stdio},
    time::Instant,
};

mod whole_process {
    pub(super) mod forms;
}
use whole_process::forms;

const PROGRAM: &str = env!("CARGO_BIN_EXE_vn100");
const ROUNDS: usize = 11;

/// The kernel counts CPU time for other processes in hundredths of a second.
const TICKS_PER_S: f64 = 100.0;

/// What a notebook does with the same file: no checksum, twelve channels, octave taus.
const NOTEBOOK: &str = "
import sys, pandas, allantools
frame = pandas.read_csv(sys.argv[1], header=None, usecols=range(1, 13))
frame[12] = frame[12].str.slice(0, 10).astype(float)
for name in frame:
    y = frame[name].to_numpy()
    y.mean(), y.std(ddof=1), y.min(), y.max()
    allantools.oadev(y, rate=40.0, data_type='freq', taus='octave')
";

/// What a serial script does at best: the checksum of every line, and its fields, to be looked at
/// later.
const SCRIPT: &str = "
import sys
columns = [[] for _ in range(12)]
for line in open(sys.argv[1]):
    body, check = line[1:].split('*')
    parity = 0
    for byte in body.encode():
        parity ^= byte
    if parity == int(check, 16):
        for column, field in zip(columns, body.split(',')[1:]):
            column.append(float(field))
";

struct Entry {
    name: &'static str,
    command: Vec<String>,
    cpu_s: f64,
    wall_s: Vec<f64>,
}

fn main() {
    let record = forms::record(PROGRAM);
    let file = record.text.as_str();
    let entry = |name, command: &[&str]| Entry {
        name,
        command: command.iter().map(ToString::to_string).collect(),
        cpu_s: 0.0,
        wall_s: Vec::new(),
    };
    let mut entries = vec![
        entry("cat", &["cat", file]),
        entry("replay", &[PROGRAM, "replay", file]),
        entry("replay, one core", &["taskset", "-c", "0", PROGRAM, "replay", file]),
        entry("replay --estimator full", &[PROGRAM, "replay", "--estimator", "full", file]),
        entry("replay --json of four files", &[PROGRAM, "replay", "--json", file, file, file, file]),
        entry("replay, raw bytes and times", &[PROGRAM, "replay", &record.raw]),
        entry("replay, recording", &[PROGRAM, "replay", &record.recording]),
        entry("replay, CSV with fields", &[PROGRAM, "replay", &record.csv]),
        entry("replay, gzip", &[PROGRAM, "replay", &record.gzip]),
        entry("replay, a line in 1000 damaged", &[PROGRAM, "replay", &record.damaged]),
        entry("replay, random bytes", &[PROGRAM, "replay", &record.random]),
        entry("replay, a line without end", &[PROGRAM, "replay", &record.endless]),
        entry("sha256sum", &["sha256sum", file]),
        entry("a script in Python, fields only", &["python3", "-c", SCRIPT, file]),
    ];
    let has_python = run(&["python3".into(), "-c".into(), "import pandas, allantools".into()]).is_some();
    if has_python {
        entries.push(entry("pandas and allantools", &["python3", "-c", NOTEBOOK, file]));
    }
    for round in 0..=ROUNDS {
        for entry in &mut entries {
            // Python takes seconds: three runs tell enough
            if entry.command[0] == "python3" && round > 3 {
                continue;
            }
            let before = children_cpu_s();
            let started = Instant::now();
            if run(&entry.command).is_none() {
                continue;
            }
            // the first round warms the cache
            if round > 0 {
                entry.wall_s.push(started.elapsed().as_secs_f64());
                entry.cpu_s += children_cpu_s() - before;
            }
        }
    }
    println!("{:<34}{:>9}{:>10}{:>12}{:>15}", "720 000 lines, 88 MB", "CPU s", "wall s", "CPU / cat", "CPU / replay");
    let (cat_s, replay_s) = (cpu_s(&entries[0]), cpu_s(&entries[1]));
    for entry in entries.iter_mut().filter(|entry| !entry.wall_s.is_empty()) {
        entry.wall_s.sort_by(f64::total_cmp);
        let wall_s = entry.wall_s[entry.wall_s.len() / 2];
        let cpu_s = cpu_s(entry);
        println!("{:<34}{cpu_s:>9.3}{wall_s:>10.3}{:>12.1}{:>15.2}", entry.name, cpu_s / cat_s, cpu_s / replay_s);
        figures::record(
            "program",
            entry.name,
            &[
                ("CPU s", format!("{cpu_s:.3}")),
                ("wall s", format!("{wall_s:.3}")),
                ("CPU, of `replay`", format!("{:.2}", cpu_s / replay_s)),
            ],
        );
        if entry.command[0] == "python3" {
            let values = [
                ("vn100", format!("{replay_s:.3} s")),
                ("the other", format!("{cpu_s:.3} s")),
                ("ratio", format!("{:.1}", cpu_s / replay_s)),
            ];
            figures::record("peers", &format!("replay, {}", entry.name), &values);
        }
    }
    if !has_python {
        println!("pandas and allantools: skipped, python3 has them not");
    }
    println!("\n{:<34}{:>9}{:>12}{:>20}", "from a pipe", "MB", "peak KiB", "CPU ns per line");
    for copies in [1, 5, 20] {
        let before = children_cpu_s();
        let (megabytes, peak_kib) = piped(Path::new(file), copies);
        let ns_per_line = (children_cpu_s() - before) / (copies * forms::LINES) as f64 * 1e9;
        let name = format!("replay - of {copies} records");
        println!("{name:<34}{megabytes:>9}{peak_kib:>12}{ns_per_line:>20.0}");
        let peak_mib = format!("{:.1}", peak_kib as f64 / 1024.0);
        figures::record("memory", &name, &[("peak MiB", peak_mib), ("CPU ns per line", format!("{ns_per_line:.0}"))]);
    }
}

fn cpu_s(entry: &Entry) -> f64 {
    entry.cpu_s / entry.wall_s.len() as f64
}

/// Runs to the end with its output dropped; `None` where the program is missing or fails.
fn run(command: &[String]) -> Option<()> {
    /// There was no valid sample, which for some of these files is right.
    const NO_DATA: i32 = 3;
    let mut command_line = Command::new(&command[0]);
    let status =
        command_line.args(&command[1..]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.ok()?.code().filter(|code| [0, NO_DATA].contains(code)).map(|_| ())
}

/// Feeds the capture several times through standard input: megabytes fed, and the most memory the
/// program ever held.
fn piped(capture: &Path, copies: u64) -> (u64, u64) {
    let mut command = Command::new(PROGRAM);
    let mut child = command
        .args(["replay", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut bytes = 0;
    for _ in 0..copies {
        bytes += io::copy(&mut File::open(capture).unwrap(), &mut stdin).unwrap();
    }
    stdin.flush().unwrap();
    // before its input ends the program is still there to be asked
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("0");
    drop(stdin);
    child.wait().unwrap();
    (bytes / 1_000_000, peak.trim().trim_end_matches(" kB").parse().unwrap())
}

/// CPU seconds of all children that have ended, by the kernel's account (Linux).
fn children_cpu_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    // the fields behind the parenthesised name; children's user and system time are numbers 16 and 17 of the line
    let fields: Vec<_> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks = |index: usize| fields[index].parse::<f64>().unwrap();
    (ticks(13) + ticks(14)) / TICKS_PER_S
}
