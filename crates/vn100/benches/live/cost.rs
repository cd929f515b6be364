//! CPU time, wake-ups and memory of `vn100 attach` on emulated sensors behind USB adapters with a
//! latency timer of 1 ms.

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead, BufReader, Read},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::{self, sleep},
    time::{Duration, Instant},
};

use crate::figures;

const PROGRAM: &str = env!("CARGO_BIN_EXE_vn100");
const PORTS: usize = 16;

/// Until the rate is known and all 24 registers are read, five in a second.
const SETTLING: Duration = Duration::from_secs(6);
const MEASURING: Duration = Duration::from_secs(6);

pub(crate) fn measure() {
    let folder = tempfile::tempdir().unwrap();
    let sensors: Vec<Sensor> = (1..=PORTS).map(|number| Sensor::start(folder.path(), number)).collect();
    println!(
        "{:<35}{:>8}{:>14}{:>14}{:>16}{:>10}{:>9}",
        "vn100 attach", "CPU %", "of it reads %", "bare reads %", "switches per s", "peak MiB", "missing"
    );
    for (ports, message, rate_hz, baud) in [
        (1, "VNYMR", 1, 115_200),
        (1, "VNYMR", 40, 115_200),
        (1, "VNYMR", 40, 921_600),
        (1, "VNYMR", 200, 921_600),
        (PORTS, "VNYMR", 40, 921_600),
        (PORTS, "VNYMR", 200, 921_600),
        (1, "BINARY", 200, 921_600),
        (1, "BINARY", 800, 921_600),
        (4, "BINARY", 800, 921_600),
        (PORTS, "BINARY", 200, 921_600),
    ] {
        let sensors = &sensors[..ports];
        configure(sensors, message, rate_hz, baud);
        let Cost { cpu, reading_cpu, switches_hz, peak_mib, missing } = attach(sensors);
        let bare_cpu = read_only(sensors, baud);
        // a sensor takes a fresh pseudo-terminal when its host has left
        sleep(Duration::from_millis(200));
        let name = format!("{ports} {message} at {rate_hz} Hz, {baud} baud");
        println!(
            "{name:<35}{:>8.2}{:>14.2}{:>14.2}{switches_hz:>16.0}{peak_mib:>10.1}{missing:>9}",
            100.0 * cpu,
            100.0 * reading_cpu,
            100.0 * bare_cpu
        );
        figures::record(
            "live",
            &name,
            &[
                ("CPU % of a core", format!("{:.2}", 100.0 * cpu)),
                ("of which reading", format!("{:.2}", 100.0 * reading_cpu)),
                ("bare reads", format!("{:.2}", 100.0 * bare_cpu)),
                ("peak MiB", format!("{peak_mib:.1}")),
                ("dropped", missing.to_string()),
            ],
        );
    }
}

struct Sensor {
    process: Child,
    port: PathBuf,
}

