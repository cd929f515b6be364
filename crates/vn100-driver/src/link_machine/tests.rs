//! Scripts of what happens to a link, on a clock that is a number.

use bytes::Bytes;
use proptest::prelude::*;
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

/// A link whose port always opens, unless a test fails it; all that the machine gave.
struct Bench {
    machine: LinkMachine,
    now: Duration,
    /// Whether the port is opened, set and closed at once.
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

    /// One that is connected, and whose first reads are answered by nothing.
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

    /// That every byte is counted and recorded, now that the link has ended.
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

/// That the rate is to be 20 Hz.
fn slowed() -> LinkOptions {
    let fields = |text| RegisterFields::new(text).unwrap();
    let desired_settings = vec![Change { register: Register::ASYNC_RATE, before: fields("40"), after: fields("20") }];
    LinkOptions { desired_settings, ..LinkOptions::default() }
}

#[test]
fn a_port_that_cannot_be_opened_ends_a_first_attempt_and_is_tried_again_after_a_connection() {
    let refusal = || open_failed(PortProblem::NotFound(vec![]));
    let mut first = Bench::new(LinkOptions::default());
    first.machine.phase = Phase::Opening;
    first.input(refusal());
    assert_eq!(first.phase(), "closed");
    assert!(first.error.as_ref().unwrap().starts_with("cannot open imu at 9600 baud"));

    let mut bench = Bench::connected(LinkOptions::default());
    bench.is_port_good = false;
    bench.input(Input::Lost(io::Error::from(io::ErrorKind::BrokenPipe).into()));
    assert_eq!(bench.phase(), "closing");
    bench.input(Input::PortClosed { unread: Vec::new() });
    for delay in [100, 200, 400, 800, 1600, 3200, 5000, 5000] {
        assert_eq!(bench.phase(), "backing off");
        assert!(
            matches!(bench.states.last(), Some(LinkState::Down { was_up: true, needs_help: false, retry_in, .. }) if *retry_in == ms(delay))
        );
        bench.wait(ms(delay) - ms(1));
        assert_eq!(bench.phase(), "backing off");
        bench.wait(ms(1));
        assert_eq!(bench.phase(), "opening");
        bench.input(refusal());
    }
    // the delay starts anew after a good frame
    bench.wait(ms(5000));
    bench.is_port_good = true;
    bench.input(Input::Opened(OpenPort::default()));
    bench.receive(FRAME);
    bench.input(Input::Lost(LinkError::Disconnected));
    assert!(matches!(bench.states.last(), Some(LinkState::Down { retry_in, .. }) if *retry_in == ms(100)));
    bench.assert_ledger();
}

#[test]
fn a_port_that_never_will_be_one_is_not_tried_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.is_port_good = false;
    bench.input(Input::Lost(LinkError::Disconnected));
    bench.input(Input::PortClosed { unread: Vec::new() });
    bench.wait(ms(100));
    bench.input(open_failed(PortProblem::NotASerialPort(vec![])));
    assert_eq!(bench.phase(), "closed");
    assert!(bench.error.is_some());
}

#[test]
fn a_scan_listens_and_asks_at_each_baud_rate() {
    let mut bench = Bench::new(LinkOptions::default());
    assert_eq!(bench.port, [PortAction::Open { baud: 115_200 }]);
    assert_eq!(bench.states.last(), Some(&LinkState::Probing { port: "tty".into(), baud: Some(115_200) }));
    bench.wait(ms(149));
    assert_eq!(bench.sent, [""; 0]);
    bench.wait(ms(1));
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    // garbage: no sensor boots here
    bench.receive(&"x".repeat(101));
    bench.wait(ms(122));
    assert_eq!(bench.port.len(), 1);
    bench.wait(ms(1));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
    bench.wait(ms(8 * (150 + 370)));
    let set = bench.port[1..9].iter().map(|action| match action {
        PortAction::SetBaud(baud) => *baud,
        other => panic!("{other:?}"),
    });
    assert_eq!(set.collect::<Vec<_>>(), BAUD_RATES[1..]);
    assert_eq!(bench.phase(), "scanning", "a second time");
    bench.assert_ledger();
}

