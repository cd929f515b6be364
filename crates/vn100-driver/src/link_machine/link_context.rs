//! The state shared by all phases of a link: the path of every input, and the facts about the sensor.

use std::{collections::VecDeque, mem, time::Duration};

use vn100_capture::Event as StreamEvent;
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, SampleReader, StreamInput};
use vn100_protocol::{Check, Frame, Framer, Options, Register, RegisterContents, Reply, Sentence};

use super::{LinkOutput, OpenPort, PortAction, requests::Requests};
use crate::{
    link::{LinkOptions, LinkState},
    link_error::LinkError,
    output_plan::Change,
};

/// The first and the longest delay before an attempt to reconnect.
pub(super) const FIRST_DELAY: Duration = Duration::from_millis(100);
const LONGEST_DELAY: Duration = Duration::from_secs(5);

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct FrameCounts {
    /// All frames with a correct checksum.
    pub(super) good: u64,
    /// Frames that are not replies: the output that the sensor sends by itself.
    pub(super) output: u64,
    /// Bytes without a valid frame, which may have been output or replies.
    pub(super) damaged_bytes: u64,
}

pub(super) struct LinkContext {
    /// The name of the port as given by the user.
    pub(super) given_name: String,
    pub(super) has_baud: bool,
    pub(super) options: LinkOptions,
    /// The baud rate at which the sensor was last connected, or to which it was set before the
    /// link.
    pub(super) last_baud: Option<u32>,
    pub(super) was_connected: bool,
    /// Another program that has the port open, if one was found.
    pub(super) port_shared_with: Option<String>,
    /// Attempts to open the port since the sensor was last connected.
    pub(super) attempts: u32,
    /// The delay before the next attempt to reconnect; it doubles until the link has carried a
    /// valid frame.
    pub(super) reconnect_delay: Duration,
    pub(super) port: OpenPort,
    pub(super) requests: Requests,
    /// Received inputs that are neither forwarded nor discarded yet.
    pub(super) pending: PendingInputs,
    pub(super) port_actions: VecDeque<PortAction>,
    pub(super) events: VecDeque<LinkOutput>,
    pub(super) reader: SampleReader,
    serial_number: Option<String>,
    /// A different serial number that the sensor has reported once.
    unconfirmed_serial: Option<String>,
}

/// The baud rate to which a sensor with these settings was set.
fn baud_set(settings: &[Change]) -> Option<u32> {
    let baud = settings.iter().find(|change| change.register == Register::BAUD_RATE)?;
    baud.after.as_str().split(',').next()?.parse().ok()
}

impl LinkContext {
    pub(super) fn new(given_name: String, has_baud: bool, mut options: LinkOptions) -> Self {
        let mut reader = SampleReader::new(options.read);
        reader.keep_replies();
        if options.listen_only {
            options.desired_settings.clear();
        }
        Self {
            given_name,
            has_baud,
            last_baud: baud_set(&options.desired_settings),
            was_connected: false,
            port_shared_with: None,
            attempts: 0,
            reconnect_delay: FIRST_DELAY,
            port: OpenPort::default(),
            requests: Requests::new(options.listen_only, options.poll_temperature),
            pending: PendingInputs::new(Options { accept_unchecked: options.read.accept_unchecked }),
            port_actions: VecDeque::new(),
            events: VecDeque::new(),
            reader,
            serial_number: options.known_serial.take(),
            unconfirmed_serial: None,
            options,
        }
    }

    /// The frames of all connections so far. A frame with a correct checksum shows that the link
    /// carries a sensor, even if its fields are malformed.
    pub(super) fn frame_counts(&self) -> FrameCounts {
        let tally = self.reader.tally();
        let output = tally.samples + tally.other + tally.packets + tally.rejected.grammar + tally.rejected.range;
        let damaged_bytes = tally.skipped_bytes + tally.rejected_sentence_bytes;
        FrameCounts { good: output + tally.replies, output, damaged_bytes }
    }

