//! The paths of data through the program, and what each costs.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use nix::sys::{
    resource::{UsageWho, getrusage},
    time::TimeValLike,
};

use super::forms::Record;
use crate::figures;

const PROGRAM: &str = env!("CARGO_BIN_EXE_vn100");
const ROUNDS: usize = 11;

/// Wall time after which a path has been measured enough.
const ENOUGH_S: f64 = 4.0;

/// The bytes of a file, which the first row gives the time of.
const SHA256SUM: &str = "sha256sum";

/// Name of the row, unit, and command line, in which `@NAME` is a file of the record.
const PATHS: [(&str, &str, &str); 35] = [
    (SHA256SUM, "line", "sha256sum @text.vnymr"),
    ("`$VNYMR`", "line", "vn100 replay @text.vnymr"),
    ("`$VNYMR`, one core", "line", "taskset -c 0 vn100 replay @text.vnymr"),
    ("`$VNIMU`", "line", "vn100 replay --rate 40 @text.vnimu"),
    ("packets", "packet", "vn100 replay @packets.bin"),
    ("raw bytes and times", "line", "vn100 replay @raw.bin"),
    ("recording", "line", "vn100 replay @recording.mcap"),
    ("gzip", "line", "vn100 replay @text.gz"),
    ("CSV of integers", "row", "vn100 replay @fields.csv"),
    ("CSV of floats", "row", "vn100 replay @floats.csv"),
    ("ROS 1 bag", "message", "vn100 replay @plain.bag"),
    ("rosbag2, SQLite", "message", "vn100 replay @db3"),
    ("rosbag2, SQLite, messages in zstd", "message", "vn100 replay @db3-messages"),
    ("rosbag2, MCAP", "message", "vn100 replay @mcap"),
    ("rosbag2, MCAP in zstd", "message", "vn100 replay @mcap-zstd"),
    ("`$VNYMR`, one line in 100 damaged", "line", "vn100 replay @damaged-100.vnymr"),
    ("`$VNYMR`, one line in 20 damaged", "line", "vn100 replay @damaged-20.vnymr"),
    ("raw bytes and times, one line in 100 lost", "line", "vn100 replay @raw-lost-100.bin"),
    ("raw bytes and times, one line in 20 lost", "line", "vn100 replay @raw-lost-20.bin"),
    ("CSV of floats, one row in 100 lost", "row", "vn100 replay @floats-lost-100.csv"),
    ("CSV of floats, one row in 20 lost", "row", "vn100 replay @floats-lost-20.csv"),
    ("a line without end", "line", "vn100 replay @endless"),
    ("`--estimator full`", "line", "vn100 replay --estimator full @text.vnymr"),
    ("`--estimator full`, one line in 100 damaged", "line", "vn100 replay --estimator full @damaged-100.vnymr"),
    ("`--json` of four files", "line", "vn100 replay --json @text.vnymr @text.vnymr @text.vnymr @text.vnymr"),
    ("`--samples`", "row", "vn100 replay --samples - @text.vnymr"),
    ("`--samples` of a CSV of floats", "row", "vn100 replay --samples - @floats.csv"),
    ("`--ndjson=thin`", "document", "vn100 replay --ndjson=thin @text.vnymr"),
    ("`report`", "line", "vn100 report @text.vnymr -o @page.html"),
    ("`archive` of files of ten minutes", "file", "vn100 archive @archive"),
    ("script in Python, no deviation", "line", "python3 -c SCRIPT @text.vnymr"),
    ("pandas and allantools, `$VNYMR`", "line", "python3 -c TEXT @text.vnymr"),
    ("pandas and allantools, CSV of floats", "row", "python3 -c FLOATS @floats.csv"),
    ("rosbags and allantools, rosbag2 in MCAP", "message", "python3 -c BAG @mcap"),
    ("rosbags and allantools, messages in zstd", "message", "python3 -c BAG @db3-messages"),
];

/// Each program of Python, and the row of the same work.
const PEERS: [(&str, &str); 5] = [
    ("script in Python, no deviation", "`$VNYMR`"),
    ("pandas and allantools, `$VNYMR`", "`$VNYMR`"),
    ("pandas and allantools, CSV of floats", "CSV of floats"),
    ("rosbags and allantools, rosbag2 in MCAP", "rosbag2, MCAP"),
    ("rosbags and allantools, messages in zstd", "rosbag2, SQLite, messages in zstd"),
];

