//! Scripts of inputs for a link, on a clock that is a number.

mod connected;
mod ending;
mod long;
mod opening;
mod properties;
mod verification;

use bytes::Bytes;
use vn100_protocol::stream::{Chunk, LinkEvent, StreamCounts};
use vn100_protocol::{DeviceError, Register, RegisterFields};

use super::*;
use crate::{connect::PortProblem, output_plan::Change};

const FRAME: &str = "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n";
const ASK_MODEL: &str = "$VNRRG,01*72";
const ASK_SERIAL: &str = "$VNRRG,03*70";
const RESUME: &str = "$VNASY,1*4E";
const PAUSE: &str = "$VNASY,0*4F";

/// A sentence with its checksum and line end.
fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", body.bytes().fold(0, |xor, byte| xor ^ byte))
}

fn serial(number: &str) -> String {
    sentence(&format!("VNRRG,03,{number}"))
}

fn open_failed(problem: PortProblem) -> Input {
    Input::OpenFailed(ConnectError::Port { port: "imu".into(), baud: 9600, problem })
}

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A link whose port always opens, unless a test makes it fail; with all results of the machine.
struct Bench {
    machine: LinkMachine,
    now: Duration,
    /// Whether the port opens, changes its baud rate and closes without errors.
    is_port_good: bool,
    port: Vec<PortAction>,
    sent: Vec<String>,
    link: Vec<LinkEventKind>,
    states: Vec<LinkState>,
    answers: Vec<(u64, Result<Response, CommandError>)>,
    counts: StreamCounts,
    rows: usize,
    error: Option<String>,
    received: u64,
    recorded: u64,
}

impl Bench {
    fn new(options: LinkOptions) -> Self {
        Self::of(true, options)
    }

    fn of(has_baud: bool, options: LinkOptions) -> Self {
        let mut bench = Self {
            machine: LinkMachine::new("imu".into(), has_baud, options),
            now: ms(0),
            is_port_good: true,
            port: Vec::new(),
            sent: Vec::new(),
            link: Vec::new(),
            states: Vec::new(),
            answers: Vec::new(),
            counts: StreamCounts::default(),
            rows: 0,
            error: None,
            received: 0,
            recorded: 0,
        };
        bench.poll();
        bench
    }

    /// A connected link whose first reads are not answered.
    fn connected(options: LinkOptions) -> Self {
        let mut bench = Self::new(options);
        bench.receive(FRAME);
        assert_eq!(bench.phase(), "connected");
        bench
    }