impl Sensor {
    fn start(folder: &Path, number: usize) -> Self {
        let port = folder.join(format!("imu-{number}"));
        let mut command = Command::new(PROGRAM);
        command.args(["sim", "--seed", &number.to_string(), "--link"]).arg(&port);
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        // it says its name when it is there
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut String::new()).unwrap();
        Self { process, port }
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

fn configure(sensors: &[Sensor], message: &str, rate_hz: u32, baud: u32) {
    let setting = |sensor: &Sensor| {
        let mut command = Command::new(PROGRAM);
        command.args(["configure", "--set-message", message]);
        command.args(["--set-rate", &rate_hz.to_string(), "--set-baud", &baud.to_string()]);
        command.arg(&sensor.port).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    for mut child in sensors.iter().map(setting).collect::<Vec<_>>() {
        assert!(child.wait().unwrap().success());
    }
}

struct Cost {
    /// Of one core.
    cpu: f64,
    /// Of it, what the threads take that only read the ports.
    reading_cpu: f64,
    /// How often a thread went to sleep.
    switches_hz: f64,
    peak_mib: f64,
    missing: u64,
}

fn attach(sensors: &[Sensor]) -> Cost {
    let duration = format!("{}s", (SETTLING + MEASURING).as_secs() + 1);
    let mut command = Command::new(PROGRAM);
    command.args(["attach", "--json", "--duration", &duration]).args(sensors.iter().map(|sensor| &sensor.port));
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let told = BufReader::new(process.stderr.take().unwrap()).lines();
    let connected = told.map(Result::unwrap).filter(|line| line.contains("connected to")).take(sensors.len());
    assert_eq!(connected.count(), sensors.len());
    sleep(SETTLING);
    let (before, started) = (Usage::of(process.id()), Instant::now());
    sleep(MEASURING);
    let (after, seconds) = (Usage::of(process.id()), started.elapsed().as_secs_f64());
    let status = fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap();
    let peak_mib = number(&status, "VmHWM:") as f64 / 1024.0;
    let mut document = String::new();
    process.stdout.take().unwrap().read_to_string(&mut document).unwrap();
    assert!(process.wait().unwrap().success());
    let used = after.since(&before);
    Cost {
        cpu: used.cpu_s / seconds,
        reading_cpu: used.reading_cpu_s / seconds,
        switches_hz: used.switches as f64 / seconds,
        peak_mib,
        missing: missing(&document),
    }
}

/// Of one core: a thread a port that takes bytes as they come and forgets them.
fn read_only(sensors: &[Sensor], baud: u32) -> f64 {
    let read = |sensor: &Sensor| {
        let port = serialport::new(sensor.port.to_str().unwrap(), baud).timeout(MEASURING).open();
        let mut port = port.unwrap();
        thread::spawn(move || {
            let this = Path::new("/proc/thread-self");
            let (before, started) = (Used::by(this).unwrap(), Instant::now());
            while started.elapsed() < MEASURING {
                assert!(port.read(&mut [0; 512]).unwrap() > 0);
            }
            (Used::by(this).unwrap().cpu_s - before.cpu_s) / started.elapsed().as_secs_f64()
        })
    };
    let threads: Vec<_> = sensors.iter().map(read).collect();
    threads.into_iter().map(|thread| thread.join().unwrap()).sum()
}

/// Samples of all sources that the documents miss.
fn missing(documents: &str) -> u64 {
    let documents: serde_json::Value = serde_json::from_str(documents).unwrap();
    let documents = documents.as_array().cloned().unwrap_or_else(|| vec![documents.clone()]);
    documents.iter().map(|document| document["timing"]["missing"].as_u64().unwrap()).sum()
}

/// What the threads of a process have used, by their numbers.
struct Usage(BTreeMap<String, Used>);

#[derive(Default)]
struct Used {
    cpu_s: f64,
    reading_cpu_s: f64,
    /// How often it went to sleep.
    switches: u64,
}

impl Usage {
    fn of(process: u32) -> Self {
        let threads = fs::read_dir(format!("/proc/{process}/task")).unwrap().map(|thread| thread.unwrap());
        let used =
            threads.filter_map(|thread| Some((thread.file_name().into_string().unwrap(), Used::by(&thread.path())?)));
        Self(used.collect())
    }

    /// Of the threads that are there at both times: steady running begins and ends few.
    fn since(&self, before: &Self) -> Used {
        let both = self.0.iter().filter_map(|(thread, used)| Some((used, before.0.get(thread)?)));
        both.fold(Used::default(), |sum, (after, before)| Used {
            cpu_s: sum.cpu_s + after.cpu_s - before.cpu_s,
            reading_cpu_s: sum.reading_cpu_s + after.reading_cpu_s - before.reading_cpu_s,
            switches: sum.switches + after.switches - before.switches,
        })
    }
}

impl Used {
    /// By one thread since it began; `None` when it has just ended.
    fn by(thread: &Path) -> Option<Self> {
        let schedstat = fs::read_to_string(thread.join("schedstat")).ok()?;
        let status = fs::read_to_string(thread.join("status")).ok()?;
        let cpu_ns: u64 = schedstat.split_whitespace().next()?.parse().ok()?;
        let cpu_s = cpu_ns as f64 / 1e9;
        let reads = status.lines().next()?.ends_with("serial-reader");
        let reading_cpu_s = if reads { cpu_s } else { 0.0 };
        Some(Self { cpu_s, reading_cpu_s, switches: number(&status, "voluntary_ctxt_switches:") })
    }
}

/// The number behind `name` in a table of the kernel.
fn number(table: &str, name: &str) -> u64 {
    let line = table.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}