    /// The delay before the next attempt to reconnect; each delay is twice as long as the one
    /// before.
    pub(super) fn next_delay(&mut self) -> Duration {
        let doubled = (self.reconnect_delay * 2).min(LONGEST_DELAY);
        mem::replace(&mut self.reconnect_delay, doubled)
    }

    pub(super) fn publish(&mut self, state: LinkState) {
        self.events.push_back(LinkOutput::State(state));
    }

    pub(super) fn emit(&mut self, now: Duration, kind: LinkEventKind) {
        let at_ns = nanoseconds(now);
        _ = self.forward(StreamInput::Link(LinkEvent { at_ns, kind }));
    }

    /// Records, counts and decodes an input of the measurement. Returns the replies that the input
    /// completes.
    pub(super) fn forward(&mut self, input: StreamInput) -> Vec<Reply> {
        // the clone shares the bytes
        self.events.push_back(LinkOutput::Recorded(input.clone()));
        self.events.extend(StreamEvent::from_input(&mut self.reader, input).map(LinkOutput::Stream));
        self.reader.take_replies()
    }

    /// Discards pending inputs; their bytes are counted and recorded as discarded. Returns their
    /// number.
    pub(super) fn discard_pending(&mut self, now: Duration) -> u64 {
        let inputs = self.pending.take_all();
        self.discard(now, inputs)
    }

    pub(super) fn discard(&mut self, now: Duration, inputs: VecDeque<StreamInput>) -> u64 {
        let mut bytes = 0;
        for input in inputs {
            match input {
                StreamInput::Chunk(chunk) => bytes += chunk.bytes.len() as u64,
                StreamInput::Link(event) => self.emit(now, event.kind),
            }
        }
        if bytes > 0 {
            self.emit(now, LinkEventKind::DiscardedDuringBaudScan { bytes });
        }
        bytes
    }

    /// Keeps an input pending until the verification has ended, and handles its replies. Unsolicited
    /// errors are handled with the measurement.
    pub(super) fn keep_pending(&mut self, now: Duration, input: StreamInput) -> Result<(), LinkError> {
        for reply in self.pending.push(input).iter().filter(|reply| !is_unsolicited_error(reply)) {
            let identified = self.check_serial_number(reply);
            self.requests.handle_reply(reply, now);
            identified?;
        }
        Ok(())
    }

    /// The serial number to verify; `None` if it is not known or must not be read.
    pub(super) fn serial_to_verify(&self) -> Option<&str> {
        // a link that only listens may have received the answer to another program
        self.serial_number.as_deref().filter(|_| !self.options.listen_only)
    }

    /// Compares a reply with the known serial number. Returns whether the number must be read
    /// again: one reply in a few million is damaged in spite of a correct checksum, but not two in
    /// the same way.
    pub(super) fn check_serial_number(&mut self, reply: &Reply) -> Result<bool, LinkError> {
        let Reply::Register(RegisterContents { register: Register::SERIAL_NUMBER, fields, .. }) = reply else {
            return Ok(false);
        };
        let serial = fields.to_string();
        match &self.serial_number {
            None => self.serial_number = Some(serial),
            Some(known) if *known == serial => self.unconfirmed_serial = None,
            Some(known) if self.unconfirmed_serial.as_ref() == Some(&serial) => {
                return Err(LinkError::OtherSensor { serial, known: known.clone() });
            }
            Some(_) => self.unconfirmed_serial = Some(serial),
        }
        Ok(self.unconfirmed_serial.is_some())
    }
}

pub(super) fn is_unsolicited_error(reply: &Reply) -> bool {
    matches!(reply, Reply::Error(error) if error.is_unsolicited())
}

/// A time in the form of the stamps of the stream.
pub(super) fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

/// Finds the frames in a stream of chunks; a frame may span several of them.
pub(super) struct FrameScanner {
    framer: Framer,
    incomplete: Vec<u8>,
}

