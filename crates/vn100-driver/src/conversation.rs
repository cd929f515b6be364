//! What is said to the sensor over a link: the callers' requests, and what the link itself wants to know.

use std::{collections::VecDeque, time::Duration};

use tokio::sync::oneshot;

use crate::{
    command::{Answer, Command, CommandError, device_error},
    exchange::{Exchange, error_code},
};

/// What a measurement is to be read with: the sensor, its output, its calibration, its filters.
const IDENTITY: [u8; 24] = [1, 2, 3, 4, 5, 6, 7, 21, 23, 25, 26, 30, 32, 35, 43, 44, 47, 75, 76, 77, 82, 83, 84, 85];

/// The register with the uncompensated measurements and the temperature.
const IMU_MEASUREMENTS: u8 = 54;

/// Bytes that a reading of it takes from the line.
const READING_BYTES: f64 = 128.0;

const MODEL: u8 = 1;
const BAUD_RATE: u8 = 5;

/// From one question of the link's own to the next. On a line that is nearly full, as with `$VNIMU` at 100 Hz and 115 200 baud, an answer
/// puts all lines behind it off until the idle time of the line has made up for it; answers without a pause would add up to what looks
/// like lost lines.
const READ_EVERY: Duration = Duration::from_millis(200);

/// A command with whom to answer.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) command: Command,
    /// `None` where nobody waits for it.
    pub(crate) answer: Option<oneshot::Sender<Result<Answer, CommandError>>>,
}

/// Who asked for a command.
#[derive(Debug)]
enum Asker {
    Caller(Option<oneshot::Sender<Result<Answer, CommandError>>>),
    /// The link, to know the sensor. What it answers is in the stream.
    Identity,
    /// The link, to know whether the sensor is there.
    Presence,
}

pub(crate) struct Conversation {
    listen_only: bool,
    exchange: Exchange<Asker>,
    /// Registers to read when nothing else is asked for.
    to_read: VecDeque<u8>,
    /// Not before this time.
    read_at: Duration,
    /// Whether a caller has paused the output, and wants it so.
    paused: bool,
    temperature: Option<TemperaturePoll>,
}

#[derive(Debug)]
struct TemperaturePoll {
    every: Duration,
    last: Duration,
    /// Bytes that came since then.
    bytes: u64,
}

/// What follows from an answer for the link.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Consequence {
    /// The sensor talks at another speed from now on.
    Baud(u32),
    /// The sensor was asked whether it is there, and did not answer.
    Absent,
    /// The sensor has restarted by itself: why.
    Restarted(String),
}

impl Conversation {
    pub(crate) fn new(listen_only: bool, poll_temperature: Option<Duration>) -> Self {
        let temperature = poll_temperature.map(|every| TemperaturePoll { every, last: Duration::ZERO, bytes: 0 });
        Self {
            listen_only,
            exchange: Exchange::new(),
            to_read: VecDeque::new(),
            read_at: Duration::ZERO,
            paused: false,
            temperature,
        }
    }

    /// A sensor is heard, perhaps another one, perhaps after a restart: asks for all that identifies it.
    pub(crate) fn meet(&mut self, now: Duration) {
        if self.listen_only {
            return;
        }
        self.to_read = IDENTITY.into();
        if let Some(poll) = &mut self.temperature {
            (poll.last, poll.bytes) = (now, 0);
        }
    }

    /// Takes a caller's request.
    pub(crate) fn ask(&mut self, request: Request) {
        if self.listen_only {
            answer(request.answer, Err(CommandError::ListenOnly));
        } else {
            self.exchange.submit(request.command, Asker::Caller(request.answer));
        }
    }

    /// Asks a sensor that says nothing whether it is there: unless it is silent on request, with the command that makes it speak again if an
    /// exchange was broken off while its output was paused.
    pub(crate) fn ask_presence(&mut self) {
        let question = if self.paused { Command::ReadRegister(MODEL) } else { Command::Output(true) };
        self.exchange.submit(question, Asker::Presence);
    }

    /// What is to be sent now, on a line of this speed.
    pub(crate) fn next_line(&mut self, now: Duration, baud: Option<u32>) -> Option<String> {
        if self.temperature.as_mut().is_some_and(|poll| poll.is_due(now, baud)) && !self.listen_only {
            self.to_read.push_back(IMU_MEASUREMENTS);
        }
        if self.exchange.is_idle()
            && now >= self.read_at
            && let Some(register) = self.to_read.pop_front()
        {
            self.read_at = now + READ_EVERY;
            self.exchange.submit(Command::ReadRegister(register), Asker::Identity);
        }
        self.exchange.poll_transmit(now)
    }

    /// When something is due without an answer.
    pub(crate) fn wake_at(&self) -> Option<Duration> {
        let poll = self.temperature.as_ref().filter(|_| !self.listen_only).map(|poll| poll.last + poll.every);
        let read = (self.exchange.is_idle() && !self.to_read.is_empty()).then_some(self.read_at);
        [self.exchange.poll_timeout(), poll, read].into_iter().flatten().min()
    }

    /// Takes the number of bytes that a read brought.
    pub(crate) fn read(&mut self, bytes: usize) {
        if let Some(poll) = &mut self.temperature {
            poll.bytes += bytes as u64;
        }
    }

