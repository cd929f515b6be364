//! Properties of the request machine under any interleaving, with a sensor whose link loses,
//! damages and delays lines.

use core::time::Duration;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

use proptest::{collection::vec, prelude::*, sample::select};
use vn100_protocol::{
    Check, DeviceError, Frame, Options, Register, RegisterFields, RequestFailure, RequestId, RequestQueue, Response,
    SensorCommand,
};

use crate::support::{frames, reply};

const PRESENT: Register = Register(7);
const OTHER: Register = Register(21);
const ABSENT: Register = Register(99);

fn command() -> impl Strategy<Value = SensorCommand> {
    let write = |register, value: u32| SensorCommand::WriteRegister {
        register,
        fields: RegisterFields::new(value.to_string()).unwrap(),
    };
    prop_oneof![
        4 => select(vec![PRESENT, OTHER, ABSENT]).prop_map(SensorCommand::ReadRegister),
        4 => (select(vec![PRESENT, OTHER, ABSENT]), 0_u32..4).prop_map(move |(register, value)| write(register, value)),
        2 => any::<bool>().prop_map(SensorCommand::Async),
        1 => select(vec![SensorCommand::Tare, SensorCommand::SetGyroBias, SensorCommand::WriteSettings, SensorCommand::Reset]),
    ]
}

/// The body of the command in a line, as a sensor reads it.
fn body(line: &[u8]) -> String {
    match frames(line, Options::default())[..] {
        [Frame::Sentence(sentence)] => String::from_utf8(sentence.body.to_vec()).unwrap(),
        ref other => panic!("{other:?}"),
    }
}

fn is_repeatable(body: &str) -> bool {
    ["VNRRG", "VNWRG", "VNASY"].contains(&&body[..5])
}

#[derive(Debug, Clone)]
enum Event {
    Submit(SensorCommand),
    Transmit,
    Timeout,
    Reply(String),
    LinkDown,
    Collect,
    Wait(u64),
}

fn event() -> impl Strategy<Value = Event> {
    let bodies = [
        "VNRRG,07,1",
        "VNRRG,21,1",
        "VNRRG,99,1",
        "VNWRG,07,1",
        "VNWRG,07,2",
        "VNWRG,21,0",
        "VNASY,0",
        "VNASY,1",
        "VNTAR",
        "VNSGB",
        "VNWNV",
        "VNRST",
        "VNERR,01",
        "VNERR,02",
        "VNERR,03",
        "VNERR,08",
        "VNERR,0A",
        "VNERR,0C",
        "VNERR,12",
    ];
    prop_oneof![
        4 => command().prop_map(Event::Submit),
        6 => Just(Event::Transmit),
        3 => Just(Event::Timeout),
        6 => select(bodies.to_vec()).prop_map(|body| Event::Reply(body.into())),
        1 => Just(Event::LinkDown),
        2 => Just(Event::Collect),
        4 => (0_u64..700).prop_map(Event::Wait),
    ]
}

/// A sensor with two registers and a faulty link; it answers in order.
struct Sensor {
    registers: BTreeMap<Register, String>,
    heard: Vec<String>,
    /// The answers in transit, with the time of their arrival.
    answers: VecDeque<(Duration, String)>,
}

/// The fate of one command and its answer.
#[derive(Debug, Clone, Copy)]
enum Fate {
    Lost,
    Damaged,
    AnswerLost,
    Answered(u64),
}

fn fate() -> impl Strategy<Value = Fate> {
    // no answer takes longer than a session waits for it; otherwise only the next register could tell them
    // apart
    prop_oneof![
        1 => Just(Fate::Lost),
        1 => Just(Fate::Damaged),
        1 => Just(Fate::AnswerLost),
        5 => (0_u64..480).prop_map(Fate::Answered),
    ]
}

impl Sensor {
    fn new() -> Self {
        let registers = [(PRESENT, "1".to_owned()), (OTHER, "2".to_owned())].into();
        Self { registers, heard: Vec::new(), answers: VecDeque::new() }
    }

    fn receive(&mut self, line: &[u8], fate: Fate, now: Duration) {
        let (delay, answer) = match fate {
            Fate::Lost => return,
            Fate::Damaged => (5, "VNERR,03".to_owned()),
            Fate::AnswerLost => {
                self.carry_out(body(line));
                return;
            }
            Fate::Answered(delay) => (delay, self.carry_out(body(line))),
        };
        let earliest = self.answers.back().map_or(now, |(at, _)| *at);
        self.answers.push_back((earliest.max(now + Duration::from_millis(delay)), answer));
    }

    fn carry_out(&mut self, body: String) -> String {
        self.heard.push(body.clone());
        let mut fields = body.splitn(3, ',').skip(1);
        let register = fields.next().and_then(|number| number.parse().ok()).map(Register);
        match (&body[..5], register) {
            ("VNRRG" | "VNWRG", Some(register)) if !self.registers.contains_key(&register) => "VNERR,08".into(),
            ("VNRRG", Some(register)) => format!("VNRRG,{register},{}", self.registers[&register]),
            ("VNWRG", Some(register)) => {
                self.registers.insert(register, fields.next().unwrap().into());
                body
            }
            _ => body,
        }
    }
}

