//! The commands of the user and of the link itself over one [`RequestQueue`], and what follows.

use std::{
    collections::{BTreeMap, VecDeque},
    time::Duration,
};

use vn100_protocol::{
    BaudRate, Check, DeviceError, Handled, Register, Reply, RequestFailure, RequestId, RequestQueue, Response,
    SensorCommand,
};

use super::baud_scan::BAUD_RATES;
use crate::link::CommandError;

/// The registers that describe a measurement, in the order in which they are read: first those
/// that the first numbers rest on, as reading all of them takes five seconds. The serial number is
/// the second, because a sensor that is lost early is identified by it.
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

/// The interval between two reads of the link's own. On a line that is nearly full a reply delays
/// all frames behind it until idle time has made up for it; replies without a pause would add up to
/// what looks like lost frames.
const READ_INTERVAL: Duration = Duration::from_millis(200);

/// A running sensor whose output is on has sent a frame by then: the slowest output sends one each
/// second, and a restart takes 1.25 s.
const SURELY_PAUSED: Duration = Duration::from_secs(3);

/// Who submitted a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Requester {
    /// The user of the link; the number is that of the request.
    User(u64),
    /// The link, to identify the sensor. The replies are part of the stream.
    Identification,
    /// The link, to learn whether a silent sensor is there.
    Presence,
    /// A phase of the link that waits for the result.
    Phase,
}

/// What follows from a reply or a timeout.
#[derive(Debug, PartialEq)]
pub(super) enum RequestEvent {
    /// The command of the phase has ended.
    PhaseAnswered(Result<Response, RequestFailure>),
    /// The sensor has carried out the user's command to change its baud rate.
    BaudChanged(BaudRate),
    /// The sensor was asked whether it is there, and did not reply.
    Absent,
    /// The sensor reports that it has restarted.
    Restarted(DeviceError),
    /// The sensor refused a command that this link did not send. Errors that are always unsolicited
    /// are counted in the stream instead.
    Unsolicited(DeviceError),
}

/// What this link has done about an output that was silent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum InitialOutputState {
    /// Nothing, or the user has set the output since.
    #[default]
    Untouched,
    /// The sensor was commanded to send. The next frame shows whether its output was paused.
    Commanded,
    /// The output had been paused by another program, and was resumed by the command.
    Resumed,
}

/// Bytes that the reply to a read of the temperature takes from the line.
const TEMPERATURE_REPLY_BYTES: f64 = 128.0;

/// When the temperature is read between the frames of the output.
struct TemperaturePoll {
    every: Duration,
    last: Duration,
    /// Bytes that were received since then.
    bytes: u64,
}

impl TemperaturePoll {
    /// Whether a read is due and its reply fits between the frames; a period ends when it is due.
    fn is_due(&mut self, now: Duration, baud: Option<u32>) -> bool {
        let passed = now.saturating_sub(self.last);
        if passed < self.every {
            return false;
        }
        let bytes_per_s = self.bytes as f64 / passed.as_secs_f64();
        (self.last, self.bytes) = (now, 0);
        // ten bits a byte; the reply must be through within a second
        baud.is_none_or(|baud| bytes_per_s + TEMPERATURE_REPLY_BYTES <= f64::from(baud) / 10.0)
    }
}

#[derive(Default)]
pub(super) struct Requests {
    listen_only: bool,
    session: RequestQueue,
    /// The commands that the session has not completed.
    open: BTreeMap<RequestId, (SensorCommand, Requester)>,
    /// Registers to read while no other command is open.
    to_read: VecDeque<Register>,
    /// The earliest time of the next such read.
    read_at: Duration,
    /// Whether the user has paused the output.
    is_paused_by_user: bool,
    /// When the sensor last answered a command.
    answered_at: Option<Duration>,
    initial_output: InitialOutputState,
    /// How many errors may still be replies to a baud scan.
    spurious_errors_expected: usize,
    temperature: Option<TemperaturePoll>,
    events: VecDeque<RequestEvent>,
    /// The results of the user's commands, with their numbers.
    pub(super) answers: VecDeque<(u64, Result<Response, CommandError>)>,
}

