//! What is said to the sensor over a link: the callers' requests, and what the link itself wants to
//! know.

#[cfg(test)]
mod junk_tests;
mod temperature;

use std::{
    collections::{BTreeMap, VecDeque},
    time::Duration,
};

use tokio::sync::oneshot;
use vn100_protocol::{
    Answer, BaudRate, Check, Command, DeviceError, Handled, Register, Reply, RequestFailure, RequestId, Session,
};

use self::temperature::TemperaturePoll;
use crate::{autobaud::BAUD_RATES, command_error::CommandError};

/// What a measurement is to be read with: the output, then the filters, the sensor and its
/// calibration. First comes what the first numbers rest on, as all of them take five seconds;
/// before all but one, by what a sensor that is lost early is known again.
const IDENTITY: [Register; 24] = [
    Register::ASYNC_RATE,
    Register::SERIAL_NUMBER,
    Register::IMU_FILTER,
    Register::ASYNC_TYPE,
    Register::PROTOCOL_CONTROL,
    Register::SYNC_CONTROL,
    Register::MODEL,
    Register::FIRMWARE,
    Register::HARDWARE_REVISION,
    Register::BAUD_RATE,
    Register::BINARY_OUTPUT_1,
    Register::BINARY_OUTPUT_2,
    Register::BINARY_OUTPUT_3,
    Register::VPE_CONTROL,
    Register::STARTUP_GYRO_BIAS,
    Register::GYRO_CALIBRATION,
    Register::ACCEL_CALIBRATION,
    Register::MAG_CALIBRATION,
    Register::ROTATION,
    Register::REFERENCE_VECTORS,
    Register::HSI_CONTROL,
    Register::HSI_RESULT,
    Register::DELTA_SETTINGS,
    Register::REFERENCE_MODEL,
];

/// From one question of the link's own to the next. On a line that is nearly full, as with `$VNIMU`
/// at 100 Hz and 115 200 baud, an answer puts all lines behind it off until the idle time of the
/// line has made up for it; answers without a pause would add up to what looks like lost lines.
const READ_EVERY: Duration = Duration::from_millis(200);

/// A sensor that runs and is to send has sent a line by then: the slowest output sends each second,
/// and a restart takes 1.25 s.
const SURELY_PAUSED: Duration = Duration::from_secs(3);

/// Where an answer goes.
pub(crate) type Waiting = oneshot::Sender<Result<Answer, CommandError>>;

/// A command with whom to answer.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) command: Command,
    /// `None` where nobody waits for it.
    pub(crate) answer: Option<Waiting>,
}

/// Who asked for a command.
#[derive(Debug)]
enum Asker {
    Caller(Option<Waiting>),
    /// The link, to know the sensor. What it answers is in the stream.
    Identity,
    /// The link, to know whether the sensor is there.
    Presence,
}

pub(crate) struct Conversation {
    listen_only: bool,
    session: Session,
    /// What the session has not ended yet.
    asked: BTreeMap<RequestId, (Command, Asker)>,
    /// Registers to read when nothing else is asked for.
    to_read: VecDeque<Register>,
    /// Not before this time.
    read_at: Duration,
    /// Whether a caller has paused the output, and wants it so.
    paused: bool,
    /// When the sensor last answered.
    answered_at: Option<Duration>,
    output: FoundOutput,
    /// How many refusals may still answer junk.
    junk_answers: usize,
    temperature: Option<TemperaturePoll>,
}

/// How the output of the sensor was found, as far as anything was done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FoundOutput {
    /// Nothing was done.
    Untouched,
    /// A silent sensor was told to send; whether it was for want of that, the next lines tell.
    ToldToSend,
    /// It was paused, by somebody else, and sends because it was told to.
    Resumed,
}

/// What follows from an answer for the link.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Consequence {
    /// The sensor talks at another speed from now on.
    Baud(BaudRate),
    /// The sensor was asked whether it is there, and did not answer.
    Absent,
    /// The sensor has restarted by itself: why.
    Restarted(DeviceError),
    /// The sensor refused what nobody here asked for. Errors that only ever come unasked are known
    /// as such in the stream itself.
    Unasked(DeviceError),
}

impl Conversation {
    pub(crate) fn new(listen_only: bool, poll_temperature: Option<Duration>) -> Self {
        Self {
            listen_only,
            session: Session::new(Check::Xor8),
            asked: BTreeMap::new(),
            to_read: VecDeque::new(),
            read_at: Duration::ZERO,
            paused: false,
            answered_at: None,
            output: FoundOutput::Untouched,
            junk_answers: 0,
            temperature: poll_temperature.map(TemperaturePoll::new),
        }
    }

    /// A sensor is heard, perhaps another one, perhaps after a restart: asks for all that
    /// identifies it.
    pub(crate) fn meet(&mut self, now: Duration) {
        if self.listen_only {
            return;
        }
        self.to_read = IDENTITY.into();
        // a question that was lost with what the sensor was before says nothing of what it answers now
        self.asked.retain(|_, (_, asker)| !matches!(asker, Asker::Identity));
        if let Some(poll) = &mut self.temperature {
            poll.begin(now);
        }
    }

