//! The commands of the user and of the link itself over one [`RequestQueue`], and their effects.

mod temperature_poll;

use std::{
    collections::{BTreeMap, VecDeque},
    time::Duration,
};

use vn100_protocol::{
    BaudRate, Check, DeviceError, Handled, Register, Reply, RequestFailure, RequestId, RequestQueue, Response,
    SensorCommand,
};

use super::BAUD_RATES;
use crate::link::CommandError;
use temperature_poll::TemperaturePoll;

/// The registers that describe a measurement, in the order in which they are read: those that
/// affect the first results come first, because reading all of them takes five seconds. The serial
/// number is the second, because it identifies a sensor that is lost early.
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

/// The interval between two reads of the link itself. On a line that is nearly full a reply delays
/// all frames after it until idle time has made up for the delay; replies without a pause between
/// them would together delay frames so much that they look dropped.
const READ_INTERVAL: Duration = Duration::from_millis(200);

/// A running sensor whose output is on has sent a frame within this time: the slowest output sends
/// one each second, and a restart takes 1.25 s.
const SURELY_PAUSED: Duration = Duration::from_secs(3);

/// The origin of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Requester {
    /// The user of the link; the number is that of the command.
    User(u64),
    /// The link, for identifying the sensor. The replies are part of the stream.
    Identification,
    /// The link, for finding out whether a silent sensor is connected.
    Presence,
    /// A phase of the link, which waits for the result.
    Phase,
}

/// An effect of a reply or a timeout on the link.
#[derive(Debug, PartialEq)]
pub(super) enum RequestEvent {
    /// The command of the phase has ended.
    PhaseAnswered(Result<Response, RequestFailure>),
    /// The sensor has executed the user's command to change its baud rate.
    BaudChanged(BaudRate),
    /// The sensor did not reply to the question whether it is connected.
    Absent,
    /// The sensor reports a restart.
    Restarted(DeviceError),
    /// The sensor refused a command that this link did not send. Errors that are always unsolicited
    /// are counted in the stream instead.
    Unsolicited(DeviceError),
}

/// The action of this link on an output that was silent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum InitialOutputState {
    /// This link has sent no command, or the user has set the output since.
    #[default]
    Untouched,
    /// The sensor was commanded to send. Its next frame shows whether the output was paused.
    Commanded,
    /// The output had been paused by another program, and was resumed by the command.
    Resumed,
}

#[derive(Default)]
pub(super) struct Requests {
    listen_only: bool,
    queue: RequestQueue,
    open: BTreeMap<RequestId, (SensorCommand, Requester)>,
    /// Registers that are read while no other command is open.
    to_read: VecDeque<Register>,
    read_at: Duration,
    is_paused_by_user: bool,
    answered_at: Option<Duration>,
    initial_output: InitialOutputState,
    /// The number of errors that may still be replies to a baud scan.
    spurious_errors_expected: usize,
    temperature: Option<TemperaturePoll>,
    events: VecDeque<RequestEvent>,
    pub(super) answers: VecDeque<(u64, Result<Response, CommandError>)>,
}

impl Requests {
    pub(super) fn new(listen_only: bool, poll_temperature: Option<Duration>) -> Self {
        Self {
            listen_only,
            queue: RequestQueue::new(Check::Xor8),
            temperature: poll_temperature.filter(|_| !listen_only).map(TemperaturePoll::new),
            ..Self::default()
        }
    }

    /// Reads all registers that identify the sensor: it may be another one, or have restarted.
    pub(super) fn identify(&mut self, now: Duration) {
        if self.listen_only {
            return;
        }
        self.to_read = IDENTITY.into();
        // a read that is still open was sent to the sensor in its former state
        self.open.retain(|_, (_, requester)| *requester != Requester::Identification);
        if let Some(poll) = &mut self.temperature {
            poll.restart(now);
        }
    }

    /// Cancels the commands of the link itself, because a sensor that has become silent will not
    /// answer them.
    pub(super) fn cancel_own(&mut self) {
        self.to_read.clear();
        self.open.retain(|id, (_, requester)| {
            let is_users = matches!(requester, Requester::User(_));
            if !is_users {
                self.queue.cancel(*id);
            }
            is_users
        });
    }

    /// Reads a register before the others that identify the sensor.
    pub(super) fn read_next(&mut self, register: Register) {
        if !self.listen_only {
            self.to_read.push_front(register);
        }
    }

