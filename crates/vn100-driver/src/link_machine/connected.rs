//! A connected link: its frames are forwarded, and silences, restarts and garbled bytes are detected.

use std::{mem, time::Duration};

use vn100_protocol::stream::{LinkEventKind, StreamInput};
use vn100_protocol::{Frame, Register, Reply};

use super::{
    PortAction,
    link_context::{FIRST_DELAY, FrameCounts, FrameScanner, LinkContext, nanoseconds},
    requests::RequestEvent,
};
use crate::{
    link::{LinkState, Up},
    link_error::LinkError,
};

/// The interval at which a silent sensor is asked again, or after which the link is given up if no
/// question may be sent.
const SILENCE_CHECK: Duration = Duration::from_secs(10);

/// The shortest silence after which a sensor that does not answer counts as lost: a machine or an
/// adapter that stalls for two seconds then delivers all bytes received meanwhile, including the
/// answer.
const LONGEST_STALL: Duration = Duration::from_millis(2500);

pub(super) struct Connected {
    pub(super) up: Up,
    health: StreamHealth,
    /// The time of the last output of the sensor, or of the last damaged frame that may be output.
    last_output: Duration,
    silence: Option<Silence>,
    /// Whether the sensor has reported a restart, and has sent no output since.
    pub(super) is_restarting: bool,
}

struct Silence {
    since: Duration,
    last_check: Duration,
    scanner: FrameScanner,
}

impl Silence {
    /// Whether this input contains output of the sensor; neither replies nor garbled bytes end a
    /// silence.
    fn is_ended_by(&mut self, input: &StreamInput) -> bool {
        let StreamInput::Chunk(chunk) = input else { return false };
        let mut is_ended = false;
        self.scanner.scan(&chunk.bytes, |frame| {
            is_ended |= match frame {
                Frame::Sentence(sentence) => Reply::parse(&sentence).is_none(),
                Frame::Packet(_) => true,
                Frame::Rejected(_) => false,
            };
        });
        is_ended
    }
}

