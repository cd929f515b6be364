//! The live page: its answers, the requests that it refuses, and that it does not affect the measurement.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Lines, capture, channel, schema, vn100};

/// The timeout of each answer.
const PATIENCE: Duration = Duration::from_secs(600);

/// The program with its page, ended when dropped.
pub(crate) struct Served {
    process: Child,
    stderr: Lines,
    pub(crate) address: String,
}

impl Served {
    /// Starts a command with these arguments, with its page on any free port.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::start_at(arguments, "--serve=:0")
    }

    /// Starts it with the page at the address in this option.
    pub(crate) fn start_at(arguments: &[&str], serve: &str) -> Self {
        let mut command = vn100();
        let command = command.args(arguments).arg(serve).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().unwrap();
        let mut stderr = Lines::of(process.stderr.take().unwrap());
        let said = stderr.find(|line| line.contains("http://")).unwrap();
        let address = said.split("http://").nth(1).unwrap().split('/').next().unwrap().to_owned();
        Self { process, stderr, address }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// The answer to a request with these lines after the first, head and body.
    fn ask(&self, method: &str, path: &str, lines: &str) -> (String, String) {
        let mut stream = self.connect();
        write!(stream, "{method} {path} HTTP/1.1\r\nConnection: close\r\n{lines}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.to_lowercase(), body.to_owned())
    }

    pub(crate) fn get(&self, path: &str) -> (String, String) {
        self.ask("GET", path, &format!("Host: {}\r\n", self.address))
    }

    /// The events of the page, line by line.
    fn events(&self, lines: &str) -> impl Iterator<Item = String> + use<> {
        let mut stream = self.connect();
        // of the older version, whose answers have no marks between their pieces
        write!(stream, "GET /events HTTP/1.0\r\nHost: {}\r\n{lines}\r\n", self.address).unwrap();
        BufReader::new(stream).lines().map_while(Result::ok)
    }

    /// Its end: exit code and standard output.
    fn end(mut self) -> (i32, String) {
        let mut out = String::new();
        self.process.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        (self.process.wait().unwrap().code().unwrap(), out)
    }

    /// Waits until a replay is at its end.
    pub(crate) fn wait_for_the_end(&mut self) {
        self.stderr.find(|line| line.contains("replayed to its end")).unwrap();
    }

    fn interrupt(&self) {
        self.signal(Signal::INT);
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.process), signal).unwrap();
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A replay at its end, with its page.
pub(crate) fn replayed(folder: &Path) -> Served {
    let file = capture(folder, "still.mcap", &["--message", "VNIMU", "-d", "10min"]);
    let mut served = Served::start(&["replay", file.to_str().unwrap(), "--speed", "max"]);
    served.wait_for_the_end();
    served
}

#[test]
fn every_address_of_the_page_answers() {
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    for (path, kind, has) in [
        ("/", "text/html", "<section id=\"now\">"),
        ("/icon.svg", "image/svg+xml", "<svg"),
        ("/snapshot.json", "application/json", "\"schema\":\"vn100.analysis/2\""),
        ("/report.html", "text/html", "Noise report: still.mcap"),
        ("/metrics", "text/plain; version=0.0.4", "vn100_samples_total{port=\"still.mcap\"} 24000\n"),
        ("/healthz", "text/plain", "still.mcap: replayed to its end\n"),
    ] {
        let (head, body) = served.get(path);
        assert!(head.starts_with("http/1.1 200 "), "{path}: {head}");
        assert!(head.contains(&format!("content-type: {kind}")), "{path}: {head}");
        assert!(body.contains(has), "{path}: {}", &body[..body.len().min(500)]);
        for header in ["x-content-type-options: nosniff", "content-security-policy: default-src 'none'"] {
            assert!(head.contains(header), "{path}: no {header} in {head}");
        }
        assert!(!head.contains("access-control") && !head.contains("unsafe"), "{path}: {head}");
        // a page carries its styles and scripts in itself
        assert_eq!(head.contains("script-src 'sha256-"), kind == "text/html", "{path}: {head}");
        let (head, body) = served.ask("HEAD", path, &format!("Host: {}\r\n", served.address));
        assert!(head.starts_with("http/1.1 200 ") && body.is_empty(), "{path}: {head}");
    }
    schema::check(&serde_json::from_str(&served.get("/snapshot.json").1).unwrap());
    for absent in ["/nothing", "/1", "/0/x", "/events?page=1"] {
        assert!(served.get(absent).0.starts_with("http/1.1 404 "), "{absent}");
    }
    served.interrupt();
    let (code, out) = served.end();
    assert_eq!(code, 0);
    assert!(out.starts_with("still.mcap"), "{out}");
}

#[test]
fn a_warm_up_is_no_lack_of_samples() {
    let folder = TempDir::new().unwrap();
    let file = capture(folder.path(), "still.mcap", &["--message", "VNIMU", "-d", "1min"]);
    let mut served = Served::start(&["replay", file.to_str().unwrap(), "--speed", "max", "--skip", "30min"]);
    served.wait_for_the_end();
    let (_, page) = served.get("/");
    assert!(page.contains("Warm-up excluded: </b>1 min of 30 min"), "{page}");
    let empty = "<section id=\"parameters\"></section>";
    assert!(page.contains(empty) && page.contains("section:empty { display: none; }"), "{page}");
    assert!(!page.contains("No sample yet") && !page.contains("too-short"), "{page}");
}

#[test]
fn what_writes_or_asks_for_another_name_is_refused() {
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    let here = format!("Host: {}\r\n", served.address);
    for (method, lines, status) in [
        ("GET", here.as_str(), 200),
        ("GET", "Host: localhost:9\r\n", 200),
        ("POST", &here, 405),
        ("DELETE", &here, 405),
        ("OPTIONS", &here, 405),
        ("GET", "Host: evil.example\r\n", 403),
        ("GET", "Host: localhost.evil.example\r\n", 403),
        ("GET", "Host: 192.0.2.1\r\n", 403),
        ("GET", "", 400),
        ("GET", "Host: localhost\r\nHost: evil.example\r\n", 400),
        ("GET", &format!("{here}X: {}\r\n", "x".repeat(40_000)), 431),
        ("GET", &(here.clone() + &"X: x\r\n".repeat(200)), 431),
    ] {
        let mut stream = served.connect();
        // a refused connection may be closed already
        let _ = write!(stream, "{method} / HTTP/1.1\r\nConnection: close\r\n{lines}\r\n");
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer);
        let shown = &lines[..lines.len().min(60)];
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status} ")),
            "{method} {shown}: {}",
            answer.lines().next().unwrap_or("")
        );
    }
}