    /// A baud scan has sent a question. At all other baud rates the sensor received garbled bytes.
    /// Until its first valid answer it may report an error for each rate and each further question;
    /// these errors do not answer the commands that are open at that time.
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

    /// Submits the command that the present phase waits for, before the commands of the user.
    pub(super) fn submit_for_phase(&mut self, command: SensorCommand) {
        self.submit(command, Requester::Phase);
    }

    /// Asks a sensor that has been silent since `silent_since` whether it is connected. A sensor that
    /// has answered since then has power: it is commanded to send, because a program that was killed
    /// may have left its output paused. This command is not sent if the user has paused the output.
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

    /// Notes that the output is on. Returns whether this shows for the first time that the output
    /// had been paused.
    pub(super) fn detect_resumed_output(&mut self) -> bool {
        let is_resumed = self.initial_output == InitialOutputState::Commanded;
        if is_resumed {
            self.initial_output = InitialOutputState::Resumed;
        }
        is_resumed
    }

    /// Whether the output was found paused and is on only because of this link, which pauses it
    /// again.
    pub(super) fn must_restore_pause(&self) -> bool {
        self.initial_output == InitialOutputState::Resumed && !self.is_paused_by_user
    }

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
        let poll = self.temperature.as_ref().map(TemperaturePoll::next_at);
        let read = (self.open.is_empty() && !self.to_read.is_empty()).then_some(self.read_at);
        poll.into_iter().chain(read).min()
    }

    pub(super) fn poll_transmit(&mut self, now: Duration) -> Option<Vec<u8>> {
        self.queue.poll_transmit(now)
    }

    pub(super) fn poll_timeout(&self) -> Option<Duration> {
        self.queue.poll_timeout()
    }

    pub(super) fn poll_event(&mut self) -> Option<RequestEvent> {
        self.events.pop_front()
    }

    pub(super) fn handle_read(&mut self, bytes: usize) {
        if let Some(poll) = &mut self.temperature {
            poll.handle_read(bytes);
        }
    }

    pub(super) fn handle_reply(&mut self, reply: &Reply, now: Duration) {
        if self.queue.handle_reply(reply, now) == Handled::Mine {
            self.answered_at = Some(now);
        }
        while let Some(error) = self.queue.poll_notice() {
            match error {
                DeviceError::HardFault | DeviceError::WatchdogReset => {
                    // after a restart of the sensor its output is on
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
        self.queue.handle_timeout(now);
        self.take_completions();
    }

    /// The link is lost, or tries another baud rate: all commands end, and only the user is
    /// informed.
    pub(super) fn handle_link_down(&mut self) {
        self.to_read.clear();
        self.is_paused_by_user = false;
        self.queue.handle_link_down();
        self.take_completions();
        self.events.clear();
    }

    fn submit(&mut self, command: SensorCommand, requester: Requester) {
        let submitted = match requester {
            Requester::Phase => self.queue.submit_next(command.clone()),
            _ => self.queue.submit(command.clone()),
        };
        match (submitted, requester) {
            (Ok(id), requester) => _ = self.open.insert(id, (command, requester)),
            (Err(full), Requester::User(id)) => self.answers.push_back((id, Err(full.into()))),
            (Err(_), Requester::Phase) => {
                // handled like a command that the sensor did not answer
                let failure = RequestFailure::LinkDown { line: String::new(), attempts: 0 };
                self.events.push_back(RequestEvent::PhaseAnswered(Err(failure)));
            }
            // the 64 commands in the queue will show whether the sensor answers
            (Err(_), Requester::Identification | Requester::Presence) => {}
        }
    }

    fn take_completions(&mut self) {
        while let Some((id, result)) = self.queue.poll_completion() {
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
                // a one-way cable carries no replies; one missing register does not mean that
                // others are missing
                Requester::Identification if is_unanswered => self.to_read.clear(),
                Requester::Presence if is_unanswered => self.events.push_back(RequestEvent::Absent),
                Requester::Presence if result.is_ok() && command == SensorCommand::Async(true) => {
                    self.initial_output = InitialOutputState::Commanded;
                }
                Requester::Identification | Requester::Presence => {}
            }
        }
    }

    fn note_effects(&mut self, command: &SensorCommand, result: &Result<Response, RequestFailure>) {
        match (command, result) {
            (SensorCommand::WriteRegister { register: Register::BAUD_RATE, fields }, Ok(Response::Register(written)))
                // a second field names a port of the sensor, which may be the other port
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
mod tests;