impl Connected {
    /// The state of a link whose sensor is connected at this baud rate.
    pub(super) fn new(context: &mut LinkContext, now: Duration, baud: Option<u32>) -> Self {
        context.last_baud = baud;
        (context.was_connected, context.attempts) = (true, 0);
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

    /// Forwards the inputs that were pending while the sensor was verified. Their replies are
    /// handled if `is_open` holds for them: the others answered the baud scan and the verification.
    pub(super) fn forward_pending(
        &mut self,
        context: &mut LinkContext,
        now: Duration,
        is_open: fn(&Reply) -> bool,
    ) -> Result<(), LinkError> {
        while let Some(input) = context.pending.inputs.pop_front() {
            self.forward(context, now, input, is_open)?;
        }
        // the frames of the measurement begin a new stream
        context.pending.take_all();
        Ok(())
    }

    /// Handles an input: forwards it, unless the sensor must be verified first, because it sends
    /// again after a silence. In that case it returns the input.
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

    /// Checks whether the output is silent, and whether the open commands have timed out.
    pub(super) fn handle_timeout(&mut self, context: &mut LinkContext, now: Duration) -> Result<(), LinkError> {
        if now >= self.next_silence_check() {
            if context.options.listen_only && self.silence.is_some() {
                return Err(LinkError::NoAnswer);
            }
            if !context.options.listen_only {
                context.requests.ask_presence(self.last_output, now);
            }
            let begin = || Silence { since: now, last_check: now, scanner: FrameScanner::new(context.pending.options) };
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

    /// The port was set to the baud rate to which the sensor has changed.
    pub(super) fn handle_baud_set(&mut self, context: &mut LinkContext, baud: u32) {
        self.up.baud = Some(baud);
        context.last_baud = Some(baud);
        context.options.baud = context.options.baud.map(|_| baud);
        context.publish(LinkState::Up(self.up.clone()));
    }

    /// The time when the output will count as silent, or, if it is silent, the time of the next check.
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

    /// Forwards an input, judges the link by it, and handles its replies for which `is_open` holds,
    /// because the others are handled already.
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
            if self.health.handle_read(at_ns, length, counts)? {
                context.reconnect_delay = FIRST_DELAY;
            }
        }
        let has_output = counts.output > before.output;
        // neither a reply nor a part of one is output; a damaged frame may be, but ends no silence
        if has_output || self.silence.is_none() && counts.damaged_bytes > before.damaged_bytes {
            self.last_output = now;
            if self.silence.take().is_some() {
                context.publish(LinkState::Up(self.up.clone()));
                // the sensor may have lost its power
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
            while let Some(event) = context.requests.poll_event() {
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
            RequestEvent::Restarted(error) if !context.options.desired_settings.is_empty() => {
                return Err(LinkError::Restarted(error));
            }
            RequestEvent::Restarted(error) => {
                context.emit(now, LinkEventKind::Down { cause: error.to_string() });
                self.up.since_ns = nanoseconds(now);
                self.up.restarted = Some(error);
                context.publish(LinkState::Up(self.up.clone()));
                // the sensor boots and does not answer; with its next frame it is connected again
                self.is_restarting = true;
            }
            RequestEvent::BaudChanged(_) | RequestEvent::PhaseAnswered(_) => {}
        }
        Ok(())
    }
}

/// Bytes that arrive for this long without a valid frame are garbled: the baud rate is wrong, or
/// the receiver of the host flips bits until the port is opened again.
const GARBLED_AFTER: Duration = Duration::from_millis(300);

/// Fewer bytes than this may be single damaged frames: the length of four usual frames.
const GARBLED_BYTES: u64 = 512;

/// A stream counts as silent after this many of its own periods, but not before the usual pauses of
/// an adapter and of a busy machine.
const SILENT_PERIODS: u32 = 5;
const SILENT_AT_LEAST: Duration = Duration::from_millis(250);

/// The timeout of a stream with an unknown period: three periods of the slowest output.
const SILENT_UNKNOWN: Duration = Duration::from_secs(3);

/// A server that collects lines sends them in bursts: the longest recent pause between two bursts
/// is no silence, and the next pause may be twice as long. A pause above this limit may be a
/// restart.
const LONGEST_PAUSE_S: f64 = 1.2;
const SILENT_PAUSES: f64 = 2.0;

/// Time constant with which the longest pause decays if no longer one occurs.
const PAUSE_MEMORY_S: f64 = 4.0;

/// Weight of a new period in the estimate: a read may contain one frame more or fewer.
const PERIOD_SMOOTHING: f64 = 1.0 / 8.0;

#[derive(Debug, Clone)]
struct StreamHealth {
    counts: FrameCounts,
    /// The arrival time of the first byte after the last valid frame; `None` right after a valid frame.
    bad_since_ns: Option<i64>,
    bad_bytes: u64,
    last_output_ns: Option<i64>,
    period_s: Option<f64>,
    /// The longest recent pause between two reads, in seconds.
    pause_s: f64,
}

impl StreamHealth {
    /// The state at the start of a connection; `counts` are those of earlier connections.
    fn new(counts: FrameCounts) -> Self {
        Self { counts, bad_since_ns: None, bad_bytes: 0, last_output_ns: None, period_s: None, pause_s: 0.0 }
    }

    /// Judges a read by its time, its length and the number of frames up to its end. Returns
    /// whether it contained a valid frame. If it did not, a single damaged or incomplete frame is
    /// assumed, until the time without a valid frame is too long.
    fn handle_read(&mut self, at_ns: i64, length: usize, counts: FrameCounts) -> Result<bool, LinkError> {
        let before = mem::replace(&mut self.counts, counts);
        if counts.output > before.output {
            self.update_period(at_ns, counts.output - before.output);
        }
        if counts.good > before.good {
            (self.bad_since_ns, self.bad_bytes) = (None, 0);
            return Ok(true);
        }
        let since_ns = *self.bad_since_ns.get_or_insert(at_ns);
        self.bad_bytes += length as u64;
        let lasted = duration_ns(at_ns, since_ns);
        if self.bad_bytes >= GARBLED_BYTES && lasted >= GARBLED_AFTER {
            return Err(LinkError::Garbled { bytes: self.bad_bytes, ms: lasted.as_millis() });
        }
        Ok(false)
    }

    /// The time after its last frame when the output counts as silent.
    fn silence_timeout(&self) -> Duration {
        let Some(period_s) = self.period_s else { return SILENT_UNKNOWN };
        let periods = Duration::from_secs_f64(period_s).saturating_mul(SILENT_PERIODS);
        let pauses = Duration::from_secs_f64(self.pause_s * SILENT_PAUSES);
        periods.max(pauses).clamp(SILENT_AT_LEAST, SILENT_UNKNOWN * 2)
    }

    fn update_period(&mut self, at_ns: i64, frames: u64) {
        if let Some(last_ns) = self.last_output_ns.replace(at_ns) {
            let pause_s = duration_ns(at_ns, last_ns).as_secs_f64();
            self.pause_s *= (-pause_s / PAUSE_MEMORY_S).exp();
            if pause_s <= LONGEST_PAUSE_S {
                self.pause_s = self.pause_s.max(pause_s);
            }
            let seen_s = pause_s / frames as f64;
            let before_s = self.period_s.unwrap_or(seen_s);
            self.period_s = Some(before_s + (seen_s - before_s) * PERIOD_SMOOTHING);
        }
    }
}

fn duration_ns(later_ns: i64, earlier_ns: i64) -> Duration {
    Duration::from_nanos(later_ns.saturating_sub(earlier_ns).try_into().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn lines(count: u64) -> FrameCounts {
        FrameCounts { good: count, output: count, damaged_bytes: 0 }
    }

    #[test]
    fn a_garbled_stream_is_detected_within_a_third_of_a_second() {
        let mut health = StreamHealth::new(lines(7));
        assert!(health.handle_read(0, 122, lines(8)).unwrap());
        let reads = (1..).map(|line| (line * 25 * MS, health.handle_read(line * 25 * MS, 122, lines(8))));
        let (at_ns, reading) = { reads }.find(|(_, reading)| !matches!(reading, Ok(false))).unwrap();
        // 0.3 s after the first bad byte
        assert_eq!(at_ns, 325 * MS);
        let Err(LinkError::Garbled { bytes, ms }) = reading else { panic!("{reading:?}") };
        assert_eq!((bytes, ms), (13 * 122, 300));
    }

    #[test]
    fn a_damaged_frame_of_a_slow_stream_is_not_a_garbled_stream() {
        let mut health = StreamHealth::new(FrameCounts::default());
        let mut good = 0;
        // lines at one per second in two reads each, one of three damaged
        for line in 0..30 {
            let at_ns = line * 1000 * MS;
            assert!(!health.handle_read(at_ns, 62, lines(good)).unwrap());
            good += u64::from(line % 3 > 0);
            let whole = health.handle_read(at_ns + 6 * MS, 60, lines(good));
            assert_eq!(whole.unwrap(), line % 3 > 0);
        }
    }

    #[test]
    fn the_silence_timeout_is_a_few_periods() {
        let mut health = StreamHealth::new(FrameCounts::default());
        assert_eq!(health.silence_timeout(), SILENT_UNKNOWN);
        (0..100).for_each(|line| _ = health.handle_read(line * 200 * MS, 122, lines(line as u64 + 1)));
        assert_eq!(health.silence_timeout(), Duration::from_secs(1));
        // eight lines per read, 200 Hz
        let mut health = StreamHealth::new(FrameCounts::default());
        (0..100).for_each(|read| _ = health.handle_read(read * 40 * MS, 976, lines(8 * (read as u64 + 1))));
        assert_eq!(health.silence_timeout(), SILENT_AT_LEAST);
    }

    #[test]
    fn a_pause_between_bursts_is_no_silence_until_it_does_not_return() {
        for pause_ms in [400, 1000] {
            let mut health = StreamHealth::new(FrameCounts::default());
            let (mut at_ns, mut count) = (0, 0);
            let mut read = |health: &mut StreamHealth, after_ms: i64, frames: u64| {
                (at_ns, count) = (at_ns + after_ms * MS, count + frames);
                health.handle_read(at_ns, 122, lines(count)).unwrap();
                health.silence_timeout()
            };
            let pause = Duration::from_millis(pause_ms);
            read(&mut health, 0, 16);
            read(&mut health, pause_ms as i64, 16);
            for _ in 0..100 {
                // a burst in two reads
                assert!(read(&mut health, pause_ms as i64 - 2, 8) > pause);
                assert!(read(&mut health, 2, 8) > pause);
            }
            assert!(health.silence_timeout() <= pause * 2);
            // a gap that may be a restart is no pause
            read(&mut health, 1300, 1);
            let timeouts: Vec<_> = (0..400).map(|_| read(&mut health, 25, 1)).collect();
            assert!(timeouts[0] < Duration::from_millis(2600));
            assert_eq!(timeouts.last(), Some(&SILENT_AT_LEAST));
        }
    }

    #[test]
    fn replies_do_not_change_the_period() {
        let mut health = StreamHealth::new(FrameCounts::default());
        for answer in 0..10 {
            assert!(
                health
                    .handle_read(
                        answer * 20 * MS,
                        20,
                        FrameCounts { good: answer as u64 + 1, ..FrameCounts::default() }
                    )
                    .unwrap()
            );
        }
        assert_eq!(health.silence_timeout(), SILENT_UNKNOWN);
    }
}