#[test]
fn a_silent_sensor_is_waited_for_at_the_first_baud_rate_as_long_as_it_boots() {
    for baud in [None, Some(9600)] {
        let mut bench = Bench::new(LinkOptions { baud, ..LinkOptions::default() });
        bench.wait(ms(1990));
        assert_eq!(bench.port.len(), 1);
        assert!(bench.sent.len() >= 4 && bench.sent.iter().all(|line| line == ASK_MODEL));
        // the rest of a frame is no sign of a sensor that sends
        bench.receive("-00.9");
        bench.wait(ms(500));
        let next = if baud.is_none() { PortAction::SetBaud(921_600) } else { PortAction::Close };
        assert_eq!(bench.port[1], next);
        bench.receive(&sentence("VNRRG,01,VN-100"));
        assert_eq!(bench.phase(), "connected");
        bench.assert_ledger();
    }
}

#[test]
fn a_first_scan_without_a_sensor_is_repeated_once_and_ends_with_what_was_received() {
    let cases = [
        (
            true,
            false,
            "",
            2,
            "no sensor is heard on imu at 9 speeds: nothing came; check the cable, the power of the sensor and the baud rate",
        ),
        (true, true, "", 2, "it: do not only listen, or check the cable and the power of the sensor"),
        (
            true,
            false,
            "junk",
            5,
            "bytes came and none of them made a good line; check the cable, the power of the sensor and the baud rate",
        ),
        (
            true,
            false,
            "$VNRRG,01*72\r\n",
            2,
            "the line echoes, and nothing came but what was sent; take a loopback plug off; on RS-485 check",
        ),
        (
            false,
            false,
            "",
            2,
            "no sensor is heard on imu: nothing came; check the cable and the power of the sensor, and the speed that the server is set to",
        ),
    ];
    for (has_baud, listen_only, text, openings, expected) in cases {
        let mut bench = Bench::of(has_baud, LinkOptions { listen_only, ..LinkOptions::default() });
        for _ in 0..1000 {
            bench.wait(ms(130));
            if !text.is_empty() && bench.phase() == "scanning" {
                bench.receive(text);
            }
        }
        assert_eq!(bench.phase(), "closed");
        let error = bench.error.clone().unwrap();
        assert!(error.contains(expected), "{error}");
        let opened = bench.port.iter().filter(|action| matches!(action, PortAction::Open { .. })).count();
        assert_eq!(opened, openings, "{expected}");
        assert_eq!(bench.sent.is_empty(), listen_only);
        bench.assert_ledger();
    }
}

#[test]
fn the_owner_has_its_own_words_for_a_hint() {
    let mut bench = Bench::of(false, LinkOptions { hint_text: Some(|_| "own words"), ..LinkOptions::default() });
    bench.wait(ms(10_000));
    assert_eq!(bench.error.as_deref(), Some("no sensor is heard on imu: nothing came; own words"));
}

#[test]
fn a_baud_rate_that_the_port_does_not_support_is_passed_over() {
    let mut bench = Bench::new(LinkOptions::default());
    bench.receive(&"x".repeat(200));
    bench.is_port_good = false;
    bench.wait(ms(400));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
    // of the rate before
    bench.receive(FRAME);
    assert_eq!((bench.phase(), bench.machine.poll_timeout()), ("scanning", None));
    bench.input(Input::BaudSet { baud: 921_600, result: Err(io::ErrorKind::InvalidInput.into()) });
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(460_800)));
    bench.receive(FRAME);
    bench.is_port_good = true;
    bench.input(Input::BaudSet { baud: 460_800, result: Ok(()) });
    assert_eq!(bench.states.last(), Some(&LinkState::Probing { port: "tty".into(), baud: Some(460_800) }));
    bench.receive(FRAME);
    assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(460_800) }));
    bench.assert_ledger();
    assert_eq!(bench.rows, 1, "what was received at the rates before is discarded");
}

