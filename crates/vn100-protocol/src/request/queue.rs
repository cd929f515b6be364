//! Requests to the sensor and their answers, among the other frames of the sensor; time is an
//! argument.

use alloc::{collections::VecDeque, format, string::String, vec::Vec};
use core::time::Duration;

use thiserror::Error;

use crate::{
    framing::checksum::Check,
    register::fields::RegisterFields,
    register::{Register, RegisterContents},
    request::command::SensorCommand,
    request::device_error::DeviceError,
    request::reply::Reply,
};

/// Sends requests one at a time, finds their answers among the replies and repeats commands that
/// may be repeated.
///
/// Each request ends exactly once, with an answer or a failure. Reads, writes and
/// [`SensorCommand::Async`] are sent up to [`ATTEMPTS`](Self::ATTEMPTS) times; all other commands
/// exactly once.
///
/// The owner has the link and the clock; times are durations since any fixed moment. After each
/// call, and when [`poll_timeout`](Self::poll_timeout) is due (with
/// [`handle_timeout`](Self::handle_timeout)): send the result of
/// [`poll_transmit`](Self::poll_transmit), collect [`poll_completion`](Self::poll_completion) and
/// [`poll_notice`](Self::poll_notice), and wait until the next timeout or reply.
///
/// # Which reply answers which request
///
/// A reply answers by its command and its register. `VNERR` names neither: it answers the request on
/// the wire, unless the error is always unsolicited. On a line that echoes, such as a half-duplex
/// line, the echo of a command other than a read looks like its reply: once a read was echoed and
/// answered, the first copy of any other command is the echo and the next one the answer. After a
/// request that was sent twice, the next request waits until the second answer has arrived or is too
/// late to arrive: otherwise it would be taken for the answer to the next request.
#[derive(Debug, Default)]
pub struct RequestQueue {
    check: Check,
    queue: VecDeque<(RequestId, SensorCommand)>,
    current: Option<Current>,
    late: Option<Late>,
    line_echoes: bool,
    /// The sensor executes no request before this time.
    busy_until: Duration,
    completions: VecDeque<(RequestId, Result<Response, RequestFailure>)>,
    notices: VecDeque<DeviceError>,
    submitted: u64,
}

/// A request in a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RequestId(u64);

/// The answer of the sensor to a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Response {
    /// For a read, the contents of the register; for a write, the contents that the sensor has
    /// accepted.
    Register(RegisterContents),
    /// For any other command: it is executed.
    Done,
}

/// The relation of a reply to the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handled {
    /// The reply answers a request, the present one or an ended one.
    Mine,
    /// The reply is a copy of the request itself: the line echoes.
    Echo,
    /// The reply answers no request of this queue.
    NotMine,
}

/// The queue has its [`CAPACITY`](RequestQueue::CAPACITY) of requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{} requests are pending: collect their replies before sending more", RequestQueue::CAPACITY)]
pub struct QueueFull;

/// The reason why a request failed. `line` is the command as sent, without CR and LF; empty if none
/// was sent.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RequestFailure {
    /// The sensor did not answer.
    #[error(
        "no reply to {line}, {} in {:.1} s: check the baud rate and the wire to the sensor; with error mode 0 (register 30) \
         the sensor does not report refused commands", sent(*.attempts), .after.as_secs_f64()
    )]
    Timeout {
        /// The command.
        line: String,
        /// The number of times the command was sent.
        attempts: u32,
        /// The time from the first transmission to the end of the wait.
        after: Duration,
    },
    /// The sensor refused the command.
    #[error("the sensor refused {line} with {error}: {}", .error.advice())]
    Device {
        /// The command.
        line: String,
        /// The error that the sensor reported.
        error: DeviceError,
    },
    /// The link went down before an answer came.
    #[error("the link disconnected before the reply to {line} ({})", sent(*.attempts))]
    LinkDown {
        /// The command.
        line: String,
        /// The number of times the command was sent; 0 if it was waiting for others.
        attempts: u32,
    },
    /// The sensor executed a write with other values than those sent.
    #[error(
        "the reply to {line} has other fields: requested {asked}, received {got}; read the register to see its value"
    )]
    EchoDiffers {
        /// The command.
        line: String,
        /// The fields sent.
        asked: RegisterFields,
        /// The fields of the reply.
        got: RegisterFields,
    },
}