impl Requests {
    pub(super) fn new(listen_only: bool, poll_temperature: Option<Duration>) -> Self {
        let poll = |every| TemperaturePoll { every, last: Duration::ZERO, bytes: 0 };
        Self {
            listen_only,
            session: RequestQueue::new(Check::Xor8),
            temperature: poll_temperature.filter(|_| !listen_only).map(poll),
            ..Self::default()
        }
    }

    /// Reads all registers that identify the sensor: it may be another one, or have restarted.
    pub(super) fn identify(&mut self, now: Duration) {
        if self.listen_only {
            return;
        }
        self.to_read = IDENTITY.into();
        // a read that is still open was sent to the sensor as it was before
        self.open.retain(|_, (_, requester)| *requester != Requester::Identification);
        if let Some(poll) = &mut self.temperature {
            (poll.last, poll.bytes) = (now, 0);
        }
    }

    /// Gives up what the link itself has asked a sensor that was silent since then.
    pub(super) fn cancel_own(&mut self) {
        self.to_read.clear();
        self.open.retain(|id, (_, requester)| {
            let is_users = matches!(requester, Requester::User(_));
            if !is_users {
                self.session.cancel(*id);
            }
            is_users
        });
    }

    /// Reads a register ahead of the others that identify the sensor.
    pub(super) fn read_next(&mut self, register: Register) {
        if !self.listen_only {
            self.to_read.push_front(register);
        }
    }

    /// A baud scan has sent a question. At all baud rates but its own the sensor received garbage.
    /// Until its first good answer it may report an error for each rate and each further question,
    /// and these errors answer none of the commands that are open by then.
    pub(super) fn expect_spurious_errors(&mut self) {
        self.spurious_errors_expected = (self.spurious_errors_expected + 1).max(BAUD_RATES.len());
    }

    pub(super) fn submit_for_user(&mut self, id: u64, command: SensorCommand) {
        if self.listen_only {
            self.answers.push_back((id, Err(CommandError::ListenOnly)));
        } else {
            self.submit(command, Requester::User(id));
        }
    }

    /// Submits the command that the present phase waits for, ahead of those of the user.
    pub(super) fn submit_for_phase(&mut self, command: SensorCommand) {
        self.submit(command, Requester::Phase);
    }

    /// Asks a sensor that has been silent since `silent_since` whether it is there. A sensor that
    /// has answered since then has power: it is commanded to send, because a program that was
    /// killed may have left its output paused. Not if the user has paused it.
    pub(super) fn ask_presence(&mut self, silent_since: Duration, now: Duration) {
        let has_answered = self.answered_at.is_some_and(|at| at > silent_since);
        let may_be_paused = !self.is_paused_by_user && has_answered && now >= silent_since + SURELY_PAUSED;
        if self.initial_output == InitialOutputState::Commanded {
            self.initial_output = InitialOutputState::Untouched;
        }
        let question =
            if may_be_paused { SensorCommand::Async(true) } else { SensorCommand::ReadRegister(Register::MODEL) };
        self.submit(question, Requester::Presence);
    }

    /// The output is on. Whether that shows, for the first time, that it had been paused.
    pub(super) fn detect_resumed_output(&mut self) -> bool {
        let is_resumed = self.initial_output == InitialOutputState::Commanded;
        if is_resumed {
            self.initial_output = InitialOutputState::Resumed;
        }
        is_resumed
    }

    /// Whether the output was found paused and is on only because of this link.
    pub(super) fn must_restore_pause(&self) -> bool {
        self.initial_output == InitialOutputState::Resumed && !self.is_paused_by_user
    }

    /// Submits the reads that are due on a connected link of this baud rate.
    pub(super) fn submit_due_reads(&mut self, now: Duration, baud: Option<u32>) {
        if self.temperature.as_mut().is_some_and(|poll| poll.is_due(now, baud)) {
            self.to_read.push_back(Register::IMU);
        }
        if self.open.is_empty()
            && now >= self.read_at
            && let Some(register) = self.to_read.pop_front()
        {
            self.read_at = now + READ_INTERVAL;
            self.submit(SensorCommand::ReadRegister(register), Requester::Identification);
        }
    }

