//! The life of a link as a state machine: it does no I/O, and time is an argument.
//!
//! ```text
//! Opening ──> Scanning ──> Identifying ──> Connected
//!    ^           │              │              │
//!    │           └──────────────┴──────────────┴─ lost, or stopped
//!    │                                                  v
//! BackingOff <── lost ── Closing <── (RestoringOutput, where stopped)
//!                           │
//!                           └── stopped, or not worth another attempt ──> Closed
//! ```
//!
//! The owner performs the actions of the machine and reports their outcome. After each call of
//! [`handle_input`](LinkMachine::handle_input) or [`handle_timeout`](LinkMachine::handle_timeout):
//! perform the actions of [`poll_port`](LinkMachine::poll_port), send the bytes of
//! [`poll_transmit`](LinkMachine::poll_transmit), forward the results of
//! [`poll_event`](LinkMachine::poll_event) and [`poll_answer`](LinkMachine::poll_answer), and wait
//! for an input or until [`poll_timeout`](LinkMachine::poll_timeout). Every time is a duration
//! since the origin of the stamps of the stream; a late call does no harm.
//!
//! In every phase a received byte is first pending. Then it is either forwarded, which records,
//! counts and decodes it, or discarded, which records it and counts it as discarded. No phase ends
//! with inputs pending: [`LinkMachine::disconnect`] discards them.

mod baud_scan;
mod connected;
mod link_context;
mod requests;
#[cfg(test)]
mod tests;
mod verification;

use std::{io, mem, time::Duration};

use vn100_capture::{End, Event as StreamEvent};
use vn100_protocol::stream::{FrameKind, LinkEventKind, StreamInput};
use vn100_protocol::{Response, SensorCommand};

use self::{
    baud_scan::BaudScan,
    connected::Connected,
    link_context::{LinkContext, is_unsolicited_error},
    requests::RequestEvent,
    verification::Verification,
};
use crate::{
    connect::ConnectError,
    link::{CommandError, LinkOptions, LinkState},
    link_error::{LinkError, LinkHint},
    ports::LatencyTimer,
};

/// The baud rates of a VN-100 in bit/s, all of [`BaudRate::ALL`](vn100_protocol::BaudRate::ALL), in
/// the order in which the scan tries them: the factory default, the faster ones, the slower ones.
pub const BAUD_RATES: [u32; 9] = [115_200, 921_600, 460_800, 230_400, 57_600, 38_400, 19_200, 9600, 128_000];

/// The attempts to open a link that was never connected: a sensor that was just switched on sends
/// nothing for 1.25 s.
const FIRST_ATTEMPTS: u32 = 2;

/// These attempts if bytes arrive at every baud rate but form no frame: the receiver of the host
/// may flip bits until the port is opened again.
const FIRST_ATTEMPTS_GARBLED: u32 = 5;