    /// The sensor was asked while its speed was looked for: at all speeds but its own that was junk
    /// to it. Until the first good answer it may refuse that, once for each speed and for each
    /// question more, or what it took with the rest of it.
    pub(crate) fn expect_junk_answers(&mut self) {
        self.junk_answers = (self.junk_answers + 1).max(BAUD_RATES.len());
    }

    /// Reads a register before all others that the link wants to know.
    pub(crate) fn read_next(&mut self, register: Register) {
        self.to_read.push_front(register);
    }

    /// Takes a caller's request.
    pub(crate) fn ask(&mut self, request: Request) {
        if self.listen_only {
            answer(request.answer, Err(CommandError::ListenOnly));
        } else {
            self.submit(request.command, Asker::Caller(request.answer));
        }
    }

    /// Asks a sensor that says nothing since `silent_since` whether it is there. One that has
    /// answered since then, and yet sends nothing, is asked by the command that makes it send,
    /// unless it is silent on request: its output may have been paused by a program that broke off.
    pub(crate) fn ask_presence(&mut self, silent_since: Duration, now: Duration) {
        let runs = self.answered_at.is_some_and(|at| at > silent_since);
        let may_be_paused = !self.paused && runs && now >= silent_since + SURELY_PAUSED;
        if self.output == FoundOutput::ToldToSend {
            self.output = FoundOutput::Untouched;
        }
        let question = if may_be_paused { Command::Async(true) } else { Command::ReadRegister(Register::MODEL) };
        self.submit(question, Asker::Presence);
    }

    /// The sensor sends by itself: whether it does so because its output was paused and was resumed
    /// from here, the first time.
    pub(crate) fn sends(&mut self) -> bool {
        let is_resumed = self.output == FoundOutput::ToldToSend;
        if is_resumed {
            self.output = FoundOutput::Resumed;
        }
        is_resumed
    }

    /// Whether the output was found paused, and is on because of that alone: it is to be paused
    /// again.
    pub(crate) fn owes_pause(&self) -> bool {
        self.output == FoundOutput::Resumed && !self.paused
    }

    /// What is to be sent now, on a line of this speed.
    pub(crate) fn next_line(&mut self, now: Duration, baud: Option<u32>) -> Option<Vec<u8>> {
        if self.temperature.as_mut().is_some_and(|poll| poll.is_due(now, baud)) && !self.listen_only {
            self.to_read.push_back(Register::IMU);
        }
        if self.asked.is_empty()
            && now >= self.read_at
            && let Some(register) = self.to_read.pop_front()
        {
            self.read_at = now + READ_EVERY;
            self.submit(Command::ReadRegister(register), Asker::Identity);
        }
        self.session.poll_transmit(now)
    }

    /// When something is due without an answer.
    pub(crate) fn wake_at(&self) -> Option<Duration> {
        let poll = self.temperature.as_ref().filter(|_| !self.listen_only).map(TemperaturePoll::due_at);
        let read = (self.asked.is_empty() && !self.to_read.is_empty()).then_some(self.read_at);
        [self.session.poll_timeout(), poll, read].into_iter().flatten().min()
    }

    /// Takes the number of bytes that a read brought.
    pub(crate) fn read(&mut self, bytes: usize) {
        if let Some(poll) = &mut self.temperature {
            poll.read(bytes);
        }
    }

    /// Takes an answer, or an error that the sensor told unasked.
    pub(crate) fn take_reply(&mut self, reply: &Reply, now: Duration) -> Vec<Consequence> {
        if self.session.handle_reply(reply, now) == Handled::Mine {
            self.answered_at = Some(now);
        }
        let mut consequences = Vec::new();
        while let Some(error) = self.session.poll_notice() {
            match error {
                DeviceError::HardFault | DeviceError::WatchdogReset => {
                    // a sensor that restarts sends again, by itself
                    self.paused = false;
                    self.output = FoundOutput::Untouched;
                    consequences.push(Consequence::Restarted(error));
                }
                _ if error.is_unsolicited() => {}
                _ if self.junk_answers > 0 => self.junk_answers -= 1,
                _ => consequences.push(Consequence::Unasked(error)),
            }
        }
        consequences.extend(self.settle());
        consequences
    }

    /// Takes the time.
    pub(crate) fn handle_timeout(&mut self, now: Duration) -> Option<Consequence> {
        self.session.handle_timeout(now);
        self.settle()
    }

    /// The link is down.
    pub(crate) fn link_down(&mut self) {
        self.to_read.clear();
        // whoever paused it is told that the link is down; the next session begins with the output on
        self.paused = false;
        self.session.handle_link_down();
        // nothing follows for a link that is no more
        while self.settle().is_some() {}
    }