/// The words of the command lines that stand for a program.
const PROGRAMS: [(&str, &str); 5] = [
    ("vn100", PROGRAM),
    (
        // the checksum of every line, and its fields
        "SCRIPT",
        "
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
",
    ),
    (
        // no checksum, twelve channels, octave taus
        "TEXT",
        "
import sys, pandas, allantools
frame = pandas.read_csv(sys.argv[1], header=None, usecols=range(1, 13))
frame[12] = frame[12].str.slice(0, 10).astype(float)
for name in frame:
    y = frame[name].to_numpy()
    y.mean(), y.std(ddof=1), y.min(), y.max()
    allantools.oadev(y, rate=40.0, data_type='freq', taus='octave')
",
    ),
    (
        "FLOATS",
        "
import sys, pandas, allantools
frame = pandas.read_csv(sys.argv[1])
for name in frame.columns[1:]:
    y = frame[name].to_numpy()
    y.mean(), y.std(ddof=1), y.min(), y.max()
    allantools.oadev(y, rate=40.0, data_type='freq', taus='octave')
",
    ),
    (
        "BAG",
        "
import sys, pathlib, numpy, allantools
from rosbags.highlevel import AnyReader
rows = []
with AnyReader([pathlib.Path(sys.argv[1])]) as reader:
    for connection, _, data in reader.messages():
        message = reader.deserialize(data, connection.msgtype)
        rates, forces = message.angular_velocity, message.linear_acceleration
        rows.append((rates.x, rates.y, rates.z, forces.x, forces.y, forces.z))
for y in numpy.array(rows).T:
    y.mean(), y.std(ddof=1), y.min(), y.max()
    allantools.oadev(y, rate=40.0, data_type='freq', taus='octave')
",
    ),
];

/// A record, and what a path took to process it.
struct Timed {
    command: Vec<String>,
    input_bytes: u64,
    units: f64,
    cpu_s: Vec<f64>,
    wall_s: Vec<f64>,
}

impl Timed {
    fn new(line: &str, unit: &str, record: &Record) -> Self {
        let files = line.split(' ').filter_map(|word| word.strip_prefix('@')).map(|name| record.path(name));
        let word = |word: &str| match word.strip_prefix('@') {
            Some(name) => record.path(name),
            None => PROGRAMS.iter().find(|(name, _)| *name == word).map_or(word, |(_, program)| program).to_owned(),
        };
        let copies = line.matches("@text.vnymr").count().max(1) as f64;
        let units = match unit {
            "document" => record.samples as f64 / 40.0,
            "file" => record.samples as f64 / 24_000.0,
            _ => record.samples as f64 * copies,
        };
        Self {
            command: line.split(' ').map(word).collect(),
            input_bytes: files.map(|file| bytes(Path::new(&file))).sum(),
            units,
            cpu_s: Vec::new(),
            wall_s: Vec::new(),
        }
    }