    pub(super) fn next_read_at(&self) -> Option<Duration> {
        let poll = self.temperature.as_ref().map(|poll| poll.last + poll.every);
        let read = (self.open.is_empty() && !self.to_read.is_empty()).then_some(self.read_at);
        poll.into_iter().chain(read).min()
    }

    pub(super) fn poll_transmit(&mut self, now: Duration) -> Option<Vec<u8>> {
        self.session.poll_transmit(now)
    }

    pub(super) fn poll_timeout(&self) -> Option<Duration> {
        self.session.poll_timeout()
    }

    pub(super) fn poll_event(&mut self) -> Option<RequestEvent> {
        self.events.pop_front()
    }

    pub(super) fn handle_read(&mut self, bytes: usize) {
        if let Some(poll) = &mut self.temperature {
            poll.bytes += bytes as u64;
        }
    }

    /// Handles a reply, or an unsolicited error.
    pub(super) fn handle_reply(&mut self, reply: &Reply, now: Duration) {
        if self.session.handle_reply(reply, now) == Handled::Mine {
            self.answered_at = Some(now);
        }
        while let Some(error) = self.session.poll_notice() {
            match error {
                DeviceError::HardFault | DeviceError::WatchdogReset => {
                    // after a restart the output is on
                    self.is_paused_by_user = false;
                    self.initial_output = InitialOutputState::Untouched;
                    self.events.push_back(RequestEvent::Restarted(error));
                }
                _ if error.is_unsolicited() => {}
                _ if self.spurious_errors_expected > 0 => self.spurious_errors_expected -= 1,
                _ => self.events.push_back(RequestEvent::Unsolicited(error)),
            }
        }
        self.take_completions();
    }

    pub(super) fn handle_timeout(&mut self, now: Duration) {
        self.session.handle_timeout(now);
        self.take_completions();
    }

    /// The link is lost, or tries another baud rate: all commands end; only the user is informed.
    pub(super) fn handle_link_down(&mut self) {
        self.to_read.clear();
        self.is_paused_by_user = false;
        self.session.handle_link_down();
        self.take_completions();
        self.events.clear();
    }

    fn submit(&mut self, command: SensorCommand, requester: Requester) {
        let submitted = match requester {
            Requester::Phase => self.session.submit_next(command.clone()),
            _ => self.session.submit(command.clone()),
        };
        match (submitted, requester) {
            (Ok(id), requester) => _ = self.open.insert(id, (command, requester)),
            (Err(full), Requester::User(id)) => self.answers.push_back((id, Err(full.into()))),
            (Err(_), Requester::Phase) => {
                // to be taken as one that the sensor has not answered
                let failure = RequestFailure::LinkDown { line: String::new(), attempts: 0 };
                self.events.push_back(RequestEvent::PhaseAnswered(Err(failure)));
            }
            // the results of the 64 open commands show that
            (Err(_), Requester::Identification | Requester::Presence) => {}
        }
    }

    fn take_completions(&mut self) {
        while let Some((id, result)) = self.session.poll_completion() {
            let Some((command, requester)) = self.open.remove(&id) else { continue };
            let is_refused = matches!(result, Err(RequestFailure::Device { .. }));
            if is_refused && self.spurious_errors_expected > 0 && matches!(command, SensorCommand::ReadRegister(_)) {
                self.spurious_errors_expected -= 1;
                self.submit(command, requester);
                continue;
            }
            if result.is_ok() {
                self.spurious_errors_expected = 0;
            }
            let is_unanswered = matches!(result, Err(RequestFailure::Timeout { .. }));
            match requester {
                Requester::User(id) => {
                    self.note_effects(&command, &result);
                    self.answers.push_back((id, result.map_err(CommandError::from)));
                }
                Requester::Phase => self.events.push_back(RequestEvent::PhaseAnswered(result)),
                // a one-way cable carries no replies; one missing register is no evidence for the others
                Requester::Identification if is_unanswered => self.to_read.clear(),
                Requester::Presence if is_unanswered => self.events.push_back(RequestEvent::Absent),
                Requester::Presence if result.is_ok() && command == SensorCommand::Async(true) => {
                    self.initial_output = InitialOutputState::Commanded;
                }
                Requester::Identification | Requester::Presence => {}
            }
        }
    }