#[derive(Debug)]
pub(crate) enum Input {
    Opened(OpenPort),
    OpenFailed(ConnectError),
    /// The baud rate of the port was set, or could not be. Bytes received before this input were
    /// sent at the former rate.
    BaudSet {
        baud: u32,
        result: io::Result<()>,
    },
    /// An input of the connection: the bytes of a read, or an event placed among them.
    Received(StreamInput),
    /// A read or write has failed, or the other end has closed the connection.
    Lost(LinkError),
    /// The port is closed. `unread` are the inputs that were read from the port but not reported.
    PortClosed {
        unread: Vec<StreamInput>,
    },
    /// The user submits a command; its result is reported with this number.
    Command {
        id: u64,
        command: SensorCommand,
    },
    /// The link must be closed finally.
    Stop,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct OpenPort {
    pub(crate) name: String,
    pub(crate) latency_timer: Option<LatencyTimer>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PortAction {
    /// Open the port at this baud rate; links without one ignore it.
    Open {
        baud: u32,
    },
    SetBaud(u32),
    Close,
}

#[derive(Debug)]
pub(crate) enum LinkOutput {
    Recorded(StreamInput),
    Stream(StreamEvent),
    State(LinkState),
}

#[expect(clippy::large_enum_variant, reason = "there is one for each link")]
enum Phase {
    Opening,
    Scanning(BaudScan),
    /// A sensor is found; it is verified to be the known sensor, with its settings.
    Identifying {
        baud: Option<u32>,
        verification: Verification,
    },
    /// The output of the sensor is forwarded. If the sensor sends again after a silence, it is
    /// verified first: it must still be the known sensor, with its settings.
    Connected {
        connected: Connected,
        verification: Option<Verification>,
    },
    /// Switches the output on or off, as it was found or as requested, before the port is closed.
    RestoringOutput {
        on: bool,
    },
    /// Waits until the port is closed; `error` is the reason, `None` for a stop.
    Closing {
        error: Option<LinkError>,
    },
    /// Waits before the port is opened again.
    BackingOff {
        until: Duration,
    },
    Closed,
}

pub(crate) struct LinkMachine {
    phase: Phase,
    context: LinkContext,
    is_stopped: bool,
    /// Whether an output that was found paused has been paused again.
    is_pause_restored: bool,
}

impl LinkMachine {
    /// A link to the port that the user calls `name`; the first phase opens the port.
    pub(crate) fn new(name: String, has_baud: bool, options: LinkOptions) -> Self {
        let mut machine = Self {
            phase: Phase::Closed,
            context: LinkContext::new(name, has_baud, options),
            is_stopped: false,
            is_pause_restored: false,
        };
        machine.open();
        machine
    }

    pub(crate) fn handle_input(&mut self, now: Duration, input: Input) {
        let mut handled = Ok(());
        match input {
            Input::Opened(port) => {
                self.context.port = port;
                let bauds = self.baud_rates();
                self.phase = Phase::Scanning(BaudScan::start(bauds, &mut self.context, now));
            }
            Input::OpenFailed(error) => self.handle_closed(now, Some(error.into())),
            Input::BaudSet { baud, result } => handled = self.handle_baud_set(now, baud, result),
            Input::Received(input) => handled = self.handle_received(now, input),
            Input::Lost(error) => handled = Err(error),
            Input::PortClosed { unread } => {
                unread.into_iter().for_each(|input| _ = self.context.pending.push(input));
                self.context.discard_pending(now);
                if let Phase::Closing { error } = mem::replace(&mut self.phase, Phase::Closed) {
                    self.handle_closed(now, error);
                }
            }
            Input::Command { id, command } => {
                self.context.requests.submit_for_user(id, command);
                if !self.is_open() {
                    self.context.requests.handle_link_down();
                }
            }
            Input::Stop => self.handle_stop(now),
        }
        self.finish_call(now, handled);
    }

    /// Handles events that are due at `now`; does nothing before the time of
    /// [`poll_timeout`](Self::poll_timeout).
    pub(crate) fn handle_timeout(&mut self, now: Duration) {
        let mut handled = Ok(());
        match &mut self.phase {
            Phase::Scanning(scan) => handled = scan.handle_timeout(&mut self.context, now),
            Phase::Connected { connected, verification: None } => {
                handled = connected.handle_timeout(&mut self.context, now);
            }
            Phase::BackingOff { until } if now >= *until => self.open(),
            Phase::Identifying { .. } | Phase::Connected { .. } | Phase::RestoringOutput { .. } => {
                self.context.requests.handle_timeout(now);
            }
            Phase::Opening | Phase::BackingOff { .. } | Phase::Closing { .. } | Phase::Closed => {}
        }
        self.finish_call(now, handled);
    }

    pub(crate) fn poll_port(&mut self) -> Option<PortAction> {
        self.context.port_actions.pop_front()
    }

    /// The bytes to send now. Must be polled after [`poll_port`](Self::poll_port) has returned `None`.
    pub(crate) fn poll_transmit(&mut self, now: Duration) -> Option<Vec<u8>> {
        if !self.is_open() {
            return None;
        }
        if let Phase::Connected { connected, verification: None } = &self.phase {
            self.context.requests.submit_due_reads(now, connected.up.baud);
        }
        let line = self.context.requests.poll_transmit(now)?;
        self.context.reader.note_sent(&line);
        Some(line)
    }

    pub(crate) fn poll_event(&mut self) -> Option<LinkOutput> {
        self.context.events.pop_front()
    }

    /// The next result of a command of the user, with the number of the command. Must be polled
    /// after [`poll_event`](Self::poll_event) has returned `None`, because the samples before a
    /// reply come first.
    pub(crate) fn poll_answer(&mut self) -> Option<(u64, Result<Response, CommandError>)> {
        self.context.requests.answers.pop_front()
    }

    /// The time for the next call of [`handle_timeout`](Self::handle_timeout) and
    /// [`poll_transmit`](Self::poll_transmit); `None` if only an input can have an effect.
    pub(crate) fn poll_timeout(&self) -> Option<Duration> {
        match &self.phase {
            Phase::Scanning(scan) => scan.poll_timeout(),
            Phase::Connected { connected, verification: None } => Some(connected.poll_timeout(&self.context)),
            Phase::Identifying { .. } | Phase::Connected { .. } | Phase::RestoringOutput { .. } => {
                self.context.requests.poll_timeout()
            }
            Phase::BackingOff { until } => Some(*until),
            Phase::Opening | Phase::Closing { .. } | Phase::Closed => None,
        }
    }

    /// Whether commands of the user are sent, or fail, at once; otherwise the owner keeps them
    /// waiting.
    pub(crate) fn accepts_commands(&self) -> bool {
        matches!(self.phase, Phase::Connected { verification: None, .. } | Phase::BackingOff { .. })
    }

    pub(crate) fn is_closed(&self) -> bool {
        matches!(self.phase, Phase::Closed)
    }

    pub(crate) fn mark(&mut self, now: Duration, text: String) {
        self.context.emit(now, LinkEventKind::Marked { text });
    }

    pub(crate) fn report_shared_port(&mut self, now: Duration, program: String) {
        self.context.port_shared_with = Some(program.clone());
        self.context.emit(now, LinkEventKind::PortShared { program });
    }

    /// Number of valid frames that the sensor has sent by itself so far, by their kind.
    pub(crate) fn frames(&self) -> impl Iterator<Item = (FrameKind, u64)> {
        self.context.reader.frames()
    }

    /// Whether the sensor was connected before but is not connected now.
    fn is_lost(&self) -> bool {
        match &self.phase {
            Phase::Connected { connected, .. } => connected.is_restarting,
            Phase::RestoringOutput { .. } | Phase::Closed => false,
            Phase::Closing { error } => error.is_some() && self.context.was_connected,
            Phase::Opening | Phase::Scanning(_) | Phase::Identifying { .. } | Phase::BackingOff { .. } => {
                self.context.was_connected
            }
        }
    }

    /// Whether commands can be sent.
    fn is_open(&self) -> bool {
        !matches!(self.phase, Phase::Opening | Phase::Closing { .. } | Phase::BackingOff { .. } | Phase::Closed)
    }

    fn open(&mut self) {
        self.phase = Phase::Opening;
        self.context.attempts += 1;
        self.context.publish(LinkState::Opening);
        let baud = self.baud_rates().first().copied().flatten().unwrap_or_default();
        self.context.port_actions.push_back(PortAction::Open { baud });
    }

    /// The baud rates to try, in order; a single `None` if the link has no baud rate.
    fn baud_rates(&self) -> Vec<Option<u32>> {
        let LinkContext { has_baud, last_baud, .. } = self.context;
        let given = self.context.options.baud;
        if !has_baud || given.is_some() {
            return vec![given.filter(|_| has_baud)];
        }
        let others = BAUD_RATES.into_iter().filter(|baud| Some(*baud) != last_baud);
        last_baud.into_iter().chain(others).map(Some).collect()
    }

    fn handle_received(&mut self, now: Duration, input: StreamInput) -> Result<(), LinkError> {
        match &mut self.phase {
            Phase::Connected { connected, verification: verification @ None } => {
                let Some(input) = connected.handle_received(&mut self.context, now, input)? else { return Ok(()) };
                // first its replies: one may be the answer to the command that made the sensor send, which the
                // verification cancels
                self.context.keep_pending(now, input)?;
                *verification = Some(Verification::after_silence(&mut self.context));
                Ok(())
            }
            Phase::Scanning(scan) => {
                let bytes = if let StreamInput::Chunk(chunk) = &input { chunk.bytes.len() } else { 0 };
                self.context.pending.push(input);
                scan.handle_received(&mut self.context, now, bytes)
            }
            _ => self.context.keep_pending(now, input),
        }
    }

    fn handle_baud_set(&mut self, now: Duration, new_baud: u32, result: io::Result<()>) -> Result<(), LinkError> {
        match &mut self.phase {
            Phase::Scanning(scan) => scan.handle_baud_set(&mut self.context, now, result)?,
            Phase::Identifying { baud, verification } => {
                *baud = verification.handle_baud_set(&mut self.context, result)?.or(*baud);
            }
            Phase::Connected { connected, .. } => {
                result?;
                connected.handle_baud_set(&mut self.context, new_baud);
            }
            _ => {}
        }
        Ok(())
    }

    /// Continues with the next phase once a baud scan has found the sensor, or the sensor is
    /// verified.
    fn advance(&mut self, now: Duration) -> Result<(), LinkError> {
        if let Phase::Scanning(scan) = &self.phase
            && let Some(baud) = scan.found()
        {
            let verification = Verification::after_scan(&mut self.context, baud);
            self.phase = Phase::Identifying { baud, verification };
        }
        match &mut self.phase {
            Phase::Identifying { baud, verification } if verification.is_done() => {
                let mut connected = Connected::new(&mut self.context, now, *baud);
                let forwarded = connected.forward_pending(&mut self.context, now, |_| false);
                self.phase = Phase::Connected { connected, verification: None };
                forwarded
            }
            Phase::Connected { connected, verification } => match verification.take_if(|done| done.is_done()) {
                Some(_) => connected.forward_pending(&mut self.context, now, is_unsolicited_error),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn handle_request_events(&mut self, now: Duration) -> Result<(), LinkError> {
        while let Some(event) = self.context.requests.poll_event() {
            match (&mut self.phase, event) {
                (
                    Phase::Identifying { verification, .. } | Phase::Connected { verification: Some(verification), .. },
                    RequestEvent::PhaseAnswered(result),
                ) => {
                    verification.handle_answer(&mut self.context, now, result)?;
                    self.advance(now)?;
                }
                // the sensor sends, so it is present
                (Phase::Connected { verification: Some(_), .. }, RequestEvent::Absent) => {}
                (Phase::Connected { connected, .. }, event) => {
                    connected.handle_request_event(&mut self.context, now, event)?;
                }
                (Phase::RestoringOutput { on }, RequestEvent::PhaseAnswered(result)) => {
                    if result.is_ok() && !*on {
                        self.is_pause_restored = true;
                        self.context.emit(now, LinkEventKind::OutputPaused);
                    }
                    self.close(now, None);
                }
                // without effect before the link is connected
                _ => {}
            }
        }
        Ok(())
    }

    fn finish_call(&mut self, now: Duration, handled: Result<(), LinkError>) {
        let handled = handled.and_then(|()| self.advance(now));
        if let Err(error) = handled.and_then(|()| self.handle_request_events(now)) {
            self.disconnect(now, error);
        }
    }

    /// The link is lost: closes the port and discards pending inputs.
    fn disconnect(&mut self, now: Duration, error: LinkError) {
        self.context.discard_pending(now);
        match &self.phase {
            Phase::Connected { .. } => {
                self.context.emit(now, LinkEventKind::Down { cause: error.to_string() });
                self.close(now, Some(error));
            }
            Phase::Scanning(_) | Phase::Identifying { .. } => self.close(now, Some(error)),
            Phase::RestoringOutput { .. } => self.close(now, None),
            Phase::Opening | Phase::Closing { .. } | Phase::BackingOff { .. } | Phase::Closed => {}
        }
    }

    fn handle_stop(&mut self, now: Duration) {
        if mem::replace(&mut self.is_stopped, true) {
            return;
        }
        if self.is_lost() {
            self.context.emit(now, LinkEventKind::Closed);
        }
        let on = match &self.phase {
            Phase::Opening | Phase::BackingOff { .. } => return self.end(None),
            Phase::Closing { .. } | Phase::Closed | Phase::RestoringOutput { .. } => return,
            Phase::Connected { .. } if self.context.requests.must_restore_pause() => false,
            Phase::Identifying { verification, .. } if verification.may_have_paused_output() => true,
            _ => return self.close(now, None),
        };
        self.context.discard_pending(now);
        self.context.requests.handle_link_down();
        self.phase = Phase::RestoringOutput { on };
        self.context.requests.submit_for_phase(SensorCommand::Async(on));
    }

    fn close(&mut self, now: Duration, error: Option<LinkError>) {
        self.context.discard_pending(now);
        self.context.requests.handle_link_down();
        self.phase = Phase::Closing { error };
        self.context.port_actions.push_back(PortAction::Close);
    }

    /// The port is closed, or could not be opened: waits for the next attempt, or ends.
    fn handle_closed(&mut self, now: Duration, error: Option<LinkError>) {
        let Some(error) = error.filter(|error| !(self.is_stopped && self.may_reconnect(error))) else {
            return self.end(None);
        };
        if !self.may_reconnect(&error) {
            return self.end(Some(error));
        }
        let retry_in = self.context.next_delay();
        self.context.publish(LinkState::Down {
            was_up: self.context.was_connected,
            cause: self.text(&error),
            needs_help: error.needs_help(),
            retry_in,
            attempts: self.context.attempts,
        });
        self.phase = Phase::BackingOff { until: now + retry_in };
    }

    /// Whether another attempt follows this error: always on a link that was connected, else a few
    /// times, because the sensor may be booting.
    fn may_reconnect(&self, error: &LinkError) -> bool {
        let was_connected = self.context.was_connected;
        match error {
            LinkError::OtherSensor { .. } => false,
            LinkError::Open(error) => was_connected && error.is_passing(),
            LinkError::NoSensor { tried, bytes, echoes: 0, .. } if tried.len() > 1 && *bytes > 0 => {
                was_connected || self.context.attempts < FIRST_ATTEMPTS_GARBLED
            }
            LinkError::NoSensor { .. } => was_connected || self.context.attempts < FIRST_ATTEMPTS,
            _ => was_connected,
        }
    }

    fn text(&self, error: &LinkError) -> String {
        match (error.hint(), &self.context.port_shared_with) {
            (Some(_), Some(program)) => format!("{error}; {program} has the port open too: end that program"),
            (Some(hint), None) => {
                format!("{error}; {}", self.context.options.hint_text.unwrap_or(LinkHint::text)(hint))
            }
            (None, _) => error.to_string(),
        }
    }

    fn end(&mut self, error: Option<LinkError>) {
        self.phase = Phase::Closed;
        let batches = self.context.reader.finish().into_iter().map(StreamEvent::from);
        let error = error.map(|error| io::Error::other(self.text(&error)));
        let last = batches.chain([StreamEvent::End(End { error, report: None })]);
        self.context.events.extend(last.map(LinkOutput::Stream));
        let paused_again = self.context.requests.must_restore_pause().then_some(self.is_pause_restored);
        self.context.publish(LinkState::Closed { paused_again });
    }
}