#[derive(Debug)]
struct Current {
    id: RequestId,
    command: SensorCommand,
    attempts: u32,
    /// Number of copies that were sent and are not answered yet.
    unanswered: u32,
    /// Number of copies that were sent and whose echo has not arrived.
    unechoed: u32,
    is_echoed: bool,
    first_sent: Duration,
    last_sent: Duration,
    /// The end of the present attempt; `None` if the next copy must be sent.
    deadline: Option<Duration>,
}

/// A request that has ended with fewer answers than copies were sent.
#[derive(Debug)]
struct Late {
    command: SensorCommand,
    unanswered: u32,
    /// No further answer arrives after this time.
    until: Duration,
}

impl RequestQueue {
    /// The most times that a repeatable command is sent.
    pub const ATTEMPTS: u32 = 3;
    /// The most requests that may wait, be on the wire, or have ended without being collected.
    pub const CAPACITY: usize = 64;
    /// The most notices that are kept; the oldest are dropped.
    pub const NOTICES: usize = 16;

    /// A queue whose sentences have `check`. The sensor always accepts XOR-8 and CRC-16, and never
    /// a sentence with [`Check::None`].
    pub fn new(check: Check) -> Self {
        Self { check, ..Self::default() }
    }

    /// Queues a request after the waiting ones.
    ///
    /// # Errors
    /// [`QueueFull`] if the queue has [`CAPACITY`](Self::CAPACITY) of requests.
    pub fn submit(&mut self, command: SensorCommand) -> Result<RequestId, QueueFull> {
        let id = self.next_id()?;
        self.queue.push_back((id, command));
        Ok(id)
    }

    /// Queues a request before the waiting ones; the one on the wire is finished first.
    ///
    /// # Errors
    /// As for [`submit`](Self::submit).
    pub fn submit_next(&mut self, command: SensorCommand) -> Result<RequestId, QueueFull> {
        let id = self.next_id()?;
        self.queue.push_front((id, command));
        Ok(id)
    }

    /// Cancels a request: it is not sent again, and ends without a result; unknown and ended
    /// requests are ignored. A later answer belongs to no request; a device error may be taken for
    /// the answer to the next one.
    pub fn cancel(&mut self, id: RequestId) {
        self.queue.retain(|(queued, _)| *queued != id);
        self.current.take_if(|current| current.id == id);
    }

    fn next_id(&mut self) -> Result<RequestId, QueueFull> {
        if self.queue.len() + usize::from(self.current.is_some()) + self.completions.len() >= Self::CAPACITY {
            return Err(QueueFull);
        }
        self.submitted += 1;
        Ok(RequestId(self.submitted))
    }