#[test]
fn a_burst_after_a_stall_does_not_show_the_baud_rate() {
    for again in [false, true] {
        let mut bench = Bench::connected(LinkOptions { baud: None, ..LinkOptions::default() });
        bench.input(Input::Lost(LinkError::Disconnected));
        bench.wait(ms(100));
        // held back at the rate it had, while the next is tried
        bench.wait(ms(2300));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
        bench.receive(FRAME);
        assert_eq!((bench.ups(), bench.port.last()), (1, Some(&PortAction::SetBaud(115_200))));
        bench.wait(ms(99));
        bench.receive(FRAME);
        bench.wait(ms(1));
        assert_eq!(bench.ups(), 1, "still of the burst");
        if again {
            bench.wait(ms(280));
            assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)), "then the rate of the burst");
        }
        bench.receive(FRAME);
        let baud = Some(if again { 921_600 } else { 115_200 });
        assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud }));
        bench.assert_ledger();
        assert_eq!(bench.rows, 2);
    }
}

#[test]
fn a_known_sensor_is_verified_before_it_is_measured() {
    for (first, second, phase) in [("7", None, "connected"), ("8", Some("7"), "connected"), ("8", Some("8"), "closed")]
    {
        let mut bench = Bench::new(known_serial());
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.take_sent()), ("identifying", vec![ASK_SERIAL.to_owned()]));
        bench.receive(FRAME);
        assert_eq!(bench.rows, 0);
        bench.receive(&serial(first));
        if let Some(second) = second {
            assert_eq!(bench.take_sent(), [ASK_SERIAL], "one reply may be damaged");
            bench.receive(&serial(second));
        }
        assert_eq!(bench.phase(), phase);
        bench.assert_ledger();
        let rows = if phase == "connected" { 2 } else { 0 };
        assert_eq!((bench.rows, bench.ups()), (rows, rows / 2));
        let other = "another sensor, serial 8, is on the port; it was 7";
        assert_eq!(bench.error.as_deref(), (rows == 0).then_some(other));
    }
    // one that does not say is taken for the known one
    let mut bench = Bench::new(known_serial());
    bench.receive(FRAME);
    bench.wait(ms(1499));
    assert_eq!((bench.phase(), bench.sent.len()), ("identifying", 3));
    bench.wait(ms(1));
    assert_eq!(bench.phase(), "connected");
    bench.assert_ledger();
    // one that only listens does not ask
    let mut bench = Bench::connected(LinkOptions { listen_only: true, ..known_serial() });
    bench.receive(&serial("8"));
    bench.wait(ms(1000));
    assert_eq!((bench.phase(), &bench.sent[..]), ("connected", &[][..]));
}

#[test]
fn a_serial_number_is_learned_and_one_that_changes_is_read_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.receive(&serial("7"));
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "connected");
    let reads = |bench: &Bench| bench.sent.iter().filter(|line| *line == ASK_SERIAL).count();
    bench.receive(&sentence("VNRRG,07,40"));
    bench.stream(FRAME, ms(100), 3);
    assert_eq!(reads(&bench), 1);
    bench.receive(&serial("7"));
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "connected", "not twice in a row");
    bench.receive(&serial("8"));
    assert_eq!(bench.phase(), "closed");
    bench.assert_ledger();
}

/// A sensor with settings to keep that has been lost, and sends again.
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

#[test]
fn settings_are_written_again_after_a_reconnect() {
    for refused in [false, true] {
        let mut bench = reconnected();
        let mut answer = |command: &str, reply: &str| {
            assert_eq!(bench.take_sent(), [command]);
            bench.receive(&(sentence(reply) + FRAME));
        };
        answer(ASK_MODEL, "VNRRG,01,VN-100");
        answer(PAUSE, "VNASY,0");
        answer(sentence("VNWRG,07,20").trim_end(), if refused { "VNERR,09" } else { "VNWRG,07,20" });
        answer(RESUME, "VNASY,1");
        assert_eq!(bench.phase(), if refused { "backing off" } else { "connected" });
        assert_eq!(bench.rows, 2, "what was sent before is no part of the measurement");
        if refused {
            let Some(LinkState::Down { cause, needs_help: true, .. }) = bench.states.last() else { panic!() };
            assert!(
                cause.starts_with("the sensor is back and cannot be set as it was: the sensor refused $VNWRG,07,20")
            );
        }
        bench.assert_ledger();
    }
}

