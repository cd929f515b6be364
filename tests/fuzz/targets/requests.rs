//! Any bytes on a connection to the live page: each answer is one of the page, forbids other sites
//! to show it, and shows nothing to requests for another name or to writes; and the page answers
//! the next reader.

use std::{
    io::{ErrorKind, Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{Arc, OnceLock},
    time::Duration,
};

use tokio::time::Instant;
use vn100_report::Evaluation;

use crate::serve::{Drawer, Server};

/// A test that waits for longer has failed.
const DEADLOCK: Duration = Duration::from_secs(60);

const GOOD: &[u8] = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";

pub(crate) fn check(bytes: &[u8]) {
    let answers = answers_to(bytes, true);
    assert!(answers.is_empty() || answers.starts_with(b"HTTP/1."), "{}", answers.escape_ascii());
    let text = String::from_utf8_lossy(&answers);
    // one connection may carry several
    for answer in text.split("HTTP/1.").skip(1) {
        let status = answer.get(2..5).unwrap_or_default();
        let is_of_the_parser = ["400", "431", "414", "501", "505"].contains(&status) && !answer.contains("nosniff");
        if is_of_the_parser {
            continue;
        }
        assert!(["200", "400", "403", "404", "405", "503"].contains(&status), "{}", answers.escape_ascii());
        assert!(answer.contains("x-content-type-options: nosniff"), "{}", answers.escape_ascii());
    }
    let asks_well = bytes.split(|byte| *byte == b'\n').any(|line| {
        line.to_ascii_lowercase().windows(5).any(|name| name == b"host:")
            || line.windows(7).any(|part| part == b"http://")
    });
    assert!(asks_well || !text.contains(" 200 OK"), "{} gave {text}", bytes.escape_ascii());
    assert!(answers_to(GOOD, false).starts_with(b"HTTP/1.1 "), "no answer after {}", bytes.escape_ascii());
}

/// All bytes until the page closes the connection. With `ends` no more bytes are sent, so the page
/// does not wait for the rest of a request, and drops unanswered requests.
fn answers_to(bytes: &[u8], ends: bool) -> Vec<u8> {
    let mut stream = TcpStream::connect(page()).unwrap();
    stream.set_read_timeout(Some(DEADLOCK)).unwrap();
    stream.set_write_timeout(Some(DEADLOCK)).unwrap();
    // it may close before all is written
    let _ = stream.write_all(bytes);
    if ends {
        let _ = stream.shutdown(Shutdown::Write);
    }
    let mut answers = Vec::new();
    let mut piece = [0; 4096];
    loop {
        // events do not end while there is a reader
        if String::from_utf8_lossy(&answers).contains("text/event-stream") {
            return answers;
        }
        match stream.read(&mut piece) {
            Ok(0) => return answers,
            Ok(read) => answers.extend_from_slice(&piece[..read]),
            // a signal of the search
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return answers,
            Err(error) => panic!("{error} after {}", bytes.escape_ascii()),
        }
    }
}

/// One page for all inputs.
fn page() -> SocketAddr {
    static PAGE: OnceLock<(SocketAddr, Server)> = OnceLock::new();
    let start = || {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let evaluation = Arc::new(Evaluation::new(None, Vec::new(), false).unwrap());
        let drawer = Drawer::new(Vec::new(), evaluation, String::new(), 0.95, Instant::now());
        (address, Server::start(listener, vec!["bench".into()], drawer, Duration::ZERO).unwrap())
    };
    PAGE.get_or_init(start).0
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let get = |path: &str| format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
    let paths =
        ["/", "/page.css", "/page.js", "/snapshot.json", "/report.html", "/metrics", "/healthz", "/events", "/none"];
    let others = [
        format!("{}{}", get("/healthz"), get("/metrics")),
        "HEAD / HTTP/1.0\r\nHost: 127.0.0.1:80\r\nConnection: keep-alive\r\n\r\n".into(),
        "POST / HTTP/1.1\r\nHost: bench\r\nContent-Length: 4\r\n\r\nabcd".into(),
        "PUT / HTTP/1.1\r\nHost: bench\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nabcd\r\n0\r\n\r\n".into(),
        "GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\nAccept: application/openmetrics-text\r\n\r\n".into(),
        "GET /events HTTP/1.1\r\nHost: [::1]\r\nLast-Event-ID: 18446744073709551615\r\n\r\n".into(),
        "GET / HTTP/1.1\r\nHost: evil.example\r\nExpect: 100-continue\r\nUpgrade: h2c\r\n\r\n".into(),
    ];
    paths.into_iter().map(get).chain(others).map(String::into_bytes).collect()
}
