//! A connected link: its frames are forwarded, and its silences and restarts are detected.

use std::{mem, time::Duration};

use vn100_protocol::stream::{LinkEventKind, StreamInput};
use vn100_protocol::{Frame, Register, Reply};

use super::{
    PortAction,
    link_context::{FIRST_DELAY, LinkContext, nanoseconds},
    pending_inputs::FrameScanner,
    requests::RequestEvent,
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
    pub(super) up: Up,
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
    pub(super) fn new(context: &mut LinkContext, now: Duration, baud: Option<u32>) -> Self {
        context.last_baud = baud;
        context.was_connected = true;
        let up = Up {
            port: context.port.name.clone(),
            baud,
            since_ns: nanoseconds(now),
            latency_timer: context.port.latency_timer.clone(),
            restarted: None,
            output_resumed: false,
        };
        let connected = Self {
            up,
            health: StreamHealth::new(context.frame_counts()),
            last_output: now,
            silence: None,
            is_restarting: false,
        };
        connected.announce(context, now);
        connected
    }

    /// Forwards what was pending while the sensor was verified. Only those replies in it are
    /// handled that `is_open` gives: the others answered the baud scan and the verification.
    pub(super) fn forward_pending(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        is_open: fn(&Reply) -> bool,
    ) -> Result<(), LinkError> {
        while let Some(input) = context.pending.pop() {
            self.forward(context, now, input, is_open)?;
        }
        // begins a new stream
        context.pending.take_all();
        Ok(())
    }

    /// Handles an input: forwards it, unless the sensor has to be verified first, because it sends
    /// again after a silence. Then the input is given back.
    pub(super) fn handle_received(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        input: StreamInput,
    ) -> Result<Option<StreamInput>, LinkError> {
        if self.silence.as_mut().is_some_and(|silence| silence.is_ended_by(&input)) {
            return Ok(Some(input));
        }
        self.forward(context, now, input, |_| true)?;
        context.requests.handle_timeout(now);
        Ok(None)
    }

    /// Checks a silent output and open commands.
    pub(super) fn handle_timeout(&mut self, context: &mut LinkContext, now: Duration) -> Result<(), LinkError> {
        if now >= self.next_silence_check() {
            if context.listen_only && self.silence.is_some() {
                return Err(LinkError::NoAnswer);
            }
            if !context.listen_only {
                context.requests.ask_presence(self.last_output, now);
            }
            let begin = || Silence { since: now, last_check: now, scanner: FrameScanner::new(context.options) };
            self.silence.get_or_insert_with(begin).last_check = now;
            context.publish(LinkState::Silent(self.up.clone()));
        }
        context.requests.handle_timeout(now);
        Ok(())
    }

    pub(super) fn poll_timeout(&self, context: &LinkContext) -> Duration {
        let requests = [context.requests.poll_timeout(), context.requests.next_read_at()];
        requests.into_iter().flatten().fold(self.next_silence_check(), Duration::min)
    }

    /// The port has followed the sensor to another baud rate.
    pub(super) fn handle_baud_set(&mut self, context: &mut LinkContext, baud: u32) {
        self.up.baud = Some(baud);
        context.last_baud = Some(baud);
        context.fixed_baud = context.fixed_baud.map(|_| baud);
        context.publish(LinkState::Up(self.up.clone()));
    }

    /// When the output counts as silent, or is checked again if it is.
    fn next_silence_check(&self) -> Duration {
        match &self.silence {
            Some(silence) => silence.last_check + SILENCE_CHECK,
            None => self.last_output + self.health.silence_timeout(),
        }
    }

    /// Reports that the link is up, and identifies the sensor.
    fn announce(&self, context: &mut LinkContext, now: Duration) {
        context.publish(LinkState::Up(self.up.clone()));
        context.requests.identify(now);
        context.emit(now, LinkEventKind::Up { port: self.up.port.clone(), baud: self.up.baud });
    }

    /// Forwards an input, judges the link by it and handles those replies in it that `is_open` says
    /// are not handled yet.
    fn forward(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        input: StreamInput,
        is_open: impl Fn(&Reply) -> bool,
    ) -> Result<(), LinkError> {
        let before = context.frame_counts();
        let read = match &input {
            StreamInput::Chunk(chunk) => Some((chunk.at_ns.unwrap_or_else(|| nanoseconds(now)), chunk.bytes.len())),
            StreamInput::Link(_) => None,
        };
        let replies = context.forward(input);
        let counts = context.frame_counts();
        if let Some((at_ns, length)) = read {
            context.requests.handle_read(length);
            match self.health.handle_read(at_ns, length, counts) {
                Reading::Good => context.reconnect_delay = FIRST_DELAY,
                Reading::Undecided => {}
                Reading::Garbled { bytes, lasted } => return Err(LinkError::Garbled { bytes, ms: lasted.as_millis() }),
            }
        }
        let has_output = counts.output > before.output;
        // a reply is no output; garbage does not end a silence
        if has_output || self.silence.is_none() && counts.good == before.good {
            self.last_output = now;
            if self.silence.take().is_some() {
                context.publish(LinkState::Up(self.up.clone()));
                // it may have been switched off and on
                context.requests.identify(now);
            }
        }
        if has_output && mem::take(&mut self.is_restarting) {
            self.announce(context, now);
        }
        for reply in replies.into_iter().filter(is_open) {
            if context.check_serial_number(&reply)? {
                context.requests.read_next(Register::SERIAL_NUMBER);
            }
            context.requests.handle_reply(&reply, now);
            while let Some(event) = context.poll_request_event() {
                self.handle_request_event(context, now, event)?;
            }
        }
        if has_output && context.requests.detect_resumed_output() {
            self.up.output_resumed = true;
            context.publish(LinkState::Up(self.up.clone()));
            context.emit(now, LinkEventKind::OutputResumed);
        }
        Ok(())
    }

    /// Handles what follows from a reply or a timeout.
    pub(super) fn handle_request_event(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        event: RequestEvent,
    ) -> Result<(), LinkError> {
        match event {
            RequestEvent::BaudChanged(baud) if context.has_baud => {
                context.port_actions.push_back(PortAction::SetBaud(baud.bits_per_s()));
            }
            RequestEvent::Absent => match &self.silence {
                Some(silence) if now < silence.since + LONGEST_STALL => {
                    context.requests.ask_presence(self.last_output, now);
                }
                Some(_) => return Err(LinkError::NoAnswer),
                None => {}
            },
            RequestEvent::Unsolicited(error) => context.emit(now, LinkEventKind::UnsolicitedError { error }),
            RequestEvent::Restarted(error) if !context.desired_settings.is_empty() => {
                return Err(LinkError::Restarted(error));
            }
            RequestEvent::Restarted(error) => {
                context.emit(now, LinkEventKind::Down { cause: error.to_string() });
                self.up.since_ns = nanoseconds(now);
                self.up.restarted = Some(error);
                context.publish(LinkState::Up(self.up.clone()));
                // it boots, and answers nothing: it is up again with its next frame
                self.is_restarting = true;
            }
            RequestEvent::BaudChanged(_) | RequestEvent::PhaseAnswered(_) | RequestEvent::Answered { .. } => {}
        }
        Ok(())
    }
}
