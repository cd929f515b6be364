//! A connected link: its frames are forwarded, and its silences and restarts are detected.

use std::{mem, time::Duration};

use vn100_protocol::stream::{LinkEventKind, StreamInput};
use vn100_protocol::{Frame, Register, Reply};

use super::{
    PortAction,
    pending_inputs::FrameScanner,
    requests::RequestEvent,
    shared::{Shared, nanoseconds},
    stream_health::{Reading, StreamHealth},
};
use crate::{
    link::{LinkState, Up},
    link_error::LinkError,
};

/// How long after it was last checked a silent sensor is asked again, or given up where asking is
/// not allowed.
const SILENCE_CHECK: Duration = Duration::from_secs(10);

/// How long a silence lasts, at least, before a sensor that does not answer counts as lost: a
/// machine or an adapter that stalls for two seconds then delivers everything that was received
/// meanwhile, the answer too.
const LONGEST_STALL: Duration = Duration::from_millis(2500);

pub(super) struct Connected {
    up: Up,
    health: StreamHealth,
    /// When the output of the sensor was last received.
    last_output: Duration,
    silence: Option<Silence>,
    /// Whether the sensor has reported a restart, and has sent no output since.
    is_restarting: bool,
}

struct Silence {
    since: Duration,
    last_check: Duration,
    scanner: FrameScanner,
}

impl Silence {
    /// Whether the sensor sends by itself in this input. Replies do not end a silence, nor does
    /// garbage.
    fn is_ended_by(&mut self, input: &StreamInput) -> bool {
        let StreamInput::Chunk(chunk) = input else { return false };
        let mut is_ended = false;
        self.scanner.scan(&chunk.bytes, |frame| {
            is_ended |= match frame {
                Frame::Sentence(sentence) => Reply::parse(&sentence).is_err(),
                Frame::Packet(_) => true,
                Frame::Rejected(_) => false,
            };
        });
        is_ended
    }
}

impl Connected {
    /// The sensor is connected at this baud rate.
    pub(super) fn new(shared: &mut Shared, now: Duration, baud: Option<u32>) -> Self {
        shared.last_baud = baud;
        shared.was_connected = true;
        let up = Up {
            port: shared.port.name.clone(),
            baud,
            since_ns: nanoseconds(now),
            latency_timer: shared.port.latency_timer.clone(),
            restarted: None,
            output_resumed: false,
        };
        let connected = Self {
            up,
            health: StreamHealth::new(shared.frame_counts()),
            last_output: now,
            silence: None,
            is_restarting: false,
        };
        connected.announce(shared, now);
        connected
    }

    /// Forwards what was pending while the sensor was verified. Only those replies in it are
    /// handled that `is_open` gives: the others answered the baud scan and the verification.
    pub(super) fn forward_pending(
        &mut self,
        shared: &mut Shared,
        now: Duration,
        is_open: fn(&Reply) -> bool,
    ) -> Result<(), LinkError> {
        while let Some(input) = shared.pending.pop() {
            self.forward(shared, now, input, is_open)?;
        }
        // begins a new stream
        shared.pending.take_all();
        Ok(())
    }

    /// Handles an input: forwards it, unless the sensor has to be verified first, because it sends
    /// again after a silence. Then the input is given back.
    pub(super) fn handle_received(
        &mut self,
        shared: &mut Shared,
        now: Duration,
        input: StreamInput,
    ) -> Result<Option<StreamInput>, LinkError> {
        if self.silence.as_mut().is_some_and(|silence| silence.is_ended_by(&input)) {
            return Ok(Some(input));
        }
        self.forward(shared, now, input, |_| true)?;
        shared.requests.handle_timeout(now);
        self.handle_request_events(shared, now)?;
        Ok(None)
    }

    /// Checks a silent output and open commands.
    pub(super) fn handle_timeout(&mut self, shared: &mut Shared, now: Duration) -> Result<(), LinkError> {
        if now >= self.next_silence_check() {
            if shared.listen_only && self.silence.is_some() {
                return Err(LinkError::NoAnswer);
            }
            if !shared.listen_only {
                shared.requests.ask_presence(self.last_output, now);
            }
            let begin = || Silence { since: now, last_check: now, scanner: FrameScanner::new(shared.options) };
            self.silence.get_or_insert_with(begin).last_check = now;
            shared.publish(LinkState::Silent(self.up.clone()));
        }
        shared.requests.handle_timeout(now);
        self.handle_request_events(shared, now)
    }

    /// Submits what is due to be read on the line.
    pub(super) fn submit_due_reads(&self, shared: &mut Shared, now: Duration) {
        shared.requests.submit_due_reads(now, self.up.baud);
    }

    pub(super) fn poll_timeout(&self, shared: &Shared) -> Duration {
        let requests = [shared.requests.poll_timeout(), shared.requests.next_read_at()];
        requests.into_iter().flatten().fold(self.next_silence_check(), Duration::min)
    }

