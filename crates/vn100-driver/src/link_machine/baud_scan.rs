//! The search for the baud rate of a sensor: at each rate the scan listens, then asks.

use std::{collections::VecDeque, io, time::Duration};

use super::{PortAction, link_context::LinkContext};
use crate::{
    link::LinkState,
    link_error::LinkError,
    question::{QUESTION, without_echoes},
};

/// The time of listening before a question: more than three periods of the factory default of 40 Hz.
const LISTEN: Duration = Duration::from_millis(150);

/// The time of listening if no question is sent: a period of the slowest output, and the frame
/// itself.
const LISTEN_ONLY: Duration = Duration::from_millis(1200);

/// The wait for a sensor while another device sends: enough for three lines at one per second.
const DOUBT: Duration = Duration::from_millis(2400);

/// The longest delay of the sensor's answer, besides the transmission time of the answer.
const ANSWER: Duration = Duration::from_millis(100);

/// The round-trip time of a network.
const NETWORK: Duration = Duration::from_millis(500);

/// The longest frame that may be in transmission when the question arrives, and the answer after
/// it, in bytes.
const BYTES_BEFORE_ANSWER: u32 = 256;

/// The wait for a silent sensor at the first baud rate: longer than its boot of 1.25 s.
const BOOT: Duration = Duration::from_secs(2);

/// The time for discarding bytes before a baud rate is tried a second time: longer than an adapter
/// keeps bytes.
const SETTLE: Duration = Duration::from_millis(100);

/// More bytes than this are neither left over in the adapter nor the rest of one frame.
const STRAY_BYTES: u64 = 100;

/// More bytes than this, long after the port was opened and without a question, are not glitches of
/// an idle line.
const GLITCH_BYTES: u64 = 8;

#[derive(Debug, Clone, Copy, Default)]
struct BaudAttempt {
    /// The rate; `None` if the link has none, as over TCP.
    baud: Option<u32>,
    /// The time for discarding received bytes at first.
    settle: Duration,
}

/// The event that an attempt waits for; only the wait for the port has no timeout.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum AttemptStage {
    /// The port to switch to the baud rate.
    #[default]
    Switching,
    /// The end of the bytes that were sent at the former rate.
    Settling,
    /// A frame.
    Listening,
    /// The answer to the question, or a frame.
    Asking,
    /// A frame of a sensor, while another device sends.
    Doubting,
}

/// Tries baud rates in sequence until a valid frame arrives. At the first rate the scan waits for a
/// silent sensor, because it may be booting.
///
/// Bytes at a wrong rate come from a device that sends by itself. If no sensor was connected
/// before, that may be another device: then no further question is sent, and the scan listens at
/// each rate for a period of the slowest output. Every second scan sends the question nevertheless.
///
/// If a sensor is silent at its former rate, its adapter may be stalled: it delays all bytes,
/// including answers, and delivers them at once, perhaps while another rate is tried. So the first
/// valid frame after such a silence is discarded, and the former rate is tried next: only bytes
/// after a delayed burst show the baud rate.
#[derive(Default)]
pub(super) struct BaudScan {
    attempts: VecDeque<BaudAttempt>,
    attempt: BaudAttempt,
    stage: AttemptStage,
    until: Duration,
    listening_since: Duration,
    is_first: bool,
    is_found: bool,
    /// Whether bytes may be delayed by a stalled adapter.
    may_be_stalled: bool,
    began: Duration,
    attempt_began: Duration,
    tried: Vec<u32>,
    bytes: u64,
    /// Copies of the question among them.
    echoes: u64,
    /// Bytes that are neither from a sensor nor an echo, at the rates tried before.
    unframed: u64,
    /// Bytes that arrived long after the port was switched and without a question.
    unsolicited: u64,
}

impl BaudScan {
    /// Starts with the first of `bauds`, at which the port is opened.
    pub(super) fn start(bauds: Vec<Option<u32>>, context: &mut LinkContext, now: Duration) -> Self {
        let mut attempts = VecDeque::from_iter(bauds.iter().map(|&baud| BaudAttempt { baud, settle: Duration::ZERO }));
        let attempt = attempts.pop_front().unwrap_or_default();
        let mut scan = Self { attempts, attempt, is_first: true, began: now, ..Self::default() };
        scan.begin_attempt(context, now);
        scan
    }

    /// The baud rate of the sensor, when the sensor is found: `Some(None)` on a link without a baud
    /// rate. The frames of the sensor are then still pending.
    pub(super) fn found(&self) -> Option<Option<u32>> {
        self.is_found.then_some(self.attempt.baud)
    }

    /// Handles received bytes, all of them pending and this many of them new.
    pub(super) fn handle_received(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        bytes: usize,
    ) -> Result<(), LinkError> {
        let pending = &context.pending;
        if self.stage == AttemptStage::Listening && now >= self.listening_since + SETTLE {
            self.unsolicited += bytes as u64;
        }
        match self.stage {
            AttemptStage::Switching | AttemptStage::Settling => {}
            _ if pending.has_sensor() => return self.finish_attempt(context, now),
            AttemptStage::Listening | AttemptStage::Asking if !pending.other_sentences.is_empty() => {
                context.requests.handle_link_down();
                (self.stage, self.until) = (AttemptStage::Doubting, now + DOUBT + self.line_time());
            }
            // at the correct rate a frame is complete by now; earlier bytes may be stray
            AttemptStage::Listening if now >= self.attempt_began + SETTLE && self.only_listens(context) => {
                self.until = self.until.min(now + LISTEN + self.line_time());
            }
            AttemptStage::Listening | AttemptStage::Asking | AttemptStage::Doubting => {}
        }
        Ok(())
    }