    /// Takes the body of an answer, or of an error that the sensor told unasked.
    pub(crate) fn take_reply(&mut self, body: &str) -> Option<Consequence> {
        if let Some(code @ (0x01 | 0x0A)) = error_code(body) {
            return Some(Consequence::Restarted(device_error(code)));
        }
        self.exchange.take_answer(body);
        self.settle()
    }

    /// Takes the time.
    pub(crate) fn handle_timeout(&mut self, now: Duration) -> Option<Consequence> {
        self.exchange.handle_timeout(now);
        self.settle()
    }

    /// The link is down.
    pub(crate) fn link_down(&mut self) {
        self.to_read.clear();
        // whoever paused it is told that the link is down; the next session begins with the output on
        self.paused = false;
        self.exchange.handle_link_down();
        // nothing follows for a link that is no more
        while self.settle().is_some() {}
    }

    /// Answers those who wait. One command is under way at a time, so that there is one consequence at most.
    fn settle(&mut self) -> Option<Consequence> {
        let mut consequence = None;
        while let Some((asker, command, result)) = self.exchange.poll_done() {
            match (&command, &result) {
                (Command::WriteRegister { register: BAUD_RATE, .. }, Ok(written)) => {
                    consequence = written.fields.parse().ok().map(Consequence::Baud);
                }
                (Command::Output(on), Ok(_)) => self.paused = !on,
                _ => {}
            }
            let silent = matches!(result, Err(CommandError::NoAnswer { .. }));
            match asker {
                Asker::Caller(waiting) => answer(waiting, result),
                // a sensor that does not answer, as on a one-way cable, is not asked for the rest; one without a register is
                Asker::Identity if silent => self.to_read.clear(),
                Asker::Presence if silent => consequence = Some(Consequence::Absent),
                Asker::Identity | Asker::Presence => {}
            }
        }
        consequence
    }
}

impl TemperaturePoll {
    /// Whether a reading is due and fits between the lines.
    fn is_due(&mut self, now: Duration, baud: Option<u32>) -> bool {
        let passed = now.saturating_sub(self.last);
        if passed < self.every {
            return false;
        }
        let bytes_per_s = self.bytes as f64 / passed.as_secs_f64();
        (self.last, self.bytes) = (now, 0);
        // ten bits a byte; the reading must be through within a second
        baud.is_none_or(|baud| bytes_per_s + READING_BYTES <= f64::from(baud) / 10.0)
    }
}

fn answer(waiting: Option<oneshot::Sender<Result<Answer, CommandError>>>, result: Result<Answer, CommandError>) {
    if let Some(waiting) = waiting {
        // whoever asked may have stopped waiting
        let _ = waiting.send(result);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(s: u64) -> Duration {
        Duration::from_secs(s)
    }

    #[test]
    fn the_temperature_is_read_where_the_line_has_room() {
        // 94 lines of 122 bytes fill a line of 115 200 baud but for 52 bytes a second
        for (lines_per_s, baud, read) in [(40, Some(115_200), true), (94, Some(115_200), false), (94, None, true)] {
            let mut conversation = Conversation::new(false, Some(s(10)));
            assert_eq!(conversation.wake_at(), Some(s(10)));
            conversation.read(10 * lines_per_s * 122);
            assert_eq!(conversation.next_line(s(9), baud), None);
            assert_eq!(conversation.next_line(s(10), baud).as_deref(), read.then_some("$VNRRG,54*72\r\n"));
            assert_eq!(conversation.next_line(s(11), baud), None);
        }
    }

    #[test]
    fn a_caller_does_not_wait_for_the_whole_identification() {
        let mut conversation = Conversation::new(false, None);
        conversation.meet(s(0));
        assert_eq!(conversation.next_line(s(0), None).as_deref(), Some("$VNRRG,01*72\r\n"));
        let (sender, mut answered) = oneshot::channel();
        conversation.ask(Request { command: Command::ReadRegister(54), answer: Some(sender) });
        assert_eq!(conversation.take_reply("VNRRG,01,VN-100S-CR"), None);
        assert_eq!(conversation.next_line(s(0), None).as_deref(), Some("$VNRRG,54*72\r\n"));
        conversation.take_reply("VNRRG,54,+21.6");
        assert_eq!(answered.try_recv().unwrap().unwrap().fields, "+21.6");
        // and its next question waits until the line has made up for the answer
        assert_eq!(conversation.next_line(READ_EVERY - Duration::from_millis(1), None), None);
        assert_eq!(conversation.wake_at(), Some(READ_EVERY));
        assert_eq!(conversation.next_line(READ_EVERY, None).as_deref(), Some("$VNRRG,02*71\r\n"));
    }

    #[test]
    fn a_missing_register_is_passed_over_and_a_dumb_sensor_is_left_alone() {
        let mut conversation = Conversation::new(false, None);
        conversation.meet(s(0));
        conversation.next_line(s(0), None);
        conversation.take_reply("VNERR,08");
        assert!(conversation.next_line(READ_EVERY, None).is_some());
        let mut now = s(0);
        let mut lines = 0;
        while let Some(wake) = conversation.wake_at() {
            now = wake;
            conversation.handle_timeout(now);
            lines += u32::from(conversation.next_line(now, None).is_some());
        }
        assert_eq!((lines, now), (2, READ_EVERY + Duration::from_millis(1500)), "two more attempts of one read");
    }
}