impl FrameScanner {
    pub(super) fn new(options: Options) -> Self {
        Self { framer: Framer::new(options), incomplete: Vec::new() }
    }

    /// Calls `handle` with each frame that these bytes complete.
    pub(super) fn scan(&mut self, bytes: &[u8], mut handle: impl FnMut(Frame<'_>)) {
        self.incomplete.extend_from_slice(bytes);
        let mut at = 0;
        loop {
            let (consumed, frame) = self.framer.next(&self.incomplete[at..], false);
            at += consumed;
            match frame {
                Some(frame) => handle(frame),
                None => break,
            }
        }
        self.incomplete.drain(..at);
    }
}

/// The number of sentences of another device that are named.
const NAMED_SENTENCES: usize = 3;

/// The name of a sentence of another device: one with a checksum and a name of capital letters and
/// digits, which does not result from damaged bytes.
fn name_of_other(sentence: &Sentence<'_>) -> Option<String> {
    let name = sentence.header();
    let is_name = (3..=8).contains(&name.len()) && name.iter().all(|b| matches!(b, b'A'..=b'Z' | b'0'..=b'9'));
    (is_name && sentence.check != Check::None).then(|| String::from_utf8_lossy(name).into_owned())
}

/// The inputs in the order of their arrival, and the meaning of their frames.
pub(super) struct PendingInputs {
    pub(super) options: Options,
    pub(super) inputs: VecDeque<StreamInput>,
    scanner: FrameScanner,
    /// The start of the first frame of a sensor, in bytes from the first input.
    sensor_at: Option<u64>,
    /// Copies of the question of a baud scan that arrived before that frame: an echo is no sensor.
    pub(super) echoes: u64,
    /// The names of the first few sentences of another device.
    pub(super) other_sentences: Vec<String>,
}

impl PendingInputs {
    pub(super) fn new(options: Options) -> Self {
        Self {
            options,
            inputs: VecDeque::new(),
            scanner: FrameScanner::new(options),
            sensor_at: None,
            echoes: 0,
            other_sentences: Vec::new(),
        }
    }

    /// Keeps an input, and returns the replies that it completes.
    pub(super) fn push(&mut self, input: StreamInput) -> Vec<Reply> {
        let mut replies = Vec::new();
        if let StreamInput::Chunk(chunk) = &input {
            self.scanner.scan(&chunk.bytes, |frame| {
                let (reply, offset) = match frame {
                    Frame::Sentence(sentence) if sentence.header().starts_with(b"VN") => {
                        (Reply::parse(&sentence), sentence.offset)
                    }
                    Frame::Packet(packet) => (None, packet.offset),
                    Frame::Sentence(sentence) => {
                        let name = name_of_other(&sentence).filter(|name| !self.other_sentences.contains(name));
                        self.other_sentences.extend(name);
                        return self.other_sentences.truncate(NAMED_SENTENCES);
                    }
                    Frame::Rejected(_) => return,
                };
                if reply == Some(Reply::Question(Register::MODEL)) {
                    self.echoes += u64::from(self.sensor_at.is_none());
                } else {
                    self.sensor_at.get_or_insert(offset);
                }
                replies.extend(reply);
            });
        }
        self.inputs.push_back(input);
        replies
    }

    pub(super) fn bytes(&self) -> u64 {
        let length = |input: &StreamInput| match input {
            StreamInput::Chunk(chunk) => chunk.bytes.len() as u64,
            StreamInput::Link(_) => 0,
        };
        self.inputs.iter().map(length).sum()
    }

    pub(super) fn has_sensor(&self) -> bool {
        self.sensor_at.is_some()
    }

    /// Takes all inputs; the next one is the first of another stream.
    pub(super) fn take_all(&mut self) -> VecDeque<StreamInput> {
        mem::replace(self, Self::new(self.options)).inputs
    }