    /// The port has followed the sensor to another baud rate.
    pub(super) fn handle_baud_set(&mut self, shared: &mut Shared, baud: u32) {
        self.up.baud = Some(baud);
        shared.last_baud = Some(baud);
        shared.fixed_baud = shared.fixed_baud.map(|_| baud);
        shared.publish(LinkState::Up(self.up.clone()));
    }

    /// When the output counts as silent, or is checked again if it is.
    fn next_silence_check(&self) -> Duration {
        match &self.silence {
            Some(silence) => silence.last_check + SILENCE_CHECK,
            None => self.last_output + self.health.silence_timeout(),
        }
    }

    /// Reports that the link is up, and identifies the sensor.
    fn announce(&self, shared: &mut Shared, now: Duration) {
        shared.publish(LinkState::Up(self.up.clone()));
        shared.requests.identify(now);
        shared.emit(now, LinkEventKind::Up { port: self.up.port.clone(), baud: self.up.baud });
    }

    /// Forwards an input, judges the link by it and handles those replies in it that `is_open` says
    /// are not handled yet.
    fn forward(
        &mut self,
        shared: &mut Shared,
        now: Duration,
        input: StreamInput,
        is_open: impl Fn(&Reply) -> bool,
    ) -> Result<(), LinkError> {
        let before = shared.frame_counts();
        let read = match &input {
            StreamInput::Chunk(chunk) => Some((chunk.at_ns.unwrap_or_else(|| nanoseconds(now)), chunk.bytes.len())),
            StreamInput::Link(_) => None,
        };
        let replies = shared.forward(input);
        let counts = shared.frame_counts();
        if let Some((at_ns, length)) = read {
            shared.requests.handle_read(length);
            match self.health.handle_read(at_ns, length, counts) {
                Reading::Good => shared.back_off.reset(),
                Reading::Undecided => {}
                Reading::Garbled { bytes, lasted } => return Err(LinkError::Garbled { bytes, ms: lasted.as_millis() }),
            }
        }
        let has_output = counts.output > before.output;
        // a reply is no output; garbage does not end a silence
        if has_output || self.silence.is_none() && counts.good == before.good {
            self.last_output = now;
            if self.silence.take().is_some() {
                shared.publish(LinkState::Up(self.up.clone()));
                // it may have been switched off and on
                shared.requests.identify(now);
            }
        }
        if has_output && mem::take(&mut self.is_restarting) {
            self.announce(shared, now);
        }
        for reply in replies.into_iter().filter(is_open) {
            if shared.check_serial_number(&reply)? {
                shared.requests.read_next(Register::SERIAL_NUMBER);
            }
            shared.requests.handle_reply(&reply, now);
            self.handle_request_events(shared, now)?;
        }
        if has_output && shared.requests.detect_resumed_output() {
            self.up.output_resumed = true;
            shared.publish(LinkState::Up(self.up.clone()));
            shared.emit(now, LinkEventKind::OutputResumed);
        }
        Ok(())
    }

    fn handle_request_events(&mut self, shared: &mut Shared, now: Duration) -> Result<(), LinkError> {
        while let Some(event) = shared.poll_request_event() {
            self.handle_request_event(shared, now, event)?;
        }
        Ok(())
    }

    /// Handles what follows from a reply or a timeout.
    pub(super) fn handle_request_event(
        &mut self,
        shared: &mut Shared,
        now: Duration,
        event: RequestEvent,
    ) -> Result<(), LinkError> {
        match event {
            RequestEvent::BaudChanged(baud) if shared.has_baud => {
                shared.port_actions.push_back(PortAction::SetBaud(baud.bits_per_s()));
            }
            RequestEvent::Absent => match &self.silence {
                Some(silence) if now < silence.since + LONGEST_STALL => {
                    shared.requests.ask_presence(self.last_output, now);
                }
                Some(_) => return Err(LinkError::NoAnswer),
                None => {}
            },
            RequestEvent::Unsolicited(error) => shared.emit(now, LinkEventKind::UnsolicitedError { error }),
            RequestEvent::Restarted(error) if !shared.desired_settings.is_empty() => {
                return Err(LinkError::Restarted(error));
            }
            RequestEvent::Restarted(error) => {
                shared.emit(now, LinkEventKind::Down { cause: error.to_string() });
                self.up.since_ns = nanoseconds(now);
                self.up.restarted = Some(error);
                shared.publish(LinkState::Up(self.up.clone()));
                // it boots, and answers nothing: it is up again with its next frame
                self.is_restarting = true;
            }
            RequestEvent::BaudChanged(_) | RequestEvent::PhaseAnswered(_) | RequestEvent::Answered { .. } => {}
        }
        Ok(())
    }
}