    /// Handles a reply that has arrived.
    pub fn handle_reply(&mut self, reply: &Reply, now: Duration) -> Handled {
        match reply {
            Reply::Error(error) => return self.handle_error(*error, now),
            Reply::Question(register) => return self.handle_question(*register),
            Reply::Register(_) | Reply::Written(_) | Reply::Echo(_) => {}
        }
        let Some(current) = self.current.as_mut().filter(|current| current.command.is_answered_by(reply)) else {
            return self.handle_late(|late| late.command.is_answered_by(reply));
        };
        if self.line_echoes && current.unechoed > 0 && is_copy(&current.command, reply) {
            current.unechoed -= 1;
            return Handled::Echo;
        }
        if let Some((asked, got)) = difference(&current.command, reply) {
            let is_its = |late: &Late| late.command.is_answered_by(reply) && difference(&late.command, reply).is_none();
            if self.late.as_ref().is_some_and(is_its) {
                return self.handle_late(is_its);
            }
            let line = current.command.line(self.check);
            let failure = RequestFailure::EchoDiffers { line, asked: asked.clone(), got: got.clone() };
            current.unanswered = current.unanswered.saturating_sub(1);
            self.complete(Err(failure), now);
            return Handled::Mine;
        }
        current.unanswered = current.unanswered.saturating_sub(1);
        let answer = match reply {
            Reply::Register(contents) | Reply::Written(contents) => Response::Register(contents.clone()),
            Reply::Echo(_) | Reply::Error(_) | Reply::Question(_) => Response::Done,
        };
        self.complete(Ok(answer), now);
        Handled::Mine
    }

    /// Repeats or ends a request that was not answered in time; does nothing before that time.
    pub fn handle_timeout(&mut self, now: Duration) {
        let Some(current) = self.current.as_mut().filter(|current| current.deadline.is_some_and(|at| at <= now)) else {
            return;
        };
        if current.may_be_repeated() {
            current.deadline = None;
            return;
        }
        let failure = RequestFailure::Timeout {
            line: current.command.line(self.check),
            attempts: current.attempts,
            after: now.saturating_sub(current.first_sent),
        };
        self.complete(Err(failure), now);
    }

    /// Ends all requests, because the link is lost. Later requests wait for the next
    /// [`poll_transmit`](Self::poll_transmit), on a new link.
    pub fn handle_link_down(&mut self) {
        let current = self.current.take().map(|current| (current.id, current.command, current.attempts));
        let queued = self.queue.drain(..).map(|(id, command)| (id, command, 0));
        for (id, command, attempts) in current.into_iter().chain(queued) {
            let failure = RequestFailure::LinkDown { line: command.line(self.check), attempts };
            self.completions.push_back((id, Err(failure)));
        }
        self.late = None;
        self.line_echoes = false;
        self.busy_until = Duration::ZERO;
    }

    /// The sentence to send now, if there is one; the wait for its answer begins.
    pub fn poll_transmit(&mut self, now: Duration) -> Option<Vec<u8>> {
        if self.current.is_none() && now >= self.ready_at() {
            self.current = self.queue.pop_front().map(|(id, command)| Current::new(id, command));
        }
        let current = self.current.as_mut().filter(|current| current.deadline.is_none())?;
        if current.attempts == 0 {
            current.first_sent = now;
        }
        current.last_sent = now;
        current.attempts += 1;
        current.unanswered += 1;
        current.unechoed += 1;
        current.deadline = Some(now.saturating_add(current.command.answer_time()));
        Some(current.command.sentence(self.check).into_bytes())
    }

    /// The time for the next call of [`handle_timeout`](Self::handle_timeout) and
    /// [`poll_transmit`](Self::poll_transmit) , after the latter gives nothing more; `None` if only
    /// a reply or a request can have an effect.
    pub fn poll_timeout(&self) -> Option<Duration> {
        match &self.current {
            Some(current) => current.deadline,
            None if self.queue.is_empty() => None,
            None => Some(self.ready_at()),
        }
    }

    /// The next request that has ended, with its result, in the order of their ends.
    pub fn poll_completion(&mut self) -> Option<(RequestId, Result<Response, RequestFailure>)> {
        self.completions.pop_front()
    }

    /// The next device error that answers no request, in the order of arrival.
    pub fn poll_notice(&mut self) -> Option<DeviceError> {
        self.notices.pop_front()
    }

    fn handle_question(&mut self, register: Register) -> Handled {
        match &mut self.current {
            Some(current) if current.command == SensorCommand::ReadRegister(register) && current.unechoed > 0 => {
                current.unechoed -= 1;
                current.is_echoed = true;
                Handled::Echo
            }
            _ => Handled::NotMine,
        }
    }

