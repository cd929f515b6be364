//! What a browser gets from a running server.

use std::{
    io::{BufRead, BufReader, Write},
    net::{SocketAddr, TcpStream},
};

use vn100_analysis::{Settings, SourceFacts};
use vn100_report::Evaluation;
use vn100_session::Stage;

use super::*;

/// No answer takes so long, not even on a machine that has other work.
const PATIENCE: Duration = Duration::from_secs(300);

/// A server, and where it is.
struct Served {
    _server: Server,
    address: SocketAddr,
}

fn drawer_of(sources: Vec<ServedSource>) -> Drawer {
    let evaluation = Arc::new(Evaluation::new(None, Vec::new(), false).unwrap());
    Drawer::new(sources, evaluation, String::new(), 0.95, Instant::now())
}

/// A server of one source, and what moves that on.
fn served() -> (Served, watch::Sender<SourceState>) {
    let facts = SourceFacts { name: "imu".into(), ..SourceFacts::default() };
    let (sender, state) = watch::channel(SourceState::new(facts, &Settings::default()));
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let drawer = drawer_of(vec![ServedSource { state, goals: Goals::default() }]);
    let server = Server::start(listener, vec!["bench".into()], drawer, PATIENCE);
    (Served { _server: server.unwrap(), address }, sender)
}

fn request(served: &Served, method: &str, path: &str, host: &str) -> TcpStream {
    let mut stream = TcpStream::connect(served.address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    stream
}

#[test]
fn a_reader_gets_the_page_as_it_changes_and_the_end_of_the_program() {
    let (server, sender) = served();
    let events = BufReader::new(request(&server, "GET", "/events", "localhost"));
    let begin = std::time::Instant::now();
    // a stream has an event every two seconds, so that a line comes
    let mut lines = events.lines().map(|line| line.unwrap()).take_while(|_| begin.elapsed() < PATIENCE);
    let mut now = || {
        lines.find(|line| line == "data: now").unwrap();
        lines.find(|line| line.contains("<p class=\"state\">")).unwrap()
    };
    assert!(now().contains(">preparing<"));
    sender.send_modify(|state| state.stage = Stage::Measuring);
    assert!(!now().contains(">preparing<"));
    sender.send_modify(|state| state.stage = Stage::Preparing);
    // the last state is sent though the second between two of them is not over
    drop(server);
    let last = now();
    assert!(last.contains(">preparing<"), "{last}");
    let end: Vec<String> = lines.filter(|line| line.starts_with("event: ") || line.starts_with("data: the")).collect();
    assert_eq!(end[end.len() - 2..], ["event: end", "data: the program ends"]);
}

/// A runtime without a clock makes the task panic at its first step.
#[test]
fn a_server_ends_although_its_drawing_has_panicked() {
    let app = Arc::new(App {
        drawer: Arc::new(Mutex::new(drawer_of(Vec::new()))),
        page: watch::channel(Arc::new(PageState::default())).0,
        streams: Arc::new(Semaphore::new(STREAMS)),
        over: CancellationToken::new(),
        hosts: Vec::new(),
    });
    let runtime = Builder::new_current_thread().build().unwrap();
    let keeping = keep_drawn(Arc::clone(&app), PATIENCE, CancellationToken::new());
    assert!(runtime.block_on(runtime.spawn(keeping)).unwrap_err().is_panic());
    assert!(app.over.is_cancelled());
}
