//! Inputs that were received before it is known whether they are part of the measurement.

use std::collections::VecDeque;

use vn100_protocol::stream::{Chunk, StreamInput};
use vn100_protocol::{Frame, Framer, Options, Register, Reply};

/// Finds the frames in a stream of chunks; a frame may be spread over several of them.
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

/// The inputs in the order in which they were received, and what their frames say.
pub(super) struct PendingInputs {
    options: Options,
    inputs: VecDeque<StreamInput>,
    scanner: FrameScanner,
    /// Where the first frame of a sensor begins, in bytes from the first input.
    sensor_at: Option<u64>,
    /// Copies of the question of a baud scan that arrived before that: an echo is no sensor.
    echoes: u64,
}

impl PendingInputs {
    pub(super) fn new(options: Options) -> Self {
        Self { options, inputs: VecDeque::new(), scanner: FrameScanner::new(options), sensor_at: None, echoes: 0 }
    }

    /// Keeps an input, and gives the replies that it completes.
    pub(super) fn push(&mut self, input: StreamInput) -> Vec<Reply> {
        let mut replies = Vec::new();
        if let StreamInput::Chunk(chunk) = &input {
            self.scanner.scan(&chunk.bytes, |frame| {
                let (reply, offset) = match frame {
                    Frame::Sentence(sentence) if sentence.header().starts_with(b"VN") => {
                        (Reply::parse(&sentence).ok(), sentence.offset)
                    }
                    Frame::Packet(packet) => (None, packet.offset),
                    Frame::Sentence(_) | Frame::Rejected(_) => return,
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

    pub(super) fn has_sensor(&self) -> bool {
        self.sensor_at.is_some()
    }

    pub(super) fn echoes(&self) -> u64 {
        self.echoes
    }

    /// Takes the first input.
    pub(super) fn pop(&mut self) -> Option<StreamInput> {
        self.inputs.pop_front()
    }

    /// Takes all inputs; the next one is the first of another stream.
    pub(super) fn take_all(&mut self) -> VecDeque<StreamInput> {
        std::mem::replace(self, Self::new(self.options)).inputs
    }

    /// Takes what was received before the first frame of a sensor.
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
    fn an_echo_of_the_question_is_no_sensor_and_the_answer_behind_it_is() {
        let echo = "$VNRRG,01*72\r\n";
        let mut nothing = pending(&["$VNRRG,", "01*72\r\n", echo]);
        assert_eq!((nothing.has_sensor(), nothing.echoes()), (false, 2));
        assert_eq!(nothing.take_before_sensor().len(), 3);
        let answer = "$VNRRG,01,VN-100S-CR*35\r\n";
        let mut answered = pending(&[echo, answer, echo]);
        assert_eq!((answered.has_sensor(), answered.echoes()), (true, 1));
        assert_eq!(answered.take_before_sensor(), [chunk(echo)]);
        assert_eq!(answered.pop(), Some(chunk(answer)));
    }

    #[test]
    fn other_sentences_are_no_sensor() {
        // a satellite receiver on the same kind of adapter
        let pieces = ["$GPGLL,4916.45,N,12311.12,W,225444,A,*1D\r\n", "$VNYPR,+010.071,+000.278,-002.026*61\r\n"];
        assert!(!pending(&pieces).has_sensor());
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