proptest! {
    #[test]
    fn every_request_ends_once_and_nothing_else_does(events in vec(event(), 0..120)) {
        let mut session = RequestQueue::new(Check::Crc16);
        let mut now = Duration::ZERO;
        let mut open = BTreeSet::new();
        let mut asked_once: BTreeMap<String, i32> = BTreeMap::new();
        let collect = |session: &mut RequestQueue, open: &mut BTreeSet<RequestId>| {
            while let Some((id, _)) = session.poll_completion() {
                assert!(open.remove(&id), "{id:?} ended twice, or was never asked");
            }
        };
        for event in events {
            match event {
                Event::Submit(command) => {
                    let line = command.sentence(Check::Crc16);
                    if let Ok(id) = session.submit(command) {
                        prop_assert!(open.insert(id));
                        *asked_once.entry(body(line.as_bytes())).or_default() += 1;
                    }
                }
                Event::Transmit => while let Some(line) = session.poll_transmit(now) {
                    let body = body(&line);
                    if !is_repeatable(&body) {
                        let left = asked_once.get_mut(&body).unwrap();
                        *left -= 1;
                        prop_assert!(*left >= 0, "{} was sent more often than asked", body);
                    }
                },
                Event::Timeout => session.handle_timeout(now),
                Event::Reply(body) => _ = session.handle_reply(&reply(&body), now),
                Event::LinkDown => session.handle_link_down(),
                Event::Collect => collect(&mut session, &mut open),
                Event::Wait(ms) => now += Duration::from_millis(ms),
            }
        }
        // without further input it ends by itself
        for _ in 0..10_000 {
            while session.poll_transmit(now).is_some() {}
            collect(&mut session, &mut open);
            let Some(at) = session.poll_timeout() else { break };
            now = now.max(at);
            session.handle_timeout(now);
        }
        prop_assert!(open.is_empty());
        prop_assert_eq!((session.poll_timeout(), session.poll_transmit(now)), (None, None));
    }

    #[test]
    fn answers_belong_to_their_requests_over_a_bad_link(
        commands in vec(command(), 1..30), fates in vec(fate(), 1..90),
    ) {
        let mut session = RequestQueue::new(Check::Xor8);
        let mut sensor = Sensor::new();
        let mut now = Duration::ZERO;
        let asked: BTreeMap<_, _> = commands.into_iter().map(|command| (session.submit(command.clone()).unwrap(), command)).collect();
        let mut fates = fates.into_iter().cycle();
        let mut ended = BTreeMap::new();
        loop {
            while let Some((id, result)) = session.poll_completion() {
                prop_assert!(ended.insert(id, result.clone()).is_none());
                match (&asked[&id], result) {
                    (SensorCommand::ReadRegister(ABSENT) | SensorCommand::WriteRegister { register: ABSENT, .. }, Ok(answer)) => {
                        prop_assert!(false, "{answer:?} of a register that is not there")
                    }
                    (SensorCommand::ReadRegister(register), Ok(Response::Register(contents))) => {
                        prop_assert_eq!(contents.register, *register);
                        prop_assert_eq!(contents.fields.as_str(), &sensor.registers[register]);
                    }
                    (SensorCommand::WriteRegister { register, fields }, Ok(_)) => {
                        prop_assert_eq!(fields.as_str(), &sensor.registers[register]);
                    }
                    (
                        SensorCommand::ReadRegister(ABSENT) | SensorCommand::WriteRegister { register: ABSENT, .. },
                        Err(RequestFailure::Device { error: DeviceError::InvalidRegister, .. }),
                    )
                    | (_, Err(RequestFailure::Timeout { .. }))
                    | (_, Err(RequestFailure::Device { error: DeviceError::InvalidChecksum, .. }))
                    | (_, Ok(Response::Done)) => {}
                    (command, result) => prop_assert!(false, "{:?}: {:?}", command, result),
                }
            }
            // the answers are compared before the next command changes them
            while let Some(line) = session.poll_transmit(now) {
                sensor.receive(&line, fates.next().unwrap(), now);
            }
            let arrival = sensor.answers.front().map(|(at, _)| *at);
            let Some(next) = arrival.into_iter().chain(session.poll_timeout()).min() else { break };
            now = now.max(next);
            if arrival == Some(next) && let Some((_, body)) = sensor.answers.pop_front() {
                session.handle_reply(&reply(&body), now);
            } else {
                session.handle_timeout(now);
            }
        }
        prop_assert_eq!(ended.len(), asked.len());
        prop_assert_eq!(session.poll_notice(), None);
        for once in ["VNTAR", "VNSGB", "VNWNV", "VNRST"] {
            let count = |bodies: &mut dyn Iterator<Item = String>| bodies.filter(|body| body == once).count();
            let of_command = |command: &SensorCommand| {
                let line = command.sentence(Check::Xor8);
                body(line.as_bytes())
            };
            prop_assert!(count(&mut sensor.heard.iter().cloned()) <= count(&mut asked.values().map(of_command)));
        }
    }
}