    fn submit(&mut self, command: Command, asker: Asker) {
        match (self.session.submit(command.clone()), asker) {
            (Ok(id), asker) => _ = self.asked.insert(id, (command, asker)),
            (Err(full), Asker::Caller(waiting)) => answer(waiting, Err(full.into())),
            // the answers to all that waits tell as much
            (Err(_), Asker::Identity | Asker::Presence) => {}
        }
    }

    /// Answers those who wait. One command is under way at a time, so that there is one consequence
    /// at most.
    fn settle(&mut self) -> Option<Consequence> {
        let mut consequence = None;
        while let Some((id, result)) = self.session.poll_completion() {
            let Some((command, asker)) = self.asked.remove(&id) else { continue };
            match (&command, &result) {
                (Command::WriteRegister { register: Register::BAUD_RATE, fields }, Ok(Answer::Register(written)))
                    // behind a comma stands a port, which may be the other one
                    if fields.iter().count() == 1 =>
                {
                    consequence = written.value().ok().map(Consequence::Baud);
                }
                (Command::Async(on), Ok(_)) => {
                    self.paused = !on;
                    self.output = match asker {
                        Asker::Presence => FoundOutput::ToldToSend,
                        // whoever asks for the output has it
                        _ => FoundOutput::Untouched,
                    };
                }
                _ => {}
            }
            let is_refused = matches!(result, Err(RequestFailure::Device { .. }));
            if is_refused && self.junk_answers > 0 && matches!(command, Command::ReadRegister(_)) {
                self.junk_answers -= 1;
                self.submit(command, asker);
                continue;
            }
            if result.is_ok() {
                self.junk_answers = 0;
            }
            let silent = matches!(result, Err(RequestFailure::Timeout { .. }));
            match asker {
                Asker::Caller(waiting) => answer(waiting, result.map_err(CommandError::from)),
                // a sensor that does not answer, as on a one-way cable, is not asked for the rest; one without a register is
                Asker::Identity if silent => self.to_read.clear(),
                Asker::Presence if silent => consequence = Some(Consequence::Absent),
                Asker::Identity | Asker::Presence => {}
            }
        }
        consequence
    }
}

fn answer(waiting: Option<Waiting>, result: Result<Answer, CommandError>) {
    if let Some(waiting) = waiting {
        // whoever asked may have stopped waiting
        let _ = waiting.send(result);
    }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::{Fields, RegisterContents};

    use super::*;

    fn register(register: Register, fields: &str) -> Reply {
        Reply::Register(RegisterContents { register, fields: Fields::new(fields).unwrap(), check: Check::Xor8 })
    }

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
            assert_eq!(conversation.next_line(s(10), baud).as_deref(), read.then_some(&b"$VNRRG,54*72\r\n"[..]));
            assert_eq!(conversation.next_line(s(11), baud), None);
        }
    }

    #[test]
    fn a_caller_does_not_wait_for_the_whole_identification() {
        let mut conversation = Conversation::new(false, None);
        conversation.meet(s(0));
        assert_eq!(conversation.next_line(s(0), None).as_deref(), Some(&b"$VNRRG,07*74\r\n"[..]));
        let (sender, mut answered) = oneshot::channel();
        conversation.ask(Request { command: Command::ReadRegister(Register::IMU), answer: Some(sender) });
        assert_eq!(conversation.take_reply(&register(Register::ASYNC_RATE, "40"), s(0)), []);
        assert_eq!(conversation.next_line(s(0), None).as_deref(), Some(&b"$VNRRG,54*72\r\n"[..]));
        conversation.take_reply(&register(Register::IMU, "+21.6"), s(0));
        let Ok(Answer::Register(contents)) = answered.try_recv().unwrap() else { panic!("no answer") };
        assert_eq!(contents.fields.as_str(), "+21.6");
        // and its next question waits until the line has made up for the answer
        assert_eq!(conversation.next_line(READ_EVERY - Duration::from_millis(1), None), None);
        assert_eq!(conversation.wake_at(), Some(READ_EVERY));
        assert_eq!(conversation.next_line(READ_EVERY, None).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
    }

    #[test]
    fn a_missing_register_is_passed_over_and_a_dumb_sensor_is_left_alone() {
        let mut conversation = Conversation::new(false, None);
        conversation.meet(s(0));
        conversation.next_line(s(0), None);
        conversation.take_reply(&Reply::Error(DeviceError::InvalidRegister), s(0));
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

    #[test]
    fn what_nobody_asked_for_is_passed_on() {
        // a link that only listens has asked for nothing
        let mut conversation = Conversation::new(true, None);
        let mut told = |error| conversation.take_reply(&Reply::Error(error), s(0));
        assert_eq!(told(DeviceError::InvalidCommand), [Consequence::Unasked(DeviceError::InvalidCommand)]);
        assert_eq!(told(DeviceError::HardFault), [Consequence::Restarted(DeviceError::HardFault)]);
        assert_eq!(told(DeviceError::OutputBufferOverflow), [], "the stream tells of it");
    }
}