#[test]
fn the_baud_rate_is_raised_again_where_the_settings_need_it() {
    for is_supported in [true, false] {
        let mut bench = Bench::new(slowed());
        bench.wait(ms(150));
        bench.receive(&"x".repeat(200));
        bench.wait(ms(123));
        bench.receive(FRAME);
        assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(921_600) }));
        bench.input(Input::Lost(LinkError::Disconnected));
        bench.wait(ms(100 + 150));
        bench.receive(&"x".repeat(200));
        bench.wait(ms(103));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(115_200)));
        bench.take_sent();
        bench.receive(FRAME);
        for reply in ["VNRRG,01,VN-100", "VNASY,0", "VNERR,0C", "VNASY,1"] {
            bench.receive(&sentence(reply));
        }
        assert_eq!(bench.take_sent().last().unwrap(), sentence("VNWRG,05,921600").trim_end());
        bench.is_port_good = false;
        bench.receive(&sentence("VNWRG,05,921600"));
        assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(921_600)));
        let result = if is_supported { Ok(()) } else { Err(io::Error::other("no such rate")) };
        bench.is_port_good = true;
        bench.input(Input::BaudSet { baud: 921_600, result });
        if is_supported {
            for reply in ["VNRRG,01,VN-100", "VNASY,0", "VNWRG,07,20", "VNASY,1"] {
                while bench.take_sent().is_empty() {
                    assert_eq!(bench.phase(), "identifying");
                    bench.wait(ms(10));
                }
                bench.receive(&sentence(reply));
            }
            assert_eq!(bench.link.last(), Some(&LinkEventKind::Up { port: "tty".into(), baud: Some(921_600) }));
        } else {
            assert_eq!(bench.phase(), "backing off");
        }
        bench.assert_ledger();
    }
}

#[test]
fn a_stop_while_settings_are_written_leaves_the_output_on() {
    let mut bench = reconnected();
    bench.receive(&sentence("VNRRG,01,VN-100"));
    assert_eq!(bench.sent.last().unwrap(), PAUSE);
    bench.stop();
    assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("restoring", RESUME));
    bench.receive(FRAME);
    bench.stop();
    assert_eq!(bench.phase(), "restoring");
    bench.receive(&sentence("VNASY,1"));
    assert_eq!((bench.phase(), bench.port.last()), ("closed", Some(&PortAction::Close)));
    assert_eq!(bench.error, None);
    bench.assert_ledger();
}

#[test]
fn a_silent_output_is_asked_and_given_up_without_an_answer() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.receive(&sentence("VNERR,08"));
    bench.stream(FRAME, ms(25), 100);
    bench.take_sent();
    // five periods, and 250 ms at least
    bench.wait(ms(249));
    assert!(matches!(bench.states.last(), Some(LinkState::Up(_))));
    bench.wait(ms(1));
    assert!(matches!(bench.states.last(), Some(LinkState::Silent(_))));
    // asked again until a stall would be over
    bench.wait(ms(2999));
    assert_eq!(bench.phase(), "connected");
    assert!(bench.sent.iter().filter(|line| *line == ASK_MODEL).count() >= 4);
    bench.wait(ms(1600));
    assert_eq!((bench.phase(), bench.down_cause()), ("scanning", "the sensor says nothing and does not answer"));
    bench.assert_ledger();
    // where nothing may be asked, the second check decides
    let mut bench = Bench::connected(LinkOptions { listen_only: true, ..LinkOptions::default() });
    bench.wait(ms(12_999));
    assert_eq!(bench.phase(), "connected");
    bench.wait(ms(1));
    assert_eq!((bench.phase(), bench.sent.len()), ("backing off", 0));
    bench.assert_ledger();
}

