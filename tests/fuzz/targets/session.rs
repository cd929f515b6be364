//! A script of requests, replies of any text, and times: each request ends once, and without
//! further input the session comes to rest.

use std::{collections::BTreeMap, time::Duration};

use vn100_protocol::{
    Check, Decoder, Item, Options, Register, RegisterFields, Reply, RequestId, RequestQueue, SensorCommand, xor8,
};

/// A request that the session has accepted.
struct Asked {
    is_repeatable: bool,
    has_ended: bool,
}

/// A session, and the facts that are needed to check it.
struct Conversation {
    session: RequestQueue,
    now: Duration,
    asked: BTreeMap<RequestId, Asked>,
    /// Sent lines that may be sent only once.
    sent_once: usize,
}

/// Each byte of the script is one step; some steps use the bytes after them.
pub(crate) fn check(script: &[u8]) {
    let mut conversation = Conversation {
        session: RequestQueue::new(Check::Xor8),
        now: Duration::ZERO,
        asked: BTreeMap::new(),
        sent_once: 0,
    };
    let mut rest = script;
    while let Some((&step, behind)) = rest.split_first() {
        rest = conversation.step(step, behind);
    }
    conversation.come_to_rest();
}

impl Conversation {
    /// Executes one step, and returns the rest of the script.
    fn step<'a>(&mut self, step: u8, behind: &'a [u8]) -> &'a [u8] {
        let argument = behind.first().copied().unwrap_or_default();
        let behind_argument = behind.get(1..).unwrap_or_default();
        match step % 10 {
            0..2 => {
                self.submit(command(argument));
                return behind_argument;
            }
            2 | 3 => self.transmit(),
            4 => self.session.handle_timeout(self.now),
            5 => {
                self.now = self.now.saturating_add(Duration::from_millis(u64::from(argument) * 10));
                return behind_argument;
            }
            6 => {
                // up to the end of the clock
                self.now = self.now.saturating_add(Duration::from_secs(u64::MAX >> (argument % 64)));
                return behind_argument;
            }
            7 => self.session.handle_link_down(),
            8 => self.collect(),
            _ => {
                let end = behind.iter().position(|&byte| byte == b'\n').unwrap_or(behind.len());
                self.hear(&behind[..end]);
                return behind.get(end + 1..).unwrap_or_default();
            }
        }
        behind
    }

    fn submit(&mut self, command: SensorCommand) {
        let is_repeatable = command.is_repeatable();
        let waiting = self.asked.values().filter(|asked| !asked.has_ended).count();
        match self.session.submit(command) {
            Ok(id) => {
                assert!(waiting < RequestQueue::CAPACITY);
                assert!(self.asked.insert(id, Asked { is_repeatable, has_ended: false }).is_none());
            }
            Err(_) => assert_eq!(waiting, RequestQueue::CAPACITY),
        }
    }

    fn transmit(&mut self) {
        while let Some(line) = self.session.poll_transmit(self.now) {
            assert!(line.ends_with(b"\r\n") && line.len() <= 256, "{}", line.escape_ascii());
            self.sent_once += usize::from(!matches!(&line[1..6], b"VNRRG" | b"VNWRG" | b"VNASY"));
            let may_be_sent = self.asked.values().filter(|asked| !asked.is_repeatable).count();
            assert!(self.sent_once <= may_be_sent, "{} is sent again", line.escape_ascii());
        }
    }

    /// A line arrives, with a correct checksum.
    fn hear(&mut self, body: &[u8]) {
        let line = [b"$", body, format!("*{:02X}\r\n", xor8(body)).as_bytes()].concat();
        let mut decoder = Decoder::new(Options::default());
        decoder.push(&line, |item| {
            if let Item::Reply(sentence) = item
                && let Some(reply) = Reply::parse(&sentence)
            {
                self.session.handle_reply(&reply, self.now);
            }
        });
    }

    fn collect(&mut self) {
        while let Some((id, result)) = self.session.poll_completion() {
            let asked = self.asked.get_mut(&id).unwrap();
            assert!(!asked.has_ended, "{id:?} ended twice");
            asked.has_ended = true;
            _ = result.map_err(|failure| failure.to_string());
        }
        let notices = std::iter::from_fn(|| self.session.poll_notice()).count();
        assert!(notices <= RequestQueue::NOTICES);
    }

    fn come_to_rest(&mut self) {
        // three attempts of each request that may wait, with a wait after each
        for _ in 0..4 * RequestQueue::CAPACITY * RequestQueue::ATTEMPTS as usize {
            self.transmit();
            self.collect();
            let Some(at) = self.session.poll_timeout() else { break };
            self.now = self.now.max(at);
            self.session.handle_timeout(self.now);
        }
        assert!(self.asked.values().all(|asked| asked.has_ended));
        assert_eq!((self.session.poll_timeout(), self.session.poll_transmit(self.now)), (None, None));
    }
}

fn command(choice: u8) -> SensorCommand {
    let register = Register(choice >> 3);
    match choice & 7 {
        0 | 1 => SensorCommand::ReadRegister(register),
        2 | 3 => SensorCommand::WriteRegister {
            register,
            fields: RegisterFields::new("1".repeat(usize::from(choice >> 4))).unwrap(),
        },
        4 => SensorCommand::Async(choice & 8 == 0),
        5 => [SensorCommand::WriteSettings, SensorCommand::Reset][usize::from(choice >> 3 & 1)].clone(),
        6 => [SensorCommand::RestoreFactorySettings, SensorCommand::Tare][usize::from(choice >> 3 & 1)].clone(),
        _ => SensorCommand::SetGyroBias,
    }
}