    /// Runs once with the output dropped, and not again if the program is missing or fails.
    fn run(&mut self, round: usize) {
        /// No valid sample was there, as is right for some of these files.
        const NO_DATA: i32 = 3;
        let has_failed = self.cpu_s.is_empty() && round > 1;
        if has_failed || self.wall_s.iter().sum::<f64>() > ENOUGH_S {
            return;
        }
        if let Some(page) = self.command.iter().find(|word| word.ends_with(".html")) {
            let _ = fs::remove_file(page);
        }
        let (before, started) = (cpu_of_children(), Instant::now());
        let mut command = Command::new(&self.command[0]);
        command.args(&self.command[1..]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let code = command.status().ok().and_then(|status| status.code());
        let wall_s = started.elapsed().as_secs_f64();
        // the first round fills the cache, which the time of a long command does not show
        if (round > 0 || wall_s > ENOUGH_S) && code.is_some_and(|code| [0, NO_DATA].contains(&code)) {
            self.wall_s.push(wall_s);
            self.cpu_s.push((cpu_of_children() - before).as_secs_f64());
        }
    }

    fn cpu_s(&self) -> f64 {
        median(&self.cpu_s)
    }
}

/// Measures the paths whose names contain `selected`, and prints and records their rows.
pub(crate) fn measure(selected: &str) {
    let [short, long] = [60, 300].map(|minutes| Record::of(PROGRAM, minutes));
    let is_selected = |name: &str| name == SHA256SUM || name.contains(selected);
    let mut paths: Vec<_> = PATHS
        .iter()
        .filter(|(name, ..)| is_selected(name))
        .map(|(name, unit, line)| (*name, *unit, [&short, &long].map(|record| Timed::new(line, unit, record))))
        .collect();
    for round in 0..=ROUNDS {
        paths.iter_mut().flat_map(|(.., timed)| timed).for_each(|timed| timed.run(round));
    }
    paths.retain(|(name, _, [short, long])| {
        let has_run = !short.cpu_s.is_empty() && !long.cpu_s.is_empty();
        if !has_run {
            println!("{name}: skipped, a program or a package of it is missing");
        }
        has_run
    });
    let [_, hashed] = &paths[0].2;
    let sha256_s_per_byte = hashed.cpu_s() / hashed.input_bytes as f64;
    println!(
        "{:<44}{:>9}{:>11}{:>10}{:>9}{:>9}{:>13}",
        "path", "unit", "ns a unit", "fixed ms", "CPU s", "wall s", "of sha256sum"
    );
    for (name, unit, [short, long]) in &paths {
        let s_a_unit = (long.cpu_s() - short.cpu_s()) / (long.units - short.units);
        let values = [
            ("unit", (*unit).to_owned()),
            ("ns a unit", format!("{:.0}", s_a_unit * 1e9)),
            ("fixed ms", format!("{:.1}", (short.cpu_s() - s_a_unit * short.units) * 1e3)),
            ("CPU s", format!("{:.3}", long.cpu_s())),
            ("wall s", format!("{:.3}", median(&long.wall_s))),
            ("of sha256sum", format!("{:.2}", long.cpu_s() / (sha256_s_per_byte * long.input_bytes as f64))),
        ];
        let [unit, ns, fixed, cpu, wall, of_hash] = values.each_ref().map(|(_, value)| value);
        println!("{name:<44}{unit:>9}{ns:>11}{fixed:>10}{cpu:>9}{wall:>9}{of_hash:>13}");
        figures::record("program", name, &values);
    }
    let cpu_s = |row: &str| paths.iter().find(|(name, ..)| *name == row).map(|(.., [_, long])| long.cpu_s());
    for (peer, row) in PEERS {
        if let (Some(theirs), Some(ours)) = (cpu_s(peer), cpu_s(row)) {
            let values = [
                ("vn100", format!("{ours:.3} s")),
                ("the other", format!("{theirs:.3} s")),
                ("ratio", format!("{:.1}", theirs / ours)),
            ];
            println!("{peer}: {:.1} times {row}", theirs / ours);
            figures::record("peers", peer, &values);
        }
    }
    if is_selected("pipe") {
        measure_pipes(&long);
    }
}

/// The memory of a record of any length, from a pipe.
fn measure_pipes(record: &Record) {
    println!("\n{:<34}{:>9}{:>12}{:>20}", "from a pipe", "MB", "peak KiB", "CPU ns per line");
    for copies in [1, 5, 20] {
        let before = cpu_of_children();
        let (megabytes, peak_kib) = piped(Path::new(&record.path("text.vnymr")), copies);
        let ns_per_line = (cpu_of_children() - before).as_secs_f64() / (copies * record.samples) as f64 * 1e9;
        let name = format!("replay - of {copies} records");
        println!("{name:<34}{megabytes:>9}{peak_kib:>12}{ns_per_line:>20.0}");
        let peak_mib = format!("{:.1}", peak_kib as f64 / 1024.0);
        figures::record("memory", &name, &[("peak MiB", peak_mib), ("CPU ns per line", format!("{ns_per_line:.0}"))]);
    }
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

fn bytes(path: &Path) -> u64 {
    match fs::read_dir(path) {
        Ok(entries) => entries.map(|entry| bytes(&entry.unwrap().path())).sum(),
        Err(_) => fs::metadata(path).map_or(0, |metadata| metadata.len()),
    }
}

/// User and system time of all children that have ended.
fn cpu_of_children() -> Duration {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap();
    let micros = usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
    Duration::from_micros(micros.unsigned_abs())
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