#[test]
fn events_continue_for_a_returning_reader_and_end_with_the_program() {
    let served = Served::start(&["attach", "sim", "--json"]);
    let mut events = served.events("");
    // the parts of one state, up to the one with its number
    let state = |events: &mut dyn Iterator<Item = String>| {
        let (mut parts, mut id) = (String::new(), String::new());
        for line in events {
            if let Some(data) = line.strip_prefix("data: ") {
                parts += data.get(..12).unwrap_or(data);
                parts += " ";
            } else if let Some(number) = line.strip_prefix("id: ") {
                id = number.to_owned();
            } else if line.is_empty() && !id.is_empty() {
                break;
            }
        }
        (parts, id)
    };
    // the first result
    while !state(&mut events).0.contains("axes <h2") {}
    // after that, only the changes
    let is_news = |parts: &str| parts.contains("now <") && !parts.contains("axes ");
    let (mut parts, mut id) = state(&mut events);
    while !is_news(&parts) {
        assert!(!id.is_empty(), "the stream has ended");
        (parts, id) = state(&mut events);
    }
    // all parts of the report are drawn again from time to time: such a state has more than the news
    let returns_to_news = (0..20).any(|_| {
        (parts, id) = state(&mut served.events(&format!("Last-Event-ID: {id}\r\n")));
        is_news(&parts)
    });
    assert!(returns_to_news, "{parts}");
    // as a browser asks for them
    let mut packed = served.connect();
    write!(packed, "GET /events HTTP/1.0\r\nHost: {}\r\nAccept-Encoding: gzip\r\n\r\n", served.address).unwrap();
    let mut packed = BufReader::new(packed);
    let mut head = String::new();
    while packed.read_line(&mut head).unwrap() > 2 {}
    assert!(head.to_lowercase().contains("content-encoding: gzip"), "{head}");
    let mut unpacked = BufReader::new(flate2::bufread::GzDecoder::new(packed)).lines().map_while(Result::ok);
    assert!(unpacked.any(|line| line.starts_with("event: snapshot")), "each event comes at once");
    let other = served.events("Last-Event-ID: 1-1\r\n").find(|line| line.starts_with("event: other"));
    assert_eq!(other.as_deref(), Some("event: other"));
    served.interrupt();
    assert!(events.any(|line| line == "event: end"));
    assert_eq!(served.end().0, 0);
}