#[test]
fn a_sensor_that_sends_after_a_silence_is_verified() {
    let silent = |options: LinkOptions| {
        let mut bench = Bench::new(LinkOptions { known_serial: Some("7".into()), ..options });
        bench.receive(FRAME);
        bench.receive(&serial("7"));
        bench.receive(&sentence("VNRRG,07,40"));
        bench.wait(ms(3000));
        assert!(matches!(bench.states.last(), Some(LinkState::Silent(_))));
        bench.receive(&sentence("VNRRG,01,VN-100"));
        bench.receive("junk");
        assert_eq!((bench.phase(), bench.rows), ("connected", 1), "neither ends a silence");
        bench.take_sent();
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.rows, bench.take_sent()), ("verifying", 1, vec![ASK_SERIAL.to_owned()]));
        bench
    };
    let mut bench = silent(LinkOptions::default());
    bench.receive(FRAME);
    bench.receive(&(serial("7") + &sentence("VNERR,04")));
    assert_eq!((bench.phase(), bench.rows, bench.ups()), ("connected", 3, 1));
    assert!(matches!(bench.states.last(), Some(LinkState::Up(_))));
    assert_eq!(bench.link.last(), Some(&LinkEventKind::UnsolicitedError { error: DeviceError::InvalidCommand }));
    bench.receive(FRAME);
    assert_eq!((bench.phase(), bench.rows), ("connected", 4));
    bench.assert_ledger();

    let mut bench = silent(slowed());
    bench.receive(&serial("7"));
    assert_eq!(bench.take_sent(), ["$VNRRG,07*74"]);
    bench.receive(&sentence("VNRRG,07,20"));
    assert_eq!((bench.phase(), bench.rows), ("connected", 2));
    bench.assert_ledger();

    let mut bench = silent(slowed());
    bench.receive(&serial("7"));
    bench.receive(&sentence("VNRRG,07,40"));
    assert_eq!((bench.phase(), bench.down_cause()), ("backing off", "the sensor was silent, and may have restarted"));
    assert_eq!(bench.rows, 1);
    bench.assert_ledger();

    let mut bench = silent(LinkOptions::default());
    bench.receive(&serial("8"));
    bench.receive(&serial("8"));
    assert_eq!((bench.phase(), bench.rows), ("closed", 1));
    bench.assert_ledger();
}

#[test]
fn a_verification_does_not_wait_for_answers_to_what_a_silent_sensor_was_asked() {
    let mut bench = Bench::new(known_serial());
    bench.receive(FRAME);
    bench.receive(&serial("7"));
    // the read of a register and the question whether the sensor is there
    bench.wait(ms(3010));
    bench.take_sent();
    bench.receive(FRAME);
    assert_eq!(bench.take_sent(), [ASK_SERIAL]);
    bench.receive(&serial("7"));
    assert_eq!((bench.phase(), bench.take_sent()), ("connected", vec!["$VNRRG,07*74".to_owned()]));
    bench.assert_ledger();
}

#[test]
fn a_restart_of_the_sensor_begins_a_new_segment() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.wait(ms(10));
    bench.receive(&sentence("VNERR,0A"));
    assert_eq!((bench.phase(), bench.ups()), ("connected", 1));
    assert_eq!(bench.down_cause(), DeviceError::WatchdogReset.to_string());
    let restarted = |state: Option<&LinkState>| matches!(state, Some(LinkState::Up(up)) if up.restarted == Some(DeviceError::WatchdogReset) && up.since_ns == 10_000_000);
    assert!(restarted(bench.states.last()));
    bench.receive(FRAME);
    assert_eq!((bench.ups(), bench.counts.connects), (2, 2));
    bench.receive(FRAME);
    assert_eq!((bench.ups(), bench.rows), (2, 3));
    bench.assert_ledger();
    // where settings are lost with it, they are written again
    let mut bench = Bench::connected(slowed());
    bench.receive(&sentence("VNERR,01"));
    assert_eq!(bench.phase(), "backing off");
    bench.assert_ledger();
}