    fn phase(&self) -> &'static str {
        match &self.machine.phase {
            Phase::Opening => "opening",
            Phase::Scanning(_) => "scanning",
            Phase::Identifying { .. } => "identifying",
            Phase::Connected { verification: None, .. } => "connected",
            Phase::Connected { .. } => "verifying",
            Phase::RestoringOutput { .. } => "restoring",
            Phase::Closing { .. } => "closing",
            Phase::BackingOff { .. } => "backing off",
            Phase::Closed => "closed",
        }
    }

    fn input(&mut self, input: Input) {
        self.machine.handle_input(self.now, input);
        self.poll();
    }

    fn chunk(&mut self, bytes: &[u8]) -> StreamInput {
        self.received += bytes.len() as u64;
        let at_ns = Some(self.now.as_nanos() as i64);
        Chunk { bytes: Bytes::copy_from_slice(bytes), at_ns }.into()
    }

    fn receive(&mut self, text: &str) {
        let chunk = self.chunk(text.as_bytes());
        self.input(Input::Received(chunk));
    }

    /// Receives `text` every `period` for a time.
    fn stream(&mut self, text: &str, period: Duration, count: u32) {
        for _ in 0..count {
            self.wait(period);
            self.receive(text);
        }
    }

    /// Lets time pass.
    fn wait(&mut self, time: Duration) {
        let end = self.now + time;
        while let Some(due) = self.machine.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.machine.handle_timeout(self.now);
            self.poll();
        }
        self.now = end;
    }

    fn stop(&mut self) {
        self.input(Input::Stop);
    }

    /// Polls the machine as its owner does.
    fn poll(&mut self) {
        loop {
            while let Some(event) = self.machine.poll_event() {
                self.take(event);
            }
            self.answers.extend(std::iter::from_fn(|| self.machine.poll_answer()));
            if let Some(action) = self.machine.poll_port() {
                self.port.push(action);
                let input = match action {
                    _ if !self.is_port_good => continue,
                    PortAction::Open { .. } => Input::Opened(OpenPort { name: "tty".into(), latency_timer: None }),
                    PortAction::SetBaud(baud) => Input::BaudSet { baud, result: Ok(()) },
                    PortAction::Close => Input::PortClosed { unread: Vec::new() },
                };
                self.machine.handle_input(self.now, input);
            } else if let Some(line) = self.machine.poll_transmit(self.now) {
                self.sent.push(String::from_utf8(line).unwrap().trim_end().to_owned());
            } else {
                return;
            }
        }
    }

    fn take(&mut self, event: LinkOutput) {
        match event {
            LinkOutput::Recorded(StreamInput::Chunk(chunk)) => self.recorded += chunk.bytes.len() as u64,
            LinkOutput::Recorded(StreamInput::Link(LinkEvent { kind, .. })) => {
                if let LinkEventKind::DiscardedDuringBaudScan { bytes } = kind {
                    self.recorded += bytes;
                }
            }
            LinkOutput::Stream(StreamEvent::Batch(batch)) => {
                self.rows += batch.row_count();
                self.counts = batch.link;
            }
            LinkOutput::Stream(StreamEvent::Link(event)) => self.link.push(event.kind),
            LinkOutput::Stream(StreamEvent::End(end)) => self.error = end.error.map(|error| error.to_string()),
            LinkOutput::State(state) => self.states.push(state),
        }
    }

    fn take_sent(&mut self) -> Vec<String> {
        mem::take(&mut self.sent)
    }

    fn count(&self, is: fn(&LinkEventKind) -> bool) -> usize {
        self.link.iter().filter(|kind| is(kind)).count()
    }

    fn ups(&self) -> usize {
        self.count(|kind| matches!(kind, LinkEventKind::Up { .. }))
    }

    fn down_cause(&self) -> &str {
        let down = self.link.iter().rev().find(|kind| matches!(kind, LinkEventKind::Down { .. }));
        let Some(LinkEventKind::Down { cause }) = down else { panic!("it was not lost") };
        cause
    }

    /// Checks that every byte is counted and recorded, after the link has ended.
    fn assert_ledger(&mut self) {
        if self.phase() != "closed" {
            self.stop();
            self.wait(ms(10_000));
        }
        assert_eq!(self.phase(), "closed");
        assert_eq!((self.counts.bytes(), self.recorded), (self.received, self.received));
        assert!(matches!(self.states.last(), Some(LinkState::Closed { .. })));
    }
}

fn known_serial() -> LinkOptions {
    LinkOptions { known_serial: Some("7".into()), ..LinkOptions::default() }
}

/// The rate is set to 20 Hz.
fn slowed() -> LinkOptions {
    let fields = |text| RegisterFields::new(text).unwrap();
    let desired_settings = vec![Change { register: Register::ASYNC_RATE, before: fields("40"), after: fields("20") }];
    LinkOptions { desired_settings, ..LinkOptions::default() }
}

/// A sensor with desired settings that has been lost, and sends again.
fn reconnected() -> Bench {
    let mut bench = Bench::connected(LinkOptions { baud: Some(230_400), ..slowed() });
    bench.receive(FRAME);
    assert_eq!(bench.sent, ["$VNRRG,07*74"], "nothing is written to a sensor that is as it was left");
    bench.input(Input::Lost(LinkError::Disconnected));
    assert_eq!(bench.down_cause(), LinkError::Disconnected.to_string());
    bench.wait(ms(100));
    bench.take_sent();
    bench.receive(FRAME);
    assert_eq!(bench.phase(), "identifying");
    bench
}