    /// The port has been switched to the baud rate, or does not support it.
    pub(super) fn handle_baud_set(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        result: io::Result<()>,
    ) -> Result<(), LinkError> {
        if result.is_err() {
            self.bytes += context.discard_pending(now);
            return self.next_attempt(context, now);
        }
        (self.stage, self.until) = (AttemptStage::Settling, now + self.attempt.settle);
        self.handle_timeout(context, now)
    }

    pub(super) fn handle_timeout(&mut self, context: &mut LinkContext, now: Duration) -> Result<(), LinkError> {
        if now < self.until {
            return Ok(());
        }
        match self.stage {
            AttemptStage::Switching => {}
            AttemptStage::Settling => {
                self.bytes += context.discard_pending(now);
                self.begin_attempt(context, now);
            }
            AttemptStage::Listening if !self.only_listens(context) => {
                context.requests.submit_for_phase(QUESTION);
                context.requests.expect_spurious_errors();
                (self.stage, self.until) = (AttemptStage::Asking, now + ANSWER + self.line_time());
            }
            AttemptStage::Listening | AttemptStage::Asking => return self.finish_attempt(context, now),
            AttemptStage::Doubting => {
                let (port, baud) = (context.given_name.clone(), self.attempt.baud);
                return Err(LinkError::OtherDevice { port, baud, sentences: context.pending.other_sentences.clone() });
            }
        }
        Ok(())
    }

    pub(super) fn poll_timeout(&self) -> Option<Duration> {
        (self.stage != AttemptStage::Switching).then_some(self.until)
    }

    fn begin_attempt(&mut self, context: &mut LinkContext, now: Duration) {
        let baud = self.attempt.baud;
        self.attempt_began = now;
        self.tried.extend(baud.filter(|baud| !self.tried.contains(baud)));
        context.publish(LinkState::Probing { port: context.port.name.clone(), baud });
        let time = if self.only_listens(context) { LISTEN_ONLY + self.line_time() } else { LISTEN };
        self.listen(now, now + time);
    }

    fn listen(&mut self, now: Duration, until: Duration) {
        (self.stage, self.until, self.listening_since) = (AttemptStage::Listening, until, now);
    }

    /// Whether no question is sent at this rate.
    fn only_listens(&self, context: &LinkContext) -> bool {
        let pending = &context.pending;
        let unframed = self.unframed + without_echoes(pending.bytes(), pending.echoes);
        let sends_by_itself = unframed > STRAY_BYTES || self.unsolicited > GLITCH_BYTES;
        let may_be_other = sends_by_itself && !context.was_connected && !context.attempts.is_multiple_of(2);
        context.options.listen_only || may_be_other
    }

    /// The transmission time of the bytes before the answer, and of the answer.
    fn line_time(&self) -> Duration {
        // ten bits per byte
        self.attempt.baud.map_or(NETWORK, |baud| Duration::from_secs(10) * BYTES_BEFORE_ANSWER / baud.max(1))
    }

    fn finish_attempt(&mut self, context: &mut LinkContext, now: Duration) -> Result<(), LinkError> {
        // a late answer to this question must not count as an answer to a later question
        context.requests.handle_link_down();
        let (is_found, echoes) = (context.pending.has_sensor(), context.pending.echoes);
        let before = context.pending.take_before_sensor();
        let bytes = context.discard(now, before);
        (self.bytes, self.echoes) = (self.bytes + bytes, self.echoes + echoes);
        if !is_found {
            self.unframed += without_echoes(bytes, echoes);
        }
        if is_found {
            if !self.may_be_stalled {
                self.is_found = true;
                return Ok(());
            }
            self.bytes += context.discard_pending(now);
            self.may_be_stalled = false;
            if !self.is_first {
                self.attempts.push_front(self.attempt);
            }
            self.attempts.push_front(BaudAttempt { baud: context.last_baud, settle: SETTLE });
        } else if self.is_first && without_echoes(bytes, echoes) <= STRAY_BYTES {
            self.may_be_stalled |= context.last_baud.is_some();
            let booted = self.began + BOOT;
            if now < booted {
                // a frame of a sensor that sends one per second arrives before the next question
                let until = now + LISTEN_ONLY + self.line_time();
                let until = match context.was_connected {
                    _ if self.only_listens(context) => until,
                    true => now + LISTEN,
                    false => until.min(booted),
                };
                self.listen(now, until);
                return Ok(());
            }
        }
        self.next_attempt(context, now)
    }

    fn next_attempt(&mut self, context: &mut LinkContext, now: Duration) -> Result<(), LinkError> {
        self.is_first = false;
        let Some(attempt) = self.attempts.pop_front() else {
            return Err(LinkError::NoSensor {
                port: context.given_name.clone(),
                tried: std::mem::take(&mut self.tried),
                bytes: self.bytes,
                echoes: self.echoes,
                asked: !context.options.listen_only,
            });
        };
        self.attempt = attempt;
        match attempt.baud {
            Some(baud) => {
                self.stage = AttemptStage::Switching;
                context.port_actions.push_back(PortAction::SetBaud(baud));
            }
            None => self.begin_attempt(context, now),
        }
        Ok(())
    }
}