#[test]
fn a_garbled_stream_is_opened_again() {
    let mut bench = Bench::connected(LinkOptions::default());
    bench.stream(&"x".repeat(122), ms(25), 13);
    assert_eq!(bench.down_cause(), "1586 bytes came in 300 ms and no good line was among them");
    bench.assert_ledger();
}

#[test]
fn a_paused_output_is_resumed_and_paused_again_at_the_end() {
    for (reply, paused_again) in [("VNASY,0", true), ("VNERR,04", false), ("", false)] {
        let mut bench = Bench::new(LinkOptions::default());
        bench.wait(ms(150));
        bench.receive(&sentence("VNRRG,01,VN-100"));
        // it answers each question, and sends nothing
        while bench.sent.last().unwrap() != RESUME {
            assert!(bench.now < ms(10_000));
            let body = match bench.sent.last().unwrap().as_str() {
                ASK_MODEL => "VNRRG,01,VN-100".to_owned(),
                line => format!("{},1", &line[1..9]),
            };
            bench.receive(&sentence(&body));
            bench.wait(ms(200));
        }
        bench.receive(&sentence("VNASY,1"));
        bench.receive(FRAME);
        assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("verifying", ASK_SERIAL));
        bench.receive(&serial("1"));
        assert_eq!(bench.link.last(), Some(&LinkEventKind::OutputResumed));
        assert!(matches!(bench.states.last(), Some(LinkState::Up(up)) if up.output_resumed));
        bench.stop();
        assert_eq!((bench.phase(), bench.sent.last().unwrap().as_str()), ("restoring", PAUSE));
        bench.receive(FRAME);
        if reply.is_empty() {
            bench.input(Input::Lost(LinkError::Disconnected));
        } else {
            bench.receive(&sentence(reply));
        }
        assert_eq!(bench.states.last(), Some(&LinkState::Closed { paused_again: Some(paused_again) }));
        assert_eq!(bench.count(|kind| *kind == LinkEventKind::OutputPaused), usize::from(paused_again));
        assert_eq!(bench.error, None);
        bench.assert_ledger();
    }
}

#[test]
fn commands_of_the_user_are_sent_while_connected_and_end_with_the_link() {
    let mut bench = Bench::connected(LinkOptions::default());
    assert!(bench.machine.accepts_commands());
    bench.receive(&sentence("VNRRG,07,40"));
    bench.take_sent();
    bench.input(Input::Command { id: 5, command: SensorCommand::ReadRegister(Register::MODEL) });
    assert_eq!(bench.take_sent(), [ASK_MODEL]);
    bench.receive(&sentence("VNRRG,01,VN-100"));
    assert!(matches!(&bench.answers[..], [(5, Ok(Response::Register(_)))]));
    bench.input(Input::Command { id: 6, command: SensorCommand::ReadRegister(Register::MODEL) });
    bench.input(Input::Lost(LinkError::Disconnected));
    assert!(matches!(&bench.answers[1..], [(6, Err(CommandError::Failed(_)))]));
    assert!(bench.machine.accepts_commands(), "while it waits, too");
    bench.input(Input::Command { id: 7, command: SensorCommand::Tare });
    assert!(matches!(&bench.answers[2..], [(7, Err(CommandError::Failed(_)))]));
    bench.wait(ms(100));
    assert!(!bench.machine.accepts_commands(), "they wait while the sensor is searched");
    bench.assert_ledger();
}