#[test]
fn the_seventeenth_page_gets_the_present_state_and_one_that_is_closed_makes_room() {
    let served = Served::start(&["attach", "sim", "--json"]);
    // as the page knows it, even if new states follow each other closely
    fn stays_open(mut events: impl Iterator<Item = String>) -> bool {
        events.find(|line| line == "event: alive" || line == "event: full").is_some_and(|event| event == "event: alive")
    }
    let mut open: Vec<_> = (0..16).map(|_| served.events("")).collect();
    assert!(open.iter_mut().all(stays_open));
    let lines: Vec<String> = served.events("").filter(|line| line.contains(": ")).collect();
    assert!(lines.iter().any(|line| line == "event: snapshot"), "{lines:?}");
    assert_eq!(lines[lines.len() - 3..], ["retry: 5000", "event: full", "data: 16"]);
    open.pop();
    for _ in 0..20 {
        if stays_open(served.events("")) {
            return;
        }
        // its end is noticed with the next event at the latest
        assert!(open[0].any(|line| line.starts_with("event: snapshot")));
    }
    panic!("no room for another page");
}

/// A thousand connections: slow, large, hung up in the middle.
#[test]
fn the_measurement_does_not_notice_those_who_attack_its_page() {
    let options = ["attach", "sim", "--set-message", "BINARY", "--set-rate", "800", "-d", "8s", "--json"];
    let served = Served::start(&options);
    let mut events = served.events("");
    assert!(events.any(|line| line == "event: snapshot"));
    let here = format!("Host: {}\r\n", served.address);
    let ask = |text: &str| {
        // on a busy machine it may not be accepted in time, and one beyond the limit is closed already
        let stream = TcpStream::connect(&served.address);
        stream.inspect(|mut stream| _ = stream.write_all(text.as_bytes()))
    };
    let mut kept = Vec::new();
    for round in 0..250 {
        // a request that never ends, one that is too large, an answer and a stream that are not read
        let slow = ask(&format!("GET / HTTP/1.1\r\n{here}X: "));
        let large = ask(&format!("GET / HTTP/1.1\r\n{here}X: {}\r\n\r\n", "x".repeat(60_000)));
        let unread = ask(&format!("GET /report.html HTTP/1.1\r\n{here}\r\n"));
        let stream = ask(&format!("GET /events HTTP/1.1\r\n{here}\r\n"));
        if round < 100 {
            kept.push((slow, large, unread, stream));
        }
    }
    // the page that was open still gets events; on a machine that is too busy, the program ends before it has sent the last one
    assert!(events.any(|line| line.starts_with("event: ")));
    let (code, out) = served.end();
    let document: Value = serde_json::from_str(&out).unwrap();
    // on a machine that is too busy, the emulator drops packets
    let timing = |name: &str| document["timing"][name].as_u64().unwrap();
    assert_eq!(timing("samples") + timing("missing"), 6400);
    assert_eq!(code, 0);
}

#[test]
fn the_metrics_are_read_by_the_parser_of_prometheus() {
    let pythons = [std::env::var("VN100_PYTHON").unwrap_or_default(), "python3".into()];
    let has_parser = |python: &&String| {
        let imports = Command::new(python).args(["-c", "import prometheus_client"]).output();
        imports.is_ok_and(|output| output.status.success())
    };
    let Some(python) = pythons.iter().find(has_parser) else {
        eprintln!("skipped: no python3 with prometheus_client, nor one named by VN100_PYTHON");
        return;
    };
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    let script = "
import sys
from prometheus_client.parser import text_string_to_metric_families
for family in text_string_to_metric_families(sys.stdin.read()):
    for sample in family.samples:
        print(family.type, sample.name, sample.labels.get('channel', ''), sample.labels.get('bound', ''), sample.value)
";
    let document: Value = serde_json::from_str(&served.get("/snapshot.json").1).unwrap();
    let text = served.get("/metrics").1;
    let mut parser = Command::new(python);
    let parser = parser.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut parser = parser.stderr(Stdio::piped()).spawn().unwrap();
    parser.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let output = parser.wait_with_output().unwrap();
    assert!(output.status.success(), "{}\n{text}", String::from_utf8_lossy(&output.stderr));
    let found = String::from_utf8(output.stdout).unwrap();
    assert!(found.contains("counter vn100_samples_total   24000"), "{found}");
    let white = &channel(&document, "gyro_x")["noise"]["white"]["value"];
    let white = white.as_f64().unwrap_or_else(|| panic!("{}", channel(&document, "gyro_x")["noise"]));
    let line = found.lines().find(|line| line.contains("vn100_white_noise gyro_x value ")).unwrap();
    let value: f64 = line.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((value / white - 1.0).abs() < 1e-12, "{value} {white}");
}