    /// What a command of the user changes for the link.
    fn note_effects(&mut self, command: &SensorCommand, result: &Result<Response, RequestFailure>) {
        match (command, result) {
            (SensorCommand::WriteRegister { register: Register::BAUD_RATE, fields }, Ok(Response::Register(written)))
                // a second field names a port of the sensor, which may be the other one
                if fields.iter().count() == 1 =>
            {
                self.events.extend(written.value().ok().map(RequestEvent::BaudChanged));
            }
            (SensorCommand::Async(on), Ok(_)) => {
                self.is_paused_by_user = !on;
                self.initial_output = InitialOutputState::Untouched;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use vn100_protocol::{RegisterContents, RegisterFields};

    use super::*;

    const MODEL: &[u8] = b"$VNRRG,01*72\r\n";

    fn register(register: Register, fields: &str) -> Reply {
        Reply::Register(RegisterContents { register, fields: RegisterFields::new(fields).unwrap() })
    }

    const fn s(s: u64) -> Duration {
        Duration::from_secs(s)
    }

    /// What a connected link sends.
    fn transmit(requests: &mut Requests, now: Duration, baud: Option<u32>) -> Option<Vec<u8>> {
        requests.submit_due_reads(now, baud);
        requests.poll_transmit(now)
    }

    /// What follows from an error that the sensor reports.
    fn reported(requests: &mut Requests, error: DeviceError, now: Duration) -> Vec<RequestEvent> {
        requests.handle_reply(&Reply::Error(error), now);
        requests.events.drain(..).collect()
    }

    #[test]
    fn the_temperature_is_read_where_the_line_has_room() {
        // 94 frames of 122 bytes fill a line of 115 200 baud but for 52 bytes a second
        for (frames_per_s, baud, read) in [(40, Some(115_200), true), (94, Some(115_200), false), (94, None, true)] {
            let mut requests = Requests::new(false, Some(s(10)));
            assert_eq!(requests.next_read_at(), Some(s(10)));
            requests.handle_read(10 * frames_per_s * 122);
            assert_eq!(transmit(&mut requests, s(9), baud), None);
            let sent = transmit(&mut requests, s(10), baud);
            assert_eq!(sent.as_deref(), read.then_some(&b"$VNRRG,54*72\r\n"[..]));
            assert_eq!(transmit(&mut requests, s(11), baud), None);
        }
        assert_eq!(Requests::new(true, Some(s(10))).next_read_at(), None, "a link that only listens");
    }

    #[test]
    fn the_user_does_not_wait_for_the_whole_identification() {
        let mut requests = Requests::new(false, None);
        requests.identify(s(0));
        assert_eq!(transmit(&mut requests, s(0), None).as_deref(), Some(&b"$VNRRG,07*74\r\n"[..]));
        requests.submit_for_user(1, SensorCommand::ReadRegister(Register::IMU));
        requests.handle_reply(&register(Register::ASYNC_RATE, "40"), s(0));
        assert_eq!(requests.poll_event(), None);
        assert_eq!(transmit(&mut requests, s(0), None).as_deref(), Some(&b"$VNRRG,54*72\r\n"[..]));
        requests.handle_reply(&register(Register::IMU, "+21.6"), s(0));
        let Some((1, Ok(Response::Register(contents)))) = requests.answers.pop_front() else { panic!("no answer") };
        assert_eq!(contents.fields.as_str(), "+21.6");
        // the next register waits until the line has made up for the reply
        assert_eq!(transmit(&mut requests, READ_INTERVAL - Duration::from_millis(1), None), None);
        assert_eq!(requests.next_read_at(), Some(READ_INTERVAL));
        assert_eq!(transmit(&mut requests, READ_INTERVAL, None).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
        // one that is to be verified comes before the rest
        requests.read_next(Register::SERIAL_NUMBER);
        requests.handle_reply(&register(Register::SERIAL_NUMBER, "1"), READ_INTERVAL);
        assert_eq!(transmit(&mut requests, READ_INTERVAL * 2, None).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
    }

    #[test]
    fn a_missing_register_is_passed_over_and_a_one_way_cable_is_left_alone() {
        let mut requests = Requests::new(false, None);
        requests.identify(s(0));
        assert!(transmit(&mut requests, s(0), None).is_some());
        requests.handle_reply(&Reply::Error(DeviceError::InvalidRegister), s(0));
        assert!(transmit(&mut requests, READ_INTERVAL, None).is_some());
        let (mut now, mut sent) = (s(0), 0);
        while let Some(due) = [requests.poll_timeout(), requests.next_read_at()].into_iter().flatten().min() {
            now = due;
            requests.handle_timeout(now);
            sent += u32::from(transmit(&mut requests, now, None).is_some());
        }
        assert_eq!((sent, now), (2, READ_INTERVAL + Duration::from_millis(1500)), "two more attempts of one read");
    }

    #[test]
    fn a_command_of_the_phase_is_sent_before_those_of_the_user() {
        let mut requests = Requests::new(false, None);
        requests.submit_for_user(1, SensorCommand::ReadRegister(Register::IMU));
        requests.submit_for_user(2, SensorCommand::ReadRegister(Register::MODEL));
        assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(&b"$VNRRG,54*72\r\n"[..]));
        requests.submit_for_phase(SensorCommand::ReadRegister(Register::SERIAL_NUMBER));
        requests.handle_reply(&register(Register::IMU, "1"), s(0));
        assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(&b"$VNRRG,03*70\r\n"[..]));
        requests.handle_reply(&register(Register::SERIAL_NUMBER, "1"), s(0));
        assert!(matches!(requests.answers.pop_front(), Some((1, Ok(_)))));
        assert!(matches!(requests.poll_event(), Some(RequestEvent::PhaseAnswered(Ok(_)))));
        assert_eq!(requests.poll_transmit(s(0)).as_deref(), Some(MODEL));
        // a lost link ends what is open, and only the user is informed
        requests.submit_for_phase(SensorCommand::ReadRegister(Register::SERIAL_NUMBER));
        requests.handle_link_down();
        assert!(matches!(requests.answers.pop_front(), Some((2, Err(_)))));
        assert_eq!((requests.poll_event(), requests.poll_transmit(s(9))), (None, None));
    }

    #[test]
    fn what_this_link_did_not_cause_is_an_event() {
        // a link that only listens has sent nothing
        let mut requests = Requests::new(true, None);
        for (error, expected) in [
            (DeviceError::InvalidCommand, vec![RequestEvent::Unsolicited(DeviceError::InvalidCommand)]),
            (DeviceError::HardFault, vec![RequestEvent::Restarted(DeviceError::HardFault)]),
            (DeviceError::WatchdogReset, vec![RequestEvent::Restarted(DeviceError::WatchdogReset)]),
            // counted in the stream
            (DeviceError::OutputBufferOverflow, vec![]),
        ] {
            assert_eq!(reported(&mut requests, error, s(0)), expected);
        }
        requests.submit_for_user(1, SensorCommand::Async(true));
        assert_eq!(requests.answers.pop_front(), Some((1, Err(CommandError::ListenOnly))));
        requests.identify(s(0));
        requests.read_next(Register::MODEL);
        assert_eq!(transmit(&mut requests, s(0), None), None);
    }

    #[test]
    fn errors_after_a_baud_scan_are_not_taken_for_answers_until_the_first_good_one() {
        let refusal = DeviceError::InvalidCommand;
        let read = |requests: &mut Requests| requests.submit_for_user(1, SensorCommand::ReadRegister(Register::MODEL));
        let mut requests = Requests::new(false, None);
        requests.expect_spurious_errors();
        assert_eq!(reported(&mut requests, refusal, s(0)), [], "before anything is sent");
        read(&mut requests);
        for _ in 0..2 {
            assert!(requests.poll_transmit(s(0)).is_some(), "it is sent again");
            assert_eq!(reported(&mut requests, refusal, s(0)), []);
        }
        assert!(requests.poll_transmit(s(0)).is_some());
        requests.handle_reply(&register(Register::MODEL, "VN-100S-CR"), s(0));
        assert!(matches!(requests.answers.pop_front(), Some((1, Ok(_)))));
        assert_eq!(reported(&mut requests, refusal, s(1)), [RequestEvent::Unsolicited(refusal)]);
        // and a sensor that always refuses is not asked without end: one error for each baud rate
        for questions in [1, BAUD_RATES.len() + 3] {
            (0..questions).for_each(|_| requests.expect_spurious_errors());
            read(&mut requests);
            for attempt in 0.. {
                assert!(requests.poll_transmit(s(1)).is_some());
                assert_eq!(reported(&mut requests, refusal, s(1)), []);
                if let Some((1, Err(_))) = requests.answers.pop_front() {
                    assert_eq!(attempt, BAUD_RATES.len() + questions - 1);
                    break;
                }
            }
        }
    }

    /// A sensor whose output has been silent for 3 s, and that has answered meanwhile.
    fn silent() -> Requests {
        let mut requests = Requests::new(false, None);
        requests.ask_presence(s(0), s(1));
        assert_eq!(requests.poll_transmit(s(1)).as_deref(), Some(MODEL));
        requests.handle_reply(&register(Register::MODEL, "VN-100"), s(1));
        requests
    }

    #[test]
    fn a_paused_output_is_resumed_and_its_pause_is_to_be_restored() {
        let mut requests = silent();
        requests.ask_presence(s(0), Duration::from_millis(2999));
        assert_eq!(requests.poll_transmit(s(3)).as_deref(), Some(MODEL), "it may only be slow");
        requests.handle_reply(&register(Register::MODEL, "VN-100"), s(3));
        requests.ask_presence(s(0), s(3));
        assert_eq!(requests.poll_transmit(s(3)).as_deref(), Some(&b"$VNASY,1*4E\r\n"[..]));
        assert!(!requests.detect_resumed_output(), "the command is not answered");
        requests.handle_reply(&Reply::Echo("VNASY,1".into()), s(3));
        assert!(!requests.must_restore_pause());
        assert!(requests.detect_resumed_output());
        assert!(requests.must_restore_pause() && !requests.detect_resumed_output());
        // a restart switches the output on, and a user who commands the output keeps it
        let mut restarted = requests;
        restarted.handle_reply(&Reply::Error(DeviceError::HardFault), s(4));
        assert!(!restarted.must_restore_pause());
    }

    #[test]
    fn an_output_that_the_user_has_set_is_left_alone() {
        for on in [false, true] {
            let mut requests = silent();
            requests.submit_for_user(1, SensorCommand::Async(on));
            assert!(requests.poll_transmit(s(2)).is_some());
            requests.handle_reply(&Reply::Echo(format!("VNASY,{}", u8::from(on))), s(2));
            requests.ask_presence(s(0), s(9));
            let question = requests.poll_transmit(s(9));
            assert_eq!(question.as_deref() == Some(MODEL), !on, "a pause that the user wants is kept");
            if on {
                requests.handle_reply(&Reply::Echo("VNASY,1".into()), s(9));
                assert!(requests.detect_resumed_output());
                requests.submit_for_user(2, SensorCommand::Async(true));
                assert!(requests.poll_transmit(s(9)).is_some());
                requests.handle_reply(&Reply::Echo("VNASY,1".into()), s(9));
                assert!(!requests.must_restore_pause());
            }
        }
    }

    #[test]
    fn a_sensor_that_does_not_answer_is_absent() {
        let mut requests = Requests::new(false, None);
        requests.ask_presence(s(0), s(0));
        while requests.poll_transmit(requests.poll_timeout().unwrap_or_default()).is_some() {
            requests.handle_timeout(requests.poll_timeout().unwrap());
        }
        assert_eq!(requests.poll_event(), Some(RequestEvent::Absent));
        assert_eq!(requests.poll_timeout(), None);
    }
}