#[test]
fn the_port_follows_the_sensor_to_another_baud_rate() {
    let mut bench = Bench::connected(LinkOptions { baud: Some(9600), ..LinkOptions::default() });
    bench.receive(&sentence("VNRRG,07,40"));
    let write = || SensorCommand::WriteRegister {
        register: Register::BAUD_RATE,
        fields: RegisterFields::new("19200").unwrap(),
    };
    bench.input(Input::Command { id: 1, command: write() });
    bench.receive(&sentence("VNWRG,05,19200"));
    assert_eq!(bench.port.last(), Some(&PortAction::SetBaud(19_200)));
    assert!(matches!(bench.states.last(), Some(LinkState::Up(up)) if up.baud == Some(19_200)));
    bench.input(Input::Lost(LinkError::Disconnected));
    bench.wait(ms(100));
    assert_eq!(bench.port.last(), Some(&PortAction::Open { baud: 19_200 }), "also at the next opening");
    // a server has a baud rate of its own
    let mut bench = Bench::of(false, LinkOptions::default());
    bench.receive(FRAME);
    bench.receive(&sentence("VNRRG,07,40"));
    bench.input(Input::Command { id: 1, command: write() });
    bench.receive(&sentence("VNWRG,05,19200"));
    assert_eq!((bench.answers.len(), bench.port.len()), (1, 1));
}

/// A link in each phase, with bytes pending where it has them.
fn phases() -> Vec<Bench> {
    let mut opening = Bench::new(known_serial());
    opening.machine.phase = Phase::Opening;
    let mut scanning = Bench::new(LinkOptions::default());
    scanning.receive("junk");
    let mut identifying = Bench::new(known_serial());
    identifying.receive(FRAME);
    let connected = Bench::connected(LinkOptions::default());
    let mut verifying = Bench::new(known_serial());
    verifying.receive(FRAME);
    verifying.receive(&serial("7"));
    verifying.wait(ms(3000));
    verifying.receive(FRAME);
    let mut restoring = reconnected();
    restoring.receive(&sentence("VNRRG,01,VN-100"));
    restoring.stop();
    restoring.receive(FRAME);
    let mut backing_off = Bench::connected(LinkOptions::default());
    backing_off.input(Input::Lost(LinkError::Disconnected));
    vec![opening, scanning, identifying, connected, verifying, restoring, backing_off]
}

#[test]
fn a_stop_ends_every_phase_and_a_lost_link_every_open_one() {
    let names = ["opening", "scanning", "identifying", "connected", "verifying", "restoring", "backing off"];
    let after_loss = ["opening", "closed", "closed", "backing off", "backing off", "closed", "backing off"];
    for (index, name) in names.into_iter().enumerate() {
        let mut stopped = phases().remove(index);
        assert_eq!(stopped.phase(), name);
        stopped.stop();
        let expected = if name == "restoring" { name } else { "closed" };
        assert_eq!((stopped.phase(), stopped.error.as_deref()), (expected, None));
        stopped.assert_ledger();

        let mut lost = phases().remove(index);
        lost.input(Input::Lost(io::Error::from(io::ErrorKind::BrokenPipe).into()));
        assert_eq!(lost.phase(), after_loss[index], "{name}");
        assert_eq!(lost.error.is_some(), matches!(name, "scanning" | "identifying"), "{name}");
        lost.assert_ledger();
    }
}

#[test]
fn what_was_read_and_not_reported_when_the_port_is_closed_is_counted() {
    for mut bench in phases() {
        bench.is_port_good = false;
        let before = bench.port.len();
        bench.stop();
        bench.wait(ms(5000));
        if bench.port.len() > before {
            assert_eq!((bench.phase(), bench.port.last()), ("closing", Some(&PortAction::Close)));
            let unread = vec![bench.chunk(b"not taken"), bench.chunk(FRAME.as_bytes())];
            bench.input(Input::PortClosed { unread });
        }
        bench.assert_ledger();
    }
}

#[test]
fn an_overrun_in_pending_inputs_is_kept() {
    let mut bench = Bench::new(LinkOptions::default());
    let overrun = LinkEvent { at_ns: 0, kind: LinkEventKind::Overrun { bytes: 9 } };
    bench.input(Input::Received(StreamInput::Link(overrun.clone())));
    bench.receive(&("junk".to_owned() + FRAME));
    bench.input(Input::Received(StreamInput::Link(overrun)));
    bench.assert_ledger();
    assert_eq!((bench.counts.overrun_bytes, bench.counts.baud_scan_bytes, bench.rows), (18, 4, 1));
}

