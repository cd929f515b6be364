//! The live page in a browser that is controlled over its pipes: it follows the program. Skipped
//! without Chromium.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    process::{Child, ChildStdin, Command, Stdio},
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread,
    time::{Duration, Instant},
};

use rustix::process::Signal;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::page::{Served, replayed};
use crate::support::{capture, channel};

/// The timeout of each step; a longer step is a failure.
const PATIENCE: Duration = Duration::from_secs(600);

/// A browser with one page. Its commands and answers end with a zero byte.
struct Browser {
    process: Child,
    commands: ChildStdin,
    answers: Receiver<Value>,
    page: Value,
    number: u64,
    _profile: TempDir,
}

impl Browser {
    /// Opens a browser with this page; `None`, with a message, without a browser.
    fn open(url: &str) -> Option<Self> {
        let browsers = ["chromium", "chromium-browser", "google-chrome"];
        let Some(browser) = browsers.iter().find(|name| Command::new(name).arg("--version").output().is_ok()) else {
            eprintln!("skipped: no chromium on this machine");
            return None;
        };
        let profile = TempDir::new().unwrap();
        // it reads commands from file 3 and writes answers to file 4
        let mut process = Command::new("sh")
            .args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh", browser])
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let commands = process.stdin.take().unwrap();
        let answers = BufReader::new(process.stdout.take().unwrap()).split(0);
        let (sender, received) = mpsc::channel();
        thread::spawn(move || {
            for answer in answers.map_while(Result::ok) {
                if sender.send(serde_json::from_slice(&answer).unwrap()).is_err() {
                    return;
                }
            }
        });
        let mut browser =
            Self { process, commands, answers: received, page: Value::Null, number: 0, _profile: profile };
        browser.show(url);
        Some(browser)
    }

    /// Opens a further page in front of the others, and turns to it.
    fn show(&mut self, url: &str) {
        self.page = Value::Null;
        let target = self.call("Target.createTarget", json!({ "url": url })).unwrap()["targetId"].clone();
        let attach = json!({ "targetId": target, "flatten": true });
        self.page = self.call("Target.attachToTarget", attach).unwrap()["sessionId"].clone();
    }

    fn call(&mut self, method: &str, parameters: Value) -> Result<Value, String> {
        self.number += 1;
        let mut command = json!({ "id": self.number, "method": method, "params": parameters });
        if !self.page.is_null() {
            command["sessionId"] = self.page.clone();
        }
        write!(self.commands, "{command}\0").unwrap();
        loop {
            let answer = self.answers.recv_timeout(PATIENCE).unwrap();
            if answer["id"] == self.number {
                let error = answer.get("error").map(Value::to_string);
                return error.map_or_else(|| Ok(answer["result"].clone()), Err);
            }
        }
    }