    fn handle_error(&mut self, error: DeviceError, now: Duration) -> Handled {
        let current = self.current.as_mut().filter(|current| current.unanswered > 0 && !error.is_unsolicited());
        let Some(current) = current else {
            let handled =
                if error.is_unsolicited() { Handled::NotMine } else { self.handle_late(|late| now <= late.until) };
            if handled == Handled::NotMine {
                if self.notices.len() == Self::NOTICES {
                    self.notices.pop_front();
                }
                self.notices.push_back(error);
            }
            return handled;
        };
        current.unanswered -= 1;
        if error.is_transmission_fault() && current.may_be_repeated() {
            // an earlier copy may have arrived undamaged: its answer counts as well
            if current.unanswered == 0 {
                current.deadline = None;
            }
        } else {
            let failure = RequestFailure::Device { line: current.command.line(self.check), error };
            self.complete(Err(failure), now);
        }
        Handled::Mine
    }

    /// Handles a reply to the request that ended last, if a further answer is due and `is_its`
    /// holds.
    fn handle_late(&mut self, is_its: impl FnOnce(&Late) -> bool) -> Handled {
        let Some(late) = self.late.as_mut().filter(|late| is_its(late)) else {
            return Handled::NotMine;
        };
        late.unanswered -= 1;
        if late.unanswered == 0 {
            self.late = None;
        }
        Handled::Mine
    }

    fn complete(&mut self, result: Result<Response, RequestFailure>, now: Duration) {
        let Some(current) = self.current.take() else {
            return;
        };
        if result.is_ok() {
            // without a later answer, such a reply may be the form in which a sensor prints an
            // empty register
            self.line_echoes |= current.is_echoed;
            self.busy_until = now.saturating_add(current.command.busy_time());
        }
        let answer_time = match &result {
            Err(RequestFailure::Timeout { .. }) => current.command.answer_time(),
            // the sensor may take as long for the last attempt as for the first
            _ => current.command.answer_time().max(now.saturating_sub(current.first_sent)),
        };
        self.late = (current.unanswered > 0).then(|| Late {
            unanswered: current.unanswered,
            until: current.last_sent.saturating_add(answer_time),
            command: current.command,
        });
        self.completions.push_back((current.id, result));
    }

    fn ready_at(&self) -> Duration {
        self.late.as_ref().map_or(self.busy_until, |late| late.until.max(self.busy_until))
    }
}

impl Current {
    fn new(id: RequestId, command: SensorCommand) -> Self {
        Self {
            id,
            command,
            attempts: 0,
            unanswered: 0,
            unechoed: 0,
            is_echoed: false,
            first_sent: Duration::ZERO,
            last_sent: Duration::ZERO,
            deadline: None,
        }
    }

    fn may_be_repeated(&self) -> bool {
        self.command.is_repeatable() && self.attempts < RequestQueue::ATTEMPTS
    }
}

/// The fields that a write requested and the fields of its reply, if they differ.
fn difference<'a>(command: &'a SensorCommand, reply: &'a Reply) -> Option<(&'a RegisterFields, &'a RegisterFields)> {
    let (SensorCommand::WriteRegister { fields, .. }, Reply::Written(echo)) = (command, reply) else {
        return None;
    };
    (!echo.is_as_written(fields)).then_some((fields, &echo.fields))
}

/// Whether `reply`, which answers `command`, may also be a copy of the command itself.
fn is_copy(command: &SensorCommand, reply: &Reply) -> bool {
    match (command, reply) {
        (SensorCommand::WriteRegister { fields, .. }, Reply::Written(contents)) => contents.fields == *fields,
        (_, Reply::Echo(_)) => true,
        _ => false,
    }
}

fn sent(times: u32) -> String {
    match times {
        0 => "not yet sent".into(),
        1 => "sent once".into(),
        times => format!("sent {times} times"),
    }
}