/// Something that may happen.
#[derive(Debug, Clone)]
enum Happening {
    Receive(String),
    Wait(u64),
    Request,
    Lose,
}

fn happening() -> impl Strategy<Value = Happening> {
    const REPLIES: [&str; 11] = [
        "VNRRG,01,VN-100",
        "VNRRG,03,7",
        "VNRRG,03,8",
        "VNRRG,07,20",
        "VNRRG,07,40",
        "VNWRG,07,20",
        "VNASY,0",
        "VNASY,1",
        "VNERR,04",
        "VNERR,0A",
        "VNRRG,01",
    ];
    prop_oneof![
        6 => Just(Happening::Receive(FRAME.into())),
        4 => prop::sample::select(&REPLIES[..]).prop_map(|body| Happening::Receive(sentence(body))),
        3 => prop::sample::select(&["junk", "$VNYMR,-0", "$VNRRG,03,7*", "\u{7f}\u{7f}", "\r\n"][..]).prop_map(|text| Happening::Receive(text.into())),
        4 => prop::sample::select(&[1, 40, 300, 700, 3500][..]).prop_map(Happening::Wait),
        1 => Just(Happening::Request),
        1 => Just(Happening::Lose),
    ]
}

fn options(case: u8) -> LinkOptions {
    LinkOptions {
        listen_only: case & 1 != 0,
        known_serial: (case & 2 != 0).then(|| "7".into()),
        ..if case & 4 != 0 { slowed() } else { LinkOptions::default() }
    }
}

proptest! {
    #[test]
    fn every_byte_is_counted_and_recorded_and_every_request_answered(case in 0..8_u8, script in prop::collection::vec(happening(), 0..60)) {
        let mut bench = Bench::new(options(case));
        let mut requests = 0;
        for event in script {
            match event {
                Happening::Receive(text) if bench.machine.is_open() => bench.receive(&text),
                Happening::Receive(_) => {}
                Happening::Wait(time) => bench.wait(ms(time)),
                Happening::Request => {
                    requests += 1;
                    bench.input(Input::Command { id: requests, command: SensorCommand::ReadRegister(Register::MODEL) });
                }
                Happening::Lose => bench.input(Input::Lost(LinkError::Disconnected)),
            }
        }
        bench.assert_ledger();
        prop_assert_eq!(bench.answers.len() as u64, requests);
        prop_assert!(bench.sent.is_empty() || case & 1 == 0, "a link that only listens sends nothing");
    }

    #[test]
    fn how_bytes_are_cut_into_reads_changes_nothing(texts in prop::collection::vec(happening(), 1..20), cuts in prop::collection::vec(1..200_usize, 1..40)) {
        // a restart and another sensor are handled when the read that reports them is forwarded
        let is_of_read = |text: &str| text.starts_with("$VNERR,0A") || text.starts_with("$VNRRG,03,8");
        let texts: String = texts.into_iter().filter_map(|event| match event {
            Happening::Receive(text) if !is_of_read(&text) => Some(text),
            _ => None,
        }).collect();
        let run = |pieces: &mut dyn Iterator<Item = usize>| {
            let mut bench = Bench::new(LinkOptions::default());
            let mut rest = texts.as_bytes();
            while !rest.is_empty() && bench.machine.is_open() {
                let (piece, behind) = rest.split_at(pieces.next().unwrap_or(rest.len()).min(rest.len()));
                let chunk = bench.chunk(piece);
                bench.input(Input::Received(chunk));
                rest = behind;
            }
            bench.assert_ledger();
            (bench.counts.tally, bench.counts.baud_scan_bytes, bench.counts.connects, bench.rows)
        };
        prop_assert_eq!(run(&mut cuts.iter().copied()), run(&mut std::iter::empty()));
    }
}