    fn resize(&mut self, width: u32, height: u32) {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 1000 });
        self.call("Emulation.setDeviceMetricsOverride", screen).unwrap();
    }

    /// Waits until an expression is true on the page, which may be loaded again meanwhile.
    fn until(&mut self, expression: &str) {
        let begin = Instant::now();
        let wait = format!(
            "new Promise((done) => {{ const look = () => ({expression}) ? done(true) : setTimeout(look, 20); look(); }})"
        );
        let evaluate = json!({ "expression": wait, "awaitPromise": true, "returnByValue": true, "timeout": 600_000 });
        while self.call("Runtime.evaluate", evaluate.clone()).map(|found| found["result"]["value"].clone())
            != Ok(Value::Bool(true))
        {
            assert!(begin.elapsed() < PATIENCE, "never so: {expression}");
        }
    }

    fn value(&mut self, expression: &str) -> Value {
        let found = self.call("Runtime.evaluate", json!({ "expression": expression, "returnByValue": true }));
        found.unwrap()["result"]["value"].clone()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

const UP_TO_DATE: &str = "document.getElementById('connection').textContent.startsWith('Up to date')";

#[test]
fn a_page_that_is_open_survives_a_restart_of_the_program() {
    let folder = TempDir::new().unwrap();
    let [first, second] = ["first.mcap", "second.mcap"].map(|name| {
        let file = capture(folder.path(), name, &["--message", "VNIMU", "-d", "1min"]);
        file.to_str().unwrap().to_owned()
    });
    let served = Served::start(&["replay", &first, "--speed", "max"]);
    let address = served.address.clone();
    let Some(mut browser) = Browser::open(&format!("http://{address}/")) else { return };
    browser.until(UP_TO_DATE);
    // killed without a last message
    drop(served);
    browser.until("document.getElementById('connection').className === 'lost'");
    let last = browser.value("document.title + document.getElementById('now').textContent");
    assert!(last.as_str().unwrap().starts_with("first.mcap: noise, live"), "its last state stays: {last}");
    let _served = Served::start_at(&["replay", &second, "--speed", "max"], &format!("--serve={address}"));
    browser.until("document.title === 'second.mcap: noise, live'");
    browser.until(UP_TO_DATE);
    browser.until("document.querySelectorAll('#allan figure').length === 3");
}

/// A stopped program sends no end event: the page detects this by its own clock.
#[test]
fn a_page_greys_when_it_hears_no_more() {
    const OLD: &str = "document.documentElement.className === 'old' && \
        document.getElementById('connection').textContent.startsWith('No news from the program for ')";
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    let Some(mut browser) = Browser::open(&format!("http://{}/", served.address)) else { return };
    browser.until(UP_TO_DATE);
    // a page may be left open for days
    let is_dated = "document.getElementById('connection').textContent.includes(new Date().getFullYear())";
    assert_eq!(browser.value(is_dated), true);
    served.signal(Signal::STOP);
    browser.until(OLD);
    served.signal(Signal::CONT);
    browser.until(&format!("{UP_TO_DATE} && document.documentElement.className === ''"));
}

/// Answers with this page, and to a request for events with a stream that says nothing more.
fn answer(mut stream: TcpStream, page: &str, asked: &Sender<()>) {
    let Some(Ok(request)) = BufReader::new(&stream).lines().next() else { return };
    if !request.starts_with("GET /events") {
        let _ = write!(stream, "HTTP/1.0 200 OK\r\nContent-Type: text/html\r\n\r\n{page}");
        return;
    }
    let _ = write!(stream, "HTTP/1.0 200 OK\r\nContent-Type: text/event-stream\r\n\r\nevent: alive\ndata:\n\n");
    let _ = asked.send(());
    // until the page closes it
    let _ = stream.read(&mut [0]);
}

/// A connection that the network has forgotten sends neither an event nor an end.
#[test]
fn a_page_asks_anew_when_its_connection_leads_nowhere() {
    let folder = TempDir::new().unwrap();
    let page: Arc<str> = replayed(folder.path()).get("/").1.into();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (sender, asked) = mpsc::channel();
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let (page, sender) = (Arc::clone(&page), sender.clone());
            thread::spawn(move || answer(stream, &page, &sender));
        }
    });
    let Some(_browser) = Browser::open(&format!("http://{address}/")) else { return };
    for _ in 0..2 {
        asked.recv_timeout(PATIENCE).unwrap();
    }
}

/// Six streams are all that Chromium opens to one program; a seventh page would not even load.
#[test]
fn pages_in_the_background_leave_their_connections_to_others() {
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    let url = format!("http://{}/", served.address);
    let Some(mut browser) = Browser::open(&url) else { return };
    let first = browser.page.clone();
    for _ in 0..7 {
        browser.show(&url);
        browser.until(UP_TO_DATE);
    }
    browser.page = first;
    browser.call("Page.bringToFront", json!({})).unwrap();
    browser.until(UP_TO_DATE);
}

#[test]
fn each_of_several_sources_has_a_page_that_the_list_leads_to() {
    let folder = TempDir::new().unwrap();
    let files = ["a.mcap", "b.mcap"].map(|name| {
        let file = capture(folder.path(), name, &["--message", "VNIMU", "-d", "1min"]);
        file.to_str().unwrap().to_owned()
    });
    let served = Served::start(&["replay", &files[0], &files[1], "--speed", "max"]);
    let Some(mut browser) = Browser::open(&format!("http://{}/", served.address)) else { return };
    browser.until("document.querySelectorAll('#sources tbody tr').length === 2");
    browser.until(UP_TO_DATE);
    assert_eq!(browser.value("document.querySelectorAll('figure').length"), 0);
    browser.value("document.querySelector('#sources tbody tr:nth-child(2) a').click()");
    browser
        .until("document.title === 'b.mcap: noise, live' && document.querySelectorAll('#allan figure').length === 3");
    browser.until(UP_TO_DATE);
    // the curves are seen at once beside the table, and every control has a description
    browser.resize(1400, 900);
    browser.until("document.querySelector('#allan svg').getBoundingClientRect().top < innerHeight");
    browser.until("document.querySelectorAll('button').length > 20");
    let unnamed = "[...document.querySelectorAll('input, select, button')].filter((one) => \
        !one.closest('label') && !one.textContent.trim() && !one.getAttribute('aria-label')).length";
    assert_eq!(browser.value(unnamed), 0);
}