    pub(super) fn take_before_sensor(&mut self) -> VecDeque<StreamInput> {
        let Some(offset) = self.sensor_at else { return self.take_all() };
        let mut left = usize::try_from(offset).unwrap_or(usize::MAX);
        let mut before = VecDeque::new();
        while left > 0
            && let Some(input) = self.inputs.pop_front()
        {
            let StreamInput::Chunk(Chunk { mut bytes, at_ns }) = input else {
                before.push_back(input);
                continue;
            };
            let head = bytes.split_to(left.min(bytes.len()));
            left -= head.len();
            before.push_back(Chunk { bytes: head, at_ns }.into());
            if !bytes.is_empty() {
                self.inputs.push_front(Chunk { bytes, at_ns }.into());
            }
        }
        self.sensor_at = Some(0);
        before
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;

    fn chunk(text: &'static str) -> StreamInput {
        Chunk { bytes: Bytes::from_static(text.as_bytes()), at_ns: None }.into()
    }

    fn pending(pieces: &[&'static str]) -> PendingInputs {
        let mut pending = PendingInputs::new(Options::default());
        pieces.iter().for_each(|piece| _ = pending.push(chunk(piece)));
        pending
    }

    #[test]
    fn the_stream_begins_with_the_first_good_frame() {
        let mut pending = pending(&["\u{7f}junk*00\r\n$VN", "YMR,-0$VNRRG,01,VN", "-100S-CR*35\r\n"]);
        assert_eq!(pending.take_before_sensor(), [chunk("\u{7f}junk*00\r\n$VN"), chunk("YMR,-0")]);
        assert_eq!(pending.take_before_sensor(), [], "it begins at once now");
        assert_eq!(pending.take_all(), [chunk("$VNRRG,01,VN"), chunk("-100S-CR*35\r\n")]);
        assert!(!pending.has_sensor());
        assert_eq!(pending.take_all(), []);
    }

    #[test]
    fn an_echo_of_the_question_is_no_sensor_but_the_answer_after_it_is() {
        let echo = "$VNRRG,01*72\r\n";
        let mut nothing = pending(&["$VNRRG,", "01*72\r\n", echo]);
        assert_eq!((nothing.has_sensor(), nothing.echoes), (false, 2));
        assert_eq!(nothing.take_before_sensor().len(), 3);
        let answer = "$VNRRG,01,VN-100S-CR*35\r\n";
        let mut answered = pending(&[echo, answer, echo]);
        assert_eq!((answered.has_sensor(), answered.echoes), (true, 1));
        assert_eq!(answered.take_before_sensor(), [chunk(echo)]);
        assert_eq!(answered.inputs.pop_front(), Some(chunk(answer)));
    }

    #[test]
    fn other_sentences_are_no_sensor() {
        // a satellite receiver on the same kind of adapter
        let gpgll = "$GPGLL,4916.45,N,12311.12,W,225444,A,*1D\r\n";
        let receiver = pending(&[gpgll, "$VNYPR,+010.071,+000.278,-002.026*61\r\n", gpgll, "$*00\r\n$a,b*4F\r\n"]);
        assert!(!receiver.has_sensor());
        assert_eq!(receiver.other_sentences, ["GPGLL"]);
        assert!(pending(&["$VNYPR,-129.867,-000.355,-000.296*61\r\n"]).has_sensor());
    }

    #[test]
    fn replies_are_found_however_they_are_cut() {
        let text = "$VNRRG,01,VN-100S-CR*35\r\n$VNYMR,junk$VNRRG,01*72\r\n";
        let whole = PendingInputs::new(Options::default()).push(chunk(text));
        for at in 1..text.len() {
            let mut pending = PendingInputs::new(Options::default());
            let mut replies = pending.push(chunk(&text[..at]));
            replies.extend(pending.push(chunk(&text[at..])));
            assert_eq!(replies, whole);
        }
        assert_eq!(whole.len(), 2);
    }
}