/// Tables scroll within themselves; their names stay visible. The badges stand above the curves.
#[test]
fn a_phone_shows_no_line_that_leaves_the_screen() {
    const WIDTH: u32 = 400;
    let folder = TempDir::new().unwrap();
    let file = capture(folder.path(), "a.mcap", &["--message", "VNIMU", "-d", "1min"]);
    let served = Served::start(&["replay", file.to_str().unwrap(), "--speed", "max"]);
    let Some(mut browser) = Browser::open(&format!("http://{}/report.html", served.address)) else { return };
    browser.resize(WIDTH, 800);
    browser
        .until("document.querySelectorAll('figure').length > 10 && document.querySelectorAll('caption').length > 10");
    let edge = |id: &str, edge: &str| format!("document.getElementById('{id}').getBoundingClientRect().{edge}");
    assert_eq!(browser.value(&format!("{} <= {}", edge("statuses", "bottom"), edge("allan", "top"))), true);
    browser.value("document.querySelectorAll('details').forEach((one) => { one.open = true; })");
    assert_eq!(browser.value("document.documentElement.scrollWidth"), WIDTH);
    let cut = format!(
        "[...document.querySelectorAll('caption > span, th[colspan] > span, p, li, summary, dd')]\
         .filter((one) => one.getBoundingClientRect().right > {WIDTH}).map((one) => one.textContent)"
    );
    assert_eq!(browser.value(&format!("({cut}).join('; ')")), "");
    assert!(
        browser.value("document.querySelectorAll('caption > span, th[colspan] > span').length").as_u64() > Some(10)
    );
}

/// The numbers of a table of the page, by the name of the row.
fn cells(dom: &str, name: &str) -> Vec<String> {
    let begin = format!("<th scope=\"row\">{name}</th>");
    let rows: Vec<&str> = dom.split(&begin).skip(1).filter_map(|rest| rest.split("</tr>").next()).collect();
    // the table of statistics begins with the number of samples
    let row = rows.iter().find(|row| row.contains("24\u{202f}000")).unwrap_or_else(|| panic!("{name}: {rows:?}"));
    let cells = row.split("<td>").skip(1).map(|cell| cell.split("</td>").next().unwrap());
    cells.map(|cell| cell.replace('−', "-").replace('\u{202f}', "")).collect()
}

#[test]
fn the_page_shows_the_numbers_of_the_document() {
    let folder = TempDir::new().unwrap();
    let served = replayed(folder.path());
    let document: Value = serde_json::from_str(&served.get("/snapshot.json").1).unwrap();
    let Some(mut browser) = Browser::open(&format!("http://{}/", served.address)) else { return };
    browser.until("document.querySelector('[data-ready]') !== null");
    let figures = browser.value("document.querySelectorAll('figure').length").as_u64().unwrap();
    let alive = "[...document.querySelectorAll('button')].filter((one) => one.textContent === 'Enlarge').length";
    browser.until(&format!("{figures} > 0 && {alive} === {figures}"));
    let dom = browser.value("document.documentElement.outerHTML");
    for name in ["gyro_x", "accel_z", "mag_y", "temperature"] {
        let statistics = &channel(&document, name)["statistics"];
        let shown = cells(dom.as_str().unwrap(), name);
        assert_eq!(shown[0], statistics["count"].to_string(), "{name}");
        for (text, key) in shown[1..].iter().zip(["mean", "std", "min", "max"]) {
            let (shown, exact): (f64, f64) = (text.parse().unwrap(), statistics[key].as_f64().unwrap());
            let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            assert!((shown - exact).abs() <= 0.5001 * 10_f64.powi(-(decimals as i32)), "{name} {key}: {text}, {exact}");
        }
    }
}
